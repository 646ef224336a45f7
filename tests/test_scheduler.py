"""The scheduler: rule by rule, and at random against a model that goes nanosecond by nanosecond."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scheduler_model import Model, Spec

from runtime.scheduler.report import rows
from runtime.scheduler.scheduler import Scheduler
from runtime.scheduler.thread import LEVELS, Thread


def scheduler(processors: list[list[Spec]], log: list | None = None, done: list | None = None) -> Scheduler:
    """``done``: what begins is noted there, by threads that nobody logs."""
    def thread(spec: Spec) -> Thread:
        def work(now: int):
            if done is not None:
                done.append((now, spec))
            if spec.raises:
                made.raise_event(made.thread(*spec.raises))
            return iter(spec.costs) if spec.costs else None

        return Thread(spec.name, spec.kind, spec.period, work, spec.budget, spec.offset, spec.priority)

    made = Scheduler([[thread(spec) for spec in specs] for specs in processors], log)
    return made


def log_of(specs: list[Spec], until: int, events: dict[int, str] | None = None) -> list[tuple]:
    """The log of one processor, without its number; ``events``: time -> thread that one is raised for."""
    log: list = []
    made = scheduler([specs], log)
    for time, name in sorted((events or {}).items()):
        made.run(time)
        made.raise_event(made.thread(0, name))
    made.run(until)
    return [(e.time_ns, e.thread, e.what) for e in log]


# ---- at random

KINDS = tuple(LEVELS)


@st.composite
def machines(draw) -> tuple[list[list[Spec]], list[tuple[int, int, str]]]:
    """Processors, and events (time, processor, thread) from outside."""
    count = draw(st.integers(1, 3))
    processors: list[list[Spec]] = []
    for _ in range(count):
        specs = []
        for number in range(draw(st.integers(1, 4))):
            kind = draw(st.sampled_from(KINDS))
            customised = kind == "customised"
            if customised and not any(s.kind == "control" for s in specs):
                kind, customised = "control", False
            control = kind == "control"
            times = st.integers(1, 25)
            period = None if customised else draw(times if control else st.none() | times)
            costs = tuple(draw(st.lists(st.integers(0, 6), max_size=4)))
            specs.append(Spec(f"t{number}", kind, period, costs,
                              draw(st.integers(0, 5)), draw(st.integers(0, 2)) if control else 0,
                              draw(st.none() | st.integers(1, 5)) if customised else None))
        processors.append(specs)
    takers = [(at, s) for at, specs in enumerate(processors) for s in specs if s.kind != "customised"]
    # Who is raised by another raises nobody, or time might stand still.
    silent = [(at, s.name) for at, s in takers if draw(st.booleans())]
    for at, spec in takers:
        if (at, spec.name) not in silent and silent:
            spec.raises = draw(st.none() | st.sampled_from(silent))
    times = st.tuples(st.integers(0, 90), st.sampled_from([(at, s.name) for at, s in takers]))
    events = [(time, *taker) for time, taker in draw(st.lists(times, max_size=6))]
    return processors, sorted(events)


@settings(max_examples=400, deadline=None)
@given(machines())
def test_the_log_is_that_of_the_model(drawn) -> None:
    processors, events = drawn
    log: list = []
    made, model = scheduler(processors, log), Model(processors)
    for time, at, name in events:
        for one in (made, model):
            one.run(time)
        made.raise_event(made.thread(at, name))
        model.raise_event(at, name)
    for one in (made, model):
        one.run(100)
    assert [tuple(entry) for entry in log] == model.log
    for at, specs in enumerate(processors):
        for spec in specs:
            counts = made.thread(at, spec.name).counts
            said = [what for _, on, name, what in model.log if (on, name) == (at, spec.name)]
            kept = {"ended": counts.executions, "overrun": counts.overruns, "missed": counts.missed,
                    "preempted": counts.preemptions, "watchdog": counts.watchdogs, "lost": counts.lost}
            assert kept == {what: said.count(what) for what in kept}


@settings(max_examples=50, deadline=None)
@given(machines(), st.lists(st.integers(0, 100), max_size=8))
def test_where_a_run_is_cut_makes_no_difference(drawn, cuts) -> None:
    processors, _ = drawn
    whole: list = []
    scheduler(processors, whole).run(100)
    parts: list = []
    made = scheduler(processors, parts)
    for cut in [*sorted(cuts), 100]:
        made.run(cut)
        assert made.now_ns == cut
    assert parts == whole


@settings(max_examples=150, deadline=None)
@given(machines(), st.integers(0, 2), st.sampled_from([(), (2, 0, 3)]),
       st.sets(st.integers(0, 60), max_size=12), st.data())
def test_a_thread_that_is_released_first_does_as_from_the_queue(drawn, number, costs, times, data) -> None:
    processors, _ = drawn
    number %= len(processors)
    silent = [(at, s.name) for at, specs in enumerate(processors) for s in specs
              if s.kind != "customised" and not s.raises]
    raises = data.draw(st.sampled_from([None, *silent]))
    processors[number].append(Spec("extra", "algorithm", None, costs, raises=raises))
    found = []
    for first in (False, True):
        done: list = []
        made, left = scheduler(processors, done=done), sorted(times)
        extra = made.thread(number, "extra")
        while left:
            made.run(left[0])
            at = left.pop(0)
            if first and (made.next_ns is None or at < made.next_ns):
                assert made.release_first(extra) == (made.next_ns == at)
            else:
                made.release(extra)
        made.run(80)
        found.append((done, [rows("", threads, 80) for threads in made.threads]))
    assert found[0] == found[1]


# ---- rule by rule

def test_a_higher_level_preempts_between_two_pieces() -> None:
    specs = [Spec("control", "control", 100, (10, 10, 10)), Spec("stop", "emergency", None, (3,))]
    assert log_of(specs, 50, {14: "stop"}) == [
        (0, "control", "began"), (20, "control", "preempted"), (20, "stop", "began"), (23, "stop", "ended"),
        (23, "control", "resumed"), (33, "control", "ended")]


def test_an_event_in_the_last_piece_waits_for_its_end_and_preempts_nothing() -> None:
    specs = [Spec("control", "control", 100, (10,)), Spec("stop", "emergency", None, (3,))]
    assert log_of(specs, 50, {4: "stop"}) == [
        (0, "control", "began"), (10, "control", "ended"), (10, "stop", "began"), (13, "stop", "ended")]


def test_no_preemption_inside_a_level_and_visual_before_communication() -> None:
    specs = [Spec("link", "communication", None, (5, 5)), Spec("camera", "visual", None, (2,)),
             Spec("poll", "communication", None, (1,))]
    assert log_of(specs, 50, {0: "link", 2: "poll", 4: "camera"}) == [
        (0, "link", "began"), (10, "link", "ended"), (10, "camera", "began"), (12, "camera", "ended"),
        (12, "poll", "began"), (13, "poll", "ended")]


def test_tasks_of_one_level_preempt_each_other_by_priority() -> None:
    specs = [Spec("slow", "control", 40, (10, 10)), Spec("fast", "control", 40, (1,), offset=5, priority=0)]
    specs[0].priority = 1
    assert [entry[1:] for entry in log_of(specs, 30)] == [
        ("slow", "began"), ("slow", "preempted"), ("fast", "began"), ("fast", "ended"), ("slow", "resumed"),
        ("slow", "ended")]


def test_equal_periods_go_by_id_shorter_ones_first() -> None:
    specs = [Spec("a", "control", 20), Spec("b", "control", 10), Spec("c", "control", 10)]
    assert [name for time, name, what in log_of(specs, 20) if what == "began"] == ["b", "c", "a", "b", "c"]


def test_an_overrun_ends_and_misses_its_period_and_three_in_a_row_call_the_watchdog() -> None:
    came: list[int] = []
    thread = Thread("control", "control", 10, lambda now: iter((12,)), on_watchdog=came.append)
    log: list = []
    made = Scheduler([[thread]], log)
    made.run(45)
    assert [(e.time_ns, e.what) for e in log] == [
        (0, "began"), (10, "overrun"), (10, "missed"), (12, "ended"),
        (20, "began"), (30, "overrun"), (30, "missed"), (32, "ended"), (40, "began")]
    made.run(51)
    assert came == [50] and [e.what for e in log[-3:]] == ["overrun", "missed", "watchdog"]


def test_one_execution_in_time_forgives_earlier_overruns() -> None:
    lasts = iter((12, 12, 5, 12, 12, 5))
    thread = Thread("control", "control", 10, lambda now: iter((next(lasts, 1),)))
    Scheduler([[thread]]).run(200)
    assert thread.counts.overruns == 4 and thread.counts.watchdogs == 0


def test_an_execution_that_never_ends_calls_the_watchdog_too() -> None:
    thread = Thread("control", "control", 10, lambda now: iter((1000,)))
    Scheduler([[thread]]).run(31)
    assert thread.counts.overruns == 1 and thread.counts.missed == 3 and thread.counts.watchdogs == 1


def test_an_execution_that_ends_when_its_next_period_begins_is_in_time() -> None:
    fast, slow = Spec("fast", "control", 10, (5,)), Spec("slow", "control", 20, (5, 5), priority=1)
    log = log_of([fast, slow], 200)
    assert not any(what in ("overrun", "missed") for _, _, what in log)
    assert (20, "slow", "ended") in log


def test_the_customised_thread_gets_thirty_percent_of_the_slack() -> None:
    # Slack 80, of which 24: three pieces of 10 (the third begins within the budget), 6 too much. The next
    # scan gives 24 - 6 = 18: two pieces, 2 too much; then 22: the last two pieces.
    specs = [Spec("control", "control", 100, (20,)), Spec("program", "customised", None, (10,) * 7)]
    assert [entry for entry in log_of(specs, 300) if entry[1] == "program"] == [
        (20, "program", "began"), (50, "program", "paused"), (120, "program", "resumed"),
        (140, "program", "paused"), (220, "program", "resumed"), (240, "program", "ended")]


def test_the_budget_of_a_customised_thread_bounds_its_share() -> None:
    specs = [Spec("control", "control", 100, (20,)), Spec("program", "customised", None, (1,) * 9, budget=3)]
    ran = [entry for entry in log_of(specs, 300) if entry[1] == "program"]
    assert ran == [(20, "program", "began"), (23, "program", "paused"), (120, "program", "resumed"),
                   (123, "program", "paused"), (220, "program", "resumed"), (223, "program", "ended")]


def test_no_slack_no_customised_thread() -> None:
    specs = [Spec("control", "control", 10, (10,)), Spec("program", "customised", None, (1,))]
    assert not [entry for entry in log_of(specs, 100) if entry[1] == "program"]


def test_diagnostics_execute_when_nothing_else_is_ready() -> None:
    specs = [Spec("diagnostics", "diagnostics", 50, (4, 4)), Spec("control", "control", 10, (9,))]
    ran = [entry for entry in log_of(specs, 30) if entry[1] == "diagnostics"]
    assert ran == [(9, "diagnostics", "began"), (13, "diagnostics", "preempted"),
                   (22, "diagnostics", "resumed"), (26, "diagnostics", "ended")]


def test_one_further_event_waits_and_others_are_counted() -> None:
    specs = [Spec("frame", "visual", None, (10,))]
    log = log_of(specs, 50, {0: "frame", 2: "frame", 4: "frame", 6: "frame"})
    assert [what for _, _, what in log] == ["began", "lost", "lost", "ended", "began", "ended"]
    assert log[-1][0] == 20


def test_an_event_and_a_period_of_one_instant_are_one_activation() -> None:
    assert log_of([Spec("link", "communication", 10)], 15, {10: "link"}) == [
        (0, "link", "began"), (0, "link", "ended"), (10, "link", "began"), (10, "link", "ended")]


def test_processors_run_side_by_side_and_wake_each_other_in_the_same_instant() -> None:
    log: list = []
    processors = [[Spec("in", "communication", None, (2,))],
                  [Spec("algorithm", "algorithm", 10, (4,), raises=(0, "in"))]]
    scheduler(processors, log).run(10)
    assert [tuple(e) for e in log] == [
        (0, 1, "algorithm", "began"), (0, 0, "in", "began"), (2, 0, "in", "ended"),
        (4, 1, "algorithm", "ended")]


def test_a_generator_of_pieces_executes_what_follows_a_piece_when_it_is_over() -> None:
    seen = []

    def work(now: int):
        seen.append(("first", made.now_ns))
        yield 5
        seen.append(("second", made.now_ns))
        yield 7
        seen.append(("after", made.now_ns))

    made = Scheduler([[Thread("control", "control", 100, work)]])
    made.run(50)
    assert seen == [("first", 0), ("second", 5), ("after", 12)]
    assert made.next_ns == 100


def test_figures_of_a_run() -> None:
    made = scheduler([[Spec("fast", "control", 10, (2,)), Spec("slow", "control", 20, (3,) * 4, priority=1)]])
    made.run(40)
    fast, slow = rows("master", (made.thread(0, "fast"), made.thread(0, "slow")), made.now_ns)
    assert (fast.executions, fast.response_worst_us, fast.jitter_us) == (4, 0.003, 0.001)
    assert (slow.executions, slow.preemptions, slow.response_mean_us) == (2, 2, 0.016)
    assert fast.utilisation_percent == 20.0 and slow.utilisation_percent == 60.0


def test_a_piece_that_goes_on_counts_as_far_as_it_went() -> None:
    made = scheduler([[Spec("long", "control", 100, (1000,))]])
    made.run(50)
    (row,) = rows("master", made.threads[0], made.now_ns)
    assert row.utilisation_percent == 100.0 and row.executions == 0


@pytest.mark.parametrize("wrong", [
    lambda: Thread("t", "motion", 10, iter), lambda: Thread("t", "control", 0, iter),
    lambda: Thread("t", "customised", 10, iter), lambda: Thread("t", "control", 10, iter, priority=1 << 16),
    lambda: Scheduler([[Thread("t", "control", 10, iter), Thread("t", "control", 10, iter)]]),
    lambda: Scheduler([[Thread("t", "control", 10, lambda now: iter((-1,)))]]).run(1),
    lambda: Scheduler([[]]).raise_event(Thread("t", "customised", None, iter))])
def test_what_is_no_thread_is_refused(wrong) -> None:
    with pytest.raises(ValueError):
        wrong()
