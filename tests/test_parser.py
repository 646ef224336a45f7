"""What is written becomes the tree that the language describes."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from strategies import expressions, junction_rungs, program_text, sp_rungs

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, parse_expression, parse_file
from ldc.parser.unparse import expr_text, paths_text, rung_text
from ldc.source import SourceFile, Span


def bare(node: object) -> object:
    """A tree without its spans."""
    if isinstance(node, Span):
        return None
    if dataclasses.is_dataclass(node):
        return (type(node).__name__, *(bare(getattr(node, f.name)) for f in dataclasses.fields(node)
                                       if f.name != "source"))
    return tuple(map(bare, node)) if isinstance(node, tuple) else node


def parsed(text: str, path: str = "test.ld") -> ast.File:
    diagnostics = Diagnostics()
    file = parse_file(SourceFile(path, text), diagnostics)
    assert [f"{d.code} {d.message}" for d in diagnostics] == []
    return file


def rungs(text: str) -> tuple[ast.Rung, ...]:
    return parsed(f"PROGRAM p\n{text}\nEND_PROGRAM\n").pous[0].body.rungs


def expression(text: str) -> ast.Expr:
    diagnostics = Diagnostics()
    tree = parse_expression(SourceFile("test.ld", text), 0, len(text), diagnostics)
    assert [d.message for d in diagnostics] == []
    return tree


@pytest.mark.parametrize(("text", "grouped"), [
    ("a OR b AND c XOR d", "(a OR ((b AND c) XOR d))"),
    ("a - b - c", "((a - b) - c)"),
    ("a ** b ** c", "((a ** b) ** c)"),
    ("-a ** b", "(-a ** b)"),
    ("NOT a AND b", "(NOT a AND b)"),
    ("a = b < c", "(a = (b < c))"),
    ("a < b = c > d", "((a < b) = (c > d))"),
    ("a + b * c MOD d - e", "((a + ((b * c) MOD d)) - e)"),
    ("a & b or c", "((a AND b) OR c)"),
    ("(a OR b) AND c", "((a OR b) AND c)"),
])
def test_precedence_is_that_of_the_standard(text: str, grouped: str) -> None:
    """IEC 61131-3, 2nd edition, table 55 and B.3.1: signs and NOT bind tightest, the others to the left."""
    def show(node: ast.Expr) -> str:
        if isinstance(node, ast.Binary):
            return f"({show(node.left)} {node.op} {show(node.right)})"
        if isinstance(node, ast.Unary):
            return f"{node.op}{' ' * (node.op == 'NOT')}{show(node.operand)}"
        return node.name

    assert show(expression(text)) == grouped


@pytest.mark.parametrize(("text", "value", "kind"), [
    ("5", 5, None), ("-5", -5, None), ("- 5", -5, None), ("+5", 5, None), ("1_000", 1000, None),
    ("16#fF", 255, None),
    ("2#1010_0101", 165, None), ("8#17", 15, None), ("1.5", 1.5, None), ("-1.5E-3", -0.0015, None),
    ("1e3", 1000.0, None),
    ("INT#-5", -5, "INT"), ("byte#16#FF", 255, "BYTE"), ("REAL#1.5e2", 150.0, "REAL"),
    ("real#3", 3.0, "REAL"),
    ("TRUE", True, "BOOL"), ("false", False, "BOOL"), ("BOOL#1", True, "BOOL"), ("BOOL#FALSE", False, "BOOL"),
    ("18446744073709551615", (1 << 64) - 1, None), ("-9223372036854775808", -(1 << 63), None),
    ("T#1d2h3m4s5ms6us7ns", 93784005006007, "TIME"), ("t#1.5s", 1_500_000_000, "TIME"),
    ("TIME#-20ms", -20_000_000, "TIME"),
    ("LT#90m", 5_400_000_000_000, "TIME"), ("LTIME#1h_30m", 5_400_000_000_000, "TIME"),
    ("T#0.5us", 500, "TIME"),
    ("D#1970-01-02", 1, "DATE"), ("DATE#2000-02-29", 11016, "DATE"),
    ("TOD#01:02:03.5", 3_723_500_000_000, "TIME_OF_DAY"),
    ("TIME_OF_DAY#23:59", 86_340_000_000_000, "TIME_OF_DAY"),
    ("DT#1970-01-02-00:00:01", 86_401_000_000_000, "DATE_AND_TIME"),
    ("DATE_AND_TIME#1970-01-01-00:00:00", 0, "DATE_AND_TIME"),
    ("'a$'b$$$0A$L$r'", b"a'b$\n\n\r", None), ('"a$"b$00E9$t"', 'a"bé\t', None), ("'é'", b"\xe9", None),
    ("STRING#'x'", b"x", "STRING"), ('WSTRING#"x"', "x", "WSTRING"),
])
def test_literals_have_the_value_that_the_standard_gives(text: str, value: object, kind: str | None) -> None:
    literal = expression(text)
    assert (literal.value, type(literal.value), literal.type) == (value, type(value), kind)


def test_names_keep_their_spelling_and_may_be_called_like_modifiers() -> None:
    rung, = rungs("rung Seal [P] [p eye] [/S] [N MOD 2 = 1] <c: CTU(R := { [R] }, PV := N)> (S) (S s) (r R)")
    shapes = [(type(i).__name__, getattr(i, "modifier", None)) for i in rung.paths[0].items]
    assert shapes == [("Contact", ""), ("Contact", "P"), ("Contact", "/"), ("Contact", ""), ("Block", None),
                      ("Coil", ""), ("Coil", "S"), ("Coil", "R")]
    assert rung.name == "Seal"
    assert rung.paths[0].items[7].target.name == "R"


def test_blocks_have_pins_and_power_pins() -> None:
    rung, = rungs("RUNG [a] <t[1].x: TON(T#1s, IN := @n, Q => @m, ET => e.f) in=_ OUT=Q> @m")
    block = rung.paths[0].items[1]
    assert expr_text(block.instance) == "t[1].x"
    assert [(p.name, p.output, type(p.value).__name__) for p in block.pins] == [
        (None, False, "Literal"), ("IN", False, "Junction"), ("Q", True, "Junction"), ("ET", True, "Member")]
    assert (block.power_in, block.power_out) == ("_", "Q")


def test_functions_may_be_called_like_operators() -> None:
    rung, = rungs("RUNG <AND(a AND b, c, OUT => d)> <not(a, OUT => b)> <mod(a, 2, OUT => b)> (q)")
    assert [block.type for block in rung.paths[0].items[:3]] == ["AND", "not", "mod"]


def test_a_jump_may_follow_a_block_without_a_space() -> None:
    rung, = rungs("RUNG [a]<MOVE(IN:=1,OUT=>x)>>>return")
    assert rung.paths[0].items[2].target == "RETURN"


def test_a_rung_has_paths_and_its_last_semicolon_may_go() -> None:
    text = 'RUNG r "a $"title$"" [a] @x (q); @x (r)'
    with_it, without = rungs(f"{text};\n{text}")
    assert bare(with_it) == bare(without)
    assert with_it.title == 'a "title"'


def test_spans_cover_what_they_stand_for() -> None:
    text = "PROGRAM p\nRUNG r [ x.y[2] ] { (a) | [(b OR c) AND d] (e) }\nEND_PROGRAM"
    rung = parsed(text).pous[0].body.rungs[0]
    contact, branches = rung.paths[0].items
    assert contact.span.text == "[ x.y[2] ]"
    assert contact.expr.span.text == "x.y[2]"
    assert branches.span.text == "{ (a) | [(b OR c) AND d] (e) }"
    assert branches.paths[1].span.text == "[(b OR c) AND d] (e)"
    assert branches.paths[1].items[0].expr.left.span.text == "(b OR c)"
    assert rung.span.text == text.split("\n")[1]
    assert rung.name_span.text == "r"


DECLARATIONS = """
FUNCTION_BLOCK fb "a block"
VAR_INPUT RETAIN a, B : BOOL; END_VAR
VAR_OUTPUT CONSTANT c : STRING[20] := 'x'; d : WSTRING(n + 1); END_VAR
VAR_IN_OUT e : ARRAY [1..10, -2..n] OF REAL; END_VAR
VAR_TEMP f : INT (0..10) := 5; g : (red, amber := 5, green) := amber; END_VAR
VAR_EXTERNAL h : Point; END_VAR
VAR NON_RETAIN i AT %IW3 : INT := 5; j : TON := (PT := T#1s); k : ARRAY [0..3] OF INT := [1, 2(7), x];
    l : ARRAY [0..1] OF STRUCT u, v : INT; w : STRUCT z : BOOL; END_STRUCT; END_STRUCT
        := [2((u := 1, w := (z := TRUE)))];
END_VAR
END_FUNCTION_BLOCK
"""


def test_declarations() -> None:
    pou = parsed(DECLARATIONS).pous[0]
    assert (pou.kind, pou.name, pou.title) == ("FUNCTION_BLOCK", "fb", "a block")
    assert [(b.kind, b.qualifiers) for b in pou.var_blocks] == [
        ("VAR_INPUT", ("RETAIN",)), ("VAR_OUTPUT", ("CONSTANT",)), ("VAR_IN_OUT", ()), ("VAR_TEMP", ()),
        ("VAR_EXTERNAL", ()), ("VAR", ("NON_RETAIN",))]
    of = {v.name: v for b in pou.var_blocks for v in b.variables}
    assert list(of) == ["a", "B", "c", "d", "e", "f", "g", "h", "i", "j", "k", "l"]
    assert of["a"].group_span == of["B"].group_span and of["B"].group_span.text == "a, B : BOOL;"
    assert of["c"].type.length.value == 20
    assert [(expr_text(a), expr_text(b)) for a, b in of["e"].type.bounds] == [("1", "10"), ("-2", "n")]
    assert (of["f"].type.base, of["f"].type.high.value, of["f"].initial.value) == ("INT", 10, 5)
    assert [(n, v and v.value) for n, v in of["g"].type.values] == [
        ("red", None), ("amber", 5), ("green", None)]
    assert of["i"].location == "%IW3"
    assert [n for n, _ in of["j"].initial.fields] == ["PT"]
    assert [n for n, _ in of["k"].initial.items] == [1, 2, 1]
    assert [f.name for f in of["l"].type.element.fields] == ["u", "v", "w"]


def test_types_globals_and_configurations() -> None:
    file = parsed("""
        TYPE Colour : (red, green) := green; Point : STRUCT x, y : REAL := 1.0; END_STRUCT; END_TYPE
        VAR_GLOBAL g : Colour := Colour#red; END_VAR
        FUNCTION f : INT "a title" VAR_INPUT a : INT; END_VAR RUNG <ADD(a, 1, OUT => f)> END_FUNCTION
        CONFIGURATION plant
            VAR_GLOBAL h : BOOL; END_VAR
            RESOURCE master ON cpu
                TASK fast (INTERVAL := T#10ms, PRIORITY := 1);
                PROGRAM one WITH fast : main;
                PROGRAM two : main;
            END_RESOURCE
            RESOURCE slave1 ON mcu END_RESOURCE
        END_CONFIGURATION""")
    assert [t.name for t in file.types] == ["Colour", "Point"]
    assert expr_text(file.globals[0].variables[0].initial) == "Colour#red"
    assert (file.pous[0].result.name, file.pous[0].title) == ("INT", "a title")
    plant = file.configurations[0]
    master, slave = plant.resources
    assert (plant.name, master.name, master.processor, slave.processor) == ("plant", "master", "cpu", "mcu")
    task, = master.tasks
    assert (task.name, task.interval.text, task.single) == ("fast", "T#10ms", None)
    assert [(p.name, p.task, p.pou) for p in master.programs] == [
        ("one", "fast", "main"), ("two", None, "main")]


def test_bodies_of_il_files_are_text() -> None:
    lines = "\n  f := a^ § 'open; (* END_FUNCTION *)\n"
    text = f"FUNCTION f : INT\nVAR_INPUT a : INT; END_VAR{lines}END_FUNCTION\n"
    body = parsed(text, "some/F.IL").pous[0].body
    assert (body.language, body.span.text) == ("IL", lines)
    assert parsed("PROGRAM p LD a ST b END_PROGRAM", "x.il").pous[0].body.span.text == " LD a ST b "


def test_a_program_without_rungs_has_an_empty_ladder() -> None:
    assert parsed("PROGRAM p END_PROGRAM").pous[0].body.rungs == ()


def test_comments_are_kept() -> None:
    file = parsed("(* one *)\nPROGRAM p // two\nRUNG [a (* three\n*)] (q)\nEND_PROGRAM")
    assert [c.text for c in file.comments] == ["(* one *)", "// two", "(* three\n*)"]


@given(expressions())
def test_an_expression_is_read_as_it_was_printed(tree: ast.Expr) -> None:
    assert bare(expression(expr_text(tree))) == bare(tree)


@given(st.lists(sp_rungs() | junction_rungs(), min_size=1, max_size=3))
@settings(deadline=None)
def test_rungs_are_read_as_they_were_printed(drawn: list[ast.Rung]) -> None:
    read = parsed(program_text(drawn)).pous[0].body.rungs
    assert list(map(bare, read)) == list(map(bare, drawn))


def test_canonical_text_of_a_rung() -> None:
    rung, = rungs('rung r "t"{[a]|[ /b ]}[P  c](*x*)<t:TON(PT:=T#1s,Q=>q)out=_>(S d);@x[e&not f](g)')
    first, second = "{ [a] | [/b] } [P c] <t: TON(PT := T#1s, Q => q) out=_> (S d);", "@x [e AND NOT f] (g)"
    assert rung_text(rung) == f'RUNG r "t"\n    {first}\n    {second}'
    assert paths_text(rung) == f"{first} {second}"
