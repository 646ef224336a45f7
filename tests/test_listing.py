"""Bodies in Instruction List in .st files, as the generators of Beremiz and OpenPLC write them."""

from __future__ import annotations

import pytest

from ldc.cli.main import main
from ldc.pipeline import compile_paths
from runtime.vm.machine import Machine

BLOCK = """FUNCTION_BLOCK up
VAR_INPUT again : BOOL; END_VAR
VAR_OUTPUT n : INT; END_VAR
{body}
END_FUNCTION_BLOCK
"""
LISTED = "LD again\nJMPC clear\nLD n\nADD 1\nJMP done\nclear:\nLD 7\ndone:\nST n\n"
STATED = "IF again THEN n := 7; ELSE n := n + 1; END_IF;"
PROGRAM = """PROGRAM main
VAR again : BOOL; u : up; k : INT; END_VAR
u(again := again);
k := u.n;
END_PROGRAM
"""
CHART = """PROGRAM main
VAR again : BOOL; u : up; k : INT; END_VAR
INITIAL_STEP count: work(N); END_STEP
TRANSITION full FROM count TO rest:
LD k
GE 3
END_TRANSITION
STEP rest: END_STEP
TRANSITION FROM rest TO count := again; END_TRANSITION
ACTION work: CAL u(again := again)
LD u.n
ST k
END_ACTION
END_PROGRAM
"""


def trace(path, scans="0001000") -> list[int]:
    compiled = compile_paths([str(path)])
    assert compiled.image is not None, [(d.code, d.message) for d in compiled.diagnostics]
    machine, seen = Machine(compiled.program), []
    for bit in scans:
        machine.set("again", bit == "1")
        machine.scan()
        seen.append(machine.get("k"))
    return seen


def put(tmp_path, text, name="plc.st"):
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.mark.parametrize("body", [LISTED, "(* counts *)\n" + LISTED, "first:\n" + LISTED, STATED])
def test_list_in_a_file_of_statements(tmp_path, body):
    assert trace(put(tmp_path, BLOCK.format(body=body) + PROGRAM)) == [1, 2, 3, 7, 8, 9, 10]


def test_list_in_a_chart(tmp_path):
    path = put(tmp_path, BLOCK.format(body=LISTED) + CHART)
    assert trace(path, "0000010") == [1, 2, 3, 4, 4, 7, 8]
    assert main(["fmt", str(path)]) == 0
    once = path.read_text()
    assert main(["fmt", "--check", str(path)]) == 0
    assert "ACTION work:\n    CAL u(again := again)\n" in once
    assert trace(path, "0000010") == [1, 2, 3, 4, 4, 7, 8]


@pytest.mark.parametrize("kind, statement", [
    ("INT", "ld := 4; k := ld;"), ("ARRAY [0..1] OF INT", "ld[1] := 4; k := ld[1];"), ("BOOL", "ld S= again; k := 4;"),
    ("up", "ld(); k := 4;"), ("up", "ld.again := FALSE; k := 4;")])
def test_names_of_instructions_are_names_in_statements(tmp_path, kind, statement):
    text = f"PROGRAM main\nVAR again : BOOL; k : INT; ld : {kind}; END_VAR\n{statement}\nEND_PROGRAM\n"
    assert trace(put(tmp_path, BLOCK.format(body=STATED) + text), "0") == [4]


def test_import_writes_a_list_into_the_file_of_a_chart(tmp_path):
    chart = put(tmp_path, BLOCK.format(body=LISTED) + CHART)
    assert main(["export", str(chart), "--to", "plcopen", "-o", str(tmp_path / "plc.xml")]) == 0
    assert main(["import", str(tmp_path / "plc.xml"), "-o", str(tmp_path / "plant")]) == 0
    assert "CAL u(again := again)" in (tmp_path / "plant" / "src" / "main.st").read_text()
    assert "JMPC clear" in (tmp_path / "plant" / "src" / "up.il").read_text()
    images = {compile_paths([str(tmp_path / name)]).image.digest for name in ("plc.st", "plc.xml", "plant")}
    assert len(images) == 1
