"""The accumulator while IL text is read: its type, and literals that wait for theirs."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ldc.diagnostics import Diagnostics
from ldc.il.program import Instr
from ldc.model.values import Untyped, natural, settle
from ldc.source import Span
from ldc.types import REAL, Elementary, Subrange, Type

# After an error: fits everywhere, so that one mistake gives one message.
POISON = Elementary("?", "unknown", 0)


@dataclass(slots=True)
class Accumulator:
    """``type`` None and nothing ``loose``: undefined.

    ``loose``: places in the code (index, literal or None for a type alone, whether the instruction
    takes the type) whose literals have no type until what follows decides it. ``literal``: the
    accumulator holds just this literal.
    """

    type: Type | None = None
    loose: list[tuple[int, Untyped | None, bool]] = field(default_factory=list)
    literal: Untyped | None = None

    @property
    def defined(self) -> bool:
        return self.type is not None or bool(self.loose)

    @property
    def poisoned(self) -> bool:
        return self.type is POISON

    def set(self, type_: Type | None) -> None:
        self.type, self.loose, self.literal = base(type_), [], None

    def natural(self) -> Elementary:
        """The type that the waiting literals take when nothing decides."""
        values = [literal.value for _, literal, _ in self.loose if literal is not None]
        if any(isinstance(v, float) for v in values):
            return REAL
        types = [natural(v) for v in values]
        return max(types, key=lambda t: t.bits)

    def settle(self, type_: Type, code: list[Instr], diagnostics: Diagnostics) -> bool:
        """Gives the waiting literals their type; False after an error."""
        literal = self.literal
        for index, waiting, typed in self.loose:
            instr = code[index]
            if waiting is not None:
                const = settle(waiting, type_, diagnostics)
                if const is None:
                    self.set(POISON)
                    return False
                instr = replace(instr, operand=const)
            code[index] = replace(instr, type=base(type_)) if typed else instr
        self.set(type_)
        self.literal = literal
        return True


@dataclass(frozen=True, slots=True)
class Open:
    """A parenthesis: the operator that waits, where its instruction is, and what it found."""

    op: str
    index: int
    before: Accumulator
    span: Span


def base(type_: Type | None) -> Type | None:
    """A subrange counts as the type that it is a range of."""
    return type_.base if isinstance(type_, Subrange) else type_


def allowed(op: str, type_: Type) -> bool:
    """Whether the operator works in the type (2nd edition, tables 24, 26, 28 and 30)."""
    kind = type_.kind if isinstance(type_, Elementary) else ""
    if op in ("AND", "OR", "XOR", "NOT"):
        return kind in ("bool", "bits")
    if op == "MOD":
        return kind in ("int", "uint")
    if op in ("ADD", "SUB"):
        return kind in ("int", "uint", "real", "time")
    return op not in ("MUL", "DIV") or kind in ("int", "uint", "real")
