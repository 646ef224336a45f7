"""Expressions and places of IL as C text."""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.backends.c import functions
from ldc.backends.c.ctypes import by_address, is_string, literal, string_bytes, suffix
from ldc.backends.c.places import Address, Names
from ldc.expr import Apply, Const, Expr, Load, Place
from ldc.il.c_types import c_type
from ldc.il.structure import Structured
from ldc.records import record


@record
class Callee:
    """How generated code calls a POU: its C function, its prototype or (of the library) whole text, and
    whether a call can end in a fault."""

    name: str
    declaration: str
    faults: bool


@dataclass(slots=True)
class Shared:
    """What the functions of one file need before them: names of places, constants, callees, each in the
    order of its first use. ``named`` False: places are written out, for text that several files have."""

    named: bool = True
    places: dict[str, str] = field(default_factory=dict)
    constants: dict[bytes, str] = field(default_factory=dict)
    callees: dict[str, str] = field(default_factory=dict)

    def place(self, at: Address) -> str:
        """The name of a scalar in memory."""
        meaning = f"LDC_AT({c_type(at.type)}, {at.base}, {at.offset})"
        if not self.named:
            return meaning
        name, number = at.name, 1
        while self.places.setdefault(name, meaning) != meaning:
            number += 1
            name = f"{at.name}__v{number}"
        return name

    def constant(self, value: bytes) -> str:
        """The name of a constant string."""
        return self.constants.setdefault(value, f"k_{len(self.constants) + 1}")

    def call(self, callee: Callee) -> str:
        """The name of a function that is called."""
        self.callees.setdefault(callee.name, callee.declaration)
        return callee.name


@dataclass(slots=True)
class Values:
    """Writes the expressions of one C function. ``first``: the rung that places of faults count from."""

    names: Names
    code: Structured
    shared: Shared
    first: int
    lines: list[str] = field(default_factory=list)
    declared: dict[str, str] = field(default_factory=dict)
    at: int = 0
    _temporaries: int = 0
    _texts: dict[tuple[str, bool], str] = field(default_factory=dict)

    def where(self) -> str:
        """The arguments that tell a function of faults where it was."""
        rung, index = self.code.flat.places[self.at]
        return f"m, {rung - self.first}, {index}"

    def fresh(self, type_name: str) -> str:
        """A C variable of its own."""
        self._temporaries += 1
        name = f"i_{self._temporaries}"
        self.declared[name] = f"{type_name} {name};"
        return name

    def expr(self, expr: Expr) -> str:
        """A pure expression; of strings, arrays and structures the address."""
        match expr:
            case Const():
                return self.shared.constant(string_bytes(expr)) if is_string(expr.type) else literal(expr)
            case Load(place):
                if place.steps:
                    return self.read(self.names.reach(place).address)
                # Most operands are plain variables, used again and again.
                known = place.root, place.is_global
                text = self._texts.get(known)
                if text is None:
                    text = self._texts[known] = self.read(self.names.reach(place).address)
                return text
            case Apply(op, args):
                return functions.scalar(op, [(self.expr(a), a.type) for a in args], expr.type)
        raise TypeError(expr)

    # ---- places; ``more`` is what computed indexes add: to the offset, of image bits to the bit

    def checked(self, place: Place) -> tuple[Address, str]:
        """The address of a place; its computed indexes are evaluated and checked now, in order."""
        reach = self.names.reach(place)
        terms = []
        for index in reach.indexes:
            for operand, (low, high), stride in zip(
                    index.step.indexes, index.step.bounds, index.strides, strict=True):
                name = self.fresh("int64_t")
                self.lines.append(f"{name} = (int64_t){self._operand(operand)};")
                kind = "LDC_INDEX_UNSIGNED" if suffix(operand.type) == "u64" else "LDC_INDEX"
                self.lines.append(f"if (LDC_RARE({name} < {low} || {name} > {high})) "
                                  f"return ldc_index({self.where()}, {kind}, {name}, {low}, {high});")
                terms.append(f" + ({name} - ({low})) * {stride * index.size}")
        return reach.address, "".join(terms)

    def _operand(self, operand: Expr) -> str:
        """An index: a constant or a variable, which may itself be an element."""
        if isinstance(operand, Const):
            return literal(operand)
        return self.read(*self.checked(operand.place))

    def read(self, at: Address, more: str = "") -> str:
        """The value of a place."""
        if at.bit is not None:
            if more:
                return f"ldc_bit({at.base} + {at.offset}, {at.bit}{more})"
            return f"(LDC_AT(uint8_t, {at.base}, {at.offset}) >> {at.bit} & 1)"
        whole = self.whole(at, more)
        return whole if at.part is None else f"({whole} >> {at.part} & 1)"

    def whole(self, at: Address, more: str) -> str:
        """The variable, or the bit string that a bit is part of; of strings and so on the address."""
        type_ = at.whole or at.type
        if at.base.startswith("t_"):
            self._declare(at.base)
        if at.local:
            return at.base
        if by_address(type_):
            return f"({at.base} + {at.offset}{more})"
        if more or at.part is not None:
            return f"LDC_AT({c_type(type_)}, {at.base}, {at.offset}{more})"
        return self.shared.place(at)

    def _declare(self, name: str) -> None:
        if name in self.declared:
            return
        type_ = self.names.type_of(name)
        self.declared[name] = f"{c_type(type_)} {name};" if not by_address(type_) else (
            f"uint8_t {name}[{max(self.names.block.measure(type_), 1)}] __attribute__((aligned(8)));")
