"""Names that somebody may have meant."""

from __future__ import annotations

from collections.abc import Iterable


def similar(word: str, known: Iterable[str], count: int = 3, least: float = 0.6) -> list[str]:
    """The names most like a word, best first: at most ``count``, each with at least ``least`` (0 to 1) in
    common."""
    from difflib import get_close_matches  # most texts are right

    return get_close_matches(word, known, count, least)
