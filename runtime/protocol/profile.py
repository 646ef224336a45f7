"""The sequences U* and I* as data, and the words that one direction of one slot uses (SPEC 1.3, 2.3).

A sender begins with ``opening``, waits for an answer and ends with ``closing``. A receiver begins when
``running`` is 1 and ``begin`` is ``ready``; after its answer it does ``answered``, waits for ``released`` to
be 0 and does ``rest``. The names of flags are those of ``Channel``.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.il.areas import SLAVES, areas
from ldc.records import record
from runtime.protocol.envelope import HEAD

SET, CLEAR, COPY = "set", "clear", "copy"

SLOTS = 32
"""Slots of one direction: a word of flags has a bit for each."""

Script = tuple[tuple[str, str], ...]


@record
class Profile:
    """``settled``: the answer counts when ``busy`` is 0 again."""

    name: str
    opening: Script
    closing: Script
    ready: bool
    settled: bool
    answered: Script
    released: tuple[str, ...]
    rest: Script


U_STAR = Profile(
    name="U*",
    opening=((SET, "begin"), (SET, "running"), (COPY, "slot"), (CLEAR, "begin")),
    closing=((CLEAR, "running"),),
    ready=False,
    settled=True,
    answered=((CLEAR, "busy"),),
    released=("running",),
    rest=((CLEAR, "ack"), (CLEAR, "nack")),
)

I_STAR = Profile(
    name="I*",
    opening=((SET, "begin"), (COPY, "slot"), (SET, "running")),
    closing=((SET, "order"), (CLEAR, "begin"), (CLEAR, "running"), (CLEAR, "order")),
    ready=True,
    settled=False,
    answered=(),
    released=("begin", "running", "order"),
    rest=((CLEAR, "busy"), (CLEAR, "ack"), (CLEAR, "nack")),
)

WITHDRAW: Script = ((CLEAR, "begin"), (CLEAR, "running"), (CLEAR, "order"))
"""How a sender gives up: all its flags 0."""

SCRUB: Script = ((CLEAR, "busy"), (CLEAR, "ack"), (CLEAR, "nack"))
"""What a receiver at rest makes sure of from time to time."""

_WORD = {"begin": 0, "running": 4, "ack": 8, "busy": 12, "nack": 16, "order": 24}
"""Byte offsets in MPF and SPF: those of the sender in its own, those of the receiver in the other (SPEC
1.3)."""

_OF_SENDER = ("begin", "running", "order")


@record
class Channel:
    """Addresses of one direction of one slot. ``mask``: its bit in the words of flags.

    The sender writes ``begin``, ``running``, ``order`` and the slot; the receiver ``busy``, ``ack``,
    ``nack``, ``status`` (code in the lowest 8 bits, above it the ``token`` of the envelope that is answered)
    and ``last`` (the number that was taken last before a RESET). From master to slave these are msb, msf, msc
    and sms, sma, sna; the other way smb, smf, smc and mss, msa, mna.
    """

    begin: int
    running: int
    order: int
    busy: int
    ack: int
    nack: int
    status: int
    last: int
    slot: int
    size: int
    mask: int


def channel(slave: int, to_slave: bool, index: int = 0, size: int = 128) -> Channel:
    """The direction master to slave or back, of slave 1 .. 4, in slot ``index`` of slots of ``size`` bytes.

    Raises ValueError when there is no such slot.
    """
    name = ("MPF", "SPF", "SPA", "SMD") if to_slave else ("SPF", "MPF", "MPA", "MSD")
    sender, receiver, answer, data = (areas()[n] for n in name)
    if not 1 <= slave <= SLAVES or size % 4 or size < HEAD:
        raise ValueError(f"slave {slave} of {SLAVES}, slots of {size} bytes")
    if not 0 <= index < min(SLOTS, data.size // size):
        raise ValueError(f"{data.name} has no slot {index} of {size} bytes")
    flags = {
        flag: (sender if flag in _OF_SENDER else receiver).first(slave) + at for flag, at in _WORD.items()}
    status = answer.first(slave) + 8 * index
    return Channel(**flags, status=status, last=status + 4, slot=data.first(slave) + size * index,
                   size=size, mask=1 << index)


Steps = tuple[tuple[str, int], ...]
"""A script with the addresses of its flags."""


@dataclass(frozen=True, slots=True)
class Link:
    """One direction of one slot with its limits.

    ``retries``: attempts after the first. ``ack_periods``: calls of ``tick`` until a missing answer is a
    failure (T_ack), ``clear_periods``: until flags of the receiver that stay 1 are (T_clr). ``chunk``: bytes
    that one step copies, a multiple of 4. The further members are the profile's, with addresses.
    """

    channel: Channel
    profile: Profile = U_STAR
    retries: int = 2
    ack_periods: int = 5
    clear_periods: int = 5
    chunk: int = 4096
    opening: Steps = field(init=False, repr=False, compare=False)
    closing: Steps = field(init=False, repr=False, compare=False)
    withdraw: Steps = field(init=False, repr=False, compare=False)
    answered: Steps = field(init=False, repr=False, compare=False)
    rest: Steps = field(init=False, repr=False, compare=False)
    scrub: Steps = field(init=False, repr=False, compare=False)
    answer: tuple[int, ...] = field(init=False, repr=False, compare=False)
    quiet: tuple[int, ...] = field(init=False, repr=False, compare=False)
    released: tuple[int, ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        p, c = self.profile, self.channel
        scripts = {"opening": p.opening, "closing": p.closing, "withdraw": WITHDRAW,
                   "answered": p.answered, "rest": p.rest, "scrub": SCRUB}
        bound = {n: tuple((kind, getattr(c, flag)) for kind, flag in s) for n, s in scripts.items()}
        bound |= {"answer": (c.ack, c.nack), "quiet": (c.ack, c.nack, c.busy),
                  "released": tuple(getattr(c, f) for f in p.released)}
        for name, value in bound.items():
            object.__setattr__(self, name, value)
