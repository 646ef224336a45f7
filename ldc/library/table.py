"""The row of the function table, and how a call is matched with it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ldc.library.generic import GENERIC, WORDS, common, is_temporal, kind, widens
from ldc.records import record
from ldc.symbols import Parameter, Signature
from ldc.types import BOOL, ELEMENTARY, INT, LREAL, REAL, STRING, String, Subrange, Type

Meaning = Callable[[tuple[Type, ...], Type], Callable]
# What an untyped literal becomes where the other arguments do not say it.
_DEFAULT = {"ANY_REAL": REAL, "ANY_BIT": BOOL, "ANY_STRING": STRING}
LONGEST = 32_767


@record
class Shape:
    """One way to call a function.

    ``inputs``: per pin a type name, a generic that all pins of that generic share (``ANY_NUM``), or
    one that the pin has for itself (``own ANY_INT``). ``result``: a type name; ``same``: the common
    type of the shared generic; ``sum``: a string as long as all string arguments together;
    ``wide``: the WSTRING (``narrow``: STRING) of the argument's length. ``extends``: the last pin
    may be repeated.
    """

    inputs: tuple[str, ...]
    result: str
    extends: bool = False


@record
class Resolved:
    """A call with its types settled. ``parameters`` are the types that the arguments must have."""

    name: str
    pins: tuple[str, ...]
    parameters: tuple[Type, ...]
    result: Type

    @property
    def signature(self) -> Signature:
        """The same as the signature of a FUNCTION."""
        inputs = tuple(Parameter(n, t) for n, t in zip(self.pins, self.parameters, strict=True))
        return Signature("FUNCTION", self.name, inputs, result=self.result, standard=True)


@record
class Function:
    """A standard function: one row of the table.

    ``names``: formal pin names; of an extensible function the last one ends in the number that is
    counted on. ``meaning`` makes the Python callable for given argument and result types.
    ``mnemonic``: the IL operator of the same meaning, if there is one. ``internal``: made by the
    compiler, not callable by name. ``group``: the table of the standard (2nd edition).
    """

    name: str
    names: tuple[str, ...]
    shapes: tuple[Shape, ...]
    meaning: Meaning
    group: str
    note: str = ""
    mnemonic: str = ""
    internal: bool = False

    @property
    def least(self) -> int:
        """The least number of arguments."""
        return len(self.names)

    @property
    def extensible(self) -> bool:
        return any(shape.extends for shape in self.shapes)

    def pins(self, count: int) -> tuple[str, ...]:
        """The formal names of ``count`` arguments (at least ``least``)."""
        names = self.names[:count]
        stem, last = self.names[-1].rstrip("0123456789"), len(self.names)
        first = int(self.names[-1][len(stem):]) + 1 if count > last else 0
        return names + tuple(f"{stem}{first + n}" for n in range(count - last))

    def position(self, pin: str) -> int | None:
        """Which argument (from 0) a formal name stands for, in any case; None: no such pin."""
        key = pin.upper()
        if key in self.names:
            return self.names.index(key)
        stem = self.names[-1].rstrip("0123456789")
        digits = key[len(stem):]
        if not (self.extensible and key.startswith(stem) and digits.isascii() and digits.isdigit()):
            return None
        if digits[0] == "0" or len(digits) > 4:
            return None
        place = len(self.names) - 1 + int(digits) - int(self.names[-1][len(stem):])
        return place if place >= len(self.names) else None

    def resolve(self, arguments: Sequence[Type | None]) -> Resolved | str:
        """The types of a call; what is wrong, in plain words, when it does not fit."""
        count = len(arguments)
        if count < self.least or (count > self.least and not self.extensible):
            return self._count_error(count)
        errors: list[str] = []
        found = self._matched(arguments, errors)
        if found is not None:
            return found
        if len(self.shapes) > 1 and any(t is not None and is_temporal(t) for t in arguments):
            return self._overload_error(arguments)
        return errors[0]

    def _matched(self, arguments: Sequence[Type | None], errors: list[str]) -> Resolved | None:
        """The types by the first shape that fits; what is wrong with those before is added to ``errors``."""
        pins = self.pins(len(arguments))
        for shape in self.shapes:
            found = _match(self.name, shape, pins, arguments)
            if not isinstance(found, str):
                return Resolved(self.name, pins, *found)
            errors.append(found)
        return None

    def _count_error(self, count: int) -> str:
        least = "at least " if self.extensible else ""
        arguments = "argument" if self.least == 1 else "arguments"
        return f"{self.name} takes {least}{self.least} {arguments} ({', '.join(self.names)}), not {count}"

    def _overload_error(self, arguments: Sequence[Type | None]) -> str:
        given = ", ".join("a literal" if t is None else str(t) for t in arguments)
        ways = [", ".join(i.removeprefix("own ") for i in shape.inputs) for shape in self.shapes]
        if self.name == "MUL" and self._matched(tuple(reversed(arguments)), []) is not None:
            return f"MUL takes the TIME first and the number second, not ({given})"
        return f"{self.name} does not take ({given}); it takes ({'), ('.join(ways)})"


def _match(name, shape: Shape, pins, arguments) -> tuple[tuple[Type, ...], Type] | str:
    if len(arguments) > len(shape.inputs) and not shape.extends:
        return f"{name} takes {len(shape.inputs)} arguments of these types, not {len(arguments)}"
    wanted = shape.inputs + shape.inputs[-1:] * (len(arguments) - len(shape.inputs))
    shared: list[Type] = []
    settled: list[Type | None] = []
    for pin, want, given in zip(pins, wanted, arguments, strict=True):
        own = want.startswith("own ")
        want = want[4:] if own else want
        found = _pin(want, given)
        if isinstance(found, str):
            return f"{name} takes {found} at {pin}, not {given}"
        if own and found is None:
            found = _DEFAULT.get(want, INT)
        elif want in GENERIC and not own and found is not None:
            shared.append(found)
        settled.append(found)
    group = _group(name, wanted, shared)
    if isinstance(group, str):
        return group
    parameters = tuple(_parameter(want, found, group) for want, found in zip(wanted, settled, strict=True))
    return parameters, _result(shape.result, group, parameters)


def _pin(want: str, given: Type | None) -> Type | str | None:
    """The type that one argument brings in (None: the others decide), or the words for what it should be."""
    if want in GENERIC:
        if given is None or kind(given) in GENERIC[want]:
            return given.base if isinstance(given, Subrange) else given
        if want == "ANY_REAL":
            return next((t for t in (REAL, LREAL) if widens(given, t)), WORDS[want])
        return WORDS[want]
    fixed = ELEMENTARY[want]
    if given is None:
        return fixed
    if not widens(given, fixed):
        return f"{'an' if want[0] in 'AEIOU' else 'a'} {want}"
    return given if isinstance(fixed, String) else fixed


def _group(name: str, wanted: Sequence[str], shared: list[Type]) -> Type | str | None:
    """The common type of the shared generic."""
    if not shared:
        generic = next((w for w in wanted if w in GENERIC), None)
        return _DEFAULT.get(generic, INT) if generic else None
    group = common(shared)
    if group is None:
        distinct = list(dict.fromkeys(map(str, shared)))
        return f"{name}: {' and '.join(distinct)} have no common type; convert one of them"
    return group


def _parameter(want: str, found: Type | None, group: Type | None) -> Type:
    if want in GENERIC and (found is None or not isinstance(found, String)):
        return group
    return found


def _result(rule: str, group: Type | None, parameters: tuple[Type, ...]) -> Type:
    match rule:
        case "same":
            return group
        case "sum":
            total = sum(t.length for t in parameters if isinstance(t, String))
            return String(group.name, min(total, LONGEST))
        case "wide":
            return String("WSTRING", parameters[0].length)
        case "narrow":
            return String("STRING", parameters[0].length)
    return ELEMENTARY[rule]
