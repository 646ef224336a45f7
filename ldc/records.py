"""Records: what frozen dataclasses with slots are, made sooner and filled faster.

`dataclass(frozen=True, slots=True)` compiles six methods of every class from text, which took half of the
time in which `ldc` starts, and an object of it is filled by a function in Python: a compile makes hundreds of
thousands. Structs of msgspec are made and filled in C, in a quarter of the time.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from operator import attrgetter
from typing import Any, TypeVar, dataclass_transform

import msgspec
from msgspec import Struct
from msgspec.structs import replace

__all__ = ["entity", "field", "is_record", "record", "replace"]

_Class = TypeVar("_Class", bound=type)
_PLAIN = ("__dict__", "__weakref__")
"""What a class without slots has of its own."""
_NOTHING: Any = msgspec.NODEFAULT


class _Field:
    """What `field` says of one field."""

    __slots__ = ("default", "made", "compare", "repr")

    def __init__(self, default: object, made: object, compare: bool, repr: bool) -> None:
        self.default, self.made, self.compare, self.repr = default, made, compare, repr


def field(*, default: Any = _NOTHING, default_factory: Any = _NOTHING, compare: bool = True,
          repr: bool = True) -> Any:
    """A field of a record or an entity, with these words of `dataclasses.field`."""
    return _Field(default, default_factory, compare, repr)


@dataclass_transform(frozen_default=True, field_specifiers=(field,))
def record(cls: _Class) -> _Class:
    """The class as `dataclass(frozen=True, slots=True)` makes it: `replace`, patterns and the `fields` of the
    standard library know it, equality, hash and representation are by fields, and an object never changes.

    A class with a base is none of its own, and all that it annotates are fields, each plain or a `field` of
    this module (one of the standard library says the same). A `cached_property` is kept beside the fields.
    """
    return _made(cls, frozen=True)


@dataclass_transform(eq_default=False, field_specifiers=(field,))
def entity(cls: _Class) -> _Class:
    """The class as `dataclass(slots=True, eq=False)` makes it: fields may change, and an object is equal to
    itself alone. Of fields and bases it knows what a record knows."""
    return _made(cls, eq=False)


def is_record(thing: object) -> bool:
    """Whether something is a record or an entity: its fields are its `__match_args__`."""
    return isinstance(thing, Struct)


def _made(cls: _Class, **settings: bool) -> _Class:
    own = cls.__dict__
    names = tuple(own.get("__annotations__", ()))
    body = {name: value for name, value in own.items() if name not in _PLAIN}
    said = {name: value for name in names if (value := _said(own.get(name))) is not None}
    for name, value in said.items():
        body[name] = msgspec.field(default=value.default, default_factory=value.made)
    compared = [name for name in names if name not in said or said[name].compare]
    if len(compared) < len(names) or "__eq__" in own:
        values = attrgetter("__class__", *compared)
        body.setdefault("__eq__", _equality(values))
        if own.get("__hash__") is None:  # None: a class that says what is equal
            body["__hash__"] = lambda self: hash(values(self))
    if any(not value.repr for value in said.values()):
        body.setdefault("__repr__", _shown([name for name in names if name not in said or said[name].repr]))
    if any(type(value) is cached_property for value in own.values()):
        settings["dict"] = True
    body |= {"__qualname__": cls.__qualname__, "__match_args__": names,
             "__dataclass_fields__": _Fields(cls, said)}
    return type(Struct)(cls.__name__, (Struct,), body, **settings)


def _said(value: object) -> _Field | None:
    """What a field says of itself, None for one that is no more than a default."""
    if type(value).__module__ != "dataclasses":
        return value if type(value) is _Field else None
    from dataclasses import MISSING  # loads `inspect`, which is slow; whoever made the field has it

    default, made = (_NOTHING if one is MISSING else one for one in (value.default, value.default_factory))
    return _Field(default, made, value.compare, value.repr)


def _equality(values: Callable[[object], tuple]) -> Callable[[object, object], bool]:
    def equal(self: object, other: object) -> bool:
        return values(self) == values(other) if other.__class__ is self.__class__ else NotImplemented

    return equal


def _shown(names: list[str]) -> Callable[[object], str]:
    def shown(self: object) -> str:
        return f"{self.__class__.__name__}({', '.join([f'{n}={getattr(self, n)!r}' for n in names])})"

    return shown


class _Fields:
    """The fields as the standard library describes them, made for the few classes of which somebody asks."""

    def __init__(self, plain: type, said: dict[str, _Field]) -> None:
        self.plain, self.said = plain, said

    def __get__(self, instance: object, made: type) -> dict[str, object]:
        import dataclasses  # loads `inspect`, which is slow

        for name, value in self.said.items():
            given = {"default": value.default, "default_factory": value.made}
            given = {word: one for word, one in given.items() if one is not _NOTHING}
            setattr(self.plain, name, dataclasses.field(compare=value.compare, repr=value.repr, **given))
        found = dataclasses.dataclass(init=False, repr=False, eq=False)(self.plain).__dataclass_fields__
        made.__dataclass_fields__ = found
        return found
