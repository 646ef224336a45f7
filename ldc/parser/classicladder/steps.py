"""The elements of a rung as steps between nets, in the order in which ClassicLadder evaluates them.

That order goes from column to column and in each from top to bottom. Power at the left of a cell is the OR of
the elements that end there, and of those that vertical lines join with it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.parser.classicladder import grid
from ldc.parser.classicladder.expressions import Expression, Wrong
from ldc.parser.classicladder.grid import Cell, Nets, Rung
from ldc.parser.classicladder.settings import Settings
from ldc.parser.classicladder.variables import BLOCKS, Variables, base
from ldc.source import Span

Net = tuple[int, int]
RAIL = None
_EDGES = {grid.RISING: "P", grid.FALLING: "N"}
_COILS = {grid.COIL: "", grid.COIL_NOT: "/", grid.SET: "S ", grid.RESET: "R "}


@dataclass(slots=True, eq=False)
class Step:
    """An element between two nets (``head`` RAIL: the rail, ``tail`` None: nothing). ``text`` is the element
    in ladder text; ``inputs`` and ``outputs`` are the nets at other pins of a block. ``reads``, ``writes``:
    variables. ``acts``: it does more than pass power."""

    text: str
    head: Net | None
    tail: Net | None
    span: Span
    inputs: dict[str, Net | None] = field(default_factory=dict)
    outputs: dict[str, Net] = field(default_factory=dict)
    reads: frozenset[str] = frozenset()
    writes: frozenset[str] = frozenset()
    acts: bool = False
    jump: int | None = None
    call: str | None = None
    wire: bool = False


@dataclass(slots=True)
class Drawing:
    """Makes the steps of one rung. ``subroutines``: the function block of each, by number; ``feeding``:
    elements that end at each net."""

    variables: Variables
    settings: Settings
    subroutines: dict[int, str]
    drawn: Rung
    nets: Nets = field(init=False)
    feeding: set[Net] = field(default_factory=set)
    steps: list[Step] = field(default_factory=list)

    def make(self) -> list[Step]:
        self.nets = Nets(self.drawn)
        for column in range(self.drawn.width):
            for row in range(self.drawn.height):
                cell = self.drawn.cells.get((column, row))
                if cell is not None:
                    self._cell(cell, column, row)
        kept = _alive(self.steps)
        alive = {id(step) for step in kept}
        for step in self.steps:
            if not step.wire and id(step) not in alive and not self.variables.reading.lost:
                self.variables.reading.left_out(step.span, f"{step.text} in rung {self.drawn.number}",
                                                "its power leads nowhere")
        return _wired(_unfed(kept))

    # ---- nets

    def _head(self, column: int, row: int) -> Net | None:
        """What feeds the left of a cell: RAIL, or its net."""
        return self.nets.at(column, row)

    def _tail(self, column: int, row: int) -> Net:
        net = self.nets.at(column + 1, row)
        self.feeding.add(net)
        return net

    def _fed(self, column: int, row: int) -> str | Net:
        """What stands at an input pin: ``TRUE`` at the rail, the net, ``FALSE`` when nothing ends there."""
        net = self._head(column, row)
        if net is RAIL:
            return "TRUE"
        return net if net in self.feeding else "FALSE"

    # ---- cells

    def _cell(self, cell: Cell, column: int, row: int) -> None:
        kind = cell.type
        if kind in (grid.FREE, grid.COVERED) or kind >= grid.EDITING:
            return
        left = column + 1 - grid.WIDTHS.get(kind, 1)
        if left < 0:
            self._wrong(cell, "an element begins left of the rung")
        elif kind == grid.WIRE:
            self._add(cell, "[TRUE]", self._head(column, row), self._tail(column, row), wire=True)
        elif kind in (grid.OPEN, grid.CLOSED, *_EDGES):
            self._contact(cell, column, row)
        elif kind == grid.COMPARE:
            self._compare(cell, column, row, left)
        elif kind in (grid.TIMER, grid.MONOSTABLE, grid.COUNTER, grid.TIMER_IEC):
            self._block(cell, column, row, left)
        else:
            self._output(cell, column, row, left)

    def _wrong(self, cell: Cell, message: str) -> None:
        self.variables.reading.malformed(cell.span, f"rung {self.drawn.number}: {message}")

    def _add(self, cell: Cell, text: str, head: Net | None, tail: Net | None, **more) -> None:
        more = {key: frozenset(value) if key in ("reads", "writes") else value for key, value in more.items()}
        self.steps.append(Step(text, head, tail, cell.span, **more))

    def _contact(self, cell: Cell, column: int, row: int) -> None:
        place = self.variables.place(cell.variable, cell.offset, cell.span)
        edge = _EDGES.get(cell.type)
        if edge and place.type != "BOOL":
            self.variables.reading.unsupported(cell.span, "an edge of a number", "compare the number")
        if place.type == "BOOL":
            text = f"[{edge} {place.text}]" if edge else f"[/{place.text}]" if cell.type == grid.CLOSED else (
                f"[{place.text}]")
        else:
            text = f"[{place.text} {'=' if cell.type == grid.CLOSED else '<>'} 0]"
        self._add(cell, text, self._head(column, row), self._tail(column, row), reads={base(place.text)})

    def _expression(self, cell: Cell) -> Expression | None:
        """The expression of a compare or operate block; None when there is none."""
        line = self.settings.expressions.get(cell.offset)
        if line is None or not line.text.strip() or line.text.startswith("#"):
            return None
        return Expression(self.variables, line)

    def _told(self, expression: Expression, wrong: Wrong) -> None:
        self.variables.reading.malformed(
            expression.line.span,
            f"the expression is wrong: {wrong}",
            help="mend it in ClassicLadder, which takes what it understands of it",
        )

    def _compare(self, cell: Cell, column: int, row: int, left: int) -> None:
        expression, text = self._expression(cell), "FALSE"
        if expression is not None:
            try:
                text = expression.compare()
            except Wrong as wrong:
                self._told(expression, wrong)
        self._add(cell, f"[{text}]", self._head(left, row), self._tail(column, row),
                  reads=expression.names if expression else ())

    def _output(self, cell: Cell, column: int, row: int, left: int) -> None:
        head = self._head(left, row)
        if cell.type in _COILS:
            place = self.variables.place(cell.variable, cell.offset, cell.span)
            if place.type != "BOOL" or not place.writable:
                self.variables.reading.unsupported(cell.span, f"a coil of the variable {place.text}",
                                                   "coils write %B, %Q, %I, %E and %X")
                return
            self._add(
                cell, f"({_COILS[cell.type]}{place.text})", head, None, writes={base(place.text)}, acts=True
            )
        elif cell.type == grid.JUMP:
            self._add(cell, "", head, None, acts=True, jump=cell.offset)
        elif cell.type == grid.CALL:
            self._call(cell, head)
        elif cell.type == grid.OPERATE:
            self._operate(cell, head)
        else:
            self.variables.reading.unsupported(cell.span, f"an element of type {cell.type}",
                                               "docs/import-classicladder.md lists what is read")

    def _call(self, cell: Cell, head: Net | None) -> None:
        block = self.subroutines.get(cell.offset)
        if block is None:
            self._wrong(cell, f"there is no subroutine {cell.offset}")
            return
        instance = self.variables.subroutine(f"call_{block}", block, cell.span)
        self._add(cell, f"<{instance}: {block}()>", head, None, acts=True, call=block)

    def _operate(self, cell: Cell, head: Net | None) -> None:
        expression = self._expression(cell)
        if expression is None:
            return
        try:
            target, value = expression.operate()
        except Wrong as wrong:
            self._told(expression, wrong)
            return
        text = f"<MOVE(IN := {value}, OUT => {target.text})>"
        self._add(cell, text, head, None, reads=expression.names, writes={base(target.text)}, acts=True)

    def _block(self, cell: Cell, column: int, row: int, left: int) -> None:
        """The first pins are of the row of the cell: power enters and leaves there."""
        variables, number, span = self.variables, cell.offset, cell.span
        letters = {grid.TIMER: "T", grid.MONOSTABLE: "M", grid.COUNTER: "C", grid.TIMER_IEC: "TM"}[cell.type]
        name = variables.instance(letters, number, span)
        row_of, preset = variables.table(letters, number, span), variables.preset(letters, number, span)
        inputs: dict[str, str | Net] = {}
        outputs: dict[str, int] = {}
        if cell.type == grid.COUNTER:
            inputs = {pin: self._fed(left, row + n) for n, pin in enumerate(("LOAD", "UP", "DOWN"), 1)}
            outputs = {"DONE": row + 1, "FULL": row + 2}
            given = {"PRESET": preset, "VALUE": variables.count(number, span)}
        else:
            milliseconds = f"{preset} * {row_of.base}" if not preset.lstrip("-").isdigit() else (
                str(int(preset) * row_of.base))
            given = {"PRESET": milliseconds, "BASE": str(row_of.base), "SCAN": str(self.settings.period)}
            if cell.type == grid.TIMER_IEC:
                given |= {"PRESET": preset, "MODE": str(min(max(row_of.mode, 0), 2))}
            if cell.type == grid.TIMER:
                control = self._fed(left, row + 1)
                inputs = {"CONTROL": "TRUE" if control == "FALSE" else control}
                outputs = {"RUNNING": row + 1}
        given |= {pin: net for pin, net in inputs.items() if isinstance(net, str)}
        written = ", ".join(f"{pin} := {text}" for pin, text in given.items())
        self._add(cell, f"<{name}: {variables.supporting(BLOCKS[letters])}({written})>",
                  self._head(left, row), self._tail(column, row),
                  inputs={pin: net for pin, net in inputs.items() if not isinstance(net, str)},
                  outputs={pin: self._tail(column, lower) for pin, lower in outputs.items()},
                  reads={base(preset)} if not preset.lstrip("-").isdigit() else (),
                  writes={name, *((given["VALUE"],) if letters == "C" else ())}, acts=True)


# ---- what is left of a drawing


def _alive(steps: list[Step]) -> list[Step]:
    """Without the elements whose power nobody reads."""
    used: set[Net | None] = set()
    kept = []
    for step in reversed(steps):
        step.tail = step.tail if step.tail in used else None
        step.outputs = {pin: net for pin, net in step.outputs.items() if net in used}
        if step.acts or step.tail is not None:
            kept.append(step)
            used |= {step.head, *step.inputs.values()}
    return kept[::-1]


def _wired(steps: list[Step]) -> list[Step]:
    """Without wires, as far as the nets at their ends can become one."""
    reading, feeding = _counts(steps)
    alias: dict[Net, Net] = {}

    def final(net: Net | None) -> Net | None:
        while net in alias:
            net = alias[net]
        return net

    kept = []
    for step in steps:
        head, tail = final(step.head), final(step.tail)
        if step.wire and tail is not None and feeding[tail] == 1:
            alias[tail] = head
        elif step.wire and head is not RAIL and tail is not None and reading[head] == 1:
            feeding[tail] += feeding[head] - 1
            alias[head] = tail
        else:
            kept.append(step)
            continue
        if head is not RAIL and alias.get(tail) == head:
            reading[head] += reading[tail] - 1
    for step in kept:
        step.head, step.tail = final(step.head), final(step.tail)
        step.inputs = {pin: final(net) for pin, net in step.inputs.items()}
        step.outputs = {pin: final(net) for pin, net in step.outputs.items()}
    return kept


def _counts(steps: list[Step]) -> tuple[dict[Net, int], dict[Net, int]]:
    """How many elements read, and how many feed, each net."""
    reading: dict[Net, int] = {}
    feeding: dict[Net, int] = {}
    for step in steps:
        for net in (step.head, *step.inputs.values()):
            reading[net] = reading.get(net, 0) + 1
        for net in (step.tail, *step.outputs.values()):
            feeding[net] = feeding.get(net, 0) + 1
    return reading, feeding


def _unfed(steps: list[Step]) -> list[Step]:
    """Nets that nothing feeds are fed with FALSE."""
    _, feeding = _counts(steps)
    missing = {}
    for step in steps:
        for net in (step.head, *step.inputs.values()):
            if net is not RAIL and net not in feeding:
                missing.setdefault(net, step.span)
    return [*(Step("[FALSE]", RAIL, net, span) for net, span in missing.items()), *steps]
