"""`ldc online get|set|watch|force|unforce|forces|trace`: values of a running program, from the side of those
who look at them (docs/commissioning.md)."""

from __future__ import annotations

import argparse
import csv
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

from ldc.cli import link
from ldc.cli.attached import AFTER, BEFORE, listed
from ldc.cli.console import Failure, UsageError, is_terminal, say
from ldc.cli.inputs import read
from ldc.cli.output import replacing, write_result
from ldc.render import plural, visible
from runtime.online.wire import Answer, Arm, Collect, Force, Forced, Get, Set, Unforce, Value
from runtime.values import milliseconds

_POLL = 0.1
"""Seconds between two looks at a trace."""

_EVERY = 100_000_000


def run(options: argparse.Namespace) -> int:
    """Raises Invalid with what the runtime has against it."""
    path = _runtime(options)
    match options.action:
        case "get":
            _print_values(link.ask(path, Get(paths=list(options.paths))).values)
        case "set":
            link.ask(path, Set(path=options.path, value=options.value, owner=_owner(options)))
        case "force":
            link.ask(path, Force(path=options.path, value=options.value, owner=_owner(options)))
        case "unforce":
            _unforce(options, path)
        case "forces":
            _print_values(link.ask(path, Forced()).values)
        case "watch":
            _watch(options, path)
        case "trace":
            _trace(options, path)
    return 0


def _runtime(options: argparse.Namespace) -> Path:
    """The socket; the project is read only when its name is needed."""
    if options.socket or os.environ.get("LDC_SOCKET"):
        return link.socket_path(options.socket, "")
    return link.runtime_of(options, read([options.src]))


def _owner(options: argparse.Namespace) -> str:
    return link.owner_of([options.src])


def _unforce(options: argparse.Namespace, path: Path) -> None:
    if bool(options.path) == options.all:
        raise UsageError("unforce takes a variable, or --all")
    link.ask(path, Unforce(owner=_owner(options), path=options.path))


def _print_values(values: list[Value]) -> None:
    width = max((len(value.path) for value in values), default=0)
    for value in values:
        print(visible(f"{value.path:<{width}}  {value.shown}"))


def _watch(options: argparse.Namespace, path: Path) -> None:
    """A table on a terminal, rows of a trace elsewhere; until Ctrl-C, the end of the runtime or `--for`."""
    names = list(listed(options.names))
    if not names:
        raise UsageError("watch takes variables, as in `motor,warm.Q`")
    answer = link.ask(path, Get(paths=names))
    try:
        if is_terminal(sys.stdout):
            from ldc.cli.watch_table import shown  # loads rich

            with shown() as show:
                _poll(options, path, answer, names, show)
        else:
            writer = csv.writer(sys.stdout, lineterminator="\n")
            writer.writerow(("scan", "t_ms", *names))

            def row(now: Answer) -> None:
                # The state that a scan left, as in a trace: before the first there is none.
                writer.writerow((now.scan - 1, milliseconds(now.now_ns), *(v.value for v in now.values)))
                sys.stdout.flush()

            _poll(options, path, answer, names, row)
    except KeyboardInterrupt:
        pass  # how a watch ends


def _poll(options: argparse.Namespace, path: Path, answer: Answer, names: list[str],
          show: Callable[[Answer], None]) -> None:
    every = (options.every or _EVERY) / 1e9
    end = time.monotonic() + options.duration / 1e9 if options.duration else None
    due = time.monotonic()
    while True:
        show(answer)
        due = max(due + every, time.monotonic())
        if end is not None and due > end:
            return
        time.sleep(max(0.0, due - time.monotonic()))
        answer = link.ask(path, Get(paths=names))


def _trace(options: argparse.Namespace, path: Path) -> None:
    """Waits for the event, then for its rows. The file is opened before: an event may come only once."""
    if options.output in (None, "-"):
        write_result(_rows(options, path), None)
    else:
        with replacing(Path(options.output)) as file:
            file.write(_rows(options, path).encode())


def _rows(options: argparse.Namespace, path: Path) -> str:
    owner, names = _owner(options), list(listed(options.watch))
    before = BEFORE if options.before is None else options.before
    after = AFTER if options.after is None else options.after
    link.ask(path, Arm(paths=names, trigger=options.trigger, before=before, after=after, owner=owner))
    say("waiting for the event; Ctrl-C gives up")
    parts: list[str] = []
    first = 0
    while True:
        trace = link.ask(path, Collect(owner=owner, first=first)).trace
        if trace.state == "lost":
            raise Failure("the variable of the trigger is not in the program any more")
        if trace.state != "done":
            time.sleep(_POLL)
            continue
        parts.append(trace.text)
        first = trace.next
        if first >= trace.rows:
            break
    say(f"triggered in scan {trace.event}, {plural(trace.rows, 'row')}")
    return "".join(parts)
