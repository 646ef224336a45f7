"""What ladders of a Logix controller do, scan by scan (docs/import-l5x.md)."""

from __future__ import annotations

from pathlib import Path

import pytest

from ldc import pipeline
from ldc.cli.main import main
from runtime.vm.machine import Machine
from tests import l5x_xml as xml


def machine(path: Path, text: str) -> Machine:
    file = path / "plant.L5X"
    file.write_text(text, encoding="utf-8")
    result = pipeline.compile_paths([str(file)])
    assert result.program is not None, [f"{d.code} {d.message}" for d in result.diagnostics]
    return Machine(result.program)


def trace(m: Machine, watched: str, rows: list[dict[str, object]]) -> list[list[object]]:
    """The variables after each scan; before it a row sets some."""
    found = []
    for row in rows:
        for name, value in row.items():
            m.set(name, value)
        m.scan()
        found.append([int(v) if isinstance(v, bool) else v for v in map(m.get, watched.split())])
    return found


def scans(name: str, pattern: str) -> list[dict[str, object]]:
    return [{name: sign == "1"} for sign in pattern]


# ---- bits -------------------------------------------------------------------------------------


def test_branches_are_evaluated_in_their_order(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(a)[XIC(b),XIO(c) OTE(d)]OTE(e);"], "BOOL a b c d e"))
    rows = [{"a": n & 4 > 0, "b": n & 2 > 0, "c": n & 1 > 0} for n in range(8)]
    assert trace(m, "d e", rows) == [[0, 0]] * 4 + [[1, 1], [0, 0], [1, 1], [0, 1]]


def test_an_empty_level_is_a_wire(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(a)[,XIC(b)OTE(d)]OTE(e);", "XIC(a)[,]OTE(f);"], "BOOL a b d e f"))
    assert trace(m, "d e f", scans("a", "01")) == [[0, 0, 0], [0, 1, 1]]


def test_an_output_passes_the_power_on_and_is_read_behind_it(tmp_path: Path) -> None:
    m = machine(tmp_path,
                xml.one(["XIC(a)OTE(b)XIC(b)OTL(c)XIO(b)OTE(d);", "XIC(e)OTU(c);"], "BOOL a b c d e"))
    assert trace(m, "b c d", [{}, {"a": True}, {"a": False}, {"e": True}]) == [
        [0, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 0]]


def test_one_shots(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(
        ["XIC(a)ONS(s.0)OTE(p)ADD(n,1,n);", "XIC(a)OSR(s.1,r)OTE(q);", "XIC(a)OSF(s.2,f)OTE(g);"],
        "BOOL a p q r f g; DINT s n"))
    assert trace(m, "p n r q f g s", scans("a", "0110010")) == [
        [0, 0, 0, 0, 0, 0, 0], [1, 1, 1, 1, 0, 1, 7], [0, 1, 0, 1, 0, 1, 7], [0, 1, 0, 0, 1, 0, 0],
        [0, 1, 0, 0, 0, 0, 0], [1, 2, 1, 1, 0, 1, 7], [0, 2, 0, 0, 1, 0, 0]]


def test_a_one_shot_with_power_in_the_first_scan_does_not_fire(tmp_path: Path) -> None:
    """The controller sets storage bits and CU before the first scan."""
    m = machine(tmp_path, xml.one(["XIC(a)[ONS(s)OTL(p),OSR(s2,r)OTE(q),CTU(c,5,0)];"],
                                  xml.tag("a", "BOOL", data=xml.value("BOOL", 1)) + xml.tags(
                                      "BOOL s s2 p q r; COUNTER c")))
    assert trace(m, "p r q c.ACC", [{}, {"a": False}, {"a": True}]) == [[0, 0, 1, 0], [0, 0, 0, 0],
        [1, 1, 1, 1]]


def test_bits_of_integers(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(
        ["XIC(a)OTE(d.31);", "XIC(d.31)OTL(w.15);", "XIO(w.15)OTE(b.7);", "XIC(a)XIC(d.[k])OTE(q);",
         "XIC(c)OTU(w.15);"],
        "BOOL a c q; DINT d k; INT w; SINT b"))
    m.set("k", 31)
    assert trace(m, "d w b q", [{}, {"a": True}, {"c": True}]) == [
        [0, 0, -128, 0], [-2147483648, -32768, 0, 1], [-2147483648, 0, 0, 1]]


# ---- timers and counters ----------------------------------------------------------------------


def test_ton(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(a)TON(t,25,0)OTE(q);"], "BOOL a q; TIMER t"))
    assert trace(m, "t.EN t.TT t.DN t.ACC q", scans("a", "011111011")) == [
        [0, 0, 0, 0, 0], [1, 1, 0, 0, 1], [1, 1, 0, 10, 1], [1, 1, 0, 20, 1], [1, 0, 1, 30, 1],
        [1, 0, 1, 30, 1],
        [0, 0, 0, 0, 0], [1, 1, 0, 0, 1], [1, 1, 0, 10, 1]]


def test_ton_counts_the_time_in_which_it_was_jumped_over(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(j)JMP(over);", "XIC(a)TON(t,1000,0);", "LBL(over)XIC(t.DN)OTE(q);"],
                                  "BOOL a j q; TIMER t"))
    rows = [{"a": True}, {"j": True}, {}, {"j": False}]
    assert trace(m, "t.ACC", rows) == [[0], [0], [0], [30]]


def test_tof(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(a)TOF(t,25,0);"], "BOOL a; TIMER t"))
    assert trace(m, "t.EN t.TT t.DN t.ACC", scans("a", "0100000")) == [
        [0, 0, 0, 0], [1, 0, 1, 0], [0, 1, 1, 0], [0, 1, 1, 10], [0, 1, 1, 20], [0, 0, 0, 30], [0, 0, 0, 30]]


def test_rto_keeps_what_it_has_until_res(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(a)RTO(t,25,0);", "XIC(r)RES(t);"], "BOOL a r; TIMER t"))
    rows = [*scans("a", "1101110"), {"r": True}]
    assert trace(m, "t.EN t.TT t.DN t.ACC", rows) == [
        [1, 1, 0, 0], [1, 1, 0, 10], [0, 0, 0, 10], [1, 1, 0, 10], [1, 1, 0, 20], [1, 0, 1, 30],
        [0, 0, 1, 30],
        [0, 0, 0, 0]]


def test_a_timer_keeps_the_preset_of_its_data_and_drops_the_rest(tmp_path: Path) -> None:
    data = xml.structure("TIMER", PRE=15, ACC=9, EN=1, TT=1, DN=0)
    m = machine(tmp_path,
                xml.one(["XIC(a)TON(t,?,?);"], xml.tag("t", "TIMER", data=data) + xml.tags("BOOL a")))
    assert m.get("t.PRE") == 15 and m.get("t.ACC") == 0 and m.get("t.EN") is False
    assert trace(m, "t.DN t.ACC", scans("a", "111")) == [[0, 0], [0, 10], [1, 20]]


def test_counters_up_and_down(tmp_path: Path) -> None:
    m = machine(tmp_path,
                xml.one(["XIC(u)CTU(c,2,0);", "XIC(d)CTD(c,?,?);", "XIC(r)RES(c);"], "BOOL u d r; COUNTER c"))
    rows = [{"u": False}, {"u": True}, {}, {"u": False}, {"u": True}, {"d": True}, {"r": True}]
    assert trace(m, "c.ACC c.CU c.CD c.DN", rows) == [
        [0, 0, 0, 0], [1, 1, 0, 0], [1, 1, 0, 0], [1, 0, 0, 0], [2, 1, 0, 1], [1, 1, 1, 0], [0, 0, 0, 0]]


def test_counters_go_round_at_the_ends_of_a_dint(tmp_path: Path) -> None:
    data = xml.structure("COUNTER", PRE=10, ACC=2147483647)
    m = machine(tmp_path, xml.one(["XIC(u)CTU(c,?,?);", "XIC(d)CTD(c,?,?);"],
                                  xml.tag("c", "COUNTER", data=data) + xml.tags("BOOL u d")))
    rows = [{}, {"u": True}, {"u": False, "d": True}, {"d": False}]
    assert trace(m, "c.ACC c.DN c.OV c.UN", rows) == [
        [2147483647, 0, 0, 0], [-2147483648, 1, 1, 0], [2147483647, 1, 0, 0], [2147483647, 1, 0, 0]]


# ---- values -----------------------------------------------------------------------------------

COMPUTED = [
    ("ADD(i,d,x)", "x", 7 + 100), ("SUB(d,2.6,x)", "x", 97), ("MUL(i,i,s)", "s", 49), ("MUL(d,d,s)", "s", 16),
    ("DIV(i,2,x)", "x", 3), ("DIV(i,2,f)", "f", 3.5), ("DIV(d,z,x)", "x", 100),
    ("DIV(r,z,f)", "f", float("inf")),
    ("MOD(i,4,x)", "x", 3), ("MOD(r,2,f)", "f", 0.5), ("MOD(i,z,x)", "x", 7), ("NEG(i,x)", "x", -7),
    ("ABS(-5,x)", "x", 5), ("SQR(50,x)", "x", 7), ("SQR(-16,f)", "f", 4.0), ("MOV(r,x)", "x", 2),
    ("MOV(3.5,x)", "x", 4), ("MOV(-2.5,x)", "x", -2), ("MOV(16#FFFF_FFFF,x)", "x", -1),
    ("MOV(d,f)", "f", 100.0),
    ("MOV(300,b)", "b", 44), ("CLR(d)", "d", 0), ("CPT(x,(i+1)*2-d/3)", "x", -17),
    ("CPT(f,i/2+0.25)", "f", 3.75),
    ("CPT(x,2**10)", "x", 1024), ("CPT(x,-i MOD 4)", "x", -3), ("CPT(x,i AND 5 OR 16#10)", "x", 21),
    ("AND(d,6,x)", "x", 4), ("OR(d,3,x)", "x", 103), ("XOR(d,-1,x)", "x", -101), ("NOT(z,x)", "x", -1),
    ("OR(n,0,x)", "x", 65535), ("MVM(16#1234,16#0FF0,x)", "x", 0x230), ("BTD(d,2,x,4,3)", "x", 0x10),
    ("TRN(2.9,x)", "x", 2), ("DEG(0.0,f)", "f", 0.0), ("SIN(0,f)", "f", 0.0), ("LOG(1000.0,f)", "f", 3.0),
    ("TOD(123,x)", "x", 0x123), ("FRD(16#123,x)", "x", 123), ("XPY(2,0.5,f)", "f", 1.4142135381698608),
    ("SCP(5,0,10,0,100,f)", "f", 50.0), ("SCL(d,20000,5,x)", "x", 205), ("SCL(r,2.0,1.0,f)", "f", 6.0),
]


@pytest.mark.parametrize(("text", "name", "wanted"), COMPUTED, ids=[c[0] for c in COMPUTED])
def test_computed(tmp_path: Path, text: str, name: str, wanted: object) -> None:
    data = {"i": ("INT", 7), "d": ("DINT", 100), "r": ("REAL", 2.5), "n": ("INT", -1)}
    declared = "".join(xml.tag(n, t, data=xml.value(t, v)) for n, (t, v) in data.items())
    m = machine(tmp_path,
                xml.one([f"XIC(go){text};"], declared + xml.tags("BOOL go; DINT x z; SINT b s; REAL f")))
    before = m.get(name)
    m.scan()
    assert m.get(name) == before, "nothing is computed without power"
    m.set("go", True)
    m.scan()
    assert m.get(name) == wanted


COMPARED = [
    ("EQU(i,7)", 1), ("NEQ(i,7)", 0), ("GRT(r,2)", 1), ("GEQ(i,r)", 1), ("LES(d,i)", 0), ("LEQ(b,i)", 1),
    ("LIM(1,i,7)", 1), ("LIM(8,i,7)", 1), ("LIM(8,7.5,7)", 0), ("MEQ(i,6,16#E)", 1),
    ("CMP(i*2>d-90 AND r<3)",1),
    ("CMP(i-7)", 0), ("EQU(t,'abc')", 1), ("NEQ(t,'ABC')", 1), ("LES(b,-1)", 1),
    ("EQU(u,-1)",0), ("XIC(i.0)", 1),
    ("XIO(i.0)", 0), ("CMP(NOT (i = 7))", 0), ("EQU(t.LEN,3)", 1),
]


@pytest.mark.parametrize(("text", "wanted"), COMPARED, ids=[c[0] for c in COMPARED])
def test_compared(tmp_path: Path, text: str, wanted: int) -> None:
    data = {"i": ("INT", 7), "d": ("DINT", 100), "r": ("REAL", 2.5), "b": ("SINT", -2), "u": ("DINT", 255)}
    abc = ('<Structure DataType="STRING"><DataValueMember Name="LEN" Value="3"/>'
           "<DataValueMember Name=\"DATA\"><![CDATA['abc$00']]></DataValueMember></Structure>")
    declared = "".join(xml.tag(n, t, data=xml.value(t, v)) for n, (t, v) in data.items())
    m = machine(tmp_path,
                xml.one([f"{text}OTE(q);"], declared + xml.tag("t", "STRING", data=abc) + xml.tags("BOOL q")))
    assert trace(m, "q", [{}]) == [[wanted]]


TEXTS = [
    ("CONCAT('ab','cd',s)", "abcd"), ("MID('abcdef',3,2,s)", "bcd"), ("DELETE('abcdef',2,3,s)", "abef"),
    ("INSERT('abef','cd',3,s)", "abcdef"), ("UPPER('aBc1',s)", "ABC1"), ("LOWER('aBC1',s)", "abc1"),
    ("DTOS(-12,s)", "-12"), ("MOV('x$'y',s)", "x'y"),
]


@pytest.mark.parametrize(("text", "wanted"), TEXTS, ids=[c[0] for c in TEXTS])
def test_strings(tmp_path: Path, text: str, wanted: str) -> None:
    m = machine(tmp_path, xml.one([f"{text};"], "STRING s"))
    m.scan()
    assert m.get("s") == wanted


def test_numbers_in_strings(tmp_path: Path) -> None:
    m = machine(tmp_path,
                xml.one(["STOD('a -12b3',x)FIND('abcabc','bc',3,y)FIND('abc','x',1,z);"], "DINT x y z"))
    assert trace(m, "x y z", [{}]) == [[-12, 5, 0]]


# ---- arrays -----------------------------------------------------------------------------------


def test_copy_and_fill(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(
        ["XIC(go)[FLL(7,a[1],2),COP(a[0],b[2],9),COP(a,c,1),COP(a[1],a[2],2),FLL(n,r,3)];"],
        "BOOL go; DINT a[4] b[5] c n; REAL r[2]"))
    m.set("n", 4)
    assert trace(m, "a[0] a[1] a[2] a[3] b[1] b[2] b[3] b[4] c r[1]", [{}, {"go": True}]) == [
        [0] * 9 + [0.0], [0, 7, 7, 7, 0, 0, 7, 7, 0, 4.0]]


def test_structures_are_copied_whole(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(go)COP(t[1],u,1)COP(t[0],v[0],2);"], "BOOL go; TIMER t[2] u v[2]"))
    m.set("t[1].ACC", 5)
    assert trace(m, "u.ACC v[1].ACC", scans("go", "01")) == [[0, 0], [5, 5]]


def test_first_in_first_out_and_last_in_first_out(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(
        ["XIC(l)[FFL(x,f,c,3,0),LFL(x,g,d,3,0)];", "XIC(u)[FFU(f,y,c,3,0),LFU(g,z,d,3,0)];"],
        "BOOL l u; DINT x y z f[3] g[3]; CONTROL c d"))
    rows = [{}]
    for n in (11, 12, 13, 14):
        rows += [{"x": n, "l": True}, {"l": False}]
    trace(m, "x", rows)
    assert trace(m, "c.POS c.DN f[2] y z", [{"u": True}, {}, {"u": False}, {"u": True}]) == [
        [2, 0, 0, 11, 13], [2, 0, 0, 11, 13], [2, 0, 0, 11, 13], [1, 0, 0, 12, 12]]
    assert trace(m, "c.EM y z", [{"u": False}, {"u": True}, {"u": False}, {"u": True}]) == [
        [0, 12, 12], [1, 13, 11], [1, 13, 11], [1, 0, 0]]


@pytest.mark.parametrize("name", ["BSL", "BSR"])
def test_bits_are_shifted_through_an_array(tmp_path: Path, name: str) -> None:
    length = 40
    m = machine(tmp_path, xml.one([f"XIC(go){name}(a,c,bit,{length});"], "BOOL go bit; DINT a[2]; CONTROL c"))
    bits = [0] * length
    m.scan()
    for n in range(90):
        fed = int(n % 7 in (0, 3))
        bits, out = ([fed, *bits[:-1]], bits[-1]) if name == "BSL" else ([*bits[1:], fed], bits[0])
        m.set("bit", bool(fed))
        got = trace(m, "a[0] a[1] c.UL c.DN c.POS", [{"go": True}, {}])
        whole = sum(bit << at for at, bit in enumerate(bits))
        low = whole & 0xFFFFFFFF
        assert got[0] == got[1] == [low - (1 << 32) if low >> 31 else low, whole >> 32, out, 1, length]
        assert trace(m, "c.DN c.POS", [{"go": False}]) == [[0, 0]]


def test_fal_all_and_one_by_one(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(
        ["XIC(all)FAL(c,3,0,ALL,f[c.POS],d[c.POS]*1.5);", "XIC(inc)FAL(e,3,0,INC,d[e.POS],e.POS+10);"],
        "BOOL all inc; REAL f[3]; DINT d[3]; CONTROL c e"))
    assert trace(m, "d[0] d[1] e.POS e.DN", scans("inc", "0101101")) == [
        [0, 0, 0, 0], [10, 0, 1, 0], [10, 0, 1, 0], [10, 11, 2, 0], [10, 11, 2, 0], [10, 11, 2, 0],
        [10, 11, 3, 1]]
    assert trace(m, "f[0] f[2] c.POS c.DN", scans("all", "100")) == [[15.0, 18.0, 3, 1], [15.0, 18.0, 0, 0],
        [15.0, 18.0, 0, 0]]


def test_fsc_stops_at_what_it_finds(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(go)FSC(c,4,0,2,d[c.POS]>5);", "XIC(go_on)OTU(c.IN);"],
                                  "BOOL go go_on; DINT d[4]; CONTROL c"))
    m.set("d[1]", 9)
    rows = [{}, {"go": True}, {}, {"go_on": True}, {}, {}]
    assert trace(m, "c.POS c.FD c.DN", rows) == [[0, 0, 0], [1, 1, 0], [1, 1, 0], [1, 1, 0], [4, 0, 1],
                                                 [4, 0, 1]]


# ---- the order of rungs -----------------------------------------------------------------------


def test_subroutines_run_under_power_between_the_rungs_of_the_caller(tmp_path: Path) -> None:
    sub = xml.rll("Sub", ["SBR(p,q);", "ADD(p,q,s)XIC(stop)RET(s);", "ADD(s,100,s);", "RET(s);"])
    m = machine(tmp_path, xml.one(["MOV(1,n);", "XIC(go)JSR(Sub,2,n,10,r)OTE(done);", "MOV(2,n);"],
                                  "BOOL go stop done; DINT n p s r; INT q", sub))
    rows = [{}, {"go": True}, {"stop": True}, {"go": False}]
    assert trace(m, "p q s r done", rows) == [[0, 0, 0, 0, 0], [1, 10, 111, 111, 1], [1, 10, 11, 11, 1],
                                              [1, 10, 11, 11, 0]]


def test_a_routine_that_calls_another_and_one_that_nobody_calls(tmp_path: Path) -> None:
    routines = xml.rll("A", ["JSR(B);",
                             "ADD(n,1,n);"]) + xml.rll("B", ["ADD(n,10,n);"]) + xml.rll("C", ["MOV(0,n);"])
    m = machine(tmp_path, xml.one(["JSR(A);", "JSR(B);"], "DINT n", routines))
    assert trace(m, "n", [{}, {}]) == [[21], [42]]


def test_jumps_labels_and_the_end(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(a)JMP(x);", "OTL(q);", "LBL(x);", "NOP();", "XIC(b)TND();", "OTL(r);",
                                   "LBL(x2)XIC(a)JMP(last);", "OTL(s);", "LBL(last);"], "BOOL a b q r s"))
    assert trace(m, "q r s", [{"a": True, "b": True}, {"b": False}, {"a": False}]) == [[0, 0, 0], [0, 1, 0],
        [1, 1, 1]]


def test_a_master_control_zone_takes_the_power_from_its_rungs(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["XIC(on1)MCR();", "XIC(a)OTE(q);", "OTL(l)TON(t,1000,0);", "MCR();",
                                   "XIC(a)OTE(r);"],
                                  "BOOL on1 a q l r; TIMER t"))
    rows = [{"a": True}, {"on1": True}, {}, {"on1": False}]
    assert trace(m, "q l t.ACC r", rows) == [[0, 0, 0, 1], [1, 1, 0, 1], [1, 1, 10, 1], [0, 1, 0, 1]]


def test_afi_and_the_first_scan(tmp_path: Path) -> None:
    m = machine(tmp_path, xml.one(["AFI()OTE(q);", "XIC(S:FS)ADD(n,1,n);"],
                                  xml.tag("q", "BOOL", data=xml.value("BOOL", 1)) + xml.tags("DINT n")))
    assert trace(m, "q n", [{}, {}]) == [[0, 1], [0, 1]]


# ---- Add-On Instructions ----------------------------------------------------------------------

GAIN = xml.addon(
    "Gain",
    xml.parameter("X", "INT", "Input") + xml.parameter("Factor", "DINT", "Input",
                                                       False) + xml.parameter("Y", "DINT", "Output")
    + xml.parameter("Log", "DINT", "InOut", dims="3"),
    xml.rll("Logic", ["MUL(X,Factor,Y)ADD(n,1,n)MOV(n,Log[2]);", "XIC(Reset)CLR(n)OTU(Reset);",
                      "XIO(t.DN)TON(t,20,0);"]),
    '<LocalTag Name="n" DataType="DINT"/><LocalTag Name="t" DataType="TIMER"/>'
    '<LocalTag Name="Reset" DataType="BOOL"/>')


def test_an_addon_keeps_its_data_in_the_instance(tmp_path: Path) -> None:
    text = xml.one(["XIC(go)Gain(g[1],i,d,log);", "XIC(g[1].Y.0)OTE(odd);", "MOV(3,g[1].Factor);"],
                   "BOOL go odd; INT i; DINT d log[3]; Gain g[2]", addons=GAIN)
    m = machine(tmp_path, text)
    rows = [{"i": 7}, {"go": True}, {}, {"go": False, "i": 1}, {"d": 5}]
    assert trace(m, "d g[1].Y g[1].X log[2] g[1].n g[1].t.ACC odd", rows) == [
        [0, 0, 7, 0, 0, 0, 0], [21, 21, 7, 1, 1, 0, 1], [21, 21, 7, 2, 2, 10, 1], [21, 21, 1, 2, 2, 10, 1],
        [5, 21, 1, 2, 2, 10, 1]]


def test_an_addon_without_power_and_one_that_switches_the_power_off(tmp_path: Path) -> None:
    flip = xml.addon("Flip", xml.parameter("Q", "BOOL", "Output", False),
                     xml.rll("Logic", ["OTL(Q);", "OTU(EnableOut);"]) + xml.rll("EnableInFalse", ["OTU(Q);"]),
                     more='ExecuteEnableInFalse="true"')
    m = machine(tmp_path, xml.one(["XIC(go)Flip(f)OTE(behind);"], "BOOL go behind; Flip f", addons=flip))
    assert trace(m, "f.Q behind", scans("go", "010")) == [[0, 0], [1, 0], [0, 0]]


def test_addons_call_one_another_and_lie_in_structures(tmp_path: Path) -> None:
    inner = xml.addon("Inner", xml.parameter("X", "DINT", "Input"), xml.rll("Logic", ["ADD(Sum,X,Sum);"]),
                      '<LocalTag Name="Sum" DataType="DINT"/>')
    outer = xml.addon("Outer", xml.parameter("X", "DINT", "Input"),
                      xml.rll("Logic", ["Inner(a,X)Inner(b,a.Sum);"]),
                      '<LocalTag Name="a" DataType="Inner"/><LocalTag Name="b" DataType="Inner"/>')
    types = ('<DataType Name="Box"><Members><Member Name="o" DataType="Outer" Dimension="2"/></Members>'
             "</DataType>")
    m = machine(tmp_path, xml.one(["Outer(box.o[1],2);"], "Box box", addons=inner + outer, types=types))
    assert trace(m, "box.o[1].a.Sum box.o[1].b.Sum", [{}, {}]) == [[2, 2], [4, 6]]


def test_an_addon_in_structured_text_with_defaults_and_an_alias(tmp_path: Path) -> None:
    text = xml.addon(
        "Clamp", xml.parameter("X", "DINT", "Input")
        + '<Parameter Name="Top" DataType="DINT" Usage="Input" Required="false">'
        '<DefaultData Format="Decorated"><DataValue DataType="DINT" Value="9"/></DefaultData></Parameter>'
        '<Parameter Name="Y" TagType="Alias" Usage="Output" AliasFor="r.PRE" Required="true"/>',
        xml.st("Logic", ["IF X > Top THEN // cut", "  r.PRE := Top; RETURN;", "END_IF;", "r.PRE := X;"]),
        '<LocalTag Name="r" DataType="TIMER"/>')
    m = machine(tmp_path, xml.one(["Clamp(c,x,y);"], "Clamp c; DINT x y", addons=text))
    assert trace(m, "y c.r.PRE", [{"x": 5}, {"x": 50}, {"c.Top": 20}]) == [[5, 5], [9, 9], [20, 20]]


# ---- the file ---------------------------------------------------------------------------------


def test_structures_with_bits_arrays_and_values(tmp_path: Path) -> None:
    types = ('<DataType Name="Part" Family="NoFamily" Class="User"><Members>'
             '<Member Name="ZZZZHost0" DataType="SINT" Dimension="0" Hidden="true"/>'
             '<Member Name="Ok" DataType="BIT" Dimension="0" Target="ZZZZHost0" BitNumber="0"/>'
             '<Member Name="Step" DataType="INT" Dimension="3"/></Members></DataType>')
    data = ('<Array DataType="Part" Dimensions="2"><Element Index="[1]"><Structure DataType="Part">'
            '<DataValueMember Name="Ok" DataType="BOOL" Value="1"/>'
            '<ArrayMember Name="Step" DataType="INT" Dimensions="3"><Element Index="[0]" Value="16#ffff"/>'
            '<Element Index="[2]" Value="5"/></ArrayMember></Structure></Element></Array>')
    m = machine(tmp_path, xml.one(["XIC(parts[k].Ok)MOV(parts[k].Step[2],n);"],
                                  xml.tag("parts", "Part", "2", data) + xml.tags("DINT k n"), types=types))
    assert m.get("parts[1].Step_[0]") == -1
    assert trace(m, "n", [{}, {"k": 1}]) == [[0], [5]]


def test_bits_of_a_hidden_member_that_logic_names_are_its_bits(tmp_path: Path) -> None:
    types = ('<DataType Name="Faults" Family="NoFamily" Class="User"><Members>'
             '<Member Name="All" DataType="SINT" Dimension="0" Hidden="true"/>'
             '<Member Name="Jam" DataType="BIT" Dimension="0" Target="All" BitNumber="0"/>'
             '<Member Name="Heat" DataType="BIT" Dimension="0" Target="All" BitNumber="7"/>'
             '</Members></DataType>')
    data = ('<Structure DataType="Faults"><DataValueMember Name="Jam" DataType="BOOL" Value="1"/>'
            '<DataValueMember Name="Heat" DataType="BOOL" Value="1"/></Structure>')
    declared = xml.tag("f", "Faults", data=data) + xml.tags(
        "Faults g h[3]; DINT n k; BOOL set jam heat copied")
    m = machine(tmp_path, xml.one(
        ["XIC(set)MOV(n,f.all);", "XIC(heat)OTL(f.Heat);", "XIO(f.Jam)OTE(jam);", "COP(f,g,1);",
         "COP(g,h[k],1);", "XIC(h[k].Heat)OTE(copied);"], declared, types=types))
    assert trace(m, "f.All jam g.All copied", [{}, {"set": True, "n": 2}, {"heat": True, "k": 2}]) == [
        [-127, 0, -127, 1], [2, 1, 2, 0], [-126, 1, -126, 1]]
    assert m.get("h[0].All") == 2


def test_bits_of_a_visible_member_are_its_bits_in_structured_text(tmp_path: Path) -> None:
    types = ('<DataType Name="Word" Family="NoFamily" Class="User"><Members>'
             '<Member Name="Whole" DataType="DINT" Dimension="0"/>'
             '<Member Name="Top" DataType="BIT" Dimension="0" Target="Whole" BitNumber="31"/>'
             '</Members></DataType>')
    lines = ["w.Top := go;", "IF w.Top THEN n := n + 1; END_IF;"]
    text = xml.one(["JSR(Calc,0);"], "Word w; BOOL go; DINT n", xml.st("Calc", lines), types=types)
    assert trace(machine(tmp_path, text), "n", [{}, {"go": True}, {}]) == [[0], [1], [2]]


def test_aliases_modules_and_undeclared_inputs(tmp_path: Path) -> None:
    module = ('<Modules><Module Name="In" ParentModule="Local"><Ports>'
              '<Port Id="1" Address="1" Type="ICP" Upstream="true"/></Ports><Communications><Connections>'
              '<Connection Name="Std"><InputTag><Data Format="Decorated">'
              '<Structure DataType="AB:1756_DI:I:0"><DataValueMember Name="Fault" DataType="DINT" Value="0"/>'
              '<DataValueMember Name="Data" DataType="DINT" Value="2"/></Structure></Data></InputTag>'
              "</Connection></Connections></Communications></Module></Modules>")
    declared = ('<Tag Name="Door" TagType="Alias" AliasFor="Local:1:I.Data.1"/>'
                '<Tag Name="Lamp" TagType="Alias" AliasFor="Local:2:O.Data.3"/>')
    m = machine(tmp_path, xml.one(["XIC(Door)OTE(Lamp);", "GRT(Local:3:I.Ch0Data,5)OTE(high);"],
                                  declared + xml.tags("BOOL high"), more=module))
    assert trace(m, "Local_2_O_Data high", [{}, {"Local_1_I.Data": 0}, {"Local_3_I_Ch0Data": 6}]) == [
        [8, 0], [0, 0], [0, 1]]


def test_program_tags_hide_those_of_the_controller(tmp_path: Path) -> None:
    programs = (xml.program("P1", xml.rll("Main", ["ADD(n,1,n);"]), xml.tags("DINT n"))
                + xml.program("P2", xml.rll("Main", ["ADD(n,10,n)MOV(\\P1.n,seen);"])))
    m = machine(tmp_path, xml.controller(programs, xml.tags("DINT n seen")))
    assert trace(m, "P1_n n seen", [{}, {}]) == [[1, 10, 1], [2, 20, 2]]


def test_tasks_run_their_programs_at_their_rates(tmp_path: Path) -> None:
    programs = "".join(xml.program(p, xml.rll("Main", [f"ADD({p}n,1,{p}n);"]))
                       for p in ("Slow", "All", "Never"))
    tasks = ('<Tasks><Task Name="P10" Type="PERIODIC" Rate="10" Priority="10"><ScheduledPrograms>'
             '<ScheduledProgram Name="All"/></ScheduledPrograms></Task>'
             '<Task Name="P30" Type="PERIODIC" Rate="30" Priority="5"><ScheduledPrograms>'
             '<ScheduledProgram Name="Slow"/></ScheduledPrograms></Task></Tasks>')
    m = machine(tmp_path, xml.controller(programs, xml.tags("DINT Slown Alln Nevern"), more=tasks))
    trace(m, "Slown", [{}] * 7)
    assert [m.get(n) for n in ("Slown", "Alln", "Nevern")] == [3, 7, 0]


def test_routines_without_a_type_are_known_by_what_they_hold(tmp_path: Path) -> None:
    routines = xml.rll("Main", ["JSR(Calc,0);"]) + xml.st("Calc", ["n := n + 2;"])
    text = xml.controller(xml.program("P", routines), xml.tags("DINT n"))
    bare = text.replace(' Type="RLL"', "").replace(' Type="ST"', "")
    assert bare != text
    assert trace(machine(tmp_path, bare), "n", [{}, {}]) == [[2], [4]]


def test_structured_text_routines(tmp_path: Path) -> None:
    body = ["(* sum *) total := 0;", "FOR k := 0 TO 3 DO", " IF a[k] < 0 THEN CONTINUE; END_IF;",
            "  total := total + a[k] / 2; /* REAL */", "END_FOR;", "CASE mode OF", " 1, 2: n := 10;",
            " 3..5: n := 2.5;",
            "ELSE n := n + 1; END_CASE;", "WHILE n > 100 DO n := n - 1; END_WHILE;", "w.3 := total > 2;",
            "REPEAT m := m + 1; UNTIL m >= 5 END_REPEAT;"]
    declared = xml.tags("REAL total; DINT a[4] k n m w; INT mode; BOOL go")
    m = machine(tmp_path, xml.controller(
        xml.program("Main", xml.rll("Main", ["XIC(go)JSR(Sums,0);"]) + xml.st("Sums", body)), declared))
    m.set("a[0]", 3), m.set("a[1]", -7), m.set("a[2]", 2)
    rows = [{}, {"go": True}, {"mode": 2}, {"mode": 4}]
    assert trace(m, "total n w m", rows) == [[0.0, 0, 0, 0], [2.5, 1, 8, 5], [2.5, 10, 8, 6], [2.5, 2, 8, 7]]


def test_pid_moves_its_output_by_gains_and_limits(tmp_path: Path) -> None:
    data = xml.structure("PID", KP="2.0", KI="1.0", UPD="0.5", MAXO="60.0", SP="10.0")
    m = machine(tmp_path,
                xml.one(["PID(p,pv,0,cv,0,0,0);"], xml.tag("p", "PID", data=data) + xml.tags("REAL pv cv")))
    assert trace(m, "cv p.ERR p.OLH", [{"pv": 4.0}, {}, {"pv": -90.0}]) == [
        [15.0, 6.0, 0], [18.0, 6.0, 0], [60.0, 100.0, 1]]


def test_an_export_of_a_routine_runs_it(tmp_path: Path) -> None:
    """Without a main routine, what nobody calls runs."""
    text = xml.controller('<Program Name="P"><Routines>' + xml.rll("R", ["XIC(a)OTE(q);"], {0: "One & two"})
                          + "</Routines></Program>", xml.tags("BOOL a q"))
    m = machine(tmp_path, text)
    assert trace(m, "q", scans("a", "01")) == [[0], [1]]


def test_the_text_of_a_string_tag(tmp_path: Path) -> None:
    text = xml.tag("s", "STRING").replace(
        "></Tag>", "><Data Format=\"String\" Length=\"4\"><![CDATA['a$'b$0A']]></Data></Tag>")
    assert machine(tmp_path, xml.one(["NOP();"], text)).get("s") == "a'b\n"


def test_an_imported_project_does_the_same(tmp_path: Path) -> None:
    """The tree as ladder text, read again."""
    text = xml.one(["XIC(go)[TON(t,25,0),ONS(s.0)ADD(n,1,n)]Gain(g,i,n,log);",
                    "MUL(i,2.5,i)FAL(c,3,0,ALL,log[c.POS],n);"],
                   "BOOL go; TIMER t; DINT s n log[3]; INT i; CONTROL c; Gain g", addons=GAIN)
    rows = [{"i": 3}, {"go": True}, {}, {"go": False}, {"go": True}]
    watched = "t.ACC n i log[2] g.n c.DN"
    wanted = trace(machine(tmp_path, text), watched, rows)
    assert main(["import", str(tmp_path / "plant.L5X"), "-o", str(tmp_path / "out")]) == 0
    result = pipeline.compile_paths([str(tmp_path / "out")])
    assert result.program is not None, [f"{d.code} {d.message}" for d in result.diagnostics]
    assert trace(Machine(result.program), watched, rows) == wanted and wanted[-1] != wanted[0]
