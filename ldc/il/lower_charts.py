"""The code of a chart: control and bodies one after the other; a body that is off is jumped over.

A body keeps the code that it has by itself. RETURN in it becomes a jump behind it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from ldc.il.emit import Emitter
from ldc.il.lower_statements import lower_together
from ldc.il.program import COMPARISON, Instr, RungCode
from ldc.model.chart_control import Control, Guarded
from ldc.records import replace
from ldc.symbols import Variable
from ldc.types import BOOL

_RETURNS = {"RET": "JMP", "RETC": "JMPC", "RETCN": "JMPCN"}
_LOADS = frozenset(("LD", "LDN", "AND", "ANDN", "OR", "ORN", "XOR", "XORN", "NOT", "ST", "STN", "S", "R",
                    "FN"))
_NAMED = frozenset(("JMP", "JMPC", "JMPCN", "LABEL"))


class ChartCode:
    """Collects ``rungs`` and ``temps``. ``taken``: keys and labels of the bodies, which no other gets."""

    def __init__(self, taken: Iterable[str], max_paren_depth: int | None) -> None:
        self.rungs: list[RungCode] = []
        self.temps: dict[str, Variable] = {}
        self._taken = {name.upper() for name in taken}
        self._labels: set[str] = set()
        self._depth = max_paren_depth
        self._number = 0
        self._label: str | None = None

    def control(self, part: Control) -> None:
        key = self.key()
        code, temps = lower_together(key, part.actions, self._depth)
        self.temps.update((t.name, t) for t in temps)
        self._add(RungCode(key, code, None, part.title, span=part.span))

    def guarded(self, part: Guarded, body: Sequence[RungCode]) -> None:
        key = self.key()
        emit, end = Emitter(key, self._depth), f"_ldc_{key}_end"
        emit.span = part.span
        emit.value(part.when)
        emit.put("JMPCN", name=end)
        self._add(RungCode(key, emit.finish(), None, part.title, span=part.span))
        self.temps.update(emit.temps)
        for code in self._own(body, key, end):
            self._add(code)
        self._label = end
        if part.result is not None and body and _leaves_bool(body[-1].code):
            last = self.rungs[-1]
            store = Instr("ST", part.result, BOOL, span=part.span)
            self.rungs[-1] = replace(last, code=(*last.code, store))

    def finish(self) -> tuple[RungCode, ...]:
        if self._label is not None:
            self._add(RungCode(self.key(), (Instr("RET"),), None))
        return tuple(self.rungs)

    def key(self) -> str:
        """A key that no rung has."""
        while True:
            self._number += 1
            key = f"sfc{self._number}"
            if key.upper() not in self._taken:
                return key

    def _add(self, code: RungCode) -> None:
        """Code that the jump over the body before leads to, when there is one."""
        if self._label is not None and code.label is not None:
            self.rungs.append(RungCode(self.key(), (), self._label))
        elif self._label is not None:
            code = replace(code, label=self._label)
        self._label = None
        self.rungs.append(code)

    def _own(self, body: Sequence[RungCode], key: str, end: str) -> Iterable[RungCode]:
        """The code with jumps instead of RET, and with labels that no other body has."""
        found = [code.label for code in body if code.label] + [
            i.name for code in body for i in code.code if i.op == "LABEL"]
        renamed = {label.upper(): f"{label}_{key}" for label in found if label.upper() in self._labels}
        self._labels.update(renamed.get(label.upper(), label).upper() for label in found)

        def own(instr: Instr) -> Instr:
            if instr.op in _RETURNS:
                return replace(instr, op=_RETURNS[instr.op], name=end)
            if instr.op in _NAMED and instr.name.upper() in renamed:
                return replace(instr, name=renamed[instr.name.upper()])
            return instr

        for code in body:
            label = code.label and renamed.get(code.label.upper(), code.label)
            yield replace(code, code=tuple(map(own, code.code)), label=label)


def _leaves_bool(code: Sequence[Instr]) -> bool:
    """Whether the accumulator surely holds a BOOL at the end of the code."""
    if not code:
        return False
    last = code[-1]
    if last.op in COMPARISON:
        return True
    if last.op != ")":
        return last.op in _LOADS and last.type == BOOL
    depth = 0
    for instr in reversed(code):
        depth += (instr.op == ")") - (instr.op[-1] == "(")
        if depth == 0:
            return instr.op[:-1] in COMPARISON or instr.type == BOOL
    return False
