"""How the elements of a POU use its variables together."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.diagnostics import Diagnostics
from ldc.expr import Const, IndexStep, Place
from ldc.model import call_findings as findings
from ldc.model.elements import Coil
from ldc.model.project import Pou

_OWNING = frozenset(("normal", "negated", "rising", "falling"))


def duplicate_coils(pou: Pou, coils: Iterable[tuple[str, Coil]], diagnostics: Diagnostics) -> None:
    """Warn, once for a place, when coils that write on every execution have the same one (set and reset do
    not).

    ``coils``: (rung key, coil) of the whole POU in the order of execution. A place with a computed
    index may be another one each time and does not count. Places at one address are one place.
    """
    writers: dict[str, list[Coil]] = {}
    for _, coil in coils:
        if coil.kind not in _OWNING or _computed(coil.place):
            continue
        writers.setdefault(_identity(pou, coil.place), []).append(coil)
    for first, *others in writers.values():
        if others:
            second = others[0]
            findings.duplicate_coil(diagnostics, second.span, str(second.place), first.span, 1 + len(others))


def _computed(place: Place) -> bool:
    return any(isinstance(step, IndexStep) and any(not isinstance(i, Const) for i in step.indexes)
               for step in place.steps)


def _identity(pou: Pou, place: Place) -> str:
    variable = pou.variables.get(place.root.upper())
    if variable is not None and variable.location is not None and not place.steps:
        return str(variable.location)
    return str(place).upper()
