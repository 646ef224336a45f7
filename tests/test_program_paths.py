"""Variables of programs and lists of globals by path: what they are on all engines, and what cannot be reached."""

from __future__ import annotations

from pathlib import Path

import pytest
from everywhere import checked, compiled, trace
from plcopen_xml import coil, contact, pou, project, rail
from test_plcopen import run

from ldc.il.layout import lay_out
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.pipeline import Options, compile_project
from ldc.source import SourceFile

BLOCK = """FUNCTION_BLOCK adder
VAR_INPUT i : INT; END_VAR
VAR_OUTPUT q : INT; END_VAR
    q := i + 1 + main.x;
    main.x := main.x + 1;
END_FUNCTION_BLOCK
"""
MAIN = """PROGRAM main
VAR x, y, c : INT; row : ARRAY [0..2] OF INT := [1, 2, 3]; f : adder; out AT %QW3 : INT; seen : INT; END_VAR
VAR CONSTANT k : INT := 7; END_VAR
    y := x;
    f(i := y);
    y := x * 10 + y + row[1];
    c := main.c + other.n;
    seen := x + 1000 * out;
END_PROGRAM
"""
OTHER = """PROGRAM other
VAR n : INT; g : adder; END_VAR
    n := main.y + main.row[n MOD 3] + main.f.q + main.k;
    main.row[1] := n;
    main.f.i := 3;
    main.out := n;
    g(i := main.f.q);
END_PROGRAM
"""


def test_statements(tmp_path: Path) -> None:
    rows = trace(tmp_path, BLOCK + MAIN + OTHER, "main.st", [{}] * 4, ("c", "seen"))
    assert [c for c, _ in rows] == [0, 21, 21 + 66, 21 + 66 + 137]


def test_a_ladder_proves_its_rungs_with_what_others_may_change(tmp_path: Path) -> None:
    text = """FUNCTION_BLOCK flip
RUNG [/main.a] (main.a)
END_FUNCTION_BLOCK
PROGRAM main
VAR a, b, c, d, e : BOOL; f : flip; t : TON; END_VAR
RUNG <f: flip() in=_ out=_>; [a] (b)
RUNG { [a] | [/b] } @p { <f: flip() in=_ out=_> | (c) }; @p [a] (e)
RUNG [other.t.Q] (d)
END_PROGRAM
PROGRAM other
VAR t : TON; END_VAR
RUNG [main.a] <main.t: TON(PT := T#10ms)>
RUNG <t: TON(PT := T#20ms)>
END_PROGRAM
"""
    rows = trace(tmp_path, text, "main.ld", [{}] * 4, ("b", "c", "e", "d"))
    assert rows == [(True, True, False, False)] * 3 + [(True, True, False, True)]


def test_the_path_is_the_name_of_the_variable_whoever_reaches_it() -> None:
    alone, both = compiled(MAIN.replace("+ other.n", "").replace("f : adder;", "f : CTU;")
                           .replace("f(i := y);", ""), "main.st"), compiled(BLOCK + MAIN + OTHER, "main.st")
    at = {s.path: s.offset for s in lay_out(alone.program).symbols}
    kept = {s.path: s.offset for s in lay_out(both.program, lay_out(alone.program)).symbols}
    assert all(kept[path] == at[path] for path in at if path != "main.f")


def test_lists_of_globals_are_called_like_their_files() -> None:
    files = (SourceFile("src/GVL.st", "VAR_GLOBAL speed : INT := 4; END_VAR"),
             SourceFile("src/main.st", "PROGRAM main VAR n : INT; END_VAR n := GVL.speed; GVL.speed := n + 1; END_PROGRAM"))
    result = compile_project(Sources(files, Settings(), None), Options())
    assert [d.code for d in result.diagnostics] == [] and result.image is not None


@pytest.mark.parametrize(("other", "wanted"), [
    ("n := main.nothing;", ["LD0520"]), ("n := main.tmp;", ["LD0520"]), ("n := mian.x;", ["LD0404"]),
    ("n := main.x.y;", ["LD0405"]), ("main.k := 1;", ["LD0503"]), ("main.Act();", ["LD0520"]),
    ("n := main.e;", ["LD0520"]), ("n := main;", ["LD0405"]), ("main.f.q := 1;", ["LD0503"]),
])
def test_what_cannot_be_reached_is_told(other: str, wanted: list[str]) -> None:
    text = f"""PROGRAM main
VAR_INPUT e : BOOL R_EDGE; END_VAR
VAR x : INT; f : CTU; END_VAR VAR CONSTANT k : INT := 1; END_VAR VAR_TEMP tmp : INT; END_VAR
    IF e THEN x := f.CV; END_IF;
    ACTION Act: x := 1; END_ACTION
END_PROGRAM
PROGRAM other VAR n : INT; END_VAR {other} END_PROGRAM
"""
    assert [d.code for d in checked(text, "main.st").diagnostics] == wanted


def test_a_program_that_runs_twice_has_no_variable_of_that_path() -> None:
    text = """PROGRAM part VAR x : INT; END_VAR x := x + 1; END_PROGRAM
PROGRAM main VAR n : INT; END_VAR n := part.x; END_PROGRAM
CONFIGURATION c RESOURCE r ON master TASK t (INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM p WITH t : part; PROGRAM q WITH t : part; PROGRAM m WITH t : main; END_RESOURCE END_CONFIGURATION
"""
    assert [d.code for d in checked(text, "main.st").diagnostics] == ["LD0520"]
    once = text.replace("PROGRAM q WITH t : part; ", "")
    assert compiled(once, "main.st") and compiled(once.replace("part.x", "p.x"), "main.st")


def test_a_drawing_reaches_another_program() -> None:
    xml = project(pou(f"<LD>{rail()}{contact(2, 'Second.on')}{coil(3, 'q', 2)}</LD>", "a q : BOOL"),
                  pou("<ST>on := main.a;</ST>", "on : BOOL", "Second"))
    assert run(xml, [{}, {"main.a": 1}, {}, {"main.a": 0}], "main.q") == ["0", "0", "1", "1"]
