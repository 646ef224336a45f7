"""`ldc compile --emit st`: the text compiles, and does what the program does, scan by scan."""

from __future__ import annotations

from pathlib import Path

import pytest
import strategies
import test_engines
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_engines import PERIOD, booleans, compiled, same

from ldc.cli.main import main
from ldc.il.st_text import print_st
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.pipeline import compile_paths, compile_project
from ldc.source import SourceFile
from runtime.vm.machine import Machine

SAMPLES = sorted(path.parent for path in Path(__file__).resolve().parent.parent.glob("samples/*/ldc.toml")
                 if "[plant]" not in path.read_text())


def read_back(text: str):
    result = compile_project(Sources((SourceFile("printed.st", text),), Settings(), None))
    errors = [f"{d.code} {d.message}" for d in result.diagnostics if d.severity == "error"]
    assert not errors, (errors, text)
    return result.program


class Pair:
    """A program and the one that its text is; instances may be called differently."""

    def __init__(self, program, text: str) -> None:
        self.text, self.one = text, Machine(program, period_ns=PERIOD)
        self.other = Machine(read_back(text), period_ns=PERIOD)
        runs = [m.program.resources[m.resource].runs for m in (self.one, self.other)]
        self.renamed = {a.name: b.name for a, b in zip(*runs, strict=True)}
        paths = [path for path, _ in self.one.paths() if "ldc_" not in path.lower()]
        self.paths = [(path, self.path(path)) for path in paths]

    def path(self, path: str) -> str:
        head, dot, rest = path.partition(".")
        return f"{self.renamed.get(head, head)}{dot}{rest}"

    def set(self, path: str, value: object) -> None:
        self.one.set(path, value)
        self.other.set(self.path(path), value)

    def scan(self) -> bool:
        """One scan of both; whether they go on."""
        self.one.scan()
        self.other.scan()
        assert bool(self.one.faults) == bool(self.other.faults), (self.one.faults, self.other.faults, self.text)
        if self.one.faults:
            return False
        for path, other in self.paths:
            assert same(self.one.get(path), self.other.get(other)), (path, self.text)
        return True


def compare(text: str, stimuli: list[dict[str, object]]) -> None:
    check(compiled(text, verify=False).program, stimuli)


def check(program, stimuli: list[dict[str, object]]) -> None:
    pair = Pair(program, print_st(program))
    for values in stimuli:
        for name, value in values.items():
            pair.set(name, value)
        if not pair.scan():
            return


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=40)
@given(strategies.programs(), st.lists(booleans, min_size=1, max_size=5))
def test_networks_do_the_same_as_structured_text(text: str, stimuli: list) -> None:
    compare(text, stimuli)


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=60)
@given(test_engines.rungs, st.lists(test_engines.changes, min_size=1, max_size=5))
def test_blocks_values_and_jumps_do_the_same_as_structured_text(lines: list[str], stimuli: list) -> None:
    body = "".join(f"RUNG r{n}\n    {line}\n" for n, line in enumerate(lines))
    compare(f"{test_engines.MINE}{test_engines.DECLARATIONS}{body}RUNG last [a0] (q3)\nEND_PROGRAM\n", stimuli)


def test_jumps_that_cross_become_numbered_parts() -> None:
    program = """PROGRAM main
VAR a0, a1 : BOOL; n : INT; END_VAR
RUNG first [a0] >>third
RUNG second [TRUE] <ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG third [a1] [n < 50] >>second
RUNG fourth [a0] [n < 20] >>first
RUNG fifth [TRUE] <ADD(IN1 := n, IN2 := 100, OUT => n)>
END_PROGRAM
"""
    made = compile_project(Sources((SourceFile("main.ld", program),), Settings(), None)).program
    check(made, [{"a0": a, "a1": b, "n": n} for a in (0, 1) for b in (0, 1) for n in (0, 19, 30)
                      if not (a and not b and n < 20)])
    assert "ldc_part" in print_st(made)


@pytest.mark.parametrize("folder", SAMPLES, ids=lambda path: path.name)
def test_samples_do_the_same_as_structured_text(folder: Path, capsys) -> None:
    result = compile_paths([str(folder)])
    if result.natives:
        pytest.skip("a body in C has no text in ST")
    assert main(["compile", str(folder), "--emit", "st"]) == 0
    pair = Pair(result.program, capsys.readouterr().out)
    inputs = [s.path for s in pair.one.symbols.located("I")]
    for number in range(120):
        for position, path in enumerate(inputs):
            value = pair.one.get(path)
            if type(value) is bool and number % (position + 3) == 0:
                pair.set(path, not value)
            elif type(value) is int:
                pair.set(path, number * (position + 7) % 100)
        assert pair.scan()


def test_what_was_written_in_structured_text_stays_as_it_was(tmp_path: Path, capsys) -> None:
    source = tmp_path / "main.st"
    source.write_text("PROGRAM main\nVAR\n    i, n : INT;\nEND_VAR\n    FOR i := 1 TO 3 DO\n        n := n + i;\n"
                      "    END_FOR;\nEND_PROGRAM\n")
    assert main(["compile", str(source), "--emit", "st"]) == 0
    assert "    FOR i := 1 TO 3 DO\n        n := n + i;\n    END_FOR;\n" in capsys.readouterr().out


def test_other_names_of_types_that_bodies_use_are_declared(tmp_path: Path, capsys) -> None:
    """The IL, of which the rest is printed, has only what they stand for."""
    source, printed = tmp_path / "main.st", tmp_path / "printed.st"
    source.write_text("TYPE\n    Row : ARRAY [0..3] OF Pair := [(a := 4)];\n    Pair : STRUCT a : INT; END_STRUCT;\n"
                      "    Count : DINT := 7;\nEND_TYPE\nPROGRAM main\nVAR\n    row : Row;\n    count : Count;\n"
                      "END_VAR\n    count := count + row[0].a;\nEND_PROGRAM\n")
    assert main(["compile", str(source), "--emit", "st", "-o", str(printed)]) == 0
    machine = Machine(compile_paths([str(printed)]).program)
    machine.scan()
    assert machine.get("count") == 11
