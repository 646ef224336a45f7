"""IL text to typed IL: IEC 61131-3, 2nd edition, tables 51 to 53, with the accumulator's type known."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.expr import Place
from ldc.il import calls, findings, function_calls, operators
from ldc.il.accumulator import POISON
from ldc.il.carried import Carried, wanting
from ldc.il.machine import Machine, copied
from ldc.il.program import Unit
from ldc.il.scan import DEFERRED, Line, Mark
from ldc.model import places
from ldc.model.names import PREFIX, suggest
from ldc.model.project import Pou
from ldc.model.type_findings import described
from ldc.patterns import Pattern
from ldc.records import replace
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import BOOL

# Names that the compiler gave to temporaries (``_ldc_t1``, ``_ldc_int_2``); others are memories.
_TEMPORARY = Pattern(r"_ldc_(t\d+|[a-z0-9]+_\d+)\Z", re.IGNORECASE)

_MOST = 1_000


def parse_unit(pou: Pou, scope, diagnostics: Diagnostics) -> Unit | None:
    """The IL of a POU whose body is ``ast.TextBody("IL")``; None when it has errors.

    ``scope`` is the ``model.Scope`` of the POU. Comments ``(* rung "key": title *)``, as the printer
    writes them, divide the code into rungs; without them it is one rung, "body".
    """
    own = Diagnostics()
    unit = Reader(pou, scope, own).unit()
    diagnostics.extend(own)
    return None if own.has_errors else unit


class Reader(Machine):
    """Reads one body, line by line."""

    def __init__(self, pou: Pou, scope, diagnostics: Diagnostics) -> None:
        super().__init__(pou, scope, diagnostics)
        self.labels: dict[str, tuple[str, Span]] = {}
        self.jumps: list[tuple[int, Span]] = []
        self.carried = Carried(set())

    def unit(self) -> Unit:
        lines = list(self.scanner.lines())
        marks = list(reversed(self.scanner.marks))
        self.spelled = {line.label.upper() for line in lines if line.label}
        self.wanting = wanting(lines)
        self.carried = Carried(self.wanting)
        for line, self.next in zip(lines, [*lines[1:], None]):
            while marks and marks[-1].at < (line.label_start if line.label else line.op_start):
                self._mark(marks.pop())
            self._line(line)
            if len(self.diagnostics) > _MOST:  # reading on helps nobody
                break
        while marks:
            self._mark(marks.pop())
        for opened in self.stack:
            self.never_closed(opened.span)
        self._connect()
        signature, variables = self.pou.signature, [_restored(v) for v in self.pou.variables.values()]
        rungs = self.regions.rungs(self.span_of)
        return Unit(signature.kind, signature.name, (*variables, *self.temps), rungs, signature.result,
                    self.pou.title or self._title(), signature.standard)

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
            function_calls.function(self, line)
            return
        if line.arguments >= 0 and not line.closed:
            self.never_closed(self.span_of(line.arguments, line.arguments + 1))
            self.define(POISON)
        elif line.paren and line.op not in DEFERRED and line.op != ")":
            findings.malformed(self.diagnostics, self.at, f"`{line.op}` takes no parentheses",
                               f"write `{line.op} operand`")
            self.define(POISON)
        else:
            handler(self, line)
            if line.closed and line.arguments < 0:
                self.at = self.span_of(line.stop - 1, line.stop)
                operators.closing(self)

    def _label(self, line: Line) -> None:
        self.at = span = self.span_of(line.label_start, line.label_start + len(line.label))
        self.outside("a label")
        known = self.labels.get(line.label.upper())
        if known is not None:
            findings.duplicate_label(self.diagnostics, span, line.label, known[1])
        else:
            self.labels[line.label.upper()] = line.label, span
        kept = self.carried.arrive(self, line.label)
        self.emit("LABEL", name=line.label)
        self.define(None)
        if kept is not None:
            self.load("LD", kept)

    def _load(self, line: Line) -> None:
        if not self.operand(line):
            return
        if line.op == "LD" and (called := calls.input_operator(self, line)):
            return called
        value = self.value(line.start, line.end, whole=line.op == "LD")
        self.load(line.op, value)
        if line.op == "LDN" and value is not None and self.convert_loose(BOOL):
            self.check("NOT", self.acc.type)

    def _store(self, line: Line) -> None:
        if not self.operand(line) or line.op in ("S", "R") and calls.input_operator(self, line):
            return
        place = self.operands.place(line.start, line.end, write=True)
        if not self.use(line.op) or place is None:
            return
        if not copied(place.type) and not self._handed_over(place):
            findings.wrong_types(self.diagnostics, self.at, f"`{place}` takes no value",
                                 f"this is {described(place.type)}", "store to its inputs one by one")
            return
        if line.op in ("S", "R"):
            if place.type != BOOL:
                findings.wrong_types(self.diagnostics, self.at, f"`{line.op}` needs a BOOL",
                                     f"`{place}` is {described(place.type)}",
                                     "set and reset BOOL variables only")
            elif self.condition(line.op):
                self.emit(line.op, place)
            return
        self.store(line.op, place)

    def _handed_over(self, place: Place) -> bool:
        """Whether an instance is stored to a pin or taken back from one, as the compiler prints it, or to or
        from its temporary for a FUNCTION."""
        last = self.code[-1]
        source = last.operand if last.op == "LD" and isinstance(last.operand, Place) else None
        return source is not None and any(map(self._is_lent, (source, place)))

    def _is_lent(self, place: Place) -> bool:
        if not place.steps:
            return place.root.upper().startswith(PREFIX)
        owners = tuple(places.owners(self.scope, place, place.steps))
        return bool(owners) and places.handed_pin(self.scope, *owners[-1]) is not None

    def _jump(self, line: Line) -> None:
        if self.outside(f"`{line.op}`") and self.operand(line, "a label"):
            if line.op == "JMP" or self.condition(line.op):
                span = self.span_of(line.start, line.end)
                self.carried.leave(self, span.text, line.op, span.text.upper() in self.labels)
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


def _restored(variable: Variable) -> Variable:
    """A variable that the compiler made once, in printed text: a temporary or a memory again."""
    if not variable.name.upper().startswith("_LDC_") or variable.kind != "local":
        return variable
    return replace(variable, kind="temp" if _TEMPORARY.match(variable.name) else "hidden")


_HANDLERS = {
    **dict.fromkeys(DEFERRED, operators.operator),
    **dict.fromkeys(("LD", "LDN"), Reader._load),
    **dict.fromkeys(("ST", "STN", "S", "R"), Reader._store),
    **dict.fromkeys(("JMP", "JMPC", "JMPCN"), Reader._jump),
    **dict.fromkeys(("RET", "RETURN", "RETC", "RETCN"), Reader._return),
    **dict.fromkeys(("CAL", "CALC", "CALCN"), Reader._call),
    ")": operators.close, "NOT": operators.negate,
}
