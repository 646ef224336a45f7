"""Statements of Structured Text as they were written (IEC 61131-3, 2nd edition, 3.3.2), each with its span.

An expression that could not be read is None; what was wrong was told. Blocks nest 100 deep at most.
"""

from __future__ import annotations

from ldc.parser.ast import Argument, Expr
from ldc.records import record
from ldc.source import Span


@record
class Assign:
    """``target := value``."""

    target: Expr
    value: Expr
    span: Span


@record
class Invoke:
    """``callee(arguments)``: an instance of a function block, or a function whose result nobody takes."""

    callee: Expr
    arguments: tuple[Argument, ...]
    span: Span


@record
class Arm:
    """``IF condition THEN`` or ``ELSIF condition THEN`` (``head``) with what it leads to."""

    condition: Expr | None
    body: tuple[Statement, ...]
    head: Span


@record
class Otherwise:
    """``ELSE`` (``head``) with what it leads to."""

    body: tuple[Statement, ...]
    head: Span


@record
class If:
    arms: tuple[Arm, ...]
    otherwise: Otherwise | None
    span: Span


@record
class Label:
    """A value of a CASE, or the range ``low..high``."""

    low: Expr
    high: Expr | None
    span: Span


@record
class Choice:
    """``labels:`` (``head``) with what it leads to."""

    labels: tuple[Label, ...]
    body: tuple[Statement, ...]
    head: Span


@record
class Case:
    """``CASE selector OF`` (``head``)."""

    selector: Expr | None
    choices: tuple[Choice, ...]
    otherwise: Otherwise | None
    head: Span
    span: Span


@record
class ForHead:
    """``variable := start TO stop BY step``; without BY ``step`` is None."""

    variable: Expr
    start: Expr
    stop: Expr
    step: Expr | None
    span: Span


@record
class For:
    """``head_span`` goes from FOR to DO."""

    head: ForHead | None
    body: tuple[Statement, ...]
    head_span: Span
    span: Span


@record
class While:
    """``WHILE condition DO`` (``head``)."""

    condition: Expr | None
    body: tuple[Statement, ...]
    head: Span
    span: Span


@record
class Repeat:
    """``REPEAT`` (``head``) until ``UNTIL condition END_REPEAT`` (``tail``)."""

    body: tuple[Statement, ...]
    condition: Expr | None
    head: Span
    tail: Span
    span: Span


@record
class Leave:
    """``word``: EXIT CONTINUE RETURN."""

    word: str
    span: Span


@record
class Empty:
    """A semicolon alone."""

    span: Span


Statement = Assign | Invoke | If | Case | For | While | Repeat | Leave | Empty


@record
class StatementBody:
    """The body of a POU in Structured Text; ``span`` reaches from the declarations to the END."""

    statements: tuple[Statement, ...]
    span: Span
