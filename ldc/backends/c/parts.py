"""How a POU is cut into C functions (parts) and files (chunks).

Cuts follow the keys of rungs, not their numbers: an inserted rung changes the part that it lies in and no
other one. A part has at most ``LONGEST`` rungs, since gcc takes more than linear time for a function; a
chunk at most 200 (DESIGN section 5).
"""

from __future__ import annotations

from zlib import crc32

from ldc.il.pieces import pieces
from ldc.il.statements import Statement
from ldc.il.structure import Structured
from ldc.records import record

LEAST, LONGEST, MOST_STATEMENTS = 12, 40, 600
CHUNK_LEAST, CHUNK_MOST = 80, 200


@record
class Cut:
    """One part: the numbers of its first rung and of that after its last, its statements, a name that is
    unique in its POU."""

    first: int
    end: int
    name: str
    statements: tuple[Statement, ...]


def cut(code: Structured, paced: bool = False) -> list[list[Cut]]:
    """The chunks of a POU, each a list of its parts; ``paced``: each piece (``ldc.il.pieces``) is a part."""
    flat, keys = code.flat, [rung.key for rung in code.unit.rungs]
    apart = pieces(flat).rungs if paced else ()
    begins = frozenset(flat.places[at][0] for at in code.seams if not paced)
    by_rung: dict[int, list[Statement]] = {}
    for statement in code.statements:
        if statement.at < len(flat.places):
            by_rung.setdefault(flat.places[statement.at][0], []).append(statement)
    chunks: list[list[Cut]] = [[]]
    first, held, rungs_in_chunk = apart[0] if apart else 0, [], 0
    names: dict[str, int] = {}

    def close(end: int) -> None:
        nonlocal held, first, rungs_in_chunk
        if held or apart:
            mark = crc32(keys[first].encode())
            stem = f"{mark:08x}"
            names[stem] = names.get(stem, 0) + 1
            name = stem if names[stem] == 1 else f"{stem}_{names[stem]}"
            count = end - first
            if chunks[-1] and (rungs_in_chunk + count > CHUNK_MOST
                               or rungs_in_chunk >= CHUNK_LEAST and (mark >> 8) % 3 == 0):
                chunks.append([])
                rungs_in_chunk = 0
            chunks[-1].append(Cut(first, end, name, tuple(held)))
            rungs_in_chunk += count
        first, held = end, []

    later = frozenset(apart[1:])
    for number in range(first, len(keys)):
        count = number - first
        if number in later or number in begins and count and (
                count >= LONGEST or len(held) >= MOST_STATEMENTS
                or count >= LEAST and crc32(keys[number].encode()) % 8 == 0):
            close(number)
        held += by_rung.get(number, ())
    close(len(keys))
    return [chunk for chunk in chunks if chunk]
