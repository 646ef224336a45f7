"""What generated code calls: library meanings, POUs, copiers and makers, under names of the namespace."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial, reduce

from ldc.expr import Const
from ldc.il.program import COMPARISON, LOGIC, Unit
from ldc.library import functions
from ldc.types import BOOL, REAL, Elementary, Enum, Subrange, Type, Value, storage
from runtime.layout import slot
from runtime.vm import expression as ex
from runtime.vm.arithmetic import bad_index, divide, make_f32, modulo
from runtime.vm.expression import Expression
from runtime.vm.memory import Memory

_INTEGERS = ("int", "uint", "bits")
SELECTIONS = ("MIN", "MAX", "LIMIT")


class Calls:
    """Collects in ``names`` everything beside variables that the generated code of one machine refers to."""

    def __init__(self, memory: Memory) -> None:
        self._memory = memory
        self._units = memory.layout.units
        self._known: dict[object, str] = {}
        self._meanings: dict[tuple, Callable] = {}
        self.f32 = make_f32()
        self.names: dict[str, object] = {
            "_f32": self.f32, "_div": divide, "_mod": modulo, "_bad_index": bad_index,
            "_inf": float("inf"), "_nan": float("nan")}

    def _named(self, key: object, prefix: str, make: Callable[[], object]) -> str:
        name = self._known.get(key)
        if name is None:
            name = self._known[key] = f"_{prefix}{len(self._known)}"
            self.names[name] = make()
        return name

    def copier(self, type_: Type) -> str:
        """A function that copies an array or structure deeply."""
        return self._named(("copy", type_), "copy", lambda: self._memory.copier(type_))

    def maker(self, type_: Type, initial: Value | None) -> str:
        """A function without arguments that makes an initial value."""
        key = ("make", type_, initial)
        return self._named(key, "make", lambda: partial(self._memory.fresh, type_, initial))

    def block(self, pou: str) -> str:
        """The function that runs a function block on an instance."""
        return f"do_{slot(pou)}"

    def function(self, name: str) -> Unit | None:
        """The FUNCTION of the project of that name; None for one of the library."""
        unit = self._units.get(name.upper())
        return unit if unit is not None and unit.kind == "FUNCTION" else None

    def native(self, unit: Unit) -> str:
        """The function that runs a unit's native code on an instance."""
        return f"native_{slot(unit.name)}"

    def user(self, unit: Unit) -> str:
        return f"fn_{slot(unit.name)}"

    def ignores_accumulator(self, name: str) -> bool:
        """Whether FN of that name does not take the accumulator: a FUNCTION without inputs."""
        unit = self.function(name)
        return unit is not None and not unit.arguments

    def rounded(self, constant: Const):
        """The value of a constant, a REAL rounded to 32 bit."""
        return self.f32(constant.value) if storage(constant.type) == REAL else constant.value

    def meaning_of(self, op: str, arg_types: tuple[Type, ...], result: Type) -> Callable:
        """The library's meaning of a function on values of these types."""
        key = (op, arg_types, result)
        found = self._meanings.get(key)
        if found is None:
            found = functions.meaning(op, tuple(plain(t) for t in arg_types), plain(result))
            self._meanings[key] = found
        return found

    def meaning(self, op: str, arg_types: tuple[Type, ...], result: Type) -> str:
        """The name under which generated code calls ``meaning_of``."""
        return self._named((op, arg_types, result), "m", lambda: self.meaning_of(op, arg_types, result))

    def inline(self, name: str, args: list[Expression], result: Type) -> Expression | None:
        """A function as an expression when that is simple and free of faults, else None."""
        if name == "MOVE":
            return args[0]
        if name == "NOT":
            return ex.invert(args[0])
        if name in LOGIC:
            return reduce(partial(ex.logic, name), args)
        if name in COMPARISON and len(args) == 2:
            return ex.compare(name, *args)
        if name == "SEL" and len(args) == 3:
            (g, dg), (a, da), (b, db) = (ex.within(x, ex.OR) for x in args)
            return Expression(f"({b} if {g} else {a})", result, ex.ATOM,
                              args[0].reads | args[1].reads | args[2].reads, max(dg, da, db) + 1)
        if name in SELECTIONS and len(args) > 1 and all(is_integral(a.type) for a in args):
            return _select(name, args, result)
        if "_TO_" in name and "BCD" not in name and len(args) == 1:
            return _convert(args[0], plain(args[0].type), plain(result))
        return None


def plain(type_: Type) -> Type:
    """Subranges and enumerations as the elementary types that they are stored as."""
    return storage(type_) if isinstance(type_, Subrange | Enum) else type_


def is_integral(type_: Type) -> bool:
    """Whether values of the type are numbers that Python compares as ints: integers, bit strings, TIME."""
    kind = storage(type_)
    return isinstance(kind, Elementary) and kind.kind in (*_INTEGERS, "time")


def _select(name: str, args: list[Expression], result: Type) -> Expression | None:
    """MIN, MAX and LIMIT of two or three values that cost nothing to be read twice."""
    if name == "LIMIT":
        low, value, high = (a.text for a in args)
        text = f"({high} if {value} > {high} or {low} > {high} else {low} if {value} < {low} else {value})"
    elif len(args) == 2:
        sign = "<=" if name == "MIN" else ">="
        first, second = args[0].text, args[1].text
        text = f"({first} if {first} {sign} {second} else {second})"
    else:
        return None
    return Expression(text, result, ex.ATOM, frozenset().union(*(a.reads for a in args)), 1)


def _convert(value: Expression, source: Type, target: Type) -> Expression | None:
    """Conversions between integers, from small integers to reals, and between BOOL and integers."""
    if not isinstance(source, Elementary) or not isinstance(target, Elementary):
        return None
    if target.kind in _INTEGERS:
        if source == BOOL:
            text, depth = ex.within(value, ex.UNARY)
            return Expression(f"+{text}", target, ex.UNARY, value.reads, depth)
        if source.kind in _INTEGERS:
            (low, high), (least, most) = source.range, target.range
            fits = least <= low and high <= most
            return Expression(value.text, target, value.level, value.reads, value.depth, not fits)
    if target == BOOL and source.kind in _INTEGERS:
        return ex.compare("NE", value, ex.constant(0, source))
    if target.kind == "real" and source.kind in ("int", "uint") and source.bits <= target.bits // 2:
        return ex.binary(value, "+", ex.constant(0.0, target), ex.SUM, target)
    if (source.name, target.name) == ("REAL", "LREAL"):
        return Expression(value.text, target, value.level, value.reads, value.depth)
    return None
