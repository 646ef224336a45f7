"""An algorithm of a slave with its link: what is known of it, and its words in the memory of the slave."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from typing import TYPE_CHECKING

from ldc.il.areas import areas
from ldc.il.placement import Placed, PlacedPin
from runtime.field import Field
from runtime.processors.states import Algorithm as State
from runtime.protocol.check import Algorithm as Parameters
from runtime.protocol.check import Parameter, Situation
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.memory import Memory, bit
from runtime.slave.algorithm import Maker

if TYPE_CHECKING:
    from runtime.retain import Leaf

_F32 = 3.4028235677973366e38
"""From here on a number is infinite when it is rounded to 32 bits."""

_CODES = {"f32": "f", "i32": "i", "u32": "I", "bool32": "I"}

_AFE, _AFS, _AD = bit(areas()["AFE"].base)[0], areas()["AFS"].base, areas()["AD"].base


def of_p(aid: int, pins: Iterable[PlacedPin]) -> Parameters:
    """What P knows of the pins of one direction."""
    return Parameters(aid, tuple(Parameter(p.pid, p.type, p.low, p.high) for p in pins))


class Slot:
    """``live``: it was started and has not ended; ``begun``: it has been executed since. ``due``, ``last``:
    when it is and was executed, in ns. ``seq``: the transfer
    whose parameters it has, ``fresh``: not in AD yet. ``faulty``: its IL came to a fault and is to be made
    anew. ``tell``: feedback is to go out, ``sent`` what went out last. ``leaves``: what it retains, when
    somebody has asked."""

    __slots__ = ("placed", "maker", "algorithm", "endpoint", "mask", "live", "begun", "due", "last",
                 "period_ns", "seq", "fresh", "state", "error", "faulty", "tell", "sent", "leaves", "_memory",
                 "_taken", "_fed", "_values", "_words", "_afs")

    def __init__(self, placed: Placed, maker: Maker, field: Field, endpoint: Endpoint, memory: Memory
                 ) -> None:
        self.placed, self.maker, self.endpoint, self.period_ns = placed, maker, endpoint, placed.period_ns
        self.algorithm = maker(placed, field)
        self.mask = 1 << placed.slot
        self.live = self.begun = self.fresh = self.faulty = self.tell = False
        self.due = self.last = self.seq = self.error = 0
        self.state = State.IDLE
        self.sent: tuple = ()
        self.leaves: tuple[Leaf, ...] | None = None
        self._memory, self._afs = memory, bit(_AFS + 2 * placed.slot)
        self._taken, self._fed = of_p(placed.aid, placed.parameters), of_p(placed.aid, placed.feedback)
        self._values: tuple[float, ...] = ()
        self._words = struct.Struct("=" + "".join(_CODES[p.type] for p in placed.parameters))
        self.enter(State.IDLE)

    def enter(self, state: State) -> None:
        """AFS, and what P is to know when it checks the next envelope."""
        self.state = state
        address, low = self._afs
        self._memory.bits.clear(address, 3 * low)
        self._memory.bits.set(address, state * low)
        aid, nothing = frozenset((self.placed.aid,)), frozenset()
        rested = not self.live and state in (State.DONE, State.ERROR)
        self.endpoint.situation = Situation({self.placed.aid: self._taken}, aid if self.live else nothing,
                                            ended=aid if rested else nothing)

    def execute_flag(self, on: bool) -> None:
        """AFE."""
        (self._memory.bits.set if on else self._memory.bits.clear)(_AFE, self.mask)

    def take(self, seq: int, values: tuple[float, ...]) -> None:
        """Parameters that P has taken by transfer ``seq`` wait for the next execution."""
        self._values, self.seq, self.fresh = values, seq, True

    def deframe(self) -> None:
        """They go into AD, and to the algorithm."""
        self.fresh = False
        self._memory.data.write(_AD + self.placed.ad, self._words.pack(*self._values))
        self.algorithm.take(self._values)

    def feedback(self) -> tuple[bool | int | float, ...] | None:
        """The outputs of now; None when one is a number that P does not send: none, or infinite."""
        values = self.algorithm.outputs()
        for n in self._fed.layout.floats:
            if not -_F32 < values[n] < _F32:
                return None
        return values

    def message(self, values: tuple[bool | int | float, ...]) -> bytes:
        """The data of a feedback with these outputs."""
        self.sent = values
        return self._fed.packed((*values, self.error, self.state))

    def goes_on(self, new: Placed, maker: Maker) -> bool:
        """Whether the algorithm of another placement is this one: same place, same pins, and
        everything that it executes the same."""
        was = self.placed
        return ((was.slot, was.aid, was.ad, was.unit.upper(), was.parameters, was.feedback, was.local) ==
                (new.slot, new.aid, new.ad, new.unit.upper(), new.parameters, new.feedback, new.local)
                and self.maker.same(maker))


def executing(memory: Memory) -> int:
    """AFE of a slave: the algorithms that execute, a bit a slot."""
    return memory.bits.load(_AFE)
