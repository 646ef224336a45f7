"""`ldc build`: code for a processor, as files that other programs load."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from ldc.backends.c.emit import HEADER, BuildPlan
from ldc.cli.build_folder import before, places, write_sources
from ldc.cli.compiling import compiled
from ldc.cli.console import OK, UsageError, say
from ldc.cli.inputs import read
from ldc.cli.native import artifact
from ldc.cli.output import write_file
from ldc.cli.starting import resource_to_run
from ldc.il.external import Binding
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
    write_sources({HEADER: made.plan.header} | {file.name: file.text for file in made.plan.files},
                  folder / "c")
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
