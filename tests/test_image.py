"""The image: the same input gives the same bytes; what does not run does not count; symbols keep their place."""

from __future__ import annotations

import pytest

from ldc import pipeline
from ldc.il import image
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile

PROGRAM = """PROGRAM main
VAR
    a AT %IX0.0 : BOOL; q AT %QX0.0 : BOOL;
    t : TON; count : DINT; total : LREAL;
END_VAR
VAR RETAIN kept : ARRAY [1..3] OF INT; END_VAR
(* a comment *)
RUNG one "a title"
    [a] <t: TON(PT := T#1s)> (q)
RUNG [q] <ADD(IN1 := count, IN2 := 1, OUT => count)>
END_PROGRAM
"""


def made(text: str, previous=None) -> image.Image:
    sources = Sources((SourceFile("main.ld", text),), Settings(), None)
    result = pipeline.compile_project(sources, pipeline.Options(previous=previous))
    assert result.image is not None, [d.message for d in result.diagnostics]
    return result.image


def test_same_input_same_bytes() -> None:
    assert made(PROGRAM).data == made(PROGRAM).data


def test_comments_titles_and_spacing_do_not_change_the_digest() -> None:
    other = PROGRAM.replace("(* a comment *)", "\n\n(* another *)").replace("a title", "its title")
    other = other.replace("[a] <t", "[a]\n      <t")
    assert made(other).digest == made(PROGRAM).digest


@pytest.mark.parametrize("old, new", [("T#1s", "T#2s"), ("[a] <", "[/a] <"), ("RUNG one", "RUNG two"),
                                      ("count : DINT", "count : DINT := 1"), ("RETAIN", ""), ("%QX0.0", "%QX0.1")])
def test_what_runs_changes_the_digest(old: str, new: str) -> None:
    assert made(PROGRAM.replace(old, new)).digest != made(PROGRAM).digest


def places(layout) -> dict[str, tuple]:
    return {s.path: (s.area, s.offset, s.bit) for s in layout.symbols}


def test_an_added_declaration_moves_nothing() -> None:
    before = made(PROGRAM).layout
    grown = PROGRAM.replace("    t : TON;", "    early : LREAL; t : TON; u : TOF;")
    after = made(grown, previous=before).layout
    assert places(before).items() <= places(after).items()
    assert {s.offset for s in after.symbols if s.path in ("main.early", "main.u")}.isdisjoint(
        s.offset for s in before.symbols if s.area == "D")


def test_a_symbol_of_another_type_gets_another_place() -> None:
    before = made(PROGRAM).layout
    after = made(PROGRAM.replace("count : DINT", "count : LINT"), previous=before).layout
    old, new = places(before), places(after)
    assert new.pop("main.count") != old.pop("main.count")
    assert new == old


def test_no_two_symbols_share_memory() -> None:
    layout = made(PROGRAM).layout
    taken: set[int] = set()
    for symbol in (s for s in layout.symbols if s.area == "D"):
        own = set(range(symbol.offset, symbol.offset + symbol.size))
        assert own and not own & taken and max(own) < layout.size
        taken |= own


@pytest.mark.parametrize("data", [b"", b"LDCI", b"LDCX" + bytes(40), b"LDCI" + bytes(40), b"LDCI\x93\x02\xc4\x00\xc4\x00"])
def test_other_bytes_are_no_image(data: bytes) -> None:
    with pytest.raises(image.BadImage):
        image.load(data)


def test_every_cut_and_every_changed_byte_is_no_crash() -> None:
    data = made(PROGRAM).data
    for size in range(0, len(data), 7):
        with pytest.raises(image.BadImage):
            image.load(data[:size])
    for at in range(4, len(data), 11):
        spoilt = data[:at] + bytes([data[at] ^ 0x55]) + data[at + 1:]
        try:
            image.load(spoilt)
        except image.BadImage:
            continue
