"""A staged message becomes a program that is ready to run beside the running one."""

from __future__ import annotations

import hashlib
from pathlib import Path

from ldc.diagnostics import Invalid
from ldc.il import block
from ldc.il import image as il_image
from runtime.machine import Machine
from runtime.native.library import Code
from runtime.native.machine import Machine as Native
from runtime.online import findings
from runtime.online.controller import Loaded
from runtime.online.wire import Stage
from runtime.vm.machine import Machine as Virtual


def engine_of(machine: Machine) -> str:
    """vm or native."""
    return "native" if isinstance(machine, Native) else "vm"


def areas_of(machine: Machine) -> dict[str, int]:
    """Bytes of I, Q and M in native memory; nothing for the virtual machine."""
    return dict(machine.plan.areas) if isinstance(machine, Native) else {}


def load(message: Stage, running: Machine, folder: Path) -> Loaded:
    """A machine for what was sent, of the engine, resource and base tick of the running one. ``folder``:
    for its shared object. Raises Invalid (LD0826) for whatever cannot be loaded: it comes from outside."""
    try:
        image = il_image.load(message.image)
        if running.resource >= len(image.program.resources):
            raise findings.refused(findings.unusable("it has no program for the processor that runs"))
        if any(unit.external is not None for unit in image.program.units):
            raise findings.refused(findings.unusable(
                "it calls components in C or C++, which are bound at a start"))
        machine = _machine(message, image, running, folder)
    except Invalid:
        raise
    except Exception as error:  # the bytes can be anything, and the running program must go on
        raise findings.refused(findings.unusable(f"{type(error).__name__}: {error}"[:300])) from error
    return Loaded(machine, message.image, image.digest, tuple(message.sources))


def _machine(message: Stage, image: il_image.Image, running: Machine, folder: Path) -> Machine:
    program, number, period = image.program, running.resource, running.period_ns
    if not isinstance(running, Native):
        return Virtual(program, number, period)
    if message.library is None:
        raise findings.refused(findings.unusable("it has no native code, and the runtime runs nothing else"))
    # A name of its own for every content: a loader that knows a path does not look at it again.
    path = folder / f"program-{hashlib.sha256(message.library).hexdigest()[:24]}.so"
    path.write_bytes(message.library)
    try:
        memory = block.make(program, image.layout, number, message.areas)
        parts = tuple((name, tuple(firsts)) for name, firsts in message.parts)
        return Native(program, number, period, native=Code(path, memory, parts))
    finally:
        path.unlink()
