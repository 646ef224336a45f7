"""The statements that IL is brought into for backends of other languages (``ldc.il.structure``)."""

from __future__ import annotations

from ldc.expr import Expr, Place
from ldc.il.program import Unit
from ldc.records import record


@record
class Assign:
    """``target := value``. All statements: ``at`` is the flat position of the instruction."""

    at: int
    target: Place
    value: Expr


@record
class Latch:
    """``IF condition THEN target := value; END_IF``: the instructions S and R."""

    at: int
    target: Place
    condition: Expr
    value: bool


@record
class CallBlock:
    """Runs the function block ``instance``, whose pins were assigned before; ``condition`` None: always."""

    at: int
    instance: Place
    condition: Expr | None = None


@record
class CallFunction:
    """Calls a FUNCTION of the project. ``arguments`` as ``Unit.arguments``; ``result``: a temporary, None
    for a FUNCTION without result; ``outputs``: pins and the temporaries that take them."""

    at: int
    function: Unit
    arguments: tuple[Expr, ...]
    result: Place | None
    outputs: tuple[tuple[str, Place], ...] = ()


@record
class CallNative:
    """Runs the native code of the unit (EXT) on the instance that is executed; ``elapsed``: the time since it
    ran last."""

    at: int
    elapsed: Expr


@record
class Label:
    """Something jumps to the flat position ``at``."""

    at: int


@record
class Goto:
    """Jumps to the label at ``target`` (the length of the code: the end); backward when that is not
    behind ``at``."""

    at: int
    target: int
    condition: Expr | None = None


@record
class Return:
    at: int
    condition: Expr | None = None


Statement = Assign | Latch | CallBlock | CallFunction | CallNative | Label | Goto | Return
