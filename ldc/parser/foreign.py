"""What the readers of other tools' formats share: findings (LD015x), names, remarks, supporting POUs."""

from __future__ import annotations

import re
from functools import cache

from ldc.diagnostics import Diagnostics
from ldc.library import blocks
from ldc.library.functions import is_function
from ldc.parser import ast, reader
from ldc.parser.lexer import KEYWORDS
from ldc.patterns import Pattern
from ldc.records import entity, field
from ldc.source import SourceFile, Span
from ldc.types import ELEMENTARY

RESERVED = frozenset((*KEYWORDS, *ELEMENTARY, "STRING", "WSTRING"))
"""Words, in capitals, that nothing can be called."""
_LONGEST = 100
_NOT_IN_NAMES = Pattern(r"\W+|__+", re.ASCII)


@entity
class Reading:
    """One foreign source while it is read. ``format``: its name for messages; ``mend``: what helps where it
    breaks the rules of its format."""

    source: SourceFile
    format: str
    diagnostics: Diagnostics
    remarks: list[ast.Remark] = field(default_factory=list)
    lost: bool = False
    mend: str = "save the file again in the editor that it comes from"

    def span(self, start: int, end: int) -> Span:
        return Span(self.source, start, end)

    def malformed(self, span: Span, message: str, label: str = "here", help: str = "") -> None:
        """The file breaks the rules of its format."""
        self.lost = True
        self.diagnostics.error("LD0150", f"{self.format}: {message}", span, label,
                               help=help or self.mend)

    def unsupported(self, span: Span, what: str, help: str, label: str = "this is not read") -> None:
        """Something that has a meaning which cannot be kept. ``what`` names the instruction or element."""
        self.lost = True
        self.diagnostics.error("LD0151", f"{self.format}: {what} is not supported", span, label, help=help)

    def left_out(self, span: Span, what: str, why: str) -> None:
        """Something without effect on what the program does. Told, and listed in the report."""
        self.remark("left out", what, why, span)
        self.diagnostics.warning("LD0152", f"{self.format}: {what} is left out", span, why,
                                 help="the rest of the program does not depend on it")

    def too_large(self, span: Span, limit: int, what: str) -> None:
        self.lost = True
        self.diagnostics.error("LD0153", f"{self.format}: more than {limit:,} {what}", span,
                               "reading stops here", help="split the program")

    def remark(self, kind: str, what: str, into: str, span: Span) -> None:
        self.remarks.append(ast.Remark(kind, what, into, span))


class Names:
    """Identifiers for foreign names: legal, not reserved, unique in any case; each change is a remark."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading
        self._made: dict[str, str] = {}
        self._taken: set[str] = set()
        self._last: dict[str, int] = {}

    def name(self, foreign: str, span: Span, key: str | None = None, pou: bool = False) -> str:
        """The identifier for a name; the same one for the same ``key`` (the name itself in capitals)."""
        key = foreign.upper() if key is None else key
        made = self._made.get(key)
        if made is None:
            made = self._made[key] = self.fresh(foreign, pou)
            if made != foreign:
                self.reading.remark("renamed", foreign, made, span)
        return made

    def fresh(self, wanted: str, pou: bool = False) -> str:
        """An identifier like ``wanted`` that nothing else has; for a ``pou``, no function or block of the
        standard either."""
        base = _NOT_IN_NAMES.sub("_", wanted[:_LONGEST]).strip("_") or "unnamed"
        if base[0].isdigit():
            base = f"n{base}"
        standard = pou and (is_function(base) or base.upper() in blocks.names())
        if standard or base.upper() in RESERVED or base.upper().startswith("_LDC"):
            base = f"{base}_"
        made, number = base, self._last.get(base.upper(), 1)
        while made.upper() in self._taken or made.upper() in RESERVED:
            number += 1
            made = f"{base}_{number}"
        self._last[base.upper()] = number
        self._taken.add(made.upper())
        return made


def supporting(text: str, path: str) -> tuple[ast.Pou, ...]:
    """POUs that a foreign instruction set is written in: ``text`` in Structured Text, ours and correct.
    ``path`` is what messages call it. Raises ValueError when the text is wrong."""
    diagnostics = Diagnostics()
    file = reader.parse_file(SourceFile(path, text), diagnostics)
    if diagnostics.has_errors:
        raise ValueError("; ".join(f"{d.code} {d.message} at {d.primary.span}" for d in diagnostics))
    return file.pous


def stored(package: str, name: str, /, **values: object) -> tuple[ast.Pou, ...]:
    """Supporting POUs that lie in a package: ``blocks/name.st`` with ``values`` for its ``{fields}``."""
    text = _text(package, f"{name}.st")
    return supporting(text.format(**values) if values else text, f"{package.rpartition('.')[2]}/{name}.st")


@cache
def _text(package: str, file: str) -> str:
    from importlib.resources import files  # slow to load, and few programs need a supporting POU

    return files(package).joinpath("blocks", file).read_text(encoding="ascii")
