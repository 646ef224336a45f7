"""The check of typed IL finds every kind of slip that a lowering could make."""

from __future__ import annotations

import pytest
from tests.il_text import DELAY, A, B, D, I, T, W, X, read

from ldc.expr import Apply, Const, IndexStep, Place
from ldc.il.program import Instr, RungCode, Unit
from ldc.il.typecheck import check_unit
from ldc.symbols import Variable
from ldc.types import BOOL, DINT, INT, REAL, TIME, WORD

VARIABLES = read("LD a")[0].variables
LD_A, ST_B = Instr("LD", A), Instr("ST", B)


def findings(*code: Instr, label: str | None = None, units=()) -> list[str]:
    unit = Unit("PROGRAM", "main", VARIABLES, (RungCode("r", code, label),))
    return [str(f) for f in check_unit(unit, units)]


@pytest.mark.parametrize("code, expected", [
    ((Instr("LDX", A),), "r[0]: unknown operation LDX"),
    ((ST_B,), "r[0]: ST: the accumulator is undefined"),
    ((Instr("CAL", DELAY, DELAY.type), ST_B), "r[1]: ST: the accumulator is undefined"),
    ((LD_A, Instr("JMP", name="l"), ST_B, Instr("LABEL", name="l")), "r[2]: ST: the accumulator is undefined"),
    ((Instr("LD", I, INT), ST_B), "r[1]: ST: the accumulator is INT, not BOOL"),
    ((Instr("LD", I, DINT),), "r[0]: LD: i is INT, not DINT"),
    ((Instr("LD", Place("i", DINT), DINT),), "r[0]: LD: i is INT, not DINT"),
    ((Instr("LD", Place("nope", BOOL)),), "r[0]: LD: there is no variable nope"),
    ((Instr("LD", None),), "r[0]: LD: the operand is missing"),
    ((Instr("LD", I, INT), Instr("ADD", D, DINT)), "r[1]: ADD: the accumulator is INT, not DINT"),
    ((Instr("LD", I, INT), Instr("ADD", D, INT)), "r[1]: ADD: d is DINT, not INT"),
    ((LD_A, Instr("ADD", B, BOOL)), "r[1]: ADD: does not work on BOOL"),
    ((Instr("LD", X, REAL), Instr("MOD", X, REAL)), "r[1]: MOD: does not work on REAL"),
    ((Instr("LD", T, TIME), Instr("MUL", T, TIME)), "r[1]: MUL: does not work on TIME"),
    ((Instr("LD", I, INT), Instr("NOT", None, INT)), "r[1]: NOT: INT cannot be negated"),
    ((Instr("LDN", I, INT),), "r[0]: LDN: INT cannot be negated"),
    ((LD_A, Instr("AND(", B)), "r[2]: a parenthesis is never closed"),
    ((LD_A, Instr(")")), "r[1]: ): nothing is open"),
    ((LD_A, Instr("AND("), Instr(")")), "r[2]: ): the accumulator is undefined"),
    ((LD_A, Instr("AND(", I), Instr(")")), "r[2]: ): the accumulator is INT, not BOOL"),
    ((LD_A, Instr("AND(", B), Instr(")", None, WORD)), "r[2]: ): closes AND( of BOOL as WORD"),
    ((LD_A, Instr("AND(", B), Instr("CAL", DELAY, DELAY.type), Instr("LD", A), Instr(")")),
     "r[2]: CAL: stands within parentheses"),
    ((Instr("LD", W, WORD), Instr("JMPC", name="l"), Instr("LABEL", name="l")),
     "r[1]: JMPC: the accumulator is WORD, not BOOL"),
    ((LD_A, Instr("JMPC", name="l")), "r[1]: JMPC: there is no label l"),
    ((Instr("CAL", A),), "r[0]: CAL: calls no instance"),
    ((Instr("LD", X, REAL), Instr("S", X, REAL)), "r[1]: S: the accumulator is REAL, not BOOL"),
    ((LD_A, Instr("ST", Const(True, BOOL))), "r[1]: ST: stores to no variable"),
    ((Instr("FN", None, DINT, "INT_TO_DINT"),), "r[0]: FN: the accumulator is undefined"),
    ((Instr("LD", D, DINT), Instr("FN", None, DINT, "INT_TO_DINT")), "r[1]: FN:"),
    ((Instr("LD", I, INT), Instr("FN", None, REAL, "INT_TO_DINT")), "r[1]: FN: INT_TO_DINT gives DINT, not REAL"),
    ((Instr("LD", I, INT), Instr("FN", None, DINT, "MAX", (D,))), "r[1]: FN: MAX takes DINT, DINT"),
    ((Instr("LD", Place("list", INT, (IndexStep((Apply("ADD", (), INT),), ((1, 4),)),)), INT),),
     "r[0]: LD: an index is an expression"),
])
def test_a_slip_is_found_where_it_is(code: tuple[Instr, ...], expected: str) -> None:
    found = findings(*code)
    assert found and found[0].startswith(expected), found


def test_calls_of_functions_of_the_project() -> None:
    scale = Unit("FUNCTION", "scale", (Variable("raw", INT, "input"), Variable("over", BOOL, "output")), (), REAL)
    load = Instr("LD", I, INT)
    assert not findings(load, Instr("FN", None, REAL, "SCALE", (), (("over", A),)), units=(scale,))
    assert findings(load, Instr("FN", None, INT, "SCALE"), units=(scale,)) == ["r[1]: FN: scale gives REAL, not INT"]
    assert findings(load, Instr("FN", None, REAL, "SCALE", (I,)), units=(scale,)) == ["r[1]: FN: scale takes INT"]
    assert findings(load, Instr("FN", None, REAL, "SCALE", (), (("over", I),)), units=(scale,)) == [
        "r[1]: FN: scale has no output over of INT"]


def test_labels_are_unique_in_the_whole_unit() -> None:
    assert findings(Instr("LABEL", name="l"), label="l") == ["[-1]: label l stands twice"]


def test_what_is_right_has_no_findings() -> None:
    assert not findings(
        Instr("LD", W, WORD), Instr("AND", Const(255, WORD), WORD), Instr("GT(", W, WORD), Instr("NOT", None, WORD),
        Instr(")", None, WORD), Instr("CALC", DELAY, DELAY.type), Instr("JMPCN", name="l"), ST_B,
        Instr("LABEL", name="l"), Instr("RET"))
