"""Further instructions of Logix controllers, and calls in their Structured Text (docs/import-l5x.md)."""

from __future__ import annotations

import math
from pathlib import Path

import l5x_xml as xml
import native
import pytest
from foreign_files import compiled, machine, said

from ldc.cli.main import main
from ldc.components import toolchain
from ldc.il.st_text import print_st
from ldc.il.text import print_program
from ldc.pipeline import compile_paths
from runtime.vm.machine import Machine


def does(rungs: list[str], declared: str, rows: list[dict], watch: str, **parts: str) -> list[list[object]]:
    """The variables after each scan."""
    m, found = machine(xml.one(rungs, declared, **parts), "p.L5X"), []
    for row in rows:
        for name, value in row.items():
            m.set(name, value)
        m.scan()
        found.append([int(v) if isinstance(v, bool) else v for v in map(m.get, watch.split())])
    return found


def told(rungs: list[str], declared: str, **parts: str) -> list[str]:
    result = compiled(xml.one(rungs, declared, **parts), "p.L5X")
    return [line for line in said(result) if "LD0204" not in line]


# ---- numbers, bytes, texts

def test_bytes_change_their_places() -> None:
    rungs = ["SWPB(d,REVERSE,k)SWPB(d,WORD,m)SWPB(d,HIGH/LOW,n)SWPB(w,WORD,v);"]
    found = does(rungs, "DINT d k m n; INT w v", [{"d": 0x01020304, "w": 0x0102}], "k m n v")
    assert found == [[0x04030201, 0x03040102, 0x02010403, 0x0201]]


def test_cop_copies_bytes_between_numbers_of_other_types() -> None:
    rungs = ["COP(d[0],w[0],4)COP(x,d[1],1)COP(b[0],n,1)COP(d[1],y,1)COP(w[0],long,1)COP(d[3],w[4],9);"]
    declared = "DINT d[4] n; INT w[6]; REAL x y; SINT b[4]; LINT long"
    found = does(rungs, declared, [{"d[0]": 0x11112222, "x": 1.5, "b[0]": 1, "b[1]": 2, "b[3]": -1,
                                    "d[3]": 0x50006}], "w[0] w[1] d[1] n y long w[4] w[5]")
    assert found == [[0x2222, 0x1111, 0x3FC00000, 0xFF000201 - (1 << 32), 1.5, 0x11112222, 6, 5]]


def test_structures_are_cleared_and_go_through_files() -> None:
    types = ('<DataType Name="Part" Family="NoFamily"><Members><Member Name="Id" DataType="DINT"/>'
             '<Member Name="Name" DataType="STRING"/></Members></DataType>')
    rungs = ["XIC(a)FFL(p,f[0],c,3,0);", "XIC(b)FFU(f[0],q,c,3,0);", "XIC(z)FLL(0,f[0],3)CLR(p)FLL(0,q,1);"]
    rows = [{"p.Id": 7, "p.Name": "x"}, {"a": True}, {"a": False, "p.Id": 8}, {"a": True, "b": True},
            {"b": False, "a": False}, {"z": True}]
    declared, watch = "Part p q f[3]; CONTROL c; BOOL a b z", "q.Id q.Name p.Id c.POS f[0].Id"
    assert does(rungs, declared, rows, watch, types=types) == [
        [0, "", 7, 0, 0], [0, "", 7, 1, 7], [0, "", 8, 1, 7], [7, "x", 8, 1, 8], [7, "x", 8, 1, 8],
        [0, "", 0, 1, 0]]


def test_characters_and_the_length_of_a_string() -> None:
    rungs = ["MOV('a$$c',t)MOV(t.LEN,i)MOV(t.DATA[1],j)MOV(t.DATA[9],k)MOV(2,t.LEN)EQU(t,'a$$')OTE(q);",
             "XIC(z)MOV(4,t.LEN);", "XIC(y)CLR(t.LEN);"]
    rows = [{}, {"z": True}, {"y": True}]
    assert does(rungs, "STRING t; DINT i j k; BOOL q z y", rows, "i j k q t") == [
        [3, 36, 0, 1, "a$"], [3, 36, 0, 1, "a$\0\0"], [3, 36, 0, 1, ""]]
    assert told(["MOV(65,t.DATA[0]);"], "STRING t") == ["LD0151 L5X: writing `t.DATA[0]` is not supported"]


def test_angles_decimals_and_what_is_no_number() -> None:
    rungs = ["ATAN2(y,x,z)TO_BCD(i,j)BCD_TO(j,k);", "IsNAN(n)OTE(q);", "IsINF(n)OTE(p);"]
    rows = [{"x": -1.0, "y": 1.0, "i": 123}, {"n": math.inf, "y": -1.0, "x": 0.0}, {"n": math.nan, "y": 0.0}]
    found = does(rungs, "REAL x y z n; DINT i j k; BOOL q p", rows, "z j k q p")
    assert [row[1:] for row in found] == [[0x123, 123, 0, 0], [0x123, 123, 0, 1], [0x123, 123, 1, 0]]
    assert [round(row[0], 5) for row in found] == [2.35619, -1.5708, 0.0]


def test_a_change_of_masked_data() -> None:
    found = does(["XIC(a)DTR(i,16#F,d)CTU(c,9,0);"], "DINT i d; COUNTER c; BOOL a",
                 [{"a": True}, {"i": 16}, {"i": 17}, {}, {"i": 18}], "c.ACC d")
    assert found == [[0, 0], [0, 0], [1, 1], [1, 1], [2, 2]]


# ---- arrays

def test_sequencers() -> None:
    rungs = ["XIC(a)SQO(t[0],16#FF,o,c,3,0)OTE(q);", "SQI(t[0],16#F,o,c2,3,0)OTE(p);",
             "XIC(a)SQL(n[1],o,c3,2,0);"]
    declared = "BOOL a q p; DINT t[4] o n[4]; CONTROL c c2 c3"
    rows = [{"t[1]": 0x101, "t[2]": 2, "t[3]": 3, "o": 0x200}, *({"a": n % 2 == 0} for n in range(8))]
    found = does(rungs, declared, rows, "o c.POS c.DN q p n[2] n[3] c3.POS")
    assert found[::2] == [
        [0x200, 0, 0, 0, 1, 0, 0, 0], [0x201, 1, 0, 0, 0, 0x201, 0, 1], [0x202, 2, 0, 0, 0, 0x201, 0x202, 2],
        [0x203, 3, 1, 0, 0, 0x203, 0x202, 1], [0x201, 1, 0, 0, 0, 0x203, 0x201, 2]]
    assert [row[3] for row in found] == [0, 1, 0, 1, 0, 1, 0, 1, 0]


def test_statistics_and_sorting_at_a_rise() -> None:
    rungs = ["XIC(a)[AVE(v[0],0,m,c,4,0)OTE(q),STD(v[0],0,x,c2,4,0),SRT(v[0],0,c3,4,0),"
             "AVE(v[0],0,k,c4,4,0)];",
             "SIZE(v[0],0,i)SIZE(g,1,j)SIZE(g[0,1],0,n);"]
    declared = xml.tags("BOOL a q; INT v[5]; REAL m x; CONTROL c c2 c3 c4; DINT i j k n")
    declared += xml.tag("g", "DINT", "2 7")
    rows = [{"v[0]": 4, "v[1]": 1, "v[2]": 3, "v[3]": 3}, {"a": True}, {"v[0]": 9}, {"a": False}]
    assert does(rungs, declared, rows, "m k v[0] v[3] c.POS c.DN q i j n") == [
        [0.0, 0, 4, 3, 0, 0, 0, 5, 7, 2], [2.75, 3, 1, 4, 4, 1, 1, 5, 7, 2],
        [2.75, 3, 9, 4, 4, 1, 1, 5, 7, 2], [2.75, 3, 9, 4, 4, 0, 0, 5, 7, 2]]


# ---- order

def test_a_routine_for_each_number() -> None:
    sub = xml.rll("Sub", ["ADD(n,i,n);", "EQU(i,6)BRK();", "CTU(c,99,0);"])
    rungs = ["XIC(a)FOR(Sub,i,0,9,2)OTE(q);", "XIC(b)FOR(Sub,i,k,1,-1);"]
    rows = [{}, {"a": True}, {"a": False, "b": True, "k": 2}]
    assert does(rungs, "BOOL a b q; DINT i n k; COUNTER c", rows, "i n q", routines=sub) == [
        [0, 0, 0], [6, 12, 1], [0, 15, 0]]
    assert told(["FOR(Nope,i,0,9,1);"], "DINT i") == [
        "LD0150 L5X: there is no routine `Nope` in this program"]
    assert told(["FOR(Sub,x,0,9,1);"], "DINT i n; REAL x; COUNTER c", routines=sub)[0] == (
        "LD0150 L5X: `x` cannot count")


# ---- calls in Structured Text

SCALE = xml.addon(
    "Scale", xml.parameter("In", "REAL", "Input") + xml.parameter("Gain", "REAL", "Input", False)
    + xml.parameter("Out", "REAL", "Output") + xml.parameter("Arr", "DINT", "InOut", dims="4"),
    xml.st("Logic", ["Out := In * 2.0 + Gain;", "IF In > 5.0 THEN COP(Arr[0], Arr[2], 1); RETURN; END_IF;",
                     "Arr[1] := 7;"]))
CALC = xml.st("Calc", ["(* JSR(Nope); *) SBR();", "COP(A[0], B[0], 4); // copy", "Scale(sc, x, y, A);",
                       "IF A[1] = 7 THEN JSR(Sub, 2, i, 3, k); END_IF;", "CONCAT(t, 'ab', t); SIZE(A, 0, i);",
                       "n [:=] n + 1; RET();", "n := 99;"])
SUB = xml.st("Sub", ["SBR(i, j);", "IF j = 3 THEN RET(i + j); END_IF;", "RET(0);"])
TAGS = "REAL x y; DINT i j k n A[4] B[4]; STRING t; Scale sc"
ROWS = [{"x": 3.0, "A[0]": 5}, {"x": 6.0}]


def test_calls() -> None:
    parts = {"routines": CALC + SUB, "addons": SCALE}
    assert does(["JSR(Calc,0);"], TAGS, ROWS, "y i k A[1] A[2] B[2] t n", **parts) == [
        [6.0, 4, 3, 7, 0, 0, "ab", 1], [12.0, 4, 7, 7, 5, 0, "abab", 2]]


def test_timers_counters_and_one_shots_of_members() -> None:
    body = ["t.TimerEnable := a; t.PRE := 20; TONR(t);",
            "p.TimerEnable := a; p.PRE := 30; p.Reset := b; RTOR(p);",
            "f.TimerEnable := a; f.PRE := 20; TOFR(f);",
            "c.CUEnable := a; c.CDEnable := b; c.PRE := 1; CTUD(c);",
            "o.InputBit := a; OSRI(o); l.InputBit := a; OSFI(l);"]
    rows = [{"a": True}, {}, {}, {"a": False, "b": True}, {"b": False, "a": True}, {"a": False}, {}, {}]
    declared = "FBD_TIMER t p f; FBD_COUNTER c; FBD_ONESHOT o l; BOOL a b"
    assert does(["JSR(Calc,0);"], declared, rows, "t.ACC t.DN p.ACC f.DN c.ACC c.DN o.OutputBit l.OutputBit",
                routines=xml.st("Calc", body)) == [
        [0, 0, 0, 1, 0, 0, 0, 0], [10, 0, 10, 1, 0, 0, 0, 0], [20, 1, 20, 1, 0, 0, 0, 0],
        [0, 0, 0, 1, -1, 0, 0, 1], [0, 0, 0, 1, 0, 0, 1, 0], [0, 0, 0, 1, 0, 0, 0, 1],
        [0, 0, 0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 0]]


@pytest.mark.parametrize(("line", "message"), [
    ("TON(i, 1, 2);", "LD0151 L5X: instruction TON in Structured Text is not supported"),
    ("GSV(WallClockTime,,LocalDateTime,i);", "LD0151 L5X: instruction GSV is not supported"),
    ("MINE(i);", "LD0151 L5X: instruction MINE is not supported"),
    ("COP(i, j;", "LD0150 L5X: the operands of `COP` do not end"),
    ("JSR(Nope);", "LD0150 L5X: there is no routine `Nope` in this program"),
    ("COP(i, j);", "LD0150 L5X: COP takes 3 operands, 2 are given"),
    ("COP(i, j, 1) k := 1;", "LD0150 L5X: `;` is missing"),
])
def test_calls_that_are_told(line: str, message: str) -> None:
    assert told(["JSR(Calc,0);"], "DINT i j k", routines=xml.st("Calc", [line, "i := 1;"])) == [message]


def test_every_engine_and_every_text_does_the_same(tmp_path: Path) -> None:
    rungs = ["JSR(Calc,0);", "SWPB(i,REVERSE,j)COP(x,i,1);", "FOR(Sub2,n,0,3,1);",
             "XIC(go)[SQO(A[0],16#FF,k,c,3,0),AVE(A[0],0,y,c2,4,0),SRT(A[0],0,c3,4,0)];", "MOV(t.DATA[0],j);"]
    text = xml.one(rungs, f"{TAGS}; CONTROL c c2 c3; BOOL go", addons=SCALE,
                   routines=CALC + SUB + xml.rll("Sub2", ["ADD(k,n,k);"]))
    source = tmp_path / "p.L5X"
    source.write_text(text)
    assert main(["import", str(source), "-o", str(tmp_path / "imported")]) == 0
    program = compiled(text, "p.L5X").program
    machines = {
        "vm": Machine(program), "read back": machine(print_program(program), "printed.il"),
        "st": machine(print_st(program), "printed.st"),
        "imported": Machine(compile_paths([str(tmp_path / "imported")]).program),
    }
    if toolchain.find(toolchain.GCC) is not None:
        machines["native"] = native.machine(program, 10_000_000)
    rows = [{"x": 3.5, "A[0]": 5, "A[2]": 2}, {"go": True}, {"x": 7.0}, {"go": False}]
    found: dict[str, list] = {name: [] for name in machines}
    for name, one in machines.items():
        for row in rows:
            for variable, value in row.items():
                one.set(variable, value)
            one.scan()
            found[name].append([one.get(v) for v in "i j k n y A[0] A[1] A[2] B[2] c.POS t".split()])
    assert found["vm"][1] != found["vm"][2]
    for name, values in found.items():
        assert values == found["vm"], name
