"""Statements of Structured Text with all names known and all types checked, as IL is made of them."""

from __future__ import annotations

from dataclasses import dataclass

from ldc.expr import Expr, Place
from ldc.model.elements import Block
from ldc.source import Span


@dataclass(frozen=True, slots=True)
class Assign:
    """``value`` is of the place's type, or of one that is stored alike."""

    place: Place
    value: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Call:
    """A function block, or a function whose result goes to an output pin or nowhere. No power pins."""

    block: Block
    span: Span


@dataclass(frozen=True, slots=True)
class Arm:
    condition: Expr
    body: tuple[Action, ...]


@dataclass(frozen=True, slots=True)
class If:
    arms: tuple[Arm, ...]
    otherwise: tuple[Action, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Choice:
    """``labels``: inclusive ranges of numbers, no two of one CASE overlap."""

    labels: tuple[tuple[int, int], ...]
    body: tuple[Action, ...]


@dataclass(frozen=True, slots=True)
class Case:
    selector: Expr
    choices: tuple[Choice, ...]
    otherwise: tuple[Action, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class For:
    """``start``, ``stop`` and ``step`` are of the variable's integer type; a constant ``step`` is not 0.
    ``down``: the step is the amount that is subtracted (of an unsigned variable). ``free``: the body
    cannot change the variable."""

    place: Place
    start: Expr
    stop: Expr
    step: Expr
    down: bool
    free: bool
    body: tuple[Action, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class While:
    condition: Expr
    body: tuple[Action, ...]
    span: Span


@dataclass(frozen=True, slots=True)
class Repeat:
    body: tuple[Action, ...]
    condition: Expr
    span: Span


@dataclass(frozen=True, slots=True)
class Leave:
    """``word``: EXIT and CONTINUE are for the innermost loop around it, RETURN for the POU."""

    word: str
    span: Span


Action = Assign | Call | If | Case | For | While | Repeat | Leave
