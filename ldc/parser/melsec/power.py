"""The power of one rung while its instructions are read: what LD, ANB, ORB, MPS, MRD and MPP do to it."""

from __future__ import annotations

from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.melsec.circuit import MAX_DEPTH, Block, Point
from ldc.parser.melsec.lines import Instruction
from ldc.source import Span

_JUMPS = ("CJ", "CJP")
_ANEW = "begin the rung anew with LD"


class Power:
    """``point``: where the next output goes, None before the first LD; ``blocks``: begun by LD and not joined
    yet; ``stored``: points that MPS keeps; ``failed``: something was told, so that there is no rung."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading
        self.root: Point | None = None
        self.point: Point | None = None
        self.blocks: list[Block] = []
        self.stored: list[Point] = []
        self.jumped = self.failed = False

    @property
    def ended(self) -> bool:
        """Whether the next LD begins a rung, unless ANB joins its block to this one."""
        return self.point is not None and not self.blocks and bool(self.point.branches or self.failed)

    def load(self, block: Block) -> None:
        """LD begins the rung or a block in it."""
        if self.point is None:
            self.root = self.point = Point(block)
        else:
            self.blocks.append(block)

    def series(self, it: Instruction, block: Block) -> None:
        """AND; behind an output a new branch begins."""
        if not self._is_there(it):
            return
        if not self.blocks and self.point.branches:
            self.point = self.point.behind()
        self._top().series(block)
        self._bounded(it, max(self.point.depth, self._top().depth))

    def parallel(self, it: Instruction, block: Block) -> None:
        """OR is parallel to all that leads to the point: not possible behind an output or a stored point."""
        if not self._is_there(it):
            return
        if not self.blocks and (self.point is not self.root or self.point.branches):
            self.failed = True
            self.reading.unsupported(it.span, f"{it.name} behind an output", _ANEW)
            return
        self._top().parallel(block)
        self._bounded(it, self._top().depth)

    def join(self, it: Instruction) -> None:
        """ANB and ORB."""
        if not self.blocks:
            self.reading.left_out(it.span, f"{it.name} without a second block",
                                  "there is nothing that it could join")
            return
        block = self.blocks.pop()
        if it.name == "ORB":
            self.parallel(it, block)
        elif not self.failed:
            self.series(it, block.joined(it.span))

    def branch(self, it: Instruction) -> None:
        """MPS, MRD and MPP: a new branch at a point."""
        if not self._is_there(it):
            return
        self._no_blocks(it.span, "before this")
        if it.name == "MPS":
            self.stored.append(self.point)
        elif not self.stored:
            self.failed = True
            self.reading.malformed(it.span, f"{it.name} without MPS before it")
            return
        self.point = (self.stored.pop() if it.name == "MPP" else self.stored[-1]).behind()
        self._bounded(it, self.point.depth)

    def output(self, it: Instruction, paths: list[list[ast.Item]]) -> None:
        """Parallel paths at the point."""
        if not self._is_there(it):
            return
        if self.jumped:
            self.failed = True
            self.reading.unsupported(it.span, f"{it.name} behind a jump", _ANEW)
            return
        self._no_blocks(it.span, "before this")
        self.point.branches += paths
        self.jumped = it.name in _JUMPS

    def items(self, begin: Span, last: Span) -> list[ast.Item]:
        """The rung; empty when there is none (then that is told)."""
        self._no_blocks(last, "before the end of the rung")
        if not self.failed and self.stored:
            self.failed = True
            self.reading.malformed(last, "MPS without MPP", "before this")
        if not self.failed and not _has_output(self.root):
            self.failed = True
            self.reading.malformed(begin, "a rung without an output", "it begins here")
        return [] if self.failed else self.root.items(begin)

    def _is_there(self, it: Instruction) -> bool:
        if self.point is None and not self.failed:
            self.reading.malformed(it.span, f"{it.name} stands before any LD",
                                   help="a rung begins with LD or LDI")
        return self.point is not None

    def _top(self) -> Block:
        return self.blocks[-1] if self.blocks else self.point.block

    def _no_blocks(self, span: Span, label: str) -> None:
        if self.blocks and not self.failed:
            self.reading.malformed(span, "a block that LD begins is not joined", label,
                                   "ANB or ORB joins the blocks before an output")
        self.failed |= bool(self.blocks)
        self.blocks = []

    def _bounded(self, it: Instruction, depth: int) -> None:
        if depth > MAX_DEPTH and not self.failed:
            self.failed = True
            self.reading.too_large(it.span, MAX_DEPTH, "circuits in one another")


def _has_output(point: Point) -> bool:
    work = [point]
    while work:
        for branch in work.pop().branches:
            if not isinstance(branch, Point):
                return True
            work.append(branch)
    return False
