"""`ldc build`: code for a processor, as files that other programs load."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from ldc.backends.c.emit import HEADER, BuildPlan
from ldc.cli.compiling import compiled
from ldc.cli.console import OK, Failure, UsageError, say
from ldc.cli.inputs import read
from ldc.cli.native import artifact
from ldc.cli.output import write_file
from ldc.cli.run import resource_to_run
from ldc.il import image
from ldc.il.block import Block, Spot
from ldc.il.external import Binding
from ldc.il.homes import direct_addresses
from ldc.il.layout import state
from ldc.render import plural

IMAGE, ABOUT = "program.img", "native.json"


def run(options: argparse.Namespace) -> int:
    """Writes the shared object, its C, a description of its memory, and the image that the next build keeps
    the places of variables from."""
    if options.target != "host":
        from ldc.cli import build_firmware  # loads what only firmware needs

        return build_firmware.run(options)
    if options.board:
        raise UsageError("--board is for firmware: name its processor with --target, such as cortex-m3")
    folder = Path(options.folder)
    layout, areas = before(folder, IMAGE, ABOUT)
    result = compiled(read(options.sources), previous=layout, called_on="a host of its own")
    resource = resource_to_run(result)
    made = artifact(result, resource, folder, areas, options.sanitize)
    write_sources({HEADER: made.plan.header} | {file.name: file.text for file in made.plan.files}, folder / "c")
    for binding in made.plan.bindings:
        write_file(folder / _component(binding), binding.library.read_bytes())
    write_file(folder / IMAGE, result.image.data)
    write_file(folder / ABOUT, json.dumps(about(made.plan, made.path.name), indent=1).encode() + b"\n")
    for old in folder.glob("program-*.so"):
        if old != made.path:
            old.unlink(missing_ok=True)
    count = plural(len(made.compiled), "file")
    say(f"built {made.path} ({count} compiled, {len(made.plan.files) - len(made.compiled)} unchanged)")
    return OK


def before(folder: Path, image_name: str, about_name: str) -> tuple[image.Layout | None, dict[str, int]]:
    """Layout and areas of the build before in this folder; of one that cannot be read nothing is kept."""
    try:
        found = json.loads((folder / about_name).read_bytes())["areas"]
        layout = image.load((folder / image_name).read_bytes()).layout
        return layout, {area: size for area, size in found.items() if isinstance(size, int) and 0 < size <= 1 << 20}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None, {}


def about(plan: BuildPlan, library: str) -> dict[str, object]:
    """What a host needs to run the shared object (docs/native.md)."""
    block = plan.block
    part = block.program.resources[block.resource]
    return {
        "abi": 1, "library": library, "size": block.size, "digest": plan.digest, "areas": dict(block.areas),
        "programs": [run.name for run in part.runs],
        "tasks": [{"name": t.name, "interval_ns": t.interval, "priority": t.priority, "watchdog": t.watchdog,
                   "programs": [n for n, run in enumerate(part.runs) if run.task.upper() == t.name.upper()]}
                  for t in part.tasks],
        "components": [_component(binding) for binding in plan.bindings],
        "variables": dict(places(block)),
        "initial": bytes(block.initial()).hex(),
    }


def _component(binding: Binding) -> str:
    """The file of a component's library in the folder."""
    return f"component-{binding.unit.lower()}.so"


def places(block: Block) -> Iterable[tuple[str, dict[str, object]]]:
    """Path, type and place of every variable."""
    return ((path, _place(spot)) for path, spot in _variables(block))


def _variables(block: Block) -> Iterable[tuple[str, Spot]]:
    for variable in block.program.globals:
        yield variable.name, block.variable(variable.name, variable)
    for address in direct_addresses(block.units.values()):
        yield address, block.direct(address)
    for run in block.program.resources[block.resource].runs:
        for variable in state(block.units[run.pou.upper()]):
            path = f"{run.name}.{variable.name}"
            yield path, block.variable(path, variable)


def _place(spot: Spot) -> dict[str, object]:
    where: dict[str, object] = {"type": str(spot.type), "offset": spot.offset}
    return where if spot.bit is None else where | {"bit": spot.bit}


def write_sources(wanted: Mapping[str, str], folder: Path) -> None:
    """Files by name; other C in the folder is of an older build and goes. Raises Failure."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob("*.[ch]"):
            if old.name not in wanted:
                old.unlink()
    except OSError as error:
        raise Failure(f"cannot write `{folder}`: {error.strerror}") from error
    for name, text in wanted.items():
        write_file(folder / name, text.encode())
