"""The sequences of the papers, as they are printed and as they are executed (SPEC 2.1, 2.3).

A printed sequence has no guards and is run by nobody: taken literally by two processors it loses and repeats
transfers (tests/test_protocol_model.py shows it). It is here to compare with: ``atomic`` gives the trace that
an ideal executor would leave, ``CANONICAL`` the order that every transfer of the machines leaves.
"""

from __future__ import annotations

from collections.abc import Sequence

from ldc.records import record

MASTER, SLAVE = "M", "S"


@record
class Action:
    """``kind``: ``set`` or ``clear`` a flag, ``send`` or ``check`` data. ``by``: M or S."""

    kind: str
    name: str
    by: str

    def __str__(self) -> str:
        return f"{self.by} {self.kind} {self.name}"


def sequence(text: str) -> tuple[Action, ...]:
    """Of lines ``S1 msb``, ``S0 msb`` (O and F are the same), ``send smd``, ``check smd``. Who does it
    follows from the first letter of a flag, and from sending and checking."""
    kinds = {"S1": "set", "O": "set", "S0": "clear", "F": "clear", "send": "send", "check": "check"}
    found = []
    for step in text.split(">"):
        word, name = step.split()
        kind = kinds[word]
        by = {"send": MASTER, "check": SLAVE}.get(kind) or (MASTER if name[0] == "m" else SLAVE)
        found.append(Action(kind, name, by))
    return tuple(found)


LITERAL_U = sequence(
    "S1 msb > S1 msf > send smd > S0 msb > S1 sms > check smd > S1 sma > S0 sms > S0 sma > S0 msf")
"""Of the second paper. The first repeats `S0 sms` where `S0 sma` and `S0 msf` have to stand."""

LITERAL_U_FIRST = sequence(
    "S1 msb > S1 msf > send smd > S0 msb > S1 sms > check smd > S1 sma > S0 sms > S0 sms")

LITERAL_I = sequence(
    "O ms > O mf > send sd > O sf > check sd > O sa > O mc > F ms > F mf > F mc > F sf > F sa")

CANONICAL = {
    "U*": sequence(
        "S1 msb > S1 msf > send smd > S0 msb > S1 sms > check smd > S1 sma > S0 sms > S0 msf > S0 sma"),
    "I*": sequence(
        "O msb > send smd > O msf > O sms > check smd > O sma > O msc > "
        "F msb > F msf > F msc > F sms > F sma"),
}
"""What is executed, by the name of the profile, in the names of SPEC 0."""

NAMES_OF_I = {"ms": "msb", "mf": "msf", "mc": "msc", "sa": "sma", "sf": "sms", "sd": "smd"}
"""The third paper's names in those of SPEC 0, for master to slave."""


def atomic(actions: Sequence[Action]) -> list[tuple[Action, frozenset[str]]]:
    """The trace of an executor that does a sequence in its order: each action with the flags that are 1 after
    it."""
    flags: frozenset[str] = frozenset()
    trace = []
    for action in actions:
        if action.kind == "set":
            flags |= {action.name}
        elif action.kind == "clear":
            flags -= {action.name}
        trace.append((action, flags))
    return trace


def left_over(actions: Sequence[Action]) -> frozenset[str]:
    """The flags that are still 1 after a sequence."""
    return atomic(actions)[-1][1]
