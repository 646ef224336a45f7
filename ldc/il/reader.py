"""IL text to typed IL: IEC 61131-3, 2nd edition, tables 51 to 53, with the accumulator's type known."""

from __future__ import annotations

import re
from dataclasses import replace

from ldc.diagnostics import Diagnostics
from ldc.expr import Const, Place
from ldc.il import calls, findings
from ldc.il.accumulator import POISON, Accumulator, Open, allowed, base
from ldc.il.emit import typed_function
from ldc.il.operands import Operand, Operands
from ldc.il.program import ARITHMETIC, COMPARISON, LOGIC, Instr, Unit
from ldc.il.regions import Regions
from ldc.il.scan import Line, Mark, Scanner
from ldc.library import functions
from ldc.model.names import suggest
from ldc.model.project import Pou
from ldc.model.type_findings import conversion_help, described
from ldc.model.values import AnyEnum, Untyped, same, settle
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import BOOL, TIME, Elementary, Enum, Instance, Type, is_scalar, storage

# Names that the compiler gave to temporaries (``_ldc_t1``, ``_ldc_int_2``); others are memories.
_TEMPORARY = re.compile(r"_ldc_(t\d+|[a-z0-9]+_\d+)\Z", re.IGNORECASE)
# What needs no value in the accumulator, whatever was in it before.
_FRESH = frozenset(("", "LD", "LDN", "JMP", "CAL", "RET", "RETURN"))


def parse_unit(pou: Pou, scope, diagnostics: Diagnostics) -> Unit | None:
    """The IL of a POU whose body is ``ast.TextBody("IL")``; None when it has errors.

    ``scope`` is the ``model.Scope`` of the POU. Comments ``(* rung "key": title *)``, as the printer
    writes them, divide the code into rungs; without them it is one rung, "body".
    """
    own = Diagnostics()
    unit = Reader(pou, scope, own).unit()
    diagnostics.extend(own)
    return None if own.has_errors else unit


class Reader:
    """Reads one body, instruction by instruction."""

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
        self.labels: dict[str, tuple[str, Span]] = {}
        self.jumps: list[tuple[int, Span]] = []
        self.temps: list[Variable] = []
        self.spelled: set[str] = set()
        self.next: Line | None = None
        self.at: Span | None = None

    def unit(self) -> Unit:
        lines = list(self.scanner.lines())
        marks = list(reversed(self.scanner.marks))
        self.spelled = {line.label.upper() for line in lines if line.label}
        for line, self.next in zip(lines, [*lines[1:], None]):
            while marks and marks[-1].at < (line.label_start if line.label else line.op_start):
                self._mark(marks.pop())
            self._line(line)
        while marks:
            self._mark(marks.pop())
        for opened in self.stack:
            self.never_closed(opened.span)
        self._connect()
        signature, variables = self.pou.signature, [_restored(v) for v in self.pou.variables.values()]
        return Unit(signature.kind, signature.name, (*variables, *self.temps), self.regions.rungs(self.span_of),
                    signature.result, self.pou.title or self._title(), signature.standard)

    def span_of(self, start: int, end: int) -> Span:
        return self.operands.span(start, end)

    # -- the surroundings

    def _title(self) -> str | None:
        """The comment behind the POU's name, where the printer puts its title."""
        text, start = self.operands.source.text, self.pou.span.start
        stop = text.find("\n", start)
        match = re.match(r"[^(]*\(\* (.*) \*\)\s*\Z", text[start: stop if stop >= 0 else len(text)])
        return match[1] if match else None

    def _mark(self, mark: Mark) -> None:
        if not self.stack:
            self.regions.open(mark)

    def _connect(self) -> None:
        """Labels of jumps, in the spelling of the label."""
        for index, span in self.jumps:
            name = self.code[index].name
            found = self.labels.get(name.upper())
            if found is None:
                findings.unknown_label(self.diagnostics, span, name,
                                       suggest(name, (spelled for spelled, _ in self.labels.values())))
            else:
                self.code[index] = replace(self.code[index], name=found[0])

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

    # -- building blocks

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

    def value(self, start: int, end: int) -> Operand | None:
        """The operand at these offsets when it is a single value."""
        found = self.operands.value(start, end, self.acc.type if isinstance(self.acc.type, Enum) else None)
        if isinstance(found, Place) and not is_scalar(found.type):
            what = described(found.type)
            help = "name one of its outputs, `instance.pin`" if isinstance(found.type, Instance) \
                else "load its elements one by one"
            findings.wrong_types(self.diagnostics, self.span_of(start, end), f"`{found}` is no single value",
                                 f"this is {what}", help)
            return None
        return found

    def convert(self, wanted: Type, op: str) -> bool:
        """Widens the accumulator to ``wanted``; False, with a finding, when that cannot be."""
        if self.acc.loose:
            return self.acc.settle(wanted, self.code, self.diagnostics)
        got = self.acc.type
        if same(got, wanted):
            return True
        if not widens(got, wanted):
            self._mismatch(op, got, wanted)
            return False
        self.emit("FN", None, wanted, functions.conversion(storage(got), storage(wanted)))
        self.acc.set(wanted)
        return True

    def _mismatch(self, op: str, got: Type, wanted: Type) -> None:
        findings.wrong_types(self.diagnostics, self.at, f"`{op}` needs {described(wanted)}, not {described(got)}",
                             f"the accumulator holds {described(got)}", _conversion_line(got, wanted))
        self.acc.set(POISON)

    def needed_after(self) -> bool:
        """Whether the next instruction may use what is in the accumulator now."""
        line = self.next
        return line is not None and not line.label and line.op not in _FRESH and not (
            line.paren and line.arguments >= 0)

    def outside(self, what: str) -> bool:
        """Whether no parenthesis is open; says so when one is, and counts all as closed from there on."""
        if not self.stack:
            return True
        findings.inside_parentheses(self.diagnostics, self.at, what, self.stack[-1].span)
        self.forgiven += len(self.stack)
        self.stack.clear()
        self.acc.set(POISON)
        return False

    # -- lines

    def _line(self, line: Line) -> None:
        if line.label:
            self._label(line)
        self.at = self.span_of(line.op_start, line.stop)
        if not line.op:
            if line.start < line.end:
                text = self.at.text[:40]
                findings.unknown_instruction(self.diagnostics, self.at, text, "")
                self.acc.set(POISON)
            return
        if line.after is not None:
            findings.malformed(self.diagnostics, self.span_of(*line.after), "text after the end of the call",
                               "write one instruction a line")
        handler = _HANDLERS.get(line.op)
        if handler is None:
            calls.function(self, line)
            return
        if line.arguments >= 0 and not line.closed:
            self.never_closed(self.span_of(line.arguments, line.arguments + 1))
            self.define(POISON)
        elif line.paren and line.op not in _DEFERRED and line.op != ")":
            findings.malformed(self.diagnostics, self.at, f"`{line.op}` takes no parentheses",
                               f"write `{line.op} operand`")
            self.define(POISON)
        else:
            handler(self, line)
            if line.closed and line.arguments < 0:
                self.at = self.span_of(line.stop - 1, line.stop)
                self._closing()

    def never_closed(self, span: Span) -> None:
        findings.unbalanced(self.diagnostics, span, "never closed", "add the missing `)`")

    def _label(self, line: Line) -> None:
        self.at = span = self.span_of(line.label_start, line.label_start + len(line.label))
        self.outside("a label")
        known = self.labels.get(line.label.upper())
        if known is not None:
            findings.duplicate_label(self.diagnostics, span, line.label, known[1])
        else:
            self.labels[line.label.upper()] = line.label, span
        self.emit("LABEL", name=line.label)
        self.define(None)

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
                               f"`{line.op}` takes no operand", "take it away, or write it on a line of its own")

    # -- loading and storing

    def _load(self, line: Line) -> None:
        if not self.operand(line):
            return
        if line.op == "LD" and (called := calls.input_operator(self, line)):
            return called
        value = self.value(line.start, line.end)
        self.load(line.op, value)
        if line.op == "LDN" and value is not None and self.convert_loose(BOOL):
            self.check("NOT", self.acc.type)

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

    def convert_loose(self, type_: Type) -> bool:
        return not self.acc.loose or self.acc.settle(type_, self.code, self.diagnostics)

    def _store(self, line: Line) -> None:
        if not self.operand(line) or line.op in ("S", "R") and calls.input_operator(self, line):
            return
        place = self.operands.place(line.start, line.end, write=True)
        if not self.use(line.op) or place is None:
            return
        if not is_scalar(place.type):
            findings.wrong_types(self.diagnostics, self.at, f"`{place}` takes no single value",
                                 f"this is {described(place.type)}", "store to its elements one by one")
            return
        if line.op in ("S", "R"):
            if place.type != BOOL:
                findings.wrong_types(self.diagnostics, self.at, f"`{line.op}` needs a BOOL",
                                     f"`{place}` is {described(place.type)}", "set and reset BOOL variables only")
            elif self.condition(line.op):
                self.emit(line.op, place)
            return
        self.store(line.op, place)

    def store(self, op: str, place: Place) -> None:
        """Stores the accumulator, widened; afterwards it holds what it held before."""
        literal, got = self.acc.literal, self.acc.type
        if literal is not None and got is not None and not same(got, place.type):
            self.load("LD", literal)
        restored: Place | None = None
        if not self.acc.loose and widens(got, place.type) and not same(got, place.type) and self.needed_after():
            restored = self.temp(got)
            self.emit("ST", restored, got)
        if not self.convert(place.type, op) or op == "STN" and not self.check("NOT", place.type):
            return
        self.code.append(Instr(op, place, place.type, span=self.at))
        if restored is not None:
            self.emit("LD", restored, got)
            self.acc.set(got)

    # -- operators

    def _operator(self, line: Line) -> None:
        op = line.op.replace("&", "AND")
        if line.paren:
            self._open(line, op)
            return
        if not self.operand(line):
            return
        parts = self.scanner.split(line.start, line.end)
        if len(parts) > 1 and op not in ("ADD", "MUL", *LOGIC):
            findings.malformed(self.diagnostics, self.span_of(*parts[1]), f"`{op}` takes one operand",
                               "write one instruction for each")
            self.acc.set(POISON)
            return
        for start, end in parts:
            value = self.value(start, end)
            if not self.use(op):
                return
            self.operate(op, value)

    def operate(self, op: str, value: Operand | None) -> None:
        """Joins the accumulator with a value."""
        acc = self.acc
        if isinstance(value, Untyped) and acc.type is not None:
            wanted = acc.type
            if wanted == TIME and op in ("MUL", "DIV"):
                wanted = None
            value = settle(value, wanted, self.diagnostics)
        elif isinstance(value, AnyEnum):
            value = settle(value, acc.type, self.diagnostics)
        if value is None:
            acc.set(POISON)
        elif isinstance(value, Untyped):
            acc.literal = None
            acc.loose.append((len(self.code), value, True))
            self.emit(op)
            self._finish(op)
        elif not acc.loose or acc.settle(value.type, self.code, self.diagnostics):
            self._join(op, value)

    def _join(self, op: str, value: Const | Place) -> None:
        plain, left, right = _plain(op), self.acc.type, base(value.type)
        mixed = typed_function(plain, (left, right))
        if mixed is not None:
            calls.standard(self, mixed, (value,))
            return
        type_ = common(left, right)
        if type_ is None:
            self._cannot_join(op, left, right)
            return
        if not self.convert(type_, op) or not self.check(plain, type_):
            return
        if same(right, type_):
            self.emit(op, value, type_)
        else:
            self.emit(op + "(", value, type_)
            self.emit("FN", None, type_, functions.conversion(storage(right), storage(type_)))
            self.emit(")", None, type_)
        self.acc.set(BOOL if plain in COMPARISON else type_)

    def _finish(self, op: str) -> None:
        """After an operator on literals only: a comparison has to decide their type now."""
        if op in COMPARISON:
            if self.acc.settle(self.acc.natural(), self.code, self.diagnostics):
                self.acc.set(BOOL)

    def _cannot_join(self, op: str, left: Type, right: Type) -> None:
        if _plain(op.removesuffix("(")) in LOGIC:
            help = "compare numbers first, for example by `GT 0`" if BOOL in (left, right) else ""
        else:
            help = _conversion_line(left, right) or _conversion_line(right, left, "convert the operand by `")
        findings.wrong_types(self.diagnostics, self.at,
                             f"`{op}` cannot join {described(left)} with {described(right)}",
                             f"the accumulator holds {described(left)}", help)
        self.acc.set(POISON)

    def check(self, op: str, type_: Type) -> bool:
        """Whether the operator works in the type; says so when it does not."""
        if allowed(op, type_):
            return True
        works = "BOOL and bit strings" if op in (*LOGIC, "NOT") else "integers" if op == "MOD" else "numbers"
        findings.wrong_types(self.diagnostics, self.at, f"`{op}` does not work on {described(type_)}",
                             f"the accumulator holds {described(type_)}", f"it works on {works}; convert it before")
        self.acc.set(POISON)
        return False

    def _open(self, line: Line, op: str) -> None:
        self.use(op + "(")
        self.stack.append(Open(op, len(self.code), self.acc, self.at))
        self.acc = Accumulator()
        value = self.value(line.start, line.end) if line.start < line.end else None
        if line.start < line.end:
            self.load(op + "(", value)
            self.acc.loose = [(index, literal, False) for index, literal, _ in self.acc.loose]
            self.acc.literal = None
        else:
            self.emit(op + "(")

    def _close(self, line: Line) -> None:
        self.nothing_more(line)
        self._closing()

    def _closing(self) -> None:
        if not self.stack:
            if self.forgiven == 0:
                findings.unbalanced(self.diagnostics, self.at, "nothing is open here", "take it away")
            self.forgiven = max(0, self.forgiven - 1)
            return
        defined = self.acc.defined
        self.use(")")
        opened, inner = self.stack.pop(), self.acc
        self.acc = opened.before
        if not defined or inner.poisoned or self.acc.poisoned:
            self.acc.set(POISON)
            return
        self._combine(opened, inner)

    def _combine(self, opened: Open, inner: Accumulator) -> None:
        op, plain, outer = opened.op, _plain(opened.op), self.acc
        outer.literal = None
        if inner.loose and outer.loose:
            outer.loose += [*inner.loose, (opened.index, None, True), (len(self.code), None, True)]
            self.emit(")")
            self._finish(op)
            return
        if inner.loose and not inner.settle(outer.type, self.code, self.diagnostics) or (
                outer.loose and not outer.settle(inner.type, self.code, self.diagnostics)):
            outer.set(POISON)
            return
        left, right = outer.type, inner.type
        type_ = common(left, right)
        if type_ is None:
            self._cannot_join(op + "(", left, right)
            return
        if not self.check(plain, type_):
            return
        if not same(right, type_):
            self.emit("FN", None, type_, functions.conversion(storage(right), storage(type_)))
        self.code[opened.index] = replace(self.code[opened.index], type=type_)
        if not same(left, type_):
            name = functions.conversion(storage(left), storage(type_))
            self.code.insert(opened.index, Instr("FN", None, type_, name, span=opened.span))
        self.emit(")", None, type_)
        self.acc.set(BOOL if plain in COMPARISON else type_)

    def _not(self, line: Line) -> None:
        self.nothing_more(line)
        if self.use("NOT") and self.convert_loose(BOOL) and self.check("NOT", self.acc.type):
            self.emit("NOT", None, self.acc.type)
            self.acc.literal = None

    # -- control

    def condition(self, op: str) -> bool:
        """Whether the accumulator is a BOOL to decide by."""
        if not self.use(op) or not self.convert_loose(BOOL):
            return False
        if self.acc.type != BOOL:
            self._mismatch(op, self.acc.type, BOOL)
            return False
        return True

    def _jump(self, line: Line) -> None:
        if self.outside(f"`{line.op}`") and self.operand(line, "a label"):
            if line.op == "JMP" or self.condition(line.op):
                span = self.span_of(line.start, line.end)
                self.jumps.append((len(self.code), span))
                self.emit(line.op, name=span.text)
        if line.op == "JMP":
            self.define(None)

    def _return(self, line: Line) -> None:
        self.nothing_more(line)
        op = "RET" if line.op == "RETURN" else line.op
        if self.outside(f"`{line.op}`") and (op == "RET" or self.condition(op)):
            self.emit(op)
        if op == "RET":
            self.define(None)

    def _call(self, line: Line) -> None:
        if self.outside(f"`{line.op}`") and self.operand(line, "an instance of a function block"):
            calls.instance(self, line)


def widens(source: Type, target: Type) -> bool:
    """Implicit conversion of single values; enumerations have none."""
    source, target = base(source), base(target)
    return isinstance(source, Elementary) and isinstance(target, Elementary) and functions.widens(source, target)


def common(left: Type, right: Type) -> Type | None:
    """The type in which both sides can be joined."""
    left, right = base(left), base(right)
    if same(left, right):
        return left
    if isinstance(left, Elementary) and isinstance(right, Elementary):
        return functions.common((left, right))
    return None


def _plain(op: str) -> str:
    return op[:-1] if op in ("ANDN", "ORN", "XORN") else op


def _conversion_line(got: Type, wanted: Type, convert: str = "convert it by `") -> str:
    help = conversion_help(got, wanted)
    if not help.startswith("convert it by `"):
        return help
    return help.replace("convert it by `", convert).replace("(...)`", "` on a line before")


def _restored(variable: Variable) -> Variable:
    """A variable that the compiler made once, in printed text: a temporary or a memory again."""
    if not variable.name.upper().startswith("_LDC_") or variable.kind != "local":
        return variable
    return replace(variable, kind="temp" if _TEMPORARY.match(variable.name) else "hidden")


_DEFERRED = frozenset((*LOGIC, "ANDN", "ORN", "XORN", "&", "&N", *ARITHMETIC, *COMPARISON))
_HANDLERS = {
    **dict.fromkeys(_DEFERRED, Reader._operator),
    **dict.fromkeys(("LD", "LDN"), Reader._load),
    **dict.fromkeys(("ST", "STN", "S", "R"), Reader._store),
    **dict.fromkeys(("JMP", "JMPC", "JMPCN"), Reader._jump),
    **dict.fromkeys(("RET", "RETURN", "RETC", "RETCN"), Reader._return),
    **dict.fromkeys(("CAL", "CALC", "CALCN"), Reader._call),
    ")": Reader._close, "NOT": Reader._not,
}
