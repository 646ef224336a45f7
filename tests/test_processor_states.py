"""The states of processors: their tables over all histories, and invariants that find what breaks them."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import NamedTuple

import pytest
from explore import explore

from runtime.processors.invariants import INVARIANTS, Executed, Snapshot, Took, violations
from runtime.processors.states import (
    ALGORITHM, MASTER, SLAVE, Algorithm, AlgorithmEvent, Master, MasterEvent, Slave, SlaveEvent, at_rest,
    follow)
from runtime.protocol.envelope import Command
from runtime.protocol.memory import Access

MS = 1_000_000


@pytest.mark.parametrize(("start", "events", "end"), [
    (Slave.STOP, "START EXECUTES ENDED", Slave.STOP),
    (Slave.STOP, "START EXECUTES START STOP", Slave.RUN),  # a second algorithm; the first goes on
    (Slave.STOP, "START OVERDUE", Slave.STOP),
    (Slave.STOP, "START STOP", Slave.STOP),
    (Slave.STOP, "EXECUTES", Slave.STOP),
    (Slave.STOP, "START EXECUTES FAULT START EXECUTES", Slave.ERROR),
    (Slave.STOP, "FAULT RESET START", Slave.READY),
])
def test_a_slave(start: Slave, events: str, end: Slave) -> None:
    assert follow(SLAVE, start, [SlaveEvent[e] for e in events.split()]) is end


@pytest.mark.parametrize(("events", "end"), [
    ("MODULES NO_MODULES", Master.STOP), ("MODULES", Master.RUN), ("MODULES ESTOP MODULES", Master.ERROR),
    ("ESTOP NO_MODULES", Master.ERROR), ("MODULES ESTOP ACKNOWLEDGE", Master.STOP),
    ("ACKNOWLEDGE", Master.STOP),
])
def test_the_master(events: str, end: Master) -> None:
    assert follow(MASTER, Master.STOP, [MasterEvent[e] for e in events.split()]) is end


def test_an_algorithm_that_failed_begins_again_only_when_cleared() -> None:
    events = AlgorithmEvent.BEGIN, AlgorithmEvent.FAULT, AlgorithmEvent.BEGIN
    failed = follow(ALGORITHM, Algorithm.IDLE, events)
    assert failed is Algorithm.ERROR
    assert follow(ALGORITHM, failed, [AlgorithmEvent.CLEAR, AlgorithmEvent.BEGIN]) is Algorithm.RUNNING
    assert [a.value for a in Algorithm] == [0, 1, 2, 3]


class Plant(NamedTuple):
    """A master with one module on each of two slaves, each slave with two algorithms."""

    master: Master = Master.STOP
    slaves: tuple[Slave, ...] = (Slave.STOP, Slave.STOP)
    executing: tuple[int, ...] = (0, 0)
    modules: int = 0
    estop: bool = False


def changes(p: Plant) -> list[Plant]:
    """What a controller that follows the tables may do next."""
    found = []

    def slave(k: int, *events: SlaveEvent, afe: int | None = None) -> Plant:
        slaves, executing = list(p.slaves), list(p.executing)
        slaves[k] = follow(SLAVE, slaves[k], events)
        executing[k] = executing[k] if afe is None else afe
        return p._replace(slaves=tuple(slaves), executing=tuple(executing))

    for k in (0, 1):
        state, afe = p.slaves[k], p.executing[k]
        if p.master is Master.RUN and p.modules >> k & 1:
            found.append(slave(k, SlaveEvent.START))
            if state in (Slave.READY, Slave.RUN):
                found += [slave(k, SlaveEvent.EXECUTES, afe=afe | bit) for bit in (1, 2)]
        found += [slave(k, SlaveEvent.OVERDUE), slave(k, SlaveEvent.STOP), slave(k, SlaveEvent.FAULT, afe=0)]
        for bit in (1, 2):
            if afe & bit:
                left = afe & ~bit
                found.append(slave(k, *(() if left else (SlaveEvent.ENDED,)), afe=left))
        if not p.estop:
            found.append(slave(k, SlaveEvent.RESET))
        if p.master is not Master.ERROR and not p.estop:
            master = follow(MASTER, p.master, [MasterEvent.MODULES])
            found.append(p._replace(modules=p.modules | 1 << k, master=master))
        if p.modules >> k & 1 and state in (Slave.STOP, Slave.ERROR):
            modules = p.modules & ~(1 << k)
            events = [] if modules else [MasterEvent.NO_MODULES]
            found.append(p._replace(modules=modules, master=follow(MASTER, p.master, events)))
    slaves = tuple(follow(SLAVE, s, [SlaveEvent.FAULT]) for s in p.slaves)
    found.append(Plant(follow(MASTER, p.master, [MasterEvent.ESTOP]), slaves, (0, 0), 0, True))
    if p.estop and at_rest(p.slaves):
        found.append(p._replace(estop=False, master=follow(MASTER, p.master, [MasterEvent.ACKNOWLEDGE])))
    return found


def test_every_history_of_a_controller_that_follows_the_tables_keeps_the_invariants() -> None:
    graph = explore(Plant(), changes)
    seen = [Snapshot(n * MS, p.master, p.slaves, p.executing, p.estop, p.estop)
            for n, p in enumerate(graph.states)]
    assert violations(seen, MS) == []
    pairs = {p.slaves for p in graph.states}
    assert pairs == set(product(Slave, repeat=2)) and {p.master for p in graph.states} == set(Master)


REST = Snapshot(0, Master.RUN, (Slave.STOP, Slave.RUN), (0, 1))
SLOT = (1, True, 0)
STOPPED = replace(REST, master=Master.ERROR, slaves=(Slave.ERROR, Slave.ERROR), executing=(0, 0), estop=True,
                  safe=True)
GOOD = [
    REST, Took(1, 1, 5, Command.START), replace(REST, time_ns=MS, slaves=(Slave.READY, Slave.RUN)),
    Executed(1, 1, 5), replace(REST, time_ns=2 * MS, slaves=(Slave.RUN, Slave.RUN), executing=(1, 1)),
    Took(1, 2, 5, Command.UPDATE), Executed(1, 2, 5),
    replace(REST, raised=frozenset((SLOT,)), open=frozenset((SLOT,))),
    replace(REST, time_ns=3 * MS, estop=True),
    replace(STOPPED, time_ns=4 * MS), replace(STOPPED, time_ns=5 * MS),
    Access("master", "set", "MPF", 0x1FC000, 1), Access("slave1", "set", "SPF", 0x1FD000, 1),
    Access("slave1", "load", "MPF", 0x1FC000, 1),
]


@pytest.mark.parametrize(("name", "entries"), [
    ("I1", [replace(REST, executing=(1, 1))]), ("I1", [replace(REST, executing=(0, 0))]),
    ("I2", [replace(REST, slaves=(Slave.READY, Slave.RUN), executing=(2, 1))]),
    ("I3", [replace(REST, master=Master.STOP)]),
    ("I4", [replace(REST, time_ns=6 * MS, estop=True)]),
    ("I4", [replace(STOPPED, time_ns=6 * MS, safe=False)]),
    ("I5", [Executed(2, 1, 5)]), ("I5", [Executed(1, 3, 5)]), ("I5", [Executed(1, 1, 6)]),
    ("I5", [Took(1, 3, 5, Command.STOP), Executed(1, 2, 5)]),
    ("I6", [replace(REST, raised=frozenset((SLOT,)))]),
    ("I7", [Access("slave1", "clear", "MPF", 0x1FC000, 1)]),
    ("I7", [Access("master", "store", "SMD", 0x1F4000, bytes(8)),
            Access("slave1", "store", "SMD", 0x1F4004, 0)]),
])
def test_invariants_find_what_breaks_them(name: str, entries: list) -> None:
    assert violations(GOOD, MS) == []
    assert name in {found.partition(":")[0] for found in violations([*GOOD, *entries], MS)}


def test_every_invariant_has_a_name() -> None:
    assert list(INVARIANTS) == [f"I{n}" for n in range(1, 8)]
