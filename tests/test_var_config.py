"""VAR_CONFIG: addresses and initial values of single instances."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, compiled, trace

from ldc import pipeline
from ldc.cli.main import main

VALVES = """FUNCTION_BLOCK Valve
VAR_INPUT go : BOOL; END_VAR
VAR_OUTPUT count : INT; END_VAR
VAR
    shut AT %I* : BOOL;
    open AT %Q* : BOOL;
    level AT %IW* : INT := 3;
    width : INT := 1;
END_VAR
    Valve.Check();
    count := count + width + level;
ACTION Check: open := go AND NOT shut; END_ACTION
END_FUNCTION_BLOCK
FUNCTION_BLOCK Pair
VAR_INPUT go : BOOL; END_VAR
VAR_OUTPUT counts : INT; END_VAR
VAR a, b : Valve; END_VAR
    a(go := go);
    b(go := go);
    counts := 100 * a.count + b.count;
END_FUNCTION_BLOCK
PROGRAM main
VAR
    west, east : Pair; plain : Pair; go AT %I* : BOOL; n : INT := 1; t : TON := (PT := T#1s, IN := TRUE);
    shut AT %IX0.1 : BOOL; q0 AT %QX0.0 : BOOL; q1 AT %QX0.1 : BOOL; w AT %IW2 : INT; x, y, z : INT; pt : TIME;
    bits : BYTE;
END_VAR
    west(go := go, counts => x);
    east(go := TRUE, counts => y);
    plain(go := TRUE, counts => z);
    bits.0 := q0;
    bits.1 := q1;
    pt := t.PT;
    n := n + 1;
END_PROGRAM
CONFIGURATION c
    VAR_CONFIG
        r.main.go AT %IX0.0 : BOOL;
        r.main.west.a.open AT %QX0.0 : BOOL;
        MAIN.west.a.shut AT %IX0.1 : BOOL;
        main.east.b.level AT %IW2 : INT;
        main.east.b.open AT %QX0.1 : BOOL;
        main.west.b.width : INT := 10;
        main.n : INT := 5;
        main.t : TON := (PT := T#5s);
    END_VAR
    RESOURCE r ON master
        TASK k (INTERVAL := T#10ms, PRIORITY := 0);
        PROGRAM main WITH k : main;
    END_RESOURCE
END_CONFIGURATION
"""


def test_instances_have_addresses_and_values_of_their_own(tmp_path: Path) -> None:
    rows = trace(tmp_path, VALVES, "main.st", [{"go": True, "w": 7}, {"shut": True}, {"shut": False, "w": 0}],
                 ("x", "y", "z", "bits", "n", "pt"))
    five = 5_000_000_000
    assert rows == [(413, 408, 404, 3, 6, five), (826, 816, 808, 2, 7, five), (1239, 1217, 1212, 3, 8, five)]


def test_what_an_instance_has_is_called_by_its_path() -> None:
    model = compiled(VALVES, "main.st").model
    places = {v.name: str(v.location) for v in model.globals.values() if v.location}
    assert places == {"main.west.a.open": "%QX0.0", "main.west.a.shut": "%IX0.1", "main.east.b.level": "%IW2",
                      "main.east.b.open": "%QX0.1"}
    assert set(model.pous) == {"VALVE", "VALVE_MAIN_WEST_A", "VALVE_MAIN_WEST_B", "VALVE_MAIN_EAST_B", "PAIR",
                               "PAIR_MAIN_WEST", "PAIR_MAIN_EAST", "MAIN"}


LADDER = """FUNCTION_BLOCK Valve
VAR_INPUT
    go  : BOOL;
END_VAR
VAR_OUTPUT
    done  : BOOL;
END_VAR
VAR
    open  AT %Q* : BOOL;
END_VAR

RUNG
    [go] (open) (done)

ACTION Close:
RUNG
    [go] (R open)
END_ACTION
END_FUNCTION_BLOCK

PROGRAM main
VAR
    go, shut  : BOOL;
    q0        AT %QX0.0 : BOOL;
    q1        AT %QX0.1 : BOOL;
    n         : INT;
END_VAR
VAR_EXTERNAL
    a, b  : Valve;
END_VAR

RUNG
    [go] <a: Valve()>

RUNG
    [go] <b: Valve()>

RUNG
    [shut] <a: Close()>

RUNG
    [q0] [q1] <ADD(IN1 := n, IN2 := 1, OUT => n)>
END_PROGRAM

VAR_GLOBAL
    a, b  : Valve;
END_VAR

VAR_CONFIG
    a.open  AT %QX0.0 : BOOL;
    b.open  AT %QX0.1 : BOOL;
END_VAR
"""


def test_global_instances_and_ladders(tmp_path: Path) -> None:
    rows = trace(tmp_path, LADDER, "main.ld", [{}, {"go": True}, {"shut": True}, {"go": False, "shut": False}],
                 ("q0", "q1", "n"))
    assert rows == [(False, False, 0), (True, True, 1), (False, True, 1), (False, False, 1)]


def test_two_instances_of_one_program() -> None:
    text = """PROGRAM p VAR q AT %Q* : BOOL; n : INT := 2; END_VAR q := n > 3; END_PROGRAM
CONFIGURATION c RESOURCE r ON master
    PROGRAM one : p; PROGRAM two : p; PROGRAM three : p;
END_RESOURCE
VAR_CONFIG one.q AT %QX0.0 : BOOL; two.q AT %QX0.1 : BOOL; two.n : INT := 9; END_VAR
END_CONFIGURATION"""
    found = checked(text, "main.st")
    assert [d.message for d in found.diagnostics] == ["nobody gives `three.q` its address"]
    (resource,) = found.model.resources
    assert [run.pou for run in resource.runs] == ["P_ONE", "P_TWO", "P"]
    assert str(found.model.pous["P_ONE"].variables["Q"].location) == "%QX0.0"
    assert found.model.pous["P_TWO"].variables["N"].initial == 9


def test_what_fits_no_instance_is_told() -> None:
    config = "VAR_CONFIG {} END_VAR"
    text = "FUNCTION_BLOCK f VAR q AT %Q* : BOOL; END_VAR q := TRUE; END_FUNCTION_BLOCK " \
           "PROGRAM main VAR a : f; many : ARRAY [0..1] OF f; END_VAR a(); many[0](); END_PROGRAM "
    right = "main.a.q AT %QX0.0 : BOOL;"
    for line, wanted in ((right, 0), (f"{right} {right}", 1), ("main.a.x AT %QX0.0 : BOOL;", 1), ("b.q : BOOL;", 1),
                         ("main.a.q AT %IX0.0 : BOOL;", 1), ("main.a.q AT %QB0 : BYTE;", 1),
                         (f"{right} main.many[0].q AT %QX0.1 : BOOL;", 1), ("main.a.q AT %Q* : BOOL;", 1)):
        codes = [d.code for d in checked(text + config.format(line), "main.st").diagnostics]
        assert codes.count("LD0239") == wanted, line
        assert "LD0238" in codes  # of the array
    inside = "PROGRAM main VAR_CONFIG main.a : INT; END_VAR END_PROGRAM"
    assert [d.code for d in checked(inside, "main.st").diagnostics] == ["LD0217"]


@pytest.mark.parametrize("depth", [3, 30])
def test_blocks_that_hold_themselves_and_long_chains_end(depth: int) -> None:
    chain = "".join(f"FUNCTION_BLOCK f{n} VAR a, b : f{n + 1}; END_VAR END_FUNCTION_BLOCK " for n in range(depth))
    text = f"{chain}FUNCTION_BLOCK f{depth} VAR x AT %I* : BOOL; END_VAR END_FUNCTION_BLOCK " \
           f"PROGRAM main VAR z : f0; END_VAR END_PROGRAM " \
           f"VAR_CONFIG main.z{'.b' * depth}.x AT %IX0.0 : BOOL; END_VAR"
    codes = {d.code for d in checked(text, "main.st").diagnostics}
    assert codes >= {"LD0238"} and "LD0239" not in codes
    circle = text.replace(f"f{depth} VAR", f"f{depth} VAR back : f0;")
    assert "LD0216" in {d.code for d in checked(circle, "main.st").diagnostics}


def test_files_without_configured_variables_lose_open_addresses(tmp_path: Path) -> None:
    source, xml = tmp_path / "a.st", tmp_path / "a.xml"
    source.write_text(VALVES, encoding="utf-8")
    assert main(["export", str(source), "--to", "plcopen", "-o", str(xml)]) == 0
    assert pipeline.compile_paths([str(xml)]).image.digest == compiled(VALVES, "main.st").image.digest
    text = xml.read_text(encoding="utf-8")
    before, _, rest = text.partition("<configVars>")
    xml.write_text(before + rest.partition("</configVars>")[2], encoding="utf-8")
    found = pipeline.compile_paths([str(xml)]).diagnostics
    assert {d.code for d in found} == {"LD0152"}
    xml.write_text(text.replace("r.main.go", "r main go"), encoding="utf-8")
    assert "LD0144" in {d.code for d in pipeline.compile_paths([str(xml)]).diagnostics}
