"""Regular expressions that are compiled when they are first used.

A command loads the modules of all languages and formats, and uses few of their expressions; to compile them
all took a tenth of the time in which `ldc` starts.
"""

from __future__ import annotations

import re


class Pattern:
    """What `re.compile` gives for ``text`` and ``flags``, made when one of its attributes is first asked
    for."""

    def __init__(self, text: str, flags: int = 0) -> None:
        self._given = text, flags

    def __getattr__(self, name: str) -> object:
        found = getattr(re.compile(*self._given), name)
        setattr(self, name, found)  # found there from now on
        return found
