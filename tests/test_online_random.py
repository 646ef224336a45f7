"""Random programs that are changed at random while they run, against a reference that keeps each symbol."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import native
from online_programs import loaded
from runtime.online.controller import Controller, prepare

TICK = 10_000_000
NAMES = ("a0", "a1", "a2", "t0", "t1", "c0", "c1", "e0", "e1", "f0", "f1")
Text = dict[str, int]

programs = st.dictionaries(st.sampled_from(NAMES), st.integers(1, 4), min_size=1)
steps = st.lists(st.tuples(programs, st.integers(0, 5), st.integers(0, 5), st.sampled_from(("commit", "untest"))),
                 min_size=1, max_size=5)


def text_of(program: Text) -> str:
    """``a``: grows by its number in every scan; ``t``: a timer that runs; ``c``: a counter of rising edges of
    ``x``, which is inverted in every scan; ``e``, ``f``: rising and falling edges of it by contacts."""
    variables, rungs = ["x : BOOL;"], ["RUNG flip\n[/x] (x)"]
    for name, number in program.items():
        kind = {"t": "TON", "c": "CTU"}.get(name[0], "INT")
        variables.append(f"{name} : {kind};" if kind != "INT" else f"{name} : INT := {10 + int(name[1])};")
        added = f"<ADD(IN1 := {name}, IN2 := {number}, OUT => {name})>"
        rungs.append(f"RUNG r_{name}\n" + {
            "a": f"[TRUE] {added}", "e": f"[P x] {added}", "f": f"[N x] {added}",
            "t": f"[TRUE] <{name}: TON(PT := T#100s)>", "c": f"[x] <{name}: CTU(PV := {number})>"}[name[0]])
    return "PROGRAM main\nVAR\n" + "\n".join(variables) + "\nEND_VAR\n" + "\n".join(rungs) + "\nEND_PROGRAM\n"


@dataclass
class Reference:
    """What the program's values must be. ``values``: of the integers; ``edges``: previous operands;
    ``starts``: of timers, None before their first execution; ``counts``: value and previous input."""

    program: Text
    values: dict[str, int] = field(default_factory=dict)
    edges: dict[str, bool] = field(default_factory=dict)
    starts: dict[str, int | None] = field(default_factory=dict)
    counts: dict[str, tuple[int, bool]] = field(default_factory=dict)
    x: bool = False

    def __post_init__(self) -> None:
        for name in self.program:
            if name[0] == "t":
                self.starts[name] = None
            elif name[0] == "c":
                self.counts[name] = 0, False
            else:
                self.values[name] = 10 + int(name[1])
                if name[0] in "ef":
                    self.edges[name] = False

    def take(self, other: Reference) -> None:
        """Goes on with the state of another program; what that does not have stands."""
        self.x = other.x
        for name in self.edges:
            self.edges[name] = other.edges.get(name, name[0] == "e")
        for mine, theirs in ((self.values, other.values), (self.starts, other.starts), (self.counts, other.counts)):
            mine |= {name: theirs[name] for name in mine if name in theirs}

    def scan(self, now: int) -> None:
        self.x = not self.x
        for name, number in self.program.items():
            if name[0] == "a":
                self.values[name] += number
            elif name[0] == "t":
                self.starts[name] = now if self.starts[name] is None else self.starts[name]
            elif name[0] == "c":
                count, before = self.counts[name]
                self.counts[name] = count + (self.x and not before), self.x
            else:
                before, self.edges[name] = self.edges[name], self.x
                seen = self.x and not before if name[0] == "e" else before and not self.x
                self.values[name] += number if seen else 0

    def expected(self, now: int) -> dict[str, object]:
        timers = {f"{name}.ET": 0 if start is None else now - start for name, start in self.starts.items()}
        return {"x": self.x, **self.values, **timers, **{f"{n}.CV": count for n, (count, _) in self.counts.items()}}


def follow(first: Text, changes: list, engine: str) -> None:
    """Runs the changes on a machine and on the reference, and compares after every scan."""
    controller = Controller(loaded(text_of(first), engine))
    reference = Reference(first)
    scans = 0

    def run(count: int) -> None:
        nonlocal scans
        for _ in range(count):
            now = scans * TICK
            controller.between()
            controller.scan()
            reference.scan(now)
            scans += 1
            assert controller.machine.now_ns == scans * TICK
            expected = reference.expected(now)
            assert {name: controller.machine.get(name) for name in expected} == expected

    run(2)
    for program, before, during, end in changes:
        run(before)
        old = controller.running
        new = loaded(text_of(program), engine, old)
        controller.stage(prepare(old, new, old.digest, "me"))
        controller.test("me")
        fresh, standing = Reference(program), reference
        fresh.take(reference)
        reference = fresh
        run(during)
        if end == "commit":
            controller.commit("me")
        else:
            controller.untest("me")
            standing.take(reference)
            reference = standing
            controller.cancel("me")
        run(2)
    assert not controller.machine.faults


@given(programs, steps)
@settings(max_examples=60, deadline=None)
def test_every_symbol_is_what_the_reference_says(first, changes) -> None:
    follow(first, changes, "vm")


@native.needs_gcc
@pytest.mark.parametrize("end", ("commit", "untest"))
def test_the_same_on_native(end: str) -> None:
    all_of = dict.fromkeys(NAMES, 2)
    half = {name: 3 for name in reversed(NAMES) if name[1] == "1"}
    follow(all_of, [(half, 3, 4, end), (all_of | {"a0": 4}, 2, 3, "commit"), (half, 1, 5, end)], "native")
