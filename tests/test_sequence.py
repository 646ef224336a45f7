"""L: frames, the four phases of a step, programs that are exchanged while one runs (SPEC 4)."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from ldc.il.areas import areas
from ldc.il.coordination import Module, Parameter, Sequence, Step, placed_modules
from ldc.types import DINT, LREAL, REAL
from runtime.master.frames import buffer, following, frames, parsed
from runtime.master.sequence import Customised, Exchanged, Phase, Refused, Started
from runtime.protocol.memory import Memory, allocate, bit, shared_size, watch

NAMES = ("clamp", "inject", "cool", "open", "eject")


def memory() -> Memory:
    return watch(allocate("master", bytearray(shared_size())))


class Rig:
    """A master's scan around L: modules end after a number of scans."""

    def __init__(self, sequence: Sequence | None = None) -> None:
        self.memory = memory()
        self.values: dict[str, bool] = {}
        self.customised = Customised(self.memory, self.reader)
        self.started: list[int] = []
        self.events: list = []
        self.left: dict[int, int] = {}
        self.scans_of = dict.fromkeys(range(256), 2)
        if sequence is not None:
            self.customised.stage(sequence)

    def reader(self, path: str):
        if path == "gone":
            raise LookupError(path)
        return lambda: self.values.get(path, False)

    def lcf(self, module: int) -> tuple[int, int]:
        return bit(areas()["LCF"].base + module)

    def scan(self, times: int = 1) -> None:
        for _ in range(times):
            for event in self.customised.control():
                self.events.append(event)
                if isinstance(event, Started):
                    assert self.memory.bits.test(*self.lcf(event.module))
                    self.started.append(event.module)
                    self.left[event.module] = self.scans_of[event.module]
            for module in list(self.left):
                self.left[module] -= 1
                if self.left[module] <= 0:
                    del self.left[module]
                    self.memory.bits.clear(*self.lcf(module))
            assert len(self.left) <= 1
            self.customised.execute()


def steps(*names: str) -> Sequence:
    return Sequence(tuple(Step(NAMES.index(name), name) for name in names))


def test_a_sequence_starts_its_modules_in_order_and_again() -> None:
    rig = Rig(steps("clamp", "inject", "cool"))
    rig.scan(20)
    assert rig.started == [0, 1, 2] * 3 + [0]
    assert rig.customised.cycles == 3


def test_a_module_that_ends_at_once_ends_its_step() -> None:
    rig = Rig(steps("clamp", "inject"))
    rig.scans_of = dict.fromkeys(range(256), 1)
    rig.scan(12)
    assert rig.started[:4] == [0, 1, 0, 1]


def test_conditions_hold_a_step_back_and_keep_it() -> None:
    rig = Rig(Sequence((Step(0, "clamp", when="ready", until="closed"), Step(1, "inject")), "auto", False))
    rig.scan(5)
    assert rig.customised.phase is Phase.IDLE
    rig.values["auto"] = True
    rig.scan(5)
    assert rig.started == [] and rig.customised.phase is Phase.NEXT
    rig.values["ready"] = True
    rig.scan(9)
    assert rig.started == [0] and rig.customised.phase is Phase.RUNNING
    rig.values["closed"] = True
    rig.scan(9)
    assert rig.started == [0, 1] and rig.customised.phase is Phase.DONE and rig.customised.cycles == 1
    rig.values["auto"] = False
    rig.scan()
    rig.values["auto"] = True
    rig.scan(3)
    assert rig.started == [0, 1, 0]


def test_parameters_are_in_lcd_when_the_module_starts() -> None:
    (module,) = placed_modules((Module(7, "clamp", "clamp.start", "clamp.done", (
        Parameter("stroke", "clamp.stroke", REAL, "<f", 0), Parameter("force", "clamp.force", LREAL, "<d", 0),
        Parameter("count", "clamp.count", DINT, "<i", 0))),))
    stroke, force, count = module.parameters
    assert (stroke.address, force.address, count.address) == (0x600, 0x604, 0x60C)
    rig = Rig(Sequence((Step(7, "clamp", ((count, -3), (force, 0.1))),)))
    rig.scan(3)
    assert Started(7, (0x60C, 0x604)) in rig.events
    data = rig.memory.data
    assert data.read(0x60C, 4) == (-3).to_bytes(4, "little", signed=True)
    assert data.read(0x600, 4) == bytes(4) and memoryview(data.read(0x604, 8)).cast("d")[0] == 0.1


def test_a_damaged_program_is_refused_and_the_old_one_goes_on() -> None:
    rig = Rig(steps("clamp", "inject"))
    rig.scan(4)
    generation = rig.customised.stage(steps("open"))
    address = buffer(0) + 16  # the first program is in buffer 1
    rig.memory.data.store(address, rig.memory.data.load(address) ^ 1)
    rig.scan(12)
    assert Refused(generation) in rig.events and set(rig.started) == {0, 1}


def test_a_program_handed_over_while_a_step_runs_begins_at_the_next_boundary() -> None:
    rig = Rig(steps("clamp", "inject"))
    rig.scans_of[0] = 10
    rig.scan(4)
    generation = rig.customised.stage(steps("clamp", "eject", "inject"))
    rig.scan(5)
    assert rig.started == [0] and rig.events == [Exchanged(1), Started(0, ())]
    rig.scan(12)
    assert rig.events[2] == Exchanged(generation) and rig.started[:3] == [0, 4, 1]


def test_a_program_without_waits_is_exchanged_too() -> None:
    rig = Rig(steps("clamp"))
    rig.scan(10)
    rig.customised.stage(steps("open"))
    rig.scan(10)
    assert rig.started[-1] == 3 and Exchanged(2) in rig.events


def test_an_empty_program_starts_nothing() -> None:
    rig = Rig(steps("clamp"))
    rig.scan(2)
    rig.customised.stage(Sequence(()))
    rig.scan(20)
    assert rig.started == [0] and rig.customised.phase is Phase.IDLE


def test_a_change_of_modules_keeps_the_step_that_runs() -> None:
    rig = Rig(steps("clamp", "inject"))
    rig.scans_of[0] = 6
    rig.scan(3)
    assert rig.customised.phase is Phase.RUNNING
    # A module is put before all others: clamp is module 1 now, and the master has moved its start bit.
    rig.memory.bits.clear(*rig.lcf(0))
    rig.memory.bits.set(*rig.lcf(1))
    rig.left = {1: rig.left[0]}
    rig.customised.change(Sequence((Step(0, "eject"), Step(1, "clamp"), Step(2, "inject"))),
                          {"EJECT": 0, "CLAMP": 1, "INJECT": 2}, rig.reader)
    rig.scan(2)
    assert rig.started == [0] and rig.customised.phase is Phase.RUNNING
    rig.scan(12)
    assert rig.started[:3] == [0, 2, 0]


def test_conditions_are_those_of_the_machine_that_is_bound() -> None:
    rig = Rig(Sequence((Step(0, "clamp", when="ready"),)))
    rig.scan(3)
    other = {"ready": True}
    rig.customised.bind(lambda path: lambda: other[path])
    rig.scan(2)
    assert rig.started == [0]


def test_a_step_whose_module_a_change_took_away_has_ended() -> None:
    rig = Rig(Sequence((Step(0, "clamp", until="gone-later"), Step(1, "inject"))))
    rig.scans_of[0] = 100
    rig.scan(4)
    rig.left.clear()

    def reader(path: str):
        raise LookupError(path)

    rig.customised.change(steps("clamp"), {"INJECT": 0}, reader)
    rig.scan()
    assert rig.customised.phase is not Phase.RUNNING


def test_an_offered_step_is_taken_back_by_a_change() -> None:
    rig = Rig(steps("clamp", "inject"))
    rig.customised.control()
    rig.customised.execute()
    assert rig.customised.phase is Phase.OFFERED
    rig.customised.change(steps("open"), {"OPEN": 3}, rig.reader)
    rig.scan(3)
    assert rig.started == [3]


def test_a_reset_begins_with_the_first_step() -> None:
    rig = Rig(steps("clamp", "inject"))
    rig.scan(4)
    assert rig.started == [0, 1]
    rig.customised.reset()
    rig.memory.bits.clear(*rig.lcf(1))
    rig.left.clear()
    rig.scan(3)
    assert rig.started == [0, 1, 0]
    assert rig.customised.cycles == 0


@given(st.lists(st.sampled_from(["control", "execute", "execute", "end"]), min_size=30, max_size=60))
def test_threads_may_run_as_often_as_they_like(turns: list[str]) -> None:
    """The four phases keep them together: every step is taken once, in order, and none while another runs."""
    rig = Rig(steps("clamp", "inject", "cool"))
    running: int | None = None
    for turn in turns:
        if turn == "execute":
            rig.customised.execute()
        elif turn == "end" and running is not None:
            rig.memory.bits.clear(*rig.lcf(running))
            running = None
        elif turn == "control":
            for event in rig.customised.control():
                if isinstance(event, Started):
                    assert running is None
                    running = event.module
                    rig.started.append(running)
    assert rig.started == [n % 3 for n in range(len(rig.started))]


programs = st.lists(st.sampled_from(NAMES), max_size=7).map(lambda names: steps(*names))


@given(programs, st.integers(0, 2**32 - 1))
def test_frames_come_back(program: Sequence, generation: int) -> None:
    data = memory().data
    data.write(buffer(1), frames(program, generation))
    assert [frame.module for frame in parsed(data, 1)] == [step.module for step in program.steps]


@given(programs, programs, st.data())
def test_what_follows_an_exchange(old: Sequence, new: Sequence, data) -> None:
    """The k-th step of a module is the same step in both; searched for here one by one, by counting."""
    ended = data.draw(st.integers(0, len(old.steps)))

    def find(place: int) -> int | None:
        name = old.steps[place].name
        turn = sum(step.name == name for step in old.steps[:place])
        same = [n for n, step in enumerate(new.steps) if step.name == name]
        return same[turn] if turn < len(same) else None

    found = following(old, ended, new)
    if ended == 0:
        assert found == 0
    elif (at := find(ended - 1)) is not None:
        assert found == at + 1
    else:
        rest = [at for place in range(ended, len(old.steps)) if (at := find(place)) is not None]
        assert found == (rest[0] if rest else len(new.steps))


@given(st.lists(st.tuples(programs.filter(lambda p: p.steps), st.integers(1, 9)), min_size=1, max_size=4),
       st.lists(st.integers(1, 4), min_size=5, max_size=5))
def test_random_exchanges_follow_the_model(plan: list[tuple[Sequence, int]], lengths: list[int]) -> None:
    """What is started is what a plain loop over the programs starts, when it is told at which boundaries the
    programs were exchanged; never two modules at once (the rig asserts it)."""
    rig = Rig()
    rig.scans_of = dict(enumerate(lengths))
    staged = {}
    for program, scans in plan:
        staged[rig.customised.stage(program)] = program
        rig.scan(scans)
    rig.scan(30)
    expected, current, at = [], Sequence(()), 0
    for event in rig.events:
        if isinstance(event, Exchanged):
            at = following(current, at, staged[event.generation]) % len(staged[event.generation].steps)
            current = staged[event.generation]
        else:
            expected.append(current.steps[at].module)
            at = (at + 1) % len(current.steps)
    assert rig.started == expected
    assert len(rig.started) > 2
    assert current == plan[-1][0]


def test_what_is_waited_for() -> None:
    steps = (Step(0, "clamp", (), "ready", "closed"), Step(1, "inject"))
    rig = Rig(Sequence(steps, "auto", repeat=False))

    def awaited():
        rig.scan()
        found = rig.customised.awaited
        return found and (found.number, found.module, found.path)

    assert awaited() == (0, "", "auto") == awaited()
    rig.values["auto"] = True
    before = rig.customised.moves
    assert awaited() == (1, "clamp", "ready") == awaited() and rig.customised.moves == before + 1
    rig.values["ready"] = True
    seen = [awaited() for _ in range(8)]
    assert (1, "clamp", "") in seen and seen[-1] == (1, "clamp", "closed")
    rig.values["closed"] = True
    seen = [awaited() for _ in range(12)]
    assert seen[0] == (2, "inject", "") and seen[-1] is None
