"""Charts at random, and what they mean: an interpreter of IEC 61131-3, 2.6, with time stamps.

A chart is drawn as plain data here, printed as text for the compiler, and interpreted from the data.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from hypothesis import strategies as st

INPUTS = ("i0", "i1", "i2")
COILS = ("c0", "c1", "c2")
COUNTS = ("n0", "n1")
LAMPS = ("b0", "b1")
ACTS = ("act0", "act1", "act2")
PLAIN, TIMED = ("N", "S", "R", "P", "P0", "P1"), ("L", "D", "SD", "DS", "SL")
MS = 1_000_000


@dataclass(frozen=True)
class Transition:
    """``body``: the condition is drawn as a rung that sets the variable with the transition's name."""

    sources: tuple[int, ...]
    targets: tuple[int, ...]
    priority: int | None
    condition: tuple
    body: bool


@dataclass(frozen=True)
class Chart:
    """``uses[step]``: (action, qualifier, milliseconds); ``acts``: the bodies that the actions have."""

    steps: int
    transitions: tuple[Transition, ...]
    uses: tuple[tuple[tuple[str, str, int], ...], ...]
    acts: tuple[str, ...]


# ---- conditions: (word, ...), as text and as value


def condition_text(node: tuple) -> str:
    match node:
        case ("not", inner):
            return f"NOT ({condition_text(inner)})"
        case ("and" | "or" as op, left, right):
            return f"({condition_text(left)}) {op.upper()} ({condition_text(right)})"
        case ("on", step):
            return f"s{step}.X"
        case ("lasts", step, ms):
            return f"s{step}.T >= T#{ms}ms"
        case ("act", name, flag):
            return f"{name}.{flag}"
        case ("count", name, number):
            return f"{name} MOD 4 = {number}"
    return node[0]


# ---- bodies of actions: text, and what it does to the variables

BODIES: dict[str, str] = {
    "count": "n0 := n0 + 1;",
    "last": "IF {me}.Q THEN n1 := n1 + 2; ELSE n1 := n1 + 100; END_IF;",
    "leaves": "n0 := n0 + 3; IF i0 THEN RETURN; END_IF; n1 := n1 + 1;",
    "coil": "RUNG [i0] [/i1] (c0)",
    "edge": "RUNG [P i1] (S c1) RUNG [i2] (R c1)",
    "jump": "RUNG [i0] >>RETURN RUNG [i1] >>{me}_over RUNG [/c2] (c2) RUNG {me}_over [i2] (c0)",
    "long": "FOR n1 := 1 TO 3 DO n0 := n0 + 1; IF i2 THEN RETURN; END_IF; END_FOR; n1 := 0;",
}


def do(kind: str, me: str, machine: Interpreter) -> None:
    v = machine.values
    match kind:
        case "count":
            v["n0"] += 1
        case "last":
            v["n1"] += 2 if v[f"{me}.Q"] else 100
        case "leaves":
            v["n0"] += 3
            v["n1"] += not v["i0"]
        case "coil":
            v["c0"] = v["i0"] and not v["i1"]
        case "edge":
            v["c1"] |= v["i1"] and not machine.edges.get(me, False)
            v["c1"] &= not v["i2"]
            machine.edges[me] = v["i1"]
        case "jump":
            if not v["i0"]:
                v["c2"] ^= not v["i1"]
                v["c0"] = v["i2"]
        case "long":
            rounds = 1 if v["i2"] else 3
            v["n0"], v["n1"] = v["n0"] + rounds, rounds if v["i2"] else 0


@dataclass
class Control:
    """What figure 15 remembers for one association."""

    set_at: int | None = None


@dataclass
class Interpreter:
    chart: Chart
    values: dict[str, object] = field(default_factory=dict)
    edges: dict[str, bool] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.values = dict.fromkeys((*INPUTS, *COILS, *LAMPS), False) | dict.fromkeys(COUNTS, 0)
        self.values |= {f"{act}.{flag}": False for act in ACTS for flag in "QA"}
        self.values |= {f"t{n}": False for n, t in enumerate(self.chart.transitions) if t.body}
        self.active = {0}
        self.began = [0] * self.chart.steps
        self.elapsed = [0] * self.chart.steps
        self.started = False
        self.stored = dict.fromkeys((*ACTS, *LAMPS), False)
        self.level = dict.fromkeys((*ACTS, *LAMPS), False)
        self.controls: dict[tuple[int, int], Control] = {}

    def value(self, node: tuple) -> bool:
        match node:
            case ("not", inner):
                return not self.value(inner)
            case ("and", left, right):
                return self.value(left) and self.value(right)
            case ("or", left, right):
                return self.value(left) or self.value(right)
            case ("on", step):
                return step in self.active
            case ("lasts", step, ms):
                return self.elapsed[step] >= ms * MS
            case ("act", name, flag):
                return self.values[f"{name}.{flag}"]
            case ("count", name, number):
                return self.values[name] % 4 == number
        return node[0] == "TRUE" or self.values[node[0]]

    def execute(self, now: int) -> None:
        """One execution of the POU. ``now`` in nanoseconds."""
        entered, left = ({0}, set()) if not self.started else self.fire(now)
        self.started = True
        self.active = self.active - left | entered
        for step in entered:
            self.began[step], self.elapsed[step] = now, 0
        for name in (*LAMPS, *ACTS):
            self.switch(name, now, entered, left)
        for name, kind in zip(ACTS, self.chart.acts, strict=True):
            if self.values[f"{name}.A"]:
                do(kind, name, self)

    def fire(self, now: int) -> tuple[set[int], set[int]]:
        for step in self.active:
            self.elapsed[step] = now - self.began[step]
        tokens, entered, left = set(self.active), set(), set()
        numbered = list(enumerate(self.chart.transitions))
        last = max((t.priority or 0 for _, t in numbered), default=0) + 1
        for number, one in sorted(numbered, key=lambda p: last if p[1].priority is None else p[1].priority):
            if one.body:
                self.values[f"t{number}"] = False
            if tokens.issuperset(one.sources) and self.value(one.condition):
                if one.body:
                    self.values[f"t{number}"] = True
                tokens -= set(one.sources)
                left |= set(one.sources)
                entered |= set(one.targets)
        return entered, left

    def switch(self, name: str, now: int, entered: set[int], left: set[int]) -> None:
        level = pulse = reset = False
        for step, uses in enumerate(self.chart.uses):
            on, lasted = step in self.active, self.elapsed[step]
            for number, (action, qualifier, ms) in enumerate(uses):
                if action != name:
                    continue
                level |= qualifier == "N" and on
                level |= qualifier == "L" and on and lasted < ms * MS
                level |= qualifier == "D" and on and lasted >= ms * MS
                pulse |= qualifier in ("P", "P1") and step in entered or qualifier == "P0" and step in left
                reset |= qualifier == "R" and on
                self.stored[name] |= on and (qualifier == "S" or qualifier == "DS" and lasted >= ms * MS)
                if qualifier in ("SD", "SL"):
                    control = self.controls.setdefault((step, number), Control())
                    if on and control.set_at is None:
                        control.set_at = now
                    if control.set_at is not None:
                        level |= (now - control.set_at >= ms * MS) == (qualifier == "SD")
        if reset:
            self.stored[name] = level = pulse = False
            for step, uses in enumerate(self.chart.uses):
                for number, use in enumerate(uses):
                    if use[0] == name:
                        self.controls.pop((step, number), None)
        level |= self.stored[name]
        if name in LAMPS:
            if any(use[0] == name for uses in self.chart.uses for use in uses):
                self.values[name] = level or pulse
        else:
            self.values[f"{name}.Q"] = level or pulse
            self.values[f"{name}.A"] = level or pulse or self.level[name]
        self.level[name] = level


# ---- text


def text(chart: Chart) -> str:
    """A FUNCTION_BLOCK with the chart, and a PROGRAM that calls it while ``run`` is TRUE."""
    parts = []
    for step in range(chart.steps):
        uses = [f"    {action}({q}{f', T#{ms}ms' if q in TIMED else ''});"
                for action, q, ms in chart.uses[step]]
        parts += [f"{'INITIAL_' if step == 0 else ''}STEP s{step}:", *uses, "END_STEP"]
    for number, one in enumerate(chart.transitions):
        priority = "" if one.priority is None else f" (PRIORITY := {one.priority})"
        ends = " TO ".join(names(steps) for steps in (one.sources, one.targets))
        condition = condition_text(one.condition)
        rest = f": RUNG [{condition}] (t{number})" if one.body else f":= {condition};"
        parts.append(f"TRANSITION t{number}{priority} FROM {ends} {rest} END_TRANSITION")
    for name, kind in zip(ACTS, chart.acts, strict=True):
        parts.append(f"ACTION {name}: {BODIES[kind].format(me=name)} END_ACTION")
    inputs = "".join(f"    {name} : BOOL;\n" for name in INPUTS)
    variables = f"    {', '.join((*COILS, *LAMPS))} : BOOL;\n    {', '.join(COUNTS)} : INT;\n"
    return (f"FUNCTION_BLOCK cell\nVAR_INPUT\n{inputs}END_VAR\nVAR\n{variables}END_VAR\n" + "\n".join(parts)
            + "\nEND_FUNCTION_BLOCK\n\nPROGRAM main\nVAR\n    run : BOOL;\n" + inputs
            + "    chart : cell;\nEND_VAR\n"
            + "RUNG\n    [/run] >>RETURN\nRUNG\n    <chart: cell(i0 := i0, i1 := i1, i2 := i2) in=_ out=_>\n"
            + "END_PROGRAM\n")


def names(steps: tuple[int, ...]) -> str:
    found = ", ".join(f"s{n}" for n in steps)
    return found if len(steps) == 1 else f"({found})"


# ---- charts at random


@st.composite
def charts(draw: Callable) -> Chart:
    """Most transitions lead from one step to one, and most conditions are inputs: so that much happens."""
    count = draw(st.integers(2, 5))
    step = st.integers(0, count - 1)
    several = st.lists(step, min_size=2, max_size=3, unique=True).map(tuple)
    ends = step.map(lambda n: (n,)) | step.map(lambda n: (n,)) | several
    inputs = st.sampled_from(INPUTS).map(lambda name: (name,))
    rare = (step.map(lambda n: ("on", n))
            | st.tuples(st.just("lasts"), step, st.sampled_from((0, 10, 20, 45)))
            | st.tuples(st.just("act"), st.sampled_from(ACTS), st.sampled_from("QA"))
            | st.tuples(st.just("count"), st.sampled_from(COUNTS), st.integers(0, 3)))
    plain = inputs | inputs.map(lambda node: ("not", node)) | st.just(("TRUE",)) | rare
    joined = st.tuples(st.sampled_from(("and", "or")), plain, plain)
    transition = st.builds(Transition, ends, ends, st.none() | st.integers(0, 3), plain | plain | joined,
                           st.sampled_from((False, False, False, True)))
    use = st.tuples(st.sampled_from((*ACTS, *LAMPS)), st.sampled_from((*PLAIN, *TIMED)),
                    st.sampled_from((0, 10, 15, 30, 40)))
    uses = draw(st.tuples(*(st.lists(use, min_size=2, max_size=4).map(tuple) for _ in range(count))))
    bodies = draw(st.lists(st.sampled_from(sorted(BODIES)), min_size=len(ACTS), max_size=len(ACTS)))
    return Chart(count, tuple(draw(st.lists(transition, min_size=4, max_size=8))), uses, tuple(bodies))


@dataclass(frozen=True)
class Scan:
    run: bool
    inputs: tuple[bool, bool, bool]


_runs = st.sampled_from((True, True, True, True, False))
scans = st.lists(st.builds(Scan, _runs, st.tuples(*[st.booleans()] * 3)), min_size=8, max_size=14)
