"""What of a project makes it a system: algorithms on slaves, a sequence, messages, an emergency stop, a
plant."""

from __future__ import annotations

import csv
import io
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import BinaryIO, TextIO

from ldc import pipeline
from ldc.cli.coordinate import coordination
from ldc.cli.output import replacing
from ldc.cli.plant import Plant
from ldc.components.pace import slaves
from ldc.il.coordination import Coordination, Module
from ldc.il.external import Binding
from ldc.il.placement import Placed, placed, points
from ldc.records import replace
from runtime.cost import Cost
from runtime.field import Field, field_size
from runtime.machine import Machine
from runtime.master.wiring import Wiring
from runtime.online.controller import Controller
from runtime.processors.invariants import Entry
from runtime.slave.algorithm import makers
from runtime.system import Events, System
from runtime.units import UnitEvent
from runtime.values import milliseconds


_MORE = 1 << 14
"""Bytes of the field for points of programs that are loaded later."""


@contextmanager
def recorded(target: str | None, opened: BinaryIO | None) -> Iterator[EventFile | None]:
    """Where events go: `-` is standard output, None nowhere. ``opened``: the file, when it is open
    already."""
    if target is None:
        yield None
    elif target == "-":
        yield EventFile(sys.stdout)
    else:
        with replacing(Path(target)) if opened is None else nullcontext(opened) as file:
            text = io.TextIOWrapper(file, encoding="utf-8", newline="")
            yield EventFile(text)
            text.flush()
            text.detach()


class EventFile:
    """Events as CSV: time in ms, processor, unit, index (of a module, an algorithm, a message), detail."""

    def __init__(self, stream: TextIO) -> None:
        self._write = csv.writer(stream, lineterminator="\n").writerow
        self._write(("t_ms", "processor", "unit", "index", "detail"))

    def append(self, event: UnitEvent) -> None:
        self._write((milliseconds(event.time_ns), event.processor, event.unit, event.index, event.detail))


def together(result: pipeline.Compiled) -> Coordination:
    """How its modules work together. A project that says nothing of it has modules all the same."""
    found, manifest = coordination(result), result.sources.manifest
    if found.modules or manifest is None:
        return found
    names = manifest.modules or tuple(
        run.name for resource in result.program.resources[:1] for run in resource.runs)
    return replace(found, modules=tuple(Module(n, name, None, None, ()) for n, name in enumerate(names)))


def placement(result: pipeline.Compiled) -> tuple[Placed, ...]:
    """Its algorithms in their places."""
    manifest = result.sources.manifest
    return placed(result.program, manifest.modules if manifest else ())


def system(result: pipeline.Compiled, runner: Machine | Controller, bindings: tuple[Binding, ...],
           events: Events | None = None, seen: Callable[[Entry], None] | None = None,
           cost: Cost | None = None, watchdogs: Mapping[str, int] | None = None) -> System:
    """The system of a compiled project around its master. ``seen``, ``cost``, ``watchdogs``: as of
    ``System``. Raises Invalid."""
    algorithms, said, manifest = placement(result), together(result), result.sources.manifest
    places = points(result.program, algorithms)
    # Programs that take over online may have more points.
    field = Field(bytearray(field_size(places) + _MORE), places)
    plant = Plant(said.plant, field) if said.plant is not None else None
    local = {pin.path.upper() for p in algorithms for pin in p.local}
    return System(runner, algorithms, makers(result.program, bindings), said, field, plant=plant,
                  slaves=slaves(manifest.processors) if manifest else (),
                  plant_ns=said.plant.step_ns if said.plant else 1_000_000,
                  wiring=Wiring(field, sorted(field.asked - local)), events=events, seen=seen,
                  cost=cost, watchdogs=watchdogs, slave_watchdogs=manifest.watchdogs if manifest else {})
