"""The areas of memory: their table is sound, the papers' constants are legal, slips in a table are found."""

from __future__ import annotations

import struct
from dataclasses import replace

import pytest

from ldc.il.areas import PAGE, PROCESSORS, SLAVES, areas, shared_range, slips
from ldc.il.coordination import Module, Parameter, placed_modules
from ldc.types import REAL
from runtime.master.frames import buffer, room
from runtime.protocol.envelope import Command, Envelope, decode, encode, head
from runtime.protocol.profile import channel


def test_the_table_is_sound() -> None:
    assert slips(areas().values()) == []
    assert len(PROCESSORS) == SLAVES + 1


@pytest.mark.parametrize(("constant", "area"), [
    (0x00, "PTD"),  # TDA
    (0x400, "LCF"),  # MSF
    (0x600, "LCD"),  # MDA
    (0x14A, "AFR"),  # AF
    (0x1F4000, "SMD"),  # ADA
])
def test_constants_of_table_1_of_the_paper_lie_in_their_areas(constant: int, area: str) -> None:
    assert areas()[area].window(constant) == 1
    assert areas()[area].space == "M" or constant % 4 == 0


def test_parameter_ids_of_table_1_are_elements_of_the_data_of_algorithms() -> None:
    assert all(areas()["AD"].window(4 * pid) == 1 for pid in range(1, 10))


def test_the_row_of_the_binocular_robot_can_be_used_as_it_is_printed() -> None:
    """MSF 0x400 and MDA 0x600 are the start bit and the first parameter of module 0, AF 0x14A asks for an
    algorithm, ADA 0x1F4000 is slot 0 of slave 1, and an envelope takes AID 0x02000001 with its 9 parameters."""
    parameter = Parameter("theta", "eyes.theta", REAL, "<f", 0)
    ((first,),) = [m.parameters for m in placed_modules((Module(0, "eyes", None, None, (parameter,)),))]
    assert first.address == 0x600 and areas()["LCF"].base == 0x400
    assert 0 <= 0x14A - areas()["AFR"].base < areas()["AFR"].size
    slot = channel(1, True, 0)
    assert slot.slot == 0x1F4000
    adata = b"".join(struct.pack("<If", pid, pid / 4) for pid in range(1, 10))
    frame = encode(Envelope(1, 0x02000001, Command.START, 0, adata))
    assert len(frame) <= slot.size and decode(head(frame), frame).aid == 0x02000001


def test_the_customised_program_has_flags_of_its_own_words_and_room_for_two_buffers() -> None:
    flags, data = areas()["ACPF"], areas()["ACPDD"]
    assert flags.base % 32 == 0 and flags.size == 64
    assert buffer(0) + room() <= buffer(1) and buffer(1) + room() <= data.base + data.size


def test_windows_of_slaves() -> None:
    smd = areas()["SMD"]
    assert [smd.window(0x1F4000 + n * 0x2000) for n in range(-1, 5)] == [None, 1, 2, 3, 4, None]
    assert smd.window(0x1F4FFF) == 1 and smd.window(0x1F5000) is None
    first, end = shared_range()
    assert first == 0x1F4000 and end % PAGE == 0
    assert all(first <= a.first(n) and a.first(n) + a.size <= end for a in areas().values() if a.shared
               for n in range(1, SLAVES + 1))


@pytest.mark.parametrize(("name", "change", "words"), [
    ("CDF", {"base": 0x180}, "overlaps AFR"),
    ("LCD", {"base": 0x0601}, "multiples of 4"),
    ("SMD", {"writer": "plant"}, "no processor"),
    ("MSD", {"base": 0x1F4800}, "in the same page has another writer"),
    ("SMD", {"stride": 0x800}, "a window holds"),
])
def test_slips_are_found(name: str, change: dict, words: str) -> None:
    table = areas() | {name: replace(areas()[name], **change)}
    assert any(words in slip for slip in slips(table.values()))
