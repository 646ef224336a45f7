"""What engineers write in C and C++: all of C11, headers of their own, the standard library of C++."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from ldc import pipeline
from ldc.cli.main import main
from ldc.components import toolchain
from tests.test_components import findings, machine

pytestmark = pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")

DESCRIPTOR = """\
[component]
name = "ODD"
id = "test.odd"
[requires]
inputs = [{ name = "a", type = "DINT", value = 4 }]
[provides]
outputs = [{ name = "r", type = "DINT" }]
[properties]
state = [{ name = "n", type = "DINT" }, { name = "grid", type = "ARRAY [1..2, 1..3] OF INT" }]
[function]
language = "c"
sources = ["odd.c"]
"""

MAIN = """\
VAR_GLOBAL
    table : ARRAY [0..3] OF DINT;
    matrix : ARRAY [1..2, 1..3] OF INT;
    rows : ARRAY [0..1] OF ARRAY [1..3] OF BOOL;
    flag : BOOL;
    count : DINT;
END_VAR
PROGRAM main
VAR odd : ODD; r : DINT; END_VAR
RUNG <odd: ODD(r => r)>
END_PROGRAM
"""

STRUCTURES = """\
typedef struct { bool enable; int32_t a; } odd_in;
typedef struct { int32_t r; uint16_t error; } odd_out;
typedef struct { int32_t n; int16_t grid[2][3]; } odd_state;
"""
CALL = """
int printf(const char *, ...);
int main(void)
{
    odd_in in = { 1, 4 }; odd_out out = { 0 }; odd_state state = { 0 };
    odd(&in, &out, &state, 0);
    printf("%d", out.r);
}
"""


def project(folder: Path, body: str, language: str = "c", **files: str) -> Path:
    """A program with one component; ``files``: others beside it, ``own_h`` is ``own.h``."""
    suffix = {"c": "c", "c++": "cpp"}[language]
    (folder / "ldc.toml").write_text('[project]\nname = "odd"\n')
    (folder / "odd.ldc.toml").write_text(
        DESCRIPTOR.replace('"c"', f'"{language}"').replace("odd.c", f"odd.{suffix}")
    )
    (folder / f"odd.{suffix}").write_bytes(body.encode())
    (folder / "main.ld").write_text(MAIN)
    for name, text in files.items():
        (folder / name.replace("_", ".")).write_text(text)
    return folder


def entry(line: str, before: str = "") -> str:
    head = "void odd(const odd_in *in, odd_out *out, odd_state *state, uint32_t dt_us)"
    used = "(void)in; (void)out; (void)state; (void)dt_us;"
    return f'#include "odd.h"\n{before}\n{head}\n{{\n    {used}\n{line}\n}}\n'


PIECES = {
    "attributes": (
        "static int __attribute__((noinline)) slow(int x) { return x + 1; }\n"
        "struct __attribute__((packed)) packed { char c; int i; };",
        "out->r = slow(in->a) * 100 + (int)sizeof(struct packed) + __builtin_popcount(7);",
    ),
    "one structure for two names": (
        "typedef struct point { int v; } point, *pointer;",
        "struct { int x; } p, q; p.x = in->a; q = p; point t = { 4 }; pointer at = &t;\n"
        "enum { LOW, HIGH } e = HIGH, g = LOW; out->r = q.x * 100 + at->v + e + g;",
    ),
    "prototypes": (
        "static int (*pick(int w))(int x);\nint twice(int x);\nint twice(int x) { return 2 * x; }\n"
        "static int thrice(int x) { return 3 * x; }\n"
        "static int (*pick(int w))(int x) { return w ? twice : thrice; }",
        "out->r = pick(in->a)(5) + pick(0)(7);",
    ),
    "unions, bit-fields, designators": (
        "struct flags { unsigned a : 3; unsigned : 2; unsigned b : 5; signed c : 4; };\n"
        "enum color { RED, GREEN = 5, BLUE };\n"
        "static const int table[] = { [RED] = 3, [BLUE] = 9, [GREEN] = 7 };\n"
        "typedef union { float f; uint32_t u; struct { uint16_t lo, hi; }; } both;",
        "struct flags f = { .a = 5, .b = 17, .c = -3 }; both b; b.f = (float)in->a;\n"
        "out->r = f.a * 1000 + f.b + f.c + table[BLUE] * 10 + b.hi + (int[]){ 1, 2, 3 }[2];",
    ),
    "goto, arrays of variable length, switches": (
        "#define MAX(a, b) ((a) > (b) ? (a) : (b))",
        "int i = 0, n = in->a, v[n]; again: if (i < n) { v[i] = i * i; i++; goto again; }\n"
        "switch (n % 3) { case 0: do { i++; case 1: i += 2; } while (i < 9); break; default: i = 100; }\n"
        "out->r = MAX(v[n - 1], 2) * 100 + i;",
    ),
    "functions by pointers, arguments without number": (
        "typedef int (*operation)(int left, int right);\n"
        "static int add(int a, int b) { return a + b; }\nstatic int mul(int a, int b) { return a * b; }\n"
        "static const operation operations[] = { add, mul };\ntypedef __builtin_va_list many;\n"
        "static int sum(int n, ...) { many v; int s = 0; __builtin_va_start(v, n);\n"
        "while (n--) s += __builtin_va_arg(v, int); __builtin_va_end(v); return s; }",
        "out->r = operations[1](in->a, 10) + sum(3, 1, 2, in->a);",
    ),
    "C11": (
        '#include <stddef.h>\n_Static_assert(sizeof(int) == 4, "int");\n'
        "#define kind(x) _Generic((x), int: 1, float: 2, default: 3)\n"
        '#pragma GCC diagnostic ignored "-Wunused-variable"',
        "_Alignas(16) int v = 3; _Atomic int c = 2;\n#pragma GCC unroll 4\n"
        "for (int i = 0; i < 4; i++) v += i;\n"
        "out->r = kind(v) + kind(1.0f) * 10 + v * 100 + c;\n"
        "out->r += (((uintptr_t)&v) & 15) + (int)offsetof(odd_in, a);",
    ),
    "texts and comments": (
        "/* PLC_D(nothing) */ // PLC_M(nothing)\n"
        'static const char text[] = "PLC_D(none) /* \\"x\\" \\x41" "z";',
        "int s = '\\\\' + '\\'' + '\"'; for (unsigned i = 0; i < sizeof text; i++) s += text[i]; // end \\\n"
        "still PLC_D(none)\nout->r = s /* PLC_D(none) */ + in->a;",
    ),
    "identifiers of other alphabets": ("", "int größe = in->a; out->r = größe + (int)sizeof \"ü\";"),
    "lines that end as on Windows": ("#define TWO(a) (a) + \\\r\n  2\r", "out->r =\r\nTWO(in->a);\r"),
    "many branches": (
        "",
        " else ".join(f"if (in->a == {n}) out->r = {n * n};" for n in range(500)),
    ),
    "long sums": ("", f"out->r = {' + '.join(['in->a'] * 800)};"),
}


@pytest.mark.parametrize("name", PIECES)
def test_c_means_what_it_means_to_gcc(tmp_path: Path, name: str) -> None:
    before, line = PIECES[name]
    body = entry(line, before)
    m = machine(project(tmp_path, body))
    m.scan()
    alone = tmp_path / "alone"
    alone.mkdir()
    (alone / "odd.h").write_text(f"#include <stdbool.h>\n#include <stdint.h>\n{STRUCTURES}")
    (alone / "odd.c").write_bytes((body + CALL).encode())
    command = ["gcc", "-w", "-O1", "-fwrapv", "odd.c", "-o", "odd"]
    subprocess.run(command, cwd=alone, check=True)
    said = subprocess.run([alone / "odd"], capture_output=True, text=True, check=True)
    assert str(m.get("r")) == said.stdout


MEMORY = [
    ("volatile int32_t *p = PLC_D(table); p[1] = 5; *(p + 2) = 6;", {"table[1]": 5, "table[2]": 6}),
    ("*PLC_D(table) = 7; (PLC_D((table)))[3]++; ++PLC_D(count);", {"table[0]": 7, "table[3]": 1, "count": 1}),
    ("PLC_D(matrix)[1][2] = 9; state->grid[1][2] = 8;", {"matrix[2,3]": 9, "odd.grid[2,3]": 8}),
    ("PLC_M(flag) = in->a; out->r = PLC_M(flag);", {"flag": True, "r": 1}),
    ("for (PLC_D(count) = 1; PLC_D(count) < 5; PLC_D(count) += 3) ;", {"count": 7}),
    ("PLC_D(count) = PLC_M(rows)[1][0]; PLC_M(rows)[1][2] = 4;", {"rows[1][3]": True, "rows[0][3]": False}),
    ("out->r = sizeof PLC_D(table) / sizeof PLC_D(table)[0];", {"r": 4}),
]


@pytest.mark.parametrize(("line", "values"), MEMORY)
def test_memory_is_used_as_variables_are(tmp_path: Path, line: str, values: dict) -> None:
    m = machine(project(tmp_path, entry(line)))
    m.scan()
    assert {name: m.get(name) for name in values} == values


@pytest.mark.parametrize("line", [
    "PLC_D(table)[1] = 5; PLC_D(table)[2]++; PLC_D(matrix)[1][2] = PLC_D(table)[1];",
    "auto &t = PLC_D(table); t[1] = 5; t[2] = 1; PLC_D(matrix)[1][2] = 5;",
])
def test_memory_in_cpp(tmp_path: Path, line: str) -> None:
    line += " PLC_D(count) = 40; PLC_D(count)++; --PLC_D(count); PLC_D(count) %= 7; PLC_M(flag) = 2;"
    m = machine(project(tmp_path, entry(line), "c++"))
    m.scan()
    got = [m.get(name) for name in ("table[1]", "table[2]", "matrix[2,3]", "count", "flag")]
    assert got == [5, 1, 5, 5, True]


@pytest.mark.parametrize(
    ("before", "line", "code", "what"),
    [
        ("typedef volatile int *port;", "*(port)0x4000 = 1;", "LD1014", "0x4000"),
        ("int elsewhere(int x);", "out->r = elsewhere(in->a);", "LD1011", "elsewhere"),
        ("extern int elsewhere;", "out->r = elsewhere;", "LD1011", "elsewhere"),
        ("extern int kept = 3;", "out->r = kept;", "LD1013", "kept"),
        ("static _Thread_local int kept;", "kept++;", "LD1013", "kept"),
        ("static const char *names[] = { 0 };", "out->r = names[0] == 0;", "LD1013", "names"),
    ],
)
def test_what_else_is_told(tmp_path: Path, before: str, line: str, code: str, what: str) -> None:
    found = findings(project(tmp_path, entry(line, before)))
    assert {c for c, _, _ in found} == {code} and what in found[0][1], found
    assert found[0][2] == (2 if code == "LD1013" else 6)


HEADER = "#pragma once\n#define FACTOR 3\nstatic inline int scaled(int x)\n{\n    return x * FACTOR;\n}\n"


@pytest.mark.parametrize("language", ["c", "c++"])
def test_headers_of_ones_own(tmp_path: Path, language: str) -> None:
    body = entry("out->r = scaled(in->a);", '#include "own.h"')
    if language == "c++":
        body = body.replace("void odd", 'extern "C" void odd')
    project(tmp_path, body, language, own_h=HEADER)
    results, digests = [], []
    for factor in ("3", "5"):
        (tmp_path / "own.h").write_text(HEADER.replace("FACTOR 3", f"FACTOR {factor}"))
        m = machine(tmp_path)
        m.scan()
        results.append(m.get("r"))
        digests.append(pipeline.compile_paths([str(tmp_path)]).image.digest)
    assert results == [12, 20] and digests[0] != digests[1]
    for line, code in (("return y;", "LD1011"), ("static int kept; return kept++;", "LD1013")):
        (tmp_path / "own.h").write_text(HEADER.replace("return x * FACTOR;", line))
        found = findings(tmp_path)
        assert {(c, at) for c, _, at in found} == {(code, 5)}, found


def test_the_standard_library_of_cpp(tmp_path: Path) -> None:
    names = ("algorithm", "array", "cmath", "cstdint", "cstring", "limits", "numeric", "utility")
    before = "".join(f"#include <{name}>\n" for name in names) + (
        "namespace dsp { template <typename T, unsigned N> T mean(const std::array<T, N> &v)\n"
        "{ return std::accumulate(v.begin(), v.end(), T{}) / T(N); } }\n"
    )
    line = "std::array<float, 4> v{1.0f, std::sqrt(4.0f), 3.0f, 6.0f}; std::sort(v.begin(), v.end());\n" \
           "out->r = std::clamp<int32_t>((int)dsp::mean<float, 4>(v), 0, std::numeric_limits<int>::max());"
    m = machine(project(tmp_path, entry(line, before), "c++"))
    m.scan()
    assert m.get("r") == 3


@pytest.mark.parametrize("before", [
    "inline int kept; int &use() { return kept; }",
    "template <typename T> struct Box { static T kept; }; template <typename T> T Box<T>::kept = 1;\n"
    "template struct Box<int>;",
    "template <typename T> int &value() { static T kept = 2; return kept; } template int &value<int>();",
    "thread_local int kept = 1; int &use() { return kept; }",
])
def test_static_data_of_cpp(tmp_path: Path, before: str) -> None:
    found = findings(project(tmp_path, entry("out->r = 1;", before), "c++"))
    assert {(c, at) for c, _, at in found} == {("LD1013", 2)}, found
    assert "`kept`" in found[0][1]


def test_installed_components_are_listed_where_no_project_is(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["component", "list"]) == 0
    assert "ldc.pid" in capsys.readouterr().out


def test_a_crash_in_a_header_of_ones_own_is_told_there(tmp_path: Path, capfd) -> None:
    own = HEADER.replace("return x * FACTOR;", "__builtin_trap();")
    project(tmp_path, entry("out->r = scaled(in->a);", '#include "own.h"'), own_h=own)
    assert main(["run", str(tmp_path), "--scans", "1", "--watch", "r"]) == 1
    said = capfd.readouterr().err
    assert "error[LD0805]: component ODD" in said and "own.h:5:" in said, said


def test_a_bug_beside_components_is_reported_like_any_other(tmp_path: Path, monkeypatch, capfd) -> None:
    """They run in a process of their own, which has no traceback for users either."""
    def broken(*options):
        raise RuntimeError("no such thing")

    monkeypatch.setattr("ldc.cli.run._run", broken)
    monkeypatch.chdir(tmp_path)
    assert main(["run", str(project(tmp_path, entry("out->r = 1;"))), "--scans", "1"]) == 3
    said = capfd.readouterr().err
    assert "Traceback" not in said and "internal fault (RuntimeError: no such thing)" in said
    (report,) = tmp_path.glob("ldc-bug-*.txt")
    assert "command: ldc run" in report.read_text()


def test_what_was_used_last_is_kept(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(toolchain, "MOST_KEPT", 2)
    for number in range(4):
        findings(project(tmp_path, entry(f"out->r = {number};")))
    assert len(list((tmp_path / "cache" / "ldc" / "components").iterdir())) == 2


def answer(folder: Path) -> object:
    """What the component gives in a process of its own, as at every start of a program."""
    line = f"import sys; from ldc.cli.main import main; sys.exit(main(['run', {str(folder)!r}, '--scans', '1', "
    done = subprocess.run([sys.executable, "-c", f"{line}'--watch', 'r', '--trace', '-']))"],
                          capture_output=True, text=True, check=False)
    return done.stdout.split(",")[-1].strip() if done.returncode == 0 else done.stderr


def test_a_component_that_is_known_is_read_again_when_a_part_of_it_changes(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    inside, other = tmp_path / "inside", tmp_path / "other"
    inside.mkdir()
    other.mkdir()
    (other / "far.h").write_text("#define FAR 100\n")
    own = '#include "../other/far.h"\n#define NEAR 1\n'
    project(inside, entry("out->r = in->a + NEAR + FAR;", '#include "own.h"'), own_h=own)
    assert answer(inside) == answer(inside) == "105"
    (other / "far.h").write_text("#define FAR 200\n")
    assert answer(inside) == "205"
    project(inside, entry("out->r = in->a + NEAR;", '#include "own.h"'), own_h="#define NEAR 2\n")
    assert answer(inside) == answer(inside) == "6"
    (inside / "own.h").write_text("#define NEAR 3\n")
    assert answer(inside) == "7"
    (inside / "main.ld").write_text(MAIN.replace("odd(r", "odd(r").replace("count : DINT", "count : INT"))
    assert answer(inside) == "7"
    (inside / "own.h").write_text("#define NEAR 3 +\n")
    assert "error" in answer(inside) and "error" in answer(inside)


def test_what_is_known_of_a_component_may_be_damaged(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    project(tmp_path, entry("out->r = in->a;"))
    assert answer(tmp_path) == "4"
    for number, seen in enumerate((tmp_path / "cache" / "ldc" / "components").glob("*.seen")):
        seen.write_bytes((b"", b"{}", b"\xff")[number % 3])
    for library in (tmp_path / "cache" / "ldc" / "components").glob("odd-*.so"):
        library.unlink()
    assert answer(tmp_path) == answer(tmp_path) == "4"
