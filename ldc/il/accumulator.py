"""The accumulator while IL text is read: its type, and literals that wait for theirs."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.il import findings
from ldc.il.program import COMPARISON, LOGIC, Instr
from ldc.library import functions
from ldc.model.type_findings import described
from ldc.model.values import Untyped, natural, same, settle
from ldc.records import entity, field, record, replace
from ldc.source import Span
from ldc.types import REAL, Elementary, Subrange, Type, is_scalar

# After an error: fits everywhere, so that one mistake gives one message.
POISON = Elementary("?", "unknown", 0)


@entity
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
        # Computed from literals: a range holds for results that are stored, not on the way.
        if literal is None:
            type_ = base(type_)
        for index, waiting, typed in self.loose:
            instr = code[index]
            if typed and not allowed(plain(instr.op.rstrip("(")), type_):
                does_not_work(diagnostics, instr.span, instr.op, type_)
                self.set(POISON)
                return False
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


@record
class Open:
    """A parenthesis: the operator that waits, where its instruction is, and what it found."""

    op: str
    index: int
    before: Accumulator
    span: Span


def base(type_: Type | None) -> Type | None:
    """A subrange counts as the type that it is a range of."""
    return type_.base if isinstance(type_, Subrange) else type_


def plain(op: str) -> str:
    """The operator that ``ANDN``, ``ORN`` and ``XORN`` negate the operand of; others as they are."""
    return op[:-1] if op in ("ANDN", "ORN", "XORN") else op


def does_not_work(diagnostics: Diagnostics, span: Span, op: str, type_: Type) -> None:
    """Reports an operator in a type that it does not work in."""
    works = "BOOL and bit strings" if plain(op.rstrip("(")) in (*LOGIC, "NOT") else (
        "integers" if op == "MOD" else "single values" if op.rstrip("(") in COMPARISON else "numbers")
    findings.wrong_types(diagnostics, span, f"`{op}` does not work on {described(type_)}",
                         f"the accumulator holds {described(type_)}",
                         f"it works on {works}" + ("; convert it before" if is_scalar(type_) else ""))


def allowed(op: str, type_: Type) -> bool:
    """Whether the operator works in the type (2nd edition, tables 24, 26, 28 and 30)."""
    kind = type_.kind if isinstance(type_, Elementary) else ""
    if op in ("AND", "OR", "XOR", "NOT"):
        return kind in ("bool", "bits")
    if not is_scalar(type_):
        return False
    if op == "MOD":
        return kind in ("int", "uint")
    if op in ("ADD", "SUB"):
        return kind in ("int", "uint", "real", "time")
    return op not in ("MUL", "DIV") or kind in ("int", "uint", "real")


def widens(source: Type, target: Type) -> bool:
    """Implicit conversion of single values; enumerations have none."""
    source, target = base(source), base(target)
    return (isinstance(source, Elementary) and isinstance(target, Elementary)
            and functions.widens(source, target))


def common(left: Type, right: Type) -> Type | None:
    """The type in which both sides can be joined."""
    left, right = base(left), base(right)
    if same(left, right):
        return left
    if isinstance(left, Elementary) and isinstance(right, Elementary):
        return functions.common((left, right))
    return None
