"""What is in a contact, a coil, a rail or a declared variable as nearly all editors write it: found by one
expression.

A file is mostly these, and a tree of their parts would be most of the work of reading it. What is written
in another way is read as a tree.
"""

from __future__ import annotations

import re

from ldc.patterns import Pattern

_WIRES = r"""(?>(?:<connection[ ][^<>]*+
    (?:(?<=/)>|>\s*+(?>(?:<position[ ][^<>]*+(?<=/)>\s*+)*)</connection>)\s*+)*)"""
_POINT = r"""<connectionPoint{side}(?:[ /][^<>]*+)?(?:(?<=/)>|>\s*+(?:<relPosition[ ][^<>]*+(?<=/)>\s*+)?
    {wires}</connectionPoint{side}>)\s*+"""
_PLACE = r"\s*+(?:<position[ ]([^<>]*+)(?<=/)>\s*+)?"
_OUT = f"(?>(?:{_POINT.format(side='Out', wires='')})*)"
_ELEMENT = Pattern(
    rf"{_PLACE}(?:{_POINT.format(side='In', wires=f'({_WIRES})')})?{_OUT}"
    r"(?:<variable>([^<>&]*+)</variable>\s*+)?</(contact|coil)>", re.VERBOSE)
_RAIL = Pattern(
    rf"{_PLACE}()(?>(?:{_POINT.format(side='In', wires=_WIRES)})*){_OUT}()</(leftPowerRail|rightPowerRail)>",
    re.VERBOSE)
_DECLARED = Pattern(
    r"""()()((?!))?\s*+<type>\s*+(?:<derived[ ]name="(?P<derived>[A-Za-z_]\w*+)"/>|(?P<elementary><[A-Z]++/>))
        \s*+</type>\s*+</(variable)>""", re.VERBOSE | re.ASCII)
PLACE, WIRES, WORDS = 1, 2, 3
"""The groups: attributes of the position, the wires to the one input, the variable; the last is the tag that
ends. A declared variable has none of the three, but a `derived` name or an `elementary` type."""

TAGS = ("contact", "coil", "leftPowerRail", "rightPowerRail", "variable")
_OF_TAG = dict(zip(TAGS, (_ELEMENT, _ELEMENT, _RAIL, _RAIL, _DECLARED)))


def inside(tag: str, text: str, start: int, end: int) -> re.Match[str] | None:
    """All that follows the start tag of an element, up to its end tag; None when it is not the usual."""
    pattern = _OF_TAG.get(tag)
    found = pattern.match(text, start, end) if pattern is not None else None
    return found if found is not None and found[found.lastindex] == tag else None
