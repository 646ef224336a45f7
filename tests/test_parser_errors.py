"""What is wrong is said once, where it is, and the rest of the file is read; no text makes it fail."""

from __future__ import annotations

import time

import pytest
from everywhere import checked
from hypothesis import example, given, settings
from hypothesis import strategies as st
from test_format import CANONICAL

from ldc.diagnostics import Diagnostic, Diagnostics
from ldc.parser import ast, parse_expression, parse_file
from ldc.parser.lexer import KEYWORDS
from ldc.source import SourceFile


def read(text: str, path: str = "test.ld") -> tuple[ast.File, list[Diagnostic]]:
    diagnostics = Diagnostics()
    file = parse_file(SourceFile(path, text), diagnostics)
    return file, list(diagnostics)


def findings(text: str, path: str = "test.ld") -> list[str]:
    return [f"{d.code} {d.message}" for d in read(text, path)[1]]


def in_program(text: str) -> list[str]:
    return findings(f"PROGRAM p\n{text}\nEND_PROGRAM\n")


@pytest.mark.parametrize(("rung", "message"), [
    ("[a b] (q)", "LD0101 expected `]` or an operator after `a`, found `b`"),
    ("[a AND] (q)", "LD0101 expected an expression after `AND`, found `]`"),
    ("[a] q", "LD0101 expected `;` or an element after `]`, found `q`"),
    ("[a] (b AND c)", "LD0101 expected `)` after `b`, found `AND`"),
    ("[a] >>5", "LD0101 expected a name or RETURN after `>>`, found `5`"),
    ("[a] <t: TON>", "LD0101 expected `(` after `TON`, found `>`"),
    ("[a] <t: TON(PT := )>", "LD0101 expected an expression after `:=`, found `)`"),
    ("[a] <t: TON(PT := 5, Q =>)>", "LD0101 expected a variable or `@` after `=>`, found `)`"),
    ("[a.15.15] (q)", "LD0101 expected a number or a name after `.`, found `15.15`"),
    ("[a", "LD0108 `[` is not closed"),
    ("[x[1] (q)", "LD0108 `[` is not closed"),
    ("{ [a] | [b] (q)", "LD0108 `{` is not closed"),
    ("[MAX(a, b] (q)", "LD0108 `(` is not closed"),
    ("[a]] (q)", "LD0109 `]` closes nothing"),
    ("[a) (q)", "LD0109 `)` closes nothing"),
    ("{ } (q)", "LD0112 a branch is empty"),
    ("{ [a] | } (q)", "LD0112 a branch is empty"),
    ("{ | [a] } (q)", "LD0112 a branch is empty"),
    ("", "LD0113 the rung has no elements"),
    (';', "LD0113 the rung has no elements"),
    ("[IF] (q)", "LD0116 `IF` is a reserved word"),
    ("[S a] (q)", "LD0122 a contact has no modifier `S`"),
    ("[a > 12ab] (q)", "LD0105 this is no literal"),
    ("[a > 18446744073709551616] (q)", "LD0106 no type holds this number"),
    ("[a > -9223372036854775809] (q)", "LD0106 no type holds this number"),
    ("[a > 1e400] (q)", "LD0106 no LREAL holds this number"),
    ("[a = 'x$q'] (q)", "LD0107 `$q` stands for no character"),
    ("[a = 'x] (q)", "LD0104 the string is not closed in its line"),
    ("[\x00a] (q)", "LD0102 the character U+0000 is a control character"),
    ("[a] (q) (* open", "LD0103 the comment is not closed"),
])
def test_a_wrong_rung(rung: str, message: str) -> None:
    assert in_program(f"RUNG {rung}") == [message]


def test_every_bad_rung_and_declaration_is_told_and_the_rest_is_read() -> None:
    file, found = read("""PROGRAM p
        VAR a : BOOL; b : ; c : INT; d = 5; e : REAL; END_VAR
        RUNG one [a (q)
        RUNG two [a] (q)
        RUNG three { [a] | } (q)
        RUNG four [b] (q)
        END_PROGRAM""")
    assert [d.code for d in found] == ["LD0101", "LD0101", "LD0108", "LD0112"]
    assert [v.name for v in file.pous[0].var_blocks[0].variables] == ["a", "c", "e"]
    assert [r.name for r in file.pous[0].body.rungs] == ["two", "four"]


def test_an_open_bracket_is_shown_where_it_was_opened() -> None:
    _, (found,) = read("PROGRAM p RUNG { [a] | [b] (q)\nRUNG [a] (q) END_PROGRAM")
    assert [label.span.text for label in found.secondary] == ["{"]
    assert found.primary.span.position == (1, 31)


@pytest.mark.parametrize(("text", "word"), [
    ("PROGRAM p RUNG [a] (q) Rnug b [a] (q) END_PROGRAM", "RUNG"),
    ("PROGRAM p Rnug b [a] (q) END_PROGRAM", "RUNG"),
    ("PROGRAM p VAR_INPT a : BOOL; END_VAR END_PROGRAM", "VAR_INPUT"),
    ("PROGRM p END_PROGRAM", "PROGRAM"),
    ("PROGRAM p RUNG [a ADN b] (q) END_PROGRAM", "AND"),
    ("CONFIGURATION c RESOURCE r ONN m END_RESOURCE END_CONFIGURATION", "ON"),
])
def test_a_keyword_with_a_slip_is_guessed(text: str, word: str) -> None:
    _, (found,) = read(text)
    assert found.help == f"did you mean `{word}`?"


@pytest.mark.parametrize(("text", "codes"), [
    ("PROGRAM p RUNG [a] (q) END_PRGRAM", ["LD0120 `END_PRGRAM` stands where END_PROGRAM was expected"]),
    ("PROGRAM p VAR a : BOOL; END_VR RUNG [a] (a) END_PROGRAM",
     ["LD0120 `END_VR` stands where END_VAR was expected"]),
    ("PROGRAM p RUNG [a] (q) END_FUNCTION", ["LD0120 `END_FUNCTION` stands where END_PROGRAM was expected"]),
    ("PROGRAM p RUNG [a] (q)", ["LD0119 END_PROGRAM is missing"]),
    ("PROGRAM p RUNG [a] (q) PROGRAM r END_PROGRAM", ["LD0119 END_PROGRAM is missing"]),
    ("PROGRAM p VAR a : BOOL; RUNG [a] (a) END_PROGRAM", ["LD0119 END_VAR is missing"]),
    ("TYPE a : INT; PROGRAM p END_PROGRAM", ["LD0119 END_TYPE is missing"]),
    ("CONFIGURATION c RESOURCE r ON m END_CONFIGURATION", ["LD0119 END_RESOURCE is missing"]),
    ("PROGRAM p (* open", ["LD0103 the comment is not closed"]),
    ("", ["LD0114 there is nothing in this file"]),
    (" (* only *) // this", ["LD0114 there is nothing in this file"]),
    ("RUNG [a] (q)", ["LD0115 `RUNG` stands outside of any program"]),
    ("PROGRAM p END_PROGRAM and more", ["LD0115 `and` stands outside of any program"]),
    ("PROGRAM p RUNG [a] (q) VAR a : BOOL; END_VAR END_PROGRAM",
     ["LD0121 declarations stand before the body"]),
    ("PROGRAM p VAR {x} a : BOOL; END_VAR END_PROGRAM", ["LD0118 this pragma is not understood"]),
    ("PROGRAM p x := 5; END_PROGRAM", ["LD0101 expected RUNG or END_PROGRAM, found `x`"]),
    ("PROGRAM p VAR at : BOOL; int : INT; END_VAR END_PROGRAM",
     ["LD0116 `at` is a reserved word", "LD0116 `int` is a reserved word"]),
    ("PROGRAM p VAR AT %QX5.1 : BOOL := 1; AT %MW6 : INT; END_VAR END_PROGRAM", []),
    ("PROGRAM p VAR AT %MW6; AT x : INT; b : INT; END_VAR END_PROGRAM",
     ["LD0101 expected `:` after `%MW6`, found `;`", "LD0101 expected an address after `AT`, found `x`"]),
    ("CONFIGURATION c TASK t (INTERVAL := T#1s); END_CONFIGURATION", []),
    ("CONFIGURATION c RESOURCE r ON p END_RESOURCE TASK t (INTERVAL := T#1s); END_CONFIGURATION",
     ["LD0101 expected RESOURCE or END_CONFIGURATION, found `TASK`"]),
    ("CONFIGURATION c TASK t (PRIORITY := 1); RESOURCE r ON p END_RESOURCE END_CONFIGURATION",
     ["LD0101 expected TASK, PROGRAM or END_CONFIGURATION, found `RESOURCE`"]),
    ("FUNCTION f : VAR_INPUT a : INT; END_VAR END_FUNCTION",
     ["LD0101 expected a type after `:`, found `VAR_INPUT`"]),
])
def test_a_wrong_file(text: str, codes: list[str]) -> None:
    assert findings(text) == codes


def test_an_array_without_its_keyword_gets_advice() -> None:
    _, (found,) = read("TYPE t : ARAY [1..2] OF INT; END_TYPE")
    assert found.help == "an array is `ARRAY [1..n] OF type`, a subrange `INT (0..n)`"


@pytest.mark.parametrize(("path", "body", "help"), [
    ("x.st", "IF a := 3 THEN a := 1; END_IF;", "`:=` assigns; write `=` to compare"),
    ("x.ld", "RUNG [a := 3] (b)", "`:=` assigns; write `=` to compare"),
    ("x.st", "a += 1;", "write the variable on both sides: `a := a + b`"),
])
def test_habits_of_other_languages_get_advice(path: str, body: str, help: str) -> None:
    _, (found,) = read(f"PROGRAM p VAR a : INT; b : BOOL; END_VAR {body} END_PROGRAM", path)
    assert found.help == help


def test_a_missing_semicolon_costs_only_its_own_declaration() -> None:
    lines = "a : BOOL\n b, c : INT; d : REAL\n e AT %IX0.0 : BOOL;"
    file, found = read(f"PROGRAM p VAR {lines} END_VAR END_PROGRAM")
    assert [d.help for d in found] == ["end the declaration with `;`"] * 2
    assert [v.name for v in file.pous[0].var_blocks[0].variables] == ["b", "c", "e"]


@pytest.mark.parametrize(("rung", "help"), [
    ("[a] | [b] (q)", "branches stand in braces: `{ [a] | [b] }`"),
    ("[a] <t: TON(PT := 50ms)> (q)", "a time is written `T#50ms`"),
])
def test_what_beginners_write_in_a_rung(rung: str, help: str) -> None:
    _, (found,) = read(f"PROGRAM p\nRUNG {rung}\nEND_PROGRAM\n")
    assert found.help == help


@pytest.mark.parametrize(("text", "incomplete"), [
    ("PROGRAM p RUNG r [a (q) END_PROGRAM", False),
    ("PROGRAM p RUNG r [a (q) RUNG [b] >>R END_PROGRAM", True),
    ("PROGRAM p VAR a : ; END_VAR END_PROGRAM", True),
    ("PROGRAM 5 END_PROGRAM", True),
    ("PROGRAM p VAR a : BOOL; END_VAR RUNG [a] (a) END_PROGRAM", False),
])
def test_a_file_tells_whether_names_were_lost(text: str, incomplete: bool) -> None:
    assert read(text)[0].incomplete is incomplete


# ---- limits


def test_deep_nesting_ends_at_the_bracket_that_is_too_much() -> None:
    def nested(levels: int) -> str:
        return "RUNG [" + "(" * (levels - 1) + "a" + ")" * (levels - 1) + "] (q)"

    assert in_program(nested(100)) == []
    _, (found,) = read(f"PROGRAM p\n{nested(101)}\nEND_PROGRAM")
    assert (found.code, found.primary.span.position) == ("LD0110", (2, 106))
    assert in_program("RUNG [" + "NOT " * 101 + "a] (q)") == [
        "LD0110 NOT and signs are nested more than 100 levels deep"]
    assert in_program("RUNG " + "{ " * 50_000)[0].startswith("LD0110")


def test_an_expression_has_a_limit_and_a_chain_of_elements_has_none() -> None:
    assert in_program("RUNG [" + "a + " * 999 + "a > 1] (q)") == []
    too_long = ["LD0111 the expression has more than 1,000 operators"]
    assert in_program("RUNG [" + "a + " * 1000 + "a > 1] (q)") == too_long
    assert in_program("VAR x : INT := " + "a + " * 1001 + "1; END_VAR") == too_long
    assert in_program("RUNG [x" + ".y" * 1001 + "] (q)") == too_long
    assert in_program("RUNG " + "[/a > 1] " * 10_000 + "<f(" + "a := 1 + b[1], " * 1000 + "c)> (q)") == []
    assert in_program("RUNG " + "[a] " * 100_000)[0] == "LD0111 the rung has more than 200,000 symbols"


@pytest.mark.parametrize("line", [
    "a" * 10_000_000, "(" * 1_000_000, "'" * 1_000_000, "(*" * 3_000_000, "[a] " * 300_000, "9" * 10_000_000,
    "1_" * 3_000_000, "T#" + "1d" * 2_000_000, "\x00" * 5_000_000, "'$" * 3_000_000, "RUNG " * 50_000,
    "a.b" * 500_000,
], ids=lambda line: line[:6].strip())
def test_a_huge_line_neither_hangs_nor_explodes(line: str) -> None:
    """Linear time, and messages that show only the beginning of what is wrong."""
    start = time.process_time()
    _, found = read(f"PROGRAM p RUNG [{line}] (q) END_PROGRAM")
    assert time.process_time() - start < 20
    for diagnostic in found[:50]:
        assert max(len(diagnostic.message), len(diagnostic.primary.text), len(diagnostic.help)) < 300


# ---- anything at all


WORDS = st.sampled_from([
    *KEYWORDS, "a", "b", "t", "TON", "5", "1.5", "T#1s", "'x'", '"t"', "INT", "%IX0.0", "[", "]", "(", ")",
    "{", "}", "<", ">", "|", ";", ":", ":=", "=>", "@", ">>", ",", ".", "..", "=", "_", "(*", "*)", "//",
    "\n",
    "'", '"', "§", "\x00", "é", "16#", "INT#", "$", "/", "+", "-", "**",
])


@given(st.text(max_size=200), st.sampled_from(["x.ld", "x.st", "x.il", "x"]))
@settings(max_examples=200)
def test_random_text_never_raises(text: str, path: str) -> None:
    file, found = read(text, path)
    assert found or file.pous or file.types or file.globals or file.configurations


@given(st.lists(WORDS, max_size=60).map(" ".join), st.sampled_from(["x.ld", "x.st"]), st.booleans())
@example("PROGRAM", "x.ld", False)
@example("CONFIGURATION", "x.ld", False)
@example("RESOURCE", "x.ld", True)
@settings(max_examples=400, deadline=None)
def test_random_words_never_raise(text: str, path: str, inside: bool) -> None:
    read(f"PROGRAM p {text} END_PROGRAM" if inside else text, path)


@given(st.integers(0, len(CANONICAL)), st.integers(0, 30), WORDS)
@settings(max_examples=300, deadline=None)
def test_a_damaged_file_never_raises(start: int, length: int, word: str) -> None:
    read(CANONICAL[:start] + word + CANONICAL[start + length :])


@given(st.lists(WORDS, max_size=12).map(" ".join))
def test_random_expressions_are_read_or_told(text: str) -> None:
    diagnostics = Diagnostics()
    tree = parse_expression(SourceFile("x.il", text), 0, len(text), diagnostics)
    assert (tree is None) == bool(len(diagnostics))


@pytest.mark.parametrize("body, help", [
    ("a := n == m;", "write `=` to compare"), ("a := n != m;", "write `<>` to compare"), ("a := a && b;", "write AND"),
    ("a := b || a;", "write OR"), ("a := !b;", "write NOT"), ("n := m << 2;", "write `SHL(bits, 2)`"),
    ("n := m >> 2;", "write `SHR(bits, 2)`"), ("n := m % 2;", "a remainder is `a MOD b`, an address `%IX0.0`"),
    ("n := a ? 1 : 2;", "write `SEL(condition, else, then)`, or IF"),
    ("s1 := 'x' + 'y';", "texts are joined by `CONCAT(a, b)`"), ("n := list;", "take one element of it, `array[index]`"),
    ("TON1(IN := a);", "declare an instance in VAR: `TON1 : TON;`"),
])
def test_what_people_know_from_other_languages_is_translated(body: str, help: str) -> None:
    text = f"""PROGRAM main VAR a, b : BOOL; n, m : INT; s1 : STRING; list : ARRAY [0..1] OF INT; END_VAR
    {body}
END_PROGRAM"""
    found = checked(text, "main.st").diagnostics
    assert next(d.help for d in found if d.severity == "error") == help


@pytest.mark.parametrize("rung, help", [
    ("[a | b] (q)", "write `[a OR b]`, or branches in braces, `{ [a] | [b] }`"),
    ("[a] <t(PT := T#1s)> (q)", "`t` is an instance: write `<t: TON(...)>`"),
])
def test_what_people_draw_first_is_put_right(rung: str, help: str) -> None:
    text = f"PROGRAM main VAR a, b, q : BOOL; t : TON; END_VAR RUNG {rung} END_PROGRAM"
    found = checked(text, "main.ld").diagnostics
    assert next(d.help for d in found if d.severity == "error") == help
