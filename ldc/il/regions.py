"""Which rungs the instructions of an IL text belong to."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

from ldc.il.program import Instr, RungCode
from ldc.il.scan import Mark
from ldc.patterns import Pattern
from ldc.records import record
from ldc.source import Span

# Keys that the compiler makes of a rung without a name: a digest and an ordinal.
_UNNAMED = Pattern(r"r[0-9a-f]{8}_\d+\Z")
_NAME = Pattern(r"[A-Za-z_]\w*\Z", re.ASCII)
_JUMPS = frozenset(("JMP", "JMPC", "JMPCN"))


@record
class Region:
    start: int
    key: str
    title: str | None
    marked: bool


class Regions:
    """Cuts ``code``, which is still growing, at the marks. A mark at which the accumulator is carried
    over does not cut: rungs begin with nothing in it."""

    def __init__(self, code: list[Instr]) -> None:
        self._code = code
        self._regions = [Region(0, "body", None, False)]
        self._keys: set[str] = set()
        self._untouched = False

    def open(self, mark: Mark) -> None:
        key, count = mark.key, 1
        while key in self._keys:
            count += 1
            key = f"{mark.key}_{count}"
        self._keys.add(key)
        if not self._regions[-1].marked and not self._code:
            self._regions.pop()
        self._regions.append(Region(len(self._code), key, mark.title, True))
        self._untouched = True

    def started(self) -> None:
        """The accumulator gets a new value."""
        self._untouched = False

    def continued(self) -> None:
        """The accumulator's value is used."""
        if self._untouched and len(self._regions) > 1:
            self._regions.pop()
        self._untouched = False

    def rungs(self, span: Callable[[int, int], Span]) -> tuple[RungCode, ...]:
        """The rungs. A label at the start of one is the rung's own; when jumps lead into the middle of
        another rung, all are one. A body without code has no rung."""
        starts = [r.start for r in self._regions]
        pieces = [self._code[a:b] for a, b in zip(starts, [*starts[1:], len(self._code)])]
        regions = self._regions
        if _entered(pieces):
            regions, pieces = [Region(0, "body", None, False)], [self._code]
        return tuple(_rung(region, piece, span) for region, piece in zip(regions, pieces)
                     if piece or region.marked)


def _entered(pieces: Iterable[list[Instr]]) -> bool:
    """Whether a jump leads from one piece into the middle of another."""
    where: dict[str, tuple[int, bool]] = {}
    pieces = list(pieces)
    for number, piece in enumerate(pieces):
        for index, instr in enumerate(piece):
            if instr.op == "LABEL":
                where[instr.name] = number, index == 0
    return any(instr.op in _JUMPS and (found := where.get(instr.name)) and not found[1] and found[0] != number
               for number, piece in enumerate(pieces) for instr in piece)


def _rung(region: Region, code: list[Instr], span: Callable[[int, int], Span]) -> RungCode:
    label = code[0].name if code and code[0].op == "LABEL" else None
    named = region.marked and _NAME.match(region.key) and not _UNNAMED.match(region.key)
    spans = [i.span for i in code if i.span is not None]
    whole = span(spans[0].start, max(s.end for s in spans)) if spans else None
    return RungCode(region.key, tuple(code if label is None else code[1:]), label, region.title,
                    region.key if named else None, "none", whole)
