"""Instructions that Structured Text calls: what a rung would do that always has power, as statements."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser import statements as st
from ldc.parser.l5x import instructions, members
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.values import boolean, negated
from ldc.source import Span

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

_CALLED = frozenset("""
    JSR SBR RET COP CPS SIZE SRT SWPB CONCAT MID FIND INSERT DELETE UPPER LOWER DTOS STOD UID UIE IOT
""".split())
"""What of the instructions of the ladder may be called too."""


def called(writer: Writer, instruction: Instruction) -> list[st.Statement] | None:
    """The statements of a call; None when there is none for it in Structured Text (nothing is told then)."""
    name = instruction.name
    if name in members.TABLE:
        return _statements(instructions.written(writer, instruction, members.TABLE[name]))
    if name in instructions.TABLE and name not in _CALLED:
        return None
    return _statements(instructions.write(writer, instruction))


def _statements(items: Sequence[ast.Item]) -> list[st.Statement]:
    """What items in series do under power, one after the other."""
    found: list[st.Statement] = []
    for at, item in enumerate(items):
        match item:
            case ast.Contact():
                expr = negated(item.expr) if item.modifier == "/" else item.expr
                rest = _statements(items[at + 1 :])
                if isinstance(expr, ast.Literal):
                    return found + (rest if expr.value else [])
                arm = st.Arm(expr, tuple(rest), item.span)
                return [*found, st.If((arm,), None, item.span)] if rest else found
            case ast.Branches():
                found += [statement for path in item.paths for statement in _statements(path.items)]
            case ast.Block():
                found.append(_block(item))
            case ast.Coil():
                found.append(st.Assign(item.target, boolean(item.modifier != "R", item.span), item.span))
            case ast.Jump():
                found.append(st.Leave("RETURN", item.span))
    return found


def _block(block: ast.Block) -> st.Statement:
    """A function whose result is stored, or a call."""
    result = next((p for p in block.pins if p.output and p.name == "OUT"), None)
    if block.type == "MOVE" and result is not None:
        value = next(p.value for p in block.pins if not p.output)
        return st.Assign(result.value, value, block.span)
    power = block.power_in if block.power_in is not None else "EN" if block.instance is not None else "_"
    arguments = [*_power(power, block.span), *_arguments(p for p in block.pins if p is not result)]
    callee = block.instance or ast.Name(block.type, block.span)
    if result is None:
        return st.Invoke(callee, tuple(arguments), block.span)
    return st.Assign(result.value, ast.Call(block.type, tuple(arguments), block.span), block.span)


def _power(name: str, span: Span) -> list[ast.Argument]:
    return [ast.Argument(name, boolean(True, span), False, span)] if name != "_" else []


def _arguments(pins: Iterable[ast.Pin]) -> list[ast.Argument]:
    return [ast.Argument(p.name, p.value, p.output, p.span) for p in pins]
