"""Functions that Logix instructions are written in, where IEC 61131-3 has none that does the same.

They are Structured Text in ``blocks/*.st``, templates with ``{T}`` and the like for types; each that a
file needs is added to its POUs once per type. All memory is in the tags, as in the controller.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from ldc.parser import ast
from ldc.parser.foreign import Names, supporting

_FOLDER = Path(__file__).with_name("blocks")
_HEAD = re.compile(r"^FUNCTION (\w+)", re.MULTILINE)
_GAP = re.compile(r"\{(\w+)\}")
_END = "END_FUNCTION"


@cache
def templates() -> dict[str, str]:
    """Every template by its name."""
    found = {}
    for path in sorted(_FOLDER.glob("*.st")):
        for part in path.read_text(encoding="ascii").split(_END)[:-1]:
            text = part[part.index("FUNCTION ") :] + _END + "\n"
            found[_HEAD.match(text)[1]] = text
    return found


class Support:
    """The functions that one file uses. ``clock``: the global that some of them read the time in, and the TON
    that gives it."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self.used: dict[tuple, tuple[str, str]] = {}
        self.clock: tuple[str, str] | None = None

    def use(self, template: str, **types: str) -> str:
        """The name of the function for these types (texts of types, bounds)."""
        key = (template, *types.items())
        if key not in self.used:
            words = [part for name, part in types.items() if name in ("T", "N")]
            name = self.names.fresh("_".join([template, *(_word(part) for part in words)]))
            if "{CLOCK}" in templates()[template] and self.clock is None:
                self.clock = self.names.fresh("logix_time"), self.names.fresh("logix_clock")
            gaps = types | {"CLOCK": self.clock[0] if self.clock else ""}
            body = _GAP.sub(lambda m: gaps[m[1]], templates()[template])
            self.used[key] = name, re.sub(rf"\b{template}\b", name, body)
        return self.used[key][0]

    def pous(self) -> tuple[ast.Pou, ...]:
        """All that were used, in the order of their first use."""
        text = "\n".join(text for _, text in self.used.values())
        return supporting(text, "logix.st") if text else ()


def _word(type_: str) -> str:
    return re.sub(r"\W+", "_", type_).strip("_").lower()
