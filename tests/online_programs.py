"""Programs for tests of online change, ready to run on either engine."""

from __future__ import annotations

import tempfile
from pathlib import Path

import native
from ldc import pipeline
from ldc.backends.c import emit, gcc
from ldc.diagnostics import Diagnostics
from ldc.il import block, image
from runtime.native.library import Code
from runtime.native.machine import Machine as Native
from runtime.online.controller import Loaded
from runtime.vm.machine import Machine as Virtual


def compiled(text: str, previous: Loaded | None = None) -> pipeline.Compiled:
    """The text compiled for a program that runs."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "main.ld")
        path.write_text(text, encoding="utf-8")
        layout = None if previous is None else image.load(previous.image).layout
        result = pipeline.compile_paths([str(path)], pipeline.Options(keep=False, previous=layout))
    assert result.image is not None, [d.message for d in result.diagnostics]
    return result


def loaded(text: str, engine: str = "vm", previous: Loaded | None = None) -> Loaded:
    """A program ready to run; ``previous``: the one that it shall take over from."""
    result = compiled(text, previous)
    period = previous.machine.period_ns if previous else None
    if engine == "vm":
        machine = Virtual(result.program, 0, period)
    else:
        areas = dict(previous.machine.plan.areas) if previous else None
        plan = emit.plan(block.make(result.program, result.image.layout, 0, areas), native.QUICK, ())
        made = gcc.build(plan, gcc.find_compiler(Diagnostics()))
        machine = Native(result.program, 0, period, native=Code(made.path, plan.block, plan.map))
    return Loaded(machine, result.image.data, result.image.digest, (("main.ld", text),))


