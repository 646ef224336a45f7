"""How the modules of a project work together, as `ldc.toml` says it (docs/messages.md).

[sequence]       repeat, start, steps: which module is started after which (L, SPEC 4)
[messages.NAME]  class, from, data, to, policy, depth: what one module tells others (M, SPEC 3)
[safety]         estop, reset
[plant]          file, step, parameters, seed: what is simulated on this computer

Values are as written: whether the program has these modules and variables is known after it is compiled.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct

from ldc.records import field, record
from ldc.toml_tables import Path, Tables

SECTIONS = ("sequence", "messages", "safety", "plant")

_LEAST_STEP = 1_000
"""Of a plant, in ns."""

Name = Annotated[str, Meta(min_length=1)]
Value = bool | Annotated[int, Meta(ge=-(1 << 63), le=(1 << 63) - 1)] | float | str
Policy = Literal["queue", "overwrite", "reject"]


class SequenceTable(Struct):
    repeat: bool = True
    start: Name | None = None
    steps: Annotated[tuple[Any, ...], Meta(min_length=1)] | None = None


class StepTable(Struct):
    module: Name = ""
    parameters: dict[str, Value] = {}
    when: Name | None = None
    until: Name | None = None


class MessageTable(Struct, rename={"kind": "class", "source": "from"}):
    kind: Literal["user", "system"] = "user"
    source: Name | None = None
    data: Name | None = None
    to: tuple[Any, ...] = ()
    policy: Policy = "queue"
    depth: Annotated[int, Meta(ge=1, le=4)] = 4


class SubscriberTable(Struct):
    module: Name = ""
    flag: Name | None = None
    data: Name | None = None


class SafetyTable(Struct):
    estop: Name | None = None
    reset: Name | None = None


class PlantTable(Struct):
    file: Name = ""
    step: Name = "1ms"
    parameters: Name | None = None
    seed: Annotated[int, Meta(ge=0, le=(1 << 63) - 1)] = 1


@record
class StepSetting:
    """A step: ``module`` is started with ``parameters`` (name to value) once ``when`` is TRUE, and has ended
    when it says so and ``until`` is TRUE. ``key``: where the step stands in the file."""

    module: str
    parameters: Mapping[str, Value]
    when: str | None
    until: str | None
    key: Path = field(compare=False)


@record
class SequenceSetting:
    """``steps``: None takes every module that can be started, in the order of the modules."""

    repeat: bool
    start: str | None
    steps: tuple[StepSetting, ...] | None


@record
class SubscriberSetting:
    module: str
    flag: str | None
    data: str | None
    key: Path = field(compare=False)


@record
class MessageSetting:
    """``kind``: user or system. ``source``: path whose rising edge broadcasts; ``data``: what goes along."""

    name: str
    kind: str
    source: str | None
    data: str | None
    to: tuple[SubscriberSetting, ...]
    policy: str
    depth: int


@record
class PlantSetting:
    """``file``, ``parameters``: relative to the folder of the project; ``step_ns``: between two steps."""

    file: str
    step_ns: int
    parameters: str | None
    seed: int


@record
class CoordinationSettings:
    """What a project says of it; nothing of it is there when the file has none of the tables. ``estop``: path
    of what is TRUE in an emergency; ``reset``: of what acknowledges faults at its rising edge."""

    sequence: SequenceSetting | None = None
    messages: tuple[MessageSetting, ...] = ()
    estop: str | None = None
    plant: PlantSetting | None = None
    reset: str | None = None

    def __bool__(self) -> bool:
        return self != CoordinationSettings()


def read(tables: Tables, duration: Callable[[Tables, Path, str], int]) -> CoordinationSettings:
    """The four tables of a project file; what is wrong is reported to ``tables``. ``duration``: reads a
    time that must be greater than 0."""
    plant = None
    if tables.has("plant"):
        table = tables.table(("plant",), PlantTable)
        if not table.file:
            tables.wrong(("plant",), "[plant] names no file", 'write file = "plant.py"')
        step = duration(tables, ("plant", "step"), table.step)
        if step < _LEAST_STEP:
            tables.wrong(("plant", "step"), f"the plant would step every {step} ns",
                         "1us is the least: the steps of a scan have to be simulated, one after the other")
        plant = PlantSetting(table.file, step, table.parameters, table.seed)
    safety = tables.table(("safety",), SafetyTable)
    return CoordinationSettings(
        _sequence(tables) if tables.has("sequence") else None,
        tuple(_message(tables, name) for name in tables.mapping("messages")),
        safety.estop,
        plant,
        safety.reset,
    )


def _sequence(tables: Tables) -> SequenceSetting:
    table = tables.table(("sequence",), SequenceTable)
    if table.steps is None:
        return SequenceSetting(table.repeat, table.start, None)
    steps = []
    for number, item in enumerate(table.steps):
        key = ("sequence", "steps", number)
        step = tables.record(key, {"module": item} if isinstance(item, str) else item, StepTable,
                             'write "clamp" or { module = "clamp", until = "closed" }')
        if step is None:
            continue
        if not step.module:
            tables.wrong(key, "a step names no module", 'write { module = "clamp" }')
        steps.append(StepSetting(step.module, step.parameters, step.when, step.until, key))
    return SequenceSetting(table.repeat, table.start, tuple(steps))


def _message(tables: Tables, name: str) -> MessageSetting:
    path = ("messages", name)
    table = tables.table(path, MessageTable)
    to = []
    for number, item in enumerate(table.to):
        key = (*path, "to", number)
        one = tables.record(key, {"module": item} if isinstance(item, str) else item, SubscriberTable,
                            'write "inject" or { module = "inject", flag = "on_clamped" }')
        if one is None:
            continue
        if not one.module:
            tables.wrong(key, f"a subscriber of message `{name}` names no module",
                         'write "inject" or { module = "inject", flag = "on_clamped" }')
        to.append(SubscriberSetting(one.module, one.flag, one.data, key))
    return MessageSetting(name, table.kind, table.source, table.data, tuple(to), table.policy, table.depth)
