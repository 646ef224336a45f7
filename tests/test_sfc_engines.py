"""Charts at random: the VM, the stepping mode and the IL read back do what an interpreter of charts says."""

from __future__ import annotations

from charts import COILS, COUNTS, INPUTS, LAMPS, Chart, Interpreter, Scan, charts, scans, text
from hypothesis import HealthCheck, given, settings
from test_engines import PERIOD

from ldc import pipeline
from ldc.diagnostics import Diagnostics
from ldc.il import text as il_text
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


def compiled(source: str, path: str = "main.ld", **options) -> pipeline.Compiled:
    result = pipeline.compile_project(Sources((SourceFile(path, source),), Settings(), None),
                                      pipeline.Options(**options))
    wrong = [f"{d.code} {d.message}" for d in result.diagnostics if d.severity == "error"]
    assert not wrong, (wrong, source)
    return result


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=40)
@given(charts(), scans)
def test_charts_do_what_they_mean(chart: Chart, run: list[Scan]) -> None:
    source = text(chart)
    result = compiled(source)
    assert [str(f) for unit in result.program.units for f in check_unit(unit, result.program.units)] == []
    assert all(build.verdict.kind != "wrong" for builds in result.units.values() for build in builds)
    printed = il_text.print_program(result.program)
    assert il_text.print_program(compiled(printed, "main.il").program) == printed
    formatted = format_file(parse_file(SourceFile("main.ld", source), Diagnostics()))
    assert format_file(parse_file(SourceFile("main.ld", formatted), Diagnostics())) == formatted
    programs = {"vm": result.program, "read back": compiled(printed, "main.il").program,
                "depth 0": compiled(source, max_paren_depth=0, verify=False).program,
                "formatted": compiled(formatted, verify=False).program, "stepping": result.program}
    machines = {name: Machine(program, period_ns=PERIOD) for name, program in programs.items()}
    machines["pieces"] = PacedMachine(result.program, period_ns=PERIOD, cost=Cost(instruction=50))
    step = {name: machine.scan for name, machine in machines.items()}
    step["stepping"] = Stepper(machines["stepping"]).scan
    reference = Interpreter(chart)
    for number, scan in enumerate(run):
        reference.values |= zip(INPUTS, scan.inputs, strict=True) if scan.run else ()
        if scan.run:
            reference.execute(number * PERIOD)
        expected = {name: reference.values[name] for name in (*COILS, *LAMPS, *COUNTS)}
        expected |= {name: value for name, value in reference.values.items() if "." in name or name[0] == "t"}
        for n in range(chart.steps):
            expected |= {f"s{n}.X": n in reference.active, f"s{n}.T": reference.elapsed[n]}
        for name, machine in machines.items():
            machine.set("run", scan.run)
            for variable, value in zip(INPUTS, scan.inputs, strict=True):
                machine.set(variable, value)
            step[name]()
            assert not machine.faults, (name, machine.faults, source)
            got = {path: machine.get(f"chart.{path}") for path in expected}
            assert got == expected, f"{name}, scan {number}\n{source}"
