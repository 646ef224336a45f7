"""Firmware: one program, one trace, on the virtual machine, as native code and on Cortex-M in QEMU."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from ldc import pipeline
from ldc.backends.firmware import board, qemu
from ldc.cli import firmware
from ldc.cli.main import main
from ldc.components import toolchain
from ldc.diagnostics import Diagnostics
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from runtime.stimuli import Stimuli

SAMPLES = sorted(p.parent for p in (Path(__file__).parents[1] / "samples").glob("*/ldc.toml")
                 if "[plant]" not in p.read_text())
TOOLS = toolchain.GCC, toolchain.ARM_GCC, toolchain.QEMU_ARM
MISSING = ", ".join(tool.command for tool in TOOLS if toolchain.find(tool) is None)
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"{MISSING} not installed: script/bootstrap --with-arm")
TRAILER = re.compile(r"^\d+ scans?.* of virtual time\n", re.MULTILINE)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture):
    """``run(arguments)``: exit status, trace and what was said, of ``ldc run``."""
    monkeypatch.chdir(tmp_path)

    def go(*arguments: str) -> tuple[int, str, str]:
        trace = tmp_path / "trace.csv"
        trace.unlink(missing_ok=True)
        status = main(["run", *arguments, "--trace", str(trace)])
        return status, trace.read_text() if trace.exists() else "", TRAILER.sub("", capsys.readouterr().err)

    return go


def written(text: str, inputs: str = "") -> str:
    Path("main.ld").write_text(text)
    Path("in.csv").write_text(inputs)
    return "main.ld"


@pytest.mark.parametrize("folder", SAMPLES, ids=lambda p: p.name)
def test_every_sample_does_the_same_on_every_engine(folder: Path, run) -> None:
    expected = 0, (folder / "expected.csv").read_text(), ""
    for engine in (("--engine", "vm"), ("--engine", "native"), ("--target", "cortex-m3")):
        assert run(str(folder), *engine) == expected, engine


def test_a_component_of_a_slave_runs_there_and_does_the_same(run, tmp_path: Path, capsys) -> None:
    folder = SAMPLES[0].parent / "two_cores"
    expected = (folder / "expected.csv").read_text()
    for _ in range(3):
        assert run(str(folder), "--target", "cortex-m33") == (0, expected, "")
    assert main(["build", str(folder), "--target", "cortex-m33", "-o", "out"]) == 0
    master, slave = capsys.readouterr().out.split("\n\n")
    assert "PROGRAM feeder" in master and "PROGRAM" not in slave and "FUNCTION_BLOCK SLIDE" in slave
    maps = [(tmp_path / "out" / name).read_text() for name in ("two_cores.map", "slave1/two_cores.map")]
    assert "sqrtf" not in maps[0] and "sqrtf" in maps[1]


def changed_slide(statement: str) -> str:
    """The sample with two processors, with one more statement in its component."""
    shutil.copytree(SAMPLES[0].parent / "two_cores", "plant")
    source = Path("plant/slide.c")
    before = "    float wanted = 0.0f;\n"
    source.write_text(source.read_text().replace(before, f"{before}{statement}\n"))
    return "plant"


def test_a_slave_that_hangs_is_an_error_of_the_component(run) -> None:
    """The master goes on; what the component gave before stays."""
    source = changed_slide("    while (in->enable && out->position > 0.5f) { }")
    watched = "--scans", "5", "--watch", "slide.position,slide.error"
    status, trace, said = run(source, "--target", "cortex-m33", *watched)
    assert (status, said) == (0, "")
    assert trace.splitlines()[3:] == ["2,20,0.59999996,0", "3,30,0.59999996,10", "4,40,0.59999996,10"]


def test_a_fault_of_the_processor_is_told_with_the_line_of_the_component(run) -> None:
    statement = "    wanted = *(volatile float *)((const char *)in + (in->enable ? 0x60000000 : 0));"
    source = changed_slide(statement)
    line = Path("plant/slide.c").read_text().splitlines().index(statement) + 1
    for target in ("cortex-m3", "cortex-m33"):
        status, trace, said = run(source, "--target", target)
        assert (status, trace) == (1, "")
        assert re.search(rf"error\[LD0644\]: .*/slide\.c:{line}: access to memory that is not there", said), said


@pytest.mark.parametrize("name", sorted(board.known()))
def test_every_board_runs(name: str, run) -> None:
    folder = SAMPLES[0].parent / "pump_station"
    found = run(str(folder), "--target", board.known()[name].target, "--board", name)
    assert found == (0, (folder / "expected.csv").read_text(), "")


FAULTS = """
PROGRAM main
VAR
    go AT %IX0.0 : BOOL;
    which AT %IW2 : INT;
    lamp AT %QX0.0 : BOOL;
    level AT %QW2 : INT := 5;
    divisor : DINT;
    few : ARRAY [1..3] OF INT;
    deep : inner;
    text : STRING[20];
END_VAR
RUNG count <ADD(IN1 := level, IN2 := 1, OUT => level)> (lamp)
RUNG divide [go] [which = 1] [7 / divisor > 2] (S lamp)
RUNG index [go] [which = 2] [few[which + 3] > 2] (S lamp)
RUNG again [go] [which = 3] >>count
RUNG inside [go] [which = 4] <deep: inner(n := divisor)>
RUNG tell <CONCAT(IN1 := text, IN2 := 'ab', OUT => text)>
END_PROGRAM

FUNCTION_BLOCK inner
VAR_INPUT enable : BOOL; n : DINT; END_VAR
VAR_OUTPUT q : BOOL; END_VAR
RUNG divide [enable] [1 / n = 1] (q)
END_FUNCTION_BLOCK
"""


@pytest.mark.parametrize("which", (1, 2, 3, 4))
def test_faults_stop_a_task_at_the_same_place(which: int, run) -> None:
    """With the rung and its line, the calls that led there, and outputs at their safe values."""
    source = written(FAULTS, f"scan,go,which\n3,1,{which}\n")
    options = "--inputs", "in.csv", "--scans", "6", "--watch", "lamp,level,text,deep.q"
    expected = run(source, *options)
    assert expected[0] == 1 and "error[LD080" in expected[2]
    assert run(source, *options, "--target", "cortex-m3") == expected


TASKS = """
PROGRAM fast
VAR_EXTERNAL trigger : BOOL; END_VAR
VAR n : INT; late : TON; pulse AT %QX1.1 : BOOL; END_VAR
RUNG <ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG [trigger] <late: TON(PT := T#25ms)> (pulse)
END_PROGRAM
PROGRAM slow
VAR n : INT; wrong : BOOL; crash AT %IX0.7 : BOOL; END_VAR
VAR out AT %QW2 : INT; END_VAR
RUNG <ADD(IN1 := n, IN2 := 1, OUT => n)> <MOVE(IN := n, OUT => out)>
RUNG [crash] [1 / (n - n) > 0] (wrong)
END_PROGRAM
PROGRAM once
VAR n : INT; END_VAR
RUNG <ADD(IN1 := n, IN2 := 1, OUT => n)>
END_PROGRAM
CONFIGURATION plant
VAR_GLOBAL trigger AT %IX0.0 : BOOL; END_VAR
RESOURCE master ON master
TASK quick (INTERVAL := T#5ms, PRIORITY := 1);
TASK lazy (INTERVAL := T#15ms, PRIORITY := 2);
TASK event (SINGLE := trigger, PRIORITY := 0);
PROGRAM a WITH quick : fast;
PROGRAM b WITH lazy : slow;
PROGRAM c WITH event : once;
PROGRAM d WITH quick : once;
END_RESOURCE
END_CONFIGURATION
"""


def test_tasks_go_by_interval_priority_and_event(run) -> None:
    rows = "".join(f"{scan},{scan % 5 > 1:d},{scan == 21:d}\n" for scan in range(24))
    source = written(TASKS, "scan,trigger,b.crash\n" + rows)
    options = "--inputs", "in.csv", "--scans", "30", "--watch", "a.n,b.n,c.n,d.n,a.late.ET,a.pulse,b.out"
    expected = run(source, *options)
    assert expected[0] == 1 and "LD0801" in expected[2]
    assert run(source, *options, "--target", "cortex-m3", "--board", "lm3s6965evb") == expected


VALUES = """
PROGRAM main
VAR
    bits AT %IB4 : BYTE;
    bit AT %IX4.3 : BOOL;
    r : REAL := 0.1; l : LREAL := 1.5; t : TIME := T#1s; s : STRING[30] := 'start'; w : WSTRING[9];
    i : LINT := 9223372036854775807; u : USINT; e : (red, green, blue) := green;
    text : STRING[40]; again : REAL; big AT %ML3 : LWORD; odd AT %QW5 : INT;
END_VAR
RUNG <MUL(IN1 := r, IN2 := 1.1, OUT => r)> <SQRT(IN := l, OUT => l)>
RUNG <ADD(IN1 := i, IN2 := 1, OUT => i)> <SUB(IN1 := u, IN2 := 1, OUT => u)>
RUNG <REAL_TO_STRING(IN := r, OUT => text)> <STRING_TO_REAL(IN := text, OUT => again)>
RUNG <CONCAT(IN1 := s, IN2 := 'x', OUT => s)> <MULTIME(IN1 := t, IN2 := r, OUT => t)>
RUNG [bit] <ROL(IN := big, N := 3, OUT => big)> <REAL_TO_INT(IN := r, OUT => odd)>
END_PROGRAM
"""


@pytest.mark.parametrize("target", board.TARGETS)
def test_values_of_all_kinds_go_in_and_come_out(target: str, run) -> None:
    source = written(VALUES, "scan,bits,s,r,w,e,big,t\n1,8,,2.5,hi,blue,16#8000000000000001,\n"
                     "4,255,a longer text than before,-1e30,,red,,T#5s\n7,0,,1e-40,,,,\n")
    names = "bits,bit,r,l,t,s,w,i,u,e,text,again,big,odd"
    expected = run(source, "--inputs", "in.csv", "--scans", "12", "--watch", names)
    assert expected[0] == 0
    found = run(source, "--inputs", "in.csv", "--scans", "12", "--watch", names, "--target", target)
    assert found == expected


BOARD = """
target = "cortex-m3"
cpu = ["-mcpu=cortex-m3", "-mthumb"]
clock_hz = 25_000_000
flash = { base = 0, size = 0x10_0000 }
ram = { base = 0x2000_0000, size = 0x1_0000 }
uart = { kind = "cmsdk", base = 0x4000_4000 }
sources = ["io.c"]
"""
IO = """
#include "places.h"
void ldc_board_inputs(uint8_t *memory);
void ldc_board_outputs(const uint8_t *memory);
static uint32_t scans;
void ldc_board_inputs(uint8_t *memory) { ldc_set_IX0_0(memory, scans++ == 2); }
void ldc_board_outputs(const uint8_t *memory) {
    ldc_puts(ldc_get_QX0_0(memory) ? "1" : "0");
    if (scans < 6) return;
    ldc_puts("\\n");
    __asm__ volatile("mov r0, #0x18\\nldr r1, =0x20026\\nbkpt 0xAB");
}
"""


def test_a_board_of_a_user_scans_in_real_time(tmp_path: Path, monkeypatch, capsys) -> None:
    """SysTick tells when; its own C reads inputs and sets outputs."""
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(BOARD)
    Path("io.c").write_text(IO)
    sample = str(SAMPLES[0].parent / "start_stop")
    assert main(["build", sample, "--target", "cortex-m3", "--board", "mine.toml", "-o", "out"]) == 0
    command = qemu.command(toolchain.find(toolchain.QEMU_ARM), board.known()["mps2-an385"])
    done = subprocess.run([*command, "-kernel", "out/start_stop.elf"], capture_output=True, text=True,
                          timeout=30, check=True, stdin=subprocess.DEVNULL)
    assert done.stdout == "001111\n"
    capsys.readouterr()
    assert main(["run", sample, "--target", "cortex-m3", "--board", "mine.toml"]) == 2
    assert "QEMU has no machine for board `mine`" in capsys.readouterr().err


@pytest.mark.parametrize(("damage", "code"), [
    (('flash = { base = 0, size = 0x10_0000 }', ''), "LD0640"), (('"cortex-m3"', '"cortex-m4"'), "LD0640"),
    (("clock_hz = 25", "clock = 25"), "LD0611"), (("clock_hz = 25_000_000", "clock_hz ="), "LD06"),
    (('["-mcpu=cortex-m3", ', '["-ofile", '), "LD06"),
    (("size = 0x10_0000", "size = 0x10_0000_0000_0000"), "LD06")])
def test_a_wrong_board_file_is_told(damage, code: str, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.toml").write_text(BOARD.replace(*damage, 1))
    sample = str(SAMPLES[0].parent / "start_stop")
    assert main(["build", sample, "--target", "cortex-m3", "--board", "mine.toml"]) == 1
    assert f"[{code}" in capsys.readouterr().err


KEPT = """
PROGRAM main
VAR RETAIN total : DINT; name : STRING[9] := 'new'; wait : TON; END_VAR
VAR seen : DINT; END_VAR
RUNG <ADD(IN1 := total, IN2 := 1, OUT => total)> <ADD(IN1 := seen, IN2 := 1, OUT => seen)>
RUNG [total = 3] <MOVE(IN := 'used', OUT => name)>
RUNG [total > 0] <wait: TON(PT := T#1s)>
END_PROGRAM
"""


def test_a_restart_leaves_alone_what_is_retained(tmp_path: Path) -> None:
    result = pipeline.compile_project(Sources((SourceFile("main.ld", KEPT),), Settings(), None))
    assert not result.diagnostics.has_errors
    machine = firmware.machine(result, 0, None, None)
    on, _ = firmware.chosen("cortex-m3", "lm3s6965evb")
    made = firmware.built(firmware.planned(machine, result, on, None), tmp_path, "kept")
    names = "total", "name", "wait.ET", "seen"
    job = machine.job(9, machine.find(names), Stimuli({}), restart=5)
    trace = qemu.run(on, [made.images[0].elf], job, 60, Diagnostics())
    machine.replay(trace)
    found = []
    for _ in range(9):
        machine.scan()
        found.append(tuple(machine.get(name) for name in names))
    ms = 1_000_000
    assert found[4] == (5, "used", 40 * ms, 5)
    assert found[5] == (6, "used", 50 * ms, 1), "time goes on where it was"
    assert found[8] == (9, "used", 80 * ms, 4)


def test_a_call_executes_a_component_in_steps_of_its_period(tmp_path: Path, monkeypatch, capsys) -> None:
    """Ten of 1 ms a scan: the same way as in virtual time, bit for bit, some scans earlier."""
    shutil.copytree(SAMPLES[0].parent / "two_cores", tmp_path / "p")
    monkeypatch.chdir(tmp_path / "p")
    descriptor = Path("slide.ldc.toml")
    descriptor.write_text(descriptor.read_text().replace(
        'processor = "slave1"', 'processor = "slave1"\nperiod_us = 1000'))
    watch = ["--scans", "68", "--watch", "slide.position,slide.speed", "--trace"]
    assert main(["run", ".", *watch, "vm.csv"]) == 0
    assert main(["run", ".", "--target", "cortex-m33", *watch, "firmware.csv"]) == 0
    assert "LD1024" in capsys.readouterr().err
    there, here = ([line.split(",")[2:] for line in Path(name).read_text().splitlines()[1:]]
                   for name in ("vm.csv", "firmware.csv"))
    begins = [next(n for n, (position, _) in enumerate(rows) if position == "5.11") for rows in (there, here)]
    strokes = [rows[begin:begin + 49] for rows, begin in zip((there, here), begins, strict=True)]
    assert strokes[0] == strokes[1] and strokes[0][-1] == ["120.0", "0.0"]


def test_a_build_tells_what_is_where_and_how_large(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    folder = SAMPLES[0].parent / "pump_station"
    assert main(["build", str(folder), "--target", "cortex-m3", "-o", "out"]) == 0
    lines = [line.rsplit(maxsplit=2) for line in capsys.readouterr().out.splitlines()[1:]]
    rows = {name: (int(flash.replace(",", "")), int(ram.replace(",", ""))) for name, flash, ram in lines}
    board_size, total = rows.pop("of mps2-an385"), rows.pop("total")
    assert board_size == (4 << 20, 4 << 20)
    assert total == tuple(map(sum, zip(*rows.values())))
    assert rows["PROGRAM station"][0] > 300 < rows["PROGRAM station"][1]
    assert rows["FUNCTION_BLOCK ALARM"][0] > 50
    image = (tmp_path / "out" / "pump_station.bin").read_bytes()
    assert len(image) == total[0]
    about = json.loads((tmp_path / "out" / "firmware.json").read_text())
    begin = about["block"]["address"]
    assert 0x2000_0000 <= begin < 0x2000_0000 + total[1]
    assert all(begin <= v["address"] < begin + about["block"]["size"] for v in about["variables"].values())
    symbols = (tmp_path / "out" / "pump_station.map").read_text()
    assert f"{begin:#018x}" in symbols or f"{begin:#010x}" in symbols
