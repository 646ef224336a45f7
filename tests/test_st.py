"""Structured Text: what statements mean at their edges, what is told about wrong ones, how they are printed."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.diagnostics import Diagnostics
from ldc.il import text as il_text
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser import findings, lexer, parse_file
from ldc.parser.format import format_file
from ldc.source import SourceFile
from runtime.vm.machine import Machine
from runtime.vm.stepping import Stepper

PERIOD = 10_000_000
DECLARED = "VAR x, y, i : INT; k : SINT; u : USINT; q, p : BOOL; a, b : ARRAY [1..3] OF INT; w : WORD; t : TON; END_VAR\n"


def program(body: str, before: str = "") -> str:
    return f"{before}PROGRAM main\n{DECLARED}{body}\nEND_PROGRAM\n"


def machine(text: str, scans: int = 1, path: str = "main.st") -> Machine:
    """After some scans; the stepping mode must have come to the same state."""
    compiled_program = compiled(text, path).program
    one, other = (Machine(compiled_program, period_ns=PERIOD) for _ in range(2))
    for _ in range(scans):
        one.scan()
        Stepper(other).scan()
    assert len(one.faults) == len(other.faults)
    for name in ("x", "y", "i", "k", "u", "q", "p", "w"):
        assert one.get(name) == other.get(name), name
    return one


def compiled(text: str, path: str = "main.st") -> pipeline.Compiled:
    return pipeline.compile_project(Sources((SourceFile(path, text),), Settings(), None), pipeline.Options())


def codes(body: str, before: str = "") -> list[str]:
    return [d.code for d in compiled(program(body, before)).diagnostics]


@pytest.mark.parametrize(("head", "rounds", "after"), [
    ("FOR u := 250 TO 255 DO", 6, 255), ("FOR u := 5 TO 0 BY -1 DO", 6, 0), ("FOR u := 0 TO 10 BY 4 DO", 3, 12),
    ("FOR u := 1 TO 0 DO", 0, 1), ("FOR u := 200 TO 255 BY 100 DO", 1, 200), ("FOR u := 0 TO 0 BY -1 DO", 1, 0),
])
def test_a_for_ends_at_the_limit_of_its_type(head: str, rounds: int, after: int) -> None:
    found = machine(program(f"x := 0; {head} x := x + 1; END_FOR;"))
    assert (found.get("x"), found.get("u")) == (rounds, after)


def test_bounds_of_a_for_are_computed_once() -> None:
    found = machine(program("y := 3; FOR i := 1 TO y DO y := 10; x := x + 1; END_FOR;"))
    assert (found.get("x"), found.get("i")) == (3, 4)


def test_and_computes_both_sides() -> None:
    assert machine(program("q := x <> 0 AND 10 / x > 1;")).faults
    assert not machine(program("IF x <> 0 THEN q := 10 / x > 1; END_IF;")).faults


def test_an_endless_loop_is_stopped() -> None:
    found = Machine(compiled(program("WHILE TRUE DO x := 1; END_WHILE;"), "main.st").program, period_ns=PERIOD)
    found.scan()
    assert found.faults


def test_whole_arrays_bits_and_computed_indexes() -> None:
    found = machine(program("a[1] := 5; a[x + 2] := 7; b := a; a[1] := 0; w.3 := TRUE; y := b[1] + b[2];"))
    assert (found.get("y"), found.get("w")) == (12, 8)


SPLIT = """FUNCTION split : INT
VAR_INPUT v : INT; END_VAR
VAR_OUTPUT rest : SINT; END_VAR
VAR_IN_OUT times : INT; END_VAR
split := v / 10;
rest := INT_TO_SINT(v MOD 10);
times := times + 1;
END_FUNCTION
"""


def test_functions_with_outputs_are_called_from_left_to_right() -> None:
    found = machine(program("y := 9; x := y + split(v := 47, rest => y, times := i) * 100 + y;", SPLIT))
    assert (found.get("x"), found.get("y"), found.get("i")) == (9 + 400 + 7, 7, 1)
    found = machine(program("split(23, i, rest => k); x := split(v := 99, times := i);", SPLIT))
    assert (found.get("x"), found.get("k"), found.get("i")) == (9, 3, 2)


def test_a_statement_may_call_a_function_with_en_and_eno() -> None:
    found = machine(program("x := 5; split(EN := x > 9, v := 23, times := i, OUT => y, ENO => q); p := NOT q;", SPLIT))
    assert (found.get("y"), found.get("i"), found.get("q"), found.get("p")) == (0, 0, False, True)


def test_function_blocks_keep_their_state() -> None:
    found = machine(program("t(IN := TRUE, PT := T#20ms, Q => q); x := x + 1;"), 2)
    assert not found.get("q")
    assert machine(program("t(TRUE, T#20ms); q := t.Q;"), 3).get("q")


def test_ladders_and_statements_call_one_another() -> None:
    ladder = ("FUNCTION_BLOCK latch VAR_INPUT put, clear : BOOL; END_VAR VAR_OUTPUT out : BOOL; END_VAR\n"
              "RUNG { [put] | [out] } [/clear] (out)\nEND_FUNCTION_BLOCK\n"
              "PROGRAM main VAR q : BOOL; c : counter; n : INT; END_VAR\n"
              "RUNG [TRUE] <c: counter(total => n)> (q)\nEND_PROGRAM\n")
    statements = ("FUNCTION_BLOCK counter VAR_INPUT run : BOOL; END_VAR VAR_OUTPUT done : BOOL; total : INT; END_VAR\n"
                  "VAR l : latch; END_VAR\nIF run THEN total := total + 1; END_IF;\n"
                  "l(put := total = 2); done := l.out;\nEND_FUNCTION_BLOCK\n")
    sources = Sources((SourceFile("a.ld", ladder), SourceFile("b.st", statements)), Settings(), None)
    result = pipeline.compile_project(sources, pipeline.Options())
    assert not [d for d in result.diagnostics if d.severity == "error"]
    found = Machine(result.program, period_ns=PERIOD)
    for _ in range(4):
        found.scan()
    assert (found.get("n"), found.get("q")) == (4, True)


@pytest.mark.parametrize(("body", "expected"), [
    ("IF q THEN x := 1; FOR i := 1 TO 3 DO y := 1; END_IF;", ["LD0130"]),
    ("CASE x OF 1: IF q THEN y := 1; 2: y := 2; END_CASE;", ["LD0130"]),
    ("x = 5; y == 3; x := ;", ["LD0133", "LD0133", "LD0101"]),
    ("ENDIF; END_WHILE;", ["LD0101", "LD0131", "LD0131"]),
    ("WHLIE q DO x := 1; END_WHILE; ELSEIF", ["LD0101", "LD0133"]),
    ("x := 1\ny := 2\nt(IN := q)\n", ["LD0132", "LD0132", "LD0132"]),
    ("WHILE q x := 1; END_WHILE; REPEAT x := 1; END_REPEAT;", ["LD0136", "LD0136"]),
    ("CONTINUE; FOR i := 1 TO 3 DO CONTINUE; END_FOR;", ["LD0134"]),
    ("IF x THEN y := z; END_IF; WHILE t DO q := 5; END_WHILE;", ["LD0401", "LD0404", "LD0405", "LD0402"]),
    ("CASE x OF 1: ; 70000: ; 2, 1: ; END_CASE;", ["LD0402", "LD0420"]),
    ("x := t; t := x; q(); nix(3); x := t(IN := q);", ["LD0403", "LD0403", "LD0405", "LD0501", "LD0502"]),
    ("{pragma} x := 1; RUNG [q] (p)", ["LD0118", "LD0131"]),
])
def test_wrong_statements_are_told_each(body: str, expected: list[str]) -> None:
    assert codes(body) == expected


def test_blocks_nest_a_hundred_deep_and_no_deeper() -> None:
    for word, end in (("IF q THEN ", "END_IF; "), ("WHILE q DO ", "END_WHILE; "), ("FOR i := 1 TO 2 DO ", "END_FOR; ")):
        assert not [c for c in codes(word * 100 + "x := 1; " + end * 100) if c != "LD0425"]
        assert "LD0110" in codes(word * 101 + "x := 1; " + end * 101)
    machine(program("q := TRUE; " + "IF q THEN " * 100 + "x := 1; " + "END_IF; " * 100))
    machine(program("WHILE i < 2 DO " * 40 + "i := i + 1; " + "END_WHILE; " * 40))


def test_long_chains_of_arms_are_compiled() -> None:
    arms = " ELSIF ".join(f"x = {n} THEN y := {n};" for n in range(100))
    choices = " ".join(f"{n}: y := {n};" for n in range(300))
    assert machine(program(f"x := 77; IF {arms} END_IF;")).get("y") == 77
    assert machine(program(f"x := 277; CASE x OF {choices} ELSE y := 1; END_CASE;")).get("y") == 277


COMMENTED = """PROGRAM main
VAR
    x, y  : INT;
END_VAR

    // above
    x := (y + 1) * 2; (* behind *)
    IF x > 1 THEN  // opens
        y := 1;

        (* last in its block *)
    ELSIF x = 0 THEN
        ;
    END_IF;  // closed
    // at the end
END_PROGRAM
"""


def formatted(text: str) -> str:
    diagnostics = Diagnostics()
    file = parse_file(SourceFile("main.st", text), diagnostics)
    assert not list(diagnostics)
    return format_file(file)


def test_comments_stay_where_they_are() -> None:
    assert formatted(COMMENTED) == COMMENTED.replace("; (* behind", ";  (* behind")
    assert formatted(formatted(COMMENTED)) == formatted(COMMENTED)


@pytest.mark.parametrize("name", ["if", "case", "for", "while", "repeat"])
def test_listings(name: str, golden) -> None:
    body = {
        "if": "IF x > 3 THEN x := 0; ELSIF q THEN RETURN; ELSE y := 2 * x; END_IF;",
        "case": "CASE x OF 1: y := 1; 2, 4..7: y := 2; ELSE y := 0; END_CASE;",
        "for": "FOR i := 10 TO y BY -2 DO a[i] := i; IF q THEN CONTINUE; END_IF; p := TRUE; END_FOR;",
        "while": "WHILE x < 3 AND q DO x := x + 1; IF p THEN EXIT; END_IF; END_WHILE;",
        "repeat": "REPEAT t(IN := q, PT := T#1s, Q => p); UNTIL p END_REPEAT;",
    }[name]
    golden(f"st/{name}.il", il_text.print_program(compiled(program(body), "main.st").program))


WORDS = st.sampled_from("IF THEN ELSE ELSIF END_IF CASE OF END_CASE FOR TO BY DO END_FOR WHILE END_WHILE REPEAT UNTIL "
                        "END_REPEAT EXIT RETURN CONTINUE ; ; : := ( ) [ ] x y q t 1 2 .. , + AND NOT = < => . "
                        "END_PROGRAM VAR END_VAR RUNG PROGRAM 'a' (* //".split())


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=200)
@given(st.lists(WORDS, max_size=40))
def test_broken_text_never_ends_in_a_traceback(words: list[str]) -> None:
    codes(" ".join(words))


# ---- limits of a file


def parsed(path: str, text: str) -> list[str]:
    diagnostics = Diagnostics()
    parse_file(SourceFile(path, text), diagnostics)
    return [f"{d.code} {d.message}" for d in diagnostics]


@pytest.mark.parametrize("pieces", [[";" * 300_001], [";" * 150_001, ";" * 150_000]])
def test_a_file_has_a_limit_of_statements(pieces: list[str]) -> None:
    text = "".join(f"PROGRAM p{at}\n{body}\nEND_PROGRAM\n" for at, body in enumerate(pieces))
    assert parsed("a.st", text) == ["LD0111 the file has more than 300,000 statements"]
    assert not parsed("a.st", text.replace(";", "", 1))


def test_a_file_has_a_limit_of_symbols(monkeypatch) -> None:
    monkeypatch.setattr(lexer, "MOST_TOKENS", 999)
    monkeypatch.setattr(findings, "MOST_TOKENS", 999)
    assert not parsed("a.ld", "PROGRAM p " + "RUNG [a] (a) " * 130 + "END_PROGRAM")
    for unit in ("RUNG [a] (a) ", "VAR a : INT; END_VAR ", "VAR a : INT;", "& "):
        assert parsed("a.ld", "PROGRAM p " + unit * 999) == ["LD0111 the file has more than 999 symbols"]
