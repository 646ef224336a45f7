"""The rules of the scheduler said once more, as slowly and simply as possible: nanosecond after nanosecond,
without queues. At every moment the thread to execute is the least of all that are active."""

from __future__ import annotations

from dataclasses import dataclass, field

LEVEL = {"emergency": 0, "visual": 1, "communication": 1, "control": 2, "algorithm": 2, "customised": 2,
         "diagnostics": 3}
BEHIND = {"communication", "customised"}


@dataclass
class Spec:
    """A thread: an execution raises ``raises`` (processor, name), then costs ``costs``, piece by piece."""

    name: str
    kind: str
    period: int | None
    costs: tuple[int, ...] = ()
    offset: int = 0
    priority: int = 0
    budget: int | None = None
    raises: tuple[int, str] | None = None


@dataclass
class State:
    spec: Spec
    number: int
    due: int | None
    active: bool = False
    begun: bool = False
    halted: bool = False
    paused: bool = False
    late: bool = False
    queued: int = -1
    released: int = -1
    pending: int | None = None
    rest: list[int] = field(default_factory=list)
    streak: int = 0
    left: int = 0

    @property
    def urgency(self) -> tuple[int, int]:
        return LEVEL[self.spec.kind], self.spec.priority


class Model:
    def __init__(self, processors: list[list[Spec]]) -> None:
        self.now, self.log = 0, []
        self.processors = [[State(s, n, s.offset if s.period else None) for n, s in enumerate(specs)]
                           for specs in processors]
        self.until: list[int | None] = [None] * len(processors)
        self.last: list[State | None] = [None] * len(processors)

    def note(self, at: int, thread: State, what: str) -> None:
        self.log.append((self.now, at, thread.spec.name, what))

    def activate(self, thread: State, since: int) -> None:
        thread.active, thread.queued = True, self.now
        if not thread.paused:
            thread.released = since

    def raise_event(self, at: int, name: str) -> None:
        self.pieces_end()
        thread = next(t for t in self.processors[at] if t.spec.name == name)
        if not thread.active:
            self.activate(thread, self.now)
        elif thread.pending is None:
            thread.pending = self.now
        else:
            self.note(at, thread, "lost")

    def period_begins(self, at: int, thread: State) -> None:
        thread.due += thread.spec.period
        if not thread.active:
            self.activate(thread, self.now)
        elif thread.released < self.now:
            if not thread.late:
                self.note(at, thread, "overrun")
            thread.late = True
            self.note(at, thread, "missed")
            thread.streak += 1
            if thread.streak == 3:
                self.note(at, thread, "watchdog")
                thread.streak = 0

    def ended(self, at: int, thread: State) -> None:
        thread.active = thread.begun = thread.halted = False
        thread.streak = thread.streak if thread.late else 0
        thread.late = False
        self.note(at, thread, "ended")
        if thread.pending is not None:
            since, thread.pending = thread.pending, None
            self.activate(thread, since)
        if thread is next((t for t in self.processors[at] if t.spec.kind == "control"), None):
            for follower in self.processors[at]:
                if follower.spec.kind == "customised":
                    share = (thread.due - self.now) * 3 // 10
                    if follower.spec.budget is not None:
                        share = min(share, follower.spec.budget)
                    follower.left = min(follower.left, 0) + share
                    if follower.left > 0 and not follower.active:
                        self.activate(follower, self.now)

    def pieces_end(self) -> None:
        for at, until in enumerate(self.until):
            if until == self.now:
                self.until[at] = None
                if not self.last[at].rest:
                    self.ended(at, self.last[at])

    def run(self, until: int) -> None:
        while self.now < until:
            self.pieces_end()
            for at, threads in enumerate(self.processors):
                for thread in sorted(threads, key=lambda t: (t.spec.period or 1 << 60, t.number)):
                    if thread.due == self.now:
                        self.period_begins(at, thread)
            while True:
                able = [at for at, threads in enumerate(self.processors)
                        if self.until[at] is None and any(t.active for t in threads)]
                if not able:
                    break
                while self.until[able[0]] is None and self.goes_on(able[0]):
                    pass
            self.now += 1

    def goes_on(self, at: int) -> bool:
        """One piece, begin or end of a thread; whether there was one."""
        active = [t for t in self.processors[at] if t.active]
        if not active:
            return False
        begun = [t for t in active if t.begun]
        if begun:
            top = min(begun, key=lambda t: t.urgency)
            if top.spec.kind == "customised" and top.left <= 0:
                top.active = top.begun = False
                top.paused = True
                self.note(at, top, "paused")
                return True
        best = min(active, key=lambda t: (t.urgency, not t.begun, t.spec.kind in BEHIND, t.queued,
                                          t.spec.period or 1 << 60, t.number))
        last = self.last[at]
        if last is not None and last.active and last.begun and not last.halted and last is not best:
            last.halted = True
            self.note(at, last, "preempted")
        self.last[at] = best
        if not best.begun:
            best.begun = True
            if best.paused:
                best.paused = False
                self.note(at, best, "resumed")
            else:
                self.note(at, best, "began")
                best.rest = list(best.spec.costs)
                if best.spec.raises:
                    self.raise_event(*best.spec.raises)
                if not best.rest:
                    self.ended(at, best)
            return True
        if best.halted:
            best.halted = False
            self.note(at, best, "resumed")
        cost = best.rest.pop(0)
        best.left -= cost
        if cost:
            self.until[at] = self.now + cost
        elif not best.rest:
            self.ended(at, best)
        return True
