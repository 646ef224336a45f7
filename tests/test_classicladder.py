"""Files of ClassicLadder: what cells, blocks, expressions, sections and pages do, and what is told."""

from __future__ import annotations

from pathlib import Path

import pytest
from foreign_files import broken, compiled, drawn, machine, remarks, run, said
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc.diagnostics import Diagnostics
from ldc.parser import parse_file
from ldc.pipeline import compile_paths
from ldc.source import SourceFile

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "corpus" / "clp"
PATH = "plant.clp"
WIDTH, HEIGHT = 10, 6


def rung(
    *rows: str, label: str = "", comment: str = "", following: int = -1, version: str = "2.0"
) -> list[str]:
    """Rows of cells between spaces; ``-`` is a wire, ``.`` free; ``^`` joins a cell with the one above.
    A row shorter than the rung is filled up with wires before its last cell, when that is a coil."""
    lines = [
        f"#VER={version}",
        f"#LABEL={label}",
        f"#COMMENT={comment}",
        "#PREVRUNG=0",
        f"#NEXTRUNG={following}",
    ]
    for row in (*rows, *[""] * (HEIGHT - len(rows))):
        cells = row.split()
        if cells and cells[-1].lstrip("^").split("-")[0].isdigit() and 50 <= int(
                cells[-1].lstrip("^").split("-")[0]) <= 60:
            cells[-1:-1] = ["-"] * (WIDTH - len(cells))
        cells += ["."] * (WIDTH - len(cells))
        lines.append(" , ".join(map(cell, cells)))
    return lines


def cell(text: str) -> str:
    top, text = int(text.startswith("^")), text.lstrip("^")
    text = {"-": "9-0/0", ".": "0-0/0", "#": "99-0/0"}.get(text, text)
    kind, variable = text.split("-", 1)
    return f"{kind}-{top}-{variable}"


def project(
    *rungs: list[str],
    sections: tuple[str, ...] = (),
    expressions: tuple[str, ...] = (),
    period: int = 100,
    **files: tuple[str, ...],
) -> str:
    """A project; the rungs follow each other in one section unless sections are given."""
    if not sections:
        sections = ("#NAME000=Main", f"000,0,-1,0,{len(rungs) - 1},0")
        for number, lines in enumerate(rungs):
            lines[4] = f"#NEXTRUNG={number + 1}"
    parts = {"general.txt": (f"PERIODIC_REFRESH={period}", "SIZE_NBR_BITS=20", "SIZE_NBR_WORDS=20",
                             "SIZE_NBR_PHYS_INPUTS=10", "SIZE_NBR_PHYS_OUTPUTS=10"),
             **{f"rung_{n}.csv": lines for n, lines in enumerate(rungs)},
             "sections.csv": ("#VER=1.0", *sections),
             "arithmetic_expressions.csv": ("#VER=2.0", *(f"{n:04d},{e}" for n, e in enumerate(expressions))),
             **{f"{name}.csv": lines for name, lines in files.items()}}
    lines = ["_FILES_CLASSICLADDER"]
    for name, content in parts.items():
        lines += [f"_FILE-{name}", *content, f"_/FILE-{name}"]
    return "\n".join((*lines, "_/FILES_CLASSICLADDER")) + "\n"


def trace(text: str, states: str, watch: str) -> str:
    """What the watched variables are after each scan, I0 being as told."""
    return " ".join(run(text, PATH, [{"I0": int(s)} for s in states], watch))


# ---- contacts, coils, lines


@pytest.mark.parametrize(("row", "inputs", "wanted"), [
    ("1-50/0 50-60/0", "0110", "0 1 1 0"), ("2-50/0 50-60/0", "0110", "1 0 0 1"),
    ("3-50/0 50-60/0", "0110", "0 1 0 0"), ("4-50/0 50-60/0", "0110", "0 0 0 1"),
    ("1-50/0 51-60/0", "0110", "1 0 0 1"), ("1-50/0 52-60/0", "0110", "0 1 1 1"),
    (". 1-50/0 50-60/0", "01", "0 0"), ("- - - 50-60/0", "00", "1 1"),
])
def test_one_row(row: str, inputs: str, wanted: str) -> None:
    assert trace(project(rung(row, "1-50/9 50-0/0", "1-50/0 50-0/1")), inputs, "Q0") == wanted


def test_reset() -> None:
    text = project(rung("1-50/1 52-60/0", "1-50/0 53-60/0"))
    assert run(text, PATH, [{"I1": 1}, {"I1": 0}, {"I0": 1}], "Q0") == ["1", "1", "0"]


def test_vertical_lines_join_to_the_right_only() -> None:
    text = project(rung("1-50/0 - 1-50/2 50-60/0", "1-50/1 ^- 1-50/3 50-60/1"))
    for bits in range(16):
        row = {f"I{n}": bits >> n & 1 for n in range(4)}
        joined = row["I0"] or row["I1"]
        assert run(text, PATH, [row], "Q0 Q1") == [f"{int(joined and row['I2'])} {int(joined and row['I3'])}"]
    one_way = project(rung("1-50/0 - ^. 50-60/0", "1-50/1 1-50/2 ^1-50/3 50-60/1"))
    assert run(one_way, PATH, [{"I0": 1, "I3": 1}, {"I0": 0, "I1": 1, "I2": 0}], "Q0 Q1") == ["0 1", "0 0"]


def test_what_is_in_series_and_parallel_is_written_so() -> None:
    text = project(rung("1-50/0 1-50/1 50-60/0", "1-60/0 ^.", comment="Seal in", label="seal"))
    assert drawn(text, PATH, "plant") == ['RUNG seal "Seal in" { [I0] | [Q0] } [I1] (Q0)']


def test_contacts_are_read_before_the_coils_of_the_rung_are_written() -> None:
    text = project(rung("1-50/0 50-0/0", "1-0/0 50-0/1", "1-0/1 50-0/2"))
    assert trace(text, "1000", "B0 B1 B2") == "1 0 0 0 1 0 0 0 1 0 0 0"
    assert "@n1" in drawn(text, PATH, "plant")[0]


# ---- timers, monostables, counters


def table(base: int, preset: int, *more: int) -> tuple[str, ...]:
    return (",".join(map(str, (base, preset, *more))),)


def test_timer() -> None:
    text = project(rung("1-50/0 # 10-0/0 50-60/0", ". # # 50-60/1"), timers=table(2, 3))
    assert trace(text, "01111101", "Q0") == "0 0 0 0 1 1 0 0"
    assert trace(text, "01111101", "Q1") == "0 1 1 1 0 0 0 1"


def test_timer_with_control() -> None:
    text = project(rung("1-50/0 # 10-0/0 50-60/0", "1-50/1 # # 50-60/1"), timers=table(2, 2))
    rows = [{"I0": 1, "I1": 1}, {"I1": 0}, {}, {"I1": 1}, {}]
    assert run(text, PATH, rows, "Q0 Q1") == ["0 1", "0 1", "0 1", "0 1", "1 0"]


def test_parts_of_a_timer_are_variables() -> None:
    text = project(
        rung("1-50/0 # 10-0/0 .", ". # # ."),
        rung("1-10/0 50-60/0", "1-11/0 50-60/1", "- - - - - - - # # 60-0/0", "1-50/1 - - - - - - # # 60-0/1"),
        timers=table(1, 1),
        expressions=("@200/0@:=@231/0@", "@230/0@:=2"),
        period=500,
    )
    rows = [{}, {"I0": 1}, {}, {}, {"I0": 0, "I1": 1}, {}, {"I0": 1}] + [{}] * 4
    found = run(text, PATH, rows, "W0 Q0 Q1")
    assert found[:5] == ["1 0 0", "0 0 1", "0 0 1", "0 1 0", "1 0 0"]
    assert found[5:] == ["2 0 0", "1 0 1", "1 0 1", "0 0 1", "0 0 1", "0 1 0"]


def test_monostable() -> None:
    text = project(rung("1-50/0 # 11-0/0 50-60/0", ". # #"), monostables=table(2, 3))
    assert trace(text, "0111111", "Q0") == "0 1 1 1 0 0 0"
    assert trace(text, "0101010101", "Q0") == "0 1 1 1 0 1 1 1 0 1"


@pytest.mark.parametrize(("mode", "inputs", "wanted"), [
    (0, "0111101", "0 0 0 1 1 0 0"), (1, "0110000", "0 1 1 1 1 0 0"), (2, "0111101", "0 1 1 0 0 0 1"),
])
def test_iec_timer(mode: int, inputs: str, wanted: str) -> None:
    text = project(rung("1-50/0 # 13-0/0 50-60/0", ". # #"), timers_iec=table(2, 2, mode))
    assert trace(text, inputs, "Q0") == wanted


def test_counter() -> None:
    rows = ("1-50/0 # 12-0/0 50-60/0", "1-50/1 # # 50-60/1", "1-50/2 # # 50-60/2", "1-50/3 # #")
    text = project(rung(*rows), counters=("3",))
    given_ = [
        {},
        {"I2": 1},
        {"I2": 0},
        {"I2": 1},
        {"I1": 1},
        {"I1": 0, "I0": 1},
        {"I0": 0, "I3": 1},
        {"I3": 0, "I2": 0},
        {"I2": 1},
    ]
    assert run(text, PATH, given_, "C0_value Q0 Q1 Q2") == [
        "0 0 0 0",
        "1 0 0 0",
        "1 0 0 0",
        "2 0 0 0",
        "3 0 1 0",
        "0 0 0 0",
        "9999 1 0 0",
        "9999 1 0 0",
        "0 0 0 1",
    ]


# ---- expressions


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("@200/5@:=@200/0@+@200/1@*2", 1),
        ("@200/5@=(@200/0@+@200/1@)*2", 8),
        ("@200/5@:=@200/0@/2", 3),
        ("@200/5@:=@200/0@%4", 3),
        ("@200/5@:=-5", -5),
        ("@200/5@:=$1F", 31),
        ("@200/5@:='AB'", 16706),
        ("@200/5@:=$FFFFFFFF", -1),
        ("@200/5@:=@200/0@&3|8", 11),
        ("@200/5@:=@200/0@^2", 2401),
        ("@200/5@:=!@200/0@", 0),
        ("@200/5@:=MINI(@200/0@,@200/1@,@200/2@)", -3),
        ("@200/5@:=MAXI(@200/0@,@200/1@)", 7),
        ("@200/5@:=MOY(@200/0@,@200/1@)", 2),
        ("@200/5@:=AVG(@200/0@)", 7),
        ("@200/5@:=ABS(@200/1@)", 3),
        ("@200/5@ := @200/0@ - 10 ", -3),
        ("@200/5@:=@50/0@+1", 2),
        ("@200/5@:=1-@0/3@-2", -1),
        ("@200/5@:=8-2-1", 5),
        ("@200/5@:=100/5/2", 10),
    ],
)
def test_operate(expression: str, wanted: int) -> None:
    text = project(
        rung("- - - - - - - # # 60-0/0", "- - - - - - - # # 60-0/1"),
        rung("1-50/0 - - - - - - # # 60-0/2"),
        expressions=("@200/0@:=7", "@200/1@:=-3", expression),
    )
    assert run(text, PATH, [{}, {"I0": 1}], "W5")[1] == str(wanted)


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("MINI(@200/0@,5,-4)", -4),
        ("ABS(-4)", 4),
        ("POW(@200/0@,3)", 343),
        ("POW(@200/1@,0)", 1),
        ("POW(@200/1@,-2)", -3),
        ("POW(3,40)", 3**40 % 2**32),
        ("SHL(@200/0@,2)", 28),
        ("SHL($60000000,1)", -(1 << 30)),
        ("SHR(@200/0@,1)", 3),
        ("SHR(@200/1@,1)", (-3 >> 1) & 0x7FFFFFFF),
        ("SHR(@200/1@,3)", (-3 >> 3) & 0x7FFFFFFF),
        ("ROL(@200/1@,1)", -5),
        ("ROL(@200/0@,1)", 14),
        ("ROR(@200/0@,1)", 3 - 2**31),
        ("ROR(6,1)", 3),
        ("@200/0@/@200/2@+1", 1),
        ("@200/0@%@200/2@", 0),
        ("@200/0@/0*3", 0),
        ("100/@200/0@*2%5", 3),
        ("@200/0@^3|8", 12),
        ("$F&@200/0@^$F", 8),
    ],
)
def test_expressions_of_newer_tools(expression: str, wanted: int) -> None:
    """As in version 0.9.113, whose files have registers; what it shifts out, %S8, is told."""
    text = project(
        rung("- - - - - - - # # 60-0/0", "- - - - - - - # # 60-0/1"),
        rung("- - - - - - - # # 60-0/2"),
        expressions=("@200/0@:=7", "@200/1@:=-3", f"@200/5@:={expression}"),
    ).replace("PERIODIC", "SIZE_NBR_REGISTERS=10\nPERIODIC")
    assert run(text, PATH, [{}], "W5") == [str(wanted)]


def test_what_numbers_of_types_mean_in_newer_tools() -> None:
    text = project(rung("1-70/8 50-0/0"), rung("- - - - - - - # # 60-0/0"),
                   expressions=("@200/0@:=@300/1@^2",))
    assert not said(compiled(text, PATH))
    part = "_FILE-project_infos.txt\nPARAM_VERSION=8\n_/FILE-project_infos.txt\n"
    infos = text.replace("_FILE-general", f"{part}_FILE-general")
    assert said(compiled(infos, PATH)) == [
        "LD0151 ClassicLadder: the system bit %S8 is not supported",
        "LD0151 ClassicLadder: `^`, which some versions take for a power and some for XOR, is not supported",
    ]
    registers = text.replace("PERIODIC", "SIZE_NBR_REGISTERS=10\nPERIODIC")
    assert said(compiled(registers, PATH)) == [
        "LD0151 ClassicLadder: the system bit %S8 is not supported",
        "LD0151 ClassicLadder: the variable type 300 of a register is not supported",
    ]
    errors = project(rung("1-75/0 50-75/1"))
    assert run(errors, PATH, [{"E0": 1}], "E1") == ["1"]


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("@200/0@=7", "1"),
        ("@200/0@<>7", "0"),
        ("@200/0@<@200/1@", "0"),
        ("@200/0@>=7", "1"),
        ("@200/0@<=6", "0"),
        ("(@200/0@-1)&3=@200/2@+2", "1"),
        ("!@200/2@>0", "1"),
        ("", "0"),
    ],
)
def test_compare(expression: str, wanted: str) -> None:
    text = project(
        rung("- - - - - - - # # 60-0/0", "- - - - - - - # # 60-0/1"),
        rung("# # 20-0/2 1-50/0 50-60/0"),
        expressions=("@200/0@:=7", "@200/1@:=-3", expression),
    )
    assert run(text, PATH, [{"I0": 1}], "Q0") == [wanted]


def test_bits_and_floats_in_expressions() -> None:
    text = project(rung(*["- - - - - - - # # 60-0/%d" % n for n in range(3)]),
                   expressions=("@0/3@:=@50/0@+@50/1@", "@310/0@:=@200/0@+3", "@200/0@:=@300/0@"))
    running = machine(text, PATH)
    running.set("IF0", 2.9)
    running.set("I1", True)
    running.scan()
    running.scan()
    assert (running.get("B3"), running.get("QF0"), running.get("W0")) == (True, 5.0, 2)


def test_indexed_variables_are_an_array() -> None:
    text = project(rung("- - - - - - - # # 60-0/0", "- - - - - - - # # 60-0/1"),
                   expressions=("@200/3[200/9]@:=@200/3[200/9]@+10", "@200/9@:=@200/9@+1"),
                   symbols=("#VER=1.0", "%W9,Index,"))
    running = machine(text, PATH)
    for _ in range(3):
        running.scan()
    assert [running.get(f"W[{n}]") for n in (3, 4, 5, 6, 9)] == [10, 10, 10, 0, 3]
    assert ("renamed", "Index", "W[9]") in remarks(compiled(text, PATH))


@pytest.mark.parametrize(
    "expression",
    [
        "@200/0@:=",
        "@200/0@:=1+",
        "@200/0@+1",
        "@200/0@:=(1",
        "@200/0@:=SIN(@200/0@)",
        "@200/0@:=-@200/1@",
        "@231/0@:=5",
        "@200/0@:=" + "(" * 20 + "1" + ")" * 20,
        "200/0:=1",
        "@200/0@:=1 1",
        "@200/0[0/1]@:=1",
    ],
)
def test_wrong_expressions(expression: str) -> None:
    text = project(rung("- - - - - - - # # 60-0/0"), expressions=(expression,), timers=table(1, 1))
    (finding,) = said(compiled(text, PATH))
    assert finding.startswith("LD0150 ClassicLadder: the expression is wrong: ")


# ---- jumps, subroutines, sections


def test_a_jump_leaves_the_rung_at_once() -> None:
    text = project(
        rung("1-50/0 54-0/2", "1-50/1 50-60/0"),
        rung("- - - - - - - # # 60-0/0"),
        rung("- - - - - - - # # 60-0/1", label="end"),
        expressions=("@200/0@:=@200/0@+1", "@200/1@:=@200/1@+1"),
    )
    rows = [{"I1": 1}, {"I0": 1, "I1": 0}, {"I0": 0}]
    assert run(text, PATH, rows, "W0 W1 Q0") == ["1 1 1", "1 2 1", "2 3 0"]


def test_a_jump_to_an_empty_rung() -> None:
    text = project(rung("1-50/0 54-0/2"), rung("1-50/1 50-60/0"), rung(), rung())
    assert run(text, PATH, [{"I1": 1}, {"I0": 1, "I1": 0}], "Q0") == ["1", "1"]


def test_subroutines_run_where_they_are_called() -> None:
    rungs = (rung("1-50/0 55-0/0", "- - - - - - - # # 60-0/0", following=-1),
             rung("- - - - - - - # # 60-0/1", "1-50/0 # 10-0/0 50-60/0", ". # #"), rung("- 55-0/0"))
    sections = (
        "#NAME000=Main",
        "#NAME001=add",
        "#NAME002=more",
        "000,0,-1,0,0,0",
        "001,0,0,1,1,0",
        "002,0,1,2,2,0",
    )
    text = project(
        *rungs, sections=sections, expressions=("@200/1@:=@200/0@", "@200/0@:=@200/0@+1"), timers=table(2, 1)
    )
    assert said(compiled(text, PATH)) == []
    assert trace(text, "01101", "W0 W1 Q0") == "0 0 0 1 1 0 2 2 1 2 2 1 3 3 1"


def test_subroutines_that_call_each_other_are_told() -> None:
    rungs = (rung("- 55-0/0"), rung("- 55-0/1"), rung("- 55-0/0"))
    sections = (
        "#NAME000=Main",
        "#NAME001=one",
        "#NAME002=two",
        "000,0,-1,0,0,0",
        "001,0,0,1,1,0",
        "002,0,1,2,2,0",
    )
    assert said(compiled(project(*rungs, sections=sections), PATH)) == [
        "LD0151 ClassicLadder: the subroutine one that calls itself is not supported"]


def test_sections_follow_each_other_and_old_files_have_none() -> None:
    rungs = (rung("- - - - - - - # # 60-0/0"), rung("- - - - - - - # # 60-0/1"))
    expressions = ("@200/0@:=@200/0@*2", "@200/0@:=@200/0@+3")
    late = project(*rungs, sections=("001,0,-1,0,0,0", "000,0,-1,1,1,0"), expressions=expressions)
    assert run(late, PATH, [{}, {}], "W0") == ["6", "18"]
    old = late.replace("sections.csv", "nothing.csv")
    assert run(old, PATH, [{}, {}], "W0") == ["3", "9"]
    unnumbered = old.replace("#VER=2.0\n0000,", "; expressions\n").replace("\n0001,", "\n")
    assert run(unnumbered, PATH, [{}, {}], "W0") == ["3", "9"]


STEPS = ("#VER=1.0", "S0,1,0,0,1,1", "S1,0,1,0,1,3", "S2,0,2,0,3,3")


def transition(number: int, to: tuple[int, ...], of: tuple[int, ...], condition: str) -> tuple[str, str]:
    lists = [[*steps, *[-1] * (10 - len(steps))] for steps in (to, of, (), ())]
    return (
        f"T{number},{','.join(str(n) for steps in lists for n in steps)},0,1,2",
        f"C{number},0,{condition}",
    )


def test_sequential_page() -> None:
    lines = (*STEPS, *transition(0, (1, 2), (0,), "50/0"), *transition(1, (0,), (1, 2), "50/1"))
    text = project(
        rung("1-30/1 50-60/0", "# # 20-0/0 50-60/1"),
        sections=("000,1,-1,0,0,0", "001,0,-1,0,0,0"),
        expressions=("@220/1@>1",),
        sequential=lines,
        period=500,
    )
    assert said(compiled(text, PATH)) == []
    rows = [{}, {"I0": 1}, {"I0": 0}, {}, {}, {"I1": 1}, {"I1": 0}]
    assert run(text, PATH, rows, "X0 X1 X2 X1_time Q0 Q1") == [
        "1 0 0 0 0 0",
        "0 1 1 0 1 0",
        "0 1 1 1 1 0",
        "0 1 1 1 1 0",
        "0 1 1 2 1 1",
        "1 0 0 0 0 0",
        "1 0 0 0 0 0",
    ]


def test_a_page_goes_on_while_transitions_fire() -> None:
    lines = (*STEPS, *transition(0, (2,), (1,), "50/0"), *transition(1, (1,), (0,), "50/0"))
    text = project(rung(), sections=("000,1,-1,0,0,0",), sequential=lines)
    assert run(text, PATH, [{"I0": 0}, {"I0": 1}], "X0 X1 X2") == ["1 0 0", "0 0 1"]


# ---- the file


def test_symbols_addresses_and_the_task() -> None:
    text = project(
        rung("1-50/9 50-60/3"),
        symbols=("#VER=1.0", "%I9,GUI-E,emergency", "%Q3,%Q3,", "%B7,spare,"),
        expressions=(),
        period=25,
    )
    result = compiled(text, PATH)
    assert said(result) == []
    (block,) = result.project.files[0].pous[-1].var_blocks
    assert [(v.name, v.location, v.note) for v in block.variables] == [
        ("GUI_E", "%IX1.1", "emergency"), ("Q3", "%QX0.3", None)]
    assert machine(text, PATH).period_ns == 25_000_000
    assert set(remarks(result)) == {
        ("renamed", "GUI-E", "GUI_E"),
        ("left out", "%B7 spare", "nothing uses it"),
    }


def test_words_lie_behind_bits() -> None:
    text = project(rung("1-50/0 - - - - - - # # 60-0/0"), expressions=("@280/1@:=@270/2@",))
    (block,) = compiled(text, PATH).project.files[0].pous[-1].var_blocks
    assert {v.name: v.location for v in block.variables} == {"I0": "%IX0.0", "QW1": "%QD2", "IW2": "%ID3"}
    assert run(text, PATH, [{"I0": 1, "IW2": -100000}], "QW1") == ["-100000"]


@pytest.mark.parametrize(
    ("text", "messages"),
    [
        (project(rung("1-50/0 50-60/0", "1-50/1")), ["LD0152 ClassicLadder: [I1] in rung 0 is left out"]),
        (
            project(rung("1-50/0 50-60/0"), modbusioconf=("#VER=1.0", "1,0,1,1,0,0")),
            ["LD0152 ClassicLadder: the table modbusioconf.csv is left out"],
        ),
        (
            project(rung("1-50/0 50-200/0")),
            ["LD0151 ClassicLadder: a coil of the variable W0 is not supported"],
        ),
        (project(rung("1-900/0 50-60/0")), ["LD0151 ClassicLadder: the variable type 900 is not supported"]),
        (project(rung("1-50/0 40-60/0")), ["LD0151 ClassicLadder: an element of type 40 is not supported"]),
        (project(rung("1-50/0 54-0/7")), ["LD0150 ClassicLadder: a jump to rung 7 leads to nowhere"]),
        (project(rung("1-50/0 55-0/7")), ["LD0150 ClassicLadder: rung 0: there is no subroutine 7"]),
        (
            project(rung("1-50/0 # 10-0/3 50-60/0"), timers=table(1, 1)),
            ["LD0150 ClassicLadder: %T3 has no row in the table of presets"],
        ),
        (
            project(rung("1-50/0 50-60/0", version="4.0")),
            ["LD0151 ClassicLadder: version 4.0 of rungs is not supported"],
        ),
        (
            project(rung("1-50/0 50-60/0"), timers=("7,1",)),
            ["LD0150 ClassicLadder: timers.csv: there is no time base 7"],
        ),
        (
            project(rung("1-50/0 50-60/0"), sections=("000,0,-1,0,5,0",)),
            ["LD0150 ClassicLadder: the rungs of section_0 do not lead from 0 to 5"],
        ),
    ],
)
def test_what_is_told(text: str, messages: list[str]) -> None:
    assert said(compiled(text, PATH)) == messages


def test_tables_whose_rows_have_names() -> None:
    """Newer tools write rows with presets alone; an expression without a number follows the one before."""
    timed = rung("1-50/0 # 10-0/7 50-60/0", ". # # 50-60/1")
    assert trace(project(timed, timers=("#VER=2.0", "T2,1,9", "T7,2,3")), "0111110", "Q0") == \
        trace(project(timed, timers=("1,1",) * 7 + table(2, 3)), "0111110", "Q0")
    text = project(rung("1-50/0 - - - - - - # # 60-0/4"), expressions=("@200/0@:=1",))
    text = text.replace("0000,@200/0@:=1", "0003,@200/0@:=1\n@200/0@:=8")
    assert trace(text, "01", "W0") == "0 8"


def test_system_bits_of_newer_tools() -> None:
    """%S0 flashes once a second, %S4 is TRUE in the first scan; the clock and the modem are not there."""
    text = project(rung("1-70/0 50-60/0", "1-70/4 - 50-60/1"), rung("2-70/1 1-50/0 50-60/2"), period=250,
                   project_infos=())
    text = text.replace("project_infos.csv", "project_infos.txt")
    rows = [run(text, PATH, [{"I0": 1}] * 6, name) for name in ("Q0", "Q1", "Q2")]
    assert rows == [list("100110"), list("100000"), list("100110")]
    (told,) = said(compiled(text.replace("1-0-70/4", "1-0-70/8"), PATH))
    assert told == "LD0151 ClassicLadder: the system bit %S8 is not supported"


# ---- rungs at random against the rule itself


CELLS = ("1-0/0", "1-0/1", "2-0/2", "3-50/0", "1-50/1", "9-0/0", "9-0/0", "0-0/0", "1-50/2", "2-50/0")
COILS = ("50-0/0", "50-0/1", "52-0/2", "53-0/2", "51-0/1", "0-0/0")
GRID = st.lists(st.tuples(st.lists(st.tuples(st.sampled_from(CELLS), st.booleans()), min_size=4, max_size=4),
                          st.tuples(st.sampled_from(COILS), st.booleans())), min_size=1, max_size=4)


class Grid:
    """Power from column to column as the tool computes it."""

    def __init__(self, rows: list) -> None:
        self.rows = [[*row, coil] for row, coil in rows]
        self.before: dict[tuple[int, int], bool] = {}

    def scan(self, values: dict[str, bool]) -> None:
        power = {}
        for column in range(5):
            for row in range(len(self.rows)):
                kind, variable = self.rows[row][column][0].split("-")
                name = {"0": "B", "50": "I"}[variable.split("/")[0]] + variable.split("/")[1]
                left = column == 0 or any(
                    power.get((column - 1, other)) for other in self.joined(column, row)
                )
                state = kind == "9"
                if kind in ("1", "2", "3"):
                    state = values[name] != (kind == "2")
                    if kind == "3":
                        before, self.before[column, row] = self.before.get((column, row), False), state
                        state = state and not before
                elif kind in ("50", "51"):
                    values[name] = left != (kind == "51")
                elif kind in ("52", "53") and left:
                    values[name] = kind == "52"
                power[column, row] = left and state

    def joined(self, column: int, row: int) -> list[int]:
        first = last = row
        while first and self.rows[first][column][1]:
            first -= 1
        while last + 1 < len(self.rows) and self.rows[last + 1][column][1]:
            last += 1
        return list(range(first, last + 1))


@settings(max_examples=60, deadline=None)
@given(GRID, st.lists(st.tuples(*[st.booleans()] * 3), min_size=1, max_size=5))
def test_random_rungs(rows: list, inputs: list[tuple[bool, bool, bool]]) -> None:
    lines = [" ".join(("^" if top else "") + c for c, top in [*row, coil]) for row, coil in rows]
    first = rung()
    for number, line in enumerate(lines):
        first[5 + number] = " , ".join(map(cell, line.split()))
    everything = rung("1-0/0 1-0/1 1-0/2 50-0/9", "1-50/0 1-50/1 1-50/2 50-0/8")
    running = machine(project(first, everything), PATH)
    grid, values = Grid(rows), dict.fromkeys(("B0", "B1", "B2", "I0", "I1", "I2"), False)
    for given_ in inputs:
        for number, value in enumerate(given_):
            running.set(f"I{number}", value)
            values[f"I{number}"] = value
        running.scan()
        grid.scan(values)
        assert {name: running.get(name) for name in values} == values


# ---- broken files, files of others


EXAMPLE = project(
    rung("1-50/0 # 10-0/0 50-60/0", "1-50/1 # # 54-0/1", "# # 20-0/0 50-0/3", label="one", comment="first"),
    rung("1-50/0 # 12-0/0 55-0/0", "- - - - - - - # # 60-0/1"),
    rung("1-50/2 50-60/2"),
    sections=("#VER=1.0", "#NAME000=Main", "000,0,-1,0,1,0", "001,0,0,2,2,0", "002,1,-1,0,0,0"),
    expressions=("@200/0@>3", "@200/1[200/2]@:=MINI(@200/0@,@251/0@)*$F"),
    timers=table(1, 2),
    counters=("4",),
    symbols=("%I0,start,the button",),
    sequential=(*STEPS, *transition(0, (1, 2), (0,), "50/0")),
)


@pytest.mark.parametrize("end", range(0, len(EXAMPLE), 41))
def test_a_file_that_ends_too_early(end: int) -> None:
    diagnostics = Diagnostics()
    parse_file(SourceFile(PATH, EXAMPLE[:end]), diagnostics)
    assert end < len("_FILES_CLASSICLADDER") or diagnostics.has_errors


@settings(max_examples=60, deadline=None)
@given(broken(EXAMPLE))
def test_broken_files_give_findings(text: str) -> None:
    result = compiled(text, PATH)
    assert result.program is not None or said(result)


def test_files_of_others() -> None:
    files = sorted(FOLDER.rglob("*.clp"))
    if not files:
        pytest.skip(f"no collection in {FOLDER.name}")
    for path in files:
        assert compile_paths([str(path)]).program is not None, path.name
