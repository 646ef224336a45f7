"""Which components are algorithms: those that a slave of the project executes by itself, at a period of its
own. All others are called by the ladder, which waits for them (docs/components.md)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Set

from ldc.components import findings
from ldc.components.descriptor import Component
from ldc.diagnostics import Diagnostics
from ldc.il.areas import SLAVES
from ldc.il.placement import NoRoom, holds_algorithm, placed
from ldc.il.program import Program
from ldc.model.declaration_findings import cannot_be_lent
from ldc.types import blocks_in, holds_blocks


def slaves(processors: Mapping[str, str]) -> frozenset[int]:
    """The numbers of a project's slaves, from the roles of its processors by name: N of a slave that is
    called slaveN, the least free number for others in their order."""
    named = [name.lower() for name, role in processors.items() if role == "slave"]
    own = {number for number in range(1, SLAVES + 1) if f"slave{number}" in named}
    free = iter([number for number in range(1, SLAVES + 1) if number not in own])
    others = sum(name not in {f"slave{number}" for number in own} for name in named)
    return frozenset(own) | {number for _, number in zip(range(others), free)}


def slave_of(component: Component, slaves: Set[int]) -> int | None:
    """The slave that executes a component by itself, None when it is called. A component for any slave goes
    to the first one."""
    if component.period_us is None or component.processor == "master" or not slaves:
        return None
    number = min(slaves) if component.processor == "slave" else int(component.processor[-1])
    return number if number in slaves else None


def elsewhere(components: Iterable[Component], slaves: Set[int], diagnostics: Diagnostics) -> None:
    """Tells which components are called because their slave is none of the project's."""
    for component in components:
        paced = component.period_us is not None and component.processor != "master"
        if slaves and paced and slave_of(component, slaves) is None:
            at = component.span("function", "processor")
            names = ", ".join(f"slave{number}" for number in sorted(slaves))
            findings.no_such_slave(diagnostics, at, component.name, component.processor, names)


def called(components: Iterable[Component], slaves: Set[int], target: str, diagnostics: Diagnostics) -> None:
    """Tells which components are called on a target though a slave would execute them by itself."""
    for component in components:
        if slave_of(component, slaves) is not None:
            findings.called_here(diagnostics, component.span("function", "period_us"), component.name, target)


def lent(program: Program, diagnostics: Diagnostics) -> None:
    """Tells of pins that take instances with algorithms in them: a slave executes these in their places."""
    for unit in program.units:
        for variable in unit.arguments:
            if holds_blocks(variable.type) and holds_algorithm(variable.type, program):
                cannot_be_lent(diagnostics, variable.span, variable.name,
                               f"a slave executes {next(blocks_in(variable.type))}")


def room(program: Program, components: Mapping[str, Component], diagnostics: Diagnostics) -> None:
    """Tells when a slave has no slot for an algorithm; ``components`` by name in capitals."""
    try:
        placed(program)
    except NoRoom as error:
        component = components[error.unit.upper()]
        at = component.span("component", "name")
        findings.no_slot(diagnostics, at, component.name, error.path, error.slave, error.blocks)
