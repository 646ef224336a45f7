"""Generates, compiles and binds the functions of one resource: the namespace that a machine runs on."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from types import CodeType, TracebackType

from ldc.il.external import Binding
from ldc.il.program import Program, Unit
from runtime.faults import Place, WatchdogExpired
from runtime.layout import FIRST_SCAN, NOW, Layout, lay_out, slot
from runtime.vm.beside import here
from runtime.vm.calls import Calls
from runtime.vm.codegen import Body, Source
from runtime.vm.memory import Memory
from runtime.vm.names import Names


@dataclass(slots=True)
class Watchdog:
    """Counts backward jumps of one task execution down; ``limit`` is set when the execution begins."""

    limit: int = 0
    left: int = 0

    def start(self, limit: int) -> None:
        self.limit = self.left = limit

    def tick(self) -> None:
        """One backward jump. Raises WatchdogExpired when there were too many."""
        self.left -= 1
        if self.left < 0:
            raise WatchdogExpired(self.limit)


@dataclass(frozen=True, slots=True)
class Code:
    """``bodies[i]`` runs program instance i. ``sources`` maps a generated file name to its unit and text."""

    layout: Layout
    memory: Memory
    calls: Calls
    watchdog: Watchdog
    bodies: tuple[Callable[[], None], ...]
    sources: dict[str, tuple[Unit, Source]] = field(repr=False)

    @property
    def namespace(self) -> dict[str, object]:
        return self.memory.namespace

    def text(self) -> str:
        """All generated Python, for people and tests."""
        return "\n".join(f"# {name}\n{source.text}" for name, (_, source) in self.sources.items())

    def trace(self, traceback: TracebackType | None) -> tuple[Place, ...]:
        """The places in IL that a Python traceback went through, outermost first."""
        found = []
        while traceback is not None:
            known = self.sources.get(traceback.tb_frame.f_code.co_filename)
            if known is not None:
                unit, source = known
                at = source.lines[traceback.tb_lineno] if traceback.tb_lineno < len(source.lines) else -1
                if at >= 0:
                    rung, index = source.flat.places[at]
                    instr = source.flat.code[at]
                    found.append(Place(unit.name, unit.rungs[rung].key, index, instr.element,
                                       instr.span or unit.rungs[rung].span))
            traceback = traceback.tb_next
        return tuple(found)


def load(program: Program, resource: int = 0, bindings: Iterable[Binding] = (),
         body: Callable[..., Body] = Body, watchdog: Watchdog | None = None,
         compiled: Callable[[Mapping[str, str]], Mapping[str, CodeType]] = here) -> Code:
    """A fresh memory and the functions that run on it; ``bindings``: where the native code of its
    components is; ``body``: what translates a unit; ``compiled``: what makes code of Python texts by file.
    Raises BadCode for IL that verification refuses, MissingNative when native code is not bound."""
    layout = lay_out(program, resource)
    memory = Memory(layout)
    calls = Calls(memory)
    watchdog = watchdog or Watchdog()
    namespace = memory.namespace
    namespace[NOW], namespace[FIRST_SCAN] = 0, True
    sources: dict[str, tuple[Unit, Source]] = {}
    for unit in program.units:
        if unit.kind == "FUNCTION_BLOCK":
            name = calls.block(unit.name)
        elif unit.kind == "FUNCTION":
            name = calls.user(unit)
        else:
            continue
        sources[f"<il {unit.name}>"] = unit, body(unit, Names(layout, unit, None), name, calls).source()
    for number, (run, _) in enumerate(layout.programs):
        unit = layout.units[run.pou.upper()]
        source = body(unit, Names(layout, unit, number), f"run_{number}", calls).source()
        sources[f"<il {unit.name} {number} {slot(run.name)}>"] = unit, source
    namespace.update(calls.names)
    namespace.update(_natives(program, layout, calls, namespace, bindings))
    namespace["_tick"] = watchdog.tick
    namespace["__builtins__"] = {}
    for code in compiled({file: source.text for file, (_, source) in sources.items()}).values():
        exec(code, namespace)
    bodies = tuple(namespace[f"run_{n}"] for n in range(len(layout.programs)))
    return Code(layout, memory, calls, watchdog, bodies, sources)


def _natives(program: Program, layout: Layout, calls: Calls, namespace: dict[str, object],
             bindings: Iterable[Binding]) -> dict[str, Callable]:
    units = [u for u in program.units if u.external is not None]
    if not units:
        return {}
    from runtime.vm import external  # loads cffi, which only components need

    known = {b.unit.upper(): b for b in bindings}
    homes = {name: root.home for name, root in layout.globals.items()}
    made = {}
    for unit in units:
        if unit.name.upper() not in known:
            raise external.MissingNative(unit)
        made[calls.native(unit)] = external.call(unit, known[unit.name.upper()], namespace, homes)
    return made
