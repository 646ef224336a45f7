"""Input files and traces, as people write and read them."""

from __future__ import annotations

import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from il_build import program, simple, unit, var

from ldc.diagnostics import Diagnostics
from ldc.source import SourceFile
from ldc.types import ELEMENTARY, INT, LREAL, REAL, TIME, WORD, Array, Enum, Instance, String
from runtime import stimuli, trace
from runtime.values import coerce, milliseconds, parse, show
from runtime.vm.machine import Machine

COLOUR = Enum("colour", (("red", 0), ("green", 1)))
NAMES = [
    var("start", at="%IX0.0"),
    var("level", REAL),
    var("wait", TIME),
    var("n", INT),
    var("m", Array(((0, 1), (0, 1)), INT)),
    var("colour", COLOUR),
    var("text", String("STRING", 9)),
    var("w", WORD),
]


def machine() -> Machine:
    return Machine(simple(NAMES, "LD n; ADD 1; ST n"), period_ns=2_500_000)


def read(text: str, on: Machine) -> tuple[stimuli.Stimuli | None, list[tuple[str, str]]]:
    diagnostics = Diagnostics()
    found = stimuli.read(SourceFile("in.csv", text), on.symbols, diagnostics)
    return found, [(d.code, d.primary.span.text, d.primary.span.position) for d in diagnostics]


def test_rows_set_before_their_scan_and_empty_cells_keep() -> None:
    m = machine()
    text = (
        '\ufeffscan,start, main.level ,wait,"m[0,1]",colour,text,w\r\n'
        '0,1,0.5,T#20ms,7,green,"a, ""b""",16#FF\r\n\r\n'
        "2,,,1.5,,,,\r\n3,FALSE\n"
    )
    found, wrong = read(text, m)
    assert not wrong and found.last == 3
    out = trace.record(m, ["start", "level", "WAIT", "m[0,1]", "n", "colour", "text", "w"], 4, found)
    assert out == (
        'scan,t_ms,start,level,WAIT,"m[0,1]",n,colour,text,w\n'
        '0,0,1,0.5,20,7,1,green,"a, ""b""",255\n'
        '1,2.5,1,0.5,20,7,2,green,"a, ""b""",255\n'
        '2,5,1,0.5,1.5,7,3,green,"a, ""b""",255\n'
        '3,7.5,0,0.5,1.5,7,4,green,"a, ""b""",255\n'
    )


@pytest.mark.parametrize(
    "text, code, at, position",
    [
        ("", "LD0650", "", (1, 1)),
        ("time,start\n0,1\n", "LD0650", "time", (1, 1)),
        ("scan;start\n0;1\n", "LD0650", "scan;start", (1, 1)),
        ("scan,strat\n0,1\n", "LD0651", "strat", (1, 6)),
        ("scan,start,\n0,1,1\n", "LD0651", "", (1, 12)),
        ("scan,start\n0,2\n", "LD0652", "2", (2, 3)),
        ("scan,n\n0,1\n1, 40000\n", "LD0652", "40000", (3, 4)),
        ("scan,start\n-1,1\n", "LD0653", "-1", (2, 1)),
        ("scan,start\n1,1\n0,1\n", "LD0653", "0", (3, 1)),
        ("scan,start\n1,1\n1,0\n", "LD0653", "1", (3, 1)),
        ("scan,start\n,1\n", "LD0653", "", (2, 1)),
        ("scan,start\n0,1,\n", "LD0654", "", (2, 5)),
        ("scan,start,n,START\n0,1,1,1\n", "LD0655", "START", (1, 14)),
    ],
)
def test_what_is_wrong_is_said_with_its_place(
    text: str, code: str, at: str, position: tuple[int, int]
) -> None:
    found, wrong = read(text, machine())
    assert found is None and wrong == [(code, at, position)]


def test_every_wrong_cell_is_reported() -> None:
    _, wrong = read("scan,start,x,n\n0,9,1,z\nq,1,1,1\n1,1,1,1,1\n", machine())
    assert [code for code, _, _ in wrong] == ["LD0651", "LD0652", "LD0652", "LD0653", "LD0654"]


@given(st.text(alphabet='scan,01\n\r"; é', max_size=80))
def test_no_text_is_a_traceback(text: str) -> None:
    diagnostics = Diagnostics()
    found = stimuli.read(SourceFile("in.csv", text), SYMBOLS, diagnostics)
    assert (found is None) == diagnostics.has_errors
    assert all(d.primary.span.end <= len(text) + 1 for d in diagnostics)


SYMBOLS = machine().symbols


def test_a_trace_shows_what_blocks_and_programs_hold() -> None:
    block = unit("FUNCTION_BLOCK", "b", [var("q", kind="output")], "LDN q; ST q")
    main = unit("PROGRAM", "main", [var("one", Instance("b"))], "CAL one", units=[block])
    m = Machine(program(block, main))
    out = io.StringIO()
    shown = trace.Trace(m, ["main.one.q", "ONE.Q"], out)
    for _ in range(2):
        m.scan()
        shown.sample()
    assert out.getvalue() == "scan,t_ms,main.one.q,ONE.Q\n0,0,1,1\n1,10,0,0\n"


@pytest.mark.parametrize(
    "text, type_, value",
    [
        ("0", "BOOL", False),
        ("TRUE", "BOOL", True),
        ("false", "BOOL", False),
        ("BOOL#1", "BOOL", True),
        ("-3", "INT", -3),
        ("INT#5", "INT", 5),
        ("16#FF", "WORD", 255),
        ("2#1010", "BYTE", 10),
        ("WORD#16#a", "WORD", 10),
        ("1_000", "DINT", 1000),
        ("1.5", "REAL", 1.5),
        ("0.1", "REAL", 0.10000000149011612),
        ("2", "LREAL", 2.0),
        ("-1e3", "LREAL", -1000.0),
        ("T#20ms", "TIME", 20_000_000),
        ("t#1s500ms", "TIME", 1_500_000_000),
        ("TIME#1m", "TIME", 60_000_000_000),
        ("20", "TIME", 20_000_000),
        ("0.5", "TIME", 500_000),
        ("-1", "TIME", -1_000_000),
        ("D#1970-01-02", "DATE", 1),
        ("TOD#00:00:01", "TIME_OF_DAY", 10**9),
        ("DT#1970-01-01-00:00:01", "DATE_AND_TIME", 10**9),
        ("'a$'b$24$N'", "STRING", b"a'b$\n"),
        ("plain text", "STRING", b"plain text"),
        ('"x$0041"', "WSTRING", "xA"),
    ],
)
def test_values_are_read(text: str, type_: str, value) -> None:
    assert parse(text, ELEMENTARY[type_]) == value


@pytest.mark.parametrize(
    "text, type_",
    [
        ("2", "BOOL"),
        ("yes", "BOOL"),
        ("256", "BYTE"),
        ("-1", "UINT"),
        ("1.5", "INT"),
        ("", "INT"),
        ("0x10", "INT"),
        ("REAL#1", "INT"),
        ("T#", "TIME"),
        ("1e30", "TIME"),
        ("1,5", "REAL"),
        ("1e39", "REAL"),
        ("1e999", "LREAL"),
        ("D#2025-02-30", "DATE"),
        ("'$q'", "STRING"),
        ("€", "STRING"),
        ("INT#INT#1", "INT"),
    ],
)
def test_what_is_no_value_is_refused(text: str, type_: str) -> None:
    with pytest.raises(ValueError, match="."):
        parse(text, ELEMENTARY[type_])


@given(st.sampled_from(["SINT", "UINT", "LINT", "ULINT", "WORD", "TIME", "LREAL", "REAL", "BOOL"]), st.data())
def test_what_a_trace_shows_reads_back(name: str, data) -> None:
    type_ = ELEMENTARY[name]
    if type_.kind == "real":
        value = data.draw(st.floats(allow_nan=False, width=type_.bits))
    elif type_.kind == "time":
        value = data.draw(st.integers(-(2**52), 2**52))
    else:
        value = data.draw(st.integers(*type_.range))
    value = coerce(value, type_)
    assert parse(show(value, type_), type_) == value


def test_milliseconds_are_exact() -> None:
    assert [milliseconds(n) for n in (0, 1, -1_250_000, 10**18 + 1, 20_000_000)] == [
        "0",
        "0.000001",
        "-1.25",
        "1000000000000.000001",
        "20",
    ]


def test_real_values_fit_after_rounding() -> None:
    m = Machine(simple([var("r", REAL), var("l", LREAL)], ""))
    m.set("r", 0.1), m.set("l", 0.1)
    assert m.get("r") == 0.10000000149011612 and m.get("l") == 0.1
