"""The control socket: requests come in threads of their own, what they do is done between two scans.

Loading and checking a program takes long and happens beside the scans; only the swap itself is handed to the
thread that runs them (``serve``).
"""

from __future__ import annotations

import fcntl
import hashlib
import os
import queue
import socket
import struct
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, Future
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TypeVar

from ldc import unfinished
from ldc.diagnostics import Invalid
from ldc.il.coordination_image import pack
from runtime.online import findings, wire
from runtime.online.audit import Audit, client_name
from runtime.online.checks import Limits
from runtime.online.controller import TEST_NS, Controller, Event, Loaded, Staged, prepare
from runtime.online.loading import areas_of, engine_of, load, undisturbed
from runtime.online.values import Values
from runtime.online.wire import Act, Answer, Changes, Pull, Report, Request, Stage, State, Status

_CLIENTS = 32
_POLL = 0.2
_LONGEST = 24 * 3600 * 10**9
Result = TypeVar("Result")


class Busy(Exception):
    """Another runtime serves the socket."""


class Server:
    """Serves ``controller`` at the socket ``path``. ``name``: of the program, for people.

    Raises OSError when the socket cannot be made, Busy when a runtime has it. The folder of the socket
    is made for the user alone. ``begin`` is called in the thread that makes those of clients. ``settings``:
    what the runtime was started with, for clients to compare.
    """

    def __init__(self, controller: Controller, path: Path, name: str, audit: Audit,
                 limits: Limits = Limits(), say: Callable[[str], None] = lambda text: None,
                 begin: Callable[[], None] = lambda: None, settings: Mapping[str, str] = {}) -> None:
        self.controller, self.path, self.name = controller, path, name
        self._audit, self._limits, self._say, self._begin = audit, limits, say, begin
        self._last, self._pause, self._settings = "", 0, dict(settings)
        self._begun = hashlib.sha256(repr(sorted(settings.items())).encode())
        self.waits: Callable[[], str] = str  # what the sequence waits for; whoever has one tells
        self._jobs: queue.SimpleQueue[tuple[Future, Callable[[], object]]] = queue.SimpleQueue()
        self._room = threading.Semaphore(_CLIENTS)
        self._loading = threading.Lock()
        self._ended = threading.Event()
        self.values = Values(self._log)
        self._socket = _bound(path)
        self._made = path.lstat().st_ino
        controller.note = self._note
        self._thread = threading.Thread(target=self._accept, name="online", daemon=True)
        self._thread.start()
        self._audit.line("started", program=controller.running.digest, settings=self._digest(), name=name)

    def close(self) -> None:
        """No further requests; those that wait are answered by the end of their connection."""
        self._ended.set()
        self._thread.join()
        self._socket.close()
        self._unlink()
        while not self._jobs.empty():
            self._jobs.get()[0].cancel()
        self._audit.line("ended", program=self.controller.running.digest, scan=self.controller.machine.scans)

    def _unlink(self) -> None:
        """The name goes, unless somebody took it away and another runtime has it by now."""
        with suppress(OSError), _by_turns(self.path.parent):
            if self.path.lstat().st_ino == self._made:
                self.path.unlink()

    # ---- of the thread that runs scans -----------------------------------------------------------

    def serve(self) -> bool:
        """To be called between two scans: does what clients want until another program runs; whether one does
        now. Whoever follows it does so within ``following``."""
        controller, before = self.controller, self.controller.swaps
        begin = time.perf_counter_ns()
        controller.between()
        while controller.swaps == before and not self._jobs.empty():
            future, job = self._jobs.get()
            try:
                future.set_result(job())
            except Invalid as error:
                future.set_exception(error.with_traceback(None))  # its frames hold the future
        if controller.swaps == before:
            return False
        self._pause = time.perf_counter_ns() - begin
        return True

    @contextmanager
    def following(self) -> Iterator[None]:
        """What is done for the program that runs from now on belongs to the pause of the swap."""
        begin = time.perf_counter_ns()
        yield
        self._pause += time.perf_counter_ns() - begin

    def _note(self, event: Event) -> None:
        self._audit.event(event, self._digest())
        self._last = f"{event.action}: {event.detail}" if event.action == "reverted" else event.action
        self._say(f"online change, scan {event.scan}: {self._last}")

    # ---- of the threads of clients ---------------------------------------------------------------

    def _accept(self) -> None:
        self._begin()
        self._socket.settimeout(_POLL)
        while not self._ended.is_set():
            try:
                connection, _ = self._socket.accept()
            except TimeoutError:
                continue
            except OSError:
                time.sleep(_POLL)  # too many open files: those that are open end
                continue
            if not self._room.acquire(timeout=1.0):
                connection.close()
                continue
            threading.Thread(target=self._client, args=(connection,), daemon=True).start()

    def _client(self, connection: socket.socket) -> None:
        """One request and its answer. A client that goes away, or is slow, leaves nothing behind."""
        try:
            with connection:
                if not _same_user(connection):
                    return
                connection.settimeout(wire.PATIENCE)
                silent = not connection.recv(1, socket.MSG_PEEK)  # a look whether the socket is taken
                try:
                    answer = self._answer(wire.receive(connection, Request))
                except Invalid as error:
                    answer = Answer(findings=[wire.finding(d) for d in error.diagnostics])
                    if not silent:
                        self._audit.line("refused", codes=[d.code for d in error.diagnostics],
                                         detail=error.diagnostics[0].message)
                wire.send(connection, answer)
                wire.leave(connection)
        except (OSError, CancelledError):
            return
        finally:
            self._room.release()

    def _answer(self, request: Request) -> Answer:
        match request:
            case Status():
                return self._between(lambda: Answer(state=self._state(), settings=self._settings))
            case Pull():
                return self._between(self._pulled)
            case Report():
                return self._report()
            case Stage():
                return self._stage(request)
            case Act():
                return self._act(request)
        return self._between(lambda: self.values.answer(request, self.controller.machine))()

    def _log(self, action: str, owner: str, **more: object) -> None:
        self._audit.line(action, program=self.controller.running.digest, client=client_name(owner), **more)

    def _between(self, job: Callable[[], Result]) -> Result:
        """The result of a job that is done between two scans."""
        future: Future = Future()
        self._jobs.put((future, job))
        if self._ended.is_set():
            future.cancel()
        try:
            return future.result()
        finally:
            del future  # which holds what it raises, whose frames would hold it

    def _stage(self, request: Stage) -> Answer:
        if not self._loading.acquire(blocking=False):
            raise findings.refused(findings.in_other_hands("another client is staging a program just now"))
        try:
            controller = self.controller
            self._between(lambda: controller.free_for(request.owner))
            old = controller.running
            with undisturbed():
                new = load(request, old.machine, self.path.parent)
                with _closed_unless_taken(new):
                    staged = prepare(old, new, request.base, request.owner, self._limits)
                    self._expect(new)
                    self._between(lambda: controller.stage(staged))
            return self._changes(staged)
        finally:
            self._loading.release()

    def _expect(self, new: Loaded) -> None:
        """Whoever follows the controller makes ready for the program. Raises Invalid when that cannot be."""
        try:
            self.controller.expect(new)
        except (OSError, ValueError, LookupError) as error:
            raise findings.refused(findings.unusable(f"{type(error).__name__}: {error}"[:300])) from error

    def _act(self, request: Act) -> Answer:
        controller, owner = self.controller, request.owner
        limit = TEST_NS if request.limit_ns is None else request.limit_ns
        if not 0 < limit <= _LONGEST:
            raise wire.refuse(f"a test of {limit} ns")
        actions = {
            "test": lambda: controller.test(owner, limit),
            "untest": lambda: controller.untest(owner),
            "commit": lambda: controller.commit(owner),
            "cancel": lambda: controller.cancel(owner, request.force),
        }
        if request.action not in actions:
            raise wire.refuse(f"`{request.action[:20]}` is no action")

        self._between(actions[request.action])
        return self._between(lambda: Answer(state=self._state()))  # how long the swap took is known by now

    def _state(self) -> State:
        controller, machine = self.controller, self.controller.machine
        left = controller.deadline_ns - machine.now_ns if controller.deadline_ns is not None else 0
        faults = [wire.finding(fault.diagnostic()) for fault in machine.faults]
        staged = controller.staged.new.digest if controller.staged else ""
        client = client_name(controller.staged.owner) if controller.staged else ""
        return State(self.name, engine_of(machine), controller.state, controller.running.digest, staged,
                     machine.scans, machine.now_ns, left, faults, machine.resource, areas_of(machine),
                     client, self._last, self._pause, self.waits(), self._digest())

    def _digest(self) -> str:
        """Of the settings of what runs: those that came with it, and those that the runtime was started with."""
        made = self._begun.copy()
        made.update(self.controller.running.settings.encode())
        return made.hexdigest()

    def _pulled(self) -> Answer:
        running = self.controller.running
        return Answer(state=self._state(), image=running.image, together=pack(running.together),
                      sources=list(running.sources), settings=self._settings)

    def _report(self) -> Answer:
        staged = self.controller.staged
        if staged is None:
            raise findings.refused(findings.nothing_staged("report"))
        return self._changes(staged)

    def _changes(self, staged: Staged) -> Answer:
        plan = staged.plan
        changes = Changes(list(plan.kept), list(plan.initialised), list(plan.dropped))
        return Answer(state=self._between(self._state), changes=changes, sources=list(staged.new.sources))


@contextmanager
def _closed_unless_taken(new: Loaded) -> Iterator[None]:
    """A program that is refused is given up at once: the collector of garbage never comes to what was made
    undisturbed."""
    try:
        yield
    except BaseException:
        new.machine.close()
        raise


def _bound(path: Path) -> socket.socket:
    """A listening socket that only this user can reach. One that a dead runtime left is replaced."""
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    unfinished.sweep(path.parent)  # of a runtime that was killed in a load
    made = socket.socket(socket.AF_UNIX)
    try:
        with _by_turns(path.parent):
            if path.exists():
                with socket.socket(socket.AF_UNIX) as probe:
                    try:
                        probe.connect(str(path))
                    except ConnectionRefusedError:
                        path.unlink()
                    else:
                        raise Busy(str(path))
            before = os.umask(0o177)
            try:
                made.bind(str(path))
            finally:
                os.umask(before)
            made.listen(_CLIENTS)
    except BaseException:
        made.close()
        raise
    return made


@contextmanager
def _by_turns(folder: Path) -> Iterator[None]:
    """Of two runtimes that start at once, none takes the socket away that the other has just made."""
    opened = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        with suppress(OSError):  # a file system without locks
            fcntl.flock(opened, fcntl.LOCK_EX)
        yield
    finally:
        os.close(opened)


def _same_user(connection: socket.socket) -> bool:
    raw = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
    _, user, _ = struct.unpack("3i", raw)
    return user in (os.getuid(), 0)
