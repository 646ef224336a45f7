"""The live table of `ldc run` on a terminal: watched values, and the power of every rung."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import pytest
import reference
from contract import MS, compiled, good, program
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from strategies import inputs, programs

from ldc.cli.powers import Powers
from ldc.graph.evaluate import evaluate
from ldc.graph.rung import RAIL
from runtime.vm.machine import Machine

SOURCE = """PROGRAM main
VAR
    a AT %IX0.0 : BOOL := TRUE; b AT %IX0.1 : BOOL; q AT %QX0.0 : BOOL;
    n, ix, sum : INT; c, d, e : BOOL; t : TON; k : ARRAY [0..1] OF BOOL;
END_VAR
RUNG plain [a] (q)
RUNG resets_itself [a] (R c) (/d)
RUNG off { [b] (d) | [b] (e) }
RUNG one_of_two { [b] (d) | [a] (e) }
RUNG edge_coil [a] (P e)
RUNG timer [a] <t: TON(PT := T#20ms)>
RUNG enabled [a] <ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG not_enabled [b] <ADD(IN1 := n, IN2 := 1, OUT => sum)>
RUNG always <ADD(IN1 := n, IN2 := 1, OUT => sum)>
RUNG indexed [a] (k[ix + 1])
RUNG by_zero [a] <DIV(IN1 := n, IN2 := ix, OUT => sum)>
RUNG jump { [a] >>last | [a] >>RETURN }
RUNG skipped [a] (d)
RUNG last [b] (e)
RUNG gone [/b] >>RETURN
RUNG behind [a] (e)
END_PROGRAM
"""


def powers(source: str) -> tuple[Machine, Powers]:
    made = good(source)
    machine = Machine(made.program, 0, 10 * MS)
    return machine, Powers(machine, made.units)


def test_power_at_the_right_end_of_every_rung() -> None:
    machine, seen = powers(SOURCE)
    with_power = "plain resets_itself one_of_two edge_coil enabled always indexed jump gone"
    expected = dict.fromkeys(with_power.split(), True)
    expected |= dict.fromkeys(("off", "timer", "not_enabled", "by_zero", "last"), False)
    expected |= dict.fromkeys(("skipped", "behind"), None)
    seen.scan()
    assert {row.name: seen.at(row) for row in seen.rows} == expected
    machine.scan()
    seen.scan()
    assert {row.name: seen.at(row) for row in seen.rows} == {**expected, "timer": True}


def test_a_rung_that_stops_by_a_fault_has_no_power() -> None:
    machine, seen = powers(program("RUNG [x / y > 1] (q)", "x, y : INT; q : BOOL;"))
    seen.scan()
    assert machine.faults and [seen.at(row) for row in seen.rows] == [None]


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=25)
@given(programs(), st.lists(st.fixed_dictionaries(dict.fromkeys(inputs(6), st.booleans())), max_size=3))
def test_power_is_that_of_the_drawing(source: str, stimuli: list) -> None:
    made = compiled(source)
    assume(not made.diagnostics.has_errors)
    machine = Machine(made.program, 0, 10 * MS)
    seen = Powers(machine, made.units)
    drawn: dict[str, bool] = {}

    def noted(graph, *rest):
        nets = evaluate(graph, *rest)
        ends = [net for net in set(graph.tails) if net != RAIL and not graph.outgoing[net]]
        drawn[graph.key] = any(nets[net] for net in ends)
        return nets

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reference, "evaluate", noted)
        graphs = {"main": [build.graph for build in made.units["main"]]}
        oracle = reference.ReferenceMachine(made.model, graphs)
        for number, values in enumerate(stimuli):
            for path, value in values.items():
                machine.set(path, value)
                oracle.set(path, value)
            seen.scan()
            oracle.scan(number * 10 * MS)
            assert {row.name: seen.at(row) for row in seen.rows} == drawn


def last_picture(tmp_path: Path, columns: int) -> list[str]:
    """The lines that are left on a terminal of this width."""
    (tmp_path / "main.ld").write_text(SOURCE)
    ours, theirs = pty.openpty()
    environment = os.environ | {"TERM": "xterm", "COLUMNS": str(columns), "LINES": "60"}
    command = [sys.executable, "-m", "ldc.cli", "run", "main.ld", "--scans", "3", "--watch", "q,t.ET"]
    process = subprocess.Popen(command, cwd=tmp_path, stdout=theirs, stderr=theirs, env=environment)
    os.close(theirs)
    shown = b""
    try:
        while part := os.read(ours, 65536):
            shown += part
    except OSError:
        pass  # The terminal is gone when the last writer is: that is the end.
    os.close(ours)
    assert process.wait() == 0
    lines = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", shown.decode()).split("\r\n")
    last = max(n for n, line in enumerate(lines) if "scan 2 of 2" in line)
    return lines[last:]


@pytest.mark.parametrize(("columns", "row", "head"), [
    (100, ["q", "BOOL", "1", "▇▇▇"], ["variable", "type", "value", "last", "60", "scans"]),
    (44, ["q", "BOOL", "1", "▇▇▇"], ["variable", "type", "value", "last", "14", "scans"]),
    (30, ["q", "BOOL", "1"], ["variable", "type", "value"]),
    (22, ["q", "1"], ["variable", "value"]),
])
def test_a_narrow_terminal_shows_names_and_values(tmp_path: Path, columns: int, row, head) -> None:
    lines = last_picture(tmp_path, columns)
    rows = [line.split() for line in lines]
    assert row in rows and head in rows and all(len(line.rstrip()) <= columns for line in lines[1:6])


def test_the_table_shows_values_and_rungs(tmp_path: Path) -> None:
    rows = [line.split() for line in last_picture(tmp_path, 100)]
    assert ["q", "BOOL", "1", "▇▇▇"] in rows and ["t.ET", "TIME", "20", "ms"] in rows
    assert all(row in rows for row in (["rung", "power"], ["timer", "1"], ["off", "0"], ["skipped", "-"]))
