"""Rungs for the tests of ldc.graph: from text to a checked graph, random ones, and a domain that records.

Every rung may use ``a0``..``a5`` and ``q0``..``q3`` (BOOL), ``i0``..``i2`` (INT), ``r0`` (REAL) and the
instances ``u0``..``u9`` (CTUD) and ``t0``..``t9`` (TON).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from random import Random
from typing import Any

from hypothesis import strategies as st

from ldc.diagnostics import Diagnostic, Diagnostics
from ldc.expr import Expr, Load, Place
from ldc.graph import rules
from ldc.graph.build import build
from ldc.graph.rung import RungGraph
from ldc.library import blocks, functions
from ldc.model import Scope, resolve
from ldc.model.elements import Block, Contact
from ldc.model.project import Model
from ldc.parser import ast, parse_file
from ldc.source import SourceFile, Span
from ldc.types import BOOL, Instance, Type, default

DECLARATIONS = f"""VAR
    {", ".join(f"a{n}" for n in range(6))}, {", ".join(f"q{n}" for n in range(4))} : BOOL;
    i0, i1, i2 : INT; r0 : REAL;
    {", ".join(f"u{n}" for n in range(10))} : CTUD;
    {", ".join(f"t{n}" for n in range(10))} : TON;
END_VAR
"""


def drawn(text: str) -> tuple[RungGraph | None, list[Diagnostic]]:
    """The graph of a rung, None when it breaks a rule, and everything that was found."""
    diagnostics = Diagnostics()
    graph = _built(text, diagnostics)
    fine = graph is not None and rules.check(graph, diagnostics)
    return (graph if fine else None), list(diagnostics)


def drawn_unchecked(text: str) -> RungGraph:
    graph = _built(text, Diagnostics())
    assert graph is not None
    return graph


def _built(text: str, diagnostics: Diagnostics) -> RungGraph | None:
    (rung,) = _parsed(f"PROGRAM main\nRUNG r\n{text}\nEND_PROGRAM\n", diagnostics).pous[0].body.rungs
    return build(rung, "r", Scope(_model(), "main"), diagnostics)


def _parsed(text: str, diagnostics: Diagnostics) -> ast.File:
    file = parse_file(SourceFile("rung.ld", text), diagnostics)
    assert not diagnostics.has_errors, [d.message for d in diagnostics]
    return file


@cache
def _model() -> Model:
    """The declarations are resolved once for all tests."""
    found = Diagnostics()
    file = _parsed(f"PROGRAM main\n{DECLARATIONS}RUNG other\n(q0)\nEND_PROGRAM\n", found)
    return resolve(ast.Project((file,)), found)


def plain_graph(elements: Sequence[tuple]) -> RungGraph:
    """A graph of (head, tail) for contacts and (head, tail, "block") for timers, made without a text."""
    made, span = [], Span(SourceFile("rung.ld", ""), 0, 0)
    for n, (_, _, *kind) in enumerate(elements):
        if kind:
            instance = Place(f"t{n}", Instance("TON"))
            made.append(Block("TON", blocks.signature("TON"), instance, (), (), "IN", "Q", span))
        else:
            made.append(Contact("open", Load(Place(f"a{n}", BOOL)), span))
    nets = max(max(e[:2]) for e in elements) + 1
    names = ("rail", *(f"#{n}" for n in range(1, nets)))
    heads, tails = tuple(e[0] for e in elements), tuple(e[1] for e in elements)
    return RungGraph("r", "r", None, tuple(made), heads, tails, names, span)


def graph_of(text: str) -> RungGraph:
    """The graph of a rung that keeps to the rules."""
    graph, found = drawn(text)
    assert graph is not None, [f"{d.code} {d.message}" for d in found]
    return graph


def codes(text: str) -> list[str]:
    return [d.code for d in drawn(text)[1]]


def random_text(random: Random, *, loops: bool = False, blocks: bool = True) -> str:
    """A network of named nets, each fed by paths from earlier ones (with ``loops`` also from later ones,
    through a block). Not every text keeps to the rules."""
    return _Random(random, loops, blocks).text()


def texts(**options: bool) -> st.SearchStrategy[str]:
    return st.integers(0, 1 << 32).map(lambda seed: random_text(Random(seed), **options))


class _Random:
    def __init__(self, random: Random, loops: bool, blocks: bool) -> None:
        self.random, self.loops, self.blocks = random, loops, blocks
        self.nets = random.randint(1, 5)
        self.used = 0

    def text(self) -> str:
        random = self.random
        paths = []
        for net in range(1, self.nets + 1):
            for _ in range(random.choice((1, 1, 2, 3))):
                source = random.randint(0, net - 1)
                paths.append(self.path(source, net, f"@n{net}"))
        for net in {self.nets, *(random.randint(0, self.nets) for _ in range(random.randint(0, 4)))}:
            paths.append(self.path(net, net, f"(q{random.randint(0, 3)})"))
        if self.loops and self.blocks:
            for _ in range(random.randint(1, 3)):
                source, target = random.randint(1, self.nets), random.randint(1, self.nets)
                before, after = self.contacts(0, 1), self.contacts(0, 1)
                paths.append(" ".join((f"@n{source}", *before, self.block(self.nets), *after, f"@n{target}")))
        if random.random() < 0.5:
            random.shuffle(paths)
        return ";\n".join(paths)

    def path(self, source: int, net: int, end: str) -> str:
        start = (f"@n{source}",) if source else ()
        return " ".join((*start, *self.items(net, 2), end))

    def contacts(self, least: int, most: int) -> list[str]:
        return [self.contact() for _ in range(self.random.randint(least, most))]

    def contact(self) -> str:
        kind = self.random.choice(("", "", "", "/", "P ", "N "))
        if self.random.random() < 0.1:
            return f"[a{self.random.randint(0, 5)} AND NOT q{self.random.randint(0, 3)}]"
        return f"[{kind}{self.random.choice('aaq')}{self.random.randint(0, 3)}]"

    def items(self, net: int, depth: int) -> list[str]:
        random, items = self.random, self.contacts(1, 2)
        if random.random() < 0.3:
            items.append(f"({random.choice(('', '/', 'S ', 'R ', 'P ', 'N '))}q{random.randint(0, 3)})")
        if depth and random.random() < 0.3:
            branches = " | ".join(" ".join(self.items(net, depth - 1)) for _ in range(random.randint(2, 3)))
            items.append(f"{{ {branches} }}")
        if self.blocks and random.random() < 0.25:
            items.append(self.block(net))
        random.shuffle(items)
        return items

    def block(self, net: int) -> str:
        random = self.random
        self.used += 1
        if self.used > 9 or random.random() < 0.3:
            return f"<t{self.used}: TON(PT := T#1s)>" if self.used <= 9 else self.contact()
        pins = [f"PV := i{random.randint(0, 2)}"]
        for pin in ("CD", "R", "LD"):
            choice = random.random()
            if choice < 0.15:
                pins.append(f"{pin} := {{ {' '.join(self.items(net, 1))} }}")
            elif choice < 0.45:
                pins.append(f"{pin} := @n{random.randint(1, self.nets if self.loops else max(1, net - 1))}")
        if random.random() < 0.3:
            pins.append(f"QD => @n{random.randint(1 if self.loops else min(net + 1, self.nets), self.nets)}")
        elif random.random() < 0.3:
            pins.append(f"QD => q{random.randint(0, 3)}")
        power = random.choice(("", "", " in=_", " in=LD", " out=_")) if len(pins) == 1 else ""
        return f"<u{self.used}: CTUD({', '.join(pins)}){power}>"


class Recorder:
    """A domain of Python values that writes down what happens. Blocks are made up: their outputs are a
    hash of their name, how often they ran and their inputs."""

    true, false = True, False

    def __init__(self, values: Mapping[str, Any]) -> None:
        self.values = dict(values)
        self.hidden: dict[str, Any] = {}
        self.runs: dict[int, int] = {}
        self.events: list[tuple] = []

    and_ = staticmethod(lambda a, b: a and b)
    or_ = staticmethod(lambda a, b: a or b)
    not_ = staticmethod(lambda a: not a)
    zero = staticmethod(default)
    choose = staticmethod(lambda when, yes, no: yes if when else no)

    def contact(self, expr: Expr, power: bool) -> bool:
        return bool(power) and self.value(expr, True)

    def value(self, expr: Expr, when: bool) -> Any:
        if isinstance(expr, Load):
            return self.values.get(str(expr.place), default(expr.type))
        if not hasattr(expr, "args"):
            return expr.value
        return functions.meaning(expr.op, tuple(a.type for a in expr.args), expr.type)(
            *(self.value(a, when) for a in expr.args))

    def convert(self, value: Any, source: Type, target: Type) -> Any:
        return functions.meaning(functions.conversion(source, target), (source,), target)(value)

    def store(self, place: Place, value: Any, when: bool) -> None:
        if when:
            self.values[str(place)] = value
            self.events.append(("store", str(place), value))

    def recall(self, name: str, type_: Type = BOOL) -> Any:
        return self.hidden.get(name, default(type_))

    def remember(self, name: str, value: Any, type_: Type = BOOL) -> None:
        self.hidden[name] = value

    def call_block(self, index: int, block: Block, inputs: Mapping[str, Any]) -> dict[str, Any]:
        self.runs[index] = self.runs.get(index, 0) + 1
        seen = tuple(sorted(inputs.items()))
        self.events.append(("call", index, seen))
        return {p.name: self._made_up((index, self.runs[index], seen, p.name), p.type)
                for p in block.signature.outputs}

    def call_function(
        self, index: int, block: Block, enable: bool, inputs: Mapping[str, Any],
    ) -> tuple[bool, dict]:
        if enable:
            self.events.append(("function", index, tuple(inputs.items())))
        return enable, {"OUT": self._made_up((index, tuple(inputs.items())), block.signature.result)}

    @staticmethod
    def _made_up(seed: tuple, type_: Type) -> Any:
        bits = Random(repr(seed)).getrandbits(8)
        return bool(bits & 1) if type_ == BOOL else type(default(type_))(bits)

    def jump(self, index: int, label: str | None, when: bool) -> None:
        if when:
            self.events.append(("jump", index, label))


def variables(random: Random) -> dict[str, bool]:
    names = (*(f"a{n}" for n in range(6)), *(f"q{n}" for n in range(4)))
    return {name: random.random() < 0.5 for name in names}
