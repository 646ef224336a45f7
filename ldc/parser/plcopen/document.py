"""XML text to a tree whose nodes know where they stand in it; safe for any input.

One expression cuts the text into tags; expat says whether it is XML at all (``whole``). A document type is
refused, so that there are no entities to expand and nothing to load; size and depth are bounded. Names lose
their prefix: the flavours of TC6 differ in nothing but the namespace.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from functools import lru_cache, partial

from ldc.beside import Beside
from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import findings, usual, whole
from ldc.parser.plcopen.nesting import flat, nests
from ldc.patterns import Pattern
from ldc.source import SourceFile, Span

MAX_ELEMENTS, MAX_DEPTH = 2_000_000, 200
_LONG = 1_000_000
"""Characters of a text from which on a process of its own pays for what is asked of all of it."""
_TAG = r"""
    <(?: (?:(connection)(?=[ >]) | ([^ \t\n\r/<>!?]++)) {rest} >
             (?: (?<=/>) | () (?>(?:[ \t\n\r]*+<relPosition[ ]{rest}(?<=/)>)*)
                 (?(1)(?>(?:[ \t\n\r]*+<position[ ]{rest}(?<=/)>)*))
                 (?: [^<]*+ () </(?(1)connection|\2)[ \t\n\r]*+> )? )
       | (/)[^<>]++>
       | !--.*?(?:-->|\Z) | !\[CDATA\[.*?(?:\]\]>|\Z) | \?.*?(?:\?>|\Z) )"""
"""A tag, with its end tag when no other element is between; an end tag; what is none. Bends of wires and
places of pins, half of a drawing, mean nothing to us and are passed over. ``rest``: behind the name in a tag."""
_WITHIN = Pattern(r"""=\s*+(?:"[^"<>]*+>|')""")
"""A text in which ``>`` may stand in the value of an attribute: there one has to be read after the other."""
_ANY_TAG = Pattern(_TAG.format(rest=r"""[^<>"']*+(?>(?:"[^<"]*+"[^<>"']*+|'[^<']*+'[^<>"']*+)*)"""),
                   re.DOTALL | re.VERBOSE)
_USUAL_TAG = Pattern(_TAG.format(rest="[^<>]*+"), re.DOTALL | re.VERBOSE)
_WIRE, _NAMED, _OPEN, _LEAF, _END = 1, 2, 3, 4, 5
"""The last group that matched tells which of them it is; a name alone: an element without an end tag."""
_MARKUP = Pattern(r"<!\[CDATA\[(.*?)\]\]>|<!--.*?-->|<[^>]*>|([^<]+)", re.DOTALL)
_BREAK = Pattern(r"<(?:[\w.-]+:)?br[\s/>]|</(?:[\w.-]+:)?(?:p|div)\s*>", re.IGNORECASE)
"""What begins a line in a text that is XHTML. A carriage return stands for it: it ends comments and
instructions, and lines are still counted as the file has them."""
_NUMBER = Pattern(r"[+-]?\d{1,15}(\.\d{1,15})?", re.ASCII)
_ATTRIBUTE = Pattern(r"""\s([^\s=<>"'/]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_USUAL = Pattern(r'''[ ]([^ =<>"/]+)="([^"]*)"''')
"""An attribute as nearly all are written: without apostrophes, references and line ends."""
_CONNECTION = Pattern(r"""<connection (?:refLocalId="(\w++)"(?: formalParameter="(\w*+)")?/?>|[^<>]*+>)""")
_PLACE = Pattern(r"""x="(\d{1,15})" y="(\d{1,15})"/""", re.ASCII)
_CDATA = "<![CDATA["
_BLANK = Pattern(r"\r\n|[\t\n\r]")
_TEXTUAL = ("ST", "IL", "STContent")
_FULL = ("body", *usual.TAGS)
_ENDS_EARLY = "it ends before its elements are closed"


class Node:
    """An element: ``start`` and ``end`` enclose it, ``inside`` and ``stop`` what is between its tags.

    ``closing``: where the end tag begins; ``start`` in an element without one. Attributes are looked up in
    the text when somebody asks for one: most elements of a drawing are never asked. ``usual``: what is in a
    contact, coil, rail or variable that is written as usual; its children are read when somebody asks.
    """

    __slots__ = ("document", "tag", "start", "inside", "closing", "usual", "_children", "_attributes")

    def __init__(self, document: Document, tag: str, start: int, inside: int, closing: int,
                 attributes: dict[str, str] | None = None) -> None:
        self.document, self.tag, self.start, self.inside, self.closing = document, tag, start, inside, closing
        self.usual: re.Match[str] | None = None
        self._children: Sequence[Node] | None = ()
        self._attributes = attributes

    @property
    def children(self) -> Sequence[Node]:
        found = self._children
        if found is None:
            found = self._children = self.document.parts(self)
        return found

    @children.setter
    def children(self, children: Sequence[Node]) -> None:
        self._children = children

    def like(self, tag: str, children: Sequence[Node], attributes: dict[str, str] | None = None) -> Node:
        """An element at the same place with another tag, other children and perhaps attributes."""
        made = Node(self.document, tag, self.start, self.inside, self.closing,
                    self._attributes if attributes is None else attributes)
        made.children = children
        return made

    @property
    def attributes(self) -> dict[str, str]:
        found = self._attributes
        if found is None:
            found = self._attributes = _attributes(self.document.source.text[self.start : self.inside])
        return found

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
        """In the order of the document; those of a matching node are not searched, nor are bodies and variables
        below this node: what is looked for by name stands beside them, and they are nearly all of a file."""
        work = list(reversed(self.children))
        while work:
            node = work.pop()
            if node.tag in tags:
                yield node
            elif node.tag not in _FULL and node.children:
                work += reversed(node.children)

    def get(self, name: str) -> str:
        found = self._attributes
        return (self.attributes if found is None else found).get(name, "")

    def flag(self, name: str) -> bool:
        text = self.get(name)
        return text not in ("", "false") and text.strip().lower() in ("true", "1")

    def number(self, name: str, default: int = 0) -> int:
        """An attribute as a whole number (positions are decimal fractions in some exports)."""
        return _number(self.get(name), default)

    @property
    def position(self) -> tuple[int, int]:
        """Where it is drawn: y, x; (0, 0) when that is not said."""
        if self.usual is not None:
            place = self.usual[usual.PLACE] or ""
            if (plain := _PLACE.fullmatch(place)) is not None:
                return int(plain[2]), int(plain[1])
            at = _attributes(f" {place}")
            return _number(at.get("y", "")), _number(at.get("x", ""))
        at = self.find("position")
        return (at.number("y"), at.number("x")) if at is not None else (0, 0)

    def wires(self) -> list[tuple[str, str]]:
        """The connections to its input: the localId of an element, the name of its output."""
        if self.usual is not None:
            found = _CONNECTION.findall(self.document.source.text, *self.usual.span(usual.WIRES))
            if all([id_ for id_, _ in found]):
                return found
        return [(wire.get("refLocalId").strip(), wire.get("formalParameter").strip())
                for wire in self.connections()]

    def connections(self) -> Iterator[Node]:
        """The same as elements. A few files give an element several inputs, of which any feeds it."""
        return (wire for point in self.all("connectionPointIn") for wire in point.all("connection"))

    def words(self, tag: str) -> Span | None:
        """The text of a child, or None when there is none."""
        if self.usual is None:
            child = self.find(tag)
            return child.content if child is not None else None
        text = self.usual[usual.WORDS] if tag == "variable" else None
        if text is None:
            return None
        start, words = self.usual.start(usual.WORDS), text.strip()
        start += len(text) - len(text.lstrip()) if len(words) < len(text) else 0
        return Span(self.document.source, start, start + len(words))

    @property
    def span(self) -> Span:
        """The start tag."""
        return Span(self.document.source, self.start, self.inside)

    @property
    def whole(self) -> Span:
        return Span(self.document.source, self.start, self.end)

    def attribute(self, name: str) -> Span:
        """The value of an attribute, between its quotes; in the text where character references are read."""
        text = self.document.source.text
        plain = text.find(f' {name}="', self.start, self.inside)
        if plain == self.start + 1 + len(self.tag):  # the first one, as usual
            plain += len(name) + 3
            return self.document.readable(plain, text.find('"', plain))
        for found in _ATTRIBUTE.finditer(text, self.start, self.inside):
            if found[1] == name:
                return self.document.readable(*found.span(found.lastindex))
        return self.span

    @property
    def content(self) -> Span:
        """The text between the tags without the space around it, in the text where references are read."""
        inner = self
        while len(inner.children) == 1 and inner.tag not in _TEXTUAL:
            inner = inner.children[0]
        span = self.document.readable(inner.inside, inner.stop)
        text = span.text
        words = text.strip()
        if len(words) == len(text):
            return span
        start = span.start + len(text) - len(text.lstrip())
        return Span(span.source, min(start, span.end), max(start, span.start + len(text.rstrip())))

    @property
    def body(self) -> Span:
        """All that is between the tags, as text, without comments inside of comments."""
        nested = nests(self.document.source.text, self.inside, self.stop)
        span = self.document.readable(self.inside, self.stop, nested)
        blanks = len(span.text) - len(span.text.lstrip(" "))
        return Span(span.source, span.start + blanks, span.end)


class Document:
    """``root`` is None when the text is no XML that can be read (a diagnostic tells). ``names``: those of its
    attributes (`whole.names`)."""

    def __init__(self, source: SourceFile, diagnostics: Diagnostics) -> None:
        self.source = source
        self._plain: SourceFile | None = None
        text = source.text
        with Beside(partial(whole.asked, text), pays=len(text) >= _LONG) as asked:
            roots, stack, refused = self._tree(0, len(text))
            fault, self.names = asked.result() if refused is None else (whole.fault(text, refused), frozenset())
        self.root = roots[0] if roots and fault is None else None
        if fault is not None:
            self._tell(fault, diagnostics)
        if self.root is not None and refused is not None:
            deep = len(stack) >= MAX_DEPTH
            what, limit = ("levels", MAX_DEPTH) if deep else ("elements", MAX_ELEMENTS)
            findings.too_large(diagnostics, Span(source, refused, refused + 1), limit, what)
            self.root = None

    def readable(self, start: int, end: int, nested: bool = False) -> Span:
        """A part of the text; where it holds markup or references (or comments that nest), of a twin that
        has them replaced."""
        text = self.source.text
        if not nested and text.find("&", start, end) < 0 and text.find("<", start, end) < 0:
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
                    (begin, end), value = match.span(match.lastindex), match[match.lastindex]
                    yield node.start + begin, node.start + end, _unescaped(value)
            if not node.children or node.tag in _TEXTUAL:
                raw = self.source.text[inside : node.stop]
                nested = nests(self.source.text, inside, node.stop)
                if nested or "&" in raw or "<" in raw:
                    plain = _unmarked(raw)
                    yield inside, node.stop, flat(plain) if nested else plain

    # ---- reading

    def parts(self, node: Node) -> list[Node]:
        """What is in an element that was passed over."""
        return self._tree(node.inside, node.closing)[0]

    def _tree(self, at: int, end: int) -> tuple[list[Node], list[Node], int | None]:
        """The elements in a part of the text that are in no other one, those that are open where it ends, and
        the tag at which there are too many (of a text that is no XML: something)."""
        roots: list[Node] = []
        siblings = roots
        stack: list[tuple[Node, list[Node]]] = []
        tags: dict[str | None, str] = {None: "connection"}
        count, refused = 0, None
        text = self.source.text
        plain = _WITHIN.search(text) is None
        search = (_USUAL_TAG if plain else _ANY_TAG).search
        while (match := search(text, at, end)) is not None:
            at, kind = match.end(), match.lastindex
            if kind == _END:
                if not stack:
                    break
                node, siblings = stack.pop()
                node.closing = match.start()
                continue
            if kind is None:
                continue
            start = match.start()
            count += 1
            if count > MAX_ELEMENTS or len(stack) >= MAX_DEPTH:
                refused = start
                break
            name = match[2]
            tag = tags.get(name)
            if tag is None:
                tag = tags[name] = name.rpartition(":")[2]
            if kind <= _NAMED:
                node = Node(self, tag, start, match.end(), start)
            else:
                node = Node(self, tag, start, match.start(_OPEN), match.start(_LEAF))
            if tag != "relPosition":
                siblings.append(node)
            if kind == _OPEN and plain and (rest := usual.inside(name, text, at, end)) is not None:
                node.usual, node._children, node.closing = rest, None, rest.end() - len(name) - 3
                at = rest.end()
            elif kind == _OPEN:
                stack.append((node, siblings))
                siblings = []
                if tag != "connection":
                    node.children = siblings
        return roots, [node for node, _ in stack], refused

    def _tell(self, fault: tuple[int, str], diagnostics: Diagnostics) -> None:
        """Tells where the text ceases to be XML."""
        (at, what), text = fault, self.source.text
        if what == whole.DOCTYPE:
            findings.document_type(diagnostics, Span(self.source, at, at + len(whole.DOCTYPE)))
            return
        _, opened, _ = self._tree(0, at)
        what = _ENDS_EARLY if at >= len(text.rstrip()) else what
        findings.not_well_formed(diagnostics, Span(self.source, at, at + 1), what,
                                 opened[-1].span if opened else None)


def _attributes(head: str) -> dict[str, str]:
    """The attributes in a start tag. Those of elements of a drawing are often the same but for the localId."""
    before, _, id_ = head.partition(' localId="')
    id_, _, behind = id_.partition('"')
    if not id_.isalnum() or "'" in before:
        return _parsed(head)
    return {"localId": id_, **_again(before, behind)}


@lru_cache(maxsize=4096)
def _again(before: str, behind: str) -> dict[str, str]:
    return _parsed(before + behind)


def _parsed(head: str) -> dict[str, str]:
    found = dict(_USUAL.findall(head))
    if 2 * len(found) != head.count('"') or "'" in head or "&" in head or not head.isprintable():
        found = {name: _unescaped(_BLANK.sub(" ", one or other))
                 for name, one, other in _ATTRIBUTE.findall(head)}
    return found


def _number(text: str, default: int = 0) -> int:
    if not text:
        return default
    text = text.strip()
    if len(text) < 16 and text.isascii() and text.isdecimal():
        return int(text)
    return int(float(text)) if _NUMBER.fullmatch(text) else default


def _unmarked(raw: str) -> str:
    """The text of an element without references and markup, its lines where they were. Each line begins in
    the column where it did, so that places are those of the file."""
    parts: list[str] = []
    begun = False
    for match in _MARKUP.finditer(raw):
        text = _unescaped(match[2]) if match[2] is not None else match[1]
        if text is None:
            before, end, last = match[0].rpartition("\n")
            begun = begun and not end
            broken = "\r" if _BREAK.match(match[0]) is not None else ""
            if not begun:
                parts.append("\n" * before.count("\n") + end + (broken + " " * len(last))[: len(last)])
            else:
                parts.append(broken)
            continue
        if match[2] is None and not begun:
            parts.append(" " * len(_CDATA))
        parts.append(text)
        _, end, last = text.rpartition("\n")
        begun = bool(last.strip()) or begun and not end
    return "".join(parts)


def _unescaped(text: str) -> str:
    """With the characters that references stand for."""
    if "&" not in text:
        return text
    from html import unescape  # slow to load, and few drawings have any

    return unescape(text)
