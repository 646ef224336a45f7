"""The collector rests while a program is compiled, and goes on behind it."""

from __future__ import annotations

import gc

import pytest

from ldc.collector import resting


@pytest.fixture
def collections() -> list[int]:
    """The generations that are walked, one by one."""
    seen: list[int] = []

    def count(phase: str, info: dict[str, int]) -> None:
        if phase == "start":
            seen.append(info["generation"])

    gc.callbacks.append(count)
    yield seen
    gc.callbacks.remove(count)


def test_what_is_made_is_old_at_once(collections: list[int]) -> None:
    with resting():
        made = [[n] for n in range(20_000)]
        with resting():
            made += [[n] for n in range(20_000)]
        assert not gc.isenabled() and not collections
    assert gc.isenabled() and not collections
    old = set(map(id, gc.get_objects(generation=2)))
    assert all(id(one) in old for one in made)


def test_goes_on_after_a_fault_and_stays_off_where_it_was_off() -> None:
    with pytest.raises(ValueError), resting():
        raise ValueError
    assert gc.isenabled()
    gc.disable()
    try:
        with resting():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()
