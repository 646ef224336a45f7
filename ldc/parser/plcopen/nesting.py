"""Comments inside of comments (IEC 61131-3, 3rd edition, 6.3.3), which the 2nd edition does not have."""

from __future__ import annotations

from ldc.patterns import Pattern

_INSIDE = Pattern(r"\(\*|\*\)")
_OUTSIDE = Pattern(r"\(\*|//[^\r\n]*|'(?:[^'$\n]|\$[^\n])*'")


def nests(text: str, start: int, stop: int) -> bool:
    """Whether a comment may begin within another one (cheap; `flat` decides)."""
    first = text.find("(*", start, stop)
    second = text.find("(*", first + 2, stop) if first >= 0 else -1
    while second >= 0:
        if text.find("*)", first, second) < 0:
            return True
        first, second = second, text.find("(*", second + 2, stop)
    return False


def flat(text: str) -> str:
    """The text with comments that nest made to single ones of the same length; the text as it is when a
    comment is not closed as often as it is opened."""
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
