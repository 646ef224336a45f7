"""What execution costs in virtual time: a model by groups of IL instructions (docs/scheduling.md).

Times are nanoseconds. Each instruction of a rung counts once, taken or not; a call counts with all that it
calls. A further pass of a loop counts when it is made (``ldc.il.pieces.Passes``).
"""

from __future__ import annotations

from itertools import pairwise

from ldc.il.flat import flatten
from ldc.il.pieces import pieces
from ldc.il.program import ARITHMETIC, COMPARISON, Instr, Program, Unit
from ldc.records import record
from ldc.types import Instance

_GROUPS = {f"{op}{end}": group for group, ops in (("arithmetic", ARITHMETIC), ("comparison", COMPARISON))
           for op in ops for end in ("", "(")}
_FREE = frozenset(("LABEL", ")"))
_CALLS = frozenset(("CAL", "CALC", "CALCN", "EXT"))


@record
class Cost:
    """The table ``[cost]``: ``instruction`` is what an IL instruction costs unless its group says otherwise:
    ``arithmetic``, ``comparison``, ``function`` (one of the library), ``call`` (of a block, a FUNCTION of the
    project or native code, beside what is in it); ``task``: to begin an execution of a task.

    ``frame`` and ``word``: what a transfer costs each of its two processors, and each word of 32 bits in it;
    ``algorithm``: an execution of an algorithm on a slave, unless ``algorithms`` has its unit, in
    capitals."""

    instruction: int = 0
    arithmetic: int | None = None
    comparison: int | None = None
    function: int | None = None
    call: int | None = None
    task: int = 0
    frame: int = 0
    word: int = 0
    algorithm: int = 0
    algorithms: tuple[tuple[str, int], ...] = ()

    def of_unit(self, unit: str) -> int:
        """What an execution of an algorithm costs."""
        return next((cost for name, cost in self.algorithms if name == unit.upper()), self.algorithm)


class Costs:
    """What the units of a program cost."""

    def __init__(self, program: Program, cost: Cost) -> None:
        self.cost = cost
        self._plain = cost.instruction
        self._group = {name: cost.instruction if given is None else given for name, given in (
            ("arithmetic", cost.arithmetic), ("comparison", cost.comparison),
            ("function", cost.function), ("call", cost.call))}
        self._units: dict[str, int] = {}
        self._functions = {u.name.upper() for u in program.units if u.kind == "FUNCTION"}
        for unit in program.units:  # callees come before callers
            self._units[unit.name.upper()] = sum(self.rungs(unit))

    def rungs(self, unit: Unit) -> tuple[int, ...]:
        """What each rung of a unit costs."""
        return tuple(sum(map(self.one, rung.code)) for rung in unit.rungs)

    def pieces(self, unit: Unit) -> dict[int, int]:
        """What each piece of a unit costs, by the number of its first rung."""
        rungs, begins = self.rungs(unit), pieces(flatten(unit)).rungs
        return {begin: sum(rungs[begin:end]) for begin, end in pairwise((*begins, len(rungs)))}

    def one(self, instr: Instr) -> int:
        """What an instruction costs, with all that it calls."""
        op = instr.op
        if op in _FREE:
            return 0
        if op in _CALLS:
            type_ = instr.operand.type
            inside = self._units.get(type_.pou.upper(), 0) if isinstance(type_, Instance) else 0
            return self._group["call"] + inside
        if op == "FN":
            name = instr.name.upper()
            if name in self._functions:
                return self._group["call"] + self._units.get(name, 0)
            return self._group["function"]
        group = _GROUPS.get(op)
        return self._plain if group is None else self._group[group]
