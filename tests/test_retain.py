"""Retain: which variables survive a restart, and that a save on the disk is whole whatever happens."""

from __future__ import annotations

import os
import random
import select
import signal
import time
from pathlib import Path

import growth
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import native
from ldc.diagnostics import Diagnostics, Invalid
from online_programs import loaded
from runtime.retain import Identity, leaves, restore, saver
from runtime.retain_file import Entry, Kept, Store, encode
from runtime.retaining import Retaining

TEXT = """TYPE
    pair : STRUCT left : INT; right : REAL; END_STRUCT;
    colour : (red, green, blue);
    small : INT(-5..50);
END_TYPE
FUNCTION_BLOCK meter
VAR_INPUT run : BOOL; END_VAR
VAR_OUTPUT ok : BOOL; END_VAR
VAR RETAIN hours : DINT; END_VAR
VAR NON_RETAIN last : DINT; END_VAR
VAR plain : DINT; END_VAR
RUNG counts
    [run] <ADD(IN1 := hours, IN2 := 1, OUT => hours)>
RUNG copies
    <MOVE(IN := hours, OUT => last)> <MOVE(IN := hours, OUT => plain)>
END_FUNCTION_BLOCK
PROGRAM main
VAR RETAIN
    n : INT := 3;
    waits : TON;
    kept : meter;
    pairs : ARRAY [1..2] OF pair;
    row : ARRAY [0..1, 0..2] OF UINT;
    reals : ARRAY [0..1] OF LREAL;
    flags : ARRAY [0..3] OF BOOL;
    text : STRING[10] := 'first';
    wide : WSTRING[5];
    tint : colour := green;
    few : small;
    day : DATE;
    out AT %QW4 : INT;
    packed AT %MW2 : WORD;
END_VAR
VAR
    low AT %MB4 : BYTE;
    free : meter;
    lost : INT := 8;
    one : BOOL := TRUE;
END_VAR
RUNG counts
    <ADD(IN1 := n, IN2 := 1, OUT => n)> <MOVE(IN := n, OUT => lost)>
RUNG waits
    [one] <waits: TON(PT := T#1s)>
RUNG meters
    [one] { <kept: meter()> | <free: meter()> }
END_PROGRAM
"""
ENGINES = ("vm", pytest.param("native", marks=native.needs_gcc))
VALUES = {"pairs[2].right": 2.5, "pairs[1].left": -7, "row[1,2]": 65535, "reals[1]": float("nan"),
          "flags[3]": True, "text": "caf\xe9", "wide": "żółw",
          "tint": "blue", "few": 49, "day": "D#2024-02-29", "out": -2,
          "packed": 0xBEEF}
ME = Identity("main", "a" * 64, lambda: "b" * 64)


def saved(machine) -> Kept:
    return saver(machine, ME)()()


def filled(engine: str):
    machine = loaded(TEXT, engine).machine
    for path, value in VALUES.items():
        machine.set(path, value)
    for _ in range(30):
        machine.scan()
    return machine


def state(machine) -> dict[str, object]:
    return {path: machine.get(path) for path, _ in machine.paths()}


@pytest.mark.parametrize("engine", ENGINES)
def test_what_is_retained_comes_back_and_nothing_else(engine: str) -> None:
    before = filled(engine)
    after = loaded(TEXT, engine).machine
    told = restore(after, saved(before))
    assert not told.initialised and not told.dropped
    for path in VALUES:
        if path != "reals[1]":
            assert after.get(path) == before.get(path), path
    assert after.get("reals[1]") != after.get("reals[1]")
    assert after.get("n") == 33 and after.get("lost") == 8
    assert after.get("kept.hours") == 30 and after.get("free.hours") == 30
    assert after.get("kept.plain") == 30 and after.get("free.plain") == 0
    assert after.get("kept.last") == 0 and after.get("free.last") == 0


@pytest.mark.parametrize("engine", ENGINES)
def test_a_retained_timer_keeps_what_has_elapsed(engine: str) -> None:
    before = filled(engine)
    assert before.get("waits.ET") == 290_000_000
    after = loaded(TEXT, engine).machine
    restore(after, saved(before))
    for _ in range(70):
        after.scan()
        assert not after.get("waits.Q")
    after.scan()
    assert after.get("waits.Q"), "one second of IN in both runs together"


@native.needs_gcc
def test_both_engines_save_the_same_bytes() -> None:
    assert encode(saved(filled("vm"))) == encode(saved(filled("native")))


def test_bytes_after_the_end_of_a_string_are_not_saved() -> None:
    machine = loaded(TEXT, "vm").machine
    machine.set("text", "ab")
    entry = next(e for e in saved(machine).entries if e.path == "MAIN.TEXT")
    assert entry.data == b"\2\0\0\0ab"


def test_another_program_takes_what_it_has_of_the_same_type() -> None:
    kept = saved(filled("vm"))
    text = TEXT.replace("n : INT := 3", "n : DINT := 4")
    text = text.replace("flags : ARRAY [0..3]", "flags : ARRAY [0..4]")
    text = text.replace("IN1 := n, IN2 := 1, OUT => n", "IN1 := lost, IN2 := 1, OUT => lost")
    text = text.replace("<MOVE(IN := n, OUT => lost)>", "")
    text = text.replace("left : INT;", "left : INT; third : INT := 9;")
    after = loaded(text.replace("INT(-5..50)", "INT(-5..40)").replace("day : DATE", "date_ : DATE")).machine
    told = restore(after, kept)
    assert set(told.initialised) == {"MAIN.N", "MAIN.FLAGS", "MAIN.FEW", "MAIN.DATE_",
                                     "MAIN.PAIRS[1].THIRD", "MAIN.PAIRS[2].THIRD"}
    assert set(told.dropped) == {"MAIN.N", "MAIN.FLAGS", "MAIN.FEW", "MAIN.DAY"}
    assert after.get("pairs[2].right") == 2.5 and after.get("pairs[2].third") == 9 and after.get("n") == 4


def test_bytes_that_are_no_value_change_nothing() -> None:
    kept = saved(filled("vm"))
    entries = [Entry(e.path, e.type, e.data[:-1]) if e.path == "MAIN.TINT" else e for e in kept.entries]
    after = loaded(TEXT).machine
    before = state(after)
    with pytest.raises(ValueError):
        restore(after, replace_entries(kept, entries))
    assert state(after) == before and after.now_ns == 0


def replace_entries(kept: Kept, entries: list[Entry]) -> Kept:
    return Kept(kept.name, kept.program, kept.layout, kept.scan, kept.now_ns, entries)


# ---- files -------------------------------------------------------------------------------------------


def numbered(n: int) -> Kept:
    return Kept("main", "p", "l", n, n, [Entry("MAIN.N", "t", bytes([n]) * 300)])


def test_the_newest_save_is_loaded_and_the_one_before_is_there(tmp_path: Path) -> None:
    store = Store(tmp_path / "r")
    assert Store(tmp_path / "r").load(Diagnostics()) is None
    store.load(Diagnostics())
    for n in (1, 2, 3):
        store.save(numbered(n))
        assert Store(tmp_path / "r").load(Diagnostics()) == numbered(n)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r", "r.before"]
    (tmp_path / "r").unlink()  # the power went between the two names
    assert Store(tmp_path / "r").load(Diagnostics()) == numbered(2)


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_a_damaged_file_is_never_loaded(tmp_path_factory, data) -> None:
    folder = tmp_path_factory.mktemp("retain")
    store = Store(folder / "r")
    store.load(Diagnostics())
    store.save(numbered(1))
    store.save(numbered(2))
    whole = (folder / "r").read_bytes()
    cut = data.draw(st.integers(0, len(whole) - 1))
    broken = whole[:cut] + data.draw(st.binary(max_size=3)) + whole[cut + data.draw(st.integers(0, 3)):]
    (folder / "r").write_bytes(broken)
    found = Diagnostics()
    fresh = Store(folder / "r")
    try:
        got = fresh.load(found)
    except Invalid as error:  # the number of the version was hit
        assert [d.code for d in error.diagnostics] == ["LD0851"]
        return
    if broken == whole:
        assert got == numbered(2) and not len(found)
        return
    assert got == numbered(1) and [d.code for d in found] == ["LD0850"]
    fresh.save(numbered(3))
    (folder / "r").write_bytes(b"")
    assert Store(folder / "r").load(Diagnostics()) == numbered(1), "damage is no save before"


def test_a_save_that_fails_leaves_the_others(tmp_path: Path, monkeypatch) -> None:
    store = Store(tmp_path / "r")
    store.load(Diagnostics())
    store.save(numbered(1))
    store.save(numbered(2))
    real = os.fsync

    def full(number: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError):
        store.save(numbered(3))
    monkeypatch.setattr(os, "fsync", real)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r", "r.before"]
    assert Store(tmp_path / "r").load(Diagnostics()) == numbered(2)


# ---- kill -9 -----------------------------------------------------------------------------------------

COUNTS = """PROGRAM main
VAR RETAIN n : DINT; row : ARRAY [0..400] OF DINT; END_VAR
VAR i : DINT; END_VAR
END_PROGRAM
"""


@pytest.mark.parametrize("beside", (False, True))
def test_power_cuts_at_any_moment_lose_nothing_that_was_saved(tmp_path: Path, beside: bool) -> None:
    """A child counts and saves; it is killed at a random moment, and another one goes on with the file."""
    path, reached, dice = tmp_path / "r", 0, random.Random(5)
    made = loaded(COUNTS)
    places = made.machine.find(["n", *(f"row[{i}]" for i in range(401))])
    for round_ in range(20):
        reader, writer = os.pipe()
        child = os.fork()
        if child == 0:
            try:
                _count(made.machine, places, path, writer, beside)
            finally:
                os._exit(1)
        os.close(writer)
        if round_ % 4:
            select.select([reader], [], [], 2.0)
        time.sleep(dice.uniform(0, 0.04))
        os.kill(child, signal.SIGKILL)
        os.waitpid(child, 0)
        with open(reader, "rb") as told:
            lines = told.read().split(b"\n")
        known = max((int(line) for line in lines[:-1]), default=reached)
        found = Diagnostics()
        kept = Store(path).load(found)
        assert not len(found), "a torn file"
        if kept is None:
            assert known == reached == 0
            continue
        machine = loaded(COUNTS).machine if round_ % 10 == 0 else made.machine
        restore(machine, kept)
        values = set(machine.sample(places))
        assert len(values) == 1, "values of two saves"
        assert (value := values.pop()) >= known >= reached
        reached = value
    assert reached > 30


def _count(machine, places, path: Path, pipe: int, beside: bool) -> None:
    store = Store(path)
    kept = store.load(Diagnostics())
    if kept is not None:
        restore(machine, kept)
    first = machine.get("n")
    retaining = Retaining(machine, ME, store, 20_000_000, (lambda: None) if beside else None,
                          lambda error: os._exit(2),
                          lambda scan: os.write(pipe, b"%d\n" % (first + scan)))
    while True:
        machine.scan()
        for symbol in places:
            machine.assign(symbol, first + machine.scans)
        retaining.scanned()


def test_what_is_retained_is_found_in_time_that_grows_with_the_program() -> None:
    """No quadratic walk: four times the variables take far less than sixteen times as long."""
    def seconds(count: int) -> float:
        fields = "\n".join(f"v{i} : ARRAY [0..3] OF DINT;" for i in range(count))
        layout = loaded(f"PROGRAM main\nVAR RETAIN\n{fields}\nEND_VAR\nEND_PROGRAM\n").machine.layout
        assert len(leaves(layout)) == count
        return growth.seconds(lambda: leaves(layout))

    assert seconds(2000) < 12 * max(seconds(500), 0.002)
