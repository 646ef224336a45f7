"""Points of the field, read several at once: what one after the other gives."""

from __future__ import annotations

import struct

from hypothesis import given
from hypothesis import strategies as st

from ldc.il.placement import Point
from runtime.field import Field, field_size

_VALUES = {
    "f32": st.floats(width=32, allow_nan=False), "i32": st.integers(-(1 << 31), (1 << 31) - 1),
    "u32": st.integers(0, (1 << 32) - 1), "bool32": st.booleans(),
}
_CODES = {"f32": "=f", "i32": "=i", "u32": "=I", "bool32": "=I"}


@given(st.data())
def test_points_read_at_once(data: st.DataObject) -> None:
    types = data.draw(st.lists(st.sampled_from(sorted(_VALUES)), min_size=1, max_size=8))
    places = {f"P{n}": Point(n, type_, float("-inf"), float("inf")) for n, type_ in enumerate(types)}
    buffer = bytearray(field_size(places))
    field = Field(buffer, places)
    asked = data.draw(st.lists(st.sampled_from([path.lower() for path in places]), max_size=10))
    read, each = field.readers(asked), [field.reader(path) for path in asked]
    for n, type_ in enumerate(types):
        struct.pack_into(_CODES[type_], buffer, 4 * n, data.draw(_VALUES[type_]))
    one_by_one = tuple(reader() for reader in each)
    assert read() == one_by_one
    assert [type(value) for value in read()] == [type(value) for value in one_by_one]
