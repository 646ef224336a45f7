"""What differs between controllers: how devices are counted, which there are, what special relays mean."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType

from ldc.records import record

_NAMED = re.compile(r"\b(?:(FX5)\w*|(FX)\w*|[QLR]\d*\w*CPU)\b", re.IGNORECASE)
_HEX_DEVICE = re.compile(r"[XY][0-9A-F]*[A-F][0-9A-F]*\Z|(?:SM|SD|ST|[BW][0-9A-F])\d*\Z|ZR\d")
_MODERN_WORDS = frozenset(("OUTH", "OUTHS", "FF"))


@record
class Family:
    """``name`` for messages. ``radix``: of devices that are not counted in tens. ``most``: the largest number
    of each kind. ``always``: relays of one value; ``first``, ``later``: on in the first scan, off in it;
    ``clocks``: periods in milliseconds; ``late``: whether clocks begin off. ``by_word``: whether the
    instruction chooses the unit of a timer, not its number."""

    name: str
    radix: Mapping[str, int]
    most: Mapping[str, int]
    special: str
    always: Mapping[int, bool]
    first: int
    later: int
    clocks: Mapping[int, int]
    late: bool
    by_word: bool

    def special_relay(self, kind: str, number: int) -> bool:
        """Whether a device belongs to the controller itself."""
        return kind in ("SM", "SD") or self.special == "M" and kind in "MD" and number >= 8000

    def known(self, number: int) -> bool:
        return number in self.always or number in (self.first, self.later) or number in self.clocks


FX = Family(
    "FX", MappingProxyType({"X": 8, "Y": 8}),
    MappingProxyType({"X": 0o17777, "Y": 0o17777, "T": 511, "C": 255, "M": 8511, "S": 4095, "L": 9999,
                      "D": 8511, "V": 7, "Z": 7}),
    "M", MappingProxyType({8000: True, 8001: False}), 8002, 8003,
    MappingProxyType({8011: 10, 8012: 100, 8013: 1000, 8014: 60_000}), False, False)
_MODERN = {"T": 32_767, "ST": 32_767, "C": 32_767, "M": 61_439, "S": 16_383, "L": 32_767, "F": 32_767,
           "B": 0x7FFF, "W": 0x7FFFF, "D": 4_184_063, "R": 32_767, "ZR": 4_184_063, "Z": 31, "SM": 4095,
           "SD": 4095}
_RELAYS = {400: True, 401: False}
_PERIODS = {409: 10, 410: 100, 411: 200, 412: 1000, 413: 2000}
Q = Family(
    "Q", MappingProxyType({"X": 16, "Y": 16, "B": 16, "W": 16}),
    MappingProxyType({"X": 0x1FFF, "Y": 0x1FFF, **_MODERN}), "SM", MappingProxyType(_RELAYS), 402, 403,
    MappingProxyType(_PERIODS), True, True)
FX5 = Family(
    "FX5", MappingProxyType({"X": 8, "Y": 8, "B": 16, "W": 16}),
    MappingProxyType({"X": 0o1777, "Y": 0o1777, **_MODERN}), "SM", MappingProxyType(_RELAYS), 402, 403,
    MappingProxyType(_PERIODS), True, True)


def family_of(named: Iterable[str], words: Iterable[str], operands: Iterable[str]) -> Family:
    """The controller that ``named`` (what a table or comments say) tells; else Q where an instruction or
    device occurs that FX does not have, and FX."""
    for text in named:
        match = _NAMED.search(text)
        if match is not None:
            return FX5 if match[1] else FX if match[2] else Q
    if any(word in _MODERN_WORDS for word in words) or any(_HEX_DEVICE.match(text) for text in operands):
        return Q
    return FX
