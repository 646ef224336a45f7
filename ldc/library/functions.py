"""The standard functions of IEC 61131-3 as one table: what they are called with and what they mean.

    lookup("max")                         the row, or None; ADD_INT and so on are ADD in one type
    resolve("ADD", (INT, None))           types of a call (None: an untyped literal), or what is wrong
    meaning("ADD", (INT, INT), INT)       a callable on Python values (ldc.types says which)
    widens, common, conversion            implicit conversions
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

from ldc.library import bits, numeric, selection, strings, time
from ldc.library import conversion as _conversion
from ldc.library.generic import common, conversion, is_temporal, kind, short_name, widens
from ldc.library.table import Function, Resolved
from ldc.records import replace
from ldc.types import INT, Type, storage

__all__ = ["TABLE", "Function", "Resolved", "common", "conversion", "is_function", "is_temporal", "kind",
           "lookup", "meaning", "names", "pins", "resolve", "typed", "widens"]

TABLE: dict[str, Function] = {
    row.name: row for group in (_conversion, numeric, bits, selection, strings, time)
    for row in group.FUNCTIONS
}
_LONG = (("DATE_AND_TIME", "DT"), ("TIME_OF_DAY", "TOD"))
_OVERLOADED = frozenset(row.name for group in (numeric, bits, selection) for row in group.FUNCTIONS
                        if not row.internal and row.name != "TRUNC")
_TARGETS = {f"TO_{name}": type_ for type_ in _conversion.TYPES for name in (type_.name, short_name(type_))}


@lru_cache(maxsize=4096)
def lookup(name: str) -> Function | None:
    """The row of a function by name in any case; long and 3rd-edition spellings are understood.

    None when there is no such function, and for the overloaded ``TO_INT`` and so on, which are no
    rows: ``resolve`` gives them the name of the conversion that they stand for.
    """
    key = name.upper()
    for long, short in _LONG:
        key = key.replace(long, short)
    row = TABLE.get(time.ALIASES.get(key, key))
    if row is None and (one := typed(key)) is not None:
        return replace(TABLE[one[0]], name=key)
    return row


def typed(name: str) -> tuple[str, Type] | None:
    """What a typed function is (2nd edition, 2.5.1.4): of ``ADD_INT`` ADD and INT; None of all others."""
    function, mark, type_ = name.upper().rpartition("_")
    if not mark or function not in _OVERLOADED or name.upper() in TABLE:
        return None
    target = _TARGETS.get(f"TO_{type_}")
    return None if target is None else (function, target)


def names() -> tuple[str, ...]:
    """All names that a user may call, in the order of the standard's tables."""
    return tuple(n for n, row in TABLE.items() if not row.internal) + tuple(time.ALIASES) + tuple(_TARGETS)


def is_function(name: str) -> bool:
    """Whether a user may call a standard function of this name (any case)."""
    row = lookup(name)
    return not row.internal if row else name.upper() in _TARGETS


def pins(name: str, count: int) -> tuple[str, ...] | None:
    """The formal pin names of a call with ``count`` arguments; None when there is no such function."""
    row = lookup(name)
    if row:
        return row.pins(count)
    return ("IN",) if name.upper() in _TARGETS else None


def resolve(name: str, arg_types: Sequence[Type | None]) -> Resolved | str:
    """The types of a call with arguments of ``arg_types``.

    None stands for an untyped literal; it takes the type that the other arguments ask for, else
    the usual one (INT, REAL, BOOL or STRING by the function). A caller whose literal does not fit
    the parameter that it got may ask again with the literal's own type. ``Resolved.name`` is the
    canonical name. The error text names the function, the pin and the types, without a full stop.
    """
    return _resolve(name.upper(), tuple(arg_types))


@lru_cache(maxsize=4096)
def _resolve(name: str, arg_types: tuple[Type | None, ...]) -> Resolved | str:
    if (one := typed(name)) is not None:
        return _in_one_type(name, TABLE[one[0]], one[1], arg_types)
    row = lookup(name)
    if row:
        return row.resolve(arg_types)
    if name not in _TARGETS:
        return f"there is no standard function {name}"
    if len(arg_types) != 1:
        return f"{name} takes 1 argument (IN), not {len(arg_types)}"
    source, target = arg_types[0] or INT, _TARGETS[name]
    row = kind(source) != "aggregate" and TABLE.get(conversion(source, target))
    return row.resolve((source,)) if row else f"{name} does not take {source}"


def _in_one_type(
    name: str, row: Function, type_: Type, arg_types: tuple[Type | None, ...]
) -> Resolved | str:
    """A call of a typed function: what may be of its type is, literals too; a selector and the like are
    not."""
    known = tuple(type_ if t is not None and widens(t, type_) else t for t in arg_types)
    for given in (tuple(type_ if t is None else t for t in known), known):
        found = row.resolve(given)
        if not isinstance(found, str) and type_ in found.parameters:
            return found
    return found if isinstance(found, str) else f"{name} takes {type_}, not {found.parameters[-1]}"


@lru_cache(maxsize=4096)
def meaning(op: str, arg_types: tuple[Type, ...], result: Type) -> Callable:
    """The function on Python values for parameters of exactly ``arg_types`` (as ``resolve`` gave them).

    The values are those of ldc.types: bool, int, float, bytes, str; TIME in nanoseconds. Raises
    ``faults.DivisionByZero`` when called, for DIV and MOD; KeyError when ``op`` is no function.
    """
    stored = tuple(map(storage, arg_types))
    row = lookup(op)
    if row is None and op.upper() in _TARGETS:
        row = TABLE[conversion(arg_types[0], _TARGETS[op.upper()])]
    if row is None:
        raise KeyError(op)
    return row.meaning(stored, storage(result))

