"""Structured Text at random: the VM, the stepping mode and the IL read back do what the statements mean."""

from __future__ import annotations

from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from statements import BOOLS, TYPES, Fault, Interpreter, TooLong, programs
from test_engines import PERIOD, compiled

from ldc.diagnostics import Diagnostics
from ldc.il import text as il_text
from ldc.il.typecheck import check_unit
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.source import SourceFile
from runtime.cost import Cost
from runtime.vm.machine import Machine
from runtime.vm.paced import Machine as PacedMachine
from runtime.vm.stepping import Stepper


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=60)
@given(programs, st.integers(-5, 5))
def test_statements_do_what_they_mean(text: str, start: int) -> None:
    file = parse_file(SourceFile("main.st", text), Diagnostics())
    result = compiled(text, "main.st")
    assert [str(f) for unit in result.program.units for f in check_unit(unit, result.program.units)] == []
    read_back = compiled(il_text.print_program(result.program), "main.il").program
    shallow = compiled(text, "main.st", max_paren_depth=0).program
    formatted = compiled(format_file(file), "main.st").program
    machines = {name: Machine(program, period_ns=PERIOD) for name, program in
                (("vm", result.program), ("read back", read_back), ("depth 0", shallow), ("formatted", formatted),
                 ("stepping", result.program))}
    machines["pieces"] = PacedMachine(result.program, period_ns=PERIOD, cost=Cost(instruction=50))
    scans = {name: machine.scan for name, machine in machines.items()}
    scans["stepping"] = Stepper(machines["stepping"]).scan
    reference = Interpreter(file)
    reference.values["i0"] = start
    for machine in machines.values():
        machine.set("i0", start)
    for number in range(3):
        try:
            reference.scan()
        except TooLong:
            assume(False)
        except Fault:
            for name, scan in scans.items():
                scan()
                assert machines[name].faults, f"{name} has no fault in scan {number}\n{text}"
            return
        for name, scan in scans.items():
            scan()
            assert not machines[name].faults, (name, machines[name].faults, text)
            got = {v: machines[name].get(v) for v in (*TYPES, *BOOLS)}
            assert got == reference.values, f"{name}, scan {number}\n{text}"
            field = [machines[name].get(f"field[{n}]") for n in range(4)]
            assert field == reference.field, f"{name}, scan {number}\n{text}"
