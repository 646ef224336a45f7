"""Series and parallel circuits, as the instructions of a list put them together.

A block is what LD begins; a point is where the power stands that outputs take. Outputs at one point are
parallel to each other, and to what AND, MPS, MRD and MPP lead on to.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.parser import ast
from ldc.source import Span

MAX_DEPTH = 40
"""Circuits in one another; the controllers themselves take 8 blocks and 11 branches."""


@dataclass(slots=True)
class Parallel:
    paths: list[list]


@dataclass(slots=True)
class Block:
    """Elements and parallels in series; ``depth``: of circuits in one another; ``changes``: whether it holds
    an element that changes the power of all before it, as INV does."""

    parts: list[ast.Item | Parallel] = field(default_factory=list)
    depth: int = 0
    changes: bool = False

    def series(self, other: Block) -> None:
        self.parts += other.parts
        self.depth = max(self.depth, other.depth)
        self.changes |= other.changes

    def joined(self, span: Span) -> Block:
        """The block as something to be put behind another: one that changes power does so with its own alone,
        so it becomes an input of an AND."""
        if not self.changes:
            return self
        items = _items(self.parts, span)
        own = ast.Pin("IN2", ast.Branches((path_of(items),), span), False, span)
        return Block([ast.Block(None, "AND", (own,), "IN1", "OUT", span)], self.depth + 1)

    def parallel(self, other: Block) -> None:
        """Another path beside all of this block."""
        self.changes |= other.changes
        if len(self.parts) == 1 and isinstance(self.parts[0], Parallel):
            self.parts[0].paths.append(other.parts)
            self.depth = max(self.depth, other.depth + 1)
        else:
            self.parts = [Parallel([self.parts, other.parts])]
            self.depth = max(self.depth, other.depth) + 1


@dataclass(slots=True)
class Point:
    """``block`` leads to it; ``branches`` are the outputs at it and the points behind it."""

    block: Block
    depth: int = 0
    branches: list[list[ast.Item] | Point] = field(default_factory=list)

    def behind(self) -> Point:
        """A new branch."""
        made = Point(Block(), self.depth + 1)
        self.branches.append(made)
        return made

    def items(self, span: Span) -> list[ast.Item]:
        """The elements of the rung from here on; parallels as branches."""
        found = _items(self.block.parts, span)
        paths = [branch.items(span) if isinstance(branch, Point) else branch for branch in self.branches]
        paths = [path for path in paths if path]
        if len(paths) == 1:
            return found + paths[0]
        return found + ([_branches(paths, span)] if paths else [])


def _items(parts: list[ast.Item | Parallel], span: Span) -> list[ast.Item]:
    return [_branches([_items(path, span) for path in part.paths], span)
            if isinstance(part, Parallel) else part for part in parts]


def _branches(paths: list[list[ast.Item]], span: Span) -> ast.Branches:
    return ast.Branches(tuple(path_of(path) for path in paths), span)


def path_of(items: list[ast.Item]) -> ast.Path:
    return ast.Path(tuple(items), items[0].span)
