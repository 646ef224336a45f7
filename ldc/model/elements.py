"""The elements of a rung, typed and resolved: what the edges of a RungGraph carry."""

from __future__ import annotations

from ldc.expr import Expr, Place
from ldc.records import record
from ldc.source import Span
from ldc.symbols import ACTION, Signature
from ldc.types import Type

Net = int


@record
class Contact:
    """``kind``: open closed rising falling (``expr`` is a Load or Const), or expression (any BOOL Expr)."""

    kind: str
    expr: Expr
    span: Span


@record
class Coil:
    """``kind``: normal negated set reset rising falling. Power passes through unchanged."""

    kind: str
    place: Place
    span: Span


@record
class PinIn:
    """An input pin (or in_out) and what it is fed with: an expression (already of ``type``), a net."""

    pin: str
    type: Type
    source: Expr | Net
    span: Span


@record
class PinOut:
    """An output pin (or in_out) and what it feeds; ``type`` is the pin's. A place of a wider type
    gets the value converted."""

    pin: str
    type: Type
    target: Place | Net
    span: Span


@record
class Block:
    """A function block (``instance``) or a function (None) with its pins in declared order.

    ``power_in``/``power_out`` name the pins that the power comes in and leaves by (``EN``/``ENO``
    for functions unless chosen otherwise); None: not wired. They are not among ``inputs`` and
    ``outputs``. Every input of a function but EN is in ``inputs`` or is ``power_in``. The result
    of a function is the pin OUT. ``callee`` is in capitals (an overloaded standard function keeps
    its plain name, ``ADD``). A call of an action is a block too, with EN and ENO like a function; of an
    instance's action, its last input tells which one.
    """

    callee: str
    signature: Signature
    instance: Place | None
    inputs: tuple[PinIn, ...]
    outputs: tuple[PinOut, ...]
    power_in: str | None
    power_out: str | None
    span: Span

    @property
    def is_function(self) -> bool:
        """Whether it has EN and ENO."""
        return self.instance is None or self.is_action

    @property
    def is_action(self) -> bool:
        return self.signature.kind == ACTION


@record
class Jump:
    """``label`` None: RETURN."""

    label: str | None
    span: Span


Element = Contact | Coil | Block | Jump
