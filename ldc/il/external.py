"""Where the native code of a unit is, once it is built: what an engine needs to call it."""

from __future__ import annotations

from pathlib import Path

from ldc.records import record
from ldc.types import Type


@record
class Shared:
    """A global variable that native code names: ``offset`` in bytes in the memory that it is given.
    It is read before every call, also when it is only written: not every call writes all of it."""

    name: str
    type: Type
    offset: int
    written: bool


@record
class Binding:
    """``library`` exports ``entry`` and, when ``size`` is not 0, the pointer ``ldc_memory`` to that many
    bytes, which hold the variables ``shared``."""

    unit: str
    library: Path
    entry: str
    size: int = 0
    shared: tuple[Shared, ...] = ()
