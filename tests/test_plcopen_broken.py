"""Broken PLCopen XML: told at the right place, never raised, in bounded time and memory."""

from __future__ import annotations

import time


import growth
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plcopen_xml import block, coil, contact, element, ladder, pou, project, rail, result, value, wires
from test_plcopen import CASES, VALUES, compiled, said

from ldc.draw import Locator
from ldc.render import render

LARGE = project(*(pou(xml.partition("<body>")[2].partition("</body>")[0], VALUES, name=f"p{number}")
                  for number, xml in enumerate(CASES.values())))


def shown(xml: str) -> str:
    """What a user sees."""
    found = compiled(xml)
    return render(found.diagnostics, locate=Locator(found.project.files))


@pytest.mark.parametrize("at", range(0, len(LARGE), 97 * 7))
def test_a_file_that_ends_anywhere(at: int) -> None:
    """Truncated at every 97th byte; each test takes every seventh of these."""
    for end in range(at, min(at + 97 * 7, len(LARGE)), 97):
        found = compiled(LARGE[:end])
        assert found.program is None and found.diagnostics.has_errors


BOMB = "".join(f'<!ENTITY e{n + 1} "&e{n};&e{n};&e{n};">' for n in range(40))


@pytest.mark.parametrize("xml, code", [
    (f"<!DOCTYPE p [{BOMB}]><project>&e40;</project>", "LD0141"),
    ('<!DOCTYPE p [<!ENTITY x SYSTEM "file:///etc/passwd">]><project>&x;</project>', "LD0141"),
    ('<!DOCTYPE p SYSTEM "http://127.0.0.1/x.dtd"><project/>', "LD0141"),
    ('<!DOCTYPE p [<!ENTITY % x SYSTEM "http://127.0.0.1/x.dtd"> %x;]><project/>', "LD0141"),
    ("<project>&nothing;</project>", "LD0140"),
    ("<project>" + "<a>" * 100_000, "LD0142"),
    (ladder("a : BOOL", rail(), coil(2, "a", 9)), "LD0146"),
    (ladder("a : BOOL", rail(), contact(2, "a"), contact(2, "a"), coil(3, "a", 2)), "LD0144"),
    (ladder("a : BOOL", rail(), contact(5, "a"), contact(2, "a", (5, 3)), contact(3, "a", 2),
            coil(4, "a", 3)), "LD0303"),
    (ladder("a : BOOL", rail(), contact(2, ""), coil(3, "a", 2)), "LD0144"),
    (ladder("a : BOOL", rail(), contact(2, "a"), coil(3, "b", 2)), "LD0404"),
    (ladder("a : BOOL", rail(), block(3, "", {"EN": 1}, ("ENO",)), coil(4, "a", "3.ENO")), "LD0144"),
    (ladder("a : BOOL", rail(), block(3, "NOTHING", {"EN": 1}, ("ENO",)), coil(4, "a", "3.ENO")), "LD0501"),
    (ladder("a : BOOL", rail(), contact(2, "(" * 200 + "a" + ")" * 200), coil(3, "a", 2)), "LD0110"),
    (ladder("a : BOOL", rail(), element("jump", 2, wires(1), label="nowhere")), "LD0515"),
    (project(types='<dataType name="E"><baseType><enum><values/></enum></baseType></dataType>'), "LD0144"),
])
def test_what_is_wrong_is_told(xml: str, code: str) -> None:
    begin = time.process_time()
    found = compiled(xml)
    assert code in {d.code for d in found.diagnostics}, said(found)
    assert found.program is None
    assert time.process_time() - begin < 10


@pytest.mark.parametrize("xml, what", [
    ('<Project xmlns="www.iec.ch/public/TC65SC65BWG7TF10"><Types/></Project>', "holds no POU, type or variable"),
    ("<Project/>", "begins with <Project>"),
    ("<TcPlcObject><POU Name='MAIN'/></TcPlcObject>", "is a source file of TwinCAT"),
    ("<ExportFile/>", "is an export of CODESYS in a format of its own"), ("<x/>", "begins with <x>"),
    ("<project/>", "holds no POU, type or variable")])
def test_other_xml_is_named(xml: str, what: str) -> None:
    (found,) = compiled(xml).diagnostics
    assert (found.code, found.message) == ("LD0143", f"this is no PLCopen project: it {what}")


def test_a_call_of_a_method_is_told_where_it_is_drawn() -> None:
    drawn = ladder("a q : BOOL; m : TON", rail(), contact(2, "a"), block(3, "m.Reset", {"EN": 2}, ("ENO",)),
                   coil(4, "q", "3.ENO"))
    assert said(compiled(drawn)) == "error LD0145 main: block 3 `m.Reset` at (30, 10) calls `m.Reset`"
    assert "in PROGRAM main, rung 1, function `m.Reset` at (30, 10)" in shown(drawn)


def test_blocks_of_an_unknown_type_are_told_where_they_are_drawn() -> None:
    xml = ladder("a q : BOOL; d : MC_Power", rail(), contact(2, "a"), coil(6, "q", 2), contact(
        3, "a", at=(10, 90)), block(4, "MC_Power", {"Enable": 3}, ("Status",), "d", at=(60, 90)), coil(
        5, "q", "4.Status", at=(90, 90)))
    assert said(compiled(xml)).splitlines() == [
        "error LD0205 there is no type or function block `MC_Power`",
        "note LD0158 a block of the unknown type `MC_Power` is not compiled"]
    assert "in PROGRAM main, rung 2, block `d: MC_Power` at (60, 90)" in shown(xml)


WORDS = st.sampled_from([
    "", "0", "-1", "99999999999999999999", "a", "TRUE", "T#1s", "(", ")", "[", "%IX0.0", "@n1", ":=", "CTU",
    "EN", "é", "RETURN", "localId", "true", "rising", "set"])


@given(st.data())
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
def test_values_at_random(data) -> None:
    """Files that are well-formed, but wrong: a few attributes or texts are others."""
    xml = CASES[data.draw(st.sampled_from(sorted(CASES)))]
    for _ in range(data.draw(st.integers(1, 4))):
        closed = ">" if data.draw(st.booleans()) else '"'
        places = [i for i, c in enumerate(xml) if c == closed]
        at = data.draw(st.sampled_from(places)) + 1
        end = min((xml.find(c, at) % len(xml) for c in '<"'), default=at)
        xml = xml[:at] + data.draw(WORDS) + xml[max(at, end):]
    shown(xml)


@pytest.mark.parametrize("make", [
    lambda n: ladder("a q : BOOL", rail(), *(contact(i, "a") for i in range(2, n))),
    lambda n: ladder("a q : BOOL", rail(), *(contact(i, "a", i - 1) for i in range(2, n)),
                     coil(n, "q", n - 1)),
    lambda n: ladder("a q : BOOL", rail(), *(contact(i, "a") for i in range(2, n)),
                     coil(n, "q", tuple(range(2, n)))),
    lambda n: ladder("a q : BOOL", rail(), *(
        element("connector", 2 * i, wires(2 * i - 1), name=f"c{i}")
        + element("continuation", 2 * i + 1, "<connectionPointOut/>", name=f"c{i}") for i in range(1, n)),
        coil(2 * n, "q", 2 * n - 1)),
    lambda n: project(pou("<ST>" + "q := a;\n" * n + "</ST>", "a q : BOOL")),
    lambda n: ladder("a : BOOL; i : INT", rail(), value(2, "i"), *(
        block(i, "ADD", {"IN1": 2 if i == 3 else f"{i - 1}.OUT", "IN2": 2}, ("OUT",)) for i in range(3, n)),
        result(n, "i", f"{n - 1}.OUT")),
    lambda n: project(pou("<ST>a := a;</ST>", "a : BOOL", sections="<localVars>" + "".join(
        f'<variable name="t{i}" address="%MD{2 * i}"><type><TIME/></type></variable>' for i in range(4 * n))
        + "</localVars>")),
], ids=["loose contacts", "a row", "a wide net", "a chain of connectors", "statements", "a chain of values",
        "addresses of another size"])
def test_time_grows_with_the_size(make) -> None:
    """Ten times as large takes less than twenty-five times as long."""
    times = []
    for size in (300, 3000):
        text = make(size)
        times.append(growth.seconds(lambda: compiled(text)))
    assert times[1] < 25 * max(times[0], 0.02), times
