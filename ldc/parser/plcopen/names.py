"""Names of other editors that are words of the language here: a variable `step`, a field `time`, a function
block called like a standard one.

Such a name gets an underscore behind it wherever the file says it, in declarations, drawings and texts; the
file is read from a twin that says so. It stays where the word means something else: in a literal
(`TIME#1s`), in a string or a comment, as an elementary type. Words of statements (`IF`, `NOT`) and operators
are no names in any editor's text, so they are renamed where they stand alone or behind a dot only.
"""

from __future__ import annotations

import re
from bisect import bisect_left
from collections.abc import Iterator

from ldc.diagnostics import Diagnostics
from ldc.library import blocks
from ldc.library.functions import is_function
from ldc.parser.foreign import RESERVED, Reading
from ldc.parser.plcopen.document import Document, Node
from ldc.patterns import Pattern
from ldc.source import SourceFile
from ldc.types import ELEMENTARY

_STATEMENTS = frozenset(
    "IF THEN ELSE ELSIF END_IF CASE OF END_CASE FOR TO BY DO END_FOR WHILE END_WHILE REPEAT UNTIL END_REPEAT "
    "EXIT RETURN AND OR XOR NOT MOD ADD SUB MUL DIV GT GE EQ NE LE LT".split())
_TYPES = frozenset((*ELEMENTARY, "STRING", "WSTRING"))
_DECLARE = ("variable", "value", "step", "action", "transition", "Variable", "Member", "Enumerator",
            "Action")
_POUS = ("pou", "dataType", "Program", "FunctionBlock", "Function", "DataTypeDecl")
"""Of TC6; with a capital, of IEC 61131-10."""
_TYPED = ("derived", "block", "pouInstance", "FbdObject", "ProgramInstance")
_ATTRIBUTES = ("name", "formalParameter", "instanceName", "targetName", "indicator", "duration", "value",
               "lower", "upper", "length", "single", "member", "typeName", "type", "parameterName", "operand",
               "operand1", "operand2", "identifier")
_TEXTS = ("variable", "expression", "ST", "IL", "InterfaceAsPlainText", "textDeclaration", "TypeName")
_SPELLED = Pattern(r"""name\s*=\s*["']\s*(\w+)\s*["']""")
_DECLARING = Pattern(rf"<(?:[\w.-]+:)?({'|'.join((*_DECLARE, *_POUS))})\s[^<>]*\Z")
"""Found from the attribute back to its tag: few of the tags of a drawing have a name."""
_WORDS = Pattern(r"[A-Za-z_]\w*", re.ASCII)
_QUOTE = r"""(?:'|"|&apos;|&quot;|&\#39;|&\#34;)"""
_CODE = Pattern(rf"""
    \(\* (?: .*?\*\) | .* ) | //[^\r\n]*
  | (?P<quote>{_QUOTE}) (?>(?: \$[^\n] | [^$\n'"&]++ | (?!(?P=quote))[^$\n] )*) (?P=quote)
  | </?[\w:.-]+(?:\s+[\w:.-]+\s*=\s*(?:"[^"]*"|'[^']*'))*\s*/?> | &[#\w]+; | <!\[CDATA\[
  | (?P<word> (?<![\w.\#%])[A-Za-z_]\w*+(?!\#) ) | [.\#]\s*(?P<member>[A-Za-z_]\w*)""",
                   re.ASCII | re.DOTALL | re.VERBOSE)
"""A name, alone or behind a dot or the name of an enumeration; or what has none in it."""
_ATTRIBUTE = Pattern(r"""\s([^\s=<>"'/]+)\s*=\s*["']([^"']*)["']""")


def legal(source: SourceFile, reading: Reading) -> SourceFile:
    """The text with names that are legal here; the source itself when they are. Each new name is a remark."""
    declared = [(tag, word) for tag, word in dict.fromkeys(_declared(source.text)) if _is_awkward(word, tag)]
    if not declared:
        return source
    root = Document(source, Diagnostics()).root
    return source if root is None else _Names(root, declared, reading).twin(source)


def _declared(text: str) -> Iterator[tuple[str, str]]:
    """The names that a file gives, each with its tag."""
    for found in _SPELLED.finditer(text):
        at = found.start()
        if text[at - 1].isspace():
            tag = _DECLARING.match(text, max(text.rfind("<", 0, at), 0), at)
            if tag is not None:
                yield tag[1], found[1]


def _is_awkward(word: str, tag: str) -> bool:
    key = word.upper()
    if key in ("TRUE", "FALSE"):
        return False
    standard = tag in _POUS and (is_function(key) or key in blocks.names()) and key not in _STATEMENTS
    return key in RESERVED or standard


class _Names:
    """``ends``: by name in capitals, what comes behind it; ``pous``: those that are POUs or types; ``said``:
    where such words may be."""

    def __init__(self, root: Node, declared: list[tuple[str, str]], reading: Reading) -> None:
        self.root, self.reading = root, reading
        taken = set(map(str.upper, _WORDS.findall(reading.source.text)))
        self.ends: dict[str, str] = {}
        self.pous = {word.upper() for tag, word in declared if tag in _POUS}
        for _, word in declared:
            self.ends.setdefault(word.upper(), _ending(word, taken))
        self.told: set[str] = set()
        words = re.compile("|".join(map(re.escape, self.ends)), re.IGNORECASE)
        self.said = [found.start() for found in words.finditer(root.document.source.text)]

    def twin(self, source: SourceFile) -> SourceFile:
        parts, at = [], 0
        for start, end, new in sorted(self._edits()):
            parts += (source.text[at:start], new)
            at = end
        return SourceFile(source.path, "".join((*parts, source.text[at:])))

    def _edits(self) -> Iterator[tuple[int, int, str]]:
        """What becomes another name: where, and which."""
        work = [self.root]
        while work:
            node = work.pop()
            work += reversed(node.children)
            text = node.document.source.text
            heads = _ATTRIBUTE.finditer(text, node.start, node.inside)
            for found in heads if self._may_have(node.start, node.inside) else ():
                if found[1] in _ATTRIBUTES and self._has_names(node, found[1]):
                    is_type = found[1] in ("typeName", "type") or node.tag == "derived"
                    yield from self._code(node, *found.span(2), alone=True, is_type=is_type)
            if node.tag in _TEXTS and (node.tag not in ("variable", "expression") or not node.children):
                is_type = node.tag == "TypeName"
                alone = is_type or node.tag in ("variable", "expression")
                yield from self._code(node, node.inside, node.stop, alone, is_type)

    def _may_have(self, start: int, end: int) -> bool:
        """Whether one of the words, or a part of another word that is like it, is between two places."""
        at = bisect_left(self.said, start)
        return at < len(self.said) and self.said[at] < end

    def _has_names(self, node: Node, attribute: str) -> bool:
        if attribute == "name":
            return node.tag in (*_DECLARE, *_POUS, "reference", "inline", "derived")
        return attribute not in ("typeName", "type") or node.tag in _TYPED

    def _code(self, node: Node, start: int, end: int, alone: bool, is_type: bool = False
              ) -> Iterator[tuple[int, int, str]]:
        """Names in a piece of text. ``alone``: a word that is all of it is a name."""
        if not self._may_have(start, end):
            return
        text = node.document.source.text
        whole = alone and _WORDS.fullmatch(text[start:end].strip()) is not None
        for found in _CODE.finditer(text, start, end):
            word = found["word"] or found["member"]
            key = word.upper() if word else ""
            if key not in self.ends or is_type and key not in self.pous:
                continue
            if not (whole or found["member"]) and self._is_no_name(key, text, found, node.tag):
                continue
            new = (word.strip("_") or "unnamed") + self.ends[key]
            if node.tag in (*_DECLARE, *_POUS) and key not in self.told:
                self.told.add(key)
                self.reading.remark("renamed", word, new, node.span)
            yield found.end() - len(word), found.end(), new

    def _is_no_name(self, key: str, text: str, found: re.Match, tag: str) -> bool:
        if key in _STATEMENTS:
            return True
        if key not in _TYPES or key in self.pous:
            return False
        behind = text[found.end() : found.end() + 80].lstrip()
        if tag in ("InterfaceAsPlainText", "textDeclaration"):
            return behind[:1] not in (":", ",")
        return re.match(r"\(\s*\)", behind) is not None  # TIME() tells the time in some editors


def _ending(word: str, taken: set[str]) -> str:
    base, number = word.strip("_") or "unnamed", 1
    ending = "_" if word.strip("_") else ""
    while f"{base}{ending}".upper() in taken:
        number += 1
        ending = f"_{number}"
    return ending
