"""Type conversions: every one that exists, what it gives, and texts that engines must agree on."""

from __future__ import annotations

import datetime
import math
import re
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ldc.library import functions
from ldc.types import (
    BOOL, BYTE, DATE, DINT, DT, DWORD, INT, LINT, LREAL, LWORD, REAL, SINT, STRING, TIME, TOD, UDINT, UINT,
    ULINT, USINT, WORD, WSTRING, String,
)

INTEGERS = (SINT, INT, DINT, LINT, USINT, UINT, UDINT, ULINT)
BITS = (BYTE, WORD, DWORD, LWORD)
INF, NAN = math.inf, math.nan
DAY, S, MS = 86_400 * 10**9, 10**9, 10**6


def convert(source, target, value):
    found = functions.resolve(functions.conversion(source, target), (source,))
    assert not isinstance(found, str), found
    return functions.meaning(found.name, found.parameters, found.result)(value)


def same(a, b) -> bool:
    return type(a) is type(b) and repr(a) == repr(b)


def wrapped(value: int, type_) -> int:
    raw = (value % (1 << type_.bits)).to_bytes(type_.bits // 8, "little")
    return int.from_bytes(raw, "little", signed=type_.kind in ("int", "time"))


@given(st.sampled_from(INTEGERS + BITS), st.sampled_from(INTEGERS + BITS), st.data())
def test_integers_and_bit_strings_keep_their_low_bits(source, target, data):
    low, high = source.range
    value = data.draw(st.integers(low, high) | st.sampled_from([low, high]))
    assert convert(source, target, value) == wrapped(value, target)


def test_signs_are_extended_into_bit_strings():
    assert convert(INT, DWORD, -1) == 0xFFFFFFFF
    assert convert(WORD, DINT, 0xFFFF) == 65535
    assert convert(WORD, INT, 0xFFFF) == -1


@pytest.mark.parametrize(("value", "expected"), [
    (0.5, 0), (1.5, 2), (2.5, 2), (-0.5, 0), (-1.5, -2), (1e9, 32767), (-1e9, -32768), (INF, 32767),
    (-INF, -32768), (NAN, 0), (32767.4, 32767), (-32768.4, -32768), (32766.5, 32766),
])
def test_reals_round_half_to_even_and_stop_at_the_ends(value, expected):
    assert same(convert(REAL, INT, value), expected)
    assert same(convert(LREAL, INT, value), expected)


@given(st.sampled_from([REAL, LREAL]), st.sampled_from(INTEGERS), st.floats(width=32))
def test_reals_to_integers(source, target, value):
    low, high = target.range
    if value != value:
        expected = 0
    elif math.isinf(value):
        expected = high if value > 0 else low
    else:
        floor = math.floor(value)
        rest = value - floor
        nearest = floor + (rest > 0.5 or (rest == 0.5 and floor % 2 == 1))
        expected = min(max(nearest, low), high)
    assert convert(source, target, value) == expected


def test_integers_to_reals_are_rounded():
    assert convert(DINT, REAL, 16777217) == 16777216.0
    assert convert(DINT, LREAL, 16777217) == 16777217.0
    assert convert(ULINT, LREAL, 2**64 - 1) == 2.0**64
    assert convert(LREAL, REAL, 0.1) == struct.unpack("f", struct.pack("f", 0.1))[0]
    assert convert(LREAL, REAL, 1e39) == INF
    assert convert(REAL, LREAL, 0.5) == 0.5


def test_booleans():
    assert same(convert(BOOL, INT, True), 1)
    assert same(convert(BOOL, REAL, True), 1.0)
    assert same(convert(BOOL, LWORD, False), 0)
    assert [convert(t, BOOL, v) for t, v in (
        (INT, -1), (INT, 0), (REAL, 0.1), (REAL, -0.0), (REAL, NAN), (WORD, 2))] == [
        True, False, True, False, True, True]


def test_a_real_and_the_bit_string_of_its_width_are_one_pattern():
    assert convert(REAL, DWORD, 1.0) == 0x3F800000
    assert convert(DWORD, REAL, 0xC0000000) == -2.0
    assert convert(LREAL, LWORD, -0.0) == 1 << 63
    assert convert(LWORD, LREAL, 0x3FF8 << 48) == 1.5


def test_other_bit_strings_count_as_unsigned_numbers():
    assert [convert(s, t, v) for s, t, v in (
        (BYTE, REAL, 255), (WORD, LREAL, 65_535), (DWORD, LREAL, 2**32 - 1), (LWORD, REAL, 2**63))] == [
        255.0, 65_535.0, 2.0**32 - 1, 2.0**63]
    assert [convert(s, t, v) for s, t, v in (
        (REAL, WORD, 2.5), (LREAL, BYTE, 300.0), (REAL, WORD, -1.0), (LREAL, DWORD, 7.6))] == [2, 255, 0, 8]


@pytest.mark.parametrize("name", [
    "BOOL_TO_TIME", "TIME_TO_DATE", "DT_TO_TIME",
    "INT_TO_INT", "REAL_TO_DT", "DATE_TO_TOD", "BOOL_TO_DATE",
])
def test_conversions_that_make_no_sense_do_not_exist(name):
    assert functions.lookup(name) is None


@pytest.mark.parametrize(("source", "target", "value", "expected"), [
    (TIME, DINT, 1_999_999, 1), (TIME, DINT, -1_999_999, -1), (TIME, INT, 40_000 * MS, 40_000 - 65536),
    (TIME, REAL, 1_500_000, 1.5), (TIME, LREAL, 1, 1e-6), (TIME, DWORD, -MS, 0xFFFFFFFF),
    (INT, TIME, -5, -5 * MS), (ULINT, TIME, 2**63, 0), (REAL, TIME, 1.5, 1_500_000), (LREAL, TIME, 2.5e-6, 2),
    (LREAL, TIME, 1e300, 2**63 - 1), (REAL, TIME, NAN, 0),
    (TOD, UDINT, DAY - 1, 86_399_999), (UDINT, TOD, 86_400_001, MS), (INT, TOD, -1, DAY - MS),
    (DT, UDINT, 10 * S + 1, 10), (UDINT, DT, 10, 10 * S), (DATE, UDINT, 2, 172_800),
    (UDINT, DATE, 172_799, 1), (DINT, DATE, -1, 2**32 - 1), (DATE, INT, 1, 86_400 - 65_536),
])
def test_times_count_in_milliseconds_and_dates_in_seconds(source, target, value, expected):
    assert same(convert(source, target, value), expected)


# ---- binary coded decimals --------------------------------------------------------------------


@given(st.sampled_from(BITS), st.sampled_from([USINT, UINT, UDINT, ULINT]), st.integers(0, 2**64 - 1))
def test_bcd(bits, number, value):
    value %= number.range[1] + 1
    there = functions.meaning(f"{number.name}_TO_BCD_{bits.name}", (number,), bits)
    back = functions.meaning(f"{bits.name}_BCD_TO_{number.name}", (bits,), number)
    digits = bits.bits // 4
    pattern = there(value)
    assert f"{pattern:x}" == (str(value)[-digits:].lstrip("0") or "0")
    assert back(pattern) == value % 10**digits


def test_bad_bcd_is_zero():
    assert functions.meaning("BYTE_BCD_TO_USINT", (BYTE,), USINT)(0x1A) == 0
    assert functions.meaning("WORD_BCD_TO_USINT", (WORD,), USINT)(0x0300) == 300 - 256


# ---- texts ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("type_", "value", "text"), [
    (BOOL, True, "TRUE"), (BOOL, False, "FALSE"), (SINT, -128, "-128"),
    (ULINT, 2**64 - 1, "18446744073709551615"),
    (WORD, 0xBEEF, "16#BEEF"), (LWORD, 0, "16#0"),
    (REAL, 0.0, "0.0"), (REAL, -0.0, "-0.0"), (REAL, 1.0, "1.0"), (REAL, 0.1, "0.1"), (REAL, -2.5, "-2.5"),
    (REAL, 16777216.0, "16777216.0"), (REAL, 1e-5, "1.0e-05"), (REAL, 1.25e-4, "0.000125"),
    (REAL, 3.4028234663852886e38, "3.4028235e+38"), (REAL, 1e-45, "1.0e-45"),
    (REAL, 1e15, "1000000000000000.0"),
    (REAL, 1e16, "1.0e+16"), (REAL, 123456.789, "123456.79"), (REAL, INF, "inf"), (REAL, -INF, "-inf"),
    (REAL, NAN, "nan"), (LREAL, 0.1, "0.1"), (LREAL, 1 / 3, "0.3333333333333333"), (LREAL, 1e100, "1.0e+100"),
    (LREAL, 5e-324, "5.0e-324"), (LREAL, 0.1 + 0.2, "0.30000000000000004"),
    (TIME, 0, "T#0ms"), (TIME, 1_500 * MS, "T#1s500ms"), (TIME, -(DAY + 3600 * S), "T#-1d1h"),
    (TIME, 61_000_001_001, "T#1m1s1us1ns"), (TIME, -(2**63), "T#-106751d23h47m16s854ms775us808ns"),
    (DATE, 0, "D#1970-01-01"), (DATE, 11016, "D#2000-02-29"), (DATE, 2**32 - 1, "D#11761191-01-20"),
    (TOD, 0, "TOD#00:00:00"), (TOD, 3_723_450 * MS, "TOD#01:02:03.45"),
    (TOD, DAY - 1, "TOD#23:59:59.999999999"),
    (DT, 951_782_400 * S + 1, "DT#2000-02-29-00:00:00.000000001"),
])
def test_texts_of_values_and_back(type_, value, text):
    if type_ == REAL:
        value = struct.unpack("f", struct.pack("f", value))[0]
    assert convert(type_, STRING, value) == text.encode()
    assert convert(type_, WSTRING, value) == text
    assert same(convert(STRING, type_, text.encode()), value)
    assert same(convert(WSTRING, type_, f"  {text.lower()} "), value)


@given(st.floats(width=32, allow_nan=False, allow_infinity=False))
def test_the_text_of_a_real_is_the_shortest_that_reads_back(value):
    text = convert(REAL, STRING, value).decode()
    assert re.fullmatch(r"-?\d+\.\d+(e[+-]\d\d+)?", text)
    assert same(convert(STRING, REAL, text.encode()), value)
    digits = text.partition("e")[0].replace(".", "").lstrip("-0").rstrip("0")
    if len(digits) > 1:
        shorter = float(f"{value:.{len(digits) - 2}e}")
        try:
            shorter = struct.unpack("f", struct.pack("f", shorter))[0]
        except OverflowError:
            shorter = INF
        assert shorter != value


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_the_text_of_an_lreal_reads_back(value):
    text = convert(LREAL, STRING, value).decode()
    assert same(float(text), value)
    assert same(convert(STRING, LREAL, text.encode()), value)
    assert ("e" in text) == ("e" in repr(value))


@given(st.integers(-(2**63), 2**63 - 1))
def test_the_text_of_a_time_reads_back(value):
    assert convert(STRING, TIME, convert(TIME, STRING, value)) == value


@given(st.datetimes(datetime.datetime(1970, 1, 1), datetime.datetime(2554, 1, 1)), st.integers(0, 999))
def test_dates_are_those_of_the_calendar(moment, nanoseconds):
    past = moment - datetime.datetime(1970, 1, 1)
    value = past.days * DAY + past.seconds * S + past.microseconds * 1000 + nanoseconds
    clock = f"{moment:%H:%M:%S}" + f".{moment.microsecond:06d}{nanoseconds:03d}".rstrip("0").rstrip(".")
    date = moment.date().isoformat()
    assert convert(DT, STRING, value) == f"DT#{date}-{clock}".encode()
    assert convert(STRING, DT, f"{date}-{clock}".encode()) == value
    assert convert(DATE, STRING, convert(DT, DATE, value)) == f"D#{date}".encode()
    assert convert(TOD, STRING, convert(DT, TOD, value)) == f"TOD#{clock}".encode()


@pytest.mark.parametrize(("type_", "texts"), [
    (BOOL, ("", "2", "yes", "TRUE1")),
    (INT, ("", "x", "1.5", "12abc", "32768", "-32769", "1__0", "_1", "+", "1 2", "9" * 5000, "\u0663")),
    (USINT, ("-1", "256", "16#100", "2#12", "8#8", "16#", "-16#1")),
    (REAL, ("", ".", "1.", ".5", "1e", "0x10", "infinity", "1,5")),
    (TIME, ("", "T#", "5", "1ms1s", "1.5s1ms", "1s1s", "T#300000d", "-T#1s")),
    (DATE, ("", "2000-02-30", "1969-12-31", "2000-13-01", "D#0000-01-01")),
    (TOD, ("24:00:00", "12:60", "12", "1:2:3.")),
    (DT, ("2000-01-01", "2000-01-01-", "2000-01-01-TOD#00:00:00", "2000-02-30-00:00:00",
          "2600-01-01-00:00:00")),
])
def test_text_that_is_no_value_of_the_type_gives_the_initial_value(type_, texts):
    for text in texts:
        assert convert(WSTRING, type_, text) == convert(STRING, type_, text.encode("latin-1", "replace")) == 0


@pytest.mark.parametrize(("type_", "text", "value"), [
    (INT, "+1_000", 1000), (INT, "000" * 3000 + "7", 7), (BYTE, "2#1111_0000", 0xF0), (UINT, "8#17", 15),
    (DINT, "16#ff", 255), (BOOL, "1", True), (REAL, "1e400", INF), (REAL, "5", 5.0),
    (LREAL, "1_0.5E-1", 1.05),
    (TIME, "TIME#1.5s", 1_500 * MS), (TIME, "1d_2h", 26 * 3600 * S), (TIME, "t#-90m", -5400 * S),
    (TIME, "0.0000000001s", 0), (TOD, "12:30", 45_000 * S), (DATE, "DATE#1970-1-2", 1),
])
def test_other_spellings_are_read(type_, text, value):
    assert same(convert(STRING, type_, text.encode()), value)


def test_strings_and_wide_strings():
    assert convert(STRING, WSTRING, b"\xe4\xff") == "\u00e4\u00ff"
    assert convert(WSTRING, STRING, "a\u00e4\u20ac") == b"a\xe4?"
    narrow = functions.meaning("DINT_TO_STRING", (DINT,), String("STRING", 3))
    assert narrow(-1234) == b"-12"


def test_overloaded_conversions_are_the_named_ones():
    assert functions.resolve("to_dint", (REAL,)) == functions.resolve("REAL_TO_DINT", (REAL,))
    assert functions.resolve("TO_LINT", (LINT,)).name == "MOVE"
    assert functions.meaning("TO_DINT", (REAL,), DINT)(2.5) == 2
