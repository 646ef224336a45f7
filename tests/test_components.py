"""Components: one behaviour in four languages, the memory that C may name, and what is told of the rest."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.cli.main import main
from ldc.components import c_source, header, host
from ldc.components.address_map import AddressMap, placed
from ldc.components.descriptor import load
from ldc.diagnostics import Diagnostics
from ldc.source import SourceFile
from ldc.types import BOOL, INT, LREAL, REAL, Array
from runtime.vm.external import MissingNative
from runtime.vm.machine import Machine
from runtime.vm.stepping import Stepper
from systems import mover

LANGUAGES = ("c", "c++", "st", "il")

DESCRIPTOR = """\
[component]
name = "PROBE"
id = "test.probe"
[requires]
inputs = [
    { name = "x", type = "REAL", min = -5.0, max = 5.0 },
    { name = "n", type = "INT", min = 0.5, max = 9.5 },
    { name = "text", type = "STRING[8]" },
    { name = "row", type = "ARRAY [1..3] OF INT" },
]
[provides]
power = "ready"
outputs = [
    { name = "ready", type = "BOOL" },
    { name = "y", type = "LREAL" },
    { name = "back", type = "STRING[8]" },
    { name = "sum", type = "DINT" },
    { name = "us", type = "UDINT" },
    { name = "class", type = "INT" },
]
[properties]
parameters = [{ name = "gain", type = "REAL", value = 2.0 }]
state = [{ name = "calls", type = "UDINT" }, { name = "last", type = "ARRAY [0..1] OF REAL" }]
[function]
language = "c"
sources = ["probe.c"]
"""

BODY = """\
#include "probe.h"
#include <math.h>
#include <string.h>

static const int16_t WEIGHTS[3] = { 1, 2, 3 };

static int16_t weighted(const int16_t *row)
{
    int16_t sum = 0;
    for (int i = 0; i < 3; i++)
        sum += WEIGHTS[i] * row[i];
    return sum;
}

void probe(const probe_in *in, probe_out *out, probe_state *state, uint32_t dt_us)
{
    state->calls++;
    state->last[1] = state->last[0];
    state->last[0] = in->x;
    out->ready = in->enable && in->n > 3;
    out->y = sqrt(fabs((double)in->x)) * in->gain;
    memcpy(out->back.text, in->text.text, in->text.length);
    out->back.length = in->text.length;
    out->sum = weighted(in->row);
    out->us = dt_us;
    out->class_ = -1;
    PLC_D(counter) += in->n;
    PLC_D(table)[2] = PLC_D(table)[0] + 1;
    PLC_M(flag) = !PLC_M(flag);
    if (PLC_D(limit) > 100)
        out->error = 99;
}
"""

MAIN = """\
VAR_GLOBAL
    counter : INT;
    table : ARRAY [0..3] OF DINT;
    flag : BOOL;
    limit : LREAL;
END_VAR
VAR_GLOBAL CONSTANT
    fixed : INT := 5;
    fixed_row : ARRAY [0..1] OF INT;
END_VAR
PROGRAM main
VAR
    go, good : BOOL;
    x : REAL;
    n : INT := 4;
    text : STRING[8] := 'abc';
    row : ARRAY [1..3] OF INT := [10, 20, 30];
    p : PROBE;
END_VAR
RUNG [go] <p: PROBE(x := x, n := n, text := text, row := row)> (good)
END_PROGRAM
"""


def project(folder: Path, body: str = BODY, descriptor: str = DESCRIPTOR, program: str = MAIN) -> Path:
    (folder / "ldc.toml").write_text('[project]\nname = "probe"\n')
    (folder / "probe.ldc.toml").write_text(descriptor)
    (folder / "probe.c").write_text(body)
    (folder / "main.ld").write_text(program)
    return folder


def machine(folder: Path, **options) -> Machine:
    result = pipeline.compile_paths([str(folder)])
    assert not result.diagnostics.has_errors, [f"{d.code} {d.message}" for d in result.diagnostics]
    diagnostics = Diagnostics()
    bindings = tuple(host.build(n, list(result.model.globals.values()), diagnostics) for n in result.natives)
    assert not diagnostics.has_errors, [d.message for d in diagnostics]
    return Machine(result.program, bindings=bindings, **options)


def findings(folder: Path) -> list[tuple[str, str, int]]:
    """Code, message and line of what is wrong."""
    result = pipeline.compile_paths([str(folder)])
    found = Diagnostics()
    for native in result.natives:
        host.build(native, list(result.model.globals.values()), found)
    return [
        (d.code, d.message, d.primary.span.position[0] if d.primary else 0)
        for bag in (result.diagnostics, found)
        for d in bag
        if d.severity == "error"
    ]


def test_what_goes_in_and_out(tmp_path: Path) -> None:
    m = machine(project(tmp_path), period_ns=2_500_000)
    m.set("go", True)
    m.set("x", 2.25)
    m.scan()
    assert not m.faults
    assert (m.get("good"), m.get("p.y"), m.get("p.back"), m.get("p.sum")) == (True, 3.0, "abc", 140)
    assert (m.get("p.us"), m.get("p.class"), m.get("p.calls"), m.get("p.error")) == (0, -1, 1, 0)
    assert (m.get("counter"), m.get("flag"), m.get("table[2]")) == (4, True, 1)
    m.set("table[0]", 41)
    m.set("x", 1.0)
    m.scan()
    assert (m.get("p.us"), m.get("counter"), m.get("flag"), m.get("table[2]")) == (2500, 8, False, 42)
    assert (m.get("p.last[0]"), m.get("p.last[1]")) == (1.0, 2.25)
    m.set("limit", 101.0)
    m.scan()
    assert m.get("p.error") == 99


def test_inputs_out_of_their_range_stop_the_body_not_the_machine(tmp_path: Path) -> None:
    m = machine(project(tmp_path))
    m.set("go", True)
    m.scan()
    for name, value, error in (("x", 5.5, 7), ("x", float("nan"), 6), ("n", 10, 7), ("n", 0, 7)):
        before = m.get("p.calls")
        m.set("x", 1.0)
        m.set("n", 4)
        m.set(name, value)
        m.scan()
        assert (m.get("p.error"), m.get("p.calls"), m.faults) == (error, before, []), (name, value)
    m.set("n", 9)
    m.scan()
    assert m.get("p.error") == 0


def test_stepping_calls_native_code_like_the_scan(tmp_path: Path) -> None:
    whole, stepped = machine(project(tmp_path)), machine(project(tmp_path))
    scan = Stepper(stepped).scan
    for number in range(6):
        for m in (whole, stepped):
            m.set("x", number * 0.5)
            m.set("go", number % 2 == 0)
        whole.scan()
        scan()
        assert whole.checksum() == stepped.checksum()


def test_instances_have_their_own_state(tmp_path: Path) -> None:
    twice = MAIN.replace("p : PROBE;", "p, q : PROBE;").replace(
        "END_PROGRAM", "RUNG [go] <q: PROBE(x := 4.0, n := 5)> (flag)\nEND_PROGRAM"
    )
    m = machine(project(tmp_path, program=twice))
    m.scan()
    m.scan()
    assert (m.get("p.calls"), m.get("q.calls"), m.get("q.last[1]"), m.get("p.last[1]")) == (2, 2, 4.0, 0.0)


@pytest.mark.parametrize(
    ("line", "code", "what"),
    [
        ("PLC_D(fixed) = 1;", "LD1017", "may not write `fixed`"),
        ("PLC_D(fixed)++;", "LD1017", "may not write `fixed`"),
        ("PLC_M(nothing) = 1;", "LD1015", "no `nothing` for PLC_M"),
        ("PLC_M(counter) = 1;", "LD1015", "no `counter` for PLC_M"),
        ("out->sum = PLC_D(COUNTER);", "LD1015", "no `COUNTER`"),
        ("out->sum = PLC_D(counter, 1);", "LD1016", "one symbol"),
        ("static int kept;", "LD1013", "`kept`"),
        ("*(int *)0x2000 = 1;", "LD1014", "0x2000"),
        ("*(int *)(0x2000 + 4 * 2) = 1;", "LD1014", "0x2000"),
        ("int *p = (int *)(8192 << 2); *p = 1;", "LD1014", "8192"),
        ("int *p = 4096; *p = 1;", "LD1014", "4096"),
        ("int y = 1 +;", "LD1011", "expected expression"),
        ("switch (dt_us) { case 1 ... 5: break; }", "LD1012", "cannot be read"),
        ("PLC_D(fixed_row)[1] = 1;", "LD1017", "fixed_row"),
        ("out->nothing = 1;", "LD1011", "nothing"),
        ("nothing();", "LD1011", "nothing"),
        ("int16_t *p = &PLC_D(fixed); *p = 1;", "LD1011", "const"),
        ("#include <stdio.h>", "LD1011", "stdio.h"),
        ("#error no", "LD1011", "no"),
    ],
)
def test_what_a_component_may_not_do(tmp_path: Path, line: str, code: str, what: str) -> None:
    body = BODY.replace(
        "    state->calls++;\n",
        f"    state->calls++;\n    {line}\n" if line[0] != "#" else f"    state->calls++;\n{line}\n",
    )
    found = findings(project(tmp_path, body))
    assert found, line
    assert {c for c, _, _ in found} == {code}
    assert what in found[0][1]
    assert found[0][2] in (17, 18), "the line that the author wrote"


def test_zero_is_no_raw_address_and_const_data_may_be_kept(tmp_path: Path) -> None:
    body = BODY.replace(
        "    state->calls++;\n",
        "    state->calls++;\n    const char *s = (const char *)0;\n"
        '    if (s) out->error = 1;\n    static const char NAME[] = "abc";\n    (void)NAME;\n',
    )
    assert findings(project(tmp_path, body)) == []


@pytest.mark.parametrize(
    ("line", "code"),
    [
        ("PLC_D(fixed) = 1;", "LD1017"),
        ("PLC_M(nothing) = true;", "LD1015"),
        ("static int kept = 1; kept++;", "LD1013"),
        ("*reinterpret_cast<int *>(0x2000) = 1;", "LD1014"),
        ("*(int *)0x2000 = 1;", "LD1014"),
        ("nothing();", "LD1011"),
    ],
)
def test_cpp_is_held_to_the_same(tmp_path: Path, line: str, code: str) -> None:
    descriptor = DESCRIPTOR.replace('"c"', '"c++"').replace("probe.c", "probe.cpp")
    project(tmp_path, descriptor=descriptor)
    (tmp_path / "probe.cpp").write_text(
        BODY.replace("    state->calls++;\n", f"    state->calls++;\n    {line}\n")
    )
    found = findings(tmp_path)
    assert {c for c, _, _ in found} == {code}, found
    assert found[0][2] == 18


def test_cpp_does_what_c_does(tmp_path: Path) -> None:
    (tmp_path / "c").mkdir()
    (tmp_path / "cpp").mkdir()
    one = machine(project(tmp_path / "c"))
    other_folder = project(
        tmp_path / "cpp", descriptor=DESCRIPTOR.replace('"c"', '"c++"').replace('.c"', '.cpp"')
    )
    (other_folder / "probe.c").rename(other_folder / "probe.cpp")
    other = machine(other_folder)
    for number in range(8):
        for m in (one, other):
            m.set("go", number % 3 > 0)
            m.set("x", number - 3.5)
            m.set("table[0]", number)
            m.scan()
        assert one.checksum() == other.checksum()


def test_templates_are_one_component_in_four_languages(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    names = {language: f"ramp_{number}" for number, language in enumerate(LANGUAGES)}
    for language, name in names.items():
        assert main(["component", "new", name, "--language", language]) == 0
    assert main(["component", "check"]) == 0
    assert "checked 4 components" in capsys.readouterr().err
    declared = " ".join(f"r{k} : RAMP_{k};" for k in range(4))
    rungs = "\n".join(f"RUNG [go] <r{k}: RAMP_{k}(target := target)>" for k in range(4))
    (tmp_path / "main.ld").write_text(
        f"PROGRAM main\nVAR go : BOOL; target : REAL; {declared} END_VAR\n{rungs}\nEND_PROGRAM\n"
    )
    (tmp_path / "ldc.toml").write_text("")
    m = machine(tmp_path)
    for number in range(60):
        m.set("go", number % 40 < 25)
        m.set("target", 12.25 if number < 20 else -7.5)
        m.scan()
        assert m.get("r0.value") == m.get("r1.value") == m.get("r2.value") == m.get("r3.value"), number
    assert m.get("r0.value") != 0


def test_the_header_compiles_alone_for_a_unit_test(tmp_path: Path, monkeypatch) -> None:
    project(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["component", "header", "probe.ldc.toml", "-o", "probe.h"]) == 0
    (tmp_path / "unit_test.c").write_text("""\
#include "probe.h"
#include <string.h>
int16_t ldc_plc_d_counter; int32_t ldc_plc_d_table[4]; bool ldc_plc_m_flag; double ldc_plc_d_limit;
int main(void)
{
    probe_in in; probe_out out; probe_state state;
    memset(&in, 0, sizeof in); memset(&out, 0, sizeof out); memset(&state, 0, sizeof state);
    in.n = 6; in.x = 4; in.gain = 2;
    probe(&in, &out, &state, 1000);
    return !(out.y == 4 && ldc_plc_d_counter == 6 && ldc_plc_m_flag && out.us == 1000);
}
""")
    gcc = shutil.which("gcc")
    subprocess.run([gcc, "-Wall", "-o", "unit_test", "unit_test.c", "probe.c", "-lm"], check=True)
    subprocess.run(["./unit_test"], check=True)


def test_native_code_that_nobody_built_is_told(tmp_path: Path) -> None:
    result = pipeline.compile_paths([str(project(tmp_path))])
    with pytest.raises(MissingNative, match="test.probe"):
        Machine(result.program)


def test_the_digest_tells_whether_a_source_changed(tmp_path: Path) -> None:
    project(tmp_path)
    first = pipeline.compile_paths([str(tmp_path)]).image.digest
    assert pipeline.compile_paths([str(tmp_path)]).image.digest == first
    (tmp_path / "probe.c").write_text(BODY.replace("99", "98"))
    assert pipeline.compile_paths([str(tmp_path)]).image.digest != first


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_no_broken_descriptor_ends_in_a_traceback(data) -> None:
    text = DESCRIPTOR
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        end = data.draw(st.integers(start, min(len(text), start + 12)))
        text = text[:start] + data.draw(st.text("abc\"'{}[]=,.#\n 01_-", max_size=6)) + text[end:]
    diagnostics = Diagnostics()
    made = load(SourceFile("x.ldc.toml", text), Path("."), diagnostics)
    assert (made is None) == diagnostics.has_errors


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("for (;;) state->calls++;", "does not end"),
        ("*(volatile int *)(intptr_t)state->calls = 1;", "memory that is not there"),
        ("__builtin_trap();", "no instruction"),
        ("state->calls = 100 / (state->calls - 1);", "divides by zero"),
    ],
)
def test_a_component_that_breaks_is_told_with_its_line(tmp_path: Path, capfd, line: str, words: str) -> None:
    project(tmp_path, BODY.replace("    state->last[1]", f"    {line}\n    state->last[1]"))
    assert main(["run", str(tmp_path), "--scans", "4", "--watch", "p.calls"]) == 1
    said = capfd.readouterr().err
    assert "error[LD0805]: component PROBE" in said and words in said
    assert "probe.c:18:" in said, said


def test_a_copy_of_a_project_is_sanitized_for_itself(tmp_path: Path, monkeypatch, capfd) -> None:
    """What is compiled has paths in it, by which findings are told."""
    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        project(tmp_path / name, BODY.replace("    state->last[1]", "    state->last[state->calls * 1000] = 1;\n"
                                              "    state->last[1]"))
        monkeypatch.chdir(tmp_path / name)
        assert main(["run", ".", "--scans", "4", "--sanitize"]) == 1
        said = capfd.readouterr().err
        assert "error[LD0806]: component PROBE" in said and "probe.c:18:" in said, said


def test_a_sanitizer_may_take_its_time(tmp_path: Path, capfd) -> None:
    """On a busy computer it looks for lines for seconds: taken for a hang, its finding lost the place."""
    slow = "    if (state->calls == 2)\n        sleep(3);\n    state->last[1]"
    body = BODY.replace("static int16_t weighted", "unsigned sleep(unsigned);\n\nstatic int16_t weighted")
    project(tmp_path, body.replace("    state->last[1]", slow))
    assert main(["run", str(tmp_path), "--scans", "4", "--sanitize"]) == 0, capfd.readouterr().err


def test_a_run_with_components_prints_what_a_run_prints(tmp_path: Path, capfd) -> None:
    project(tmp_path)
    trace = tmp_path / "trace.csv"
    assert main(["run", str(tmp_path), "--scans", "3", "--watch", "p.calls", "--trace", "-"]) == 0
    assert capfd.readouterr().out == "scan,t_ms,p.calls\n0,0,1\n1,10,2\n2,20,3\n"
    assert main(["run", str(tmp_path), "--scans", "3", "--watch", "p.calls", "--trace", str(trace)]) == 0
    assert trace.read_text().endswith("2,20,3\n")
    assert main(["run", str(tmp_path), "--watch", "nothing"]) == 2


def test_no_trace_is_left_half_written_by_a_crash(tmp_path: Path, capfd) -> None:
    project(
        tmp_path,
        BODY.replace(
            "    state->last[1]", "    if (state->calls == 3) __builtin_trap();\n    state->last[1]"
        ),
    )
    before = sorted(path.name for path in tmp_path.iterdir())
    assert (
        main(
            [
                "run",
                str(tmp_path),
                "--scans",
                "9",
                "--watch",
                "p.calls",
                "--trace",
                str(tmp_path / "trace.csv"),
            ]
        )
        == 1
    )
    assert sorted(path.name for path in tmp_path.iterdir()) == before


def test_a_component_on_a_slave_does_not_reach_the_memory_of_the_master(tmp_path: Path) -> None:
    descriptor = DESCRIPTOR.replace('language = "c"', 'language = "c"\nprocessor = "slave2"')
    found = findings(project(tmp_path, descriptor=descriptor))
    assert found and {code for code, _, _ in found} == {"LD1017"}
    assert "slave2 cannot reach `counter`" in {message for _, message, _ in found}
    alone = "\n".join(line for line in BODY.split("\n") if "PLC_" not in line and "error = 99" not in line)
    assert findings(project(tmp_path, alone, descriptor)) == []


REMAP = """\
#include "probe.h"

void probe(const probe_in *in, probe_out *out, probe_state *state, uint32_t dt_us)
{
    (void)in; (void)state; (void)dt_us;
    PLC_D(pressure) = PLC_D(speed) * 2.0f;
    PLC_D(force) += 1.0;
    out->error = PLC_D(row)[2];
}
"""


def remapped(tmp_path: Path, text: str, memory: AddressMap) -> tuple[str | None, Diagnostics]:
    diagnostics = Diagnostics()
    source = SourceFile((tmp_path / "probe.c").as_posix(), text)
    (tmp_path / "probe.c").write_text(text)
    component = load(SourceFile("probe.ldc.toml", DESCRIPTOR), tmp_path, diagnostics)
    unit = machine_unit(tmp_path)
    (tmp_path / "probe.h").write_text(header.text(component, unit, memory))
    made = c_source.rewrite(component, source, tmp_path / "probe.h", memory, shutil.which("gcc"), diagnostics)
    return (made.text if made else None), diagnostics


def machine_unit(tmp_path: Path):
    other = tmp_path / "other"
    other.mkdir(exist_ok=True)
    return pipeline.compile_paths([str(project(other))]).natives[0].unit


def test_addresses_are_those_of_the_processor_and_lie_in_its_windows(tmp_path: Path) -> None:
    wanted = [
        ("speed", REAL, "SMD"),
        ("pressure", REAL, "MSD"),
        ("force", LREAL, "MSD"),
        ("row", Array(((0, 3),), INT), "SMD"),
    ]
    texts = {}
    for processor, word_bits in (("slave1", 8), ("slave3", 8), ("slave1", 16)):
        memory = placed(processor, wanted, word_bits)
        text, diagnostics = remapped(tmp_path, REMAP, memory)
        assert not diagnostics.has_errors, [d.message for d in diagnostics]
        addresses = {int(a, 16) for a in re.findall(r"\) 0x([0-9a-f]+)u", text)}
        texts[processor, word_bits] = sorted(addresses)
    assert texts["slave1", 8] == [0x1F4000, 0x1F4004, 0x1F5000, 0x1F5004]
    assert texts["slave3", 8] == [a + 2 * 0x2000 for a in texts["slave1", 8]]
    assert texts["slave1", 16] == [a // 2 for a in texts["slave1", 8]], "an address counts words of 16 bits"


def test_a_slave_writes_its_own_window_only(tmp_path: Path) -> None:
    memory = placed(
        "slave1",
        [
            ("speed", REAL, "SMD"),
            ("pressure", REAL, "MSD"),
            ("force", LREAL, "D"),
            ("row", Array(((0, 3),), INT), "SMD"),
        ],
    )
    _, diagnostics = remapped(tmp_path, REMAP, memory)
    assert [(d.code, d.message) for d in diagnostics] == [("LD1017", "slave1 cannot reach `force`")]
    _, diagnostics = remapped(tmp_path, REMAP.replace("PLC_D(pressure) =", "PLC_D(speed) ="), memory)
    assert ("LD1017", "slave1 may not write `speed`") in {(d.code, d.message) for d in diagnostics}


def test_bits_of_memory_are_packed_and_written_alone(tmp_path: Path) -> None:
    text = REMAP.split("    PLC_D")[0] + "    PLC_M(b) = PLC_M(a);\n    PLC_M(c) |= 1;\n}\n"
    for word_bits, first in ((8, 0x500 // 8), (16, 0x500 // 16)):
        memory = placed("master", [("a", BOOL, "M"), ("b", BOOL, "M"), ("c", BOOL, "M")], word_bits)
        made, diagnostics = remapped(tmp_path, text, memory)
        assert not diagnostics.has_errors
        a, b = (f"((volatile ldc_bits *) {first:#x}u)->b{bit}" for bit in (0, 1))
        assert f"({b}) = ({a});" in made
    _, diagnostics = remapped(tmp_path, text.replace("PLC_M(c) |= 1", "bool *p = &PLC_M(c); *p = 1"), memory)
    assert [d.code for d in diagnostics] == ["LD1016"]


def test_an_area_that_is_full_is_told() -> None:
    with pytest.raises(ValueError, match="SMD is full"):
        placed("slave1", [(f"x{n}", LREAL, "SMD") for n in range(600)])
    with pytest.raises(ValueError, match="no area NONE"):
        placed("slave1", [("x", REAL, "NONE")])


CALL = "<p: PROBE(x := x, n := n, text := text, row := row)>"
WITHOUT = MAIN.replace("    p : PROBE;\n", "").replace(CALL, "")
LDC = [sys.executable, "-c", "from ldc.cli.start import entry; entry()"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("program", [MAIN, WITHOUT])
def test_no_room_for_a_trace_is_told(tmp_path: Path, program: str) -> None:
    project(tmp_path, program=program)
    with open("/dev/full", "w", encoding="utf-8") as full:
        done = subprocess.run(
            [*LDC, "run", str(tmp_path), "--watch", "flag", "--trace", "-"],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )
    assert done.returncode == 1
    assert "cannot write: No space left" in done.stderr and "Traceback" not in done.stderr


@pytest.mark.parametrize("program", [MAIN, WITHOUT])
def test_nobody_reads_the_trace_any_more(tmp_path: Path, program: str) -> None:
    project(tmp_path, program=program)
    command = [*LDC, "run", str(tmp_path), "--scans", "20000", "--watch", "flag", "--trace", "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        run.stdout.readline()
        run.stdout.close()
        said = run.stderr.read()
        assert run.wait() == 141 and "Traceback" not in said


def test_a_run_ends_with_the_process_that_watches_it(tmp_path: Path) -> None:
    project(tmp_path)
    command = [*LDC, "run", str(tmp_path), "--scans", "100000000", "--watch", "flag", "--trace", "-"]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as run:
        os.read(run.stdout.fileno(), 1)
        run.kill()
        latest = time.monotonic() + 20
        while os.read(run.stdout.fileno(), 1 << 16):
            assert time.monotonic() < latest, "something still writes into the pipe"


@pytest.mark.parametrize("slave", ["", 'slave1 = "slave"\n'])
@pytest.mark.parametrize("language", ["c", "st"])
def test_a_component_and_a_block_of_the_same_name(tmp_path: Path, capfd, language: str, slave: str) -> None:
    mover(tmp_path, "LIFT", 1)
    descriptor = tmp_path / "lift.ldc.toml"
    descriptor.write_text(descriptor.read_text().replace('language = "c"', f'language = "{language}"')
                          .replace("lift.c", f"lift.{language}"))
    body = "FUNCTION_BLOCK LIFT\nEND_FUNCTION_BLOCK\n"
    (tmp_path / "main.st").write_text(body + "PROGRAM main\nVAR a : LIFT; END_VAR\na();\nEND_PROGRAM\n")
    if language == "st":
        (tmp_path / "lift.st").write_text(body)
    (tmp_path / "ldc.toml").write_text(f'[processors]\nmaster = "master"\n{slave}')
    assert main(["check", str(tmp_path)]) == 1
    assert "error[LD0201]" in (said := capfd.readouterr().err) and "LIFT" in said, said
