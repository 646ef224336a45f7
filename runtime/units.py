"""Units of threads: what a controller does, by canonical names (SPEC 6.2), and what each paper calls it.

V: visual thread, C: control thread, A: algorithm thread. S0, S1 and S2 are the three papers on the compiler.
"""

from __future__ import annotations

from ldc.records import record


V_RX, V_STORE, V_DEFRAME = "V.RX", "V.STORE", "V.DEFRAME"
C_START, C_LOGIC, C_DEFRAME = "C.START", "C.LOGIC", "C.DEFRAME"
C_SEND, C_FEEDBACK, C_END = "C.SEND", "C.FEEDBACK", "C.END"
C_BCAST, C_MSG = "C.BCAST", "C.MSG"
A_START, A_DEFRAME, A_EXEC = "A.START", "A.DEFRAME", "A.EXEC"
A_FEEDBACK, A_END = "A.FEEDBACK", "A.END"


@record
class UnitEvent:
    """A unit was executed. ``index``: what it was about: of a module (C.START, C.END), an algorithm's aid
    (A.*, C.SEND, C.FEEDBACK), a message's offset in MSGF (C.BCAST, C.MSG), else 0. ``detail``: more of it: a
    command, ``end`` of a feedback that ends an algorithm."""

    time_ns: int
    processor: str
    unit: str
    index: int = 0
    detail: str = ""


@record
class Unit:
    """``s0``, ``s1``, ``s2``: the number in each paper, the same for two units that it does in one; empty:
    the paper has no such unit."""

    name: str
    duty: str
    s0: str = ""
    s1: str = ""
    s2: str = ""


UNITS: tuple[Unit, ...] = (
    Unit(V_RX, "receives a frame", "V1"),
    Unit(V_STORE, "checks it and stores it in the ring VD", "V2"),
    Unit(V_DEFRAME, "takes it apart into LCD and sets the flag of CDF", "V3"),
    Unit(C_START, "starts a module", "C1", "C1", "C1"),
    Unit(C_LOGIC, "executes the logic of the modules", "C2"),
    Unit(C_DEFRAME, "takes a control frame apart into the image of SMD", "C3"),
    Unit(C_SEND, "sends parameters to a slave", "C4", "C2", "C2"),
    Unit(C_FEEDBACK, "handles what a slave fed back", "C5", "C3", "C3"),
    Unit(C_END, "ends a module", "C6", "C3", "C3"),
    Unit(C_BCAST, "broadcasts a message", "", "C4", "C4"),
    Unit(C_MSG, "handles a message", "", "C5", "C5"),
    Unit(A_START, "starts an algorithm", "M1", "M1", "M1"),
    Unit(A_DEFRAME, "takes its parameters into AD", "M2", "M1", "M1"),
    Unit(A_EXEC, "executes it", "M3", "M2", "M2"),
    Unit(A_FEEDBACK, "feeds back to the master", "M4", "M3", "M3"),
    Unit(A_END, "ends it and tells the master", "M5", "M4", "M4"),
)


def named(paper: str, number: str) -> tuple[str, ...]:
    """The canonical names of what a paper (S0, S1, S2) calls by a number: `named("S2", "C3")`. Several when
    the paper does several in one; none when it has no such number."""
    return tuple(unit.name for unit in UNITS if getattr(unit, paper.lower()) == number)
