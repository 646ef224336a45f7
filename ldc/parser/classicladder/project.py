"""A ClassicLadder project as a file: main sections in their order, subroutines, one task."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import PurePath

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, fragments
from ldc.parser.classicladder import grid
from ldc.parser.classicladder.container import Part, parts
from ldc.parser.classicladder.expressions import INDEX
from ldc.parser.classicladder.paths import paths
from ldc.parser.classicladder.sequential import Pages
from ldc.parser.classicladder.settings import LADDER, SEQUENTIAL, Section, Settings, settings
from ldc.parser.classicladder.steps import RAIL, Drawing, Step
from ldc.parser.classicladder.variables import PRESETS, STEP_TIME, Variables
from ldc.parser.foreign import Names, Reading
from ldc.source import SourceFile, Span

MAX_RUNGS = 10_000
_RUNG = re.compile(r"rung_(\d{1,6})\.csv\Z")
_VARIABLE = re.compile(r"(\d{1,4})/(\d{1,6})", re.ASCII)
_OUTSIDE = {
    "ioconf.csv": "which terminals the inputs and outputs are",
    "modbusioconf.csv": "a Modbus connection",
}


def project(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The whole file (codes LD015x)."""
    reading = Reading(source, "ClassicLadder", diagnostics)
    found = parts(reading)
    if reading.lost:
        return ast.File(source, (), (), (), (), (), True, tuple(reading.remarks))
    for name, why in _OUTSIDE.items():
        if name in found and found[name].written:
            reading.left_out(found[name].written[0].span, f"the table {name}", why)
    return _Writer(reading, found).file()


@dataclass(slots=True)
class _Pou:
    """The rungs of the program or of a subroutine. ``used``: variables by name; ``calls``: subroutines."""

    rungs: list[ast.Rung] = field(default_factory=list)
    used: dict = field(default_factory=dict)
    calls: set[str] = field(default_factory=set)


class _Writer:
    def __init__(self, reading: Reading, found: dict[str, Part]) -> None:
        self.reading = reading
        self.settings: Settings = settings(reading, found)
        names = Names(reading)
        self.name = names.fresh(PurePath(reading.source.path).stem, pou=True)
        self.variables = Variables(reading, self.settings, names)
        lines = [line.text for line in self.settings.expressions.values()]
        self.variables.indexed = {int(kind) for text in lines for kind in INDEX.findall(text)}
        named = {(int(kind), int(number)) for text in lines for kind, number in _VARIABLE.findall(text)}
        self.timed = {number for kind, number in named if kind == STEP_TIME}
        self.drawn = self._drawn(found)
        named |= {(c.variable, c.offset) for rung in self.drawn.values() for c in rung.cells.values()
                  if grid.OPEN <= c.type <= grid.FALLING}
        self.variables.presets = {(PRESETS[kind], number) for kind, number in named if kind in PRESETS}
        self.span = Span(reading.source, 0, len(reading.source.text))
        self.head = reading.span(0, len(reading.source.line(1)))

    def _drawn(self, found: dict[str, Part]) -> dict[int, grid.Rung]:
        drawn: dict[int, grid.Rung] = {}
        for name, part in found.items():
            match = _RUNG.match(name)
            if match and len(drawn) == MAX_RUNGS:
                self.reading.too_large(part.span, MAX_RUNGS, "rungs")
                break
            if match:
                drawn[int(match[1])] = grid.rung(self.reading, int(match[1]), part)
        return drawn

    # ---- the file

    def file(self) -> ast.File:
        sections, variables = self._sections(), self.variables
        subroutines: dict[int, str] = {}
        for section in sections:
            if section.subroutine >= 0:
                name = variables.names.name(section.name, section.span, f"section {section.number}", pou=True)
                if section.subroutine in subroutines:
                    self.reading.malformed(section.span, f"there are two subroutines {section.subroutine}")
                subroutines.setdefault(section.subroutine, name)
        pages = Pages(variables, self.settings, self.timed)
        main, blocks = _Pou(), {}
        for section in sections:
            into = (
                main if section.subroutine < 0 else blocks.setdefault(subroutines[section.subroutine], _Pou())
            )
            variables.used = into.used
            if section.language == SEQUENTIAL:
                into.rungs += pages.rungs(section.page, section.name, section.span)
            elif section.language == LADDER:
                self._ladder(section, into, subroutines)
            else:
                self.reading.unsupported(section.span, f"a section in language {section.language}",
                                         "ladder and sequential sections are read")
        self._loops(blocks)
        if ("system",) in variables.found:
            variables.used = main.used
            block = variables.supporting("system")
            called = f"<{variables.system(self.head)}: {block}(SCAN := {self.settings.period})>"
            main.rungs.insert(0, ast.Rung(
                None, None, (fragments.path(fragments.items(called, self.head), self.head),), self.head))
        everything = [v for v in variables.found.values() if v.name]
        declared = variables.section("VAR_EXTERNAL", main.used.values(), self.head) if blocks else (
            variables.section("VAR", everything, self.head))
        program = ast.Pou(
            "PROGRAM",
            self.name,
            None,
            None,
            declared,
            ast.LadderBody(tuple(main.rungs), self.span),
            self.span,
            self.head,
        )
        pous = [self._subroutine(name, pou) for name, pou in blocks.items()]
        globals_ = variables.section("VAR_GLOBAL", everything, self.head) if blocks else ()
        self._unused()
        configuration = fragments.configuration(
            variables.names.fresh("plc"), self.name, f"T#{self.settings.period}ms", self.head)
        return ast.File(self.reading.source, (*variables.blocks.values(), *pous, program), (), globals_,
                        (configuration,), (), self.reading.lost, tuple(self.reading.remarks))

    def _sections(self) -> list[Section]:
        """The sections; in files older than sections, all rungs are one."""
        if self.settings.sections or not self.drawn:
            return self.settings.sections
        numbers = sorted(self.drawn)
        for before, after in zip(numbers, numbers[1:], strict=False):
            self.drawn[before].following = after
        return [Section(0, self.name, LADDER, -1, numbers[0], numbers[-1], 0, self.head)]

    def _subroutine(self, name: str, pou: _Pou) -> ast.Pou:
        run = fragments.variable("RUN", "BOOL", self.head)
        done = fragments.variable("DONE", "BOOL", self.head)
        declared = (ast.VarBlock("VAR_INPUT", (), (run,), self.head),
                    ast.VarBlock("VAR_OUTPUT", (), (done,), self.head),
                    *self.variables.section("VAR_EXTERNAL", pou.used.values(), self.head))
        texts = ("[RUN] (DONE)", "[/RUN] >>RETURN")
        first = tuple(fragments.path(fragments.items(text, self.head), self.head) for text in texts)
        body = ast.LadderBody((ast.Rung(None, None, first, self.head), *pou.rungs), self.head)
        return ast.Pou("FUNCTION_BLOCK", name, None, None, declared, body, self.head, self.head)

    def _loops(self, blocks: dict[str, _Pou]) -> None:
        """Subroutines that call themselves, or each other in a circle, are told."""
        waiting = {name: len(pou.calls) for name, pou in blocks.items()}
        callers: dict[str, list[str]] = {}
        for name, pou in blocks.items():
            for called in pou.calls:
                callers.setdefault(called, []).append(name)
        ready = [name for name, count in waiting.items() if not count]
        while ready:
            name = ready.pop()
            del waiting[name]
            for caller in callers.get(name, ()):
                waiting[caller] -= 1
                if not waiting[caller]:
                    ready.append(caller)
        if waiting:
            self.reading.unsupported(self.head, f"the subroutine {next(iter(waiting))} that calls itself",
                                     "write the repetition with a jump")

    def _unused(self) -> None:
        for variable, (symbol, _, span) in self.settings.symbols.items():
            if variable not in self.variables.symbols:
                self.reading.remark("left out", f"{variable} {symbol}", "nothing uses it", span)

    # ---- rungs

    def _ladder(self, section: Section, into: _Pou, subroutines: dict[int, str]) -> None:
        chain = self._chain(section)
        made = [(rung, Drawing(self.variables, self.settings, subroutines, rung).make()) for rung in chain]
        names = self._labels(made)
        for rung, steps in made:
            into.calls |= {step.call for step in steps if step.call}
            for step in steps:
                if step.jump is not None:
                    step.text = f">>{self._target(step, names)}"
            title = rung.comment or None
            name = names.get(rung.number) if steps else None
            for part in self._split(steps):
                into.rungs.append(
                    ast.Rung(name, title, paths(part, rung.span), rung.span, rung.span if name else None)
                )
                title = name = None

    def _chain(self, section: Section) -> list[grid.Rung]:
        """The rungs of a section, from the first along the links to the last."""
        found: dict[int, grid.Rung] = {}
        at = section.first
        while at in self.drawn and at not in found:
            found[at] = self.drawn[at]
            if at == section.last:
                return list(found.values())
            at = self.drawn[at].following
        self.reading.malformed(section.span, f"the rungs of {section.name} do not lead from {section.first} "
                                             f"to {section.last}", "this section")
        return list(found.values())

    def _labels(self, made: list[tuple[grid.Rung, list[Step]]]) -> dict[int, str]:
        """The names of rungs that have a label or are jumped to. An empty one that is jumped to stands for
        the next that is not, the last ones for RETURN."""
        wanted = {step.jump for _, steps in made for step in steps if step.jump is not None}
        stands: dict[int, grid.Rung | None] = {}
        follows: grid.Rung | None = None
        for rung, steps in reversed(made):
            follows = rung if steps else follows
            if rung.number in wanted or (steps and rung.label):
                stands[rung.number] = follows
        names = self.variables.names
        return {number: names.name(rung.label or f"rung_{rung.number}", rung.span, f"rung {rung.number}")
                if rung else "RETURN" for number, rung in sorted(stands.items())}

    def _target(self, step: Step, names: dict[int, str]) -> str:
        target = names.get(step.jump)
        if not target:
            where = "another section" if step.jump in self.drawn else "nowhere"
            self.reading.malformed(step.span, f"a jump to rung {step.jump} leads to {where}")
            return "RETURN"
        return target

    def _split(self, steps: list[Step]) -> list[list[Step]]:
        """A jump is taken at once, what stands behind it in the rung becomes a rung of its own; it gets the
        power of the first part through variables."""
        found = []
        while True:
            at = next((n for n, step in enumerate(steps) if step.jump is not None), None)
            if at is None or not any(step.acts for step in steps[at + 1 :]):
                return [*found, steps] if steps else found
            before, jump, after = steps[:at], steps[at], steps[at + 1 :]
            fed = {net for step in before for net in (step.tail, *step.outputs.values())}
            needed = dict.fromkeys(
                net
                for step in after
                for net in (step.head, *step.inputs.values())
                if net is not RAIL and net in fed
            )
            for net in needed:
                name = self.variables.added("power", "BOOL", jump.span, "power behind a jump")
                before.append(Step(f"({name})", net, None, jump.span, acts=True))
                after.insert(0, Step(f"[{name}]", RAIL, net, jump.span))
            found.append([*before, jump])
            steps = after
