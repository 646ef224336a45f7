"""The canonical form: the same tree, stable, comments kept, lines no wider than they must be."""

from __future__ import annotations

import re

from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import expressions, junction_rungs, program_text, sp_rungs
from test_parser import DECLARATIONS, bare, parsed

from ldc.cli.main import main
from ldc.parser import ast
from ldc.parser.format import format_file
from ldc.parser.layout import WIDTH
from ldc.parser.lexer import lex
from ldc.parser.unparse import expr_text
from ldc.source import SourceFile


def tree(file: ast.File) -> object:
    return tuple(map(bare, (file.pous, file.types, file.globals, file.configurations)))


def remarks(file: ast.File) -> list[str]:
    """What the comments say, whatever their delimiters and place."""
    return sorted(re.sub(r"^//|^\(\*|\*\)$", "", c.text).strip() for c in file.comments)


def formatted(text: str, path: str = "test.ld") -> str:
    """The canonical form, after checking that it is one."""
    file = parsed(text, path)
    once = format_file(file)
    again = parsed(once, path)
    assert tree(again) == tree(file)
    assert remarks(again) == remarks(file)
    assert format_file(again) == once
    assert all(line == line.rstrip() for line in once.split("\n"))
    return once


CANONICAL = '''\
(* The infeed. *)

PROGRAM conveyor "Infeed conveyor"
VAR
    start  AT %IX0.0 : BOOL;  // the green button
    stop   AT %IX0.1 : BOOL := TRUE;
    motor  AT %QX0.0 : BOOL;

    (* counted here *)
    warm   : TON;             (* from the motor *)
    parts  : CTU := (PV := 5);
    a, b   : INT := -1;
END_VAR
VAR_OUTPUT RETAIN
    full  : BOOL;
END_VAR

// the usual thing
RUNG seal_in "Start/stop with seal-in"
    { [start] | [motor] } [/stop] (motor)

RUNG
    [motor] <warm: TON(PT := T#2s)>
        { (ready)
        | (S started)
        | [P eye] <parts: CTU(R := { [reset] | [clear] }, PV := 100, CV => count)> (full)
        }

RUNG bridge  // not series-parallel
    // the upper part
    { [a] @x [b] | [c] @y [d] } (q);  (* first *)
    @x [e] (* between *) @y

RUNG
    [fault] >>RETURN  (* leave *)

// the end
END_PROGRAM

TYPE
    Colour : (red, green := 5) := green;
    Point : STRUCT
        x, y  : REAL := 1.0;  // mm
        // deep
        z     : STRUCT
            ok  : BOOL;
        END_STRUCT;
    END_STRUCT;
END_TYPE

VAR_GLOBAL CONSTANT
    limit  : INT := 5;
END_VAR

CONFIGURATION plant
    RESOURCE master ON cpu
        TASK fast (INTERVAL := T#10ms, PRIORITY := 1);
        PROGRAM main WITH fast : conveyor;  // the only one
    END_RESOURCE
END_CONFIGURATION
'''


def test_the_canonical_form_stays_as_it_is() -> None:
    assert formatted(CANONICAL) == CANONICAL


def test_any_spacing_comes_to_the_canonical_form() -> None:
    """Blanks and blank lines between tokens are of no account, but for the one that keeps a comment apart."""
    squeezed = re.sub(r"\n {2,}", "\n", CANONICAL)
    squeezed = squeezed.replace(" := ", ":=").replace("  :", ":").replace("{ ", "{")
    assert formatted(squeezed) == CANONICAL


def test_long_rungs_are_broken() -> None:
    many = " ".join(f"[contact_number_{i}]" for i in range(9))
    total = " + ".join(["summand"] * 9)
    text = f"""PROGRAM p RUNG {{ {many} | {{ {many} | [x] }} }} (q);
        [y] <f: FB(first := {{ {many} | [x] }}, second := {total}, third => z) out=Q> (r) END_PROGRAM"""
    assert formatted(text) == '''\
PROGRAM p

RUNG
    { [contact_number_0] [contact_number_1] [contact_number_2] [contact_number_3]
      [contact_number_4] [contact_number_5] [contact_number_6] [contact_number_7]
      [contact_number_8]
    | { [contact_number_0] [contact_number_1] [contact_number_2] [contact_number_3]
        [contact_number_4] [contact_number_5] [contact_number_6] [contact_number_7]
        [contact_number_8]
      | [x]
      }
    } (q);
    [y]
        <f: FB(
            first := { [contact_number_0] [contact_number_1] [contact_number_2] [contact_number_3]
                       [contact_number_4] [contact_number_5] [contact_number_6] [contact_number_7]
                       [contact_number_8]
                     | [x]
                     },
            second := {total},
            third => z) out=Q> (r)
END_PROGRAM
'''.replace("{total}", total)


def test_bodies_in_instruction_list_are_left_alone() -> None:
    text = "FUNCTION f:INT VAR_INPUT a:INT;END_VAR // c\n\n  f := a  +  1; (* x *) \n\n\nEND_FUNCTION"
    assert formatted(text, "x.il") == (
        "FUNCTION f : INT\nVAR_INPUT\n    a  : INT;\nEND_VAR  // c\n  f := a  +  1; (* x *)\nEND_FUNCTION\n")


def test_parentheses_are_only_where_they_must_be() -> None:
    source = "((a) OR (b AND (c))) = (NOT (d)) AND (e > (f + (g - h)))"
    file = parsed(f"PROGRAM p RUNG [{source}] (q) END_PROGRAM")
    assert expr_text(file.pous[0].body.rungs[0].paths[0].items[0].expr) == (
        "(a OR b AND c) = NOT d AND e > f + (g - h)")


def test_deep_and_long_things_are_formatted() -> None:
    deep = "{ [x] | " * 99 + "[y]" + " }" * 99
    formatted(f"PROGRAM p RUNG {deep} (q) END_PROGRAM")
    long = "RUNG " + "[abc] " * 10_000 + "(q) RUNG [" + "a + " * 999 + "b > 1] (q)"
    once = format_file(parsed(f"PROGRAM p {long} END_PROGRAM"))
    assert format_file(parsed(once)) == once


RUNGS = st.lists(sp_rungs(max_leaves=60) | junction_rungs(), min_size=1, max_size=3)


@given(RUNGS, st.lists(expressions(), max_size=2))
@settings(deadline=None)
def test_random_programs(drawn: list[ast.Rung], contacts: list[ast.Expr]) -> None:
    extra = "".join(f"[{expr_text(e)}] " for e in contacts)
    result = formatted(program_text(drawn).replace("END_PROGRAM", f"RUNG {extra}[a0] (q0) END_PROGRAM"))
    for line in result.split("\n"):  # what is too wide is one element, or stands behind deep braces
        assert len(line) <= WIDTH or len(re.findall(r"[\])] [\[(]", line)) == 0 or "'" in line or '"' in line


SPACE = st.sampled_from([" ", "\n", "\n\n\n", "  "])
NOTE = st.sampled_from(["(* note *)", "// line\n", "(* two\n   lines *)", "(**)", "\n(* own *)\n",
                        "\n// own\n", "(* long " + "x" * 60 + " *)"])


@st.composite
def commented(draw, text: str) -> str:
    """The tokens of a text with spaces and comments between them."""
    tokens = lex(SourceFile("x.ld", text))
    between = st.lists(NOTE | SPACE, max_size=3)
    places = draw(st.dictionaries(st.integers(0, len(tokens.types)), between, max_size=12))
    parts = []
    for index in range(len(tokens.types)):
        parts += places.get(index, ())
        parts += (tokens.text(index), draw(SPACE) if index in places else " ")
    return "".join(parts) + "".join(places.get(len(tokens.types), ()))


@given(st.data())
@settings(deadline=None, max_examples=120)
def test_comments_anywhere_are_kept(data: st.DataObject) -> None:
    text = data.draw(st.sampled_from([CANONICAL, DECLARATIONS]) | sp_rungs().map(lambda r: program_text([r])))
    formatted(data.draw(commented(text)))


def test_files_of_other_tools_are_left_as_they_are(tmp_path, capsys) -> None:
    text = "LDmicro0.2\nCYCLE=10000 us\nPROGRAM\nRUNG 1\n  CONTACTS Xstart 0 0\n  COIL Ymotor 0 0 0 0\nEND\n"
    (tmp_path / "old.ld").write_text(text)
    assert main(["fmt", str(tmp_path / "old.ld")]) == 0
    assert (tmp_path / "old.ld").read_text() == text
    assert "is a file of LDmicro" in capsys.readouterr().err
