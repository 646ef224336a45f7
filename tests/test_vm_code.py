"""What compiled IL does: operators, stores, hazards, jumps, calls, aggregates, deep and long code."""

from __future__ import annotations

import pytest
from il_build import program, simple, unit, var

from ldc.types import (
    BOOL,
    BYTE,
    DINT,
    INT,
    LINT,
    LREAL,
    REAL,
    SINT,
    UINT,
    ULINT,
    USINT,
    WORD,
    Array,
    Field,
    Instance,
    String,
    Struct,
)
from runtime.vm.machine import Machine


def after(source, scans: int = 1, **values) -> Machine:
    machine = Machine(source)
    for name, value in values.items():
        machine.set(name, value)
    for _ in range(scans):
        machine.scan()
    return machine


BOOLS = [var(n) for n in ("a", "b", "c", "d", "q", "r", "t")]


@pytest.mark.parametrize(
    "code, meaning",
    [
        ("LD a; AND b; OR c; ANDN d; ST q", lambda a, b, c, d: (a and b or c) and not d),
        ("LD a; AND( b; OR c; ); ST q", lambda a, b, c, d: a and (b or c)),
        ("LDN a; XOR b; XORN c; STN q", lambda a, b, c, d: not ((not a) ^ b ^ (not c))),
        ("LD a; ORN( b; AND( c; XOR d; ); ); ST q", lambda a, b, c, d: a or not (b and (c ^ d))),
        ("LD a; NOT; AND b; NOT; ST q", lambda a, b, c, d: not (not a and b)),
        ("LD a; EQ b; ST q", lambda a, b, c, d: a == b),
        ("LD TRUE; AND a; OR FALSE; ST q", lambda a, b, c, d: a),
        (
            "LD a; AND TRUE; XOR( b; AND c; ); OR( d; ANDN a; ); ST q",
            lambda a, b, c, d: a ^ (b and c) or d and not a,
        ),
        ("LD FALSE; AND a; ST q; LD b; OR TRUE; ANDN c; ST r; LD q; OR r; ST q", lambda a, b, c, d: not c),
    ],
)
def test_boolean_operators(code: str, meaning) -> None:
    machine = Machine(simple(BOOLS, code))
    for bits in range(16):
        a, b, c, d = (bool(bits >> i & 1) for i in range(4))
        for name, value in zip("abcd", (a, b, c, d), strict=True):
            machine.set(name, value)
        machine.scan()
        assert machine.get("q") is meaning(a, b, c, d), bits


def test_what_is_pending_is_read_before_it_is_written() -> None:
    """`LD q` is evaluated when it stands there, not when its value is used after a store to q."""
    machine = after(simple(BOOLS, "LD q; ST r; NOT; ST q; AND( r; ST t; OR q; ); ST c"), q=True)
    assert [machine.get(n) for n in "rqtc"] == [True, False, True, False]
    machine = after(simple(BOOLS, "LD q; AND( a; S q; R a; ); ST r"), q=False, a=True)
    assert [machine.get(n) for n in "qar"] == [True, False, False]


def test_set_and_reset() -> None:
    machine = Machine(simple(BOOLS, "LD a; AND c; S q; LD b; R q"))
    seen = []
    for a, b in ((0, 0), (1, 0), (0, 0), (1, 1), (0, 0)):
        machine.set("a", a), machine.set("b", b), machine.set("c", 1)
        machine.scan()
        seen.append(machine.get("q"))
    assert seen == [False, True, True, False, False]


@pytest.mark.parametrize(
    "type_, a, op, b, expected",
    [
        (INT, 32767, "ADD", 1, -32768),
        (INT, -32768, "SUB", 1, 32767),
        (INT, 300, "MUL", 300, 24464),
        (SINT, 127, "ADD", 1, -128),
        (USINT, 255, "ADD", 1, 0),
        (UINT, 0, "SUB", 1, 65535),
        (LINT, 2**63 - 1, "ADD", 1, -(2**63)),
        (ULINT, 2**64 - 1, "MUL", 2**64 - 1, 1),
        (DINT, -7, "DIV", 2, -3),
        (DINT, -7, "MOD", 2, -1),
        (DINT, 7, "MOD", -2, 1),
        (INT, -32768, "DIV", -1, -32768),
        (UINT, 7, "DIV", 2, 3),
        (REAL, 0.1, "ADD", 0.2, 0.30000001192092896),
        (LREAL, 0.1, "ADD", 0.2, 0.1 + 0.2),
        (REAL, 3e38, "MUL", 10.0, float("inf")),
        (REAL, 1.0, "DIV", 3.0, 0.3333333432674408),
    ],
)
def test_arithmetic(type_, a, op: str, b, expected) -> None:
    source = simple([var("a", type_), var("b", type_), var("q", type_)], f"LD a; {op} b; ST q")
    assert after(source, a=a, b=b).get("q") == expected


def test_sums_wrap_where_it_shows() -> None:
    numbers = [var(n, INT) for n in "abq"] + [var("big"), var("d", DINT)]
    machine = after(
        simple(numbers, "LD a; ADD b; ADD b; ST q; GT 0; ST big; LD a; ADD b; FN INT_TO_DINT:DINT; ST d"),
        a=30000,
        b=30000,
    )
    assert (machine.get("q"), machine.get("big"), machine.get("d")) == (24464, True, -5536)


def test_bits_of_words() -> None:
    names = [var("w", WORD), var("q"), var("b", BYTE)]
    machine = after(
        simple(names, "LD w.15; ST q; STN w.0; LD TRUE; ST b.7; S b.1; R w.15; LD w; XOR 255:WORD; ST w"),
        w=0x8000,
    )
    assert (machine.get("q"), machine.get("w"), machine.get("b")) == (True, 0xFF, 0x82)
    assert machine.get("b.7") is True and machine.get("b.6") is False
    machine.set("b.6", 1)
    assert machine.get("b") == 0xC2


def test_strings_are_cut_at_the_store() -> None:
    names = [var("s", String("STRING", 5), initial=b"hello"), var("long", String("STRING", 20)), var("less")]
    machine = after(simple(names, "LD s; FN CONCAT:STRING s; ST long; ST s; LD s; LT long; ST less"))
    assert (machine.get("long"), machine.get("s"), machine.get("less")) == ("hellohello", "hello", True)


POINT = Struct("point", (Field("x", INT, 3), Field("flags", Array(((0, 1),), BOOL))))


def test_aggregates_are_copied_deeply() -> None:
    names = [
        var("p", POINT),
        var("grid", Array(((1, 2), (-1, 1)), POINT)),
        var("i", INT, initial=2),
        var("r", INT),
    ]
    rungs = (
        "LD p; ST grid[2,-1]",
        "LD 9; ST p.x; LD TRUE; ST p.flags[1]",
        "LD 7; ST grid[i,1].x; LD grid[2,-1].x; ST r",
    )
    machine = after(simple(names, *rungs))
    assert [
        machine.get(n)
        for n in ("r", "p.x", "p.flags[1]", "grid[2,-1].flags[1]", "grid[2,1].x", "grid[1,1].x")
    ] == [3, 9, True, False, 7, 3]
    machine.scan()
    assert machine.get("grid[2,-1].flags[1]") is True


def test_an_index_is_read_when_its_instruction_runs() -> None:
    names = [var("a", Array(((0, 3),), INT), initial=(10, 11, 12, 13)), var("i", INT), var("r", INT)]
    machine = after(
        simple(names, "LD i; ADD 1; ST i; LD a[i]; ST r; LD 2; ST i; ST a[i]; LD a[i]; ADD r; ST r")
    )
    assert (machine.get("r"), machine.get("a[2]")) == (13, 2)


def test_function_blocks_keep_their_own_state() -> None:
    block = unit(
        "FUNCTION_BLOCK",
        "counter",
        [var("up", kind="input"), var("n", INT, kind="output", initial=5), var("k", INT, kind="temp")],
        "LD up; JMPCN out; LD n; ADD 1; ST k; ST n; LABEL out",
    )
    names = [
        var("x", Instance("COUNTER")),
        var("row", Array(((1, 2),), Instance("counter"))),
        var("i", INT, initial=2),
        var("go"),
        var("q", INT),
    ]
    main = unit(
        "PROGRAM",
        "main",
        names,
        "LD TRUE; ST x.up; CAL x",
        "LD go; ST row[i].up; CAL row[i]; LD row[2].n; ST q",
        "LD go; CALC x",
        units=[block],
    )
    machine = after(program(block, main), scans=3, go=1)
    assert [machine.get(n) for n in ("x.n", "row[1].n", "row[2].n", "q")] == [11, 5, 8, 8]


def test_functions_of_the_project() -> None:
    function = unit(
        "FUNCTION",
        "split",
        [
            var("n", INT, kind="input"),
            var("by", INT, kind="input"),
            var("rest", INT, kind="output"),
            var("k", INT),
        ],
        "LD k; ADD 1; ST k; LD by; EQ 0; RETC; LD n; MOD by; ST rest; LD n; DIV by; ST split",
        result=INT,
    )
    main = unit(
        "PROGRAM",
        "main",
        [var(n, INT) for n in ("q", "r", "s", "t")],
        "LD 17; FN split:INT 5 rest=>r; ST q; LD 17; FN split:INT 0 rest=>s; ST t",
        units=[function],
    )
    machine = after(program(function, main), scans=2, s=4, t=4)
    assert [machine.get(n) for n in "qrst"] == [3, 2, 0, 0]


def test_jumps_forward_skip_and_nest() -> None:
    rung = """LD a; JMPCN no
        LD b; JMPC inner
        LD TRUE; ST q
        LABEL inner
        LD TRUE; ST r
        LABEL no
        LD c; ST t"""
    machine = Machine(simple(BOOLS, rung))
    for bits in range(8):
        a, b, c = (bool(bits >> i & 1) for i in range(3))
        for name, value in {"a": a, "b": b, "c": c, "q": 0, "r": 0}.items():
            machine.set(name, value)
        machine.scan()
        assert [machine.get(n) for n in "qrt"] == [a and not b, a, c], bits


def test_two_arms() -> None:
    rung = "LD a; JMPCN else; LD 1; ST x; JMP end; LABEL else; LD 2; ST x; LABEL end; LD x; ADD 10; ST y"
    source = simple([var("a"), var("x", INT), var("y", INT)], rung)
    assert after(source, a=1).get("y") == 11 and after(source, a=0).get("y") == 12


def test_two_jumps_to_the_other_arm() -> None:
    rung = """LD a; JMPCN else; LD b; JMPCN else; LD 1; ST x; JMP end
        LABEL else; LD 2; ST x
        LABEL end; LD x; ST y"""
    source = simple([var("a"), var("b"), var("x", INT), var("y", INT)], rung)
    assert [after(source, a=a, b=b).get("y") for a in (0, 1) for b in (0, 1)] == [2, 2, 2, 1]


def test_loops_and_crossing_jumps() -> None:
    names = [var("n", INT), var("sum", INT), var("a"), var("q"), var("r")]
    rungs = [
        ("loop", "LD sum; ADD n; ST sum; LD n; SUB 1; ST n; GT 0; JMPC again", "again"),
        "LD a; JMPC far; LD sum; GT 5; JMPC near; LD TRUE; ST r",
        ("far", "LD TRUE; ST q", "far"),
        ("near", "LD n; ST n", "near"),
    ]
    machine = after(simple(names, *rungs), n=4)
    assert [machine.get(n) for n in ("n", "sum", "q", "r")] == [0, 10, False, False]
    machine = after(simple(names, *rungs), n=1, a=1)
    assert [machine.get(n) for n in ("n", "sum", "q", "r")] == [0, 1, True, False]
    machine = after(simple(names, *rungs), n=1)
    assert [machine.get(n) for n in ("n", "sum", "q", "r")] == [0, 1, True, True]


def test_many_rungs_that_jump() -> None:
    """A state machine of 300 labelled rungs, jumping back and forth, visits each equally often."""
    names = [var("n", INT), var("visits", Array(((0, 299),), INT)), var("turns", INT)]
    rungs = [("start", "LD turns; ADD 1; ST turns; LD 0; ST n", "start")]
    for i in range(300):
        rungs.append(
            (
                f"s{i}",
                f"LD n; NE {i}; JMPC s{(i * 7 + 7) % 300}; LD visits[{i}]; ADD 1; ST visits[{i}]; "
                f"LD n; ADD 1; ST n; LD n; EQ 300; JMPC done; JMP s{(i + 1) % 300}",
                f"s{i}",
            )
        )
    rungs.append(("done", "LD turns; LT 3; JMPC start", "done"))
    machine = after(simple(names, *rungs))
    assert not machine.faults and machine.get("turns") == 3
    assert {machine.get(f"visits[{i}]") for i in range(300)} == {3}


def test_a_jump_past_the_last_rung_and_return() -> None:
    rungs = [("one", "LD a; JMPC end; LD b; RETC; LD TRUE; ST q"), ("end", "", "end")]
    source = simple(BOOLS, *rungs)
    assert [after(source, a=a, b=b).get("q") for a in (0, 1) for b in (0, 1)] == [True, False, False, False]


def test_ten_thousand_operators_and_deep_parentheses() -> None:
    long = "LD a; " + "; ".join("AND b; OR c" for _ in range(5000)) + "; ST q"
    deep = "LD a; " + "AND( b; OR( c; " * 150 + "); ); " * 150 + "ST r"
    machine = after(simple(BOOLS, long, deep), a=1, b=1)
    assert machine.get("q") is True and machine.get("r") is True
    machine.set("b", 0)
    machine.scan()
    assert machine.get("q") is False and machine.get("r") is False


def test_long_sums_stay_exact() -> None:
    machine = after(
        simple(
            [var("a", LINT), var("q", LINT)], "LD a; " + "; ".join(["MUL 3:LINT; ADD a"] * 500) + "; ST q"
        ),
        a=12345,
    )
    expected = 12345
    for _ in range(500):
        expected = expected * 3 + 12345
    assert machine.get("q") == (expected + 2**63) % 2**64 - 2**63


def test_names_that_are_words_of_python() -> None:
    names = [
        var(n) for n in ("import", "None", "True", "self", "class", "__init__", "int", "_now", "pc", "lambda")
    ]
    code = "; ".join(f"LDN {v.name}; ST {v.name}" for v in names)
    machine = after(simple(names, code))
    assert all(machine.get(f"main.{v.name}") for v in names)


def test_two_instances_of_a_program_are_apart() -> None:
    from ldc.il.program import Run, Task

    main = unit(
        "PROGRAM",
        "main",
        [var("n", INT), var("shared", INT, kind="external")],
        "LD n; ADD 1; ST n; LD shared; ADD n; ST shared",
        globals_=[var("shared", INT, kind="global")],
    )
    source = program(
        main,
        globals_=[var("shared", INT, kind="global")],
        tasks=(Task("t"),),
        runs=(Run("one", "main", "t"), Run("two", "MAIN", "T")),
    )
    machine = after(source, scans=2, **{"one.n": 10})
    assert [machine.get(n) for n in ("ONE.n", "two.N", "shared")] == [12, 2, 11 + 1 + 12 + 2]
