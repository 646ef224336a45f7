"""How modules work together as bytes: it travels beside the image of a program that is changed online.

Types are left out: they are those of the variables that paths name, in the program that it belongs to.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import msgspec

from ldc.il.coordination import Coordination, Message, Module, Parameter, Sequence, Step, Subscriber
from ldc.types import Type

TypeOf = Callable[[str], Type]
"""The type of the variable at a path. Raises LookupError."""


def pack(together: Coordination) -> bytes:
    """All but the plant, which belongs to the runtime and not to the program."""
    sequence = together.sequence
    return msgspec.msgpack.encode([
        [[m.index, m.name, m.start, m.done, [_parameter(p) for p in m.parameters]] for m in together.modules],
        [[m.name, m.system, m.number, m.source, m.data, m.form, m.policy, m.depth,
          [[s.module, s.flag, s.data] for s in m.subscribers], m.flag, m.slot] for m in together.messages],
        None if sequence is None else [
            [[s.module, s.name, [[_parameter(p), value] for p, value in s.parameters], s.when, s.until]
             for s in sequence.steps], sequence.start, sequence.repeat],
        together.estop, together.reset])


def _parameter(p: Parameter) -> list:
    return [p.name, p.path, p.form, p.address]


def unpack(data: bytes, type_of: TypeOf) -> Coordination:
    """What ``pack`` made. Raises ValueError, TypeError and LookupError for anything else."""
    modules, messages, sequence, estop, reset = msgspec.msgpack.decode(data)

    def parameter(row: list[Any]) -> Parameter:
        name, path, form, address = row
        return Parameter(name, path, type_of(path), form, address)

    def message(row: list[Any]) -> Message:
        *head, subscribers, flag, slot = row
        return Message(*head, tuple(Subscriber(*s) for s in subscribers), flag, slot)

    return Coordination(
        tuple(Module(index, name, start, done, tuple(map(parameter, given)))
              for index, name, start, done, given in modules),
        tuple(map(message, messages)),
        None if sequence is None else Sequence(
            tuple(Step(module, name, tuple((parameter(p), value) for p, value in given), when, until)
                  for module, name, given, when, until in sequence[0]), sequence[1], sequence[2]),
        estop, None, reset)
