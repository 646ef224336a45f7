"""JSON to values that know where they stand; safe for any input.

Depth and number of values are bounded. What no reader asks for (how the editor draws handles) is not kept,
since it is most of such a file.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass

from ldc.parser.foreign import Reading
from ldc.source import SourceFile, Span

MAX_VALUES, MAX_DEPTH = 5_000_000, 100
_UNUSED = frozenset(("handles", "style", "measured", "glbPosition", "relPosition"))
_TOKEN = re.compile(
    r"""[ \t\r\n]*+(?:([{}\[\]:,])|("(?>(?:[^"\\\x00-\x1f]|\\.)*)")|(-?\d[\d.eE+-]{0,40})|(true|false|null))""")
_LONE = re.compile("[\ud800-\udfff]")
_LINE_ENDS = re.compile("[\r\n\v\f\x1c-\x1e\x85\u2028\u2029]")
_WORDS = {"true": True, "false": False, "null": None}


@dataclass(slots=True, eq=False)
class Value:
    """``data``: dict of Value, list of Value, str, float, bool or None; ``start`` and ``end`` enclose it."""

    data: dict[str, Value] | list[Value] | str | float | bool | None
    start: int
    end: int = 0

    def get(self, *path: str) -> Value | None:
        """The value along a path of keys; None when there is none."""
        value: Value | None = self
        for key in path:
            value = value.data.get(key) if value is not None and isinstance(value.data, dict) else None
        return value

    def text(self, *path: str) -> str:
        """The string along a path of keys; empty when there is none."""
        value = self.get(*path)
        return value.data if value is not None and isinstance(value.data, str) else ""

    def number(self, *path: str) -> int:
        """The number along a path of keys as a whole one; 0 when there is none."""
        value = self.get(*path)
        data = value.data if value is not None else None
        return int(data) if isinstance(data, float) and abs(data) < 1e15 else 0

    def flag(self, *path: str) -> bool:
        value = self.get(*path)
        return value is not None and value.data is True

    def items(self, *path: str) -> list[Value]:
        """The objects in the list along a path of keys."""
        value = self.get(*path)
        found = value.data if value is not None and isinstance(value.data, list) else []
        return [item for item in found if isinstance(item.data, dict)]


class JsonText:
    """One JSON text inside of a source, from ``start`` on. ``root`` is None when it cannot be read
    (a finding tells); ``end`` is behind it."""

    def __init__(self, reading: Reading, start: int) -> None:
        self.reading, self.source = reading, reading.source
        self.end = start
        self._escaped: list[tuple[int, int, str]] = []
        self._plain: SourceFile | None = None
        self.root = self._parse(start)

    # ---- places

    def span(self, value: Value) -> Span:
        return Span(self.source, value.start, value.end)

    def readable(self, start: int, stop: int) -> Span:
        """The characters of a string, in a twin of the text in which escapes are replaced."""
        if self.source.text.find("\\", start, stop) < 0:
            return Span(self.source, start, stop)
        return Span(self.plain, start, stop)

    def content(self, value: Value) -> Span:
        """What is between the quotes of a string."""
        return self.readable(value.start + 1, max(value.start + 1, value.end - 1))

    @property
    def plain(self) -> SourceFile:
        """The same text, of the same length, with the strings as they are meant, each in one line."""
        if not self._escaped:
            return self.source
        if self._plain is None:
            parts, at, text = [], 0, self.source.text
            for start, end, new in self._escaped:
                line = _LINE_ENDS.sub(" ", new)
                parts += (text[at:start], line.ljust(end - start)[: end - start])
                at = end
            self._plain = SourceFile(self.source.path, "".join((*parts, text[at:])))
        return self._plain

    # ---- reading

    def _parse(self, at: int) -> Value | None:
        """One pass with a stack of what is open; ``keys`` has the key that waits for its value."""
        text, match = self.source.text, _TOKEN.match
        opened: list[Value] = []
        keys: list[str | None] = []
        expected, count = "value", 0
        while True:
            token = match(text, at)
            if token is None:
                return self._wrong(at)
            at, end = token.start(token.lastindex), token.end()
            mark = token[1]
            if mark == "," and expected == "more":
                expected = "key" if isinstance(opened[-1].data, dict) else "value"
            elif mark == ":" and expected == "colon":
                expected = "value"
            elif token[2] and expected in ("key", "key or end"):
                keys[-1], expected = self._string(token[2], at, end), "colon"
                if keys[-1] is None:
                    return None
            elif mark and mark in "}]" and (expected in ("more", "key or end", "value or end")) and (
                    (mark == "}") == isinstance(opened[-1].data, dict)):
                value = opened.pop()
                keys.pop()
                value.end = end
                if not opened:
                    self.end = end
                    return value
                expected = "more"
            elif expected in ("value", "value or end") and (mark is None or mark in "{["):
                count += 1
                if count > MAX_VALUES or len(opened) >= MAX_DEPTH:
                    deep = len(opened) >= MAX_DEPTH
                    self.reading.too_large(Span(self.source, at, end), MAX_DEPTH if deep else MAX_VALUES,
                                           "levels of JSON" if deep else "JSON values")
                    return None
                value = self._value(token, at, end)
                if value is None:
                    return None
                if opened:
                    holder = opened[-1].data
                    if isinstance(holder, list):
                        holder.append(value)
                    elif keys[-1] not in _UNUSED:
                        holder[keys[-1]] = value
                if mark:
                    opened.append(value)
                    keys.append(None)
                    expected = "key or end" if mark == "{" else "value or end"
                elif not opened:
                    self.end = end
                    return value
                else:
                    expected = "more"
            else:
                return self._wrong(at)
            at = end

    def _value(self, token: re.Match, at: int, end: int) -> Value | None:
        if token[1]:
            return Value({} if token[1] == "{" else [], at)
        if token[2]:
            data = self._string(token[2], at, end)
            return None if data is None else Value(data, at, end)
        if token[3]:
            try:
                return Value(float(token[3]), at, end)
            except ValueError:
                return self._wrong(at)
        return Value(_WORDS[token[4]], at, end)

    def _string(self, text: str, start: int, end: int) -> str | None:
        if "\\" not in text:
            return text[1:-1]
        try:
            found = json.loads(text)
        except ValueError:
            self._wrong(start)
            return None
        found = _LONE.sub("\ufffd", found)
        self._escaped.append((start + 1, end - 1, found))
        return found

    def _wrong(self, at: int) -> None:
        text = self.source.text
        at += len(text[at:at + 1000]) - len(text[at:at + 1000].lstrip())
        if at >= len(text.rstrip()):
            end = len(text.rstrip())
            self.reading.malformed(Span(self.source, max(0, end - 1), end), "the JSON ends too early",
                                   "the file ends here")
        else:
            self.reading.malformed(Span(self.source, at, at + 1), "this is no JSON", "not expected here")
