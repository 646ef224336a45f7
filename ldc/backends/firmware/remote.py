"""Components that run on the second processor: what both images know of their structures, and where data
pass."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ldc.backends.firmware.board import Board
from ldc.backends.firmware.components import symbol
from ldc.components.address_map import areas
from ldc.components.descriptor import ERROR
from ldc.components.project import Native
from ldc.il import c_types
from ldc.symbols import Variable
from ldc.types import Array, String, Type, storage

_ENVELOPE, _HEAD = 20, 8


def tables(remotes: Sequence[tuple[int, Native]], serves: bool, steps: Mapping[int, int]) -> str:
    """The C file with ``ldc_remotes``; the slave (``serves``) has the code, the master calls it by
    ``ldc_call``. ``steps``: by the number of a component the microseconds of the steps that a call goes
    in."""
    lines = ["#include <stdbool.h>", "#include <stddef.h>", '#include "link.h"', ""]
    rows = []
    for at, (number, native) in enumerate(remotes):
        parts = c_types.members(native.unit)
        lines += [c_types.structure(f"part_{part}_{at}", variables) for part, variables in parts.items()]
        head = f"void {symbol(number)}(const void *in, void *out, void *state, uint32_t microseconds)"
        lines.append(f"{head};")
        if not serves:
            lines += [f"{head} {{", f"    ldc_call({at}, in, out, state, microseconds);", "}"]
        lines += [f"_Static_assert(sizeof(part_{part}_{at}) == {size(variables)}, \"as planned\");"
                  for part, variables in parts.items()]
        sizes = ", ".join(f"sizeof(part_{part}_{at})" for part in parts)
        entry = symbol(number) if serves else "0"
        rows.append(f"    {{ {entry}, {sizes}, offsetof(part_out_{at}, {ERROR}), {steps.get(number, 0)} }},")
    return "\n".join([*lines, "", f"const uint32_t ldc_remote_count = {len(rows)};",
                      "const ldc_remote ldc_remotes[] = {", *rows, "};", ""])


def slot(remotes: Iterable[tuple[int, Native]]) -> int:
    """The bytes that the largest call takes in shared memory."""
    calls = (sum(_wide(size(v)) for v in c_types.members(native.unit).values()) for _, native in remotes)
    return _ENVELOPE + _HEAD + max(calls, default=0) + 4


def room() -> int:
    """The bytes that a call may take (memory.toml)."""
    return min(areas()["SMD"].size, areas()["MSD"].size)


def patience(remotes: Iterable[tuple[int, Native]]) -> int:
    """Microseconds until a slave is taken for silent: five of its periods, 5 ms at least (SPEC 2.5)."""
    return max((5 * (native.component.period_us or 0) for _, native in remotes), default=0)


def windows(board: Board, remotes: Sequence[tuple[int, Native]]) -> dict[str, int]:
    """The constants of both images: the areas of slave1 (SPEC 1.3) in the memory that is shared."""
    known = areas()
    first = known["SMD"].first()
    base = board.second.shared.base - first
    found = {name: base + known[name].first() for name in ("SMD", "MSD", "MPF", "SPF", "MPA", "SPA")}
    return {f"LDC_{name}": at for name, at in found.items()} | {
        "LDC_SLOT": slot(remotes),
        "LDC_SECOND_TABLE": board.second.table, "LDC_SECOND_WAIT": board.second.wait,
        "LDC_SECOND_VECTORS": board.second.flash.base,
        "LDC_PATIENCE": min(max(patience(remotes), 5000) * board.clock_hz // 10**6, 0x7FFF_FFFF)}


def size(variables: Sequence[Variable]) -> int:
    """``sizeof`` the structure of some members."""
    end = widest = 1 if not variables else 0
    for variable in variables:
        bytes_, align = _measure(variable.type)
        end = -(-end // align) * align + bytes_
        widest = max(widest, align)
    return -(-end // widest) * widest


def _measure(type_: Type) -> tuple[int, int]:
    match type_:
        case Array(element=element):
            bytes_, align = _measure(element)
            return bytes_ * type_.count, align
        case String(length=length):
            return (2 + length + 1) // 2 * 2, 2
    bytes_ = max(storage(type_).bits // 8, 1)
    return bytes_, bytes_


def _wide(bytes_: int) -> int:
    return -(-bytes_ // 8) * 8
