"""A slave on a bench: projects of algorithms, and a master by hand that talks to them over P.

Every access to memory is checked (single writer), every millisecond is a snapshot for the invariants.
"""

from __future__ import annotations

from pathlib import Path

from ldc import pipeline
from ldc.cli.compiling import native_code
from ldc.il.placement import Placed, placed, points
from runtime.field import Field, field_size
from runtime.processors.invariants import Snapshot, violations
from runtime.processors.states import Master
from runtime.protocol.check import Situation, adata_of
from runtime.protocol.endpoint import Endpoint
from runtime.protocol.envelope import Command
from runtime.protocol.memory import allocate, shared_size, watch
from runtime.protocol.profile import Link, channel
from runtime.protocol.receiver import Delivered
from runtime.slave.algorithm import makers
from runtime.slave.part import SlavePart
from runtime.slave.slot import of_p

MS = 1_000_000

AXIS = """\
[component]
name = "AXIS"
id = "test.axis"
[requires]
inputs = [
    { name = "target", type = "REAL", min = 0.0, max = 400.0 },
    { name = "measured", type = "REAL", min = -10.0, max = 500.0, local = true },
]
[provides]
power = "arrived"
outputs = [
    { name = "arrived", type = "BOOL" },
    { name = "position", type = "REAL" },
    { name = "speed_out", type = "REAL", value = 0.5, local = true },
    { name = "us", type = "UDINT" },
]
[properties]
parameters = [{ name = "limit", type = "LREAL", value = 100.0, min = 1.0, max = 1000.0 }]
state = [{ name = "moved", type = "REAL" }]
[function]
language = "LANGUAGE"
sources = ["axis.SUFFIX"]
processor = "slave1"
period_us = 1000
"""

BODIES = {
    "c": """\
#include "axis.h"
void axis(const axis_in *in, axis_out *out, axis_state *state, uint32_t dt_us)
{
    float most = (float)in->limit * (float)dt_us * 1e-6f;
    float rest = (in->enable ? in->target : 0.0f) - out->position;
    rest = rest > most ? most : rest < -most ? -most : rest;
    out->position += rest;
    state->moved += rest < 0.0f ? -rest : rest;
    out->speed_out = dt_us ? rest / ((float)dt_us * 1e-6f) : 0.0f;
    out->arrived = in->enable && out->position == in->target;
    out->us = dt_us;
    if (in->measured > 400.0f)
        out->error = 20;
    if (in->measured < -5.0f)
        out->position = out->position / 0.0f;
}
""",
    "st": """\
FUNCTION_BLOCK AXIS
VAR_TEMP
    most, rest : REAL;
END_VAR
    most := LREAL_TO_REAL(limit) * TIME_TO_REAL(elapsed) * 0.001;
    rest := LIMIT(-most, SEL(enable, 0.0, target) - position, most);
    position := position + rest;
    moved := moved + ABS(rest);
    us := TIME_TO_UDINT(elapsed) * 1000;
    IF us > 0 THEN speed_out := rest / TIME_TO_REAL(elapsed) * 1000.0; ELSE speed_out := 0.0; END_IF;
    arrived := enable AND position = target;
    IF measured > 400.0 THEN error := 20; END_IF;
    IF measured < -5.0 THEN us := us / REAL_TO_UDINT(position - position); END_IF;
END_FUNCTION_BLOCK
""",
}

MAIN = """\
PROGRAM main
VAR
    go AT %IX0.0 : BOOL;
    lamp AT %QX0.0 : BOOL;
    axis : AXIS;
    pos : REAL;
END_VAR
RUNG [go] <axis: AXIS(target := 2.0, position => pos)> (lamp)
END_PROGRAM
"""


def write(folder: Path, language: str = "c", main: str = MAIN, slaves: int = 1, **files: str) -> Path:
    """A project with the axis in a language, and further files."""
    names = "".join(f'slave{n} = "slave"\n' for n in range(1, slaves + 1))
    (folder / "ldc.toml").write_text(f'[project]\nname = "rig"\n[processors]\nmaster = "master"\n{names}')
    descriptor = AXIS.replace("LANGUAGE", language).replace("SUFFIX", language)
    (folder / "axis.ldc.toml").write_text(descriptor)
    (folder / f"axis.{language}").write_text(BODIES[language])
    (folder / "main.ld").write_text(main)
    for name, text in files.items():
        (folder / name.replace("__", ".")).write_text(text)
    return folder


def compiled(folder: Path, **options: object) -> pipeline.Compiled:
    result = pipeline.compile_paths([str(folder)], pipeline.Options(**options))
    assert not result.diagnostics.has_errors, [d.message for d in result.diagnostics]
    return result


class MasterEnd:
    """The master's end of the slot of one algorithm."""

    def __init__(self, shared, p: Placed) -> None:
        self.placed = p
        self.taken, self.fed = of_p(p.aid, p.parameters), of_p(p.aid, p.feedback)
        out, into = (Link(channel(p.slave, to_slave, p.slot, p.size)) for to_slave in (True, False))
        self.end = Endpoint(shared, out, into, Situation({p.aid: self.fed}, frozenset((p.aid,))))
        self.told: list[dict[str, object]] = []
        self.events: list[object] = []

    def poll(self) -> None:
        for event in self.end.poll():
            if isinstance(event, Delivered) and event.envelope.cmd != Command.RESET:
                names = (p.name for p in self.placed.feedback)
                self.told.append(dict(zip(names, event.values, strict=True)))
            else:
                self.events.append(event)


class Rig:
    """The slaves of a compiled project, their field, and a master's end of every slot. ``units`` and
    ``trace``: what they noted; ``now``: the time in ns."""

    def __init__(self, result: pipeline.Compiled, scan_ms: int = 1) -> None:
        program = result.program
        self.placed = placed(program)
        self.makers = makers(program, native_code(result))
        where = points(program, self.placed)
        self.field = Field(bytearray(field_size(where)), where)
        shared = bytearray(shared_size())
        self.now, self.trace, self.units = 0, [], []
        self.master = watch(allocate("master", shared), self.trace.append)
        numbers = sorted({p.slave for p in self.placed})
        self.slaves = [
            SlavePart(n, watch(allocate(f"slave{n}", shared), self._seen), self.placed, self.makers,
                      self.field, self.units.append, lambda: self.now, seen=self.trace.append,
                      scan_ns=scan_ms * MS)
            for n in numbers]
        self.links = {p.path: MasterEnd(self.master.shared, p) for p in self.placed}

    def _seen(self, access) -> None:
        if access.area not in ("AFE", "AFS", "AD"):  # words of one processor alone
            self.trace.append(access)

    def send(self, path: str, command: Command, **values: object) -> None:
        link = self.links[path]
        data = {p.pid: values[p.name] for p in link.placed.parameters} if values else {}
        link.end.send(link.placed.aid, command, adata_of(data, link.taken) if values else b"")

    def run(self, milliseconds: int) -> None:
        for _ in range(milliseconds):
            self.talk()
            for slave in self.slaves:
                slave.execute()
            self.talk()
            states, executing = zip(*((s.state, s.executing) for s in self.slaves), strict=True)
            self.trace.append(Snapshot(self.now, Master.RUN, states, executing))
            self.now += MS

    def talk(self) -> None:
        for _ in range(8):
            for link in self.links.values():
                link.poll()
            for slave in self.slaves:
                slave.communicate()

    def told(self, path: str) -> list[dict[str, object]]:
        """The feedback since the last time."""
        found, self.links[path].told = self.links[path].told, []
        return found

    def sound(self) -> None:
        """The invariants hold, and at the end no flag is left."""
        assert violations(self.trace, MS) == []
        for link in self.links.values():
            for c in (link.end.out.channel, link.end.into.channel):
                flags = (c.begin, c.running, c.order, c.busy, c.ack, c.nack)
                assert not any(self.master.shared.test(flag, c.mask) for flag in flags)
