"""XML text to a tree whose nodes know where they stand in it; safe for any input.

A document type is refused, so that there are no entities to expand and nothing to load; size and depth are
bounded. Names lose their prefix: the flavours of TC6 differ in nothing but the namespace.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from html import unescape
from xml.parsers import expat

from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import findings
from ldc.source import SourceFile, Span

MAX_ELEMENTS, MAX_DEPTH = 2_000_000, 200
_HEAD = re.compile(r"""<(?:[^"'>]|"[^"]*"|'[^']*')*+>""")
_MARKUP = re.compile(r"<!\[CDATA\[(.*?)\]\]>|<!--.*?-->|<[^>]*>|([^<]+)", re.DOTALL)
_NUMBER = re.compile(r"[+-]?\d{1,15}(\.\d{1,15})?", re.ASCII)
_ATTRIBUTE = re.compile(r"""=\s*(["'])(.*?)\1""", re.DOTALL)
_INSIDE, _OUTSIDE = re.compile(r"\(\*|\*\)"), re.compile(r"\(\*|//[^\n]*|'(?:[^'$\n]|\$[^\n])*'")
_TEXTUAL = ("ST", "IL", "STContent")
_ENDS_EARLY = "it ends before its elements are closed"


@dataclass(slots=True, eq=False)
class Node:
    """An element: ``start`` and ``end`` enclose it, ``inside`` and ``stop`` what is between its tags.

    Most elements are never asked for more than where they begin, so the rest is looked up in the text.
    ``closing``: where the end tag begins; ``start`` in an element without one.
    """

    document: Document = field(repr=False)
    tag: str
    attributes: dict[str, str]
    start: int
    closing: int = 0
    children: Sequence[Node] = field(default=(), repr=False)
    _inside: int = field(default=-1, repr=False)

    @property
    def inside(self) -> int:
        if self._inside < 0:
            head = _HEAD.match(self.document.source.text, self.start)
            self._inside = head.end() if head else self.start
        return self._inside

    @property
    def stop(self) -> int:
        return self.closing if self.closing != self.start else self.inside

    @property
    def end(self) -> int:
        if self.closing == self.start:
            return self.inside
        return max(self.document.source.text.find(">", self.closing) + 1, self.closing)

    def find(self, *path: str) -> Node | None:
        """The first descendant along a path of tags."""
        node: Node | None = self
        for tag in path:
            for child in node.children:
                if child.tag == tag:
                    node = child
                    break
            else:
                return None
        return node

    def all(self, *tags: str) -> Iterator[Node]:
        return (child for child in self.children if child.tag in tags)

    def descendants(self, *tags: str) -> Iterator[Node]:
        """In the order of the document; those of a matching node are not searched, nor are bodies below
        this node: what is looked for by name stands beside them, and they are nearly all of a file."""
        work = list(reversed(self.children))
        while work:
            node = work.pop()
            if node.tag in tags:
                yield node
            elif node.tag != "body":
                work += reversed(node.children)

    def get(self, name: str) -> str:
        return self.attributes.get(name, "")

    def flag(self, name: str) -> bool:
        return self.get(name).strip().lower() in ("true", "1")

    def number(self, name: str, default: int = 0) -> int:
        """An attribute as a whole number (positions are decimal fractions in some exports)."""
        text = self.get(name).strip()
        return int(float(text)) if _NUMBER.fullmatch(text) else default

    @property
    def span(self) -> Span:
        """The start tag."""
        return Span(self.document.source, self.start, self.inside)

    @property
    def whole(self) -> Span:
        return Span(self.document.source, self.start, self.end)

    def attribute(self, name: str) -> Span:
        """The value of an attribute, between its quotes; in the text where character references are read."""
        head = self.document.source.text[self.start : self.inside]
        found = re.search(rf"""\s{re.escape(name)}\s*=\s*(?:"([^"]*)"|'([^']*)')""", head)
        if found is None:
            return self.span
        start, end = found.span(found.lastindex or 1)
        return self.document.readable(self.start + start, self.start + end)

    @property
    def content(self) -> Span:
        """The text between the tags without the space around it, in the text where references are read."""
        inner = self
        while len(inner.children) == 1 and inner.tag not in _TEXTUAL:
            inner = inner.children[0]
        return _trimmed(self.document.readable(inner.inside, inner.stop))

    @property
    def body(self) -> Span:
        """All that is between the tags, as text, without comments inside of comments."""
        return self.document.readable(self.inside, self.stop, _nests(self.document.source.text, self))


def _trimmed(span: Span) -> Span:
    text = span.text
    start = span.start + len(text) - len(text.lstrip())
    return Span(span.source, min(start, span.end), max(start, span.start + len(text.rstrip())))


class Document:
    """``root`` is None when the text is no XML that can be read (a diagnostic tells)."""

    def __init__(self, source: SourceFile, diagnostics: Diagnostics) -> None:
        self.source = source
        self.root: Node | None = None
        self._plain: SourceFile | None = None
        self._open: list[Node] = []
        self._count = 0
        self._bytes = self._chars = 0
        self._skip = len(source.text) - len(source.text.lstrip())
        self._data = source.text[self._skip :].encode("utf-8", "replace")
        self._ascii = source.text.isascii()
        self._parse(diagnostics)

    def readable(self, start: int, end: int, nests: bool = False) -> Span:
        """A part of the text; where it holds markup or references (or comments that nest), of a twin that
        has them replaced."""
        text = self.source.text
        if not nests and text.find("&", start, end) < 0 and text.find("<", start, end) < 0:
            return Span(self.source, start, end)
        if self._plain is None:
            self._plain = self._twin()
        return Span(self._plain, start, end)

    def _twin(self) -> SourceFile:
        """The same text, as long in every line, with what stands for other characters replaced by them."""
        parts, at, text = [], 0, self.source.text
        for start, end, new in sorted(self._edits()):
            if start >= at:
                parts += (text[at:start], new.ljust(end - start)[: end - start])
                at = end
        return SourceFile(self.source.path, "".join((*parts, text[at:])))

    def _edits(self) -> Iterator[tuple[int, int, str]]:
        """What stands for other characters: where, and for which."""
        work = [self.root] if self.root is not None else []
        while work:
            node = work.pop()
            work += reversed(node.children)
            inside = node.inside
            if "&" in (head := self.source.text[node.start : inside]):
                for match in _ATTRIBUTE.finditer(head):
                    start, end = match.span(2)
                    yield node.start + start, node.start + end, unescape(match[2])
            if not node.children or node.tag in _TEXTUAL:
                raw = self.source.text[inside : node.stop]
                nests = _nests(self.source.text, node)
                if nests or "&" in raw or "<" in raw:
                    plain = _unmarked(node, raw)
                    yield inside, node.stop, _flat(plain) if nests else plain

    # ---- reading

    def _parse(self, diagnostics: Diagnostics) -> None:
        parser = self._parser = expat.ParserCreate("utf-8")
        parser.StartDoctypeDeclHandler = self._doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        try:
            parser.Parse(self._data, True)
        except _Refused as problem:
            at = self._offset(parser.CurrentByteIndex)
            problem.report(diagnostics, Span(self.source, at, at + 1))
            self.root = None
        except expat.ExpatError as error:
            at = min(self._offset(max(0, parser.ErrorByteIndex)), len(self.source.text))
            opened = self._open[-1].span if self._open else None
            findings.not_well_formed(diagnostics, Span(self.source, at, at + 1),
                                     _ENDS_EARLY if at >= len(self.source.text.rstrip()) else
                                     expat.ErrorString(error.code) or "no XML", opened)
            self.root = None

    def _offset(self, at: int) -> int:
        """The character of a byte of the data; asked for in rising order, so all of it costs linear time."""
        if self._ascii:
            return self._skip + at
        if at > self._bytes:
            self._chars += len(self._data[self._bytes : at].decode("utf-8", "ignore"))
            self._bytes = at
        return self._skip + self._chars

    def _doctype(self, *_) -> None:
        start = max(0, self.source.text.find("<!DOCTYPE"))
        raise _Refused(lambda diagnostics, _: findings.document_type(
            diagnostics, Span(self.source, start, start + len("<!DOCTYPE"))))

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > MAX_ELEMENTS or len(self._open) >= MAX_DEPTH:
            deep = len(self._open) >= MAX_DEPTH
            what, limit = ("levels", MAX_DEPTH) if deep else ("elements", MAX_ELEMENTS)
            raise _Refused(lambda diagnostics, span: findings.too_large(diagnostics, span, limit, what))
        at = self._parser.CurrentByteIndex
        tag = name.rpartition(":")[2] if ":" in name else name
        node = Node(self, tag, attributes, self._skip + at if self._ascii else self._offset(at))
        if not self._open:
            self.root = node
        elif not (tag == "relPosition" or (parent := self._open[-1]).tag == "connection"):
            # Bends of wires and places of pins, half of a drawing, mean nothing to us and are let go.
            if parent.children:
                parent.children.append(node)
            else:
                parent.children = [node]
        self._open.append(node)

    def _end(self, _: str) -> None:
        at = self._parser.CurrentByteIndex
        self._open.pop().closing = self._skip + at if self._ascii else self._offset(at)


def _unmarked(node: Node, raw: str) -> str:
    """The text of an element without references and markup, its lines where they were."""
    parts: list[str] = []
    for match in _MARKUP.finditer(raw):
        if match[2] is not None:
            parts.append(unescape(match[2]))
        elif match[1] is not None:
            parts.append(match[1])
        elif node.tag in _TEXTUAL:
            parts.append("\n" * match[0].count("\n"))
    return "".join(parts)


def _nests(text: str, node: Node) -> bool:
    """Whether a comment may begin within another one (cheap; `_flat` decides)."""
    first = text.find("(*", node.inside, node.stop)
    second = text.find("(*", first + 2, node.stop) if first >= 0 else -1
    while second >= 0:
        if text.find("*)", first, second) < 0:
            return True
        first, second = second, text.find("(*", second + 2, node.stop)
    return False


def _flat(text: str) -> str:
    """The text with comments that nest (IEC 61131-3, 3rd edition, 6.3.3) made to single ones of the same
    length. A comment that is closed once less than it is opened stays, and so does the rest."""
    parts: list[str] = []
    at = look = depth = 0
    while (match := (_INSIDE if depth else _OUTSIDE).search(text, look)) is not None:
        look = match.end()
        if match[0] not in ("(*", "*)"):
            continue
        depth += 1 if match[0] == "(*" else -1
        if depth > (match[0] == "(*"):
            parts += (text[at : match.start()], "  ")
            at = look
    return text if depth else "".join((*parts, text[at:]))


class _Refused(Exception):
    def __init__(self, report) -> None:
        super().__init__()
        self.report = report
