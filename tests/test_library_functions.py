"""Standard functions: how calls are typed, and what they mean."""

from __future__ import annotations

import math
import struct
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ldc.library import functions
from ldc.library.faults import DivisionByZero
from ldc.types import (
    BOOL, BYTE, DATE, DINT, DT, DWORD, INT, LINT, LREAL, LWORD, REAL, SINT, STRING, TIME, TOD, UDINT, UINT,
    ULINT, USINT, WORD, WSTRING, Array, Elementary, Enum, String, Struct, Subrange,
)

INTEGERS = (SINT, INT, DINT, LINT, USINT, UINT, UDINT, ULINT)
COLOUR = Enum("COLOUR", (("red", 0), ("green", 1)))
PERCENT = Subrange("PERCENT", INT, 0, 100)
INF, NAN = math.inf, math.nan
DAY, S, MS = 86_400 * 10**9, 10**9, 10**6


def typed(name, *types):
    found = functions.resolve(name, types)
    assert not isinstance(found, str), found
    return found


def call(name, *arguments):
    """Calls with (type, value) pairs: resolved, converted, executed."""
    found = typed(name, *(t for t, _ in arguments))
    values = []
    for (source, value), wanted in zip(arguments, found.parameters, strict=True):
        step = functions.conversion(source, wanted)
        values.append(functions.meaning(step, (source,), wanted)(value))
    return functions.meaning(found.name, found.parameters, found.result)(*values)


def convert(source, target, value):
    name = functions.conversion(source, target)
    return functions.meaning(name, (source,), target)(value)


def same(a, b) -> bool:
    """Equal, NaN too, of the same Python type, zeros of the same sign."""
    return type(a) is type(b) and (repr(a) == repr(b))


# ---- typing -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "types", "parameters", "result"), [
    ("ADD", (INT, INT), (INT, INT), INT),
    ("add", (SINT, DINT, None), (DINT, DINT, DINT), DINT),
    ("ADD", (INT, UDINT), (LINT, LINT), LINT),
    ("ADD", (DINT, REAL), (LREAL, LREAL), LREAL),
    ("ADD", (UINT, REAL), (REAL, REAL), REAL),
    ("ADD", (None, None), (INT, INT), INT),
    ("ADD", (PERCENT, SINT), (INT, INT), INT),
    ("ADD", (TIME, TIME, TIME), (TIME, TIME, TIME), TIME),
    ("ADD", (TOD, TIME), (TOD, TIME), TOD),
    ("ADD", (DT, TIME), (DT, TIME), DT),
    ("SUB", (DT, DT), (DT, DT), TIME),
    ("SUB", (TOD, TIME), (TOD, TIME), TOD),
    ("SUB", (DATE, DATE), (DATE, DATE), TIME),
    ("MUL", (TIME, SINT), (TIME, SINT), TIME),
    ("DIV", (TIME, LREAL), (TIME, LREAL), TIME),
    ("MULTIME", (TIME, None), (TIME, INT), TIME),
    ("MUL_TIME", (TIME, REAL), (TIME, REAL), TIME),
    ("AND", (BOOL, None), (BOOL, BOOL), BOOL),
    ("AND", (BYTE, WORD), (WORD, WORD), WORD),
    ("NOT", (None,), (BOOL,), BOOL),
    ("SHL", (WORD, None), (WORD, INT), WORD),
    ("SHL", (WORD, USINT), (WORD, USINT), WORD),
    ("SEL", (BOOL, COLOUR, COLOUR), (BOOL, COLOUR, COLOUR), COLOUR),
    ("MUX", (SINT, INT, INT, DINT), (SINT, DINT, DINT, DINT), DINT),
    ("LIMIT", (None, PERCENT, None), (INT, INT, INT), INT),
    ("EQ", (COLOUR, COLOUR), (COLOUR, COLOUR), BOOL),
    ("GT", (INT, None, DINT), (DINT, DINT, DINT), BOOL),
    ("LT", (TIME, TIME), (TIME, TIME), BOOL),
    ("EXPT", (INT, INT), (REAL, INT), REAL),
    ("SQRT", (DINT,), (LREAL,), LREAL),
    ("SIN", (None,), (REAL,), REAL),
    ("TRUNC", (LREAL,), (LREAL,), DINT),
    ("LEN", (String("STRING", 7),), (String("STRING", 7),), INT),
    ("LEFT", (String("STRING", 7), None), (String("STRING", 7), INT), String("STRING", 7)),
    ("CONCAT", (String("STRING", 7), None, STRING), (String("STRING", 7), STRING, STRING),
     String("STRING", 167)),
    ("CONCAT", (WSTRING, None), (WSTRING, WSTRING), String("WSTRING", 160)),
    ("MAX", (String("STRING", 7), STRING), (String("STRING", 7), STRING), STRING),
    ("INT_TO_REAL", (SINT,), (INT,), REAL),
    ("DT_TO_TOD", (DT,), (DT,), TOD),
    ("DATE_AND_TIME_TO_TIME_OF_DAY", (DT,), (DT,), TOD),
    ("STRING_TO_WSTRING", (String("STRING", 7),), (String("STRING", 7),), String("WSTRING", 7)),
    ("TO_INT", (REAL,), (REAL,), INT),
    ("TO_DINT", (COLOUR,), (COLOUR,), DINT),
    ("TO_INT", (COLOUR,), (COLOUR,), INT),
    ("TO_INT", (PERCENT,), (INT,), INT),
    ("WORD_BCD_TO_UINT", (WORD,), (WORD,), UINT),
    ("UINT_TO_BCD_WORD", (None,), (UINT,), WORD),
    ("CONCAT_DATE_TOD", (DATE, TOD), (DATE, TOD), DT),
    ("MOVE", (Struct("POINT", ()),), (Struct("POINT", ()),), Struct("POINT", ())),
])
def test_types_of_a_call(name, types, parameters, result):
    found = typed(name, *types)
    assert (found.parameters, found.result) == (parameters, result)
    assert len(found.pins) == len(types)


@pytest.mark.parametrize(("name", "types", "error"), [
    ("ADD", (INT, BOOL), "ADD takes a number at IN2, not BOOL"),
    ("ADD", (INT, ULINT), "ADD: INT and ULINT have no common type; convert one of them"),
    ("ADD", (LINT, REAL), "ADD: LINT and REAL have no common type; convert one of them"),
    ("ADD", (INT,), "ADD takes at least 2 arguments (IN1, IN2), not 1"),
    ("SQRT", (), "SQRT takes 1 argument (IN), not 0"),
    ("NE", (INT, INT, INT), "NE takes 2 arguments (IN1, IN2), not 3"),
    ("ADD", (DATE, TIME),
     "ADD does not take (DATE, TIME); it takes (ANY_NUM, ANY_NUM), (TIME, TIME), (TOD, TIME), (DT, TIME)"),
    ("MUL", (INT, TIME), "MUL takes the TIME first and the number second, not (INT, TIME)"),
    ("AND", (INT, INT), "AND takes a BOOL or a bit string at IN1, not INT"),
    ("AND", (BOOL, BYTE), "AND: BOOL and BYTE have no common type; convert one of them"),
    ("SEL", (INT, INT, INT), "SEL takes a BOOL at G, not INT"),
    ("INT_TO_REAL", (DINT,), "INT_TO_REAL takes an INT at IN, not DINT"),
    ("EQ", (STRING, WSTRING), "EQ: STRING[80] and WSTRING[80] have no common type; convert one of them"),
    ("GT", (COLOUR, COLOUR), "GT takes a value of an elementary type at IN1, not COLOUR"),
    ("TO_DT", (REAL,), "TO_DT does not take REAL"),
    ("TO_BOOL", (COLOUR,), "TO_BOOL does not take COLOUR"),
    ("ENUM_TO_INT", (INT,), "ENUM_TO_INT takes an enumeration at IN, not INT"),
    ("TO_INT", (Array(((0, 1),), INT),), "TO_INT does not take ARRAY [0..1] OF INT"),
    ("FROB", (INT,), "there is no standard function FROB"),
])
def test_a_call_that_does_not_fit_says_why(name, types, error):
    assert functions.resolve(name, types) == error


def test_formal_names():
    assert functions.lookup("add").pins(4) == ("IN1", "IN2", "IN3", "IN4")
    assert functions.lookup("MUX").pins(4) == ("K", "IN0", "IN1", "IN2")
    assert functions.lookup("SEL").pins(3) == ("G", "IN0", "IN1")
    mux = functions.lookup("MUX")
    assert [mux.position(n) for n in ("k", "IN0", "in1", "IN7", "IN", "IN01", "X")] == [
        0, 1, 2, 8, None, None, None]
    assert functions.lookup("SUB").position("IN3") is None
    assert functions.pins("TO_INT", 1) == ("IN",)
    assert functions.pins("nothing", 1) is None


@given(st.sampled_from([n for n, f in functions.TABLE.items() if f.extensible]), st.integers(2, 40))
def test_a_formal_name_is_found_where_it_stands(name, count):
    row = functions.TABLE[name]
    if count >= row.least:
        assert [row.position(p) for p in row.pins(count)] == list(range(count))


def test_every_name_is_found_and_internal_ones_are_not_called():
    for name in functions.names():
        assert functions.is_function(name.lower())
    assert not functions.is_function("NEG")
    assert not functions.is_function("TON")
    assert functions.lookup("NEG").internal


ELEMENTARY = (BOOL, *INTEGERS, REAL, LREAL, BYTE, WORD, DWORD, LWORD, TIME, DATE, TOD, DT)


def test_what_widens_loses_no_value():
    """Every value of a smaller type is exactly a value of a wider one."""
    wide = {(a.name, b.name) for a in ELEMENTARY for b in ELEMENTARY if a != b and functions.widens(a, b)}
    digits = {"REAL": 24, "LREAL": 53}
    for a in ELEMENTARY:
        for b in ELEMENTARY:
            if a == b or a.kind not in ("int", "uint", "bits", "real") or a.kind in ("bool", "time"):
                continue
            if b.kind == "real":
                fits = (a.kind in ("int", "uint") and a.bits <= digits[b.name]) or (a, b) == (REAL, LREAL)
            elif a.kind == "real" or (a.kind == "bits") != (b.kind == "bits") or b.kind in (
                    "bool", "time", "date", "tod", "dt"):
                fits = False
            else:
                fits = b.range[0] <= a.range[0] and a.range[1] <= b.range[1] and a.bits != b.bits
            assert ((a.name, b.name) in wide) == fits, (a, b)
    assert not any("BOOL" in pair or "TIME" in pair or "DATE" in pair for pair in wide)


def test_strings_subranges_and_enumerations_widen():
    assert functions.widens(STRING, String("STRING", 3))
    assert not functions.widens(STRING, WSTRING)
    assert functions.widens(PERCENT, DINT)
    assert functions.widens(SINT, PERCENT)
    assert not functions.widens(DINT, PERCENT)
    assert functions.widens(COLOUR, COLOUR)
    assert not functions.widens(COLOUR, DINT)
    assert not functions.widens(DINT, COLOUR)


@given(st.lists(st.sampled_from(ELEMENTARY), min_size=1, max_size=4))
def test_the_common_type_takes_all_and_is_the_smallest(types):
    found = functions.common(types)
    able = [t for t in ELEMENTARY if all(functions.widens(s, t) for s in types)]
    assert (found is None) == (not able)
    if found is not None:
        assert found in able
        assert all(functions.widens(found, t) or t.bits >= found.bits for t in able)


def test_every_conversion_that_widening_needs_exists():
    for a in ELEMENTARY:
        for b in ELEMENTARY:
            if functions.widens(a, b):
                assert functions.lookup(functions.conversion(a, b)) is not None
    assert functions.conversion(INT, DINT) == "INT_TO_DINT"
    assert functions.conversion(PERCENT, INT) == "MOVE"
    assert functions.conversion(COLOUR, DINT) == "ENUM_TO_DINT"
    assert functions.conversion(COLOUR, COLOUR) == "MOVE"


# ---- integers ---------------------------------------------------------------------------------


def wrapped(value: int, type_: Elementary) -> int:
    size = type_.bits // 8
    signed = type_.kind in ("int", "time")
    return int.from_bytes((value % (1 << type_.bits)).to_bytes(size, "little"), "little", signed=signed)


@st.composite
def integers(draw, count=2):
    type_ = draw(st.sampled_from(INTEGERS))
    low, high = type_.range
    near = st.sampled_from([low, low + 1, -1 if low else 1, 0, 1, high - 1, high])
    return type_, [draw(st.integers(low, high) | near) for _ in range(count)]


@given(integers(3))
def test_integer_arithmetic_wraps(case):
    type_, (a, b, c) = case
    args = [(type_, v) for v in (a, b, c)]
    assert call("ADD", *args) == wrapped(a + b + c, type_)
    assert call("MUL", *args) == wrapped(a * b * c, type_)
    assert call("SUB", *args[:2]) == wrapped(a - b, type_)
    assert call("NEG", args[0]) == wrapped(-a, type_)
    assert call("ABS", args[0]) == wrapped(abs(a), type_)
    assert call("MOVE", args[0]) == a


@given(integers())
def test_integer_division_cuts_toward_zero(case):
    type_, (a, b) = case
    if b == 0:
        for name in ("DIV", "MOD"):
            with pytest.raises(DivisionByZero):
                call(name, (type_, a), (type_, b))
        return
    exact = math.trunc(Fraction(a, b))
    assert call("DIV", (type_, a), (type_, b)) == wrapped(exact, type_)
    assert call("MOD", (type_, a), (type_, b)) == a - exact * b


def test_division_of_signs():
    signs = [(7, 2), (-7, 2), (7, -2), (-7, -2)]
    assert [call("DIV", (INT, a), (INT, b)) for a, b in signs] == [3, -3, -3, 3]
    assert [call("MOD", (INT, a), (INT, b)) for a, b in signs] == [1, -1, 1, -1]
    assert call("DIV", (INT, -32768), (INT, -1)) == -32768


# ---- reals ------------------------------------------------------------------------------------


def single(value: float) -> float:
    try:
        return struct.unpack("f", struct.pack("f", value))[0]
    except OverflowError:
        return math.copysign(INF, value)


REALS = st.floats(width=32)
FINITE = st.floats(width=32, allow_nan=False, allow_infinity=False)


def nearest_single(exact: Fraction) -> float:
    """The 32-bit float nearest to an exact number, ties to even, from integers alone."""
    if exact == 0:
        return 0.0
    sign, exact = (-1 if exact < 0 else 1), abs(exact)
    exponent = exact.numerator.bit_length() - exact.denominator.bit_length()
    if Fraction(2) ** exponent > exact:
        exponent -= 1
    unit = Fraction(2) ** max(exponent - 23, -149)
    value = round(exact / unit) * unit
    return sign * (INF if value >= Fraction(2) ** 128 else float(value))


@given(FINITE, FINITE)
def test_real_arithmetic_is_rounded_once_to_32_bits(a, b):
    exact_a, exact_b = Fraction(a), Fraction(b)
    for name, exact in (("ADD", exact_a + exact_b), ("SUB", exact_a - exact_b), ("MUL", exact_a * exact_b)):
        assert call(name, (REAL, a), (REAL, b)) == nearest_single(exact)
    if b:
        assert call("DIV", (REAL, a), (REAL, b)) == nearest_single(exact_a / exact_b)
    else:
        with pytest.raises(DivisionByZero):
            call("DIV", (REAL, a), (REAL, b))


def test_extensible_real_sums_are_rounded_at_each_step():
    assert call("ADD", (REAL, 2.0**24), (REAL, 1.0), (REAL, 1.0)) == 2.0**24
    assert call("ADD", (LREAL, 2.0**24), (LREAL, 1.0), (LREAL, 1.0)) == 2.0**24 + 2


@pytest.mark.parametrize(("name", "value", "expected"), [
    ("SQRT", 2.0, math.sqrt(2)), ("SQRT", -1.0, NAN), ("SQRT", -0.0, -0.0), ("SQRT", INF, INF),
    ("LN", math.e, 1.0), ("LN", 0.0, -INF), ("LN", -0.0, -INF), ("LN", -1.0, NAN), ("LN", INF, INF),
    ("LOG", 1000.0, 3.0), ("LOG", 0.0, -INF), ("LOG", -1.0, NAN), ("LN", NAN, NAN),
    ("EXP", 0.0, 1.0), ("EXP", 1e9, INF), ("EXP", -1e9, 0.0), ("EXP", -INF, 0.0),
    ("SIN", 0.0, 0.0), ("SIN", INF, NAN), ("COS", 0.0, 1.0), ("COS", -INF, NAN), ("TAN", INF, NAN),
    ("TAN", 0.0, 0.0), ("ASIN", 1.0, math.pi / 2), ("ASIN", 1.5, NAN), ("ACOS", 1.0, 0.0),
    ("ACOS", -2.0, NAN),
    ("ATAN", INF, math.pi / 2), ("ATAN", -1.0, -math.pi / 4), ("ABS", -1.5, 1.5), ("ABS", -INF, INF),
])
def test_functions_of_one_real(name, value, expected):
    assert same(call(name, (LREAL, value)), expected)
    double = call(name, (LREAL, single(value)))
    assert same(call(name, (REAL, single(value))), single(double))


@pytest.mark.parametrize(("base", "exponent", "expected"), [
    (2.0, (INT, 10), 1024.0), (2.0, (INT, -1), 0.5), (2.0, (LREAL, 0.5), math.sqrt(2)),
    (-8.0, (INT, 3), -512.0), (-8.0, (LREAL, 0.5), NAN), (0.0, (INT, 0), 1.0), (NAN, (INT, 0), 1.0),
    (0.0, (INT, -1), INF), (-0.0, (INT, -1), -INF), (-0.0, (INT, -2), INF), (-0.0, (LREAL, -0.5), INF),
    (10.0, (INT, 400), INF), (-10.0, (INT, 401), -INF), (-10.0, (INT, 400), INF), (0.0, (LREAL, -INF), INF),
])
def test_powers(base, exponent, expected):
    assert same(call("EXPT", (LREAL, base), exponent), expected)


def test_truncation():
    assert [call("TRUNC", (REAL, v)) for v in (1.75, -1.75, 3e9, -INF, NAN)] == [
        1, -1, 2**31 - 1, -(2**31), 0]
    assert call("REAL_TRUNC_USINT", (REAL, -0.5)) == 0
    assert call("LREAL_TRUNC_INT", (LREAL, 32767.9)) == 32767


# ---- bits, selection, comparison --------------------------------------------------------------


@given(st.sampled_from([BYTE, WORD, DWORD, LWORD]), st.data())
def test_shifts_and_rotations_move_the_bits(type_, data):
    width = type_.bits
    value, count = data.draw(st.integers(0, 2**width - 1)), data.draw(st.integers(-3, 3 * width))
    text, n = f"{value:0{width}b}", max(count, 0)
    turn = n % width
    expected = {"SHL": (text + "0" * n)[-width:], "SHR": ("0" * n + text)[:width],
                "ROL": text[turn:] + text[:turn], "ROR": text[width - turn:] + text[: width - turn]}
    for name, bits in expected.items():
        assert call(name, (type_, value), (INT, count)) == int(bits, 2)


def test_shifts_of_one_bit():
    assert same(call("SHL", (BOOL, True), (INT, 1)), False)
    assert same(call("SHR", (BOOL, True), (INT, 0)), True)
    assert same(call("ROL", (BOOL, True), (INT, 5)), True)


@given(st.sampled_from([BOOL, BYTE, WORD, DWORD, LWORD]), st.data())
def test_bitwise_functions(type_, data):
    width = type_.bits
    numbers = [data.draw(st.integers(0, 2**width - 1)) for _ in range(3)]
    args = [(type_, bool(n) if type_ == BOOL else n) for n in numbers]
    columns = list(zip(*(f"{n:0{width}b}" for n in numbers), strict=True))

    def number(rule):
        value = int("".join("1" if rule(c.count("1")) else "0" for c in columns), 2)
        return bool(value) if type_ == BOOL else value

    assert same(call("AND", *args), number(lambda ones: ones == 3))
    assert same(call("OR", *args), number(lambda ones: ones > 0))
    assert same(call("XOR", *args), number(lambda ones: ones % 2 == 1))
    flipped = call("NOT", args[0])
    assert flipped == (not numbers[0] if type_ == BOOL else 2**width - 1 - numbers[0])
    assert same(call("NOT", (type_, flipped)), args[0][1])


def test_selection():
    assert call("SEL", (BOOL, False), (INT, 1), (INT, 2)) == 1
    assert call("SEL", (BOOL, True), (STRING, b"a"), (STRING, b"b")) == b"b"
    assert call("MAX", (INT, 1), (DINT, 70000), (SINT, -3)) == 70000
    assert call("MIN", (TIME, 5), (TIME, -5)) == -5
    assert call("MAX", (STRING, b"abc"), (STRING, b"abd")) == b"abd"
    assert same(call("MAX", (BOOL, False), (BOOL, True)), True)
    assert [call("LIMIT", (INT, 0), (INT, v), (INT, 10)) for v in (-1, 5, 11)] == [0, 5, 10]
    assert call("LIMIT", (INT, 10), (INT, 5), (INT, 0)) == 0
    assert [call("MUX", (INT, k), (INT, 7), (INT, 8), (INT, 9)) for k in (-1, 0, 1, 2, 3)] == [7, 7, 8, 9, 9]


def test_a_nan_is_not_greater_or_less():
    assert same(call("MAX", (REAL, NAN), (REAL, 1.0)), NAN)
    assert same(call("MAX", (REAL, 1.0), (REAL, NAN)), 1.0)
    assert same(call("LIMIT", (REAL, 0.0), (REAL, NAN), (REAL, 1.0)), NAN)
    assert not call("EQ", (REAL, NAN), (REAL, NAN))
    assert call("NE", (REAL, NAN), (REAL, NAN))


@given(st.lists(st.integers(-2, 2), min_size=2, max_size=4))
def test_comparison_chains(values):
    args, down = [(INT, v) for v in values], sorted(values, reverse=True)
    assert call("GE", *args) == (values == down)
    assert call("GT", *args) == (values == down and len(set(values)) == len(values))
    assert call("LE", *args) == (values == sorted(values))
    assert call("LT", *args) == (values == sorted(values) and len(set(values)) == len(values))
    assert call("EQ", *args) == (len(set(values)) == 1)


def test_comparisons_of_other_types():
    assert call("LT", (STRING, b"Z"), (STRING, b"a"))
    assert call("GT", (STRING, b"ab"), (STRING, b"a"))
    assert call("GT", (STRING, b"\xe4"), (STRING, b"z"))
    assert call("GT", (WORD, 0x8000), (BYTE, 1))
    assert call("GT", (BOOL, True), (BOOL, False))
    assert call("LT", (UINT, 65535), (DINT, 65536))
    assert call("LT", (INT, -1), (UINT, 0))
    assert call("EQ", (COLOUR, 1), (COLOUR, 1))
    assert call("TO_INT", (COLOUR, 1)) == 1


# ---- strings ----------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "arguments", "expected"), [
    ("LEN", (b"abc",), 3), ("LEN", (b"",), 0),
    ("LEFT", (b"ASTR", 3), b"AST"), ("LEFT", (b"ab", 9), b"ab"), ("LEFT", (b"ab", 0), b""),
    ("LEFT", (b"ab", -1), b""),
    ("RIGHT", (b"ASTR", 3), b"STR"), ("RIGHT", (b"ab", 9), b"ab"), ("RIGHT", (b"ab", 0), b""),
    ("RIGHT", (b"ab", -1), b""),
    ("MID", (b"ASTR", 2, 2), b"ST"), ("MID", (b"ASTR", 9, 3), b"TR"), ("MID", (b"ASTR", 1, 5), b""),
    ("MID", (b"ASTR", 2, 0), b""), ("MID", (b"ASTR", -1, 2), b""),
    ("CONCAT", (b"AB", b"CD", b"E"), b"ABCDE"),
    ("INSERT", (b"ABC", b"XY", 2), b"ABXYC"), ("INSERT", (b"ABC", b"X", 0), b"XABC"),
    ("INSERT", (b"ABC", b"X", -5), b"XABC"), ("INSERT", (b"ABC", b"X", 3), b"ABCX"),
    ("INSERT", (b"ABC", b"X", 9), b"ABCX"),
    ("DELETE", (b"ABXYC", 2, 3), b"ABC"), ("DELETE", (b"ABC", 9, 2), b"A"),
    ("DELETE", (b"ABC", 1, 4), b"ABC"),
    ("DELETE", (b"ABC", 1, 0), b"ABC"), ("DELETE", (b"ABC", -1, 1), b"ABC"),
    ("REPLACE", (b"ABCDE", b"X", 2, 3), b"ABXE"), ("REPLACE", (b"ABC", b"XY", 0, 2), b"AXYBC"),
    ("REPLACE", (b"ABC", b"X", 9, 3), b"ABX"), ("REPLACE", (b"ABC", b"X", 1, 4), b"ABC"),
    ("REPLACE", (b"ABC", b"X", 1, 0), b"ABC"), ("REPLACE", (b"ABC", b"X", -1, 1), b"XABC"),
    ("FIND", (b"ABCBC", b"BC"), 2), ("FIND", (b"ABC", b"X"), 0), ("FIND", (b"ABC", b""), 0),
])
def test_string_functions(name, arguments, expected):
    narrow = [(STRING, a) if isinstance(a, bytes) else (INT, a) for a in arguments]
    wide = [(WSTRING, a.decode()) if isinstance(a, bytes) else (INT, a) for a in arguments]
    assert call(name, *narrow) == expected
    assert call(name, *wide) == (expected.decode() if isinstance(expected, bytes) else expected)


def test_strings_are_cut_to_the_type_of_the_result():
    concat = functions.meaning("CONCAT", (STRING, STRING), String("STRING", 5))
    assert concat(b"abc", b"def") == b"abcde"
    longest = typed("CONCAT", *[String("STRING", 30000)] * 3).result
    assert longest.length == 32767


# ---- times ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "arguments", "expected"), [
    ("ADD_TIME", ((TIME, 5), (TIME, -7)), -2),
    ("ADD_TIME", ((TIME, 2**63 - 1), (TIME, 1)), -(2**63)),
    ("ADD_TOD_TIME", ((TOD, 23 * 3600 * S), (TIME, 2 * 3600 * S)), 3600 * S),
    ("SUB_TOD_TIME", ((TOD, 3600 * S), (TIME, 2 * 3600 * S)), 23 * 3600 * S),
    ("SUB_TOD_TOD", ((TOD, 0), (TOD, S)), -S),
    ("ADD_DT_TIME", ((DT, DAY), (TIME, -DAY)), 0),
    ("SUB_DT_TIME", ((DT, DAY), (TIME, S)), DAY - S),
    ("SUB_DT_DT", ((DT, 0), (DT, DAY)), -DAY),
    ("SUB_TIME", ((TIME, 5), (TIME, 7)), -2),
    ("SUB_DATE_DATE", ((DATE, 2), (DATE, 5)), -3 * DAY),
    ("MULTIME", ((TIME, 3 * S), (INT, -2)), -6 * S),
    ("MULTIME", ((TIME, 3), (REAL, 0.5)), 2),
    ("MULTIME", ((TIME, 5), (LREAL, 0.5)), 2),
    ("MULTIME", ((TIME, 2**62), (INT, 2)), -(2**63)),
    ("MULTIME", ((TIME, 2**62), (LREAL, 2.0)), 2**63 - 1),
    ("MULTIME", ((TIME, 1), (REAL, NAN)), 0),
    ("DIVTIME", ((TIME, -7), (INT, 2)), -3),
    ("DIVTIME", ((TIME, 7), (UINT, 2)), 3),
    ("DIVTIME", ((TIME, 5), (LREAL, 2.0)), 2),
    ("DIVTIME", ((TIME, -1), (REAL, 1e-30)), -(2**63)),
    ("CONCAT_DATE_TOD", ((DATE, 3), (TOD, 5)), 3 * DAY + 5),
    ("DT_TO_DATE", ((DT, 3 * DAY + 5),), 3), ("DT_TO_TOD", ((DT, 3 * DAY + 5),), 5),
    ("DATE_TO_DT", ((DATE, 3),), 3 * DAY), ("TIME_TO_TOD", ((TIME, -S),), DAY - S),
    ("TOD_TO_TIME", ((TOD, S),), S),
])
def test_time_functions(name, arguments, expected):
    assert call(name, *arguments) == expected


@pytest.mark.parametrize("zero", [(INT, 0), (REAL, 0.0), (LREAL, -0.0)])
def test_a_time_is_not_divided_by_zero(zero):
    for name in ("DIV", "DIVTIME"):
        with pytest.raises(DivisionByZero):
            call(name, (TIME, 5), zero)


@pytest.mark.parametrize(("operator", "function", "types"), [
    ("ADD", "ADD_TIME", (TIME, TIME)), ("ADD", "ADD_TOD_TIME", (TOD, TIME)),
    ("ADD", "ADD_DT_TIME", (DT, TIME)),
    ("SUB", "SUB_TIME", (TIME, TIME)), ("SUB", "SUB_DATE_DATE", (DATE, DATE)),
    ("SUB", "SUB_TOD_TIME", (TOD, TIME)), ("SUB", "SUB_TOD_TOD", (TOD, TOD)),
    ("SUB", "SUB_DT_TIME", (DT, TIME)),
    ("SUB", "SUB_DT_DT", (DT, DT)), ("MUL", "MULTIME", (TIME, INT)), ("DIV", "DIVTIME", (TIME, REAL)),
])
def test_operators_are_the_named_time_functions(operator, function, types):
    values = [2.5 if t == REAL else 3 * DAY // 1000 for t in types]
    pairs = list(zip(types, values, strict=True))
    assert call(operator, *pairs) == call(function, *pairs)
    assert typed(operator, *types).result == typed(function, *types).result


def test_widened_arguments_are_exact():
    assert call("ADD", (DINT, 2**31 - 1), (REAL, 0.5)) == 2**31 - 0.5
    assert convert(UINT, REAL, 65535) == 65535.0
