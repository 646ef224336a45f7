"""XML text to a tree whose nodes know where they stand in it; safe for any input.

A document type is refused, so that there are no entities to expand and nothing to load; size and depth are
bounded. Names lose their prefix: the flavours of TC6 differ in nothing but the namespace.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from html import unescape
from xml.parsers import expat

from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import findings
from ldc.source import SourceFile, Span

MAX_ELEMENTS, MAX_DEPTH = 500_000, 200
_HEAD = re.compile(r"""<(?:[^"'>]|"[^"]*"|'[^']*')*+>""")
_MARKUP = re.compile(r"<!\[CDATA\[(.*?)\]\]>|<!--.*?-->|<[^>]*>|([^<]+)", re.DOTALL)
_TEXTUAL = ("ST", "IL")
_ENDS_EARLY = "it ends before its elements are closed"


@dataclass(slots=True, eq=False)
class Node:
    """An element: ``start`` and ``end`` enclose it, ``inside`` and ``stop`` what is between its tags."""

    document: Document = field(repr=False)
    tag: str
    attributes: dict[str, str]
    start: int
    inside: int
    stop: int = 0
    end: int = 0
    children: list[Node] = field(default_factory=list, repr=False)

    def find(self, *path: str) -> Node | None:
        """The first descendant along a path of tags."""
        node: Node | None = self
        for tag in path:
            node = next((child for child in node.children if child.tag == tag), None)
            if node is None:
                return None
        return node

    def all(self, *tags: str) -> Iterator[Node]:
        return (child for child in self.children if child.tag in tags)

    def descendants(self, *tags: str) -> Iterator[Node]:
        """In the order of the document; those of a matching node are not searched."""
        work = list(reversed(self.children))
        while work:
            node = work.pop()
            if node.tag in tags:
                yield node
            else:
                work += reversed(node.children)

    def get(self, name: str) -> str:
        return self.attributes.get(name, "")

    def flag(self, name: str) -> bool:
        return self.get(name).strip().lower() in ("true", "1")

    def number(self, name: str, default: int = 0) -> int:
        """An attribute as a whole number (positions are decimal fractions in some exports)."""
        text = self.get(name).strip()
        return int(float(text)) if re.fullmatch(r"[+-]?\d{1,15}(\.\d{1,15})?", text, re.ASCII) else default

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
        """All that is between the tags, as text."""
        return self.document.readable(self.inside, self.stop)


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
        self._edits: list[tuple[int, int, str]] = []
        self._open: list[Node] = []
        self._count = 0
        self._bytes = self._chars = 0
        self._skip = len(source.text) - len(source.text.lstrip())
        self._data = source.text[self._skip :].encode("utf-8", "replace")
        self._ascii = source.text.isascii()
        self._parse(diagnostics)

    def readable(self, start: int, end: int) -> Span:
        """A part of the text; where it holds markup or references, of a twin that has them replaced."""
        text = self.source.text
        if text.find("&", start, end) < 0 and text.find("<", start, end) < 0:
            return Span(self.source, start, end)
        if self._plain is None:
            self._plain = self._twin()
        return Span(self._plain, start, end)

    def _twin(self) -> SourceFile:
        """The same text, as long in every line, with what stands for other characters replaced by them."""
        parts, at, text = [], 0, self.source.text
        for start, end, new in sorted(self._edits):
            if start >= at:
                parts += (text[at:start], new.ljust(end - start)[: end - start])
                at = end
        return SourceFile(self.source.path, "".join((*parts, text[at:])))

    # ---- reading

    def _parse(self, diagnostics: Diagnostics) -> None:
        parser = self._parser = expat.ParserCreate("utf-8")
        parser.StartDoctypeDeclHandler = self._doctype
        parser.StartElementHandler = self._start
        parser.EndElementHandler = self._end
        try:
            parser.Parse(self._data, True)
        except _Refused as problem:
            at = self._offset()
            problem.report(diagnostics, Span(self.source, at, at + 1))
            self.root = None
        except expat.ExpatError as error:
            at = min(self._offset(max(0, parser.ErrorByteIndex)), len(self.source.text))
            opened = self._open[-1].span if self._open else None
            findings.not_well_formed(diagnostics, Span(self.source, at, at + 1),
                                     _ENDS_EARLY if at >= len(self.source.text.rstrip()) else
                                     expat.ErrorString(error.code) or "no XML", opened)
            self.root = None

    def _offset(self, at: int | None = None) -> int:
        """The character of a byte of the data; asked for in rising order, so all of it costs linear time."""
        at = self._parser.CurrentByteIndex if at is None else at
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
        start = self._offset()
        head = _HEAD.match(self.source.text, start)
        node = Node(self, name.rpartition(":")[2], attributes, start, head.end() if head else start)
        if self._open:
            self._open[-1].children.append(node)
        else:
            self.root = node
        self._open.append(node)
        if "&" in self.source.text[start : node.inside]:
            self._attributes(node)

    def _attributes(self, node: Node) -> None:
        head = self.source.text[node.start : node.inside]
        for match in re.finditer(r"""=\s*(["'])(.*?)\1""", head, re.DOTALL):
            start, end = match.span(2)
            self._edits.append((node.start + start, node.start + end, unescape(match[2])))

    def _end(self, _: str) -> None:
        node, text = self._open.pop(), self.source.text
        at = self._offset()
        closed = text.startswith("</", at)
        node.stop = at if closed else node.inside
        node.end = max(text.find(">", at) + 1, at) if closed else node.inside
        raw = text[node.inside : node.stop]
        if not node.children or node.tag in _TEXTUAL:
            if "&" in raw or "<" in raw:
                self._edit(node, raw)

    def _edit(self, node: Node, raw: str) -> None:
        """Replace references and take away markup, so that lines stay where they are."""
        parts: list[str] = []
        for match in _MARKUP.finditer(raw):
            if match[2] is not None:
                new = unescape(match[2])
            elif match[1] is not None:
                new = match[1]
            else:
                new = "\n" * match[0].count("\n") if node.tag in _TEXTUAL else ""
            parts.append(new)
        self._edits.append((node.inside, node.stop, "".join(parts)))


class _Refused(Exception):
    def __init__(self, report) -> None:
        super().__init__()
        self.report = report
