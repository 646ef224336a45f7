"""What the compiler makes of ladders is sound IL, and comes back the same from its own text."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from tests import test_samples
from tests.strategies import programs
from tests.test_verify import DECLARATIONS, RUNGS

from ldc import pipeline
from ldc.il import standard
from ldc.il.program import Program, Unit
from ldc.il.text import print_program
from ldc.il.typecheck import check_unit
from ldc.library import blocks
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from ldc.types import String, Subrange

WIDE = """
TYPE
    Mode : (off, slow, fast) := slow;
    Level : INT (0..100);
    Axis : STRUCT speed : REAL := 1.5; mode : Mode; marks : ARRAY [0..2, 1..2] OF INT; END_STRUCT;
END_TYPE
VAR_GLOBAL
    total : DINT;
    axes : ARRAY [1..2] OF Axis;
END_VAR
FUNCTION spread : INT
VAR_INPUT low : INT; high : INT := 10; END_VAR
VAR_OUTPUT wide : BOOL; END_VAR
RUNG
    <SUB(IN1 := high, IN2 := low, OUT => spread)> [spread > 5] (wide)
END_FUNCTION
FUNCTION_BLOCK shift
VAR_INPUT R : BOOL; width : INT := 1; END_VAR
VAR_OUTPUT Q : BOOL; END_VAR
VAR_IN_OUT sum : INT; END_VAR
VAR was : R_TRIG; END_VAR
RUNG
    [R] <was: R_TRIG()> <ADD(IN1 := sum, IN2 := width, OUT => sum)> (Q)
END_FUNCTION_BLOCK
PROGRAM main "a (* little *) of everything"
VAR
    a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; q AT %QX0.0 : BOOL; z : BOOL;
    i, j : INT; d : DINT; u : UINT; x : REAL; y : LREAL; w : WORD; t : TIME; clock : TOD;
    text : STRING[10]; mode : Mode; level : Level; move : shift; warm : TON;
END_VAR
RUNG ready "jumps to a rung (named like a variable)" [a] >>q
RUNG numbers
    [a] <ADD(IN1 := i, IN2 := total, OUT => total)> <MUL(IN1 := x, IN2 := 2.5, OUT => y)>
        <DIV(IN1 := d, IN2 := j, OUT => d)> [-i < 3] [x ** 2 > y] <LIMIT(MN := 0, IN := level, MX := 50, OUT => level)> (q)
RUNG time
    [t * 2 > T#1.5s] <MUL(IN1 := t, IN2 := 3, OUT => t)> <ADD(IN1 := clock, IN2 := t, OUT => clock)> (q)
RUNG words
    [(w AND 16#F0) = 16#10] [w.3] [NOT (w.4 XOR b)] <SHL(IN := w, N := 2, OUT => w)> (w.15)
RUNG text
    [text = 'it$'s'] [LEN(text) > 3] <CONCAT(IN1 := text, IN2 := '$N;(*', OUT => text)> (q)
RUNG modes
    [mode = fast] [axes[i].mode <> Mode#off] <SEL(G := b, IN0 := mode, IN1 := slow, OUT => axes[2].mode)> (q)
RUNG arrays
    [axes[1].marks[i + 1, 2] > 4] <MOVE(IN := j, OUT => axes[i].marks[1, 1])> (q)
RUNG calls
    [P a] <spread(low := i, wide => z, OUT => j)> { <move: shift(width := spread(low := i), sum := j)> (z) | [N b] } (S q)
RUNG q
    { [a] | [b] <warm: TON(PT := t)> } { [q] (R q) | [a] (/q) } (P q); [warm.Q] >>RETURN
END_PROGRAM
CONFIGURATION plant
    RESOURCE line ON master
        TASK fast (INTERVAL := T#10ms, PRIORITY := 3);
        PROGRAM main WITH fast : main;
    END_RESOURCE
END_CONFIGURATION
"""


def compiled(path: str, text: str, **options) -> Program:
    sources = Sources((SourceFile(path, text),), Settings(), None)
    result = pipeline.compile_project(sources, pipeline.Options(verify=False, **options))
    assert not result.diagnostics.has_errors, [
        f"{d.code} {d.message} {d.primary and d.primary.span}" for d in result.diagnostics if d.severity == "error"]
    return result.program


def plain(unit: Unit) -> list:
    """The code, with subranges as their bases and strings without their lengths, which mean nothing there."""
    def type_(instr):
        found = instr.type.base if isinstance(instr.type, Subrange) else instr.type
        return String(found.name) if isinstance(found, String) else found

    return [(r.key, r.label and r.label.upper(), [replace(i, type=type_(i)) for i in r.code]) for r in unit.rungs]


def assert_comes_back(program: Program) -> None:
    for unit in program.units:
        assert not check_unit(unit, program.units), unit.name
    text = print_program(program)
    again = compiled("again.il", text)
    assert print_program(again) == text
    for unit in program.units:
        found = again.unit(unit.name)
        assert found.title is None or unit.title is not None
        assert plain(found) == plain(unit)
        made = {v.name: (v.kind, v.type) for v in unit.variables if v.name.startswith("_ldc_")}
        assert {v.name: (v.kind, v.type) for v in found.variables if v.name.startswith("_ldc_")} == made


@pytest.mark.parametrize("depth", [None, 1, 0])
@pytest.mark.parametrize("name", RUNGS)
def test_every_kind_of_rung(name: str, depth: int | None) -> None:
    text = f"PROGRAM p\n{DECLARATIONS}RUNG r1\n    {RUNGS[name]}\nRUNG other\n    [a] (f)\nEND_PROGRAM\n"
    assert_comes_back(compiled("p.ld", text, max_paren_depth=depth))


@pytest.mark.parametrize("depth", [None, 1, 0])
def test_types_functions_blocks_and_globals(depth: int | None, golden) -> None:
    program = compiled("wide.ld", WIDE, max_paren_depth=depth)
    text = print_program(program)
    again = compiled("again.il", text)
    assert print_program(again) == text
    for unit in program.units:
        assert not check_unit(unit, program.units)
    if depth is None:
        golden("il_text_wide.il", text)


@test_samples.samples
def test_a_sample_read_back_from_its_text_gives_the_same_trace(folder: Path) -> None:
    result = test_samples.compiled(folder, verify=False)
    if result.components:
        pytest.skip("the frame around a component has no text that is read (docs/components.md)")
    text = print_program(result.program)
    assert test_samples.traced(folder, compiled("again.il", text)) == (folder / "expected.csv").read_text()


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(programs(), st.sampled_from([None, 1, 0]))
def test_random_ladders(text: str, depth: int | None) -> None:
    sources = Sources((SourceFile("p.ld", text),), Settings(), None)
    program = pipeline.compile_project(sources, pipeline.Options(verify=False, max_paren_depth=depth)).program
    assume(program is not None)  # a network that leads nowhere
    assert_comes_back(program)


@pytest.mark.parametrize("name", blocks.names())
def test_standard_blocks_are_units_like_any_other(name: str) -> None:
    unit = standard.unit(name)
    assert unit.standard and not check_unit(unit)
    signature = blocks.signature(name)
    assert [v.name for v in unit.variables if v.kind == "input"] == [p.name for p in signature.inputs]
    assert [v.name for v in unit.variables if v.kind == "output"] == [p.name for p in signature.outputs]
    assert standard.unit(name) is unit


def test_there_is_no_such_standard_block() -> None:
    with pytest.raises(LookupError):
        standard.unit("TONN")


def test_the_time_and_the_first_scan_are_the_librarys_alone() -> None:
    sources = Sources((SourceFile("p.il", "PROGRAM p\nVAR t : TIME; END_VAR\nLD %NOW\nST t\nEND_PROGRAM\n"),),
                      Settings(), None)
    assert pipeline.compile_project(sources).diagnostics.has_errors


def test_the_text_of_the_drawing_can_stand_above_its_code() -> None:
    program = compiled("p.ld", "PROGRAM p\nVAR a, b : BOOL; END_VAR\nRUNG one\n    [a] (b) (* done *)\nEND_PROGRAM\n")
    text = print_program(program, sources=True)
    assert '(* | RUNG one *)\n(* | [a] (b)' in text
    assert plain(compiled("p.il", text).unit("p")) == plain(program.unit("p"))
