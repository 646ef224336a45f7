"""The areas of memory: their table is sound, the papers' constants are legal, slips in a table are found."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ldc.il.areas import PAGE, PROCESSORS, SLAVES, areas, shared_range, slips


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
