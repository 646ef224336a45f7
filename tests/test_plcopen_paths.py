"""Braces in the text of PLCopen drawings: where they stand, and that the rung does what junctions say."""

from __future__ import annotations

import random

import growth
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plcopen_xml import block, coil, contact, ladder, rail, value
from test_plcopen import built

from ldc.parser.plcopen import paths
from ldc.parser.plcopen.ordering import in_turn
from ldc.parser.unparse import paths_text
from runtime.vm.machine import Machine

NAMES = [f"v{i}" for i in range(5)]
DECLARED = " ".join(NAMES) + " : BOOL; i j : INT; " + " ".join(f"c{i}" for i in range(40)) + " : CTU"


def text(*elements: str) -> list[str]:
    result = built(ladder("a b c d q w : BOOL; i : INT; n : CTU", rail(), *elements))
    return [paths_text(rung) for rung in result.project.files[0].pous[0].body.rungs]


CASES = {
    "{ [a] | [b] [c] } [d] (q)": (contact(2, "a"), contact(3, "b", at=(20, 30)),
                                 contact(4, "c", 3, at=(40, 30)), contact(5, "d", (2, 4), at=(60, 10)),
                                 coil(6, "q", 5)),
    "[a] { (q) | [b] (S w) }": (contact(2, "a"), coil(3, "q", 2), contact(4, "b", 2, at=(40, 40)),
                               coil(5, "w", 4, at=(60, 40), storage="set")),
    "{ { [a] | [b] } [c] | [d] } (q)": (
        contact(2, "a"), contact(3, "b", at=(30, 30)), contact(4, "c", (2, 3), at=(50, 10)),
        contact(5, "d", at=(30, 60)), coil(6, "q", (4, 5), at=(90, 10))),
    "[a] <n: CTU(R := { [b] | [c] [d] }, PV := 3)> (q)": (
        contact(2, "a"), contact(3, "b", at=(30, 30)), contact(4, "c", at=(30, 50)),
        contact(5, "d", 4, at=(40, 50)), value(9, "3"),
        block(6, "CTU", {"CU": 2, "R": (3, 5), "PV": 9}, ("Q", "CV"), "n", at=(90, 10)),
        coil(7, "q", "6.Q", at=(120, 10))),
    "[a] @n1 [c] @n2; [b] @n2 (q); @n1 (w)": (
        contact(2, "a"), contact(3, "c", 2), contact(4, "b", at=(30, 30)), coil(5, "q", (3, 4), at=(90, 10)),
        coil(6, "w", 2, at=(90, 90))),
    # The coil in the middle is executed before `c` is read: `c` may not go into braces with `a`.
    "[a] @n1; [b] (w); [c] @n1 (q)": (
        contact(2, "a", executionOrderId=1), contact(3, "b", executionOrderId=2),
        coil(4, "w", 3, executionOrderId=3), contact(5, "c", executionOrderId=4),
        coil(6, "q", (2, 5), executionOrderId=5)),
}


@pytest.mark.parametrize("wanted", CASES)
def test_braces_stand_where_a_person_would_write_them(wanted: str) -> None:
    assert text(*CASES[wanted]) == [wanted]


@st.composite
def drawings(draw) -> str:
    """Contacts, coils and counters, each fed by any that are before; few variables, read and written."""
    elements, sources = [rail()], [1]
    for id_ in range(2, draw(st.integers(4, 22))):
        feed = tuple(draw(st.lists(st.sampled_from(sources[-5:]), min_size=1, max_size=3, unique=True)))
        name = draw(st.sampled_from(NAMES))
        more = {"executionOrderId": draw(st.integers(1, 30))} if draw(st.integers(0, 5)) == 0 else {}
        at = (10 * draw(st.integers(1, 9)), 10 * draw(st.integers(1, 9)))
        kind = draw(st.sampled_from(["contact"] * 5 + ["coil"] * 3 + ["counter"]))
        if kind == "contact":
            more |= draw(st.sampled_from([{}, {}, {"negated": "true"}, {"edge": "rising"}]))
            elements.append(contact(id_, name, feed, at, **more))
        elif kind == "coil":
            kinds = [{}, {}, {"storage": "set"}, {"storage": "reset"}, {"edge": "falling"}]
            more |= draw(st.sampled_from(kinds))
            elements.append(coil(id_, name, feed, at, **more))
        else:
            reset = tuple(draw(st.lists(st.sampled_from(sources), max_size=2, unique=True))) or None
            elements.append(block(id_, "CTU", {"CU": feed, "R": reset}, ("Q",), f"c{id_}", at, **more))
        sources.append(f"{id_}.Q" if kind == "counter" else id_)
    return ladder(DECLARED, *elements)


def trace(xml: str, seed: int) -> list[tuple]:
    machine, rows, chosen = Machine(built(xml).program), [], random.Random(seed)
    for _ in range(12):
        for name in NAMES:
            if chosen.random() < 0.5:
                machine.set(name, chosen.random() < 0.5)
        machine.scan()
        rows.append(tuple(machine.get(name) for name in NAMES))
    return rows


@given(drawings(), st.integers(0, 9))
@settings(deadline=None, max_examples=60)
def test_braces_mean_what_junctions_mean(xml: str, seed: int) -> None:
    paths._plan.cache_clear()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(paths, "in_turn", lambda shape: (in_turn(shape)[0], False))
        plain = trace(xml, seed)
    paths._plan.cache_clear()
    assert trace(xml, seed) == plain


def steps(kind: str, count: int) -> list[paths.Step]:
    """Rungs of one shape and any size."""
    source = built(ladder("a q : BOOL", rail(), contact(2, "a"), coil(3, "q", 2)))
    (item, last), = [p.items for p in source.project.files[0].pous[0].body.rungs[0].paths]
    made = {
        "series": [("" if n == 0 else f"s{n}", f"s{n + 1}") for n in range(count)],
        "parallel": [("", f"s{count}")] * count,
        "comb": [pair for n in range(count // 2)
                 for pair in ((f"s{2 * n}" if n else "", f"s{2 * n + 2}"), ("", f"s{2 * n + 2}"))],
        "fan": [("", f"s{count}")] + [(f"s{count}", None)] * count,
    }[kind]
    found = [paths.Step((number,), last if tail is None else item, head, tail)
             for number, (head, tail) in enumerate(made)]
    return [*found, paths.Step((len(found),), last, f"s{count}", None)]


@pytest.mark.parametrize("kind", ["series", "parallel", "comb", "fan"])
def test_large_rungs_take_linear_time(kind: str) -> None:
    def seconds(count: int) -> float:
        given = steps(kind, count)
        assert paths.write(given)
        return growth.seconds(lambda: paths.write(given))

    assert seconds(20_000) < 16 * max(seconds(4_000), 0.01)
