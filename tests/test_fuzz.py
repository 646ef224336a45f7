"""Whatever a text is: it is wrong and told, or it is proved, runs, is drawn, formatted and read back."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.diagnostics import Diagnostics
from ldc.draw import pins_from, pou_text, rung_svg, rung_text
from ldc.il import image, text as il_text
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser import ast, format_of, parse_file
from ldc.parser.format import format_file
from ldc.render import render
from ldc.source import SourceFile
from runtime.vm.machine import Machine

TESTS = Path(__file__).resolve().parent
SOURCES = tuple(
    path.read_text(encoding="utf-8", errors="replace")
    for folder in (TESTS.parent / "samples", TESTS / "errors") for path in sorted(folder.rglob("*.ld"))
    if path.is_file() and path.stat().st_size < 20_000
)
PIECE = re.compile(
    r"\(\*.*?\*\)|//[^\n]*|'[^'\n]*'|\"[^\"\n]*\"|[A-Za-z_]\w*#?|\d[\w.#]*|\s+|:=|=>|>>|.", re.DOTALL)
WORDS = (
    *"[ ] ( ) { } < > | ; : , . @ / % # $ ' \" + - * & = := => >> .. <> <= ** (* *) //".split(),
    *"a b c q x n t P N S R NOT AND OR XOR MOD TRUE FALSE 0 1 -1 7 255 32767 1.5 1.0e38 16#FF 2#1".split(),
    *"T#1s T#0s T#-1ms WORD#16#FFFF INT#-5 'text' \"text\" %IX0.0 %QX0.1 %MW3 %QD2 RETURN".split(),
    *"in=_ out=Q in=IN EN ENO IN Q PT CU PV BOOL INT DINT REAL LREAL TIME STRING WORD BYTE LINT UINT".split(),
    *"TON TOF TP CTU CTUD SR RS R_TRIG DATE ADD SUB MUL DIV MOVE SEL MUX LIMIT MAX LEN LEFT CONCAT".split(),
    *"SHL ROL INT_TO_REAL REAL_TO_INT SQRT EXPT ABS TRUNC PROGRAM END_PROGRAM FUNCTION END_FUNCTION".split(),
    *"FUNCTION_BLOCK END_FUNCTION_BLOCK VAR VAR_INPUT VAR_OUTPUT VAR_IN_OUT VAR_TEMP VAR_EXTERNAL".split(),
    *"VAR_GLOBAL CONSTANT RETAIN END_VAR TYPE END_TYPE STRUCT END_STRUCT AT ARRAY OF RUNG RUNG RUNG".split(),
    *"CONFIGURATION RESOURCE TASK ON WITH IF THEN _ _ldc_t1 main".split(),
    "[a]", "[/b]", "[P a]", "(q)", "(S q)", "@x", ">>RETURN", "ARRAY [0..3] OF INT", "{ [a] | [b] }",
    "<t: TON(PT := T#1s)>", "<MOVE(IN := 1, OUT => n)>", "\n", " ", "\0", "é", "\U0001f600",
)


def exercise(text: str, depth: int | None = None) -> bool:
    """All that can be done with a text in memory; whether it is a program."""
    source = SourceFile("main.ld", text)
    found = Diagnostics()
    file = parse_file(source, found)
    errors = found.has_errors
    if not errors and format_of(source) is None:
        again = SourceFile("main.ld", format_file(file))
        second = Diagnostics()
        assert format_file(parse_file(again, second)) == again.text
        assert not second.has_errors, again.text
    result = pipeline.compile_project(
        Sources((source,), Settings(), None), pipeline.Options(max_paren_depth=depth))
    said = render(result.diagnostics)
    assert all(d.code < "LD09" for d in result.diagnostics), said
    pins = {"pins_of": pins_from(result.model.signatures)}
    for pou in file.pous:
        if isinstance(pou.body, ast.LadderBody):
            pou_text(pou, comments=file.comments, **pins)
            for rung in pou.body.rungs:
                rung_text(rung, width=60, **pins)
                rung_svg(rung, **pins)
    assert errors <= result.diagnostics.has_errors
    if result.diagnostics.has_errors:
        assert result.program is None
        return False
    assert {build.verdict.kind for builds in result.units.values() for build in builds} <= {"proof", "check"}
    if any(resource.runs for resource in result.program.resources):
        run(result)
    read_back(result)
    return True


def run(result: pipeline.Compiled) -> list:
    number = next(i for i, resource in enumerate(result.program.resources) if resource.runs)
    machine = Machine(result.program, number)
    for _ in range(3):
        machine.scan()
    return machine.faults


def read_back(result: pipeline.Compiled) -> None:
    printed = il_text.print_program(result.program)
    again = pipeline.compile_project(Sources((SourceFile("main.il", printed),), Settings(), None))
    assert not again.diagnostics.has_errors, printed + render(again.diagnostics)
    assert il_text.print_program(again.program) == printed
    image.build(again.program, None)


def mutated(text: str, seed: int, edits: int) -> str:
    """A text with words, lines or characters taken out, doubled, exchanged or put in."""
    chosen = random.Random(seed)
    pattern = chosen.choice((PIECE, PIECE, re.compile(r"[^\n]*\n?"), re.compile(".", re.DOTALL)))
    pieces = [p for p in pattern.findall(text) if p]
    for _ in range(edits):
        at, other = (chosen.randrange(len(pieces) or 1) for _ in range(2))
        match chosen.randrange(5):
            case 0:
                del pieces[at : at + chosen.choice((1, 1, 1, 3))]
            case 1:
                pieces[at:at] = pieces[other : other + chosen.choice((1, 1, 3, 8))]
            case 2 if pieces:
                pieces[at], pieces[other] = pieces[other], pieces[at]
            case 3:
                pieces.insert(at, chosen.choice(WORDS))
            case 4 if pieces:
                pieces[at] = chosen.choice(WORDS)
    return "".join(pieces)


DECLARED = """
FUNCTION half : INT VAR_INPUT a : INT; END_VAR RUNG <DIV(IN1 := a, IN2 := 2, OUT => half)> END_FUNCTION
VAR_GLOBAL g : INT; END_VAR
FUNCTION_BLOCK fc
VAR_INPUT i, j : BOOL; END_VAR VAR_OUTPUT o : BOOL; v, w : INT; END_VAR VAR_EXTERNAL g : INT; END_VAR
RUNG { [i] | [o] } [/j] (o)
RUNG [i] <ADD(IN1 := g, IN2 := 1, OUT => g)>
END_FUNCTION_BLOCK
PROGRAM main
VAR_EXTERNAL g : INT; END_VAR
VAR
    a, b, q : BOOL; i, j : INT; x : REAL; sb : INT (0..9);
    iw AT %IW2 : INT; ar : ARRAY [0..3] OF INT; ab : ARRAY [1..4] OF BOOL; fa : ARRAY [0..9] OF fc; c1 : CTU;
END_VAR
"""
FOUND = (
    "RUNG [q] <MOVE(IN := 1 MOD ar[j + 1], OUT => i)>",
    "RUNG [q] <MOVE(IN := EXPT(x, ar[j + 1]), OUT => x)>",
    "RUNG [q] <MOD(IN1 := 1, IN2 := ar[j + 1], OUT => i)> (a)",
    "RUNG [q] <MOVE(IN := i / ar[j + 1], OUT => ar[ar[j]])> (a)",
    "RUNG [q] <c1: CTU(R := a, PV := 3, CV => ar[j + 1])> (a)",
    "RUNG [q] <fa[i + 1]: fc(j := a)> (a)",
    "RUNG [q] <fa[half(ar[i])]: fc(j := fa[1].o)> (a)",
    "RUNG [q] <fa[g]: fc(v => i, w => j)> (a)",
    "RUNG [q] <fa[iw]: fc(j := a)> (a)",
    "RUNG [q] <fa[i]: fc(v => i, w => j)> (a)",
    "RUNG [q] <ADD(IN1 := 1, IN2 := i, OUT => i)> <MOVE(IN := 3, OUT => ar[i])> [ar[i] > 2] (ab[i + 1])",
    "RUNG [a] <ADD(IN1 := 1 MOD 1, IN2 := 0, OUT => sb)> (b)",
    "RUNG [q] <DIV(IN1 := sb, IN2 := 1 MOD 1, OUT => i)> (a)",
    "RUNG [q] <ADD(IN1 := sb, IN2 := -sb, IN3 := i, OUT => i)> (a)",
    "RUNG [q] <half(a := sb / (1 / 1), OUT => ar[i])> (a)",
    "RUNG <GT(IN1 := -1, IN2 := sb, OUT => q)>",
    "",
)
"""Found by random programs: values with computed indexes behind power, instances with indexes that their
own call changes, no rungs at all."""


@pytest.mark.parametrize("rung", FOUND)
@pytest.mark.parametrize("depth", (None, 1))
def test_what_random_programs_found(rung: str, depth: int | None) -> None:
    assert exercise(f"{DECLARED}{rung}\nEND_PROGRAM\n", depth)


def test_an_instance_is_chosen_once(tmp_path) -> None:
    """The call changes the index by which its instance was found; its outputs are those of that instance."""
    text = f"{DECLARED}RUNG [a] <fa[g]: fc()> (q)\nEND_PROGRAM\n".replace("a, b, q", "a : BOOL := TRUE; b, q")
    result = pipeline.compile_project(Sources((SourceFile("main.ld", text),), Settings(), None))
    machine = Machine(result.program, 0)
    machine.scan()
    assert [machine.get(n) for n in ("q", "fa[0].o", "g")] == [True, True, 1]


LIMITS = settings(deadline=None, max_examples=150, suppress_health_check=list(HealthCheck))


@LIMITS
@given(st.sampled_from(SOURCES), st.integers(0, 1 << 40), st.integers(1, 4), st.sampled_from((None, 1, 2)))
def test_changed_programs(source: str, seed: int, edits: int, depth: int | None) -> None:
    exercise(mutated(source, seed, edits), depth)


@LIMITS
@given(st.lists(st.sampled_from(WORDS), max_size=12))
def test_rungs_of_any_words(words: list[str]) -> None:
    exercise(f"{DECLARED}RUNG {' '.join(words)}\nEND_PROGRAM")


@LIMITS
@given(st.lists(st.sampled_from(WORDS), max_size=40).map(" ".join) | st.text(max_size=200))
@example("\0")
def test_any_text(text: str) -> None:
    exercise(text)
