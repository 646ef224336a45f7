"""A record is what `dataclass(frozen=True, slots=True)` makes, for everybody who uses one."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from functools import cached_property

import pytest

from ldc.records import entity, field, is_record, record, replace


def _make(decorate: type, field: Callable) -> type:
    @decorate
    class Wire:
        """A wire between two nets."""

        head: str
        tail: str = "out"
        length: int = field(default=3, compare=False)
        note: object = field(default=None, repr=False)

        @property
        def ends(self) -> str:
            return f"{self.head}-{self.tail}"

    return Wire


@record
class Point:
    x: int
    y: int = 0


@record
class Nothing:
    pass


Wire, Plain = _make(record, field), _make(dataclass(frozen=True, slots=True), dataclasses.field)
CALLS = [(("a",), {}), (("a", "b"), {"note": 1}), ((), {"head": "a", "length": 5}), (("a", "b", 9, "n"), {})]


@pytest.mark.parametrize("given, named", CALLS)
def test_filled_shown_and_compared_as_a_dataclass(given: tuple, named: dict) -> None:
    ours, theirs = Wire(*given, **named), Plain(*given, **named)
    assert [getattr(ours, f.name) for f in fields(ours)] == [getattr(theirs, f.name) for f in fields(theirs)]
    assert repr(ours) == repr(theirs).rpartition(".")[2] and ours.ends == theirs.ends
    same = replace(ours, length=77)
    assert ours == same and hash(ours) == hash(same)
    for more, words in CALLS:
        assert (ours == Wire(*more, **words)) == (theirs == Plain(*more, **words))
    assert ours != theirs and ours != given


@pytest.mark.parametrize("given, named", [((), {}), (("a", "b", 1, 2, 3), {}), (("a",), {"head": "b"}),
                                          (("a",), {"wrong": 1})])
def test_wrong_calls_are_refused(given: tuple, named: dict) -> None:
    for wire in (Wire, Plain):
        with pytest.raises(TypeError):
            wire(*given, **named)


def test_what_the_standard_library_does_with_a_dataclass() -> None:
    assert is_dataclass(Wire) and Wire.__match_args__ == Plain.__match_args__
    assert [f.name for f in fields(Wire)] == ["head", "tail", "length", "note"]
    assert fields(Wire)[3].repr is False and fields(Wire)[2].default == 3
    assert dataclasses.replace(Wire("a"), tail="b") == Wire("a", "b")
    assert copy.copy(Wire("a")) == copy.deepcopy(Wire("a")) == Wire("a")
    assert pickle.loads(pickle.dumps(Point(1, 2))) == Point(1, 2)
    match Point(1, 2):
        case Point(x, y=2):
            assert x == 1


def test_nothing_changes_a_record() -> None:
    point = Point(1)
    with pytest.raises(AttributeError):
        point.x = 2
    with pytest.raises(AttributeError):
        del point.y
    with pytest.raises(AttributeError):
        point.z = 3
    assert point == Point(1, 0) and not hasattr(point, "__dict__")


def test_no_fields() -> None:
    assert Nothing() == Nothing() and hash(Nothing()) == hash(Nothing()) and repr(Nothing()) == "Nothing()"


def test_own_methods_stay() -> None:
    @record
    class Loose:
        name: str

        def __eq__(self, other: object) -> bool:
            return isinstance(other, Loose) and self.name.upper() == other.name.upper()

        def __hash__(self) -> int:
            return hash(self.name.upper())

        def __repr__(self) -> str:
            return self.name

    assert Loose("a") == Loose("A") and hash(Loose("a")) == hash(Loose("A")) and repr(Loose("a")) == "a"


def test_who_says_what_is_equal_is_still_hashed_by_fields() -> None:
    @record
    class Sized:
        size: int

        def __eq__(self, other: object) -> bool:
            return True

    assert hash(Sized(4)) == hash(Sized(4)) != hash(Sized(5))


def test_fields_made_anew_for_each_object() -> None:
    @record
    class Held:
        name: str
        items: list = field(default_factory=list)

    one, other = Held("a"), Held("a")
    one.items.append(1)
    assert (one, other) == (Held("a", [1]), Held("a", [])) and fields(Held)[1].default_factory is list


def test_a_field_of_the_standard_library_says_the_same() -> None:
    @record
    class Held:
        name: str = dataclasses.field(compare=False)
        items: list = dataclasses.field(default_factory=list, repr=False)

    assert Held("a") == Held("b") and Held("a").items == [] and repr(Held("a")) == "Held(name='a')"


def test_what_is_computed_once_is_kept_beside_the_fields() -> None:
    @record
    class Sum:
        items: tuple[int, ...]

        @cached_property
        def total(self) -> list[int]:
            return [sum(self.items)]

    known = Sum((1, 2))
    assert known.total is known.total and known == Sum((1, 2)) and Sum((3,)).total == [3]
    assert copy.copy(known) == known


def test_the_copy_with_other_values() -> None:
    assert replace(Wire("a"), tail="b") == Wire("a", "b")
    with pytest.raises(TypeError, match="wrong"):
        replace(Wire("a"), wrong=1)


def test_an_entity_changes_and_is_equal_to_itself_alone() -> None:
    @entity
    class Input:
        name: str
        sources: set = field(default_factory=set)

    one, other = Input("IN"), Input("IN")
    one.name = "PT"
    one.sources.add(1)
    assert repr(one) == "Input(name='PT', sources={1})" and not other.sources
    assert other != Input("IN") and len({one, other, one}) == 2
    with pytest.raises(AttributeError):
        one.note = "no field"


def test_what_is_a_record() -> None:
    assert is_record(Point(1)) and Point(1).__match_args__ == ("x", "y")
    assert not is_record("a") and not is_record((1,)) and not is_record(Point)
