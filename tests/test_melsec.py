"""Instruction lists of Mitsubishi FX controllers: which ladder they become, and what it does scan by scan."""

from __future__ import annotations

from pathlib import Path

import growth
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc.diagnostics import Diagnostics
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser import parse_file
from ldc.parser.unparse import rung_text
from ldc.pipeline import Compiled, compile_paths, compile_project
from ldc.source import SourceFile
from runtime.vm.machine import Machine

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "corpus" / "mnemonic"


def listing(text: str) -> str:
    """`LD X0, OUT Y0` as lines."""
    return "\n".join(part.strip() for part in text.split(",")) + "\n"


def compiled(text: str, path: str = "list.il") -> Compiled:
    return compile_project(Sources((SourceFile(path, text),), Settings(), None))


def said(result: Compiled) -> list[str]:
    return [f"{d.code} {d.message}" for d in result.diagnostics]


def errors(text: str) -> list[str]:
    return [f"{d.code} {d.message}" for d in compiled(text).diagnostics if d.severity.value == "error"]


def rungs(text: str) -> list[str]:
    """The rungs of a list as canonical text, in one line each."""
    result = compiled(listing(text))
    assert result.program is not None, said(result)
    body = result.project.files[0].pous[0].body
    return [" ".join(rung_text(rung).split()) for rung in body.rungs]


def run(text: str, rows: list[dict], watch: str) -> list[str]:
    """The watched variables after each scan of 10 ms."""
    result = compiled(listing(text))
    assert result.program is not None, said(result)
    machine, found = Machine(result.program), []
    for row in rows:
        for name, value in row.items():
            machine.set(name, value)
        machine.scan()
        found.append(" ".join(str(int(machine.get(name))) for name in watch.split()))
    return found


# ---- which ladder

@pytest.mark.parametrize(("text", "rung"), [
    ("LD X0, AND X1, OR M0, ANI X2, OUT Y0", "RUNG { [X0] [X1] | [M0] } [/X2] (Y0)"),
    ("LD X0, OR X1, LD X2, OR X3, ANB, OUT Y0", "RUNG { [X0] | [X1] } { [X2] | [X3] } (Y0)"),
    ("LD X0, AND X1, LD X2, AND X3, ORB, LDI X4, ORB, OUT Y0", "RUNG { [X0] [X1] | [X2] [X3] | [/X4] } (Y0)"),
    ("LD X0, OUT Y0, SET M1, RST M2", "RUNG [X0] { (Y0) | (S M1) | (R M2) }"),
    ("LD X0, OUT Y0, AND X1, OUT Y1, AND X2, OUT Y2", "RUNG [X0] { (Y0) | [X1] { (Y1) | [X2] (Y2) } }"),
    ("LD X0, MPS, AND X1, OUT Y0, MRD, AND X2, OUT Y1, MPP, OUT Y2",
     "RUNG [X0] { [X1] (Y0) | [X2] (Y1) | (Y2) }"),
    ("LD X0, MPS, LD X1, OR X2, ANB, OUT Y0, MPP, MPS, AND X3, OUT Y1, MPP, OUT Y2",
     "RUNG [X0] { { [X1] | [X2] } (Y0) | { [X3] (Y1) | (Y2) } }"),
    ("LD X0, OUT Y0, LD X1, OR X2, ANB, OUT Y1", "RUNG [X0] { (Y0) | { [X1] | [X2] } (Y1) }"),
    ("LDP X0, ANDF X1, ORP X2, PLS M0", "RUNG { [P X0] [N X1] | [P X2] } (P M0)"),
    ("LD X0, AND X1, INV, PLF M0", "RUNG [X0] [X1] <NOT() in=IN out=OUT> (N M0)"),
    ("LD X0, LD X1, INV, ANB, OUT Y0",
     "RUNG [X0] <AND(IN2 := { [X1] <NOT() in=IN out=OUT> }) in=IN1 out=OUT> (Y0)"),
    ("LD= D0 K5, AND> D1 H0A, OR<> D0 D1, OUT Y0", "RUNG { [D0 = 5] [D1 > 10] | [D0 <> D1] } (Y0)"),
    ("LD M8000, ANI M8001, OUT Y0", "RUNG [TRUE] [TRUE] (Y0)"),
    ("LD T0, AND C5, OUT Y0", "RUNG [T0.Q] [C5.Q] (Y0)"),
    ("LD X0, OUTI Y0", "RUNG [X0] (/Y0)"),
])
def test_which_ladder_a_list_is(text: str, rung: str) -> None:
    assert rungs(text) == [rung]


def test_x_and_y_are_counted_in_eights_and_have_addresses() -> None:
    result = compiled("; X10 = The eye\nLD X010\nOUT Y017\n")
    variables = [v for section in result.project.files[0].pous[0].var_blocks for v in section.variables]
    assert [(v.name, v.location, v.note) for v in variables] == [
        ("X10", "%IX1.0", "The eye"), ("Y17", "%QX1.7", None)]


def test_titles_names_and_step_numbers() -> None:
    text = ("; Press\n\n; Start it\n0 LD X0 ; key\n1 OUT Y0\n\n// X0 = not a title\n// Stop it\nP7\n2 LD X1\n"
            "3 OUT Y1\nEND\n")
    result = compiled(text, "my press.il")
    (pou,) = result.project.files[0].pous
    assert (pou.name, pou.title) == ("my_press", "Press")
    assert [(r.name, r.title) for r in pou.body.rungs] == [(None, "Start it"), ("P7", None)]


# ---- what it does

def test_seal_in() -> None:
    rows = [{"X1": 1}, {"X1": 0}, {"X0": 1}, {"X0": 0}]
    assert run("LDI X0, LD X1, OR Y0, ANB, OUT Y0", rows, "Y0") == ["1", "1", "0", "0"]


def test_an_output_is_written_before_what_follows_reads_it() -> None:
    assert run("LD X0, OUT Y0, ANI Y0, OUT Y1", [{"X0": 1}], "Y0 Y1") == ["1 0"]
    assert run("LD X0, ANI Y0, OUT Y1, LD X0, OUT Y0", [{"X0": 1}, {}], "Y0 Y1") == ["1 1", "1 0"]


def test_edges_pulses_and_inversion() -> None:
    rows = [{"X0": 0}, {"X0": 1}, {}, {"X0": 0}, {}]
    assert run("LDP X0, OUT Y0, LDF X0, OUT Y1, LD X0, PLS M0, LD X0, PLF M1", rows, "Y0 Y1 M0 M1") == [
        "0 0 0 0", "1 0 1 0", "0 0 0 0", "0 1 0 1", "0 0 0 0"]
    assert run("LD X0, MEP, OUT Y0, LD X0, MEF, OUT Y1, LD X0, INV, OUT Y2", rows, "Y0 Y1 Y2") == [
        "0 0 1", "1 0 0", "0 0 0", "0 1 1", "0 0 1"]


def test_a_timer_of_100_ms() -> None:
    rows = [{"X0": 1}] + [{}] * 20 + [{"X0": 0}]
    text = "LD X0, OUT T0 K2, LD T0, OUT Y0, LD M8000, MOV T0 D0"
    found = run(text, rows, "Y0 D0")
    assert found == ["0 0"] * 10 + ["0 1"] * 10 + ["1 2", "0 0"]


def test_timers_of_10_ms_and_1_ms_and_a_preset_in_a_register() -> None:
    text = "LD X0, MOV K3 D0, LD X0, OUT T200 D0, OUT T256 K15, LD T200, OUT Y0, LD T256, OUT Y1"
    assert run(text, [{"X0": 1}, {}, {}, {}], "Y0 Y1 T200.V T256.V") == [
        "0 0 0 0", "0 0 1 10", "0 1 2 15", "1 1 3 15"]


def test_a_retentive_timer_keeps_its_value_until_it_is_reset() -> None:
    text = "LD X0, OUT T246 K30, LD X1, RST T246, LD T246, OUT Y0"
    rows = [{"X0": 1}, {}, {"X0": 0}, {}, {"X0": 1}, {}, {"X0": 0}, {"X1": 1}, {"X1": 0}, {"X0": 1}, {}]
    assert run(text, rows, "T246.V Y0") == [
        "0 0", "10 0", "20 0", "20 0", "20 0", "30 1", "30 1", "0 0", "0 0", "0 0", "10 0"]


def test_a_counter_stops_at_its_preset_and_its_reset_holds_it() -> None:
    text = "LD X0, OUT C0 K2, LD X1, RST C0, LD C0, OUT Y0"
    rows = [{"X0": 1}, {}, {"X0": 0}, {"X0": 1}, {"X0": 0}, {"X0": 1}, {"X1": 1}, {"X0": 0}, {"X0": 1},
            {"X1": 0}, {"X0": 0}, {"X0": 1}]
    assert run(text, rows, "C0.V Y0") == [
        "1 0", "1 0", "1 0", "2 1", "2 1", "2 1", "0 0", "0 0", "0 0", "0 0", "0 0", "1 0"]


def test_a_counter_of_32_bits_counts_down_by_its_relay() -> None:
    text = "LD X1, OUT M8200, LD X0, OUT C200 K-1, LD C200, OUT Y0"
    rows = [{"X1": 1, "X0": 1}, {"X0": 0}, {"X0": 1}, {"X1": 0, "X0": 0}, {"X0": 1}, {"X1": 1, "X0": 0},
            {"X0": 1}]
    assert run(text, rows, "C200.V Y0") == ["-1 0", "-1 0", "-2 0", "-2 0", "-1 1", "-1 1", "-2 0"]


def test_master_control_takes_the_power_of_its_zone() -> None:
    text = ("LD X0, MC N0 M100, LD X1, OR X2, OUT Y0, LD X1, MC N1 M101, LD X2, OUT Y1, MCR N1, LD X2, "
            "SET Y2, MCR N0, LD X2, OUT Y3")
    assert rungs(text)[1:3] == ["RUNG [M100] { [X1] | [X2] } (Y0)", "RUNG [M100] [X1] (M101)"]
    rows = [{"X2": 1}, {"X0": 1}, {"X1": 1}, {"X0": 0}]
    assert run(text, rows, "Y0 Y1 Y2 Y3") == ["0 0 0 1", "1 0 1 1", "1 1 1 1", "0 0 1 1"]


def test_jumps_and_labels() -> None:
    text = ("LD X0, CJ P1, LD M8000, INC D0, P2, P1, LD M8000, INC D1, LD X1, CJ P63, LD M8000, INC D2, "
            "LD X1, CJP P3, P3, END")
    assert run(text, [{"X0": 1}, {"X0": 0}, {"X1": 1}], "D0 D1 D2") == ["0 1 1", "1 2 2", "2 3 2"]


def test_first_scan_and_clocks() -> None:
    text = "LD M8002, OUT Y0, LD M8003, OUT Y1, LDI M8003, OUT Y2, LD M8012, OUT Y3"
    found = run(text, [{}] * 21, "Y0 Y1 Y2 Y3")
    assert found[0] == "1 0 1 1"
    assert [row[-1] for row in found] == list("1" * 5 + "0" * 5 + "1" * 5 + "0" * 5 + "1")
    assert all(row.startswith("0 1 0") for row in found[1:])


@pytest.mark.parametrize(("instruction", "given_", "watch", "result"), [
    ("MOV D0 D1", {"D0": -5}, "D1", "-5"), ("MOV HFFFF D1", {}, "D1", "-1"), ("MOV 7 D1", {}, "D1", "7"),
    ("ADD D0 K1 D1", {"D0": 32767}, "D1", "-32768"), ("SUB D0 D2 D1", {"D0": 3, "D2": 5}, "D1", "-2"),
    ("MUL D0 D1 D2", {"D0": 1000, "D1": -1000}, "D2 D3", "-16960 -16"),
    ("DIV D0 D1 D0", {"D0": -17, "D1": 5}, "D0 D1", "-3 -2"),
    ("DIV D0 D1 D2", {"D0": 5, "D2": 9}, "D2 D3", "9 0"),
    ("INC D0", {"D0": 32767}, "D0", "-32768"), ("DEC D0", {"D0": 0}, "D0", "-1"),
    ("NEG D0", {"D0": 4}, "D0", "-4"),
    ("CML D0 D1", {"D0": 5}, "D1", "-6"), ("WAND D0 H0F D1", {"D0": 0x3C}, "D1", "12"),
    ("WOR D0 D1 D2", {"D0": 1, "D1": -32768}, "D2", "-32767"),
    ("WXOR D0 D1 D2", {"D0": 3, "D1": 5}, "D2", "6"),
    ("DMOV K100000 D0", {}, "D0 D1", "-31072 1"), ("DADD D0 D2 D4", {"D0": -1, "D2": 1}, "D4 D5", "0 1"),
    ("DSUB D0 K1 D0", {"D1": 1}, "D0 D1", "-1 0"), ("DINC D0", {"D0": -1}, "D0 D1", "0 1"),
    ("DDEC D0", {}, "D0 D1", "-1 -1"),
    ("DMUL D0 D2 D4", {"D1": 1, "D3": 2}, "D4 D5 D6 D7", "0 0 2 0"),
    ("DDIV D0 D2 D4", {"D0": 17, "D2": 5}, "D4 D5 D6 D7", "3 0 2 0"),
    ("DAND D0 HFFFF D2", {"D0": -1, "D1": -1}, "D2 D3", "-1 0"),
    ("DOR D0 H10000 D2", {"D0": 7}, "D2 D3", "7 1"),
    ("CMP D0 K5 M0", {"D0": 6}, "M0 M1 M2", "1 0 0"), ("CMP D0 K5 M0", {"D0": 5}, "M0 M1 M2", "0 1 0"),
    ("DCMP D0 K70000 M0", {"D1": 1}, "M0 M1 M2", "0 0 1"),
    ("ZRST M0 M2", {"M0": 1, "M2": 1, "M3": 1}, "M0 M1 M2 M3", "0 0 0 1"),
    ("ZRST D0 D1", {"D0": 1, "D1": 1, "D2": 1}, "D0 D1 D2", "0 0 1"),
    ("BMOV D0 D1 K3", {"D0": 1, "D1": 2, "D2": 3}, "D0 D1 D2 D3", "1 1 2 3"),
    ("BMOV D1 D0 K2", {"D0": 1, "D1": 2, "D2": 3}, "D0 D1 D2", "2 3 3"),
    ("FMOV K4 D0 K2", {}, "D0 D1", "4 4"), ("RST D0", {"D0": 4}, "D0", "0"), ("ALT M0", {"M0": 0}, "M0", "1"),
])
def test_data_instructions(instruction: str, given_: dict, watch: str, result: str) -> None:
    """Under power once; without power nothing changes."""
    touch = "".join(f", MOV {name} {name}" if name[0] == "D" else f", OUT {name}"
                    for name in {*given_, *watch.split()})
    text = f"LD X0, {instruction}, LD X7{touch}"
    values = {name: 0 for name in watch.split()} | given_
    for power, want in ((1, result), (0, " ".join(str(values[name]) for name in watch.split()))):
        program = compiled(listing(text).replace("LD X7\n", "LD X7\nCJ P63\nP1\nLD M8001\n")).program
        assert program is not None, said(compiled(listing(text)))
        machine = Machine(program)
        for name, value in given_.items():
            machine.set(name, value)
        machine.set("X0", power)
        machine.set("X7", 1)
        machine.scan()
        assert " ".join(str(int(machine.get(name))) for name in watch.split()) == want


def test_pulse_forms_work_once_per_edge() -> None:
    rows = [{"X0": 1}, {}, {"X0": 0}, {"X0": 1}]
    assert run("LD X0, INCP D0, CMPP D0 K2 M0, ALTP M5", rows, "D0 M1 M5") == [
        "1 0 1", "1 0 1", "1 0 1", "2 1 0"]


def test_comparisons_of_32_bits() -> None:
    text = "LDD> D0 K65535, OUT Y0, LD C200, ANDD= C200 K0, OUT Y1"
    assert run(text, [{"D1": 1}, {"D1": 0}], "Y0") == ["1", "0"]


def test_values_of_many_relays_are_proven_in_short_time() -> None:
    """The self-check tries 4,096 states of the relays, not all pairs of states of the two groups."""
    result = compiled("; QCPU\nLD X100\nADD K4M0 K4M20 D0\n")
    assert result.program is not None and result.timings["verify"] < 15


# ---- controllers that count and name devices otherwise

def test_lists_of_q_count_inputs_in_sixteens() -> None:
    result = compiled("LD X1A\nOR SM400\nOUT Y0F\nLD D0.A\nOUT B1F\n")
    variables = [v for section in result.project.files[0].pous[0].var_blocks for v in section.variables]
    assert [(v.name, v.location) for v in variables] == [
        ("B1F", None), ("D0", None), ("X1A", "%IX3.2"), ("YF", "%QX1.7")]
    assert [f"{d.code} {d.help}" for d in compiled("LD X8\nOUT Y0\n").diagnostics][0].endswith("`; QCPU`")
    assert compiled("; QCPU\nLD X8\nOUT Y9\n").program is not None


@pytest.mark.parametrize(("text", "given_", "watch", "result"), [
    ("+ K3 D0", {"D0": 4}, "D0", "7"), ("- D1 D0", {"D0": 4, "D1": 6}, "D0", "-2"),
    ("+ D0 D1 D2", {"D0": 4, "D1": 6}, "D2", "10"), ("D- D0 K1 D2", {"D0": 0, "D1": 1}, "D2 D3", "-1 0"),
    ("* D0 D1 D2", {"D0": 300, "D1": 300}, "D2 D3", "24464 1"), ("/ D0 K7 D2", {"D0": 30}, "D2 D3", "4 2"),
    ("WAND H0F D0", {"D0": 0x3C}, "D0", "12"), ("XCH D0 D1", {"D0": 1, "D1": 2}, "D0 D1", "2 1"),
    ("BCD D0 D1", {"D0": 1234}, "D1", str(0x1234)), ("BIN D1 D0", {"D1": 0x1234}, "D0", "1234"),
    ("MOV K2M0 D0", {"M0": True, "M3": True, "M7": True}, "D0", "137"),
    ("MOV D0 K1M4", {"D0": 0b10110}, "M4 M5 M6 M7", "0 1 1 0"),
    ("MOV K1M0 K1M1", {"M0": True, "M2": True}, "M1 M2 M3 M4", "1 0 1 0"),
    ("MOV K1M1 K1M0", {"M1": True, "M4": True}, "M0 M1 M2 M3 M4", "1 0 0 1 1"),
    ("MOV K1M0 K2M4", {"M3": True, "M8": True}, "M4 M7 M8 M11", "0 1 0 0"),
    ("MOV K3M0 D0", {"M11": True, "M0": True}, "D0", "2049"),
    ("CML K1M0 K2M4", {"M0": True}, "M4 M5 M7 M8 M11", "0 1 1 1 1"),
    ("MOV K4M0 D0", {"M15": True, "M1": True}, "D0", "-32766"),
    ("BIN K4M0 D0", {"M12": True, "M1": True}, "D0", "1002"),
    ("DMOV K5M0 D0", {"M19": True, "M1": True}, "D0 D1", "2 8"),
    ("DMOV K8M0 D0", {"M31": True, "M0": True}, "D0 D1", "1 -32768"),
    ("SET D0.3", {"D0": 1}, "D0", "9"), ("RST D0.0", {"D0": 9}, "D0", "8"), ("OUT D0.F", {}, "D0", "-32768"),
    ("FF M0", {"M0": True}, "M0", "0"), ("MOVP D0.5 D1", {}, "", None),
])
def test_data_instructions_of_q(text: str, given_: dict, watch: str, result: str | None) -> None:
    text = f"; QCPU, LD SM402, {text}"
    if result is None:
        assert errors(listing(text)) == ["LD0151 MELSEC: `D0.5` is not supported"]
    else:
        assert run(text, [given_], watch) == [result]


def test_bits_of_registers_are_contacts_and_coils() -> None:
    text = "; QCPU, LD D0.1, ANI D0.2, OUT M0, LD M1, OUT D1.0"
    assert run(text, [{"D0": 2}, {"D0": 6, "M1": True}, {"D0": 2, "M1": False}], "M0 D1") == [
        "1 0", "0 1", "1 0"]


def test_the_instruction_tells_the_unit_of_a_timer_of_q() -> None:
    text = "LD X0, OUTH T250 K2, OUT T1 K1, OUT ST0 K1, LD T250, OUT Y0"
    rows = [{"X0": True}] + [{}] * 11
    found = run(text, rows, "Y0 T1.Q ST0.V")
    assert found[1] == "0 0 0" and found[2] == "1 0 0" and found[9] == "1 0 0" and found[10] == "1 1 1"


def test_clocks_of_q_begin_off() -> None:
    found = run("LD SM410, OUT Y0, LDI SM403, OUT Y1, LDI SM401, OUT Y2", [{}] * 11, "Y0 Y1 Y2")
    assert [line[0] for line in found] == list("00000111110")
    assert [line[2:] for line in found] == ["1 1"] + ["0 1"] * 10


# ---- tables of GX Works

def table(
    *rows: str, gap: str = "\t", head: str = "PLC Information:", cpu: str = "QCPU (Q mode) Q03UDV"
) -> str:
    """`OUT T0 K5` as a row and one for each further operand; `> words` as a statement."""
    lines = ['"MAIN"', f'"{head}"{gap}"{cpu}"', gap.join(f'"{c}"' for c in (
        "Step No.", "Line Statement", "Instruction", "I/O(Device)", "Blank", "PI Statement", "Note"))]
    for step, row in enumerate(rows):
        word, *operands = ("", "") if row.startswith(">") else row.split()
        statement = row if row.startswith(">") else ""
        cells = [(str(step), statement, word, operands[0] if operands else "", "", "", "")]
        cells += [("", "", "", operand, "", "", "") for operand in operands[1:]]
        lines += [gap.join(f'"{cell}"' for cell in found) for found in cells]
    return "\n".join(lines) + "\n"


PLANT = table("> *Start", "LD X1A", "OUT T0 K5", ">> Count", "LDD>= D0 K70000", "ANI SM401", "OUT Y10", "END")


@pytest.mark.parametrize("data", [
    PLANT.encode(), b"\xff\xfe" + PLANT.replace("\n", "\r\n").encode("utf-16-le"),
    PLANT.replace("\t", ",").encode(), PLANT.replace('"', "").encode(),
    PLANT.replace("Step No.", "ステップ番号").replace("PLC Information:", "機種情報").encode("cp932"),
])
def test_tables_in_every_form(data: bytes, tmp_path: Path) -> None:
    (tmp_path / "plant.csv").write_bytes(data)
    result = compile_paths([str(tmp_path / "plant.csv")])
    assert result.program is not None, said(result)
    (pou, *_) = result.project.files[0].pous
    assert (pou.name, pou.title) == ("plant", "MAIN")
    assert [(r.title, " ".join(rung_text(r).split()).partition("[")[2]) for r in pou.body.rungs] == [
        ("Start", "X1A] <T0: FX_TIMER(K := 5, UNIT := 100) out=_>"),
        ("Count", "FX_LONG(D0, D1) >= 70000] [TRUE] (Y10)")]


def test_a_table_of_fx_and_what_is_wrong_in_one() -> None:
    result = compiled(table("LD X10", "OUT Y17", cpu="FXCPU FX3U/FX3UC"), "plant.csv")
    sections = result.project.files[0].pous[0].var_blocks
    assert [v.location for section in sections for v in section.variables] == [
        "%IX1.0", "%QX1.7"]
    lines = table("LD X0", "OUT Y0").splitlines(keepends=True)
    text = "".join([*lines[:3], lines[3], lines[4].replace('"OUT"', '"OUR"'), '""\t""\t""\t"K5"\n'])
    assert errors(text) == ["LD0151 MELSEC: the instruction OUR is not supported"]
    assert errors("".join([*lines[:3], '""\t"x"\t""\t"K5"\t\t\t\n', *lines[3:]])) == []
    assert errors("".join([*lines, '"9"\t"x"\t""\t"K5"\t\t\t\n'])) == [
        "LD0150 MELSEC: `K5` belongs to no instruction"]


def test_several_lists_share_their_devices() -> None:
    first = table("LD X0", "OUT T0 K1", "LD M1", "OUT Y0")
    second = table("LD T0", "OUT M1", "RST X1", "MOV K1 R0")
    files = SourceFile("a.csv", first), SourceFile("b.csv", second)
    result = compile_project(Sources(files, Settings(), None))
    assert said(result) == []
    machine = Machine(result.program)
    machine.set("X0", True)
    for _ in range(12):
        machine.scan()
    assert machine.get("Y0") and machine.get("R0") == 1
    (shared, kept) = result.project.files[0].globals
    assert [v.name for v in shared.variables] == ["M1", "T0", "X0", "Y0", "X1"]
    assert kept.qualifiers == ("RETAIN",)


# ---- broken lists

@pytest.mark.parametrize(("text", "message"), [
    ("LD X0, AND X8, OUT Y0", "LD0150 MELSEC: `X8` is no device with a contact"),
    ("LD X0, LD X1, OUT Y0", "LD0150 MELSEC: a block that LD begins is not joined"),
    ("LD X0, MPS, OUT Y0, LD X1, OUT Y1", "LD0150 MELSEC: MPS without MPP"),
    ("LD X0, MPP, OUT Y0", "LD0150 MELSEC: MPP without MPS before it"),
    ("NOP, OUT Y0", "LD0150 MELSEC: OUT stands before any LD"),
    ("LD X0, AND X1", "LD0150 MELSEC: a rung without an output"),
    ("LD X0, OUT T0", "LD0150 MELSEC: OUT T0 has no preset"),
    ("LD X0, OUT Y0 Y1 Y2", "LD0150 MELSEC: OUT has 1 or 2 operands, here are 3"),
    ("LD X0, OUT Y0, OR X1, OUT Y1", "LD0151 MELSEC: OR behind an output is not supported"),
    ("LD X0, SFTL M0 M1 K3 K1", "LD0151 MELSEC: the instruction SFTL is not supported"),
    ("LD X0, STL S0", "LD0151 MELSEC: the instruction STL is not supported"),
    ("LD X0, MOV D0Z1 D0", "LD0151 MELSEC: `D0Z1` is not supported"),
    ("LD X0, MOV K8M0 D0", "LD0150 MELSEC: K8M0 has more than 16 bits"),
    ("LD X0, MOV D0 K3", "LD0150 MELSEC: `K3` cannot be written"),
    ("LD X0, OUTH M0", "LD0150 MELSEC: OUTH has 2 operands, here are 1"),
    ("LDP D0.5, OUT M0, OUTH T0 K1", "LD0151 MELSEC: the edge of D0.5 is not supported"),
    ("; FX3U, LD X0, OUT B0", "LD0150 MELSEC: FX has no device `B0`"),
    ("LD X0, + D0", "LD0150 MELSEC: + has 2 or 3 operands, here are 1"),
    ("LD M8046, OUT Y0", "LD0151 MELSEC: the special device M8046 is not supported"),
    ("LD C235, OUT Y0", "LD0151 MELSEC: the high-speed counter C235 is not supported"),
    ("LD X0, CJ P1, OUT Y0, P1, LD X1, OUT Y1", "LD0151 MELSEC: OUT behind a jump is not supported"),
    ("LD X0, OUT M8002", "LD0150 MELSEC: M8002 is written by the controller alone"),
    ("LD X0, MOV K70000 D0", "LD0150 MELSEC: K70000 has more than 16 bits"),
    ("LD X0, OUT Y0, FEND, P1, LD X0, OUT Y1", "LD0151 MELSEC: what stands behind FEND is not supported"),
    ("LD X0, OUT Y0, 5 & 3", "LD0150 MELSEC: this is no instruction"),
    ("LD X0, ZRST M9 M3", "LD0150 MELSEC: M9 to M3 is no range of at most 1024 devices"),
    ("LD X0, BMOV D0 D5 D9", "LD0151 MELSEC: `D9` as a number of devices is not supported"),
    ("LD X0, MC N0 M1, LD X1, OUT M8000", "LD0150 MELSEC: M8000 is written by the controller alone"),
    ("P1, LD X0, OUT Y0, P1, LD X1, OUT Y1", "LD0150 MELSEC: the label P1 stands here a second time"),
])
def test_what_is_wrong_is_told_once(text: str, message: str) -> None:
    assert errors(listing(text)) == [message]


def test_ever_deeper_circuits_are_bounded() -> None:
    assert errors("LD X0\nOUT Y0\n" + "AND X1\nOUT Y1\n" * 100) == [
        "LD0153 MELSEC: more than 40 circuits in one another"]
    assert errors("LD X0\n" + "AND X1\nOR X2\n" * 5000 + "OUT Y0\n") == [
        "LD0153 MELSEC: more than 40 circuits in one another"]


def test_long_lists_take_linear_time() -> None:
    def seconds(count: int) -> float:
        text = "LD X0\nOR Y0\nANI X1\nOUT Y0\nLD X2\nOUT T0 K5\nLDP T0\nPLS M0\nMOVP K1 D0\n" * count
        found = parse_file(SourceFile("list.il", text), Diagnostics())
        assert len(found.pous[0].body.rungs) == 3 * count
        return growth.seconds(lambda: parse_file(SourceFile("list.il", text), Diagnostics()))

    assert seconds(4000) < 12 * seconds(800)


def test_iec_lists_are_none_of_these() -> None:
    text = "PROGRAM p VAR X0 AT %IX0.0, X1 : BOOL; END_VAR\nLD X0\nST X1\nEND_PROGRAM"
    assert all("MELSEC" not in line for line in said(compiled(text)))


WORDS = st.sampled_from((
    "LD X0", "LDI X1", "AND X2", "OR M0", "ANB", "ORB", "MPS", "MRD", "MPP", "INV", "MEP", "OUT Y0", "SET M1",
    "OUT T0 K5", "OUT C0 K2", "RST C0", "MOV K1 D0", "DDIVP D0 D2 D4", "CMP D0 D1 M5", "CJ P1", "P1",
    "MC N0 M9", "MCR N0", "END", "LD= D0 K5", "FEND", "OUT", "AND", "; words", "K1M0 X", "ZRST C0 C3",
    "LDP M8002"))


@settings(max_examples=80, deadline=None)
@given(st.lists(WORDS, max_size=25))
def test_no_list_raises(lines: list[str]) -> None:
    result = compiled("LD X0\n" + "\n".join(lines))
    assert (result.program is None) == any(d.severity.value == "error" for d in result.diagnostics)


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_lists_mean_what_a_stack_machine_does(data: st.DataObject) -> None:
    """Contacts and blocks at random against the accumulator and the stack of a controller."""
    lines, depth = ["LD X0"], 1
    for _ in range(data.draw(st.integers(0, 12))):
        word = data.draw(st.sampled_from(["LD", "LDI", "AND", "ANI", "OR", "ORI", "ANB", "ORB", "INV"]))
        if word in ("ANB", "ORB"):
            if depth == 1:
                continue
            depth -= 1
        elif word in ("LD", "LDI"):
            depth += 1
        device = "" if word in ("ANB", "ORB", "INV") else f" X{data.draw(st.integers(0, 3))}"
        lines.append(word + device)
    lines += ["ORB"] * (depth - 1) + ["OUT Y0"]
    used = sorted({line.split()[1] for line in lines if " X" in line})
    rows = [{name: i >> n & 1 for n, name in enumerate(used)} for i in range(1 << len(used))]

    def model(row: dict) -> bool:
        stack: list[bool] = []
        for line in lines:
            word, _, device = line.partition(" ")
            value = bool(row.get(device)) != word.endswith("I")
            if word in ("LD", "LDI"):
                stack.append(value)
            elif word in ("ANB", "AND", "ANI"):
                value = stack.pop() if word == "ANB" else value
                stack[-1] = stack[-1] and value
            elif word in ("ORB", "OR", "ORI"):
                value = stack.pop() if word == "ORB" else value
                stack[-1] = stack[-1] or value
            elif word == "INV":
                stack[-1] = not stack[-1]
        return stack[-1]

    assert run(",".join(lines), rows, "Y0") == [str(int(model(row))) for row in rows]


def test_files_of_others() -> None:
    files = sorted(FOLDER.rglob("*.il"))
    if not files:
        pytest.skip(f"no collection in {FOLDER.name}")
    for path in files:
        result = compile_paths([str(path)])
        assert result.program is not None, (path, said(result))
        Machine(result.program).scan()
