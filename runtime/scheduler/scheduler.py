"""The scheduler: several processors on one line of virtual time, four levels each (SPEC 6.1, rules R1 to R4).

Pure: it knows no clock, only the times that ``run`` is given; the same threads and events give the same log.
Things of one instant go in this order: pieces end, periods begin, then the processors take turns by index,
each until it is busy or has nothing to do. Two threads that cost nothing and raise each other for ever let no
time go by.
"""

from __future__ import annotations

from collections.abc import MutableSequence, Sequence
from dataclasses import dataclass, field
from heapq import heappop, heappush, heapreplace
from operator import length_hint

from runtime.scheduler.thread import Entry, Thread

SHARE = (3, 10)
"""The part of the slack of a scan that customised threads may take (R4)."""

OVERRUNS = 3
"""Periods missed since the last execution that ended in time, at which the watchdog comes (R3)."""

_END, _PERIOD = 0, 1


@dataclass(slots=True, eq=False)
class _Processor:
    """``bit``: that of its index; ``ready``: a heap of (order, time, number, thread); ``stack``: the thread in
    execution on top of those that it pre-empted; ``busy``: a piece is in work; ``scan``: the thread that
    ``customised`` follow."""

    index: int
    bit: int
    threads: dict[str, Thread]
    ready: list[tuple[int, int, int, Thread]] = field(default_factory=list)
    stack: list[Thread] = field(default_factory=list)
    busy: bool = False
    scan: Thread | None = None
    customised: tuple[Thread, ...] = ()


class Scheduler:
    """``processors``: the threads of each, in the order of their ids; names are unique on a processor.
    ``log``: anything that entries are appended to; None: nothing is noted. ``now_ns``: the time."""

    def __init__(self, processors: Sequence[Sequence[Thread]],
                 log: MutableSequence[Entry] | None = None) -> None:
        self.now_ns = 0
        self.log = log
        self._agenda: list[tuple] = []
        self._turns = 0  # bits of processors that may go on
        self._working = 0  # pieces in work
        self._until = 0
        self._processors: dict[int, _Processor] = {}  # by their bits
        for threads in processors:
            self.add(threads)

    def add(self, threads: Sequence[Thread]) -> None:
        """A further processor, before the first event. Raises ValueError when two threads have one name."""
        index = len(self._processors)
        made = _Processor(index, 1 << index, {thread.name: thread for thread in threads})
        if len(made.threads) < len(threads):
            raise ValueError(f"processor {index}: two threads of one name")
        self._processors[made.bit] = made
        made.scan = next((t for t in threads if t.kind == "control"), None)
        made.customised = tuple(t for t in threads if t.kind == "customised")
        ids = {thread.name: n for n, thread in enumerate(threads)}
        by_period = sorted(threads, key=lambda t: (t.period_ns is None, t.period_ns or 0, ids[t.name]))
        for number, thread in enumerate(by_period):
            thread.number, thread.on = number, made
            thread.quick = self.log is None and thread is not made.scan
            if thread.period_ns is not None:
                thread.due = thread.offset_ns
                heappush(self._agenda, (thread.due, _PERIOD, index, number, thread, made))

    def thread(self, processor: int, name: str) -> Thread:
        """A thread by its name. Raises KeyError."""
        return self._processors[1 << processor].threads[name]

    @property
    def threads(self) -> tuple[tuple[Thread, ...], ...]:
        """Those of each processor."""
        return tuple(tuple(on.threads.values()) for on in self._processors.values())

    @property
    def next_ns(self) -> int | None:
        """When something happens next; None: never, unless an event comes."""
        return self.now_ns if self._turns else self._agenda[0][0] if self._agenda else None

    # ---- activation ------------------------------------------------------------------------------

    def raise_event(self, thread: Thread) -> None:
        """Activates a thread now. While it is active already, one further activation waits, others are lost
        and counted. Raises ValueError for a customised thread."""
        if thread.kind == "customised":
            raise ValueError(f"thread {thread.name} follows the scan, it takes no events")
        if self._working:
            self._end_pieces()
        if not thread.active:
            self._activate(thread.on, thread, self.now_ns)
        elif thread.pending is None:
            thread.pending = self.now_ns
        else:
            thread.counts.lost += 1
            self._note(thread.on, thread, "lost")

    def release(self, thread: Thread) -> None:
        """What a period does, for threads whose periods somebody else counts: activates the thread, or notes
        that it missed a period."""
        self._end_pieces()
        self._released(thread.on, thread)

    def release_first(self, thread: Thread) -> bool:
        """``release`` of the most urgent thread that its processor gets, at a moment at which nothing else
        happens; whether something is to be done because of it. It begins at once, without the queue."""
        on = thread.on
        if self._turns or on.busy or thread.active:
            self.release(thread)
        else:
            thread.active, thread.released = True, self.now_ns
            self._begin(on, thread)
            if on.stack:
                self._turns |= on.bit
        return self._turns != 0

    def executed(self, thread: Thread, times: int) -> None:
        """Notes that a thread was executed some times in no time each, the last time now, as ``release_first``
        does; for those who know that nobody else had anything to do meanwhile."""
        counts = thread.counts
        counts.executions += times
        counts.least_delay, thread.released, thread.streak = 0, self.now_ns, 0

    def _released(self, on: _Processor, thread: Thread) -> None:
        if not thread.active:
            self._activate(on, thread, self.now_ns)
        elif thread.released < self.now_ns:
            counts = thread.counts
            if not thread.late:
                thread.late = True
                counts.overruns += 1
                self._note(on, thread, "overrun")
            counts.missed += 1
            self._note(on, thread, "missed")
            thread.streak += 1
            if thread.streak == OVERRUNS:
                thread.streak = 0
                counts.watchdogs += 1
                self._note(on, thread, "watchdog")
                if thread.on_watchdog is not None:
                    thread.on_watchdog(self.now_ns)

    def _activate(self, on: _Processor, thread: Thread, since: int) -> None:
        thread.active = True
        if not thread.paused:
            thread.released = since
        heappush(on.ready, (thread.order, self.now_ns, thread.number, thread))
        self._turns |= on.bit

    # ---- time ------------------------------------------------------------------------------------

    def run(self, until_ns: int) -> None:
        """All that happens before ``until_ns``; that is the time afterwards."""
        agenda, processors = self._agenda, self._processors
        self._until = until_ns
        while True:
            if not self._turns or self.now_ns >= until_ns:
                if not agenda or agenda[0][0] >= until_ns:
                    break
                self.now_ns = agenda[0][0]
            now = self.now_ns
            if self._working:
                self._end_pieces()
            while agenda and agenda[0][0] == now:
                _, _, index, number, thread, on = agenda[0]
                thread.due = now + thread.period_ns
                heapreplace(agenda, (thread.due, _PERIOD, index, number, thread, on))
                if thread.active:
                    self._released(on, thread)
                else:
                    self._activate(on, thread, now)
            while self._turns:
                turns = self._turns
                on = processors[turns & -turns]
                self._turns = turns ^ on.bit
                if not on.busy:
                    self._turn(on)
        if self.now_ns < until_ns:
            self.now_ns = until_ns

    def _end_pieces(self) -> None:
        """The pieces that are over now."""
        agenda = self._agenda
        while agenda and agenda[0][0] == self.now_ns and agenda[0][1] == _END:
            on = heappop(agenda)[5]
            on.busy = False
            self._working -= 1
            self._turns |= on.bit
            self._end_if_through(on)

    def _turn(self, on: _Processor) -> None:
        """The processor goes on until it is busy or has nothing to do."""
        ready, stack = on.ready, on.stack
        while True:
            if stack:
                thread = stack[-1]
                if thread.left <= 0 and thread.kind == "customised":
                    if not self._end_if_through(on):
                        self._pause(on, thread)
                    continue
                if ready and ready[0][3].urgency < thread.urgency:
                    if self._end_if_through(on):
                        continue
                    if not thread.halted:
                        thread.halted = True
                        thread.counts.preemptions += 1
                        self._note(on, thread, "preempted")
                    self._begin(on, heappop(ready)[3])
                    continue
                if thread.halted:
                    thread.halted = False
                    self._note(on, thread, "resumed")
                cost = next(thread.pieces, None)
                if cost is None:
                    self._ended(on, stack.pop())
                elif cost:
                    if cost < 0:
                        raise ValueError(f"thread {thread.name}: a piece costs {cost} ns")
                    thread.counts.busy += cost
                    thread.left -= cost
                    end, agenda = self.now_ns + cost, self._agenda
                    if self._turns or end >= self._until or agenda and end >= agenda[0][0]:
                        on.busy, thread.ends = True, end
                        self._working += 1
                        heappush(agenda, (end, _END, on.index, 0, thread, on))
                        return
                    self.now_ns = end  # until then nothing else happens anywhere
            elif ready:
                self._begin(on, heappop(ready)[3])
            else:
                return

    def _begin(self, on: _Processor, thread: Thread) -> None:
        if thread.paused:
            thread.paused = False
            self._note(on, thread, "resumed")
            on.stack.append(thread)
            return
        counts, now = thread.counts, self.now_ns
        work = thread.work  # a slot is slow where a method is looked for
        delay = now - thread.released
        if delay:
            counts.least_delay = min(delay, counts.least_delay)
            counts.most_delay = max(delay, counts.most_delay)
        else:
            counts.least_delay = 0
        if self.log is not None:
            self._note(on, thread, "began")
        pieces = work(now)
        if pieces is not None:
            thread.pieces = pieces
            on.stack.append(thread)
        elif delay or not thread.quick or thread.pending is not None:
            self._ended(on, thread)
        else:  # as in _ended, in no time
            thread.active, thread.streak = False, 0
            counts.executions += 1

    def _end_if_through(self, on: _Processor) -> bool:
        """Ends the thread in execution when its iterator tells that it has no piece more."""
        if length_hint(on.stack[-1].pieces, 1):
            return False
        self._ended(on, on.stack.pop())
        return True

    def _pause(self, on: _Processor, thread: Thread) -> None:
        on.stack.pop()
        thread.paused, thread.active = True, False
        self._note(on, thread, "paused")

    def _ended(self, on: _Processor, thread: Thread) -> None:
        counts, now = thread.counts, self.now_ns
        response = now - thread.released
        counts.executions += 1
        counts.response += response
        if response > counts.worst:
            counts.worst = response
        thread.active, thread.pieces = False, None
        if not thread.late:
            thread.streak = 0
        thread.late = False
        if self.log is not None:
            self._note(on, thread, "ended")
        if thread.pending is not None:
            since, thread.pending = thread.pending, None
            self._activate(on, thread, since)
        if thread is on.scan:
            for follower in on.customised:
                self._grant(on, thread, follower)

    def _grant(self, on: _Processor, scan: Thread, follower: Thread) -> None:
        """The budget of a customised thread for the rest of this scan. What its last piece took too much in
        earlier scans is taken off."""
        granted = follower.budget_ns
        if scan.due is not None:
            share = (scan.due - self.now_ns) * SHARE[0] // SHARE[1]
            granted = share if granted is None else min(share, granted)
        if granted is None:
            raise ValueError(f"thread {follower.name}: neither it has a budget nor {scan.name} a period")
        follower.left = min(follower.left, 0) + granted
        if follower.left > 0 and not follower.active:
            self._activate(on, follower, self.now_ns)

    def _note(self, on: _Processor, thread: Thread, what: str) -> None:
        if self.log is not None:
            self.log.append(Entry(self.now_ns, on.index, thread.name, what))
