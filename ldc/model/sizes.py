"""How much data a POU holds with all instances in it; beyond reason it is told where it is declared.

A dozen blocks that each hold two of the next make thousands of instances, thirty make a billion.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ldc.diagnostics import Diagnostics
from ldc.library import blocks
from ldc.model import declaration_findings as findings
from ldc.model.project import Pou
from ldc.symbols import Variable
from ldc.types import Array, Instance, Struct, Type

MOST = 10_000_000
"""Single values in one program with all its instances, or in all global variables."""


def check_sizes(
    pous: Mapping[str, Pou], order: Iterable[str], global_variables: Mapping[str, Variable],
    diagnostics: Diagnostics,
) -> None:
    """``order``: callees first, so that each instance counts what was counted for its POU."""
    sizes: dict[str, int] = {}
    for key in order:
        sizes[key] = _total(pous[key].variables.values(), sizes, diagnostics)
    _total(global_variables.values(), sizes, diagnostics)


def _total(variables: Iterable[Variable], sizes: dict[str, int], diagnostics: Diagnostics) -> int:
    """The values of all of them; 1 after a finding, which is told once."""
    total = 0
    for variable in variables:
        if variable.kind != "external":
            total += _values(variable.type, sizes)
            if total > MOST:
                findings.too_much_data(diagnostics, variable.span, variable.name, MOST)
                return 1
    return total


def _values(type_: Type, sizes: dict[str, int]) -> int:
    match type_:
        case Array(element=element):
            return type_.count * _values(element, sizes)
        case Struct(fields=fields):
            return sum(_values(field.type, sizes) for field in fields)
        case Instance(pou=pou):
            key = pou.upper()
            standard = None if key in sizes else blocks.signature(key)
            return sizes.get(key, 1) if standard is None else len(standard.inputs) + len(standard.outputs)
    return 1
