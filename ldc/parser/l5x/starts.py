"""Values at the start: the decorated data of tags, and what the controller changes before its first scan."""

from __future__ import annotations

import re
from collections.abc import Iterator
from math import isfinite

from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.l5x.scope import Tag
from ldc.parser.l5x.types import (
    BOOL, TIME, WIDTHS, Array, Atom, Structure, Text, Type, inner, is_integer, is_large, is_real,
)
from ldc.parser.l5x.values import boolean, real_text, wrapped
from ldc.parser.plcopen.document import Node
from ldc.source import Span

_NUMBER = re.compile(r"(?:(2|8|10|16)#)?([+-]?[0-9A-Fa-f_]+)\Z")
_ESCAPE = re.compile(r"\$([0-9A-Fa-f]{2}|.)", re.DOTALL)
_SIGNS = {"L": "\n", "N": "\r\n", "P": "\f", "R": "\r", "T": "\t"}
_MAX = 1_000_000
STRING_FORMAT = "String"
# A structure is a dict by name in capitals, an array a dict by indexes; what is not in it is zero.


def told(node: Node, *tags: str) -> Node | None:
    """The data of a tag in a form that is read."""
    found = node.all(*tags or ("Data",))
    return next((n for n in found if n.get("Format") in ("Decorated", STRING_FORMAT)), None)


def initial(tag: Tag, reading: Reading) -> ast.Initial | None:
    """The initial value of the variable; None when it is all zero."""
    if tag.type is None or is_large(tag.type):
        return None
    found = _default(tag.type, tag.data, reading)
    for way, number in tag.starts.items():
        found = _put(tag.type, found, way, number)
    return _written(tag.type, found, tag.span)


def _default(type_: Type, node: Node | None, reading: Reading) -> object:
    """The value that ``node`` tells; without one that of the type (Add-On Instructions have some)."""
    found = _read(type_, node, reading) if node is not None else None
    return _completed(type_, found, reading)


def _completed(type_: Type, found: object, reading: Reading) -> object:
    """With the values that the type itself gives to members that are not told."""
    if isinstance(type_, Array) and isinstance(type_.element, Structure):
        cells = dict(found) if isinstance(found, dict) else {}
        if _has_own(type_.element, {}):
            cells = {at: _completed(type_.element, cells.get(at), reading) for at in _indexes(type_.sizes)}
        return cells
    if not isinstance(type_, Structure):
        return found
    members = dict(found) if isinstance(found, dict) else {}
    for key, member in type_.members.items():
        if member.alias or member.type is None:
            continue
        if key not in members and member.data is not None:
            members[key] = _default(member.type, member.data, reading)
        elif _has_own(member.type, {}):
            members[key] = _completed(member.type, members.get(key), reading)
    for way, number in type_.starts.items():
        members = _put(type_, members, way, number)
    return members


def _has_own(type_: Type | None, known: dict[int, bool]) -> bool:
    """Whether variables of the type begin with other values than zero. ``known``: by structure."""
    held = inner(type_)
    if held is None:
        return False
    if id(held) not in known:
        known[id(held)] = bool(held.starts) or any(
            m.data is not None or _has_own(m.type, known) for m in held.members.values())
    return known[id(held)]


def _indexes(sizes: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    total = 1
    for size in sizes:
        total *= size
    for flat in range(min(total, _MAX)):
        at = []
        for size in reversed(sizes):
            flat, rest = divmod(flat, size)
            at.append(rest)
        yield tuple(reversed(at))


def _put(type_: Type | None, value: object, way: tuple, number: object) -> object:
    """The value with another one at a place inside of it."""
    if not way:
        return number
    step, rest = way[0], way[1:]
    if isinstance(step, str) and step.startswith("."):
        bit = 1 << int(step[1:])
        whole = value if isinstance(value, int) else 0
        whole = whole | bit if number else whole & ~bit
        return wrapped(whole, WIDTHS[type_.name], type_.name.startswith("U")) if is_integer(type_) else whole
    part = type_.element if isinstance(type_, Array) else (
        type_.members[step].type if isinstance(type_, Structure) and step in type_.members else None)
    if part is None:
        return value
    cells = dict(value) if isinstance(value, dict) else {}
    cells[step] = _put(part, cells.get(step), rest, number)
    return cells


# ---- reading ----------------------------------------------------------------------------------


def _read(type_: Type, node: Node, reading: Reading) -> object:
    """The value that an element tells: a Data, DataValue, Structure, Array or one of their parts."""
    holder = node.tag in ("Data", "DefaultData") and node.get("Format") != STRING_FORMAT
    if holder or node.tag == "Element" and not node.get("Value") and len(node.children) == 1:
        return _read(type_, node.children[0], reading) if node.children else None
    if isinstance(type_, Text):
        return _text(type_, node, reading)
    if isinstance(type_, Array):
        found = {}
        for child in node.all("Element"):
            numbers = re.findall(r"\d{1,9}", child.get("Index"))
            if len(numbers) == len(type_.sizes) and type_.element is not None:
                value = _read(type_.element, child, reading)
                if value:
                    found[tuple(map(int, numbers))] = value
        return found
    if isinstance(type_, Structure):
        found = {}
        for child in node.children:
            member = type_.members.get(child.get("Name").upper())
            if member is None or member.type is None:
                continue
            value = _read(member.type, child, reading)
            if not member.alias:
                found[child.get("Name").upper()] = value
            else:
                whole, _, bit = member.alias.upper().partition(".")
                found = _put(type_, found, (whole, f".{bit}"), value)
        return found
    return _scalar(type_, node, reading)


def _scalar(type_: Atom, node: Node, reading: Reading) -> object:
    text = node.get("Value").strip()
    if not text:
        return None
    found: object = None
    match = _NUMBER.match(text)
    try:
        if is_real(type_):
            found = float(text)
            found = found if isfinite(found) else None
        elif type_ == BOOL and text.lower() in ("true", "false"):
            found = text.lower() == "true"
        elif match is not None and len(text) < 80:
            found = int(match[2].replace("_", ""), int(match[1] or 10))
    except ValueError:
        found = None
    if found is None:
        reading.left_out(node.attribute("Value"), f"the value `{text[:40]}` at the start",
                         f"it is no {type_.name} that is read; the tag begins with 0")
    elif type_.name in WIDTHS:
        found = wrapped(found, WIDTHS[type_.name], type_.name.startswith("U"))
    return bool(found) if type_ == BOOL else found


def _text(type_: Text, node: Node, reading: Reading) -> bytes:
    data = next((child for child in node.children if child.get("Name").upper() == "DATA"), None)
    if node.get("Format") == STRING_FORMAT:
        data = node
    length = next((child.number("Value", -1) for child in node.children
                   if child.get("Name").upper() == "LEN"), -1)
    if data is None:
        return b""
    text = data.content.text.strip()
    if len(text) >= 2 and text[0] == text[-1] == "'":
        text = text[1:-1]
    found = _ESCAPE.sub(_sign, text).encode("latin-1", "replace")
    return found[: length if length >= 0 else type_.length][: type_.length]


def _sign(match: re.Match) -> str:
    word = match[1]
    return chr(int(word, 16)) if len(word) == 2 else _SIGNS.get(word.upper(), word)


# ---- writing ----------------------------------------------------------------------------------


def _written(type_: Type | None, value: object, span: Span) -> ast.Initial | None:
    """The value as it stands in a declaration; None when it is zero."""
    if isinstance(type_, Structure):
        fields = tuple((m.name, written) for key, m in type_.members.items()
                       if isinstance(value, dict)
                       and (written := _written(m.type, value.get(key), span)) is not None)
        return ast.Aggregate((), fields, span) if fields else None
    if isinstance(type_, Array):
        return _array(type_, value, span)
    return _constant(type_, value, span) if value else None


def _array(type_: Array, value: object, span: Span) -> ast.Initial | None:
    items: list[tuple[int, ast.Initial]] = []
    cells = value if isinstance(value, dict) else {}
    strides = [1]
    for size in reversed(type_.sizes[1:]):
        strides.insert(0, strides[0] * size)
    placed = {}
    for at, cell in cells.items():
        written = _written(type_.element, cell, span)
        if written is not None and all(i < size for i, size in zip(at, type_.sizes, strict=True)):
            placed[sum(i * stride for i, stride in zip(at, strides, strict=True))] = written
    after = 0
    for flat, cell in sorted(placed.items(), key=lambda pair: pair[0]):
        if flat > after:
            items.append((flat - after, _zero(type_.element, span)))
        items.append((1, cell))
        after = flat + 1
    return ast.Aggregate(tuple(items), (), span) if items else None


def _zero(type_: Type | None, span: Span) -> ast.Initial:
    if isinstance(type_, Array):
        count = 1
        for size in type_.sizes:
            count *= size
        return ast.Aggregate(((count, _zero(type_.element, span)),), (), span)
    if isinstance(type_, Structure):
        first = next((m for m in type_.members.values() if not m.alias), None)
        return ast.Aggregate((), ((first.name, _zero(first.type, span)),) if first else (), span)
    return _constant(type_, None, span)


def _constant(type_: Type | None, value: object, span: Span) -> ast.Literal:
    if isinstance(type_, Text):
        text = (value or b"").decode("latin-1")
        return ast.Literal(value or b"", None, f"'{_quoted(text)}'", span)
    if type_ == BOOL:
        return boolean(bool(value), span)
    if type_ == TIME:
        return ast.Literal(0, "TIME", "T#0s", span)
    if is_real(type_):
        number = float(value or 0.0)
        return ast.Literal(number, None, real_text(number), span)
    return ast.Literal(value or 0, None, str(value or 0), span)


def _quoted(text: str) -> str:
    return "".join(f"${ord(c):02X}" if c in "$'" or not " " <= c <= "~" else c for c in text)
