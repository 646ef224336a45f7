"""What holds in every trace of a controller, I1 to I7 (SPEC 5). Each check gives its violations in words.

A trace is a sequence of snapshots, taken when everything of a moment is done, and of the events between them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from ldc.records import record
from runtime.processors.states import Master, Slave, at_rest
from runtime.protocol.envelope import Command
from runtime.protocol.memory import Access


@record
class Snapshot:
    """``slaves``, ``executing``: a state and the flags of AFE for each slave, from slave 1. ``safe``: all
    outputs have their safe values. ``raised``: slots of which a flag is 1; ``open``: those with a transfer;
    both as (slave, to slave?, slot)."""

    time_ns: int
    master: Master
    slaves: tuple[Slave, ...]
    executing: tuple[int, ...]
    estop: bool = False
    safe: bool = False
    raised: frozenset[tuple[int, bool, int]] = frozenset()
    open: frozenset[tuple[int, bool, int]] = frozenset()


@record
class Took:
    """A slave has checked and taken a transfer."""

    slave: int
    seq: int
    aid: int
    cmd: int


@record
class Executed:
    """A slave has begun to execute an algorithm (A.EXEC) with the parameters of transfer ``seq``."""

    slave: int
    seq: int
    aid: int


Entry = Snapshot | Took | Executed | Access


def _snapshots(trace: Sequence[Entry]) -> Iterator[Snapshot]:
    return (entry for entry in trace if isinstance(entry, Snapshot))


def _each(trace: Sequence[Entry]) -> Iterator[tuple[Snapshot, int, Slave, int]]:
    for s in _snapshots(trace):
        for number, (state, afe) in enumerate(zip(s.slaves, s.executing, strict=True), 1):
            yield s, number, state, afe


def i1(trace: Sequence[Entry], period_ns: int) -> list[str]:
    """A slave is in ``srun`` exactly while one of its algorithms executes."""
    return [f"slave{n} is {state.value} and AFE is {afe:#x} at {s.time_ns} ns"
            for s, n, state, afe in _each(trace) if (state is Slave.RUN) != (afe != 0)]


def i2(trace: Sequence[Entry], period_ns: int) -> list[str]:
    """In ``sready`` no algorithm executes."""
    return [f"slave{n} is sready and AFE is {afe:#x} at {s.time_ns} ns"
            for s, n, state, afe in _each(trace) if state is Slave.READY and afe]


def i3(trace: Sequence[Entry], period_ns: int) -> list[str]:
    """In ``mstop`` every slave is in ``sstop`` or ``serror``."""
    return [f"the master is mstop and slaves are {', '.join(x.value for x in s.slaves)} at {s.time_ns} ns"
            for s in _snapshots(trace) if s.master is Master.STOP and not at_rest(s.slaves)]


def i4(trace: Sequence[Entry], period_ns: int) -> list[str]:
    """Within a period of an emergency stop nothing executes and outputs are safe, until it is over."""
    found, since = [], None
    for s in _snapshots(trace):
        since = None if not s.estop else s.time_ns if since is None else since
        if since is not None and s.time_ns - since >= period_ns and (any(s.executing) or not s.safe):
            found.append(f"{s.time_ns - since} ns after the emergency stop AFE is {list(s.executing)}, "
                         f"outputs are {'' if s.safe else 'not '}safe at {s.time_ns} ns")
    return found


def i5(trace: Sequence[Entry], period_ns: int) -> list[str]:
    """An algorithm is executed only after its START was taken, the one whose parameters it has or an earlier
    one that no STOP has ended."""
    found, started, taken = [], set(), set()
    for entry in trace:
        match entry:
            case Took(slave, seq, aid, cmd):
                if cmd == Command.START:
                    started.add((slave, aid))
                elif cmd == Command.STOP:
                    started.discard((slave, aid))
                if cmd in (Command.START, Command.UPDATE):
                    taken.add((slave, seq, aid))
            case Executed(slave, seq, aid):
                if (slave, aid) not in started or (slave, seq, aid) not in taken:
                    found.append(
                        f"slave{slave} executes {aid:#x} with transfer {seq}, of which no START was taken")
    return found


def i6(trace: Sequence[Entry], period_ns: int) -> list[str]:
    """Flags of a slot are 0 whenever no transfer is open."""
    return [f"a flag of slave {slave}, {'to' if to_slave else 'from'} it, slot {slot} is 1 without a "
            f"transfer at {s.time_ns} ns"
            for s in _snapshots(trace) for slave, to_slave, slot in sorted(s.raised - s.open)]


def i7(trace: Sequence[Entry], period_ns: int) -> list[str]:
    """Each word has one writer. Accesses to memory of one processor alone are not for this trace."""
    writers: dict[int, str] = {}
    found = []
    for entry in trace:
        if isinstance(entry, Access) and entry.kind != "load":
            size = len(entry.value) if isinstance(entry.value, bytes) else 4
            for address in range(entry.address, entry.address + size, 4):
                writer = writers.setdefault(address, entry.processor)
                if writer != entry.processor:
                    found.append(f"{entry.area} at {address:#x} is written by {writer} and {entry.processor}")
    return found


INVARIANTS: dict[str, Callable[[Sequence[Entry], int], list[str]]] = {
    "I1": i1, "I2": i2, "I3": i3, "I4": i4, "I5": i5, "I6": i6, "I7": i7}


def violations(trace: Sequence[Entry], period_ns: int) -> list[str]:
    """All of them, each with the name of its invariant. ``period_ns``: of the master's scan."""
    return [f"{name}: {text}" for name, check in INVARIANTS.items() for text in check(trace, period_ns)]
