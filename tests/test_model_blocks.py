"""Blocks and functions in a rung: which pin gets what."""

from __future__ import annotations

import pytest

from ldc import types
from ldc.diagnostics import Diagnostics
from ldc.expr import Place
from ldc.model.elements import Coil
from ldc.model.usage import duplicate_coils
from ldc.types import BOOL
from tests.modelling import Nets, findings, first, modelled, program, shown_element

BEFORE = """
TYPE Point : STRUCT x : REAL; y : REAL; END_STRUCT; Mode : (slow, fast); END_TYPE
FUNCTION_BLOCK silent
VAR_INPUT n : INT; END_VAR VAR_OUTPUT m : INT; END_VAR
RUNG <MOVE(n, OUT => m)>
END_FUNCTION_BLOCK
FUNCTION_BLOCK both
VAR_INPUT n : INT := 3; go, stop : BOOL; END_VAR
VAR_IN_OUT total : INT; END_VAR
VAR_OUTPUT m : INT; done, late : BOOL; END_VAR
VAR inner : BOOL; END_VAR
RUNG [go] (done)
END_FUNCTION_BLOCK
FUNCTION scaled : REAL
VAR_INPUT value : REAL; factor : REAL := 2.0; END_VAR
VAR_OUTPUT big : BOOL; END_VAR
RUNG <MUL(value, factor, OUT => scaled)>
END_FUNCTION
FUNCTION bump : INT
VAR_INPUT by_n : INT; END_VAR
VAR_IN_OUT total : INT; END_VAR
RUNG <ADD(total, by_n, OUT => total)>
END_FUNCTION
"""
VARIABLES = """
    a, b, c : BOOL; n, m : INT; d : DINT; byt : BYTE; us : USINT; w : WORD; x : REAL; lx : LREAL; t : TIME;
    warm : TON; timers : ARRAY [0..3] OF TON; parts : CTU; quiet : silent; two : both;
    p1, p2 : Point; mode : Mode;
    name : STRING[20];
"""


@pytest.mark.parametrize(("rung", "expected"), [
    ("<warm: TON(PT := T#2s)>", "TON(PT:=2000000000:TIME) IN>Q"),
    ("<warm: ton(T#2s)>", "TON(PT:=2000000000:TIME) IN>Q"),
    ("<warm: TON(PT := t, ET => t)>", "TON(PT:=t, ET=>t) IN>Q"),
    ("<warm: TON()>", "TON() IN>Q"),
    ("<warm: TON(IN := a, PT := t) in=_ out=_>", "TON(IN:=a, PT:=t) None>None"),
    ("<warm: TON(PT := t, Q => a)>", "TON(PT:=t, Q=>a) IN>Q"),
    ("<timers[n + 1]: TON(PT := t)>", "TON(PT:=t) IN>Q"),
    ("<parts: CTU(R := { [a] | [b] }, PV := 100, CV => n)>", "CTU(R:=1, PV:=100:INT, CV=>n) CU>Q"),
    ("<parts: CTU(PV := 5, R := @reset, CV => @count)>", "CTU(R:=1, PV:=5:INT, CV=>2) CU>Q"),
    ("<parts: CTU(CU := a, PV := n, CV => d) in=R>", "CTU(CU:=a, PV:=n, CV=>d) R>Q"),
    ("<quiet: silent(n := 5, m => n) in=_ out=_>", "SILENT(n:=5:INT, m=>n) None>None"),
    ("<two: both(5, a, total := n)>", "BOTH(n:=5:INT, stop:=a, total:=n, total=>n) go>done"),
    ("<two: both(total := n, late => a) out=late>", "BOTH(total:=n, total=>n, late=>a) go>late"),
    ("<MOVE(IN := 1200, OUT => n)>", "MOVE(IN:=1200:INT, OUT=>n) EN>ENO"),
    ("<MOVE(IN := 200, OUT => us)>", "MOVE(IN:=200:USINT, OUT=>us) EN>ENO"),
    ("<MOVE(IN := 16#FF, OUT => byt)>", "MOVE(IN:=255:BYTE, OUT=>byt) EN>ENO"),
    ("<MOVE(IN := 1, OUT => x)>", "MOVE(IN:=1:INT, OUT=>x) EN>ENO"),
    ("<MOVE(IN := 100000, OUT => d)>", "MOVE(IN:=100000:DINT, OUT=>d) EN>ENO"),
    ("<MOVE(p1, OUT => p2)>", "MOVE(IN:=p1, OUT=>p2) EN>ENO"),
    ("<MOVE(fast, OUT => mode)>", "MOVE(IN:=1:Mode, OUT=>mode) EN>ENO"),
    ("<MOVE('abc', OUT => name)>", "MOVE(IN:=b'abc':STRING[80], OUT=>name) EN>ENO"),
    ("<ADD(n, 1, d, OUT => d)>", "ADD(IN1:=INT_TO_DINT(n), IN2:=1:DINT, IN3:=d, OUT=>d) EN>ENO"),
    ("<ADD(IN2 := n, IN1 := 1, OUT => lx)>", "ADD(IN1:=1:INT, IN2:=n, OUT=>lx) EN>ENO"),
    ("<GT(n, 5) out=OUT>", "GT(IN1:=n, IN2:=5:INT) EN>OUT"),
    ("<SEL(IN0 := n, IN1 := m, OUT => n) in=G>", "SEL(IN0:=n, IN1:=m, OUT=>n) G>ENO"),
    ("<SEL(EN := a, IN0 := n, IN1 := m, OUT => n) in=G>", "SEL(EN:=a, IN0:=n, IN1:=m, OUT=>n) G>ENO"),
    ("<MAX(n, m, OUT => n) in=_>", "MAX(IN1:=n, IN2:=m, OUT=>n) None>ENO"),
    ("<MAX(n, m, OUT => n, ENO => a) out=_>", "MAX(IN1:=n, IN2:=m, ENO=>a, OUT=>n) EN>None"),
    ("<DIV(n, 2.0, OUT => x)>", "DIV(IN1:=INT_TO_REAL(n), IN2:=2.0:REAL, OUT=>x) EN>ENO"),
    ("<MUL(t, 2, OUT => t)>", "MUL(IN1:=t, IN2:=2:INT, OUT=>t) EN>ENO"),
    ("<INT_TO_REAL(n, OUT => x)>", "INT_TO_REAL(IN:=n, OUT=>x) EN>ENO"),
    ("<TO_REAL(n, OUT => x)>", "INT_TO_REAL(IN:=n, OUT=>x) EN>ENO"),
    ("<scaled(n, OUT => x)>", "SCALED(value:=INT_TO_REAL(n), factor:=2.0:REAL, OUT=>x) EN>ENO"),
    ("<scaled(factor := 1, value := x, big => a, OUT => x)>",
     "SCALED(value:=x, factor:=1.0:REAL, OUT=>x, big=>a) EN>ENO"),
    ("<scaled(x) out=big>", "SCALED(value:=x, factor:=2.0:REAL) EN>big"),
    ("<bump(5, total := n)>", "BUMP(by_n:=5:INT, total:=n, total=>n) EN>ENO"),
])
def test_pins(rung: str, expected: str) -> None:
    found = modelled(program(VARIABLES, f"RUNG {rung}", BEFORE))
    assert not found.diagnostics.has_errors, found.text
    assert shown_element(found.elements["MAIN"][0]) == expected


@pytest.mark.parametrize(("rung", "expected"), [
    ("<TON(PT := t)>", "LD0502 [<TON(PT := t)>]"),
    ("<a: MOVE(5, OUT => n)>", "LD0502 [a] `MOVE` is a FUNCTION and has no instances | write `<MOVE(...)>`"),
    ("<a: scaled(5, OUT => x)>", "LD0502 [a]"),
    ("<warm: main()>", "LD0502"),
    ("<warm: TOM(PT := t)>", "LD0501"),
    ("<scald(5)>", "did you mean `scaled`"),
    ("<warm: TOF(PT := t)>", "LD0504 [warm] `warm` is TON, not TOF"),
    ("<n: TON(PT := t)>", "LD0504 [n] `n` is INT, not TON | declare an instance: `VAR name : TON; END_VAR`"),
    ("<timers: TON(PT := t)>", "LD0504 [timers]"),
    ("<timers[4]: TON(PT := t)>", "LD0408 [4]"),
    ("<cold: TON(PT := t)>", "LD0404 [cold]"),
    ("<warm: TON(PTT := t)>", "LD0505 [PTT := t] `TON` has no pin `PTT` | did you mean `PT`?"),
    ("<two: both(inner := a, total := n)>", "LD0505 [inner := a]"),
    ("<ADD(n, m, IN4 := 4, OUT => n)>", "LD0507 [<ADD(n, m, IN4 := 4, OUT => n)>] `ADD` needs `IN3`"),
    ("<MOVE(n, X := m, OUT => n)>", "LD0505 [X := m]"),
    ("<MOVE(n, X => m)>", "LD0505 [X => m]"),
    ("<warm: TON(IN := a, PT := t)>", "LD0506 [IN := a]"),
    ("<warm: TON(PT := t, PT := t)>", "LD0506 [PT := t] pin `PT` is fed twice"),
    ("<MOVE(n, EN := a, OUT => n)>", "LD0506 [EN := a]"),
    ("<MOVE(n, IN := m, OUT => n)>", "LD0506 [IN := m]"),
    ("<ADD(n, OUT => n)>", "LD0507 [<ADD(n, OUT => n)>] `ADD` needs `IN2` | its pins are IN1, IN2 ..."),
    ("<scaled(OUT => x)>", "LD0507"),
    ("<two: both(n := 5)>", "LD0507 [<two: both(n := 5)>] `both` needs `total`"),
    ("<bump(5)>", "LD0507 [<bump(5)>] `bump` needs `total`"),
    ("<warm: TON(ET := t)>", "LD0508 [ET := t]"),
    ("<warm: TON(PT => t)>", "LD0508 [PT => t]"),
    ("<MOVE(n, m, OUT => n)>", "LD0509 [m]"),
    ("<warm: TON(t, t)>", "LD0509 [t]"),
    ("<quiet: silent(n := 5) out=_>", "has no BOOL input for the power | write `in=_`"),
    ("<quiet: silent(n := 5) in=_>", "has no BOOL output for the power | write `out=_`"),
    ("<quiet: silent() in=n out=_>", "LD0510 [<quiet: silent() in=n out=_>]"),
    ("<warm: TON() in=XX>", "power cannot use the pin `XX` of `TON` | write `in=IN` or `in=_`"),
    ("<warm: TON() out=ET>", "LD0510"),
    ("<MOVE(n) out=OUT>", "LD0510"),
    ("<two: both(total := 5)>", "LD0511 [5]"),
    ("<two: both(total := d)>", "LD0511 [d]"),
    ("<two: both(total => n)>", "LD0511 [total => n]"),
    ("<two: both(total := { [a] })>", "LD0511 [{ [a] }]"),
    ("<warm: TON(PT := { [a] })>", "LD0513 [{ [a] }] pin `PT` is TIME"),
    ("<warm: TON(PT := t, ET => { [a] })>", "LD0101"),
    ("<warm: TON(PT := n)>", "LD0403 [n] pin `PT` needs TIME, not INT | convert it by `INT_TO_TIME(...)`"),
    ("<warm: TON(PT := 5)>", "LD0403 [5] pin `PT` needs TIME, not INT"),
    ("<warm: TON(PT := t, ET => n)>",
     "LD0403 [n] output `ET` gives TIME, not INT | take it into a variable of type TIME, "
     "then convert it by `TIME_TO_INT(...)`"),
    ("<MOVE(d, OUT => n)>", "LD0403 [n] output `OUT` gives DINT, not INT"),
    ("<MOVE(300, OUT => us)>", "LD0402 [300] 300 does not fit the type USINT"),
    ("<MOVE(p1, OUT => n)>", "LD0403"),
    ("<ADD(a, b, OUT => n)>", "LD0410"),
    ("<ADD(q, 1, OUT => n)>", "LD0404 [q]"),
    ("<MOVE(n, OUT => fast)>", "LD0405 [fast]"),
    ("<MOVE(n, OUT => 5)>", "LD0101"),
    ("<MOVE(n, OUT => warm.Q)>", "LD0503"),
])
def test_findings(rung: str, expected: str) -> None:
    text = findings(VARIABLES, rung, BEFORE)
    assert expected in text
    assert len(text.splitlines()) == 1 or "LD01" in text, text


def test_a_junction_tells_the_type_of_its_value() -> None:
    block = first(VARIABLES, "<ADD(@n, 1, OUT => x)>", BEFORE, Nets({"n": types.REAL}))
    assert shown_element(block) == "ADD(IN1:=1, IN2:=1.0:REAL, OUT=>x) EN>ENO"
    assert block.inputs[0].type is types.REAL


def test_a_junction_of_unknown_type_takes_that_of_the_other_pins() -> None:
    block = first(VARIABLES, "<ADD(@n, x, OUT => x)>", BEFORE)
    assert block.inputs[0].type is types.REAL


def test_a_pin_of_a_broken_declaration_is_silent() -> None:
    text = program("f : fb; a : BOOL;", "RUNG [a] <f: fb(x := 5, q => a)> (a)",
                   "FUNCTION_BLOCK fb VAR_INPUT x : Nothing; END_VAR END_FUNCTION_BLOCK")
    assert modelled(text).codes == ["LD0205"]


def test_a_type_that_is_missing_is_told_where_it_is_declared_only() -> None:
    text = ("PROGRAM p VAR a : BOOL; x : Vendor; END_VAR RUNG [a] <x: Vendor(IN := a)> (a)\n"
            "RUNG [a] <x: Vendor()> END_PROGRAM")
    assert modelled(text).codes == ["LD0205"]


def test_the_signature_of_an_overloaded_function_has_the_types_of_the_call() -> None:
    block = first(VARIABLES, "<ADD(d, n, 3, OUT => d)>", BEFORE)
    assert [p.type for p in block.signature.inputs] == [types.DINT] * 3
    assert block.signature.result is types.DINT
    assert block.is_function and block.callee == "ADD"


def test_two_coils_for_one_place() -> None:
    found = modelled(program(
        "a : BOOL; b AT %QX0.0 : BOOL; b2 AT %QX0.0 : BOOL; w : WORD; f : ARRAY [0..3] OF BOOL; i : INT;",
        "RUNG [a] (b) (b2) (%QX0.0) (S a) (R a) (w.1) (/W.1) (f[1]) (f[1]) (f[i]) (f[i])"))
    coils = [("r", e) for e in found.elements["MAIN"] if isinstance(e, Coil)]
    diagnostics = Diagnostics()
    duplicate_coils(found.model.pous["MAIN"], coils, diagnostics)
    assert [d.primary.span.text for d in diagnostics] == ["(b2)", "(/W.1)", "(f[1])"]
    assert {d.code for d in diagnostics} == {"LD0310"}
    assert next(iter(diagnostics)).message == "`b2` is written by 3 coils", "once for a place"


def test_places_keep_the_declared_spelling() -> None:
    coil = first("Motor : BOOL;", "(MOTOR)")
    assert coil.place == Place("Motor", BOOL)
