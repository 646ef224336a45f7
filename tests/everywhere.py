"""One program on every engine and through every text that stands for it: what it does, scan by scan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import native

from ldc import pipeline
from ldc.cli.main import main
from ldc.components import toolchain
from ldc.diagnostics import Diagnostics
from ldc.il import text as il_text
from ldc.il.st_text import print_st
from ldc.il.typecheck import check_unit
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.source import SourceFile
from runtime.cost import Cost
from runtime.vm.machine import Machine
from runtime.vm.paced import Machine as PacedMachine
from runtime.vm.stepping import Stepper

PERIOD = 10_000_000


def compiled(text: str, path: str, **options) -> pipeline.Compiled:
    """A program that has no errors."""
    result = checked(text, path, **options)
    assert not result.diagnostics.has_errors, (text, [f"{d.code} {d.message}" for d in result.diagnostics])
    return result


def checked(text: str, path: str, **options) -> pipeline.Compiled:
    return pipeline.compile_project(Sources((SourceFile(path, text),), Settings(), None),
                                    pipeline.Options(**options))


def trace(tmp_path: Path, text: str, path: str, scans: Sequence[dict[str, object]], names: Sequence[str]
          ) -> list[tuple[object, ...]]:
    """The values of variables of program ``main`` after each scan, the same on all engines; and of the text
    formatted, printed as IL and as ST, imported, and exported to PLCopen and read again."""
    program = compiled(text, path).program
    assert [str(f) for unit in program.units for f in check_unit(unit, program.units)] == []
    printed = il_text.print_program(program)
    again = compiled(printed, "printed.il").program
    assert il_text.print_program(again) == printed
    source = tmp_path / path
    source.write_text(text, encoding="utf-8")
    exported = tmp_path / "plc.xml"
    assert main(["export", str(source), "--to", "plcopen", "-o", str(exported)]) == 0
    assert main(["import", str(exported), "-o", str(tmp_path / "imported")]) == 0
    programs = {
        "vm": program, "read back": again, "shallow": compiled(text, path, max_paren_depth=0).program,
        "formatted": compiled(format_file(parse_file(SourceFile(path, text), Diagnostics())), path).program,
        "st": compiled(print_st(program), "printed.st").program,
        "exported": pipeline.compile_paths([str(exported)]).program,
        "imported": pipeline.compile_paths([str(tmp_path / "imported")]).program,
    }
    machines = {name: Machine(one, period_ns=PERIOD) for name, one in programs.items()}
    machines["stepping"] = Machine(program, period_ns=PERIOD)
    machines["pieces"] = PacedMachine(program, period_ns=PERIOD, cost=Cost(instruction=50))
    if toolchain.find(toolchain.GCC) is not None:
        machines["native"] = native.machine(program, PERIOD)
        machines["native pieces"] = native.paced_machine(program, Cost(instruction=50), PERIOD)
    found = {}
    for name, machine in machines.items():
        scan = Stepper(machine).scan if name == "stepping" else machine.scan
        rows = found[name] = []
        run = machine.program.resources[0].runs[0].name
        for values in scans:
            for variable, value in values.items():
                machine.set(f"{run}.{variable}", value)
            scan()
            rows.append(tuple(machine.get(f"{run}.{variable}") for variable in names)
                        + (("fault",) if machine.faults else ()))
    for name, rows in found.items():
        assert rows == found["vm"], name
    return found["vm"]
