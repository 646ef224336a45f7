"""Plain Python models of the standard function blocks, written from the standard's diagrams.

An oracle for every engine: state machines with a name for each phase, sharing no line and no idea
with the IL text of ldc.library.blocks. ``step(now_ns, **inputs)`` executes once at that task
time and gives the outputs; an input that is not given keeps its value.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

RANGES = {
    "": (-(2**15), 2**15 - 1), "_INT": (-(2**15), 2**15 - 1), "_DINT": (-(2**31), 2**31 - 1),
    "_LINT": (-(2**63), 2**63 - 1), "_UDINT": (0, 2**32 - 1), "_ULINT": (0, 2**64 - 1),
}


class Model(ABC):
    """A block. ``inputs`` and ``outputs`` hold the pins by name, with their initial values."""

    inputs: dict
    outputs: dict

    def step(self, now_ns: int, **inputs) -> dict:
        unknown = inputs.keys() - self.inputs.keys()
        if unknown:
            raise KeyError(f"no such input: {sorted(unknown)}")
        self.inputs.update(inputs)
        self.execute(now_ns, **self.inputs)
        return dict(self.outputs)

    @abstractmethod
    def execute(self, now, **pins) -> None:
        """Update ``outputs``."""


class Timer(Model):
    def __init__(self) -> None:
        self.inputs = {"IN": False, "PT": 0}
        self.outputs = {"Q": False, "ET": 0}
        self.phase = "idle"
        self.since = 0

    def show(self, q: bool, elapsed: int) -> None:
        shown = elapsed if elapsed < self.inputs["PT"] else self.inputs["PT"]
        self.outputs = {"Q": q, "ET": shown if shown > 0 else 0}


class TON(Timer):
    """On delay: Q when IN has been TRUE for PT."""

    def execute(self, now, IN, PT):
        if not IN:
            self.phase = "idle"
            self.show(False, 0)
            return
        if self.phase == "idle":
            self.phase, self.since = "on", now
        elapsed = now - self.since
        self.show(elapsed >= PT, elapsed)


class TOF(Timer):
    """Off delay: Q with IN and for PT after it fell; fallen stays fallen until IN comes."""

    def execute(self, now, IN, PT):
        if IN:
            self.phase = "on"
            self.show(True, 0)
            return
        if self.phase == "on":
            self.phase, self.since = "falling", now
        if self.phase == "idle":
            self.show(False, 0)
            return
        elapsed = now - self.since
        if elapsed >= PT:
            self.phase = "off"
        self.show(self.phase == "falling", elapsed)


class TP(Timer):
    """Pulse of PT from a rising IN; ready again when IN was seen FALSE at or after its end."""

    def execute(self, now, IN, PT):
        if self.phase == "idle" and IN:
            self.phase, self.since = "pulse", now
        elapsed = now - self.since
        if self.phase == "pulse" and elapsed >= PT:
            self.phase = "over"
        if self.phase == "over" and not IN:
            self.phase = "idle"
        if self.phase == "idle":
            self.show(False, 0)
        else:
            self.show(self.phase == "pulse", elapsed)


class Counter(Model):
    def __init__(self, least: int, greatest: int) -> None:
        self.least, self.greatest, self.count = least, greatest, 0
        self.last = {"CU": False, "CD": False}

    def edge(self, pin: str, value: bool) -> bool:
        rising = value and not self.last[pin]
        self.last[pin] = value
        return rising

    def up(self) -> None:
        if self.count != self.greatest:
            self.count += 1

    def down(self) -> None:
        if self.count != self.least:
            self.count -= 1


class CTU(Counter):
    def __init__(self, least: int, greatest: int) -> None:
        super().__init__(least, greatest)
        self.inputs, self.outputs = {"CU": False, "R": False, "PV": 0}, {"Q": False, "CV": 0}

    def execute(self, now, CU, R, PV):
        if self.edge("CU", CU):
            self.up()
        if R:
            self.count = 0
        self.outputs = {"Q": self.count >= PV, "CV": self.count}


class CTD(Counter):
    def __init__(self, least: int, greatest: int) -> None:
        super().__init__(least, greatest)
        self.inputs, self.outputs = {"CD": False, "LD": False, "PV": 0}, {"Q": False, "CV": 0}

    def execute(self, now, CD, LD, PV):
        if self.edge("CD", CD):
            self.down()
        if LD:
            self.count = PV
        self.outputs = {"Q": self.count <= 0, "CV": self.count}


class CTUD(Counter):
    def __init__(self, least: int, greatest: int) -> None:
        super().__init__(least, greatest)
        self.inputs = {"CU": False, "CD": False, "R": False, "LD": False, "PV": 0}
        self.outputs = {"QU": False, "QD": False, "CV": 0}

    def execute(self, now, CU, CD, R, LD, PV):
        rose, fell = self.edge("CU", CU), self.edge("CD", CD)
        if R:
            self.count = 0
        elif LD:
            self.count = PV
        elif rose != fell:
            self.up() if rose else self.down()
        self.outputs = {"QU": self.count >= PV, "QD": self.count <= 0, "CV": self.count}


class Trigger(Model):
    """An edge towards ``active``; before the first call CLK counts as FALSE."""

    def __init__(self, active: bool) -> None:
        self.inputs, self.outputs = {"CLK": False}, {"Q": False}
        self.active, self.last = active, False

    def execute(self, now, CLK):
        self.outputs = {"Q": CLK != self.last and CLK == self.active}
        self.last = CLK


class Bistable(Model):
    """``dominant`` tells which side wins when both inputs are TRUE."""

    def __init__(self, dominant: str) -> None:
        self.setter, self.resetter = ("S1", "R") if dominant == "set" else ("S", "R1")
        self.inputs, self.outputs = {self.setter: False, self.resetter: False}, {"Q1": False}
        self.wins = dominant == "set"

    def execute(self, now, **pins):
        match pins[self.setter], pins[self.resetter]:
            case True, True:
                self.outputs = {"Q1": self.wins}
            case True, False:
                self.outputs = {"Q1": True}
            case False, True:
                self.outputs = {"Q1": False}


MODELS = {
    "TON": TON, "TOF": TOF, "TP": TP,
    "R_TRIG": lambda: Trigger(True), "F_TRIG": lambda: Trigger(False),
    "SR": lambda: Bistable("set"), "RS": lambda: Bistable("reset"),
} | {
    kind.__name__ + suffix: (lambda kind=kind, limits=limits: kind(*limits))
    for kind in (CTU, CTD, CTUD) for suffix, limits in RANGES.items()
}


def make(name: str) -> Model:
    """A fresh block by the name of its type, in any case."""
    return MODELS[name.upper()]()
