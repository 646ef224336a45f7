"""Places of IL as Python text, for one POU in one context (program instance, block or function)."""

from __future__ import annotations


from ldc.expr import Const, IndexStep, Place, strides
from ldc.il.program import Unit
from ldc.records import record
from ldc.symbols import Location
from ldc.types import Array, holds_blocks
from runtime.layout import INTRINSIC, Cell, Home, Layout, Packed, slot
from runtime.vm.memory import packed_name


@record
class Root:
    """A variable in Python: ``text`` reads it, ``key`` names it for hazards. ``packed`` has its own access;
    ``cell`` is the namespace entry when it is one; ``shared``: a global instance, changed from elsewhere."""

    text: str
    key: str
    cell: str | None = None
    packed: Packed | None = None
    shared: bool = False


class Names:
    """``program``: number of the program instance, None for blocks (``self``) and functions (locals)."""

    def __init__(self, layout: Layout, unit: Unit, program: int | None) -> None:
        self._layout = layout
        self._roots: dict[tuple[str, bool], Root] = {}
        self.kinds = {v.name.upper(): v.kind for v in unit.variables}
        self._program = program
        self._function = unit.kind == "FUNCTION"

    def root(self, place: Place) -> Root:
        """The variable that a place starts at; KeyError for a name that the unit does not declare."""
        key = (place.root, place.is_global)
        found = self._roots.get(key)
        if found is None:
            found = self._roots[key] = self._make(place.root, place.is_global)
        return found

    def _make(self, name: str, is_global: bool) -> Root:
        upper = name.upper()
        if is_global or self.kinds[upper] == "external":
            if upper in INTRINSIC:
                return Root(INTRINSIC[upper], INTRINSIC[upper], INTRINSIC[upper])
            if name[0] == "%":
                return self._home(self._layout.direct[str(Location.parse(name))].home)
            known = self._layout.globals[upper]
            return self._home(known.home, holds_blocks(known.variable.type))
        if self.is_local(upper):
            local = f"l_{slot(name)}"
            return Root(local, local)
        if self._program is None:
            return Root(f"self.{slot(name)}", f"self.{slot(name)}")
        return self._home(self._layout.programs[self._program][1][upper].home)

    def is_local(self, upper: str) -> bool:
        """Whether the variable is a Python local: temporaries, and everything of a FUNCTION."""
        return self._function or self.kinds[upper] == "temp"

    def _home(self, home: Home, shared: bool = False) -> Root:
        if isinstance(home, Cell):
            return Root(home.name, home.name, home.name, None, shared)
        at = home.location
        if at.size == "X" and is_single(home):
            return Root(f"({home.name}[{at.byte}] & {1 << at.bit} != 0)", home.name, None, home)
        view = packed_name(home)
        return Root(f"{view}.get()" if is_single(home) else view, home.name, None, home)


def is_single(home: Packed) -> bool:
    """Whether the packed variable is one value (not an array)."""
    return not isinstance(home.type, Array)


def constant_offset(step: IndexStep) -> int | None:
    """The flat offset when all indexes are constants within the bounds, else None."""
    total = 0
    for index, (low, high), stride in zip(step.indexes, step.bounds, strides(step.bounds), strict=True):
        if not isinstance(index, Const) or not low <= index.value <= high:
            return None
        total += (index.value - low) * stride
    return total

