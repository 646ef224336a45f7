"""The machines of p_handshake.c as those of ``protocol_model``: one access to shared memory a step."""

from __future__ import annotations

import math
import struct
import subprocess
from pathlib import Path
from typing import NamedTuple

import cffi
from protocol_model import AID, ALGORITHM, DONE, SIZE

from ldc.components import toolchain
from runtime.protocol.check import adata_of

HERE = Path(__file__).resolve().parent
ROOM = HERE.parent / "ldc" / "backends" / "firmware" / "runtime"
HEADERS = ("p_handshake.h", "p_parameters.h")

_STEPS = """
typedef struct { uint32_t count, values[32]; } t_replay;
void t_retries(uint32_t most);
int32_t t_step(uint32_t what, void *machine, uint8_t *state, uint32_t size, t_replay *done, uint32_t aid,
               const uint8_t *data, uint32_t len, uint32_t elapsed);
"""
_SEND, _RESET, _RECEIVE, _SCRUB = range(4)
_IDLE, _FAULT, _INSIDE, _DONE = 0, 9, -3, 0


def declarations() -> str:
    """What the headers declare, for cffi."""
    lines = []
    for header in HEADERS:
        lines += [line for line in (ROOM / header).read_text().splitlines() if not line.startswith("#")]
    return "\n".join(lines)


def compiled(folder: Path, *sources: Path) -> Path:
    """A shared object of the sources, in ``folder``, where other versions of what they include may lie."""
    target = folder / "p.so"
    flags = "-std=c11 -O2 -Wall -Wextra -Werror -fPIC -shared".split()
    subprocess.run([toolchain.find(toolchain.GCC), *flags, "-I", str(folder), "-I", str(ROOM), "-o",
                    str(target), *map(str, sources)], check=True)
    return target


def stepped(folder: Path) -> Path:
    """The library of ``Steps``."""
    return compiled(folder, HERE / "p_steps.c", ROOM / "p_parameters.c")


class State(NamedTuple):
    """``call``: what the owner calls until it is over; ``machine``: its bytes at the begin of the step in
    work, ``patient``: in which a wait is not taken for too long; ``accesses``: those that the step has made,
    and what was read."""

    machine: bytes
    call: int
    data: bytes = b""
    patient: bool = True
    accesses: tuple[int, ...] = ()


class Steps:
    """The library, over one channel whose words are those of ``protocol_model.Memory``."""

    def __init__(self, library: Path, retries: int = 2) -> None:
        self.ffi = ffi = cffi.FFI()
        ffi.cdef(declarations() + _STEPS)
        self.lib = ffi.dlopen(str(library))
        self.lib.t_retries(retries)
        self.words = ffi.new("uint32_t[]", 8 + SIZE // 4)
        self._view = ffi.buffer(self.words)
        names = dict(begin=0, running=1, busy=3, ack=4, nack=5, status=6, last=7, slot=8)
        self.channel = ffi.new("p_channel *", {
            **{name: self.words + at for name, at in names.items()}, "size": SIZE, "mask": 1})
        self.replay = ffi.new("t_replay *")

    def made(self, kind: str, more: int = 0):
        """A machine and the bytes of it and of ``more`` bytes behind it."""
        size = self.ffi.sizeof(kind) + more
        place = self.ffi.new("uint8_t[]", size)
        return self.ffi.cast(f"{kind} *", place), place, self.ffi.buffer(place)

    def step(self, state: State, words: tuple, machine, place, view) -> tuple[State, tuple, int]:
        """The next access: the state and the words after it, and what the step returns."""
        view[:], self._view[:] = state.machine, struct.pack(f"<8I{SIZE}s", *words)
        accesses, replay = state.accesses, self.replay
        replay.count = len(accesses)
        replay.values[0:len(accesses)] = accesses
        result = self.lib.t_step(state.call, machine, place, len(view), replay, AID, state.data,
                                 len(state.data), 0 if state.patient else 2)
        after = struct.unpack(f"<8I{SIZE}s", self._view)
        if result == _INSIDE:
            made = tuple(replay.values[0:replay.count])
            return state._replace(accesses=made), after, result
        return state._replace(machine=bytes(view), patient=True, accesses=()), after, result


class Sends:
    def __init__(self, steps: Steps) -> None:
        self.steps = steps
        self._machine = steps.made("p_sender")
        sender = self._machine[0]
        sender.channel, sender.patience = steps.channel, 1
        self.start = State(bytes(self._machine[2]), _SEND)

    def _phase(self, state: State) -> int:
        self._machine[2][:] = state.machine
        return self._machine[0].step

    def ready(self, state: State) -> bool:
        return not state.data and self._phase(state) == _IDLE and state.call == _SEND

    def failed(self, state: State) -> bool:
        return not state.data and self._phase(state) == _FAULT and state.call == _SEND

    def submit(self, state: State, value: int) -> State:
        return state._replace(data=adata_of({1: value}, ALGORITHM))

    def reset(self, state: State) -> State:
        return state._replace(call=_RESET)

    def step(self, state: State, words: tuple) -> tuple[State, tuple, str | bool | None]:
        if self.failed(state):
            return state, words, None
        after, words, result = self.steps.step(state, words, *self._machine)
        if result < 0:
            return after, words, None
        told = None
        if result == _DONE:
            told = DONE if state.call == _SEND else bool(self._machine[0].delivered)
        return after._replace(call=_SEND, data=b""), words, told

    def late(self, state: State, words: tuple) -> tuple[State, tuple, str | bool | None] | None:
        if state.accesses or not state.data and state.call == _SEND:
            return None
        return self.step(state._replace(patient=False), words)


class Receives:
    def __init__(self, steps: Steps) -> None:
        ffi = steps.ffi
        self.steps = steps
        self._machine = receiver, place, view = steps.made("p_receiver", 2 * SIZE)
        self._parameters = ffi.new("p_parameter[]", [
            {"pid": 1, "type": 1, "min": -math.inf, "max": math.inf, "rate": math.inf}])
        self._algorithm = ffi.new("p_algorithm *", {
            "aid": AID, "count": 1, "parameters": self._parameters, "running": 1})
        receiver.channel, receiver.algorithms, receiver.count = steps.channel, self._algorithm, 1
        receiver.judge = steps.lib.p_judge
        receiver.frame = place + ffi.sizeof("p_receiver")
        receiver.data = receiver.frame + SIZE
        self.start = State(bytes(view), _RECEIVE)

    def step(self, state: State, words: tuple) -> tuple[State, tuple, int | None]:
        after, words, result = self.steps.step(state, words, *self._machine)
        if result != _INSIDE:
            after = after._replace(call=_RECEIVE)
        return after, words, self._value() if result == _DONE and self._is_data() else None

    def holds(self, state: State) -> int | None:
        """What S2 has taken is given to the owner in S5."""
        self._machine[2][:] = state.machine
        receiver = self._machine[0]
        return self._value() if receiver.fresh and receiver.step > 1 and self._is_data() else None

    def _is_data(self) -> bool:
        return self._machine[0].envelope.cmd != self.steps.lib.P_RESET

    def _value(self) -> int:
        return struct.unpack("<i", self.steps.ffi.buffer(self._machine[0].data + 4, 4))[0]

    def scrub(self, state: State) -> State:
        return state if state.accesses else state._replace(call=_SCRUB)
