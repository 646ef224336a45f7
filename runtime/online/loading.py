"""A staged message becomes a program that is ready to run beside the running one."""

from __future__ import annotations

import gc
import hashlib
import json
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ldc import unfinished
from ldc.diagnostics import Invalid
from ldc.il import block
from ldc.il import image as il_image
from ldc.il.coordination import Coordination
from ldc.il.coordination_image import pack, unpack
from ldc.il.external import Binding, Shared
from ldc.il.program import Program
from runtime.machine import Machine
from runtime.native.library import Code
from runtime.native.machine import Machine as Native
from runtime.online import findings
from runtime.online.controller import Loaded
from runtime.online.wire import Part, Stage
from runtime.slave.algorithm import Maker, makers
from runtime.vm import beside, loader
from runtime.vm.loader import Code as VirtualCode
from runtime.vm.machine import Machine as Virtual

_WINDOW = 16 << 20
"""Bytes of globals that a component may see."""


class _Staged(Virtual):
    """A virtual machine that is made while another one scans."""

    __slots__ = ()

    def _code(self) -> VirtualCode:
        return loader.load(self.program, self.resource, self.bindings, compiled=beside.compiled)


@contextmanager
def undisturbed() -> Iterator[None]:
    """While a program is made: the collector of garbage would walk all of it again and again, and the scans
    would wait. What was made lives long, and is never walked."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        if collects:
            gc.enable()


def engine_of(machine: Machine) -> str:
    """vm or native."""
    return "native" if isinstance(machine, Native) else "vm"


def areas_of(machine: Machine) -> dict[str, int]:
    """Bytes of I, Q and M in native memory; nothing for the virtual machine."""
    return dict(machine.plan.areas) if isinstance(machine, Native) else {}


def load(message: Stage, running: Machine, folder: Path) -> Loaded:
    """A machine for what was sent, of the engine, resource and base tick of the running one. ``folder``:
    for its shared objects. Raises Invalid (LD0826) for whatever cannot be loaded: it comes from outside."""
    try:
        image = il_image.load(message.image)
        if running.resource >= len(image.program.resources):
            raise findings.refused(findings.unusable("it has no program for the processor that runs"))
        machine, algorithms = _machine(message, image, running, folder)
        together = Coordination()
        if message.together is not None:
            together = unpack(message.together, lambda path: machine.symbols.find(path).type)
        watch = None if message.watch is None else watched(machine, message.watch)
    except Invalid:
        raise
    except Exception as error:  # the bytes can be anything, and the running program must go on
        if isinstance(error, OSError) and error.errno is not None:  # not that of a library that cannot be loaded
            raise findings.refused(findings.no_room(folder, error)) from error
        raise findings.refused(findings.unusable(f"{type(error).__name__}: {error}"[:300])) from error
    return Loaded(machine, message.image, image.digest, tuple(message.sources), together, algorithms, watch,
                  settings_digest(together, watch))


def settings_digest(together: Coordination, watch: Iterable[tuple[str, str]] | None) -> str:
    """SHA-256 of how modules work together and what is shown: the digest of a program is of its code alone."""
    shown = None if watch is None else [path for _, path in watch]
    return hashlib.sha256(pack(together) + b"\0" + json.dumps(shown).encode()).hexdigest()


def watched(machine: Machine, names: Iterable[str]) -> tuple[tuple[str, str], ...]:
    """What a program shows, with full paths. Raises UnknownSymbol."""
    full = machine.symbols.full
    return tuple((name, full(machine.symbols.find(name))) for name in names)


def _machine(message: Stage, image: il_image.Image, running: Machine, folder: Path
             ) -> tuple[Machine, dict[str, Maker]]:
    program, number, period = image.program, running.resource, running.period_ns
    with ExitStack() as files:
        bindings = _bindings(message, program, folder, files)
        algorithms = makers(program, bindings)
        if not isinstance(running, Native):
            return _Staged(program, number, period, bindings), algorithms
        if message.library is None:
            raise findings.refused(findings.unusable(
                "it has no native code, and the runtime runs nothing else"))
        path = _placed(message.library, folder, files)
        memory = block.make(program, image.layout, number, message.areas)
        parts = tuple((name, tuple(firsts)) for name, firsts in message.parts)
        called = {unit.name.upper() for unit in memory.program.units if unit.external is not None}
        bound = tuple(b for b in bindings if b.unit.upper() in called)  # slaves have theirs by themselves
        return Native(program, number, period, native=Code(path, memory, parts, bound)), algorithms


def _bindings(message: Stage, program: Program, folder: Path, files: ExitStack) -> tuple[Binding, ...]:
    """The components of the program, in the order of their numbers. Raises Invalid when one was not sent."""
    sent = {part.unit.upper(): part for part in message.components}
    units = [u.name for u in (*program.units, *program.algorithms) if u.external is not None]
    missing = [name for name in units if name.upper() not in sent]
    if missing:
        raise findings.refused(findings.unusable(f"the code of component `{missing[0]}` is not with it"))
    return tuple(_binding(sent[name.upper()], program, folder, files) for name in units)


def _binding(part: Part, program: Program, folder: Path, files: ExitStack) -> Binding:
    types = {variable.name.upper(): variable.type for variable in program.globals}
    shared = tuple(Shared(name, types[name.upper()], at, written) for name, at, written in part.shared)
    if any(not 0 <= s.offset <= part.size <= _WINDOW for s in shared):
        raise ValueError(f"the globals of `{part.unit}` lie outside of its window")
    return Binding(part.unit, _placed(part.library, folder, files), part.entry, part.size, shared)


def _placed(library: bytes, folder: Path, files: ExitStack) -> Path:
    """A file with these bytes until all is loaded: what is mapped needs its name no more. A new file for
    every load, since a loader that knows a file gives the code, and the variables, that it has of it."""
    file = files.enter_context(unfinished.file_in(folder, 0o600))
    file.write(library)
    file.flush()
    return Path(file.name)
