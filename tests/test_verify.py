"""The self-check: right code passes as a proof or a check, every slip in it is found."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ldc import pipeline
from ldc.cli.main import main
from ldc.graph.memory import memories
from ldc.il.verify import verify
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile

DECLARATIONS = """VAR
    a, b, c, d, e, f, q, z : BOOL;
    i, j, k : INT;
    t : TON;
    n : CTU;
END_VAR
VAR many : ARRAY [0..9] OF BOOL; values : ARRAY [0..9] OF INT; flags : WORD; END_VAR
"""

RUNGS = {
    "seal_in": "{ [a] | [q] } [/b] (q)",
    "bridge": "{ [a] @x [b] | [c] @y [d] } (q); @x [e] @y",
    "coils_between": "[a] (q) [b] { [/c] (S z) | [q] (/d) }",
    "edges": "[P a] [N b] (P q) (N z)",
    "same_operand_written": "[q] { [a] (/q) | [q] } (z)",
    "timer": "[a] [b] <t: TON(PT := T#1s)> (q)",
    "counter": "[P a] <n: CTU(R := { [b] | [/c] }, PV := i, CV => j)> { (q) | [d] (R z) }",
    "comparison": "[i > j] { [a] | [i + 1 < k] } (q)",
    "enable": "[a] <MOVE(IN := i, OUT => j)> [j = 3] (q)",
    "division": "[a] <DIV(IN1 := i, IN2 := j, OUT => k)> (q)",
    "guarded": "[j <> 0] [i / j > 2] (q)",
    "array": "[many[i]] [/many[3]] (many[j]) [many[3]] (q)",
    "bits": "[flags.3] (flags.4) [flags.5] (q)",
    "loop": "[a] @n <t: TON(PT := T#1s) out=_>; @m [/b] @n; <n: CTU(CU := c, Q => @m) in=_> (q)",
    "feedback": "[a] @w <t: TON(PT := T#1s)> @m (q); @m [/b] @w",
    "array_under_power": "[a] @x <ADD(IN1 := i, IN2 := i, OUT => values[0])> (q); [b] @y (z); @x [values[i] > 2] @y",
    "jumps": "{ [a] (q) >>other | [b] (z) >>RETURN }",
}


def build(rung: str, **options):
    text = f"PROGRAM p\n{DECLARATIONS}RUNG r1\n    {rung}\nRUNG other\n    [a] (f)\nEND_PROGRAM\n"
    sources = Sources((SourceFile("p.ld", text),), Settings(), None)
    result = pipeline.compile_project(sources, pipeline.Options(**options))
    assert not result.diagnostics.has_errors, [d.message for d in result.diagnostics]
    return result, result.units["p"][0]


def judged(result, made, code):
    unit = result.program.unit("p")
    temps = [v for v in unit.variables if v.kind == "temp"]
    hidden = memories(made.graph, made.turns)
    nullary = [n for n, s in result.model.signatures.items() if s.kind == "FUNCTION" and not s.inputs]
    return verify(made.graph, made.turns, hidden, made.tree, tuple(code), temps, nullary=nullary)


@pytest.mark.parametrize("name", RUNGS)
@pytest.mark.parametrize("depth", [None, 0])
def test_what_the_compiler_makes_is_proved(name: str, depth) -> None:
    _, made = build(RUNGS[name], max_paren_depth=depth)
    assert made.verdict.kind == "proof" and made.verdict.operands <= 12


def test_more_than_twelve_operands_are_a_check() -> None:
    names = [f"x{n}" for n in range(13)]
    text = "PROGRAM p\nVAR " + ", ".join(names) + ", q : BOOL; END_VAR\nRUNG\n"
    text += " ".join(f"[{n}]" for n in names) + " (q)\nEND_PROGRAM\n"
    result = pipeline.compile_project(Sources((SourceFile("p.ld", text),), Settings(), None))
    verdict = result.units["p"][0].verdict
    assert (verdict.kind, verdict.operands) == ("check", 13)


SWAPS = {"LD": "LDN", "AND": "OR", "OR": "AND", "ANDN": "AND", "ORN": "OR", "AND(": "OR(", "OR(": "AND(",
         "ST": "STN", "S": "R", "R": "S", "STN": "ST", "GT": "GE", "LT": "GT", "EQ": "NE", "NE": "EQ",
         "JMPCN": "JMPC", "JMPC": "JMPCN", "RETC": "RETCN", "ADD": "SUB", "DIV": "MUL"}


def slips(code):
    """Every program that differs from ``code`` in one place: an operator, a lost store or call."""
    for n, instr in enumerate(code):
        if instr.op in SWAPS and (instr.op != "LD" or str(instr.type) == "BOOL"):
            if instr.op == "ST" and str(instr.type) != "BOOL":
                continue
            yield f"{n}: {instr.op} -> {SWAPS[instr.op]}", code[:n] + (replace(instr, op=SWAPS[instr.op]),) + code[n + 1:]
        if instr.op in ("ST", "S", "R", "CAL", "FN"):
            yield f"{n}: {instr.op} lost", code[:n] + code[n + 1:]


@pytest.mark.parametrize("name", RUNGS)
def test_every_slip_is_found(name: str) -> None:
    result, made = build(RUNGS[name])
    code = made.code.code
    assert judged(result, made, code).kind == "proof"
    missed = [what for what, wrong in slips(code) if judged(result, made, wrong).kind != "wrong"]
    assert not missed, "\n".join(missed)


def test_order_of_a_coil_and_a_later_contact_matters() -> None:
    result, made = build("[a] (b) [b] (q)")
    code = made.code.code
    early = tuple(i for i in code if not (i.op == "ST" and i.operand.root == "b"))
    late = early + tuple(i for i in code if i.op == "ST" and i.operand.root == "b")
    assert judged(result, made, late).kind == "wrong"


def test_a_function_sees_the_globals_of_its_moment() -> None:
    text = """VAR_GLOBAL g : BOOL; END_VAR
FUNCTION seen : BOOL
VAR_EXTERNAL g : BOOL; END_VAR
RUNG [g] (seen)
END_FUNCTION
PROGRAM p
VAR a, q : BOOL; END_VAR
VAR_EXTERNAL g : BOOL; END_VAR
RUNG r1 [a] (g); <seen() out=OUT> (q)
END_PROGRAM
"""
    result = pipeline.compile_project(Sources((SourceFile("p.ld", text),), Settings(), None))
    assert not result.diagnostics.has_errors, [d.message for d in result.diagnostics]
    (made,) = result.units["p"]
    assert made.verdict.kind == "proof"
    store = next(i for i in made.code.code if i.op == "ST" and i.operand.root == "g")
    late = (*(i for i in made.code.code if i is not store), replace(store, op="ST"))
    assert judged(result, made, (made.code.code[0], *late)).kind == "wrong"


def test_functions_without_inputs_stand_anywhere() -> None:
    text = """FUNCTION f : BOOL
RUNG (f)
END_FUNCTION
FUNCTION g : BOOL
RUNG (/g)
END_FUNCTION
PROGRAM p
VAR a, q, z : BOOL; END_VAR
RUNG r1 [a OR f() AND g()] (q)
RUNG r2 [a] <f() out=OUT> <g() in=_ out=OUT> (z)
END_PROGRAM
"""
    result = pipeline.compile_project(Sources((SourceFile("p.ld", text),), Settings(), None))
    assert not result.diagnostics.has_errors, [d.message for d in result.diagnostics]
    assert [made.verdict.kind for made in result.units["p"]] == ["proof", "proof"]


def test_a_wrong_verdict_names_what_differs_and_an_example() -> None:
    result, made = build(RUNGS["seal_in"])
    code = made.code.code
    wrong = (replace(code[0], op="LDN"), *code[1:])
    verdict = judged(result, made, wrong)
    assert verdict.stage == "il" and verdict.what == "the value of Q"
    assert {name for name, _ in verdict.example} == {"A", "B", "Q"}


def test_a_compiler_that_slips_is_stopped(monkeypatch, tmp_path, capsys) -> None:
    """No input is known that does it, so a slip is put into the lowering."""
    right = pipeline.rungs.lower

    def wrong(*args, **options):
        lowered = right(*args, **options)
        first, *rest = lowered.code.code
        return replace(lowered, code=replace(lowered.code, code=(replace(first, op="LDN"), *rest)))

    monkeypatch.setattr(pipeline.rungs, "lower", wrong)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.ld").write_text("PROGRAM p VAR a, q : BOOL; END_VAR\nRUNG seal { [a] | [q] } (q)\nEND_PROGRAM\n")
    assert main(["compile", "p.ld", "-o", "p.il"]) == 3
    shown = capsys.readouterr()
    assert "LD0901" in shown.err and "the value of Q" in shown.err and not shown.out
    assert not (tmp_path / "p.il").exists()
