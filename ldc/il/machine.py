"""The machine that IL text is read on: code, accumulator, open parentheses, and what may be done to them."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.expr import Place
from ldc.il import findings
from ldc.il.accumulator import POISON, Accumulator, Open, allowed, base, does_not_work, widens
from ldc.il.operands import Operand, Operands
from ldc.il.program import Instr
from ldc.il.regions import Regions
from ldc.il.scan import Line, Scanner
from ldc.library import functions
from ldc.model.project import Pou
from ldc.model.type_findings import conversion_help, described, enumerated
from ldc.model.values import AnyEnum, Untyped, same, settle
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import BOOL, DINT, Enum, Instance, Type, holds_blocks, is_scalar, storage

# What needs no value in the accumulator, whatever was in it before.
_FRESH = frozenset(("", "LD", "LDN", "JMP", "CAL", "RET", "RETURN"))


class Machine:
    """State while one body is read. ``at`` is the span of the instruction that is being read, ``next``
    the line after it; ``wanting``: labels (in capitals) over which the result is carried; ``forgiven``:
    closing parentheses to come whose opening was given up."""

    def __init__(self, pou: Pou, scope, diagnostics: Diagnostics) -> None:
        self.pou, self.scope, self.diagnostics = pou, scope, diagnostics
        self.operands = Operands(pou, scope, diagnostics)
        body = pou.body.span
        self.scanner = Scanner(body.source.text, body.start, body.end)
        self.code: list[Instr] = []
        self.acc = Accumulator()
        self.stack: list[Open] = []
        self.forgiven = 0
        self.regions = Regions(self.code)
        self.temps: list[Variable] = []
        self.spelled: set[str] = set()
        self.next: Line | None = None
        self.wanting: set[str] = set()
        self.at: Span | None = None

    def span_of(self, start: int, end: int) -> Span:
        return self.operands.span(start, end)

    def temp(self, type_: Type) -> Place:
        taken = self.pou.variables
        number = len(self.temps) + 1
        while f"_LDC_X_{number}" in taken:
            number += len(self.temps) + 1
        self.temps.append(Variable(f"_ldc_x_{number}", type_, "temp"))
        return Place(f"_ldc_x_{number}", type_)

    def label(self) -> str:
        """A label that the text does not have."""
        number = 1
        while f"_LDC_SKIP_{number}" in self.spelled:
            number += 1
        self.spelled.add(f"_LDC_SKIP_{number}")
        return f"_ldc_skip_{number}"

    def emit(self, op: str, operand=None, type_: Type = BOOL, name: str = "", args=(), outputs=()) -> None:
        self.code.append(Instr(op, operand, base(type_), name, args, outputs, span=self.at))

    def use(self, op: str) -> bool:
        """Whether there is a value to work on; says so when there is none."""
        if not self.acc.defined:
            findings.undefined(self.diagnostics, self.at, op)
            self.acc.set(POISON)
        self.regions.continued()
        return not self.acc.poisoned

    def define(self, type_: Type | None) -> None:
        self.regions.started()
        self.acc.set(type_)

    # -- values

    def value(self, start: int, end: int, whole: bool = False) -> Operand | None:
        """The operand at these offsets when it is a single value or, with ``whole``, an array or a
        structure to be copied. What the next line hands over may also be, or hold, an instance."""
        found = self.operands.value(start, end, self.acc.type if isinstance(self.acc.type, Enum) else None)
        if isinstance(found, Place) and not (is_scalar(found.type) or whole and (
                copied(found.type) or self._taken_next())):
            what = described(found.type)
            help = "name one of its outputs, `instance.pin`" if isinstance(found.type, Instance) \
                else "load its elements one by one"
            findings.wrong_types(self.diagnostics, self.span_of(start, end), f"`{found}` is no single value",
                                 f"this is {what}", help)
            return None
        return found

    def _taken_next(self) -> bool:
        """Whether the next line takes instances: a FUNCTION of the project, or a store to a pin or variable
        that holds some."""
        line = self.next
        if line is None or line.label:
            return False
        if line.op != "ST":
            called = self.scope.signature(line.op)
            return called is not None and called.kind == "FUNCTION"
        root = re.match(r"\w*", self.operands.source.text[line.start:line.end])[0]
        found = self.scope.variable(root.upper())
        return found is not None and holds_blocks(found[0].type)

    def load(self, op: str, value: Operand | None) -> None:
        """The value becomes that of the accumulator; None after an error."""
        self.define(POISON)
        if value is None:
            return
        if isinstance(value, AnyEnum):
            value = settle(value, None, self.diagnostics)
            if value is None:
                return
        if isinstance(value, Untyped):
            self.acc.set(None)
            self.acc.loose.append((len(self.code), value, True))
            self.acc.literal = value
            self.emit(op)
            return
        self.emit(op, value, value.type)
        self.acc.set(value.type)

    def store(self, op: str, place: Place) -> None:
        """Stores the accumulator, widened; afterwards it holds what it held before."""
        literal, got = self.acc.literal, self.acc.type
        if literal is not None and got is not None and not same(got, place.type):
            self.load("LD", literal)
        restored: Place | None = None
        widened = not self.acc.loose and widens(got, place.type) and not same(got, place.type)
        if widened and self.needed_after():
            restored = self.temp(got)
            self.emit("ST", restored, got)
        if not self.convert(place.type, op) or op == "STN" and not self.check("NOT", place.type):
            return
        self.code.append(Instr(op, place, place.type, span=self.at))
        if restored is not None:
            self.emit("LD", restored, got)
            self.acc.set(got)

    def needed_after(self) -> bool:
        """Whether the next instruction may use what is in the accumulator now."""
        line = self.next
        return line is not None and works_on_result(line) and (
            not line.label or line.label.upper() in self.wanting)

    # -- types

    def convert(self, wanted: Type, op: str) -> bool:
        """Widens the accumulator to ``wanted``; False, with a finding, when that cannot be."""
        if self.acc.loose:
            return self.acc.settle(wanted, self.code, self.diagnostics)
        got = self.acc.type
        if same(got, wanted):
            return True
        if isinstance(wanted, Enum) and same(got, DINT):
            enumerated(self.diagnostics, self.at, got, wanted)  # stored alike
            self.acc.set(wanted)
            return True
        if not widens(got, wanted):
            self.mismatch(op, got, wanted)
            return False
        self.emit("FN", None, wanted, functions.conversion(storage(got), storage(wanted)))
        self.acc.set(wanted)
        return True

    def convert_loose(self, type_: Type) -> bool:
        return not self.acc.loose or self.acc.settle(type_, self.code, self.diagnostics)

    def condition(self, op: str) -> bool:
        """Whether the accumulator is a BOOL to decide by."""
        if not self.use(op) or not self.convert_loose(BOOL):
            return False
        if self.acc.type != BOOL:
            self.mismatch(op, self.acc.type, BOOL)
            return False
        return True

    def check(self, op: str, type_: Type) -> bool:
        """Whether the operator works in the type; says so when it does not."""
        if allowed(op, type_):
            return True
        does_not_work(self.diagnostics, self.at, op, type_)
        self.acc.set(POISON)
        return False

    def mismatch(self, op: str, got: Type, wanted: Type) -> None:
        findings.wrong_types(self.diagnostics, self.at,
                             f"`{op}` needs {described(wanted)}, not {described(got)}",
                             f"the accumulator holds {described(got)}", conversion_line(got, wanted))
        self.acc.set(POISON)

    # -- the form of a line

    def operand(self, line: Line, what: str = "an operand") -> bool:
        """Whether there is an operand."""
        if line.start < line.end:
            return True
        findings.operand_missing(self.diagnostics, self.at, line.op, what)
        self.acc.set(POISON)
        return False

    def nothing_more(self, line: Line) -> None:
        """For what takes no operand."""
        if line.start < line.end:
            findings.malformed(self.diagnostics, self.span_of(line.start, line.end),
                               f"`{line.op}` takes no operand",
                               "take it away, or write it on a line of its own")

    def outside(self, what: str) -> bool:
        """Whether no parenthesis is open; says so when one is, and counts all as closed from there on."""
        if not self.stack:
            return True
        findings.inside_parentheses(self.diagnostics, self.at, what, self.stack[-1].span)
        self.forgiven += len(self.stack)
        self.stack.clear()
        self.acc.set(POISON)
        return False

    def never_closed(self, span: Span) -> None:
        findings.unbalanced(self.diagnostics, span, "never closed", "add the missing `)`")


def works_on_result(line: Line) -> bool:
    """Whether the instruction needs what was in the accumulator before it."""
    return line.op not in _FRESH and not (line.paren and line.arguments >= 0)


def copied(type_: Type) -> bool:
    """Whether LD and ST move values of the type: of any but function blocks and what holds some."""
    return not holds_blocks(type_)


def conversion_line(got: Type, wanted: Type, convert: str = "convert it by `") -> str:
    if not (is_scalar(got) and is_scalar(wanted)):
        return "both sides of a copy have one type; name an element or a member to take less"
    help = conversion_help(got, wanted)
    if not help.startswith("convert it by `"):
        return help
    return help.replace("convert it by `", convert).replace("(...)`", "` on a line before")
