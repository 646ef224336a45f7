"""Variables, their locations, and the signatures of what can be called."""

from __future__ import annotations

import re

from ldc.patterns import Pattern
from ldc.records import field, record
from ldc.source import Span
from ldc.types import Type, Value

_ADDRESS = Pattern(r"%([IQM])([XBWDL]?)(\d{1,9})(?:\.(\d{1,2}))?\Z", re.IGNORECASE)
WIDTH = {"X": 1, "B": 8, "W": 16, "D": 32, "L": 64}


@record
class Location:
    """A place in the process image: ``area`` I Q M, ``size`` X B W D L, byte and bit address.

    IEC 61131-3 leaves the unit of an address to the implementer: here ``%IWn`` counts words,
    so ``%IW1`` is bytes 2 and 3, and ``%IX1.3`` is bit 3 of byte 1 (ADR 0002).
    ``count``: how many of them an array takes, one behind the other.
    """

    area: str
    size: str
    byte: int
    bit: int = 0
    count: int = field(default=1, compare=False)

    @staticmethod
    def parse(text: str) -> Location | None:
        """``%IX0.0`` ``%QW3`` ``%I0.0``; None when it is no address of this runtime."""
        match = _ADDRESS.match(text)
        if not match:
            return None
        area, size, number, bit = match[1].upper(), match[2].upper() or "X", int(match[3]), match[4]
        if size == "X":
            if bit is None or int(bit) > 7:
                return None
            return Location(area, size, number, int(bit))
        return Location(area, size, number * (WIDTH[size] // 8)) if bit is None else None

    @staticmethod
    def usual(text: str) -> str:
        """The spelling of an address that all spellings of its place have in common; in capitals what is no
        address of this runtime."""
        place = Location.parse(text)
        return text.upper() if place is None else str(place)

    @property
    def bits(self) -> int:
        """Of one element."""
        return WIDTH[self.size]

    @property
    def extent(self) -> int:
        """Bits of all elements."""
        return self.bits * self.count

    def __str__(self) -> str:
        if self.size == "X":
            return f"%{self.area}X{self.byte}.{self.bit}"
        return f"%{self.area}{self.size}{self.byte // (WIDTH[self.size] // 8)}"


@record
class Variable:
    """``kind``: input output in_out local temp external global hidden.

    ``hidden``: memory that the compiler made (edge memories, loop memories), part of the state;
    ``temp``: has no state between two executions of the POU. ``retain``: None for NON_RETAIN, which
    leaves a variable of a function block out of what a RETAIN instance keeps.
    """

    name: str
    type: Type
    kind: str = "local"
    initial: Value | None = None
    retain: bool | None = False
    constant: bool = False
    location: Location | None = None
    span: Span | None = None

    def retained(self, instance: bool) -> bool:
        """Whether a variable of a function block is retained in an instance that is, or is not."""
        return self.retain is not None and (instance or self.retain)


@record
class Parameter:
    """A pin. ``initial`` is what an unconnected input has."""

    name: str
    type: Type
    initial: Value | None = None


OTHER_PINS = {"RESET": "R", "LOAD": "LD", "SET1": "S1", "SET": "S", "RESET1": "R1"}
"""Names that CODESYS and TwinCAT have for pins of standard function blocks, and the standard's."""

ACTION = "ACTION"
"""The kind of what an action is called with."""


@record
class Signature:
    """What a call of a POU takes and gives. ``kind``: FUNCTION_BLOCK FUNCTION PROGRAM, or ACTION.

    ``result`` is the type of a FUNCTION (its pin is called OUT in ladder); ``standard`` tells that
    it comes from the library, not from the project. ``actions``: names of the bodies that may be called
    beside that of the POU; a FUNCTION_BLOCK with such has a last input that tells which one is meant.
    ``written``: what texts call a POU that was declared once more for some instances (VAR_CONFIG), or that
    has the name of a standard one (LD0180). ``order``: inputs and VAR_IN_OUT, in capitals, as they are
    declared, where that is not the inputs first.
    """

    kind: str
    name: str
    inputs: tuple[Parameter, ...] = ()
    outputs: tuple[Parameter, ...] = ()
    in_outs: tuple[Parameter, ...] = ()
    result: Type | None = None
    standard: bool = False
    actions: tuple[str, ...] = ()
    written: str = ""
    order: tuple[str, ...] = ()

    @property
    def positional(self) -> tuple[Parameter, ...]:
        """What values without names go to, in statements (IEC 61131-3, 3rd edition, 6.6.1.4.2)."""
        pins = (*self.inputs, *self.in_outs)
        known = {pin.name.upper(): pin for pin in pins}
        return tuple(known[name] for name in self.order if name in known) if self.order else pins

    def called(self, name: str) -> bool:
        """Whether texts mean this POU by the name."""
        return name.upper() in (self.name.upper(), self.written.upper())

    def pin(self, name: str) -> Parameter | None:
        key = name.upper()
        for group in (self.inputs, self.outputs, self.in_outs):
            for parameter in group:
                if parameter.name.upper() == key:
                    return parameter
        return self.pin(OTHER_PINS[key]) if self.standard and key in OTHER_PINS else None

    def action(self, name: str) -> int:
        """The number of an action, from 1; 0 when there is none of that name."""
        key = name.upper()
        return next((n for n, action in enumerate(self.actions, 1) if action.upper() == key), 0)
