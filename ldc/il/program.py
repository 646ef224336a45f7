"""Typed IL: what the compiler produces and every engine starts from (DESIGN section 4).

The machine is that of IEC 61131-3 section 3.2: one typed accumulator (the current result), deferred
operators with parentheses, jumps to labels of the same POU.
"""

from __future__ import annotations

from functools import cached_property

from ldc.expr import Const, Place
from ldc.records import field, record
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import BOOL, Type

Operand = Const | Place

# Mnemonics by group; N forms negate the operand, "(" forms open a deferred operation. The numbers
# of the image are positions in OPCODES: append only.
LOGIC = ("AND", "OR", "XOR")
ARITHMETIC = ("ADD", "SUB", "MUL", "DIV", "MOD")
STORES = ("ST", "STN", "S", "R")
COMPARISON = ("GT", "GE", "EQ", "NE", "LE", "LT")
OPCODES: tuple[str, ...] = (
    "LD", "LDN", "ST", "STN", "S", "R",
    "AND", "OR", "XOR", "ANDN", "ORN", "XORN",
    "AND(", "OR(", "XOR(", "ANDN(", "ORN(", "XORN(",
    "ADD", "SUB", "MUL", "DIV", "MOD", "ADD(", "SUB(", "MUL(", "DIV(", "MOD(",
    "GT", "GE", "EQ", "NE", "LE", "LT", "GT(", "GE(", "EQ(", "NE(", "LE(", "LT(",
    ")", "NOT",
    "JMP", "JMPC", "JMPCN", "LABEL", "CAL", "CALC", "CALCN", "RET", "RETC", "RETCN", "FN",
    "EXT", "ACT",
)
NUMBER: dict[str, int] = {op: n for n, op in enumerate(OPCODES)}


@record
class Instr:
    """One instruction.

    ``op``: of OPCODES. ``operand``: what it works on (``AND(`` with an operand loads it first, as in
    ``AND( a``; without one the next LD does). ``name``: the label of JMP*/LABEL; the function of FN.
    ``type``: the type that the operation works in: of the value loaded or stored, of both sides of
    an arithmetic operator or comparison (a comparison leaves BOOL), of the result of FN.
    FN: the accumulator is the first argument, ``args`` are the others, ``outputs`` take the
    VAR_OUTPUTs of a FUNCTION of the project by name; a FUNCTION without inputs ignores the accumulator.
    The argument of a VAR_IN_OUT is the place that its output goes to as well.
    JMPC jumps, CALC calls and RETC returns when the accumulator is TRUE, CN forms when it is FALSE;
    none of them changes the accumulator. After CAL and LABEL it is undefined.
    CAL calls the instance in ``operand``; pins were stored by ST before.
    ACT executes the action ``name`` of the POU; units are complete without it (``ldc.il.performed``).
    EXT runs the native code of the unit (``Unit.external``) on the instance that is executed; after it
    the accumulator is undefined.
    ``element``: index of the rung's element that it comes from, -1 for none.
    """

    op: str
    operand: Operand | None = None
    type: Type = BOOL
    name: str = ""
    args: tuple[Operand, ...] = ()
    outputs: tuple[tuple[str, Place], ...] = ()
    element: int = field(default=-1, compare=False)
    span: Span | None = field(default=None, compare=False, repr=False)


@record
class RungCode:
    """The IL of one rung (or of one statement list). ``key`` is the rung's identity; ``label`` is the
    label at its start when something jumps to it; ``proof``: "proof", "check" or "none"."""

    key: str
    code: tuple[Instr, ...]
    label: str | None = None
    title: str | None = None
    name: str | None = None
    proof: str = "none"
    span: Span | None = field(default=None, compare=False, repr=False)


@record
class External:
    """Native code of a component (DESIGN section 6): ``void entry(const in *, out *, state *, uint32_t
    dt_us)``.

    Members of ``in`` are the unit's inputs, of ``out`` its outputs without ``ENO``, of ``state`` its locals,
    in the order and with the names of the unit's variables. ``digest``: SHA-256 over sources, header and
    flags. ``processor``: master or slave; ``period``: nanoseconds between two executions on a slave, or None.
    """

    component: str
    entry: str
    language: str
    digest: str
    processor: str = "master"
    period: int | None = None


@record
class Pace:
    """What makes a function block the proxy of an algorithm: slave 1 .. 4 executes the unit of its name in
    ``Program.algorithms`` by itself, every ``period`` nanoseconds. ``ranges``: least and greatest value of
    pins that have such, None: no bound."""

    slave: int
    period: int
    ranges: tuple[tuple[str, float | None, float | None], ...] = ()


@record
class Unit:
    """A POU in IL. ``variables`` holds pins, locals, hidden memories and temporaries in order. The
    result of a FUNCTION is kept in a local variable with the function's own name. ``pace``: it stands for an
    algorithm of a slave, and has the pins that go between the two."""

    kind: str
    name: str
    variables: tuple[Variable, ...]
    rungs: tuple[RungCode, ...]
    result: Type | None = None
    title: str | None = None
    standard: bool = False
    external: External | None = None
    pace: Pace | None = None

    @property
    def arguments(self) -> tuple[Variable, ...]:
        """What FN gives to a FUNCTION, in this order: its inputs, then its in_outs."""
        return tuple(v for kind in ("input", "in_out") for v in self.variables if v.kind == kind)

    @cached_property
    def changed(self) -> tuple[Variable, ...]:
        """The arguments that it changes, of which it needs copies: in_outs, and inputs that it writes."""
        written = {place.root.upper() for rung in self.rungs for instr in rung.code
                   for place in (*((instr.operand,) if instr.op in STORES else ()),
                                 *(place for _, place in instr.outputs))}
        return tuple(v for v in self.arguments if v.kind == "in_out" or v.name.upper() in written)


@record
class Task:
    """``interval``: nanoseconds between two executions, None: every scan or, with ``single``, at its
    rising edge. ``priority``: 0 is the most urgent. ``watchdog``: backward jumps allowed in one
    execution before the task is stopped."""

    name: str
    interval: int | None = None
    priority: int = 0
    single: Place | None = None
    watchdog: int = 1_000_000


@record
class Run:
    """A program instance: ``name`` is its path, ``pou`` what it runs, ``task`` by which task."""

    name: str
    pou: str
    task: str


@record
class Resource:
    """One processor's share. ``safe``: output address or global/instance path to the value that it
    takes when a task stops by a fault; outputs without one take FALSE/0."""

    name: str
    processor: str
    tasks: tuple[Task, ...]
    runs: tuple[Run, ...]


@record
class Program:
    """A whole compiled project: units (callees before callers), globals and how they run. ``algorithms``:
    what slaves execute by themselves, each under the name of its proxy in ``units``."""

    units: tuple[Unit, ...]
    types: tuple[Type, ...]
    globals: tuple[Variable, ...]
    resources: tuple[Resource, ...]
    safe: tuple[tuple[str, object], ...] = ()
    name: str = ""
    algorithms: tuple[Unit, ...] = ()

    def unit(self, name: str) -> Unit:
        key = name.upper()
        return next(u for u in self.units if u.name.upper() == key)
