"""The C header of a component: its structures, its entry, and the memory that it may name (DESIGN 6).

It compiles alone: `gcc -c algorithm.c` with it gives an object whose PLC memory is plain variables
(`ldc_d_position`) that a unit test defines. For a processor the remapper puts addresses in their place.
"""

from __future__ import annotations

from ldc.components import findings
from ldc.components.address_map import MACROS, AddressMap
from ldc.components.descriptor import Component, Pin
from ldc.diagnostics import Diagnostics
from ldc.il import c_types
from ldc.il.program import Unit
from ldc.symbols import Variable


def file_name(component: Component) -> str:
    """`axis_jog.h`: what a source of the component includes."""
    return f"{component.entry}.h"


def check_types(unit: Unit, diagnostics: Diagnostics) -> bool:
    """Whether C has a type for every member; tells which have none."""
    good = True
    for variables in c_types.members(unit).values():
        for v in variables:
            if c_types.field(v.name, v.type) is None:
                findings.no_c_type(diagnostics, v.span, v.name, str(v.type))
                good = False
    return good


def text(component: Component, unit: Unit, memory: AddressMap) -> str:
    """The whole header. Raises ValueError when a member has no C type (``check_types`` tells)."""
    guard = f"LDC_{component.entry.upper()}_H"
    entry = component.entry
    lines = [
        f"/* {component.name} ({component.id} {component.version}). Made by ldc from its descriptor. */",
        f"#ifndef {guard}",
        f"#define {guard}",
        "#include <stdbool.h>",
        "#include <stdint.h>",
        "",
    ]
    pins = {
        p.name.upper(): p
        for group in (component.inputs, component.parameters, component.outputs, component.state)
        for p in group
    }
    for part, variables in c_types.members(unit).items():
        lines += _struct(f"{entry}_{part}", variables, pins)
    lines += _memory(memory)
    lines += [
        "#ifdef __cplusplus",
        'extern "C"',
        "#endif",
        f"void {entry}(const {entry}_in *in, {entry}_out *out, {entry}_state *state, uint32_t dt_us);",
        "",
        f"#endif /* {guard} */",
    ]
    return "\n".join(lines) + "\n"


def _struct(name: str, variables: tuple[Variable, ...], pins: dict[str, Pin]) -> list[str]:
    lines = c_types.structure(name, variables).splitlines()
    for number, v in enumerate(variables, 1):
        pin = pins.get(v.name.upper())
        about = " ".join(part for part in (pin.unit, pin.text) if part) if pin else ""
        lines[number] += f"  /* {about.replace('*/', '* /')} */" if about else ""
    return [*lines, ""]


def _memory(memory: AddressMap) -> list[str]:
    """``PLC_M(x)``, ``PLC_D(x)`` and ``LCD(x)`` as plain variables: what a unit test links with."""
    lines = ["#ifndef LDC_REMAPPED"]
    for macro in MACROS:
        lines.append(f"#define {macro}(name) ldc_{macro.lower()}_##name")
    for symbol in memory.symbols.values():
        const = "" if memory.processor in symbol.writers else "const "
        declared = c_types.field(f"ldc_{symbol.macro.lower()}_{symbol.name}", symbol.type)
        if declared is not None:
            lines.append(f"extern {const}{declared};")
    return [*lines, "#endif", ""]
