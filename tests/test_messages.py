"""M: what a broadcast leaves in memory, who is called when, how often, with which data (SPEC 3)."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ldc.il.areas import areas
from ldc.il.coordination import (
    SYSTEM_MESSAGES, Full, Message, Subscriber, form, placed_messages, system_messages)
from ldc.types import BOOL, DATE, DINT, INT, LREAL, LWORD, REAL, SINT, STRING, TIME, UDINT, USINT
from runtime.master.messages import OVERFLOW, Messages, Outcome
from runtime.protocol.memory import Access, Memory, allocate, bit, shared_size, watch

ONE = (Subscriber(0),)


def user(number: int, form: str | None = None, policy: str = "queue", depth: int = 4,
         subscribers: tuple[Subscriber, ...] = ONE) -> Message:
    data = "a.c" if form else None
    return Message(f"m{number}", False, number, "a.b", data, form, policy, depth, subscribers)


def rig(*users: Message, seen=None) -> tuple[Messages, tuple[Message, ...], Memory]:
    """With ALARM and ESTOP subscribed; the memory refuses what the master may not do."""
    system = tuple(replace(m, subscribers=(Subscriber(9),)) for m in system_messages())
    messages = placed_messages((*system, *users))
    memory = watch(allocate("master", bytearray(shared_size())), seen)
    return Messages(memory, messages), messages, memory


def handled(messages: Messages) -> list[tuple[str, int, object]]:
    calls = []
    messages.handle(lambda message, subscriber, value: calls.append((message.name, subscriber.module, value)))
    return calls


def flag(memory: Memory, message: Message) -> bool:
    return memory.bits.test(*bit(message.flag))


def test_numbers_of_flags_are_those_of_the_memory_map() -> None:
    _, found, _ = rig(user(0, "<d"), user(1))
    flags = {m.name: m.flag for m in found}
    assert [flags[name] for name in SYSTEM_MESSAGES] == list(range(0x300, 0x307))
    assert (flags["m0"], flags["m1"]) == (0x340, 0x341)
    slots = {m.name: m.slot for m in found}
    assert slots["START_MODULE"] == 0x8000 and slots["m1"] == slots["m0"] + 4 + 4 * 8


def test_all_messages_that_are_possible_have_room_with_a_word_each() -> None:
    found = placed_messages((*system_messages(), *(user(n, "<f") for n in range(192))))
    assert found[-1].flag == areas()["MSGF"].base + areas()["MSGF"].size - 1
    with pytest.raises(Full) as full:
        placed_messages(tuple(user(n, "<d") for n in range(192)))
    assert full.value.number == 4096 // 36


@pytest.mark.parametrize(("type_", "expected"), [
    (BOOL, "<I"), (SINT, "<i"), (USINT, "<I"), (INT, "<i"), (DINT, "<i"), (UDINT, "<I"), (REAL, "<f"),
    (LREAL, "<d"), (TIME, "<q"), (LWORD, "<Q"), (DATE, "<i"), (STRING, None)])
def test_forms_of_values(type_, expected: str | None) -> None:
    assert form(type_) == expected


def test_data_are_there_before_the_flag() -> None:
    seen: list[Access] = []
    messages, found, _ = rig(user(0, "<f"), seen=seen.append)
    messages.broadcast(found[-1], 1.5)
    assert [access.area for access in seen if access.kind != "load"] == ["MSGD", "MSGD", "MSGF"]


def test_system_messages_come_first_then_ascending_and_subscribers_in_their_order() -> None:
    several = tuple(Subscriber(n) for n in (5, 1, 3))
    messages, found, memory = rig(user(0, "<i", subscribers=several), user(1))
    by_name = {m.name: m for m in found}
    for name, value in (("m1", None), ("m0", -7), ("ESTOP", 0), ("ALARM", 4)):
        assert messages.broadcast(by_name[name], value) is Outcome.WAITS and flag(memory, by_name[name])
    assert handled(messages) == [
        ("ALARM", 9, 4), ("ESTOP", 9, 0), ("m0", 5, -7), ("m0", 1, -7), ("m0", 3, -7), ("m1", 0, None)]
    assert not any(flag(memory, m) for m in found)
    assert handled(messages) == []


def test_a_queue_gives_one_a_scan_and_then_an_alarm() -> None:
    messages, found, memory = rig(user(0, "<i", depth=2))
    told = [messages.broadcast(found[-1], value) for value in (1, 2, 3)]
    assert told == [Outcome.WAITS, Outcome.WAITS, Outcome.REFUSED]
    assert handled(messages) == [("ALARM", 9, OVERFLOW | 0x40), ("m0", 0, 1)]
    assert flag(memory, found[-1])
    assert handled(messages) == [("m0", 0, 2)]
    assert not flag(memory, found[-1])


@pytest.mark.parametrize(("policy", "told", "value"), [
    ("overwrite", Outcome.REPLACED, 2), ("reject", Outcome.REFUSED, 1)])
def test_policies_for_a_second_broadcast(policy: str, told: Outcome, value: int) -> None:
    messages, found, _ = rig(user(0, "<i", policy, 1))
    assert messages.broadcast(found[-1], 1) is Outcome.WAITS
    assert messages.broadcast(found[-1], 2) is told
    calls = handled(messages)
    assert calls[-1] == ("m0", 0, value)
    assert (("ALARM", 9, OVERFLOW | 0x40) in calls) == (policy == "reject")
    assert handled(messages) == []


def test_too_many_alarms_make_no_alarms() -> None:
    messages, found, _ = rig()
    alarm = next(m for m in found if m.name == "ALARM")
    told = [messages.broadcast(alarm, n) for n in range(6)]
    assert told == [Outcome.WAITS] * 4 + [Outcome.REFUSED] * 2
    assert [handled(messages) for _ in range(5)] == [[("ALARM", 9, n)] for n in range(4)] + [[]]


def test_without_a_subscriber_the_flag_is_cleared() -> None:
    messages, found, memory = rig(user(0, subscribers=()))
    messages.broadcast(found[-1])
    assert flag(memory, found[-1]) and handled(messages) == [] and not flag(memory, found[-1])


def test_what_a_subscriber_broadcasts_is_handled_in_the_next_scan() -> None:
    messages, found, _ = rig(user(0), user(1), user(2, "<i"))
    first, second, itself = found[-3:]
    log = []

    def call(message: Message, subscriber: Subscriber, value: object) -> None:
        log.append((message.name, value))
        if message is second:
            messages.broadcast(first)
        if message is itself and value < 3:
            messages.broadcast(itself, value + 1)

    messages.broadcast(second)
    messages.broadcast(itself, 1)
    scans = []
    for _ in range(4):
        messages.handle(call)
        scans.append(log)
        log = []
    assert scans == [[("m1", None), ("m2", 1)], [("m0", None), ("m2", 2)], [("m2", 3)], []]


def test_an_edge_broadcasts_once_and_is_known_after_a_clear() -> None:
    messages, found, memory = rig(user(0))
    m = found[-1]
    levels = (False, True, True, False, True)
    assert [messages.rises(m, now) for now in levels] == [False, True, False, False, True]
    messages.broadcast(m)
    messages.clear()
    assert handled(messages) == [] and not messages.rises(m, True)
    again = Messages(memory, found)  # after a change of the program the words are the same
    assert not again.rises(m, True)


def test_what_waits_survives_a_change_of_messages_around_it() -> None:
    messages, found, memory = rig(user(0, "<d"), user(1, "<i"), user(2))
    first, kept, gone = found[-3:]
    for value in (1, 2, 3):
        messages.broadcast(kept, value)
    messages.broadcast(first, 0.5)
    messages.broadcast(gone)
    assert messages.rises(kept, True) and handled(messages) == [("m0", 0, 0.5), ("m1", 0, 1), ("m2", 0, None)]
    messages.broadcast(gone)
    renumbered = replace(kept, number=0, depth=2, subscribers=(Subscriber(7),))
    after = placed_messages((*found[:7], renumbered, replace(first, number=1, form="<f")))
    new = Messages(memory, after)
    new.take_over(messages)
    assert not new.rises(after[-2], True)
    assert [flag(memory, m) for m in after[-2:]] == [True, False] and not flag(memory, gone)
    assert [handled(new) for _ in range(3)] == [[("m1", 7, 2)], [("m1", 7, 3)], []]


class Model:
    """M by deques: what waits, and what is called."""

    def __init__(self, users: list[Message]) -> None:
        self.waiting = {m.name: deque() for m in (*users, *system_messages())}

    def broadcast(self, m: Message, value: object) -> None:
        queue = self.waiting[m.name]
        if len(queue) < (m.depth if m.policy == "queue" else 1):
            queue.append(value)
        elif m.policy == "overwrite":
            queue[-1] = value
        elif m.name != "ALARM":
            alarm = next(a for a in system_messages() if a.name == "ALARM")
            self.broadcast(alarm, OVERFLOW | 0x40 + m.number)


rows = st.lists(
    st.tuples(st.sampled_from([None, "<i", "<q"]), st.sampled_from(["queue", "overwrite", "reject"]),
              st.integers(1, 4), st.integers(0, 3)),
    min_size=1, max_size=5)
# An action: broadcast a message with a value, or (None) run C.MSG; callbacks of a message broadcast others.
actions = st.lists(st.one_of(st.none(), st.tuples(st.integers(0, 4), st.integers(-9, 9))), max_size=40)
answers = st.dictionaries(st.integers(0, 4), st.lists(st.integers(0, 4), max_size=3), max_size=3)


@given(rows, actions, answers)
def test_random_broadcasts_are_handled_as_the_model_says(rows, actions, answers) -> None:
    users = [user(n, form, policy, depth, tuple(Subscriber(s) for s in range(count)))
             for n, (form, policy, depth, count) in enumerate(rows)]
    messages, found, memory = rig(*users)
    real = {m.name: m for m in found}
    model, log, expected = Model(users), [], []

    def value_of(m: Message, value: int) -> int | None:
        return value if m.form else None

    def tell(number: int, value: int, to_model: bool) -> None:
        if number < len(users):
            m = users[number]
            if to_model:
                model.broadcast(m, value_of(m, value))
            else:
                messages.broadcast(real[m.name], value_of(m, value))

    def call(message: Message, subscriber: Subscriber, value: object) -> None:
        log.append((message.name, subscriber.module, value))
        if not message.system:
            for other in answers.get(message.number, ()):
                tell(other, subscriber.module, False)

    for action in [*actions, *[None] * 6]:
        if action is not None:
            tell(*action, False)
            tell(*action, True)
            continue
        messages.handle(call)
        turn = [(m, model.waiting[m.name].popleft()) for m in found if model.waiting[m.name]]
        for m, value in turn:
            for subscriber in m.subscribers:
                expected.append((m.name, subscriber.module, value))
                if not m.system:
                    for other in answers.get(m.number, ()):
                        tell(other, subscriber.module, True)
        assert log == expected
        assert [flag(memory, m) for m in found] == [bool(model.waiting[m.name]) for m in found]
