"""Statements of Structured Text with all names known and all types checked, as IL is made of them."""

from __future__ import annotations

from ldc.expr import Expr, Place
from ldc.model.elements import Block
from ldc.records import record
from ldc.source import Span
from ldc.types import Elementary


@record
class Assign:
    """``value`` is of the place's type, or of one that is stored alike."""

    place: Place
    value: Expr
    span: Span


@record
class Call:
    """A function block, or a function whose result goes to an output pin or nowhere. No power pins."""

    block: Block
    span: Span


@record
class Arm:
    condition: Expr
    body: tuple[Action, ...]


@record
class If:
    arms: tuple[Arm, ...]
    otherwise: tuple[Action, ...]
    span: Span


@record
class Choice:
    """``labels``: inclusive ranges of numbers, no two of one CASE overlap."""

    labels: tuple[tuple[int, int], ...]
    body: tuple[Action, ...]


@record
class Case:
    selector: Expr
    choices: tuple[Choice, ...]
    otherwise: tuple[Action, ...]
    span: Span


@record
class For:
    """``start`` is of the variable's type, ``step`` of the integer type ``number`` that it counts as,
    ``stop`` of that or a wider one; a constant ``step`` is not 0. ``down``: the step is the amount that is
    subtracted (of an unsigned variable). ``free``: the body cannot change the variable."""

    place: Place
    start: Expr
    stop: Expr
    step: Expr
    number: Elementary
    down: bool
    free: bool
    body: tuple[Action, ...]
    span: Span


@record
class While:
    condition: Expr
    body: tuple[Action, ...]
    span: Span


@record
class Repeat:
    body: tuple[Action, ...]
    condition: Expr
    span: Span


@record
class Leave:
    """``word``: EXIT and CONTINUE are for the innermost loop around it, RETURN for the POU."""

    word: str
    span: Span


Action = Assign | Call | If | Case | For | While | Repeat | Leave
