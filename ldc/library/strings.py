"""Character string functions (IEC 61131-3, 2nd edition, table 29). Positions count from 1.

The values are bytes (STRING) or text (WSTRING); results are cut to the length of the result type.
"""

from __future__ import annotations

from collections.abc import Callable

from ldc.library.table import Function, Shape

GROUP = "29 character strings"


def _left(text, count):
    return text[: max(count, 0)]


def _right(text, count):
    return text[max(len(text) - count, 0) :] if count > 0 else text[:0]


def _mid(text, count, at):
    return text[at - 1 : at - 1 + count] if at >= 1 and count > 0 else text[:0]


def _concat(*texts):
    return texts[0][:0].join(texts)


def _insert(text, other, at):
    at = max(at, 0)
    return text[:at] + other + text[at:]


def _delete(text, count, at):
    return text[: at - 1] + text[at - 1 + count :] if at >= 1 and count > 0 else text


def _replace(text, other, count, at):
    if not 1 <= at <= len(text):
        return text
    return text[: at - 1] + other + text[at - 1 + max(count, 0) :]


def _find(text, other):
    return text.find(other) + 1 if other else 0


def _cut(function: Callable) -> Callable:
    def meaning(types, result):
        length = result.length
        return lambda *values: function(*values)[:length]

    return meaning


def _row(name: str, names: tuple[str, ...], inputs: tuple[str, ...], result: str, function, note: str,
         extends: bool = False) -> Function:
    return Function(name, names, (Shape(inputs, result, extends),), _cut(function), GROUP, note)


_S, _I = "ANY_STRING", "own ANY_INT"

FUNCTIONS = (
    Function("LEN", ("IN",), (Shape((_S,), "INT"),), lambda types, result: len, GROUP,
             "number of characters"),
    _row("LEFT", ("IN", "L"), (_S, _I), "same", _left, "the first L characters; none when L is below 1"),
    _row("RIGHT", ("IN", "L"), (_S, _I), "same", _right, "the last L characters; none when L is below 1"),
    _row("MID", ("IN", "L", "P"), (_S, _I, _I), "same", _mid,
         "L characters from the P-th on; none when L or P is below 1 or P is past the end"),
    _row("CONCAT", ("IN1", "IN2"), (_S, _S), "sum", _concat, "one after the other", True),
    _row("INSERT", ("IN1", "IN2", "P"), (_S, _S, _I), "sum", _insert,
         "IN2 put into IN1 after its P-th character; P below 0 counts as 0, past the end as the end"),
    _row("DELETE", ("IN", "L", "P"), (_S, _I, _I), "same", _delete,
         "IN without L characters from the P-th on; unchanged when L or P is below 1 or P is past the end"),
    _row("REPLACE", ("IN1", "IN2", "L", "P"), (_S, _S, _I, _I), "sum", _replace,
         "L characters of IN1 from the P-th on replaced by IN2; unchanged when P is not in IN1; L below 0 "
         "counts as 0"),
    Function("FIND", ("IN1", "IN2"), (Shape((_S, _S), "INT"),), lambda types, result: _find, GROUP,
             "where IN2 first begins in IN1; 0 when it does not occur or is empty"),
)
