"""What of a project makes it a system: algorithms on slaves, a sequence, messages, an emergency stop, a plant."""

from __future__ import annotations

from collections.abc import MutableSequence
from dataclasses import replace

from ldc import pipeline
from ldc.cli.coordinate import coordination
from ldc.cli.plant import Plant
from ldc.il.coordination import Coordination, Module
from ldc.il.external import Binding
from ldc.il.placement import Placed, placed, points
from runtime.field import Field, field_size
from runtime.machine import Machine
from runtime.master.wiring import Wiring
from runtime.online.controller import Controller
from runtime.slave.algorithm import makers
from runtime.system import System
from runtime.units import UnitEvent


def is_system(result: pipeline.Compiled) -> bool:
    """Whether a project needs more than a machine to run; otherwise it is executed as it always was."""
    manifest = result.sources.manifest
    return bool(result.program.algorithms) or manifest is not None and bool(manifest.coordination)


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
           events: MutableSequence[UnitEvent] | None = None) -> System:
    """The system of a compiled project around its master. Raises Invalid."""
    algorithms, said = placement(result), together(result)
    places = points(result.program, algorithms)
    field = Field(bytearray(field_size(places)), places)
    plant = Plant(said.plant, field) if said.plant is not None else None
    local = {pin.path.upper() for p in algorithms for pin in p.local}
    return System(runner, algorithms, makers(result.program, bindings), said, field, plant=plant,
                  plant_ns=said.plant.step_ns if said.plant else 1_000_000,
                  wiring=Wiring(field, sorted(field.asked - local)), events=events)
