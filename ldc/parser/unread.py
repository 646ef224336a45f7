"""Rungs whose text was read before: their paths are read again only when somebody looks at them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.lexer import lex
from ldc.parser.units import Units
from ldc.records import record
from ldc.source import Span


@record
class Head:
    """What is known of a rung by its text, from RUNG to its end. ``name_at``: where its name begins, from the
    first character; ``jumps``: labels that it jumps to; ``calls``: functions that it calls, in capitals;
    ``stem``: what its key begins with when it has no name."""

    name: str | None
    title: str | None
    name_at: int
    jumps: tuple[str, ...]
    calls: frozenset[str]
    stem: str

    def rung(self, span: Span) -> ast.Rung:
        """The rung at a place where this text stands."""
        start = span.start + self.name_at
        name_span = None if self.name is None else Span(span.source, start, start + len(self.name))
        return ast.Rung(self.name, self.title, UnreadPaths(span, self), span, name_span)


Heads = Callable[[str], Head | None]
"""What is known of the text of a rung; None for one that was not read before, or not without findings."""


class UnreadPaths(Sequence[ast.Path]):
    """The paths of a rung, read when they are asked for; equal to the tuple of them."""

    __slots__ = ("head", "_span", "_paths")

    def __init__(self, span: Span, head: Head) -> None:
        self.head, self._span = head, span
        self._paths: tuple[ast.Path, ...] | None = None

    def _read(self) -> tuple[ast.Path, ...]:
        if self._paths is None:
            tokens = lex(self._span.source, self._span.start, self._span.end)
            rung = Units(tokens, Diagnostics()).parse("rung", 0, len(tokens.types), "rung")
            if rung is None:
                raise AssertionError(f"the rung at {self._span} was read before, and cannot be read now")
            self._paths = rung.paths
        return self._paths

    def __getitem__(self, index):
        return self._read()[index]

    def __len__(self) -> int:
        return len(self._read())

    def __iter__(self):
        return iter(self._read())

    def __eq__(self, other: object) -> bool:
        return self._read() == (other._read() if isinstance(other, UnreadPaths) else other)

    def __hash__(self) -> int:
        return hash(self._read())

    def __repr__(self) -> str:
        return repr(self._read())
