"""States of master, slaves and algorithms as tables of transitions (SPEC 5).

A state changes by events; an event that is in no row of a state leaves it. ``START`` is the event that an
envelope with that command was checked and taken, not the level of a flag: flags are 0 again when the transfer
ends.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum, IntEnum
from typing import TypeVar


class Master(Enum):
    """``mstop``: idle; ``mrun``: at least one module runs; ``merror``: after an emergency stop."""

    STOP = "mstop"
    RUN = "mrun"
    ERROR = "merror"


class Slave(Enum):
    """``sready``: a start was taken, no algorithm executes yet; ``srun``: at least one does."""

    STOP = "sstop"
    READY = "sready"
    RUN = "srun"
    ERROR = "serror"


class Algorithm(IntEnum):
    """AFS: what became of an algorithm."""

    IDLE = 0
    RUNNING = 1
    DONE = 2
    ERROR = 3


SLAVE_FAULTS = range(800, 900)
"""What ``error`` of an algorithm in IL becomes by a fault, which is one of its whole slave: LD0801 is 801."""

BEGUN_ANEW = 861
"""The fault of a slave that has forgotten what it did: LD0861."""


class MasterEvent(Enum):
    """``MODULES``: a start bit of a module is 1; ``NO_MODULES``: none is any more; ``ACKNOWLEDGE``: by a
    person, counts when every slave is in ``sstop`` or ``serror``."""

    MODULES = "some lcf = 1"
    NO_MODULES = "all lcf = 0"
    ESTOP = "estop"
    ACKNOWLEDGE = "ack"


class SlaveEvent(Enum):
    """``EXECUTES``: the first flag of AFE is 1 (A.START); ``ENDED``: the last one is 0 (A.END); ``OVERDUE``:
    nothing began within T_ready; ``FAULT``: of the link, of an algorithm, or an emergency stop; ``RESET``:
    counts when no fault is left."""

    START = "ok(START)"
    STOP = "ok(STOP)"
    EXECUTES = "afe <> 0"
    ENDED = "afe = 0"
    OVERDUE = "T_ready"
    FAULT = "fault"
    RESET = "reset"


class AlgorithmEvent(Enum):
    BEGIN = "begin"
    DONE = "done"
    FAULT = "fault"
    CLEAR = "clear"


MASTER: Mapping[tuple[Master, MasterEvent], Master] = {
    (Master.STOP, MasterEvent.MODULES): Master.RUN,
    (Master.RUN, MasterEvent.NO_MODULES): Master.STOP,
    (Master.STOP, MasterEvent.ESTOP): Master.ERROR,
    (Master.RUN, MasterEvent.ESTOP): Master.ERROR,
    (Master.ERROR, MasterEvent.ACKNOWLEDGE): Master.STOP,
}

SLAVE: Mapping[tuple[Slave, SlaveEvent], Slave] = {
    (Slave.STOP, SlaveEvent.START): Slave.READY,
    (Slave.READY, SlaveEvent.EXECUTES): Slave.RUN,
    (Slave.READY, SlaveEvent.OVERDUE): Slave.STOP,
    (Slave.READY, SlaveEvent.STOP): Slave.STOP,
    (Slave.RUN, SlaveEvent.ENDED): Slave.STOP,
    **{(state, SlaveEvent.FAULT): Slave.ERROR for state in Slave},
    (Slave.ERROR, SlaveEvent.RESET): Slave.STOP,
}

ALGORITHM: Mapping[tuple[Algorithm, AlgorithmEvent], Algorithm] = {
    **{(state, AlgorithmEvent.BEGIN): Algorithm.RUNNING for state in (Algorithm.IDLE, Algorithm.DONE)},
    (Algorithm.RUNNING, AlgorithmEvent.DONE): Algorithm.DONE,
    **{(state, AlgorithmEvent.FAULT): Algorithm.ERROR for state in Algorithm},
    **{(state, AlgorithmEvent.CLEAR): Algorithm.IDLE for state in Algorithm},
}

State = TypeVar("State")
Event = TypeVar("Event")


def follow(table: Mapping[tuple[State, Event], State], state: State, events: Iterable[Event]) -> State:
    """The state after some events, in their order."""
    for event in events:
        state = table.get((state, event), state)
    return state


def at_rest(slaves: Iterable[Slave]) -> bool:
    """No slave has work or is about to begin: the master may be in ``mstop``."""
    return all(slave in (Slave.STOP, Slave.ERROR) for slave in slaves)
