"""Typed IL as the text of whole POUs that other IEC 61131-3 compilers read (DESIGN section 4).

Written conservatively: one instruction a line, the operand of ``OR(`` on its line, pins set by
``ST t1.IN`` before ``CAL t1``, functions called with their first argument in the accumulator;
only a call that takes outputs of a FUNCTION names its pins.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from ldc.expr import Const, Place
from ldc.il.declare import Declarations
from ldc.il.literals import literal, type_text
from ldc.il.names import IL_WORDS, Names, renamed
from ldc.il.plain import without_paths
from ldc.il.program import ARITHMETIC, COMPARISON, LOGIC, Instr, Operand, Program, RungCode, Unit
from ldc.records import replace
from ldc.symbols import Variable

# After these a bare literal takes the type of the accumulator; elsewhere it must tell its own.
_CONTEXT = frozenset((*LOGIC, *ARITHMETIC, *COMPARISON, "ANDN", "ORN", "XORN"))


def print_program(program: Program, sources: bool | None = None) -> str:
    """The whole project as one text: types, POUs callees first, configuration. The standard function
    blocks are left out, every IEC compiler has them. With ``sources`` the text that a rung was
    compiled from stands as a comment above its code."""
    program = without_paths(program)
    names = Names(program.units, program.globals)
    declarations = Declarations(names, program.units)
    used = [v.type for u in program.units for v in u.variables] + [v.type for v in program.globals]
    lines = list(declarations.types((*program.types, *used)))
    for unit in program.units:
        if not unit.standard:
            printer = _UnitPrinter(unit, program.units, program.globals, names, declarations, bool(sources))
            lines += printer.lines()
            lines.append("")
    lines += declarations.configuration(program)
    while lines and not lines[-1]:
        lines.pop()
    return "\n".join(lines) + "\n" if lines else ""


def print_unit(unit: Unit, units: Iterable[Unit] = ()) -> str:
    """One POU. ``units``: the POUs that it calls, for the names of their pins."""
    known = (*(u for u in units if u.name.upper() != unit.name.upper()), unit)
    names = Names(known)
    lines = _UnitPrinter(unit, known, (), names, Declarations(names, known), False).lines()
    return "\n".join(lines) + "\n"


class _UnitPrinter:
    def __init__(self, unit: Unit, units: Iterable[Unit], globals: Iterable[Variable], names: Names,
                 declarations: Declarations, sources: bool) -> None:
        self.unit, self.names, self.declarations, self.sources = unit, names, declarations, sources
        self.units = {u.name.upper(): u for u in units}
        self.globals = {v.name.upper(): v for v in globals}
        variables = [v.name for v in unit.variables]
        self.labels = renamed(_labels(unit), IL_WORDS | {v.upper() for v in variables}, variables)
        self.spilled: list[Variable] = []
        rung = unit.rungs[0] if len(unit.rungs) == 1 else None
        # Text that was never divided into rungs is not divided when printed.
        self._plain_body = rung is not None and rung.key == "body" and rung.name is None and not rung.title

    def lines(self) -> list[str]:
        unit = self.unit
        body: list[str] = []
        for rung in unit.rungs:
            body += self._rung(rung)
        result = f" : {type_text(unit.result)}" if unit.result is not None else ""
        title = f" (* {comment_text(unit.title)} *)" if unit.title else ""
        head = [f"{unit.kind} {self.names.pou(unit.name)}{result}{title}"]
        head += self.declarations.variables(self._variables(), unit.name)
        return [*head, *body, f"END_{unit.kind}"]

    def _variables(self) -> list[Variable]:
        unit = self.unit
        own = [v for v in unit.variables
               if not (unit.kind == "FUNCTION" and v.name.upper() == unit.name.upper())]
        known = {v.name.upper() for v in unit.variables if v.kind == "external"}
        used = dict.fromkeys(p.root.upper() for r in unit.rungs for i in r.code
                             for p in (places(i) if i.args or i.outputs else (i.operand,))
                             if type(p) is Place and p.is_global and p.root[:1] != "%")
        missing = [replace(v, name=self.names.globally(v.name), kind="external", location=None, retain=False)
                   for v in (self.globals.get(key) for key in used if key not in known) if v is not None]
        made = [v for v in own if v.name.upper().startswith("_LDC_")]
        return [*(v for v in own if v not in made), *missing, *made, *self.spilled]

    def _rung(self, rung: RungCode) -> Iterator[str]:
        title = f": {comment_text(rung.title)}" if rung.title else ""
        yield ""
        if self.sources and rung.span is not None:
            for line in rung.span.text.strip().splitlines():
                yield f"(* | {comment_text(line)} *)"
        if not self._plain_body:
            yield f'(* rung "{rung.key}"{title} *)'
        if rung.label is not None:
            yield f"{self._label(rung.label)}:"
        previous: Instr | None = None
        pending: str | None = None
        for instr in rung.code:
            if instr.op == "FN" and instr.outputs:
                yield from self._formal_call(instr, previous, pending)
                previous, pending = instr, None
                continue
            if pending is not None:
                yield pending
            previous, pending = instr, self._instruction(instr)
        if pending is not None:
            yield pending

    def _instruction(self, instr: Instr) -> str:
        op = instr.op
        if op == "LABEL":
            return f"{self._label(instr.name)}:"
        if op == "FN":
            args = ", ".join(self._operand(a, True) for a in instr.args)
            op = self._callee(instr)
            return f"    {op:<7} {args}".rstrip()
        if instr.name:
            return f"    {op:<7} {self._label(instr.name)}"
        if instr.operand is None:
            return f"    {op}"
        return f"    {op:<7} {self._operand(instr.operand, op not in _CONTEXT)}"

    def _operand(self, operand: Operand, typed: bool) -> str:
        if isinstance(operand, Const):
            return literal(operand.value, operand.type, typed)
        return self.names.place(self.unit.name, operand)

    def _label(self, name: str) -> str:
        return self.labels.get(name.upper(), name)

    def _formal_call(self, instr: Instr, previous: Instr | None, pending: str | None) -> Iterator[str]:
        """Pins by name, one a line. The first value comes from the LD before (``pending``, not yet
        printed), or through a temporary."""
        unit = self.units.get(instr.name.upper())
        pins = unit.arguments if unit else ()
        values = [self._operand(a, True) for a in instr.args]
        if pins and previous is not None and previous.op == "LD" and previous.operand is not None:
            values.insert(0, self._operand(previous.operand, True))
            pending = None
        if pending is not None:
            yield pending
        if len(values) < len(pins):
            spill = Variable(f"_ldc_first_{len(self.spilled) + 1}", pins[0].type, "temp")
            self.spilled.append(spill)
            yield f"    ST      {spill.name}"
            values.insert(0, spill.name)
        parts = [f"{self._pin(instr, pin.name)} := {value}" for pin, value in zip(pins, values)]
        in_outs = {v.name.upper() for v in pins if v.kind == "in_out"}
        for pin, place in (output for output in instr.outputs if output[0].upper() not in in_outs):
            parts.append(f"{self._pin(instr, pin)} => {self._operand(place, True)}")
        yield f"    {self._callee(instr)}("
        yield from (f"        {part}," for part in parts[:-1])
        yield f"        {parts[-1]}"
        yield "    )"

    def _callee(self, instr: Instr) -> str:
        unit = self.units.get(instr.name.upper())
        return instr.name if unit is None else self.names.pou(unit.name)

    def _pin(self, instr: Instr, pin: str) -> str:
        return self.names.variable(instr.name, pin)


def places(instr: Instr) -> Iterator[Place]:
    """The places that an instruction names itself (not those in indexes)."""
    operands = (instr.operand, *instr.args, *(p for _, p in instr.outputs))
    return (o for o in operands if isinstance(o, Place))


def comment_text(text: str) -> str:
    """``text`` on one line and unable to end or open a comment."""
    return re.sub(r"\s+", " ", text.replace("*)", "* )").replace("(*", "( *")).strip()


def _labels(unit: Unit) -> list[str]:
    labels = [r.label for r in unit.rungs if r.label is not None]
    return labels + [i.name for r in unit.rungs for i in r.code if i.op == "LABEL"]
