"""How modules work together, resolved: what the master's runtime is built from (SPEC 3, 4).

Paths are those of variables (`clamp.closed`, `%IX0.7`). Values are kept in memory as words: a form of
`struct` says how, one word for what has up to 32 bits, two beyond.
"""

from __future__ import annotations

from collections.abc import Iterator
from struct import calcsize

from ldc.il.areas import Area, areas
from ldc.records import record, replace
from ldc.types import Elementary, Type, storage

Value = bool | int | float

SYSTEM_MESSAGES = ("START_MODULE", "STOP_MODULE", "ALARM", "ALG_DONE", "P_FAULT", "ESTOP", "RECIPE_CHANGED")
"""What the runtime raises, each with one UDINT; the place in the list is the number."""

USER_FIRST = 64
"""Offset in MSGF of the first message of the user."""

_INTEGERS = {"int": "i", "bits": "I", "uint": "I", "bool": "I", "date": "i"}
_LONG = {"int": "<q", "time": "<q", "tod": "<q", "dt": "<q", "uint": "<Q", "bits": "<Q", "real": "<d"}


def form(type_: Type) -> str | None:
    """How a value of the type is kept in words, as `struct` says it; None: it is not one."""
    kind = storage(type_)
    if not isinstance(kind, Elementary):
        return None
    if kind.bits > 32:
        return _LONG.get(kind.kind)
    return "<f" if kind.kind == "real" else f"<{_INTEGERS[kind.kind]}"


@record
class Parameter:
    """A VAR_INPUT of a module that steps and messages set. ``address``: in LCD."""

    name: str
    path: str
    type: Type
    form: str
    address: int


@record
class Module:
    """``index``: the offset of its start bit in LCF. ``start``, ``done``: paths, None when it has none."""

    index: int
    name: str
    start: str | None
    done: str | None
    parameters: tuple[Parameter, ...]

    def parameter(self, name: str) -> Parameter | None:
        return next((p for p in self.parameters if p.name.upper() == name.upper()), None)


@record
class Subscriber:
    """``flag``: VAR_INPUT that is TRUE for one execution; None: the module is started. ``data``: VAR_INPUT
    that gets what was broadcast."""

    module: int
    flag: str | None = None
    data: str | None = None


@record
class Message:
    """``number``: of its class, from 0. ``source``: path whose rising edge broadcasts it, None for those of
    the system; ``data``, ``form``: what goes along. ``flag``: bit address in MSGF; ``slot``: byte address in
    MSGD of the word of its state, behind which ``depth`` broadcasts can wait."""

    name: str
    system: bool
    number: int
    source: str | None
    data: str | None
    form: str | None
    policy: str
    depth: int
    subscribers: tuple[Subscriber, ...]
    flag: int = 0
    slot: int = 0

    @property
    def size(self) -> int:
        """Bytes of a broadcast that waits."""
        return calcsize(self.form) if self.form else 0


@record
class Step:
    """Module ``module`` (an index) gets ``parameters`` and is started when ``when`` is TRUE; the step has
    ended when the module has and ``until`` is TRUE. ``name``: of the module."""

    module: int
    name: str
    parameters: tuple[tuple[Parameter, Value], ...] = ()
    when: str | None = None
    until: str | None = None


@record
class Sequence:
    """The customised program. Without ``repeat`` it runs once at each rising edge of ``start``."""

    steps: tuple[Step, ...]
    start: str | None = None
    repeat: bool = True


@record
class Plant:
    """``file``: with the class `Plant`; ``parameters``: a file with its dict in JSON, or None."""

    file: str
    step_ns: int
    parameters: str | None
    seed: int


@record
class Coordination:
    """``messages``: those of the system first, each class in the order of the numbers: the order in which
    they are handled. ``estop``: path of a BOOL that is TRUE in an emergency; ``reset``: of one at whose
    rising edge faults are acknowledged."""

    modules: tuple[Module, ...] = ()
    messages: tuple[Message, ...] = ()
    sequence: Sequence | None = None
    estop: str | None = None
    plant: Plant | None = None
    reset: str | None = None

    def message(self, name: str) -> Message:
        """That of the name. Raises KeyError."""
        for message in self.messages:
            if message.name.upper() == name.upper():
                return message
        raise KeyError(name)


def paths(together: Coordination) -> Iterator[str]:
    """The variables that it names, some of them several times."""
    for module in together.modules:
        yield from (path for path in (module.start, module.done) if path)
        yield from (p.path for p in module.parameters)
    for message in together.messages:
        yield from (path for path in (message.source, message.data) if path)
    sequence = together.sequence
    if sequence is not None:
        conditions = (path for step in sequence.steps for path in (step.when, step.until))
        yield from (path for path in (sequence.start, *conditions) if path)
    yield from (path for path in (together.estop, together.reset) if path)


class Full(Exception):
    """An area has no room; ``number``: of the item that did not fit."""

    def __init__(self, area: Area, number: int) -> None:
        super().__init__(f"{area.name} holds {area.size} bytes")
        self.area, self.number = area, number


def placed_messages(messages: tuple[Message, ...]) -> tuple[Message, ...]:
    """The messages with their flags, and slots one behind the other. Raises Full."""
    flags, data, found = areas()["MSGF"], areas()["MSGD"], []
    at = data.base
    for number, message in enumerate(messages):
        flag = flags.base + message.number + (0 if message.system else USER_FIRST)
        found.append(replace(message, flag=flag, slot=at))
        at += 4 + message.depth * message.size
        if at > data.base + data.size:
            raise Full(data, number)
    return tuple(found)


def placed_modules(modules: tuple[Module, ...]) -> tuple[Module, ...]:
    """The modules with the places of their parameters in LCD, one behind the other. Raises Full."""
    area = areas()["LCD"]
    at = area.base
    found = []
    for module in modules:
        parameters = []
        for parameter in module.parameters:
            parameters.append(replace(parameter, address=at))
            at += calcsize(parameter.form)
        if at > area.base + area.size:
            raise Full(area, module.index)
        found.append(replace(module, parameters=tuple(parameters)))
    return tuple(found)


def system_messages() -> Iterator[Message]:
    """Those of the system, which nobody subscribes to."""
    for number, name in enumerate(SYSTEM_MESSAGES):
        yield Message(name, True, number, None, None, "<I", "queue", 4, ())
