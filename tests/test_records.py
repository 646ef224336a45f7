"""A record is what `dataclass(frozen=True, slots=True)` makes, for everybody who uses one."""

from __future__ import annotations

import copy
import pickle
from dataclasses import FrozenInstanceError, dataclass, field, fields, is_dataclass, replace

import pytest

from ldc.records import record


def _make(decorate: type) -> type:
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
class Range:
    low: int
    high: int

    def __post_init__(self) -> None:
        if self.low > self.high:
            object.__setattr__(self, "low", self.high)


@record
class Nothing:
    pass


Wire, Plain = _make(record), _make(dataclass(frozen=True, slots=True))
CALLS = [(("a",), {}), (("a", "b"), {"note": 1}), ((), {"head": "a", "length": 5}), (("a", "b", 9, "n"), {})]


@pytest.mark.parametrize("given, named", CALLS)
def test_filled_shown_and_compared_as_a_dataclass(given: tuple, named: dict) -> None:
    ours, theirs = Wire(*given, **named), Plain(*given, **named)
    assert [getattr(ours, f.name) for f in fields(ours)] == [getattr(theirs, f.name) for f in fields(theirs)]
    assert repr(ours) == repr(theirs) and hash(ours) == hash(theirs) and ours.ends == theirs.ends
    for more, words in CALLS:
        assert (ours == Wire(*more, **words)) == (theirs == Plain(*more, **words))
    assert ours != theirs and ours != given


@pytest.mark.parametrize("given, named", [((), {}), (("a", "b", 1, 2, 3), {}), (("a",), {"head": "b"}),
                                          (("a",), {"wrong": 1})])
def test_wrong_calls_are_told_in_the_same_words(given: tuple, named: dict) -> None:
    with pytest.raises(TypeError) as ours:
        Wire(*given, **named)
    with pytest.raises(TypeError) as theirs:
        Plain(*given, **named)
    assert str(ours.value) == str(theirs.value)


def test_what_the_standard_library_does_with_a_dataclass() -> None:
    assert is_dataclass(Wire) and Wire.__match_args__ == Plain.__match_args__
    assert [f.name for f in fields(Wire)] == ["head", "tail", "length", "note"]
    assert replace(Wire("a"), tail="b") == Wire("a", "b")
    assert copy.copy(Wire("a")) == copy.deepcopy(Wire("a")) == Wire("a")
    assert pickle.loads(pickle.dumps(Point(1, 2))) == Point(1, 2)
    match Point(1, 2):
        case Point(x, y=2):
            assert x == 1


def test_nothing_changes_a_record() -> None:
    point = Point(1)
    with pytest.raises(FrozenInstanceError, match="cannot assign to field 'x'"):
        point.x = 2
    with pytest.raises(FrozenInstanceError, match="cannot delete field 'y'"):
        del point.y
    with pytest.raises(FrozenInstanceError):
        point.z = 3
    assert point == Point(1, 0) and not hasattr(point, "__dict__")


def test_what_happens_after_filling_and_no_fields() -> None:
    assert Range(5, 2) == Range(2, 2)
    assert Nothing() == Nothing() and hash(Nothing()) == hash(()) and repr(Nothing()) == "Nothing()"


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
    def made(decorate: type) -> type:
        @decorate
        class Sized:
            size: int

            def __eq__(self, other: object) -> bool:
                return True

        return Sized

    assert hash(made(record)(4)) == hash(made(dataclass(frozen=True, slots=True))(4))


def test_fields_made_anew_for_each_object_are_refused() -> None:
    class Held:
        items: list = field(default_factory=list)

    with pytest.raises(TypeError, match="use a dataclass"):
        record(Held)
