"""Typed expressions and places: what names and operators mean once types are known.

Shared by the model (which makes them), the graph (whose reference evaluator gives them their
meaning) and IL (whose operands are ``Const`` and ``Place``).
"""

from __future__ import annotations

from collections.abc import Iterator

from ldc.records import field, record
from ldc.source import Span
from ldc.types import BOOL, Scalar, Type


@record
class Const:
    """A scalar of a known type (an enumeration value is its number)."""

    value: Scalar
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)


@record
class FieldStep:
    """``.name``: a structure field, or a pin or variable of an instance; declared spelling."""

    name: str


@record
class IndexStep:
    """``[i, j]``; ``bounds`` are those of the array. In IL each index is a Const or a Load."""

    indexes: tuple[Expr, ...]
    bounds: tuple[tuple[int, int], ...]


def strides(bounds: tuple[tuple[int, int], ...]) -> list[int]:
    """How many elements of an array one step of each index is, row-major."""
    made = [1] * len(bounds)
    for i in range(len(bounds) - 2, -1, -1):
        low, high = bounds[i + 1]
        made[i] = made[i + 1] * (high - low + 1)
    return made


@record
class BitStep:
    """``.15`` of a bit string or an integer; always the last step, the place is then BOOL. ``sign``: it is
    the highest bit of a signed integer."""

    bit: int
    sign: bool = False

    @property
    def weight(self) -> int:
        """What the bit adds to the value."""
        return -1 << self.bit if self.sign else 1 << self.bit


Step = FieldStep | IndexStep | BitStep


@record
class Place:
    """Where a value is kept: a variable (declared spelling) and the way into it.

    ``is_global``: a VAR_GLOBAL of the configuration (also when reached by VAR_EXTERNAL) or a
    direct address (``root`` is then the address in capitals, ``%IX0.0``); otherwise a variable
    of the POU. ``type`` is the type of what is reached, ``base_type`` that of the variable.
    """

    root: str
    type: Type
    steps: tuple[Step, ...] = ()
    is_global: bool = False
    span: Span | None = field(default=None, compare=False, repr=False)

    def indexes(self) -> Iterator[Expr]:
        """The indexes on the way."""
        return (index for step in self.steps if type(step) is IndexStep for index in step.indexes)

    def __str__(self) -> str:
        """The place as IEC text, ``a.b[1, i].c``."""
        return self.root + "".join(map(_step_text, self.steps)) if self.steps else self.root


def _step_text(step: Step) -> str:
    match step:
        case FieldStep(name):
            return f".{name}"
        case BitStep(bit):
            return f".{bit}"
        case IndexStep(indexes):
            return f"[{', '.join(_index_text(i) for i in indexes)}]"


def _index_text(index: Expr) -> str:
    match index:
        case Const(value):
            return str(value)
        case Load(place):
            return str(place)
    return "..."


@record
class Load:
    """The value of a place."""

    place: Place
    span: Span | None = field(default=None, compare=False, repr=False)

    @property
    def type(self) -> Type:
        return self.place.type


@record
class Output:
    """An output of a FUNCTION of the project, of ``type``, and the place that takes it. ``both``: a
    VAR_IN_OUT, whose value is among the arguments too, behind the inputs, in the same order."""

    name: str
    type: Type
    place: Place
    both: bool = False


@record
class Apply:
    """A function or operator on values.

    ``op`` is the name of a standard function in capitals (operators too: ADD SUB MUL DIV MOD EXPT
    AND OR XOR NOT GT GE EQ NE LE LT NEG), a conversion (``INT_TO_REAL``), or a FUNCTION of the
    project (capitals). Arguments stand in declared order, defaults filled in, and have exactly the
    types that the function takes: implicit conversions were made explicit. ``type`` is the result's.
    ``outputs``: in statements only, the VAR_OUTPUT and VAR_IN_OUT pins of a FUNCTION of the project. There
    ``op`` may also be AND_THEN or OR_ELSE, whose second argument is evaluated when the first does not decide.
    """

    op: str
    args: tuple[Expr, ...]
    type: Type
    span: Span | None = field(default=None, compare=False, repr=False)
    user: bool = False
    outputs: tuple[Output, ...] = ()


Expr = Const | Load | Apply


def nodes(expr: Expr) -> Iterator[Expr]:
    """The expression and all that it consists of, indexes of places too, in no particular order. A loop,
    since chains may be long."""
    stack = [expr]
    while stack:
        node = stack.pop()
        yield node
        if type(node) is Apply:
            stack += node.args
        elif type(node) is Load and node.place.steps:
            stack += node.place.indexes()


SHORT_CIRCUIT = frozenset(("AND_THEN", "OR_ELSE"))

TRUE = Const(True, BOOL)
