"""EN and ENO in calls of Structured Text and IL: what they call, keep and tell on all engines."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, trace

from ldc.cli.main import main

HEAD = """FUNCTION half : INT
VAR_INPUT x : INT; END_VAR
VAR_OUTPUT rest : INT; END_VAR
{half}
END_FUNCTION
PROGRAM main
VAR a, ok, ok2, ok3, ok4, q : BOOL; x : INT := 7; y, z, v : INT; t : ARRAY [1..2] OF CTU; d : DINT; w : DINT;
    i : INT := 1; e : TIME; END_VAR
"""


def test_statements(tmp_path: Path) -> None:
    text = HEAD.format(half="half := x / 2; rest := x MOD 2;") + """
    y := half(EN := a, x + y, rest => z, ENO => ok);
    d := ADD(EN := NOT a, IN1 := x, IN2 := y);
    w := DIV(IN1 := x, IN2 := z, ENO => ok2);
    t[i](EN := a, CU := TRUE, PV := 2, Q => q, CV => v, ENO => ok3);
    t[2](CU := a, ENO => ok4);
    x := x + 1;
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{"a": True}, {"a": False}, {"a": True}, {"a": False}],
                 ("y", "z", "ok", "d", "w", "ok2", "q", "v", "ok3", "ok4"))
    assert rows == [
        (3, 1, True, 0, 7, True, False, 1, True, True), (3, 1, False, 11, 8, True, False, 1, False, True),
        (6, 0, True, 11, 8, False, False, 1, True, True), (6, 0, False, 16, 8, False, False, 1, False, True)]


def test_operators_are_called_by_the_names_of_their_inputs(tmp_path: Path) -> None:
    """As the OpenPLC Editor and Beremiz write the ST of a drawing."""
    text = """PROGRAM main
VAR a, b, x, y, z, ok, ok2 : BOOL; END_VAR
    x := NOT(EN := a, IN := b, ENO => ok);
    y := NOT(IN := b) OR NOT (a) AND b;
    z := XOR(EN := b, IN1 := a, IN2 := y, ENO => ok2);
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{"a": True}, {"b": True}, {"a": False}],
                 ("x", "y", "z", "ok", "ok2"))
    assert rows == [(True, True, False, True, False), (False, False, True, True, True),
                    (False, True, True, False, True)]


def test_eno_of_an_instance_is_that_of_its_last_call(tmp_path: Path) -> None:
    """As the OpenPLC Editor writes blocks that are enabled by one another."""
    text = """FUNCTION_BLOCK own
VAR_INPUT EN : BOOL; END_VAR
VAR_OUTPUT ENO : BOOL; END_VAR
    ENO := NOT EN;
END_FUNCTION_BLOCK
FUNCTION_BLOCK twice
VAR_INPUT x : INT; END_VAR
VAR_OUTPUT y : INT; END_VAR
    y := x * 2;
END_FUNCTION_BLOCK
PROGRAM main
VAR a, b, first_ENO, told, kept : BOOL; first, second : twice; third : own; end : CTU; n : INT; END_VAR
    told := first.eno;
    IF NOT b THEN first(EN := a, x := 3); END_IF;
    second(EN := first.ENO, x := first.y + 1);
    third(EN := second.ENO);
    end(CU := third.ENO, PV := 3, ENO => kept);
    n := second.y;
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.st", [{"a": False}, {"a": True}, {"b": True, "a": False}, {"b": False}, {}],
                 ("told", "n", "first_ENO", "kept", "end.CV", "third.ENO"))
    assert rows == [(False, 0, False, True, 1, True), (False, 14, False, True, 1, False),
                    (True, 14, False, True, 1, False), (True, 14, False, True, 2, True),
                    (False, 14, False, True, 2, True)]


@pytest.mark.parametrize(
    ("use", "code"),
    [("end.ENO", "LD0406"), ("n.ENO", "LD0405"), ("all[1].ENO", "LD0406"), ("nothing.ENO", "LD0404")],
)
def test_what_has_no_eno_is_told(use: str, code: str) -> None:
    text = f"""PROGRAM main
VAR end : CTU; kept, x : BOOL; n : INT; all : ARRAY [1..2] OF CTU; END_VAR
    end(CU := x, ENO => kept);
    all[1]();
    x := {use};
END_PROGRAM
"""
    assert [d.code for d in checked(text, "main.st").diagnostics if d.severity == "error"] == [code]


def test_lists_of_instructions(tmp_path: Path) -> None:
    text = HEAD.format(half="LD x\nDIV 2\nST half\nLD x\nMOD 2\nST rest") + """
    half(EN := a, x := x, rest => z, ENO => ok)
    ST y
    MAX(EN := a, IN1 := x, IN2 := y)
    ST d
    DIVTIME(IN1 := T#6ms, IN2 := z, ENO => ok2)
    ST e
    CAL t[i](EN := a, CU := TRUE, PV := 2, Q => q, CV => v, ENO => ok3)
    CAL t[2](CU := a, NOT ENO => ok4)
    LD x
    ADD 1
    ST x
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.il", [{"a": False}, {"a": True}, {"a": False}],
                 ("y", "z", "ok", "d", "e", "ok2", "v", "ok3", "ok4"))
    assert rows == [(0, 0, False, 0, 0, False, 0, False, False),
                    (4, 0, True, 8, 0, False, 1, True, False), (0, 0, False, 0, 0, False, 1, False, False)]


def test_nothing_is_computed_for_a_call_that_is_not_made(tmp_path: Path) -> None:
    text = HEAD.format(half="half := x / 2; rest := x MOD 2;") + """
    half(EN := a, x := 1 / z, ENO => ok);
    t[1](EN := a, CU := TRUE, PV := half(x := 5, rest => y));
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}], ("y", "ok", "a")) == [(0, False, False)]


def test_a_block_that_declares_these_pins_is_called_always(tmp_path: Path) -> None:
    text = """FUNCTION_BLOCK own
VAR_INPUT EN : BOOL; END_VAR
VAR_OUTPUT ENO : BOOL; n : INT; END_VAR
    n := n + 1;
    ENO := NOT EN;
END_FUNCTION_BLOCK
PROGRAM main
VAR o : own; n : INT; ok : BOOL; END_VAR
    o(EN := FALSE, n => n, ENO => ok);
END_PROGRAM
"""
    assert trace(tmp_path, text, "main.st", [{}, {}], ("n", "ok")) == [(1, True), (2, True)]


@pytest.mark.parametrize(("statement", "codes"), [
    ("y := 1 + half(EN := a, x := 2);", ["LD0514"]), ("y := 1 + ADD(EN := a, IN1 := 2, IN2 := 2);", ["LD0514"]),
    ("t[1](EN := a, EN := a);", ["LD0506"]), ("t[1](EN := x);", ["LD0401"]), ("t[1](ENO => x);", ["LD0403"]),
    ("t[1](EN => a);", ["LD0505"]), ("y := t[1](EN := a);", ["LD0101"]),
])
def test_wrong_uses_are_told(statement: str, codes: list[str]) -> None:
    text = HEAD.format(half="half := x / 2;") + f"{statement}\nEND_PROGRAM\n"
    assert [d.code for d in checked(text, "main.st").diagnostics] == codes


def test_an_export_declares_what_its_text_names(tmp_path: Path) -> None:
    source, target = tmp_path / "main.st", tmp_path / "plc.xml"
    text = "PROGRAM main\nVAR t : TON; q : BOOL; END_VAR\nt(EN := q, IN := q);\nq := t.ENO;\nEND_PROGRAM\n"
    source.write_text(text, encoding="utf-8")
    assert main(["export", str(source), "--to", "plcopen", "-o", str(target)]) == 0
    assert "q := t.ENO;" in target.read_text(encoding="utf-8")
    assert "t_ENO" not in target.read_text(encoding="utf-8")
