"""Hypothesis strategies: random expressions, rungs and programs in the language of DESIGN section 2.

Inputs are ``a0``, ``a1``, ...; outputs ``q0``, ``q1``, ...; all BOOL. Nodes have an empty span; whoever needs
real ones parses ``program_text``.
"""

from __future__ import annotations

from collections.abc import Sequence

from hypothesis import strategies as st

from ldc.parser import ast
from ldc.parser.unparse import rung_text
from ldc.source import SourceFile, Span

NOWHERE = Span(SourceFile("random.ld", ""), 0, 0)
CONTACTS, COILS = ("", "/", "P", "N"), ("", "/", "S", "R", "P", "N")
COMPARISONS, SUMS = ("=", "<>", "<", ">", "<=", ">="), ("+", "-", "*", "/", "MOD", "**")


def inputs(count: int) -> tuple[str, ...]:
    return tuple(f"a{i}" for i in range(count))


def outputs(count: int) -> tuple[str, ...]:
    return tuple(f"q{i}" for i in range(count))


def name(text: str) -> ast.Name:
    return ast.Name(text, NOWHERE)


# ---- expressions


def bool_expressions(names: Sequence[str], max_leaves: int = 12) -> st.SearchStrategy[ast.Expr]:
    """Well-typed BOOL expressions of BOOL variables."""
    leaves = st.sampled_from(names).map(name) | st.booleans().map(
        lambda value: ast.Literal(value, "BOOL", str(value).upper(), NOWHERE))

    def grow(inner):
        return (
            st.builds(lambda e: ast.Unary("NOT", e, NOWHERE), inner)
            | st.builds(lambda op, a, b: ast.Binary(op, a, b, NOWHERE),
                        st.sampled_from(("AND", "OR", "XOR", "=", "<>")), inner, inner)
        )

    return st.recursive(leaves, grow, max_leaves=max_leaves)


def literals() -> st.SearchStrategy[ast.Literal | ast.EnumLiteral]:
    """Literals of many kinds, spelled canonically."""
    def plain(value, kind, text):
        return ast.Literal(value, kind, text, NOWHERE)

    word = st.integers(0, 0xFFFF)
    return st.one_of(
        st.integers(-(1 << 63), (1 << 64) - 1).map(lambda v: plain(v, None, str(v))),
        st.floats(allow_nan=False, allow_infinity=False).map(_real),
        word.map(lambda v: plain(v, None, f"16#{v:X}")),
        word.map(lambda v: plain(v, "WORD", f"WORD#2#{v:b}")),
        st.integers(-32768, 32767).map(lambda v: plain(v, "INT", f"INT#{v}")),
        st.booleans().map(lambda v: plain(v, "BOOL", str(v).upper())),
        st.integers(-(10**15), 10**15).map(lambda v: plain(v * 1000, "TIME", f"T#{v}us")),
        st.integers(0, 86_399).map(lambda v: plain(
            v * 10**9, "TIME_OF_DAY", f"TOD#{v // 3600:02}:{v // 60 % 60:02}:{v % 60:02}")),
        st.text(st.characters(max_codepoint=255, exclude_characters="$'", exclude_categories=["Cc"]))
        .map(lambda v: plain(v.encode("latin-1"), None, f"'{v}'")),
        st.text(st.characters(exclude_characters='$"', exclude_categories=["Cc", "Cs"]))
        .map(lambda v: plain(v, None, f'"{v}"')),
        st.just(ast.EnumLiteral("Colour", "red", NOWHERE)),
    )


def _real(value: float) -> ast.Literal:
    text = repr(value)
    if "e" in text and "." not in text:
        text = text.replace("e", ".0e")
    return ast.Literal(value, None, text, NOWHERE)


def expressions(max_leaves: int = 20) -> st.SearchStrategy[ast.Expr]:
    """Any expression that can be written; types do not fit."""
    roots = st.sampled_from(("a", "b", "R", "S", "P", "N", "level", "in", "x_1")).map(name)
    direct = st.sampled_from(("%IX0.0", "%QW12", "%MD3")).map(lambda t: ast.Direct(t, NOWHERE))

    def reference(base, steps):
        for step in steps:
            if isinstance(step, str) and not (step.isdigit() and isinstance(base, ast.Member)):
                base = ast.Member(base, step, NOWHERE)
            elif not isinstance(step, str):
                base = ast.Index(base, tuple(step), NOWHERE)
        return base

    def grow(inner):
        indexes = st.lists(inner, min_size=1, max_size=2)
        steps = st.lists(st.sampled_from(("Q", "R", "15")) | indexes, max_size=3)
        arguments = st.lists(
            inner.map(lambda e: ast.Argument(None, e, False, NOWHERE))
            | st.builds(lambda n, e: ast.Argument(n, e, False, NOWHERE), st.sampled_from(("IN", "R")), inner)
            | st.builds(lambda n, e: ast.Argument(n, e, True, NOWHERE), st.sampled_from(("OUT", "Q")), roots),
            max_size=3)
        return st.one_of(
            st.builds(reference, roots, steps),
            st.builds(lambda e: ast.Unary("NOT", e, NOWHERE), inner),
            st.builds(lambda e: ast.Unary("-", e, NOWHERE), inner),
            st.builds(lambda op, a, b: ast.Binary(op, a, b, NOWHERE),
                      st.sampled_from(("AND", "OR", "XOR", *COMPARISONS, *SUMS)), inner, inner),
            st.builds(lambda n, a: ast.Call(n, tuple(a), NOWHERE), st.sampled_from(("MAX", "f")), arguments),
        )

    return st.recursive(roots | direct | literals(), grow, max_leaves=max_leaves)


# ---- series-parallel networks


def contacts(names: Sequence[str], kinds: Sequence[str] = CONTACTS) -> st.SearchStrategy[ast.Contact]:
    return st.builds(lambda kind, n: ast.Contact(kind, name(n), NOWHERE),
                     st.sampled_from(kinds), st.sampled_from(names))


def coils(names: Sequence[str], kinds: Sequence[str] = COILS) -> st.SearchStrategy[ast.Coil]:
    return st.builds(lambda kind, n: ast.Coil(kind, name(n), NOWHERE),
                     st.sampled_from(kinds), st.sampled_from(names))


def path(items: Sequence[ast.Item]) -> ast.Path:
    return ast.Path(tuple(items), NOWHERE)


def sp_items(
    leaf: st.SearchStrategy[ast.Item], max_leaves: int = 20,
) -> st.SearchStrategy[tuple[ast.Item, ...]]:
    """Items in series, of which some are branches (and so on)."""
    def grow(inner):
        paths = st.lists(inner.map(path), min_size=1, max_size=3)
        branches = paths.map(lambda p: ast.Branches(tuple(p), NOWHERE))
        return st.lists(leaf | branches, min_size=1, max_size=4).map(tuple)

    return st.recursive(leaf.map(lambda item: (item,)), grow, max_leaves=max_leaves)


def sp_rungs(
    names: Sequence[str] = inputs(6), targets: Sequence[str] = outputs(3),
    contact_kinds: Sequence[str] = CONTACTS, coil_kinds: Sequence[str] = COILS, max_leaves: int = 20,
    inner_coils: bool = True,
) -> st.SearchStrategy[ast.Rung]:
    """Series-parallel rungs; at least one coil stands at the right, others anywhere with ``inner_coils``."""
    leaf = contacts((*names, *targets), contact_kinds)
    if inner_coils:
        leaf = leaf | coils(targets, coil_kinds)
    one = st.tuples(sp_items(leaf, max_leaves), coils(targets, coil_kinds)).map(lambda p: path((*p[0], p[1])))
    return st.lists(one, min_size=1, max_size=3).map(rung)


def rung(paths: Sequence[ast.Path], label: str | None = None, title: str | None = None) -> ast.Rung:
    return ast.Rung(label, title, tuple(paths), NOWHERE)


# ---- networks with junctions


@st.composite
def junction_rungs(
    draw, names: Sequence[str] = inputs(6), targets: Sequence[str] = outputs(3),
    contact_kinds: Sequence[str] = CONTACTS, coil_kinds: Sequence[str] = COILS, max_nets: int = 5,
) -> ast.Rung:
    """Any network without loops: ordered nets, each fed by paths from the rail or earlier nets."""
    count = draw(st.integers(1, max_nets))
    some = st.lists(contacts((*names, *targets), contact_kinds), min_size=1, max_size=2)
    paths: list[ast.Path] = []
    for net in range(1, count + 1):
        for source in sorted(draw(st.sets(st.integers(0, net - 1), min_size=1, max_size=3))):
            paths.append(path((*_net(source), *draw(some), *_net(net))))
    for source in sorted(draw(st.sets(st.integers(0, count - 1), max_size=2)) | {count}):
        paths.append(path((*_net(source), draw(coils(targets, coil_kinds)))))
    order = draw(st.permutations(paths)) if draw(st.booleans()) else paths
    return rung(order)


def _net(number: int) -> tuple[ast.Junction, ...]:
    return (ast.Junction(f"n{number}", NOWHERE),) if number else ()


# ---- programs


def program_text(
    rungs: Sequence[ast.Rung], names: Sequence[str] = inputs(6), targets: Sequence[str] = outputs(3),
) -> str:
    """A PROGRAM ``main`` with these rungs, and their variables declared at %IX and %QX."""
    lines = [f"    {n} AT %IX{i // 8}.{i % 8} : BOOL;" for i, n in enumerate(names)]
    lines += [f"    {n} AT %QX{i // 8}.{i % 8} : BOOL;" for i, n in enumerate(targets)]
    body = "\n\n".join(map(rung_text, rungs))
    return "PROGRAM main\nVAR\n" + "\n".join(lines) + f"\nEND_VAR\n\n{body}\nEND_PROGRAM\n"


def programs(rungs: st.SearchStrategy[ast.Rung] | None = None, max_rungs: int = 4) -> st.SearchStrategy[str]:
    """Programs as ``.ld`` text."""
    rungs = rungs if rungs is not None else sp_rungs() | junction_rungs()
    return st.lists(rungs, min_size=1, max_size=max_rungs).map(program_text)
