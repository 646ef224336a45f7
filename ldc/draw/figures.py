"""The figures on a wire and how much room each needs: contacts, coils, blocks, jumps, name tags."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ldc.draw.labels import BlockPins, Options, fold, shorten, text_width
from ldc.parser import ast
from ldc.parser.unparse import expr_text

OPERANDS = (ast.Name, ast.Direct, ast.Member, ast.Index, ast.Literal, ast.EnumLiteral)
MOST_OPERAND, MOST_EXPRESSION, MOST_NOTE, MOST_PIN, MOST_TYPE = 40, 36, 18, 14, 28


@dataclass(slots=True)
class Port:
    """A pin of a block: its name inside the box and, outside, a text or a wire from or to ``net``.

    ``group`` is the pin's own network with the lines that it needs above and below the pin's row.
    """

    name: str
    value: ast.Expr | ast.Branches | ast.Junction | None = None
    text: str = ""
    full: str = ""
    net: int | None = None
    group: object | None = None
    above: int = 0
    below: int = 0


@dataclass(slots=True)
class Row:
    """A line of a block, ``offset`` lines under its power wire."""

    offset: int
    left: Port | None
    right: Port | None


@dataclass(slots=True)
class Figure:
    """One drawn element. ``width`` columns; ``above`` and ``below`` its wire: lines that are its own.

    ``kind``: contact coil expression block jump, and the name tags of a junction: label (in a wire),
    source (a wire begins), sink (a wire ends). ``head`` and ``tail`` are the nets that it stands between;
    ``wired_in`` and ``wired_out`` tell whether a wire is drawn to them. ``y`` and ``column`` come later.
    """

    kind: str
    node: ast.Item
    lines: tuple[str, ...]
    width: int
    above: int = 1
    below: int = 0
    notes: tuple[str, ...] = ()
    full: str = ""
    mark: str | None = None
    rows: tuple[Row, ...] = ()
    box: int = 0
    left: int = 0
    head: int = 0
    tail: int = 0
    wired_in: bool = True
    wired_out: bool = True
    y: int = 0
    column: int = 0

    def ports(self) -> Iterator[tuple[Port, int, bool]]:
        """(port, line offset, on the left) of all pins."""
        for row in self.rows:
            if row.left is not None:
                yield row.left, row.offset, True
            if row.right is not None:
                yield row.right, row.offset, False


Marks = dict[int, str]


def marks_of(rung: ast.Rung, options: Options) -> Marks:
    """Style by ``id`` of the node: each marked span goes to the smallest drawn element that holds it."""
    marks: Marks = {}
    if not options.mark:
        return marks
    nodes = list(drawn(rung))
    for span, style in options.mark.items():
        holders = [
            n for n in nodes
            if n.span.source is span.source and n.span.start <= span.start and span.end <= n.span.end
        ]
        if holders:
            marks[id(min(holders, key=lambda n: n.span.end - n.span.start))] = style
    return marks


def drawn(rung: ast.Rung) -> Iterator[ast.Item]:
    """All elements and junctions of a rung in text order, those of pin networks too."""
    stack = [item for path in reversed(rung.paths) for item in reversed(path.items)]
    while stack:
        item = stack.pop()
        if isinstance(item, ast.Branches):
            stack += [i for path in reversed(item.paths) for i in reversed(path.items)]
            continue
        yield item
        if isinstance(item, ast.Block):
            values = (pin.value for pin in reversed(item.pins))
            stack += [v for v in values if isinstance(v, ast.Branches | ast.Junction)]


def simple(item: ast.Item, options: Options, marks: Marks) -> Figure:
    """A contact, a coil or a jump."""
    mark = marks.get(id(item))
    caret = 1 if mark and options.carets else 0
    match item:
        case ast.Jump(target):
            full = f">>{target}"
            text = shorten(full, room(options) - 2)
            return Figure("jump", item, (text,), text_width(text) + 1, 1, caret, full=full, mark=mark)
        case ast.Contact(_, expr) if not isinstance(expr, OPERANDS):
            return _expression(item, caret, options, mark)
        case ast.Contact(_, expr) | ast.Coil(_, expr):
            kind = "contact" if isinstance(item, ast.Contact) else "coil"
    full = expr_text(expr)
    text = shorten(full, min(room(options) - 2, MOST_OPERAND))
    known = options.notes.get(expr.name.upper(), ()) if isinstance(expr, ast.Name) else ()
    notes = tuple(shorten(note, max(MOST_NOTE, text_width(text))) for note in known)
    width = max(3, *map(text_width, (text, *notes))) + 2
    below = len(notes) + caret + (1 if notes else 0)
    return Figure(kind, item, (text,), width, 1, below, notes, full, mark)


def _expression(item: ast.Contact, caret: int, options: Options, mark: str | None) -> Figure:
    full = expr_text(item.expr)
    if item.modifier:
        full = f"{item.modifier} ({full})"
    lines = fold(full, min(room(options) - 6, MOST_EXPRESSION))
    width = max(map(text_width, lines)) + 6
    middle = (len(lines) - 1) // 2
    below = len(lines) - middle + caret
    return Figure("expression", item, lines, width, middle + 1, below, full=full, mark=mark)


def tag(item: ast.Junction, options: Options, marks: Marks, kind: str) -> Figure:
    mark = marks.get(id(item))
    full = "@" + item.name
    text = shorten(full, min(room(options) - 2, MOST_OPERAND))
    width = text_width(text) + (3 if kind == "sink" else 2)
    return Figure(kind, item, (text,), width, 1, 1 if mark and options.carets else 0, full=full, mark=mark)


def room(options: Options) -> int:
    """Columns that a figure may take: the page without rails and continuation arrows."""
    return max(options.width, 48) - 12


# ---- blocks -----------------------------------------------------------------------------------


def ports(block: ast.Block, options: Options) -> tuple[list[Port], list[Port], bool, bool]:
    """Ports at the left and the right, the power's first; whether the power is wired in and out."""
    is_function = block.instance is None
    known = options.pins_of(block) or (
        BlockPins(("EN",), ("ENO",), "EN", "ENO") if is_function else BlockPins((), (), "", "")
    )
    power_in, power_out = _power(block.power_in, known.power_in), _power(block.power_out, known.power_out)
    left = _side(block, known.inputs, power_in, False, is_function)
    right = _side(block, known.outputs, power_out, True, is_function)
    return left, right, power_in[1], power_out[1]


def _power(chosen: str | None, usual: str | None) -> tuple[str | None, bool]:
    """The name of a power pin, and whether it is wired."""
    if chosen == "_":
        return usual, False
    return (usual, usual is not None) if chosen is None else (chosen, True)


def _side(
    block: ast.Block, declared: tuple[str, ...], power: tuple[str | None, bool], output: bool,
    is_function: bool
) -> list[Port]:
    """The power's pin stands first. When no power is wired, an operand may be: it is drawn there, unless it
    is a network, which stands at the pin's own place and leaves the power's empty."""
    written = [pin for pin in block.pins if pin.output is output]
    by_name = {pin.name.upper(): pin for pin in written if pin.name is not None}
    positional = [pin for pin in written if pin.name is None]
    first, wired = power[0] or "", power[1]
    head = None if wired else by_name.get(first.upper())
    if head is not None and isinstance(head.value, ast.Branches):
        first, head = "", None
    elif head is not None:
        del by_name[first.upper()]
    result = [_port(first, head)]
    for name in declared:
        if name.upper() == first.upper():
            continue
        pin = by_name.pop(name.upper(), None)
        if pin is None and positional and not output:
            pin = positional.pop(0)
        result.append(_port(name, pin))
    result += [_port(pin.name, pin) for pin in by_name.values()]
    for number, pin in enumerate(positional, 1):
        known = not is_function or len(declared) > 1
        name = "" if known else "IN" if len(positional) == 1 else f"IN{number}"
        result.append(_port(name, pin))
    return result


def _port(name: str, pin: ast.Pin | None) -> Port:
    port = Port(shorten(name, MOST_PIN), full=name)
    if pin is not None:
        port.value = pin.value
        if isinstance(pin.value, ast.Junction):
            port.text = port.full = "@" + pin.value.name
        elif not isinstance(pin.value, ast.Branches):
            port.text = port.full = expr_text(pin.value)
    return port


def block(item: ast.Block, left: list[Port], right: list[Port], options: Options, marks: Marks) -> Figure:
    """Rows at equal heights left and right; the pin networks at the left open them further."""
    rows, offset, taken = [], 0, 0
    for index in range(max(len(left), len(right))):
        port = left[index] if index < len(left) else None
        offset = taken + 1 + (port.above if port is not None else 0) if index else 0
        taken = offset + (port.below if port is not None else 0)
        rows.append(Row(offset, port, right[index] if index < len(right) else None))
    title = shorten(item.type, MOST_TYPE)
    whole = expr_text(item.instance) if item.instance else ""
    name = shorten(whole, min(MOST_OPERAND, room(options) - 2))
    pairs = [[text_width(port.name) if port else 0 for port in (row.left, row.right)] for row in rows]
    box = max(text_width(title) + 4, *(a + b + (2 if a and b else 1) + 2 for a, b in pairs), 7)
    outside = room(options) - box - 8
    _fit(left, right, outside)
    before = max((text_width(p.text) + 4 for p in left if p.text and p.net is None), default=1)
    behind = max((text_width(p.text) + 4 for p in right if p.text and p.net is None), default=1)
    over = max(0, text_width(name) + 2 - box)
    before, behind = max(before, (over + 1) // 2), max(behind, (over + 1) // 2)
    mark = marks.get(id(item))
    below = max(rows[-1].offset + 1 + (1 if mark and options.carets else 0), taken)
    full = f"{whole}: {item.type}" if whole else item.type
    return Figure(
        "block", item, (title, name) if name else (title,), before + box + behind, 3 if name else 2, below,
        full=full, mark=mark, rows=tuple(rows), box=box, left=before,
    )


def _fit(left: list[Port], right: list[Port], outside: int) -> None:
    """Shorten the texts beside a box so that both sides together take ``outside`` columns."""
    widest = [max((text_width(p.text) for p in side), default=0) for side in (left, right)]
    if sum(widest) > outside:
        half = max(outside // 2, 6)
        small = min(widest)
        limit = max(half, outside - small)
        for side, own in zip((left, right), widest, strict=True):
            for port in side:
                port.text = shorten(port.text, limit if own > half else max(own, 1))
