"""When a run saves what is retained: at the first scan boundary after each interval, and at its end.

In virtual time a save is made where it is due. Scans that have their time must not wait for a disk: a copy
is taken between two scans, and a thread of its own makes and writes the save; when the disk is slower than
the interval, the newest copy is written next and those before it are left out.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Protocol

from runtime.machine import Machine
from runtime.retain import Identity, saver
from runtime.retain_file import Entry, Kept, Store

Job = Callable[[], None]
Begin = Callable[[], None]
Take = Callable[[], Callable[[], Kept]]


class Slaves(Protocol):
    """Those whose algorithms retain something."""

    def restore(self, kept: Mapping[str, Entry]) -> None:
        """Puts back what was saved, by path."""

    def retained(self) -> Callable[[], list[Entry]]:
        """Copies what there is, between two scans; what it gives tells it, in any thread."""


class Retaining:
    """Saves the machine that runs. ``every_ns``: of the program's time; ``beside``: in a thread, which calls
    this when it begins.
    ``saved`` is told the scan of each save that is on the disk, ``failed`` the first that could not be made:
    the program runs on. ``kept``: what was saved before the start, by path."""

    def __init__(self, machine: Machine, identity: Identity, store: Store, every_ns: int,
                 beside: Begin | None, failed: Callable[[OSError], None],
                 saved: Callable[[int], None] = lambda scan: None, *,
                 kept: Mapping[str, Entry] = {}) -> None:
        self._store, self._every, self.kept = store, every_ns, kept
        self._failed, self._saved = failed, saved
        self._told, self._name, self._due = False, identity.name, machine.now_ns + every_ns
        self._slaves: Slaves | None = None
        self._machine, self._take = machine, saver(machine, identity, self._of_slaves)
        self._prepare: Callable[[], Take] = lambda: saver(machine, identity, self._of_slaves)
        self._writer = _Writer(beside) if beside is not None else None

    def join(self, slaves: Slaves) -> None:
        """Algorithms of slaves get what they have retained, and are saved with the rest from now on."""
        slaves.restore(self.kept)
        self._slaves = slaves

    def _of_slaves(self) -> Callable[[], list[Entry]]:
        return list if self._slaves is None else self._slaves.retained()

    def follow(self, machine: Machine, program: str, layout: Callable[[], str]) -> None:
        """Another program goes on with the state. What is to be copied of it is found beside the scans."""
        self._machine, self._take = machine, None
        self._prepare = prepare = lambda: saver(
            machine, Identity(self._name, program, layout), self._of_slaves)
        if self._writer is None:
            self._take = prepare()
        else:
            self._writer.give(lambda: self._prepared(prepare))

    def _prepared(self, prepare: Callable[[], Take]) -> None:
        take = prepare()
        if prepare is self._prepare:  # no further program has taken over meanwhile
            self._take = take

    def scanned(self) -> None:
        """To be called after every scan."""
        now = self._machine.now_ns
        if now < self._due or self._take is None:
            return
        self._due = now + self._every
        job = self._take()
        if self._writer is None:
            self._write(job)
        else:
            self._writer.give(lambda: self._write(job))

    def close(self) -> None:
        """The last save, made between two scans. Raises OSError when it cannot be."""
        if self._writer is not None:
            self._writer.end()
        kept = (self._take or self._prepare())()()
        self._store.save(kept)
        self._saved(kept.scan)

    def abandon(self) -> None:
        """Ends without a save, in the midst of a scan: what is on the disk stays."""
        if self._writer is not None:
            self._writer.end()

    def _write(self, job: Callable[[], Kept]) -> None:
        try:
            kept = job()
            self._store.save(kept)
        except OSError as error:
            if not self._told:
                self._told = True
                self._failed(error)
        else:
            self._saved(kept.scan)


class _Writer:
    """A thread that does the newest job that it was given."""

    def __init__(self, begin: Begin) -> None:
        self._begin = begin
        self._job: Job | None = None
        self._given = threading.Condition()
        self._ended = False
        self._thread: threading.Thread | None = None

    def give(self, job: Job) -> None:
        if self._thread is None:  # not before the first scan: processes may be made until then
            self._thread = threading.Thread(target=self._run, name="retain", daemon=True)
            self._thread.start()
        with self._given:
            self._job = job
            self._given.notify()

    def end(self) -> None:
        """Returns when nothing is being written any more; what still waits is left out."""
        with self._given:
            self._ended, self._job = True, None
            self._given.notify()
        if self._thread is not None:
            self._thread.join()

    def _run(self) -> None:
        self._begin()
        while True:
            with self._given:
                while self._job is None and not self._ended:
                    self._given.wait()
                if self._ended:
                    return
                job, self._job = self._job, None
            job()
