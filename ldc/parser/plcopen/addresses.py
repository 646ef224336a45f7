"""Addresses of variables as other tools mean them, and what they are here.

In the runtimes of Beremiz and OpenPLC bits, bytes and words lie apart: `%IX0.0` has nothing to do with
`%IW0`. Here they overlay one image (ADR 0002), so the wider ones move to where nothing else is. Other editors
leave addresses open (`%I*`), name channels of devices (`%IX0.1.2`) or bits of words (`%IX0.8`), or give an
address of another size than the variable's (`%MD4 : TIME`); such a variable has no address.
"""

from __future__ import annotations

import re
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence, Set

from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.plcopen import findings
from ldc.patterns import Pattern
from ldc.records import replace
from ldc.types import ELEMENTARY, Elementary

_ADDRESS = Pattern(r"%([IQM])([XBWDL]?)(\d{1,6})(?:\.([0-7]))?\Z")
_BARE = Pattern(r"%[IQM][XBWDL]?\d+(?:\.\d+)*", re.IGNORECASE)
_NO_CODE = Pattern(
    r"""\saddress\s*=\s*["'][^"'<]*["']|<(comment|documentation)[\s>].*?</\1\s*>|\(\*.*?\*\)"""
    r"""|\bAT\s+%[\w.*]+|"(?:location|documentation|comment)"\s*:\s*"(?:[^"\\]|\\.)*\"""",
    re.DOTALL | re.IGNORECASE)
_APART = Pattern(r'\sxmlns:ns1="|/tc6\.xsd"|="(?:Beremiz|OpenPLC)', re.IGNORECASE)
_HEAD = 2_000
_BYTES = {"X": 0, "B": 1, "W": 2, "D": 4, "L": 8}
_FAR = 1_024
"""Bytes of an area of the image, unless a project says otherwise. Beyond, a flag goes without an address."""

Blocks = tuple[ast.VarBlock, ...]


def mended(blocks: Sequence[Blocks], reading: Reading) -> Callable[[Blocks], Blocks]:
    """What makes the sections of a file right; ``blocks`` are all of them."""
    found = [v for group in blocks for block in group for v in block.variables if v.location]
    if not found:
        return lambda group: group
    completed = any(block.kind == "VAR_CONFIG" for group in blocks for block in group)
    apart = _APART.search(reading.source.text, 0, _HEAD) is not None
    moved = moves({v.location for v in found}, [reading.source.text]) if apart else {}
    return changed(moved, reading, _other_sizes(found), completed)


def changed(
    moved: Mapping[str, str], reading: Reading, other_sizes: Set[str] = frozenset(), completed: bool = False
) -> Callable[[Blocks], Blocks]:
    """What gives variables their new addresses, and takes those that name no place, or are of one of the
    ``other_sizes``: places of one variable each, whose type has another size. ``completed``: addresses that
    are open (`%I*`) stay, VAR_CONFIG completes them."""

    def variable(declared: ast.VarDecl) -> ast.VarDecl:
        place = declared.location
        if place is None or completed and place.endswith("*"):
            return declared
        if _without(place):
            reading.left_out(declared.span, f"the address {place} of `{declared.name}`",
                             "it names no place of the image")
            return replace(declared, location=None)
        if place in other_sizes:
            reading.left_out(declared.span, f"the address {place} of `{declared.name}`",
                             f"the place has another size than {declared.type.name}")
            return replace(declared, location=None)
        if place not in moved:
            return declared
        findings.moved(reading.diagnostics, declared.span, declared.name, place, moved[place])
        reading.remark("mapped", f"{declared.name} AT {place}", f"AT {moved[place]}", declared.span)
        return replace(declared, location=moved[place])

    def sections(group: Blocks) -> Blocks:
        return tuple(replace(block, variables=tuple(map(variable, block.variables)))
                     if any(v.location for v in block.variables) else block for block in group)

    return sections


def _without(place: str) -> bool:
    match = _ADDRESS.match(place)
    if match is None or ((match[2] or "X") == "X") != (match[4] is not None):
        return True
    return match[1] == "M" and int(match[3]) * max(_BYTES[match[2] or "X"], 1) >= _FAR


def _other_sizes(variables: Iterable[ast.VarDecl]) -> frozenset[str]:
    """The addresses of elementary types of another size (`%MD4 : TIME`, `%IW2 : REAL`), which some editors
    take for the first byte of a variable; without those where it would lie on another variable."""
    ends: dict[str, list[tuple[int, int]]] = {}
    found: list[tuple[str, str, int, int]] = []
    for variable in variables:
        match = _ADDRESS.match(variable.location)
        if match is None:
            continue
        width = _BYTES[match[2] or "X"]
        start = int(match[3]) * max(width, 1)
        named = isinstance(variable.type, ast.NamedType)
        type_ = ELEMENTARY.get(variable.type.name.upper()) if named else None
        bits = type_.bits if isinstance(type_, Elementary) else width * 8 or 1
        end = start + max(bits // 8, 1, width)
        ends.setdefault(match[1], []).append((start, end))
        if bits != (width * 8 or 1):
            found.append((variable.location, match[1], start, end))
    starts = {area: sorted(start for start, _ in spans) for area, spans in ends.items()}
    lasts = {area: sorted(end for _, end in spans) for area, spans in ends.items()}
    return frozenset(place for place, area, start, end in found
                     if bisect_left(starts[area], end) - bisect_right(lasts[area], start) == 1)


def moves(places: Iterable[str | None], texts: Iterable[str]) -> dict[str, str]:
    """Where what overlaps with something narrower goes: behind all the rest of its area, in order. An
    address that stands in the code of a text itself stays, for both must be the same."""
    spans: dict[str, tuple[str, str, int, int]] = {}
    for place in places:
        match = _ADDRESS.match(place or "")
        if match is None or _without(place):
            continue
        size, number = match[2] or "X", int(match[3])
        width = _BYTES[size]
        spans[place] = match[1], size, number * max(width, 1), max(width, 1)
    moved: dict[str, str] = {}
    for area in "IQM":
        own = sorted(((*spans[place][1:], place) for place in spans if spans[place][0] == area),
                     key=lambda entry: (_BYTES[entry[0]], entry[1], entry[3]))
        taken: set[int] = set()
        end = max((start + width for _, start, width, _ in own), default=0)
        at = 0
        while at < len(own):
            same = [entry for entry in own[at:] if entry[0] == own[at][0]]
            for size, start, width, place in same:
                if size != "X" and not taken.isdisjoint(range(start, start + width)):
                    number = -(-end // width)
                    end = (number + 1) * width
                    moved[place] = f"%{area}{size}{number}"
            for _, start, width, place in same:
                if place not in moved:
                    taken.update(range(start, start + width))
            at += len(same)
    bare = {found.upper() for text in (texts if moved else ())
            for found in _BARE.findall(_NO_CODE.sub("", text))}
    return {place: to for place, to in moved.items() if place not in bare}
