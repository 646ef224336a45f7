"""Geometry: from ranks and lines to shapes in character cells."""

from __future__ import annotations

from ldc.draw.arrange import Arrangement, attachments
from ldc.draw.figures import Figure, Port
from ldc.draw.labels import Options, text_width
from ldc.draw.shapes import Box, Dot, Drawing, Label, Rail, Shape, Symbol, Wire
from ldc.draw.sketch import RAIL, RIGHT
from ldc.parser import ast

def place(found: Arrangement, options: Options, width: int = 0) -> Drawing:
    """The shapes of a rung. The picture takes the columns that it needs, or ``width`` if that is more: the
    coils then move to the right."""
    return _Placer(found, options, width).place()


class _Placer:
    def __init__(self, found: Arrangement, options: Options, width: int) -> None:
        self.found, self.options = found, options
        self.shapes: list[Shape] = []
        needs = [3] * found.columns
        for figure in found.figures:
            needs[figure.column] = max(needs[figure.column], figure.width)
        self.needs = needs
        natural = sum(needs) + found.columns + 1
        self.stretch = max(0, width - natural)
        self.width = natural + self.stretch
        self.at = [0]
        for need in needs:
            self.at.append(self.at[-1] + need + 1)
        for rank in range(found.zone + 1, found.columns + 1):
            self.at[rank] += self.stretch
        if found.zone == found.columns:
            self.at[found.columns] = self.width - 1
        self.feeds = self.net_power()

    def x(self, net: int) -> int:
        return self.at[-1] if net == RIGHT else self.at[self.found.rank[net]]

    def first(self, figure: Figure) -> int:
        """The first column of a figure: the middles of contacts and coils stand under each other."""
        column, need = figure.column, self.needs[figure.column]
        begin = self.at[column] + 1 + (self.stretch if column == self.found.zone else 0)
        if figure.kind == "jump":
            return begin + need - figure.width
        if figure.kind in ("contact", "coil", "label"):
            return begin + (need - 1) // 2 - (figure.width - 1) // 2
        return begin + (need - figure.width) // 2

    # ---- power ------------------------------------------------------------------------------------

    def leaving(self, figure: Figure, pin: str | None = None) -> bool | None:
        """Whether power leaves a figure; a name tag passes on what its net has."""
        if self.options.power is None or isinstance(figure.node, ast.Junction):
            return None
        return self.options.power(figure.node, pin)

    def net_power(self) -> dict[int, bool | None]:
        """Power of each net: OR of what enters it; the rails have it."""
        if self.options.power is None:
            return {}
        power: dict[int, bool | None] = {}
        for figure in sorted(self.found.figures, key=lambda f: f.column):
            out = self.leaving(figure)
            if isinstance(figure.node, ast.Junction):
                out = self.power_of(power, figure.head)
            power[figure.tail] = _either(power.get(figure.tail), out)
            for port, _, left in figure.ports():
                if port.net is not None and not left:
                    power[port.net] = _either(power.get(port.net), self.leaving(figure, port.full))
        return power

    def power_of(self, power: dict[int, bool | None], net: int) -> bool | None:
        return True if net == RAIL or net in self.found.starts else power.get(net)

    def on(self, net: int) -> bool | None:
        return None if self.options.power is None else self.power_of(self.feeds, net)

    # ---- shapes -----------------------------------------------------------------------------------

    def place(self) -> Drawing:
        lines = self.found.lines
        self.add(Rail(0, 0, lines - 1), Rail(self.at[-1], 0, lines - 1))
        self.verticals()
        for figure in self.found.figures:
            getattr(self, "_" + figure.kind)(figure, self.first(figure))
        return Drawing(self.width, lines, tuple(self.shapes), self.cuts(), self.at[self.found.zone])

    def add(self, *shapes: Shape) -> None:
        self.shapes += shapes

    def cuts(self) -> tuple[int, ...]:
        """Just before and just behind the column of each net."""
        return tuple(sorted({at + side for at in self.at[1:-1] for side in (0, 1)}))

    def verticals(self) -> None:
        """Nets that join several lines, with a dot where wires meet."""
        for net, lines in attachments(self.found).items():
            if net in (RAIL, RIGHT):
                continue
            top, bottom = min(lines), max(lines)
            if net in self.found.starts:
                self.add(Rail(self.x(net), top, bottom, local=True))
            elif top < bottom:
                self.add(Wire(self.x(net), top, self.x(net), bottom, self.on(net)))
                for line in sorted(set(lines)):
                    if (line > top) + (line < bottom) + lines.count(line) > 2:
                        self.add(Dot(self.x(net), line, self.on(net)))

    def wires(self, figure: Figure, left: int, right: int) -> None:
        """The wires from its nets to the cells ``left`` and ``right`` of a figure."""
        if figure.wired_in:
            self.add(Wire(self.x(figure.head), figure.y, left, figure.y, self.on(figure.head)))
        if figure.wired_out:
            self.add(Wire(right, figure.y, self.x(figure.tail), figure.y, self.out(figure)))

    def out(self, figure: Figure) -> bool | None:
        return self.on(figure.head) if isinstance(figure.node, ast.Junction) else self.leaving(figure)

    def _contact(self, figure: Figure, x: int) -> None:
        middle, modifier = x + (figure.width - 1) // 2, figure.node.modifier
        on, y = self.leaving(figure), figure.y
        self.wires(figure, middle - 1, middle + 1)
        self.add(Symbol(figure.kind, modifier, middle, y, on, figure.mark, figure.full))
        self.text(figure, figure.lines[0], middle, y - 1, "middle", "operand", figure.full)
        for number, note in enumerate(figure.notes, 1):
            self.text(figure, note, middle, y + number, "middle", "note")
        self.caret(figure, middle, y + 1 + len(figure.notes), 3)

    _coil = _contact

    def _expression(self, figure: Figure, x: int) -> None:
        left, width, top = x + 1, figure.width - 2, figure.y - figure.above
        self.wires(figure, left, left + width - 1)
        on = self.leaving(figure)
        self.add(Box("expression", left, top, width, len(figure.lines) + 2, on, figure.mark, figure.full))
        for number, line in enumerate(figure.lines, 1):
            self.text(figure, line, left + 2, top + number, "start", "expression")
        self.caret(figure, left + (width - 1) / 2, top + len(figure.lines) + 2, width)

    def _jump(self, figure: Figure, x: int) -> None:
        self.wires(figure, x - 1, 0)
        self.text(figure, figure.lines[0], x, figure.y, "start", "jump", figure.full)
        self.caret(figure, x + (figure.width - 2) / 2, figure.y + 1, figure.width - 1)

    def _label(self, figure: Figure, x: int) -> None:
        middle = x + (figure.width - 1) // 2
        self.wires(figure, middle, middle)
        self.add(Dot(middle, figure.y, self.on(figure.head)))
        self.text(figure, figure.lines[0], middle, figure.y - 1, "middle", "tag", figure.full)
        self.caret(figure, middle, figure.y + 1, 1)

    def _source(self, figure: Figure, x: int) -> None:
        end = x + text_width(figure.lines[0])
        self.wires(figure, 0, end + 1)
        self.text(figure, figure.lines[0], x, figure.y, "start", "tag", figure.full)
        self.caret(figure, (x + end - 1) / 2, figure.y + 1, end - x)

    def _sink(self, figure: Figure, x: int) -> None:
        begin = self.at[figure.column] + 3
        self.wires(figure, begin - 2, 0)
        self.text(figure, figure.lines[0], begin, figure.y, "start", "tag", figure.full)
        size = text_width(figure.lines[0])
        self.caret(figure, begin + (size - 1) / 2, figure.y + 1, size)

    def _block(self, figure: Figure, x: int) -> None:
        left, right = x + figure.left, x + figure.left + figure.box - 1
        top, bottom = figure.y - 2, figure.y + figure.rows[-1].offset + 1
        self.wires(figure, left, right)
        on = self.leaving(figure)
        self.add(Box("block", left, top, figure.box, bottom - top + 1, on, figure.mark, figure.full))
        middle = left + (figure.box - 1) / 2
        self.text(figure, figure.lines[0], middle, top + 1, "middle", "type", figure.node.type)
        if len(figure.lines) > 1:
            name = figure.full.removesuffix(f": {figure.node.type}")
            self.text(figure, figure.lines[1], middle, top - 1, "middle", "name", name)
        for row in figure.rows:
            if row.left is not None:
                self.pin(figure, row.left, left, figure.y + row.offset, True)
            if row.right is not None:
                self.pin(figure, row.right, right, figure.y + row.offset, False)
        self.caret(figure, middle, bottom + 1, figure.box)

    def pin(self, figure: Figure, port: Port, edge: int, y: int, is_left: bool) -> None:
        step, anchor = (-1, "start") if is_left else (1, "end")
        self.text(figure, port.name, edge - step, y, anchor, "pin", port.full if not port.text else "")
        if port.net is not None:
            x = self.x(port.net)
            on = self.on(port.net) if is_left else self.leaving(figure, port.full)
            self.add(Wire(min(x, edge), y, max(x, edge), y, on))
        elif port.text:
            self.add(Wire(min(edge, edge + 2 * step), y, max(edge, edge + 2 * step), y))
            role = "tag" if isinstance(port.value, ast.Junction) else "value"
            outer = "end" if is_left else "start"
            self.text(figure, port.text, edge + 4 * step, y, outer, role, port.full)

    def text(
        self, figure: Figure, text: str, x: float, y: int, anchor: str, role: str, full: str = ""
    ) -> None:
        if text:
            whole = full if full != text else ""
            self.add(Label(text, x, y, anchor, role, whole, figure.mark, self.leaving(figure)))

    def caret(self, figure: Figure, x: float, y: int, width: int) -> None:
        if figure.mark and self.options.carets:
            self.add(Label("^" * width, x, y, "middle", "caret", mark=figure.mark))


def _either(a: bool | None, b: bool | None) -> bool | None:
    return True if a or b else b if a is None else a
