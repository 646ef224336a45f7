"""Breaking rungs over lines: a path on one line when it fits, else filled; branches that do not fit on one
line get a line for each path, with ``{``, ``|`` and ``}`` below each other.

A comment that begins or ends a line keeps doing so, which breaks all that it stands in. As breaks are
then just where they were, formatting again changes nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.parser import ast, unparse
from ldc.parser.comments import Comments, comment_text
from ldc.records import record

WIDTH = 100


@record
class Atom:
    """What is placed as a whole when it fits: ``flat`` is its text on one line, None when that cannot be.

    ``paths`` of branches and the ``block`` whose pins can be broken tell how else it is placed.
    """

    flat: str | None
    paths: tuple[tuple[Atom, ...], ...] = ()
    block: ast.Block | None = None
    comment: str = ""
    line_before: bool = False
    line_after: bool = False


def atoms(path: ast.Path, comments: Comments | None) -> list[Atom]:
    """A path with the comments that stand before its elements and inside them."""
    made: list[Atom] = []
    for item in path.items:
        if comments is not None:
            edge = item.span.start if isinstance(item, ast.Branches) else item.span.end
            made += comment_atoms(comments.before(edge), comments, first=not made)
        if isinstance(item, ast.Branches):
            made.append(_branches(item, comments))
        else:
            made.append(Atom(unparse.item_text(item), block=item if isinstance(item, ast.Block) else None))
    return made


def comment_atoms(taken: list[ast.Comment], comments: Comments, first: bool) -> list[Atom]:
    """``first``: they begin their path, and so a line or a branch, in any case."""
    made = []
    for comment in taken:
        text = comment_text(comment)
        before = comments.starts_line(comment) and not first
        after = comments.ends_line(comment) or text.startswith("//") or "\n" in text
        flat = None if before or after else text
        made.append(Atom(flat, comment=text, line_before=before, line_after=after))
        first = False
    return made


def _branches(branches: ast.Branches, comments: Comments | None) -> Atom:
    paths, pending = [], []
    for number, path in enumerate(branches.paths):
        if comments is not None:
            pending = comment_atoms(comments.before(path.span.start), comments, first=True)
        made = pending + atoms(path, comments)
        if comments is not None:
            last = number == len(branches.paths) - 1
            end = path.span.end
            after = comments.before(branches.span.end) if last else comments.until(end, "|")
            made += comment_atoms(after, comments, first=False)
        paths.append(tuple(made))
    flats = [_flat(path) for path in paths]
    return Atom(None if None in flats else f"{{ {' | '.join(flats)} }}", tuple(paths))


def _flat(path: tuple[Atom, ...]) -> str | None:
    texts = [atom.flat for atom in path]
    return None if None in texts else " ".join(texts)


@dataclass(slots=True)
class Writer:
    """Lines being filled. ``fresh``: nothing stands behind the margin of the last line yet."""

    lines: list[str] = field(default_factory=list)
    line: str = ""
    fresh: bool = True

    def start(self, text: str) -> None:
        """Begin a line with ``text`` as its margin."""
        if self.line.strip():
            self.lines.append(self.line.rstrip())
        self.line, self.fresh = text, True

    def put(self, text: str) -> None:
        self.line += text if self.fresh else " " + text
        self.fresh = False

    def room(self, reserve: int = 1) -> int:
        """Columns left, ``reserve`` of them kept for a semicolon."""
        return WIDTH - len(self.line) - (not self.fresh) - reserve

    def finish(self, end: str = "") -> list[str]:
        return [*self.lines, self.line.rstrip() + end]


def fill(path: list[Atom] | tuple[Atom, ...], writer: Writer, margin: int, hang: int) -> None:
    """Place a path. Further lines are indented by ``margin``, behind its first element by ``hang`` more."""
    drawn = pending = False
    for atom in path:
        indent = " " * (margin + hang * drawn)
        if pending or atom.line_before:
            _break(writer, indent)
        if atom.comment:
            if atom.flat is not None and len(atom.flat) > writer.room() and not writer.fresh:
                _break(writer, indent)
            writer.put(atom.comment)
            if "\n" in atom.comment:
                *head, writer.line = writer.line.split("\n")
                writer.lines += head
        else:
            _place(atom, writer, indent)
            drawn = True
        pending = atom.line_after


def _break(writer: Writer, indent: str) -> None:
    if not writer.fresh:
        writer.start(indent)


def _place(atom: Atom, writer: Writer, indent: str) -> None:
    fits = atom.flat is not None and len(atom.flat) <= writer.room()
    if not fits:
        _break(writer, indent)
        fits = atom.flat is not None and len(atom.flat) <= writer.room()
    if not fits and atom.paths:
        _broken_branches(atom, writer)
    elif not fits and atom.block is not None and atom.block.pins:
        _broken_block(atom.block, writer)
    else:
        writer.put(atom.flat)


def _broken_branches(atom: Atom, writer: Writer) -> None:
    column = len(writer.line)
    for number, path in enumerate(atom.paths):
        if number:
            writer.start(" " * column)
        writer.put("|" if number else "{")
        writer.line, writer.fresh = writer.line + " ", True
        fill(path, writer, column + 2, 0)
    writer.start(" " * column)
    writer.put("}")


def _broken_block(block: ast.Block, writer: Writer) -> None:
    margin = len(writer.line) + 4
    writer.put(unparse.block_head(block))
    for number, pin in enumerate(block.pins, 1):
        writer.start(" " * margin)
        if isinstance(pin.value, ast.Branches):
            writer.line += unparse.pin_head(pin)
            _place(_branches(pin.value, None), writer, "")
        else:
            writer.put(unparse.pin_text(pin))
        writer.line += "," if number < len(block.pins) else unparse.block_tail(block)
