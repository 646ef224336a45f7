"""`ldc build`: what it writes, what it compiles again after an edit, and that a stranger can run the result."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import cffi
import native
import pytest

from ldc import pipeline
from ldc.backends.c import emit, gcc
from ldc.cli.main import main
from ldc.il import block
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from runtime.native.library import Code, Library, WrongLibrary

pytestmark = native.needs_gcc
RUNGS = 250


def text(names=tuple(f"r{n}" for n in range(RUNGS)), changed: str = "", more: str = "") -> str:
    """A program with a rung for each name; ``changed``: the one that is drawn otherwise."""
    lines = ["PROGRAM main", "VAR", "    a AT %IX0.0 : BOOL;", "    n AT %QW0 : INT;", more]
    lines += [f"    q_{name} : BOOL;" for name in dict.fromkeys(names)]
    lines += ["END_VAR", "RUNG count [a] <ADD(IN1 := n, IN2 := 1, OUT => n)>"]
    lines += [f"RUNG {name} {'[/a]' if name == changed else '[a]'} (q_{name})" for name in names]
    return "\n".join([*lines, "END_PROGRAM", ""])


@pytest.fixture
def build(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(gcc, "FLAGS", native.QUICK)

    def run(source: str, *options: str) -> int:
        """Builds into `out`; how many files were compiled."""
        Path("main.ld").write_text(source)
        assert main(["build", "main.ld", "--target", "host", "-o", "out", *options]) == 0
        return int(re.search(r"\((\d+) files? compiled", capsys.readouterr().err)[1])

    return run


def test_what_did_not_change_is_not_compiled_again(build) -> None:
    names = tuple(f"r{n}" for n in range(RUNGS))
    assert build(text()) >= 4
    assert build(text()) == 0
    assert build(text(changed="r77")) == 1
    assert build("(* a line more *)\n" + text(changed="r77")) == 0
    # The new variable moves no other one; the new rung lies in one file, and the drivers tell of one more.
    assert build(text((*names[:90], "new", *names[90:]))) <= 3
    assert build(text(names, more="    further : ARRAY [1..9] OF DINT;")) <= 2


def test_builds_at_the_same_time_do_not_disturb_each_other(build, tmp_path: Path) -> None:
    kept = tmp_path / "cache" / "ldc" / "native"
    kept.mkdir(parents=True)
    (kept / ".gone.o.0123").symlink_to("taken-away-by-another-build")
    assert build(text(("r",))) > 0


def test_one_build_is_there_at_a_time_and_each_has_its_own_name(build, tmp_path: Path) -> None:
    build(text())
    first, = (tmp_path / "out").glob("*.so")
    build(text(changed="r1"))
    second, = (tmp_path / "out").glob("*.so")
    assert first.name != second.name
    about = json.loads((tmp_path / "out/native.json").read_text())
    assert about["library"] == second.name and about["programs"] == ["main"]


def test_the_described_interface_is_enough_to_run_it(build, tmp_path: Path) -> None:
    build(text(changed="r3"))
    about = json.loads((tmp_path / "out/native.json").read_text())
    ffi = cffi.FFI()
    ffi.cdef("uint32_t ldc_abi(void); uint32_t ldc_size(void); int32_t ldc_run(uint8_t *memory, uint32_t program);")
    library = ffi.dlopen(str(tmp_path / "out" / about["library"]))
    assert (library.ldc_abi(), library.ldc_size()) == (about["abi"], about["size"])
    memory = ffi.new("uint8_t[]", bytes.fromhex(about["initial"]))
    at = {path: place["offset"] for path, place in about["variables"].items()}
    for scan in range(3):
        memory[at["main.a"]] = scan != 1
        assert library.ldc_run(memory, 0) == 0
        assert (memory[at["main.q_r2"]], memory[at["main.q_r3"]]) == (scan != 1, scan == 1)
    assert memory[at["main.n"]] == 2


def test_a_newer_build_goes_on_with_the_memory(tmp_path: Path) -> None:
    libraries = []
    layout = None
    for source in (text(), text(changed="r5", more="    further : ARRAY [1..99] OF INT;")):
        options = pipeline.Options(previous=layout)
        result = pipeline.compile_project(Sources((SourceFile("main.ld", source),), Settings(), None), options)
        layout = result.image.layout
        plan = emit.plan(block.make(result.program, layout), native.QUICK)
        made = gcc.build(plan, gcc.find_compiler(None), tmp_path)
        libraries.append(Library(Code(made.path, plan.block, plan.map)))
    old, new = libraries
    n = new.code.block.variable("main.n", new.code.block.units["MAIN"].variables[1])
    data = bytearray(new.code.block.initial())
    data[new.code.block.variable("main.a", new.code.block.units["MAIN"].variables[0]).offset] = 1
    pointer, memory = new.memory(data)
    for library in (old, old, new, old, new):
        assert library.run(pointer, 0) == 0
    assert block.read(memory, n) == 5
    with pytest.raises(WrongLibrary):
        Library(Code(old.code.path, new.code.block, ()))


def test_what_is_generated_is_plain_c_for_any_machine(build, tmp_path: Path) -> None:
    """No warnings, no header but stdint.h: the same files go into firmware."""
    build(text())
    for file in (tmp_path / "out/c").glob("*.c"):
        assert set(re.findall(r"#include <(.*)>", file.read_text())) <= {"math.h"}
        subprocess.run(["gcc", "-std=c11", "-ffreestanding", "-Wall", "-Wextra", "-Werror", "-fsyntax-only",
                        str(file)], check=True)


def test_each_statement_leads_to_its_line(build, tmp_path: Path) -> None:
    source = text()
    build(source)
    line = source.split("\n").index("RUNG r7 [a] (q_r7)") + 1
    found = "".join(file.read_text() for file in (tmp_path / "out/c").glob("run_*.c"))
    assert f'#line {line} "main.ld"\n    v_q_r7 = v_a;\n' in found


def test_a_build_that_checks_itself_runs(build, tmp_path: Path) -> None:
    assert build(text(("r1", "r2")), "--sanitize") >= 3
    assert main(["run", "main.ld", "--engine", "native", "--scans", "2"]) == 0


def test_nothing_of_a_damaged_build_before_is_kept(build, tmp_path: Path) -> None:
    build(text(("r1",)))
    for name, damage in (("native.json", b"{"), ("native.json", b"[]"), ("program.img", b"LDCI\x90"),
                         ("program.img", b"")):
        (tmp_path / "out" / name).write_bytes(damage)
        build(text(("r1",)))


def test_a_folder_that_cannot_be_written_is_told(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(text(("r1",)))
    Path("file").write_text("")
    assert main(["build", "main.ld", "--target", "host", "-o", "file"]) == 1
    said = capsys.readouterr().err
    assert "cannot write native code: `" in said and "[Errno" not in said
