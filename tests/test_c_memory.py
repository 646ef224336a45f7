"""What Python knows of native code without a parser of C: the interface, and where members of structures
lie."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import cffi
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc.il import c_types
from ldc.symbols import Variable
from ldc.types import BOOL, DINT, INT, LINT, LREAL, REAL, USINT, Array, String
from runtime.layout import slot
from runtime.vm.c_memory import Structure, taken, words

ROOT = Path(__file__).resolve().parent.parent
SCALARS = {BOOL: st.booleans(), INT: st.integers(-(1 << 15), (1 << 15) - 1), LINT: st.integers(-5, 1 << 40),
           USINT: st.integers(0, 255), DINT: st.integers(-9, 9), REAL: st.floats(width=32, allow_nan=False),
           LREAL: st.floats(allow_nan=False)}


def values(type_) -> st.SearchStrategy:
    match type_:
        case Array(element=element, count=count):
            return st.lists(values(element), min_size=count, max_size=count)
        case String(length=length):
            return st.binary(max_size=length)
    return SCALARS[type_]


scalars = st.sampled_from(list(SCALARS))
strings = st.builds(lambda n: String("STRING", n), st.integers(1, 9))
arrays = st.builds(lambda element, n: Array(((0, n - 1),), element), scalars | strings, st.integers(1, 5))
members = st.lists(scalars | strings | arrays, max_size=8).map(
    lambda types: tuple(Variable(f"v{n}", type_) for n, type_ in enumerate(types)))


class Values:
    """An instance: whatever has the members."""


@settings(max_examples=60, deadline=None)
@given(st.data(), members)
def test_members_lie_where_the_compiler_puts_them(data, variables) -> None:
    ffi = cffi.FFI()
    ffi.cdef(c_types.structure("made", variables, flat=True))
    made, structure = ffi.new("made *"), Structure(variables)
    assert structure.size == ffi.sizeof("made")
    buffer, before, after = bytearray(structure.size), Values(), Values()
    for v in variables:
        setattr(before, slot(v.name), data.draw(values(v.type)))
    structure.fill(buffer, before)
    ffi.memmove(made, buffer, structure.size)
    for v in variables:
        found, value = getattr(made, v.name), getattr(before, slot(v.name))
        if isinstance(v.type, String):
            assert (found.length, ffi.buffer(found.text)[: len(value)]) == (len(value), value)
        elif not isinstance(v.type, Array):
            view, at = structure.cell(buffer, v.name)
            assert found == value == view[at]
            view[at] = value
        elif not isinstance(v.type.element, String):
            assert list(found) == value
    structure.take(buffer, after)
    assert vars(after) == vars(before)


@given(st.data(), strings | arrays)
def test_a_value_and_what_is_packed_of_it(data, type_) -> None:
    value = data.draw(values(type_))
    assert taken(type_, iter(list(words(type_, value)))) == value


def test_the_interface_is_that_of_its_script() -> None:
    spec = importlib.util.spec_from_file_location("c_interface_script", ROOT / "script" / "c-interface.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    assert (ROOT / "runtime" / "c_interface.py").read_text(encoding="utf-8") == script.text()
