"""`ldc build` for a microcontroller: an image, what is where in it, and how much room it takes."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from ldc.backends.firmware.report import sizes
from ldc.backends.firmware.tools import Firmware, address_of
from ldc.cli import firmware
from ldc.cli.build_folder import before, places, write_sources
from ldc.cli.compiling import compiled
from ldc.cli.console import OK, UsageError, say
from ldc.cli.inputs import read
from ldc.cli.output import write_file
from ldc.cli.starting import resource_to_run
from ldc.il.block import Block
from ldc.manifest import Sources
from ldc.render import plural

IMAGE, ABOUT = "program.img", "firmware.json"


def run(options: argparse.Namespace) -> int:
    """Writes .elf, .bin and .map, the sources, the description of the memory, and the image that the next
    build keeps the places of variables from; the sizes go to standard output."""
    if options.sanitize:
        raise UsageError("--sanitize is for --target host: firmware has nobody to tell")
    board, room = firmware.chosen(options.target, options.board)
    folder = Path(options.folder)
    layout, areas = before(folder, IMAGE, ABOUT)
    sources = read(options.sources)
    result = compiled(sources, previous=layout, called_on=options.target)
    machine = firmware.machine(result, resource_to_run(result), None, sources.manifest, areas)
    plan = firmware.planned(machine, result, board, room)
    name = file_name(sources)
    made = firmware.built(plan, folder, name)
    for image in plan.images:
        place = folder if image.processor == "master" else folder / image.processor
        texts = image.headers | {file.name: file.text for file in image.files}
        write_sources(texts | {part.file: part.text for part in image.parts}, place / "c")
    write_file(folder / IMAGE, result.image.data)
    write_file(folder / ABOUT, json.dumps(about(made, machine.period_ns), indent=1).encode() + b"\n")
    print("\n\n".join(table(made, number) for number in range(len(made.images))))
    count = plural(made.compiled, "file")
    what = " and ".join(str(image.elf) for image in made.images)
    say(f"built {what} for {board.name} ({count} compiled, {made.files - made.compiled} unchanged)")
    return OK


def file_name(sources: Sources) -> str:
    """What the image is called: as the project, or as the first source."""
    name = sources.manifest.name if sources.manifest else Path(sources.files[0].path).stem
    return re.sub(r"[^A-Za-z0-9._-]", "_", name).lstrip(".") or "firmware"


def about(made: Firmware, period: int) -> dict[str, object]:
    """The map of the image: what a tool needs to read and write variables in the memory of the processor."""
    block: Block = made.plan.code.block
    begin = address_of(made.images[0].elf, "ldc_block")
    part = block.program.resources[block.resource]
    return {
        "abi": 1, "target": made.plan.board.target, "board": made.plan.board.name,
        "image": made.images[0].elf.name, "digest": made.plan.digest,
        "block": {"address": begin, "size": block.size}, "areas": dict(block.areas),
        "period_ns": period, "programs": [run.name for run in part.runs],
        "tasks": [{"name": t.name, "interval_ns": t.interval, "priority": t.priority} for t in part.tasks],
        "variables": {path: {**place, "address": begin + place["offset"]} for path, place in places(block)},
    }


def table(made: Firmware, number: int) -> str:
    """The sizes of an image as text; rows add up to the totals."""
    image, size = made.images[number].image, sizes(made, number)
    head = "" if len(made.images) == 1 else image.processor
    lines = [f"{head:<34}{'flash':>10}{'RAM':>10}"]
    lines += [f"{name[:33]:<34}{row.flash:>10,}{row.ram:>10,}" for name, row in size.rows.items()]
    lines += [f"{'total':<34}{size.flash:>10,}{size.ram:>10,}",
              f"{'of ' + made.plan.board.name:<34}{image.flash.size:>10,}{image.ram.size:>10,}"]
    return "\n".join(lines)
