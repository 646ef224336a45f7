"""The state of a virtual machine, taken between two scans and put back: fast to take, since a test of
an online change does that before every scan, and seldom put back (DESIGN section 7)."""

from __future__ import annotations

from collections.abc import Callable
from operator import attrgetter, itemgetter

from ldc.types import is_scalar
from runtime.layout import FIRST_SCAN, NOW, Cell, Layout

_PLAIN = frozenset((bool, int, float, bytes, str))
Kept = tuple[tuple[object, ...], list[object]]


class Keeper:
    """Knows which entries of a namespace are single values, and which are objects to be copied."""

    def __init__(self, layout: Layout) -> None:
        single, others = {NOW, FIRST_SCAN}, set()
        for root in layout.roots():
            scalar = isinstance(root.home, Cell) and is_scalar(root.variable.type)
            (single if scalar else others).add(root.home.name)
        self._single, self._others = tuple(single), tuple(others)
        self._values = itemgetter(*self._single)
        self._flat: dict[type, Callable | None] = {}

    def capture(self, namespace: dict[str, object]) -> Kept:
        """Values and copies of all variables and byte images."""
        return self._values(namespace), [self._frozen(namespace[name]) for name in self._others]

    def put_back(self, namespace: dict[str, object], kept: Kept) -> None:
        """All as it was; objects are new ones, since another machine may use those that are there. Byte
        images stay the same objects: views look into them."""
        values, others = kept
        namespace.update(zip(self._single, values, strict=True))
        for name, value in zip(self._others, others, strict=True):
            if isinstance(value, bytearray):
                namespace[name][:] = value
            else:
                namespace[name] = _thawed(value)

    def _frozen(self, value: object) -> object:
        """A copy; of an object whose members are all single values only these, as (class, values)."""
        kind = type(value)
        if kind not in self._flat:
            self._flat[kind] = _reader(value)
        read = self._flat[kind]
        return duplicate(value) if read is None else (kind, read(value))


def _reader(value: object) -> Callable[[object], tuple] | None:
    """Reads all members of such objects at once, None when some are no single values. Types of members are
    fixed, so that one object tells it for all of its class."""
    slots = getattr(value, "__slots__", ())
    if len(slots) < 2:
        return None
    read = attrgetter(*slots)
    return read if all(type(one) in _PLAIN for one in read(value)) else None


def _thawed(value: object) -> object:
    if not isinstance(value, tuple):
        return duplicate(value)
    kind, members = value
    made = object.__new__(kind)
    for name, one in zip(kind.__slots__, members, strict=True):
        setattr(made, name, one)
    return made


def duplicate(value):
    """A deep copy of one of the machine's values; depth is that of its type."""
    if isinstance(value, list):
        return list(value) if value and type(value[0]) in _PLAIN else [duplicate(v) for v in value]
    if type(value) in _PLAIN:
        return value
    if isinstance(value, bytearray):
        return bytearray(value)
    made = object.__new__(type(value))
    for name in value.__slots__:
        setattr(made, name, duplicate(getattr(value, name)))
    return made
