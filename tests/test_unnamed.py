"""Variables that are declared by their address alone: `AT %MW6 : INT;` (docs/ladder.md, declarations)."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, trace
from test_export import exported, read, same_behaviour
from test_recall import same

from ldc.cli.main import main
from ldc.diagnostics import Diagnostics
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.pipeline import compile_paths
from ldc.source import SourceFile
from runtime.vm.machine import Machine

SHARED = "VAR_GLOBAL AT %MW20 : INT := -5; END_VAR\n"
STATEMENTS = f"""{SHARED}PROGRAM main
VAR AT %QX5.1 : BOOL := 1; AT %MW6 : INT := 8; x : INT; AT %MW8 : ARRAY [0..2] OF INT; END_VAR
VAR AT %I0.0 : BOOL; END_VAR
    %MW6 := %MW6 - 10;
    x := %MW6 + %mw20;
    %MW8[1] := x;
    %QX5.1 := x < 0 AND %IX0.0;
END_PROGRAM
"""
LADDER = f"""{SHARED}PROGRAM main
VAR AT %MW6 : INT; AT %IX0.0 : BOOL; AT %QX5.1 : BOOL; low : BOOL; END_VAR
RUNG [%I0.0] <ADD(IN1 := %MW6, IN2 := -3, OUT => %MW6)> (%QX5.1)
RUNG [%MW6 < %MW20] (low)
END_PROGRAM
"""
LIST = f"""{SHARED}PROGRAM main
VAR AT %MW6 : INT; AT %QW20 : INT; END_VAR
LD %MW6 (* %MW6 *)
SUB 2
ST %MW6
ADD %MW20
ST %QW20
END_PROGRAM
"""


@pytest.mark.parametrize(("text", "name", "inputs", "names", "rows"), [
    (STATEMENTS, "main.st", [{}, {"IX0_0": True}], ("MW6", "x", "MW8[1]", "QX5_1"),
     [(-2, -7, -7, False), (-12, -17, -17, True)]),
    (LADDER, "main.ld", [{}, {"IX0_0": True}, {}], ("MW6", "QX5_1", "low"),
     [(0, False, False), (-3, True, False), (-6, True, True)]),
    (LIST, "main.st", [{}, {}], ("MW6", "QW20"), [(-2, -7), (-4, -9)]),
])
def test_an_address_is_the_variable_that_is_declared_there(
    text: str, name: str, inputs: list, names: tuple, rows: list, tmp_path: Path,
) -> None:
    assert trace(tmp_path, text, name, inputs, names) == rows


def test_they_are_watched_by_address_and_by_name(tmp_path: Path, capsys) -> None:
    path = tmp_path / "main.st"
    path.write_text(STATEMENTS, encoding="utf-8")
    assert main(["run", str(path), "--scans", "1", "--watch", "%MW6,MW6,%MW20,%Q5.1"]) == 0
    assert "%MW6=-2  MW6=-2  %MW20=-5  %Q5.1=0" in capsys.readouterr().out


@pytest.mark.parametrize(("text", "name"), [(STATEMENTS, "main.st"), (LADDER, "main.ld"), (LIST, "main.st")])
def test_an_export_gives_them_names(text: str, name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    xml = exported(tmp_path, path)
    assert '<variable name="MW6" address="%MW6">' in xml
    assert "%MW6" not in xml.replace('address="%MW6"', "").replace("(* %MW6 *)", "")
    same_behaviour(compile_paths([path]), read(xml), ["MW6"])


def test_the_formatter_leaves_them_without_names() -> None:
    text = "PROGRAM p\nVAR AT %mw6:INT:=2;(* six *) a,b:BOOL;END_VAR\n%MW6:=1;\nEND_PROGRAM\n"
    source = SourceFile("main.st", text)
    text = format_file(parse_file(source, Diagnostics()))
    assert text.splitlines()[2:4] == ["    AT %MW6 : INT := 2;  (* six *)", "    a, b  : BOOL;"]
    assert format_file(parse_file(SourceFile("main.st", text), Diagnostics())) == text


def test_a_name_that_is_taken_is_left_to_its_owner(tmp_path: Path) -> None:
    text = "PROGRAM main\nVAR AT %MW6 : INT; mw6 : BOOL; END_VAR\n%MW6 := -1; mw6 := %MW6 < 0;\nEND_PROGRAM\n"
    assert trace(tmp_path, text, "main.st", [{}], ("mw6", "MW6_2")) == [(True, -1)]


def test_what_a_program_declares_hides_what_is_global(tmp_path: Path) -> None:
    text = """VAR_GLOBAL AT %MW6 : INT; seen : DINT; END_VAR
PROGRAM first VAR AT %MW6 : UINT; END_VAR %MW6 := 65535; seen := %MW6; END_PROGRAM
PROGRAM second VAR told : DINT; END_VAR told := %MW6; END_PROGRAM
"""
    path = tmp_path / "main.st"
    path.write_text(text, encoding="utf-8")
    machine = Machine(compile_paths([path]).program)
    machine.scan()
    assert (machine.get("seen"), machine.get("second.told")) == (65535, -1)


def test_rungs_are_compiled_again_when_an_address_becomes_a_variable(tmp_path: Path) -> None:
    rung = "RUNG <MOVE(IN := %MW6, OUT => %MW8)>"
    plain = ["PROGRAM p", "VAR a : INT; END_VAR", rung, "END_PROGRAM"]
    named = ["PROGRAM p", "VAR AT %MW6 : INT; AT %MW8 : INT; END_VAR", rung, "END_PROGRAM"]
    half = ["PROGRAM p", "VAR AT %MW6 : INT; a : INT; END_VAR", rung, "END_PROGRAM"]
    for lines in (plain, named, half, named, plain):
        same(lines, tmp_path / "memory.rungs")


@pytest.mark.parametrize(("text", "codes"), [
    ("PROGRAM p VAR AT %MW6 : INT; AT %MW6 : INT; END_VAR END_PROGRAM", ["LD0201"]),
    ("PROGRAM p VAR AT %MW6 : DINT; END_VAR END_PROGRAM", ["LD0212"]),
    ("PROGRAM p VAR AT %IW6.2 : WORD; END_VAR %QW0 := %IW6.2; END_PROGRAM", ["LD0211"]),
    ("FUNCTION_BLOCK p VAR AT %MW6 : INT; END_VAR %MW6 := 1; END_FUNCTION_BLOCK", ["LD0213"]),
    ("PROGRAM p VAR AT %MW6 : INT; x : DINT; END_VAR x := %MW6; %MW6 := x; END_PROGRAM", ["LD0403"]),
])
def test_what_is_wrong_is_told_once(text: str, codes: list[str]) -> None:
    assert [d.code for d in checked(text, "main.st").diagnostics] == codes
