"""Variables of IL as C: where each lies, and the names that a chunk gives them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from ldc.backends.c.ctypes import by_address
from ldc.expr import BitStep, Const, FieldStep, IndexStep, Place, strides
from ldc.il.block import Block
from ldc.il.homes import INTRINSIC
from ldc.il.program import Unit
from ldc.records import record
from ldc.symbols import Variable
from ldc.types import BOOL, TIME, Instance, Type

_NOW, _FIRST_SCAN = 0, 16


@record
class Address:
    """A place: ``base`` (m memory, s instance, f frame, or a C array) plus ``offset`` bytes; or the C
    variable ``local``. ``bit``: it is that bit (and those behind) of the byte image at ``offset``;
    ``part``: one bit of the bit string of type ``whole`` there. ``name``: what to call it."""

    base: str
    offset: int
    type: Type
    name: str
    bit: int | None = None
    part: int | None = None
    whole: Type | None = None
    local: bool = False


@record
class Index:
    """A step that is computed: ``indexes`` with bounds and how many elements one of each is; an element
    has ``size`` bytes (bits of the byte image where the address is of one)."""

    step: IndexStep
    strides: tuple[int, ...]
    size: int


@record
class Reach:
    """An address and, in order, the computed indexes on the way to it."""

    address: Address
    indexes: tuple[Index, ...] = ()


def c_name(name: str) -> str:
    """An IEC name or path as a part of a C identifier."""
    if name.isascii() and name.isidentifier():
        return name
    return "".join(c if c.isascii() and c.isalnum() or c == "_" else f"x{ord(c):x}_" for c in name)


@dataclass(slots=True)
class Names:
    """The variables that one unit sees. ``run``: the instance when it is a PROGRAM; ``frame``: offsets of
    what lives in the frame of an execution; ``locals``: names of C variables."""

    block: Block
    unit: Unit
    run: str | None
    temporaries: tuple[Variable, ...] = ()
    frame: Mapping[str, int] = field(default_factory=dict)
    _variables: dict[str, Variable] = field(init=False)
    _roots: dict[tuple[str, bool], Address] = field(init=False, default_factory=dict)
    _reaches: dict[Place, Reach] = field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        self._variables = {v.name.upper(): v for v in (*self.unit.variables, *self.temporaries)}

    def type_of(self, name: str) -> Type:
        """The type of the variable of a C local (``t_name``)."""
        return self._variables[name[2:].upper()].type

    def reach(self, place: Place) -> Reach:
        """Where a place lies."""
        found = self._reaches.get(place)
        if found is None:
            found = self._reaches[place] = self._walk(place)
        return found

    def _walk(self, place: Place) -> Reach:
        at = self._root(place)
        offset, type_, name, bit, part, whole = at.offset, at.type, at.name, at.bit, None, None
        computed = []
        for step in place.steps:
            match step:
                case FieldStep(member):
                    inner, type_ = self.block.member(type_, member)
                    offset, name = offset + inner, f"{name}__{c_name(member)}"
                case BitStep(number):
                    part, whole, type_ = number, type_, BOOL
                case IndexStep():
                    element = type_.element
                    size = 1 if bit is not None else self.block.measure(element)
                    counts = strides(step.bounds)
                    constant = _constant(step, counts)
                    if constant is None:
                        computed.append(Index(step, tuple(counts), size))
                        name += "__at"
                    elif bit is None:
                        offset, name = offset + constant * size, f"{name}__{constant}"
                    else:
                        bit, name = bit + constant, f"{name}__{constant}"
                    type_ = element
        if bit is not None and not computed:
            offset, bit = offset + bit // 8, bit % 8
        return Reach(Address(at.base, offset, type_, name, bit, part, whole, at.local), tuple(computed))

    def _root(self, place: Place) -> Address:
        key = place.root, place.is_global
        found = self._roots.get(key)
        if found is None:
            found = self._roots[key] = self._find(place.root, place.is_global)
        return found

    def _find(self, root: str, is_global: bool) -> Address:
        upper, name = root.upper(), c_name(root)
        if is_global or self._variables[upper].kind == "external":
            if upper in INTRINSIC:
                now = upper == "%NOW"
                return (Address("m", _NOW, TIME, "now") if now
                        else Address("m", _FIRST_SCAN, BOOL, "first_scan"))
            if root[0] == "%":
                spot, name = self.block.direct(root), "a_" + c_name(root[1:].replace(".", "_"))
            else:
                variable = self.block.shared[upper]
                spot, name = self.block.variable(variable.name, variable), f"g_{name}"
            return Address("m", spot.offset, spot.type, name, spot.bit)
        variable = self._variables[upper]
        if upper in self.frame:
            return Address("f", self.frame[upper], variable.type, f"f_{name}")
        if variable.kind == "temp":
            local = f"t_{name}"
            return Address(local, 0, variable.type, local, local=not by_address(variable.type))
        if self.run is None:
            offset, type_ = self.block.member(Instance(self.unit.name.upper()), upper)
            return Address("s", offset, type_, f"s_{name}")
        spot = self.block.variable(f"{self.run}.{variable.name}", variable)
        return Address("m", spot.offset, spot.type, f"v_{name}", spot.bit)


def _constant(step: IndexStep, counts: list[int]) -> int | None:
    """The number of the element when all indexes are constants within the bounds."""
    total = 0
    for index, (low, high), stride in zip(step.indexes, step.bounds, counts, strict=True):
        if not isinstance(index, Const) or not low <= index.value <= high:
            return None
        total += (index.value - low) * stride
    return total
