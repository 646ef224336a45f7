"""The comments of a file, handed out in order to what they stand beside."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.parser import ast


class Comments:
    """A cursor over comments sorted by place. What was taken is not seen again."""

    def __init__(self, text: str, comments: Iterable[ast.Comment]) -> None:
        self._text = text
        self._rest = sorted(comments, key=lambda c: c.span.start, reverse=True)

    def before(self, offset: int) -> list[ast.Comment]:
        """All that begin before an offset."""
        taken = []
        while self._rest and self._rest[-1].span.start < offset:
            taken.append(self._rest.pop())
        return taken

    def same_line(self, offset: int, limit: int | None = None) -> list[ast.Comment]:
        """Those that follow ``offset`` in its line (semicolons may stand between), before ``limit``."""
        taken = []
        while self._rest and (limit is None or self._rest[-1].span.start < limit):
            comment = self._rest[-1]
            if comment.span.start >= offset:
                if self._text[offset : comment.span.start].strip(" \t;"):
                    break
                offset = comment.span.end
            taken.append(self._rest.pop())
        return taken

    def until(self, offset: int, mark: str) -> list[ast.Comment]:
        """Those that follow ``offset`` with nothing but space between, before ``mark`` comes."""
        taken = []
        while self._rest and mark not in self._text[offset : self._rest[-1].span.start]:
            taken.append(self._rest.pop())
            offset = taken[-1].span.end
        return taken

    def starts_line(self, comment: ast.Comment) -> bool:
        line = self._text.rfind("\n", 0, comment.span.start) + 1
        return not self._text[line : comment.span.start].strip()

    def ends_line(self, comment: ast.Comment) -> bool:
        end = self._text.find("\n", comment.span.end)
        return not self._text[comment.span.end : end if end >= 0 else len(self._text)].strip()


def comment_text(comment: ast.Comment) -> str:
    """As written, without space at the end of its lines."""
    return "\n".join(line.rstrip() for line in comment.text.split("\n"))


def trailing_text(comments: list[ast.Comment]) -> str:
    """What is appended to a line; ``//`` comments that others follow become ``(* *)``."""
    parts = []
    for number, comment in enumerate(comments, 1):
        text = comment_text(comment)
        parts.append(block_comment(text) if text.startswith("//") and number < len(comments) else text)
    return "".join(f"  {part}" for part in parts)


def block_comment(text: str) -> str:
    """``// text`` as ``(* text *)``."""
    return f"(* {text[2:].strip().replace('*)', '* )')} *)"
