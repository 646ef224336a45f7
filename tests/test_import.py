"""`ldc import`: the text of a tree is the tree, the project is the program, and nothing is half written."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest
from charts import Chart
from charts import charts as random_charts
from charts import text as chart_text
from hypothesis import given, settings
from hypothesis import strategies as st
from plcopen_xml import block, coil, contact, ladder, pou, project, rail, right, value
from statements import programs as statement_programs
from strategies import expressions, junction_rungs, program_text, sp_rungs
from test_format import CANONICAL
from test_parser import DECLARATIONS, bare, parsed

from ldc.cli.main import main
from ldc.diagnostics import Diagnostics
from ldc.parser import ast, format_of
from ldc.parser.formats import FORMATS
from ldc.parser.unparse import expr_text
from ldc.parser.write import written
from ldc.pipeline import compile_paths
from ldc.source import SourceFile

ROOT = Path(__file__).resolve().parents[1]
CORPUS = ROOT.parent / "shared" / "corpus"
DRAWN = ladder(
    "a b q : BOOL; t : TON", rail(), contact(2, "a"), value(3, "T#2s"),
    block(4, "TON", {"IN": 2, "PT": 3}, ("Q", "ET"), "t"),
    contact(5, "b", "4.Q"), coil(6, "q", 5), right(7, 6))


def tree(file: ast.File) -> object:
    return tuple(map(bare, (file.pous, file.types, file.globals, file.configurations)))


def rewritten(file: ast.File, path: str) -> ast.File:
    diagnostics = Diagnostics()
    again = written([*file.pous, *file.types, *file.globals, *file.configurations], path, diagnostics)
    assert not len(diagnostics), [d.message for d in diagnostics]
    return again


# ---- trees as text


@pytest.mark.parametrize("text", [CANONICAL, DECLARATIONS], ids=["canonical", "declarations"])
def test_the_text_of_a_tree_gives_the_tree(text: str) -> None:
    file = parsed(text)
    again = rewritten(file, "again.ld")
    assert tree(again) == tree(file)
    assert rewritten(again, "again.ld").source.text == again.source.text


@given(st.lists(sp_rungs(max_leaves=30) | junction_rungs(), min_size=1, max_size=3),
       st.lists(expressions(), max_size=2))
@settings(deadline=None, max_examples=60)
def test_random_ladders_as_text(drawn: list[ast.Rung], contacts: list[ast.Expr]) -> None:
    extra = "".join(f"[{expr_text(e)}] " for e in contacts)
    file = parsed(program_text(drawn).replace("END_PROGRAM", f"RUNG {extra}[a0] (q0) END_PROGRAM"))
    assert tree(rewritten(file, "again.ld")) == tree(file)


@given(statement_programs)
@settings(deadline=None, max_examples=30)
def test_random_statements_as_text(text: str) -> None:
    file = parsed(text, "x.st")
    assert tree(rewritten(file, "again.st")) == tree(file)


@given(random_charts())
@settings(deadline=None, max_examples=30)
def test_random_charts_as_text(chart: Chart) -> None:
    file = parsed(chart_text(chart))
    again = rewritten(file, "again.ld")
    assert tree(rewritten(again, "again.ld")) == tree(again)
    order = [[bare(part) for part in group] for body in (file.pous[0].body,)
             for group in (body.steps, body.transitions, body.actions)]
    assert order == [[bare(part) for part in group] for body in (again.pous[0].body,)
                     for group in (body.steps, body.transitions, body.actions)]


def test_notes_become_comments_in_one_line() -> None:
    found = parsed("PROGRAM p VAR a, b : INT; END_VAR END_PROGRAM").pous[0]
    section = found.var_blocks[0]
    notes = ("two\n lines *)", None)
    variables = (dataclasses.replace(v, note=note) for v, note in zip(section.variables, notes, strict=True))
    noted = dataclasses.replace(section, variables=tuple(variables))
    again = written([dataclasses.replace(found, var_blocks=(noted,))], "p.ld", Diagnostics())
    assert "    a  : INT;  // two lines *)\n    b  : INT;\n" in again.source.text


def test_notes_of_members_become_comments() -> None:
    (found,) = parsed("TYPE s : STRUCT a, b : INT; c : REAL := 1.5; END_STRUCT := (a := 3); END_TYPE").types
    notes = ("mm", None, "°C")
    fields = (dataclasses.replace(f, note=n) for f, n in zip(found.type.fields, notes, strict=True))
    noted = dataclasses.replace(found, type=dataclasses.replace(found.type, fields=tuple(fields)))
    again = written([noted], "types.st", Diagnostics())
    assert "        a  : INT;          // mm\n        b  : INT;\n        c  : REAL := 1.5;  // °C\n" in again.source.text
    assert bare(again.types[0].initial) == bare(found.initial)


# ---- the command


def imported(tmp_path: Path, text: str, *options: str, name: str = "plc.xml") -> tuple[int, Path]:
    source = tmp_path / name
    source.write_text(text, encoding="utf-8")
    folder = tmp_path / "plant"
    return main(["import", str(source), "-o", str(folder), *options]), folder


def digest(path: Path) -> str:
    result = compile_paths([str(path)])
    assert result.image is not None, [d.message for d in result.diagnostics]
    return result.image.digest


def test_a_project_of_text_files(tmp_path: Path, capsys) -> None:
    status, folder = imported(tmp_path, DRAWN)
    assert status == 0, capsys.readouterr().err
    assert sorted(p.relative_to(folder).as_posix() for p in folder.rglob("*.*")) == [
        "README.md", "import-report.md", "ldc.toml", "src/main.ld"]
    assert digest(folder) == digest(tmp_path / "plc.xml")
    assert main(["fmt", "--check", str(folder)]) == 0
    text = (folder / "src" / "main.ld").read_text(encoding="utf-8")
    assert "[a] <t: TON(PT := T#2s)> [b] (q)" in text
    report = (folder / "import-report.md").read_text(encoding="utf-8")
    assert digest(folder) in report and "| PROGRAM main | 1 rung | `src/main.ld` |" in report


def test_the_report_tells_what_was_added(tmp_path: Path) -> None:
    drawn = ladder(
        "a b q : BOOL; t : TON; c : CTU", rail(), contact(2, "a"), value(3, "T#2s"),
        block(4, "TON", {"EN": 2, "IN": 1, "PT": 3}, ("ENO", "Q", "ET"), "t"), contact(5, "b"),
        block(6, "CTU", {"CU": 5}, ("Q",), "c").replace('"CU"', '"CU" edge="rising"'), coil(7, "q", "6.Q"))
    status, folder = imported(tmp_path, drawn)
    assert status == 0
    rows = (folder / "import-report.md").read_text(encoding="utf-8").split("## Added: 2")
    assert "`main.t` | an instance of `TON_EN`" in rows[0]
    assert re.search(r"\| \d+ \| `TON_EN` \| a function block", rows[1])
    assert re.search(r"\| \d+ \| `main.edge_6_CU` \| an instance of `R_TRIG` \|", rows[1])


MANY = project(
    pou("<LD>" + rail() + contact(2, "a") + coil(3, "q", 2) + "</LD>", "a q : BOOL", "zeta"),
    pou("<ST><p>a := NOT a; (* turn *)</p></ST>", "a : BOOL", "alpha"),
    pou("<IL><p>LD a\nSTN a</p></IL>", "a : BOOL", "types"),
    types='<dataType name="Mode"><baseType><enum><values><value name="idle"/><value name="busy"/></values>'
          "</enum></baseType></dataType>",
    instances='<configurations><configuration name="c"><resource name="r">'
              '<task name="t" priority="1" interval="T#20ms"><pouInstance name="one" typeName="zeta"/>'
              '<pouInstance name="two" typeName="alpha"/><pouInstance name="three" typeName="types"/></task>'
              '<globalVars><variable name="g"><type><BOOL/></type></variable></globalVars>'
              "</resource></configuration></configurations>")


def test_every_language_gets_its_file_and_the_order_of_programs_stays(tmp_path: Path) -> None:
    status, folder = imported(tmp_path, MANY)
    assert status == 0
    assert sorted(p.name for p in (folder / "src").iterdir()) == [
        "alpha.st", "globals.st", "types.st", "types_2.il", "zeta.ld"]
    assert (folder / "ldc.toml").read_text(encoding="utf-8").count("src/zeta.ld") == 1
    assert digest(folder) == digest(tmp_path / "plc.xml")
    assert main(["fmt", "--check", str(folder)]) == 0


def test_errors_refuse_unless_the_rest_is_wanted(tmp_path: Path, capsys) -> None:
    broken = MANY.replace("<variable>a</variable>", "<variable>nowhere</variable>")
    assert imported(tmp_path, broken)[0] == 1
    assert "LD0404" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["plc.xml"]
    status, folder = imported(tmp_path, broken, "--keep-going")
    assert status == 1
    assert "[nowhere] (q)" in (folder / "src" / "zeta.ld").read_text(encoding="utf-8")
    report = (folder / "import-report.md").read_text(encoding="utf-8")
    assert re.search(r"\| plc.xml:\d+ \| error LD0404 \|", report)


def test_a_name_that_no_text_can_hold_is_renamed(tmp_path: Path) -> None:
    status, folder = imported(tmp_path, ladder("a q step : BOOL", rail(), contact(2, "a"), coil(3, "q", 2)))
    assert status == 0 and digest(folder) == digest(tmp_path / "plc.xml")
    assert "| `step` | `step_` |" in (folder / "import-report.md").read_text(encoding="utf-8")


def test_only_an_empty_folder_is_filled(tmp_path: Path, capsys) -> None:
    folder = tmp_path / "plant"
    folder.mkdir()
    assert imported(tmp_path, DRAWN)[0] == 0
    assert imported(tmp_path, DRAWN)[0] == 2
    assert "not an empty folder" in capsys.readouterr().err
    assert main(["import", str(folder / "src" / "main.ld"), "-o", str(tmp_path / "more")]) == 2
    assert main(["import", str(tmp_path / "plc.xml"), "-o", str(tmp_path / "plc.xml" / "under")]) == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["plant", "plc.xml"]


def test_the_folder_that_one_stands_in_is_filled(tmp_path: Path, monkeypatch) -> None:
    source = tmp_path / "plc.xml"
    source.write_text(DRAWN)
    stood = tmp_path / "here"
    stood.mkdir()
    monkeypatch.chdir(stood)
    assert main(["import", str(source), "-o", "."]) == 0
    assert (stood / "ldc.toml").exists() and not list(stood.glob(".*"))
    assert main(["check", "."]) == 0


def test_nothing_is_left_when_writing_fails(tmp_path: Path, monkeypatch) -> None:
    def full(*_) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    assert imported(tmp_path, DRAWN)[0] == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["plc.xml"]


def test_every_format_is_in_the_index() -> None:
    index = (ROOT / "docs" / "import.md").read_text(encoding="utf-8")
    assert [f.name for f in FORMATS if f"| {f.name} |" not in index] == []


def test_files_of_others(tmp_path: Path) -> None:
    """Whatever compiles is imported as the same program; the command compares the digests."""
    if not CORPUS.exists():
        pytest.skip("no collection of files of other tools")
    done = 0
    for path in sorted(p for p in CORPUS.rglob("*.*") if p.is_file() and p.stat().st_size < 200_000):
        try:
            source = SourceFile(str(path), path.read_text(encoding="utf-8"))
        except UnicodeDecodeError:
            continue
        if format_of(source) is None or compile_paths([str(path)]).image is None:
            continue
        folder = tmp_path / f"plant{done}"
        assert main(["import", str(path), "-o", str(folder)]) == 0, path
        assert main(["fmt", "--check", str(folder)]) == 0, path
        done += 1
    assert done
