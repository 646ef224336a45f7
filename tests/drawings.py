"""Rungs to draw, and readers of drawings: what is connected with what, in the text and in the picture."""

from __future__ import annotations

import re

from hypothesis import strategies as st

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, parse_file
from ldc.source import SourceFile

RUNGS = {
    "seal_in": "{ [start] | [motor] } [/stop] (motor)",
    "timer_and_counter": (
        "[motor] <warm: TON(PT := T#2s)> { (ready) | (S started) | [P eye] "
        "<parts: CTU(R := { [reset] | [clear] }, PV := 100, CV => count)> (full) }"
    ),
    "comparison": "[ready] [level > 80.0] <MOVE(IN := 1200, OUT => speed)>",
    "bridge": "{ [a] @x [b] | [c] @y [d] } (q); @x [e] @y",
    "jump": "[fault] >>stop_all",
    "wraps": " ".join(f"[contact_{i}]" for i in range(20)) + " (q)",
    "wraps_in_parallel": (
        "{ " + " | ".join(" ".join(f"[n{j}_{i}]" for i in range(16)) for j in range(3)) + " } (q)"
    ),
    "eight_branches": "{ " + " | ".join(f"[in{i}]" for i in range(8)) + " } [/x] { (q) | (S r) | (R t) }",
    "nested": "{ [a] { [b] | [c] { [d] [e] | [f] } } | [g] [h] | { [i] | [j] } [k] } [N l] (m)",
    "five_pins": (
        "[up] <c: CTUD(CD := down, R := { [r1] [r2] | [r3] }, LD := load_it, PV := 10, QD => @low, "
        "CV => value)> (high); @low (is_low)"
    ),
    "block_chain": (
        "[a] <t1: TON(PT := T#1s)> <t2: TOF(PT := T#2s, ET => rest)> <c: CTU(R := @n, PV := 3)> (done); "
        "[x] @n (y)"
    ),
    "own_rail": "[x] { <parts: CTU(R := { [reset] }, PV := 5)> (a) | [b] (c) }",
    "several_paths": "[a] (q) (r); [b] @y; @y [c] (s); [d] { (u) | (v) } (/ w)",
    "not_planar": "{ [a] @x [b] | [c] @y [d] | [e] @z [f] } (q); @x [g] @z; @z [h] @y; @x [i] @y",
    "loop": "[a] @in <t: TON(PT := T#1s, ET => e)> @out (q); @out [/b] @in",
    "chosen_pins": "[a] <c: CTUD(CU := b, PV := 3) in=CD out=QD> (q)",
    "not_wired": "<ADD(IN1 := x, IN2 := y, OUT => sum) in=_> (ok)",
    "operand_at_power": "<t: TON(IN := a, PT := T#1s, Q => b) in=_ out=_>",
    "junction_at_power": "[x] @up; <t: TON(IN := @up, PT := T#1s, Q => @done) in=_ out=_>; @done [y] (q)",
    "network_at_own_place": "<t: TON(IN := { [a] | [b] [/c] }, PT := T#1s) in=_> (q)",
    "unknown_block": "[a] <jog: AXIS_JOG(speed := 10.0, done => at_end)> (q)",
    "long_expression": (
        "[temperature > limits.hot OR (pressure >= 17.5 AND mode = Mode#automatic) OR NOT door.closed] "
        "(alarm)"
    ),
}


def rung(text: str, name: str = "", title: str = "") -> ast.Rung:
    """The rung that ``text`` says; fails when it says none."""
    about = f'"{title}"' if title else ""
    found = Diagnostics()
    source = SourceFile("x.ld", f"PROGRAM p\nRUNG {name} {about}\n{text}\nEND_PROGRAM\n")
    file = parse_file(source, found)
    assert not len(found), [f"{d.code} {d.message}" for d in found]
    return file.pous[0].body.rungs[0]


# ---- random rungs -----------------------------------------------------------------------------


class _Writer:
    """Draws a rung's text from Hypothesis; every element has an operand of its own."""

    def __init__(self, draw, blocks: bool) -> None:
        self.draw, self.blocks, self.operands = draw, blocks, []

    def name(self) -> str:
        name = f"n{len(self.operands)}" + "x" * self.draw(st.integers(0, 8))
        self.operands.append(name)
        return name

    def item(self, depth: int) -> str:
        kinds = ["contact"] * 4 + ["coil", "junction"]
        kinds += ["branches"] * 2 if depth else []
        kinds += ["block", "function"] if self.blocks and depth else []
        match self.draw(st.sampled_from(kinds)):
            case "contact":
                return f"[{self.draw(st.sampled_from(['', '/', 'P ', 'N ']))}{self.name()}]"
            case "coil":
                return f"({self.draw(st.sampled_from(['', '/', 'S ', 'R ']))}{self.name()})"
            case "junction":
                return "@" + self.draw(st.sampled_from("xyz"))
            case "branches":
                return self.branches(depth - 1)
            case "function":
                return f"<ADD(IN1 := {self.name()}, IN2 := 7, OUT => {self.name()})>"
        network = self.branches(depth - 1)
        reset = self.draw(st.sampled_from(["R := @x, ", "", f"R := {network}, "]))
        return f"<{self.name()}: CTU({reset}PV := {self.name()}, CV => {self.name()})>"

    def path(self, depth: int) -> str:
        return " ".join(self.item(depth) for _ in range(self.draw(st.integers(1, 4))))

    def branches(self, depth: int) -> str:
        return "{ " + " | ".join(self.path(depth) for _ in range(self.draw(st.integers(1, 3)))) + " }"


@st.composite
def rung_texts(draw, blocks: bool = True) -> str:
    writer = _Writer(draw, blocks)
    return "; ".join(writer.path(2) for _ in range(draw(st.integers(1, 3))))


# ---- nets -------------------------------------------------------------------------------------


class Nets:
    """Union-find over anything hashable."""

    def __init__(self) -> None:
        self.parent: dict = {}

    def find(self, key):
        self.parent.setdefault(key, key)
        while self.parent[key] != key:
            key = self.parent[key]
        return key

    def join(self, a, b) -> None:
        self.parent[self.find(a)] = self.find(b)

    def partition(self, terminals) -> set[frozenset]:
        """The nets that feed something; whether two ends meet only at the right rail means nothing."""
        groups: dict = {}
        for terminal in terminals:
            groups.setdefault(self.find(terminal), set()).add(terminal)
        return {frozenset(group) for group in groups.values() if any(side == "left" for _, side in group)}


def meant(drawn: ast.Rung) -> set[frozenset]:
    """The nets of a rung of contacts, coils and junctions, as sets of (operand, side) and the rails."""
    nets, terminals, count = Nets(), {("rail", "left")}, 0

    def new():
        nonlocal count
        count += 1
        return count

    def path(items, head, tail):
        for index, item in enumerate(items):
            if isinstance(item, ast.Junction):
                nets.join(head, "@" + item.name)
                if index == len(items) - 1 and tail is not None:
                    nets.join(head, tail)
                continue
            after = tail if index == len(items) - 1 and tail is not None else new()
            if isinstance(item, ast.Branches):
                for own in item.paths:
                    path(own.items, head, after)
            else:
                name = (item.expr if isinstance(item, ast.Contact) else item.target).name
                terminals.update({(name, "left"), (name, "right")})
                nets.join((name, "left"), head)
                nets.join((name, "right"), after)
            head = after

    for own in drawn.paths:
        path(own.items, new() if isinstance(own.items[0], ast.Junction) else ("rail", "left"), None)
    return nets.partition(terminals)


ARMS = {
    "│": "ud", "─": "lr", "┌": "dr", "┐": "dl", "└": "ur", "┘": "ul", "├": "udr", "┤": "udl", "┬": "dlr",
    "┴": "ulr", "┼": "udlr", "●": "lr",
}
SYMBOL = re.compile(r"(?<=─)(┤[ /PN]├|\([ /SRPN]\))(?=─)")


def read_back(text: str) -> set[frozenset]:
    """The nets that a text drawing shows, found by following its lines; ends at the right rail are open."""
    nets, terminals = Nets(), {("rail", "left")}
    rows = text.split("\n")
    width = max(map(len, rows))
    rows = [row.ljust(width) for row in rows]
    cells = {}
    for y, row in enumerate(rows):
        for x, char in enumerate(row):
            if char in ARMS:
                cells[x, y] = ARMS[char]
        for match in SYMBOL.finditer(row):
            left, right = match.start(), match.end() - 1
            label = next(
                m[0] for m in re.finditer(r"\w+", rows[y - 1]) if m.start() <= left + 1 < m.end()
            )
            cells.pop((left, y), None)
            cells.pop((right, y), None)
            terminals |= {(label, "left"), (label, "right")}
            nets.join((label, "left"), (left - 1, y))
            nets.join((label, "right"), (right + 1, y))
        for match in re.finditer(r"(\d+)►|►(\d+)", row):
            number, at = match[1] or match[2], match.end() if match[1] else match.start() - 1
            nets.join(("arrow", number), (at, y))
        for match in re.finditer(r"@\w+", row):
            _tag(nets, cells, rows, match, y)
    rails = {max(x for x, y in cells if band <= y < end) for band, end in _bands(rows)[-1:]}
    for (x, y), arms in cells.items():
        in_last = y >= _bands(rows)[-1][0]
        if x in rails and in_last:
            continue
        if x == 0:
            nets.join((x, y), ("rail", "left"))
        if "r" in arms and "l" in cells.get((x + 1, y), "") and not (x + 1 in rails and in_last):
            nets.join((x, y), (x + 1, y))
        if "d" in arms and "u" in cells.get((x, y + 1), ""):
            nets.join((x, y), (x, y + 1))
    return nets.partition(terminals)


def _bands(rows: list[str]) -> list[tuple[int, int]]:
    """First and last line of each band; blank lines stand between."""
    starts = [0] + [y + 1 for y, row in enumerate(rows) if not row.strip()]
    return list(zip(starts, [*starts[1:], len(rows)], strict=True))


def _tag(nets: Nets, cells: dict, rows: list[str], match: re.Match, y: int) -> None:
    name, start, end = match[0], match.start(), match.end()
    below = rows[y + 1] if y + 1 < len(rows) else ""
    dot = below.find("●", start, end)
    if dot >= 0:
        nets.join(name, (dot, y + 1))
    elif rows[y][end : end + 2] == " ─":
        nets.join(name, (end + 1, y))
    elif rows[y][start - 2 : start] == "─ ":
        nets.join(name, (start - 2, y))
    else:
        raise AssertionError(f"{name} stands at no wire")
