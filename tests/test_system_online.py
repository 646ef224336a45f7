"""A system whose program is changed while it runs: algorithms and modules that stay go on, what comes
joins."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from systems import MODULE, Run, modules, mover

from ldc import pipeline
from ldc.cli import system as systems
from ldc.cli.compiling import native_code
from ldc.cli.starting import start
from ldc.il import image as il_image
from ldc.il.coordination_image import pack, unpack
from runtime.native.machine import Machine as Native
from runtime.online.controller import Controller, Loaded, prepare
from runtime.processors.invariants import violations
from runtime.processors.states import Slave
from runtime.slave.algorithm import makers
from runtime.system import System
from runtime.units import A_EXEC, A_START, C_END, C_SEND, C_START, UnitEvent

ENGINES = pytest.mark.parametrize("engine", ["vm", "native"])
SEQUENCE = '[sequence]\nstart = "go"\nsteps = [{steps}]\n[safety]\nestop = "estop"\nreset = "reset"\n'


def loaded(folder: Path, engine: str, previous: Loaded | None = None) -> Loaded:
    """The program of a folder, ready to run or to take over; how modules work together went through bytes."""
    before = None if previous is None else il_image.load(previous.image).layout
    result = pipeline.compile_paths([str(folder)], pipeline.Options(keep=False, previous=before))
    assert not result.diagnostics.has_errors, list(result.diagnostics)
    bindings = native_code(result)
    if previous is None or engine == "vm":
        machine = start(result, None, result.sources.manifest, engine, bindings)
    else:
        from ldc.cli import native

        made = native.artifact(result, 0, areas=dict(previous.machine.plan.areas), bindings=bindings)
        machine = Native(result.program, 0, previous.machine.period_ns, native=native.loadable(made))
    together = unpack(pack(systems.together(result)), lambda path: machine.symbols.find(path).type)
    assert together == replace(systems.together(result), plant=None)
    return Loaded(machine, result.image.data, result.image.digest, (), together,
                  makers(result.program, bindings))


class Online(Run):
    """A run whose master has a controller of online changes."""

    def __init__(self, folder: Path, engine: str) -> None:
        self.engine, first = engine, loaded(folder, engine)
        self.controller = Controller(first)
        self.machine = first.machine
        self.events: list[UnitEvent] = []
        self.trace: list = []
        result = pipeline.compile_paths([str(folder)])
        self.system: System = systems.system(result, self.controller, native_code(result), self.events,
                                             self.trace.append)
        self.watch, self.rows = (), []

    def test(self, folder: Path) -> None:
        """Lets the program of the folder run from the next scan on."""
        old = self.controller.running
        self.controller.stage(prepare(old, loaded(folder, self.engine, old), old.digest, "me"))
        self.controller.test("me")
        self.system.follow()

    def end(self, action: str) -> None:
        getattr(self.controller, action)("me")
        self.system.follow()

    @property
    def violations(self) -> list[str]:
        return violations(self.trace, self.system.machine.period_ns)


def inserted(folder: Path, steps: str) -> None:
    """A module of the name `between`, on slave2, between the others."""
    text = (folder / "ldc.toml").read_text()
    begin, _, rest = text.partition("[sequence]")
    listed = 'modules = ["first", "between", "second"]'
    head = "\n".join(listed if line.startswith("modules") else line for line in begin.splitlines())
    (folder / "ldc.toml").write_text(f"{head}\n{SEQUENCE.format(steps=steps)}")
    mover(folder, "MOVER9", 2, 2000)
    (folder / "between.ld").write_text(MODULE.format(name="between", mover="MOVER9", number=5))


@ENGINES
def test_a_module_is_inserted_while_another_one_moves(tmp_path: Path, engine: str) -> None:
    """The algorithm of `first` is neither stopped nor started again; cycles have the new step from now on."""
    run = Online(modules(tmp_path, SEQUENCE.format(steps='"first", "second"')), engine)
    run.scans(2).scans(8, go=True)
    moved = run.get("first.axis.position")
    assert 0.0 < moved < 10.0
    inserted(tmp_path, '"first", "between", "second"')
    run.test(tmp_path)
    assert run.get("first.axis.position") == moved and run.system.slaves[0].state is Slave.RUN
    run.scans(1)
    assert run.get("first.axis.position") > moved
    run.end("commit")
    run.scans(60, lambda r: len(r.units(C_END)) == 3)
    assert [index for _, index, _ in run.units(C_START)][:3] == [0, 1, 2]
    assert run.units(A_START)[0] == (A_START, 1, "") and (A_START, 1, "") not in run.units(A_START)[1:2]
    assert run.get("between.axis.position") == 10.0
    assert run.system.machine.scans == len(run.rows), "no scan was missed"
    assert run.violations == []


@ENGINES
def test_an_algorithm_of_a_module_that_goes_ends_and_the_module_with_it(tmp_path: Path, engine: str) -> None:
    folder = modules(tmp_path, SEQUENCE.format(steps='"first", "second"'))
    before = (folder / "ldc.toml").read_text()
    inserted(folder, '"between", "first", "second"')
    run = Online(folder, engine).scans(2).scans(6, go=True)
    assert run.system.slaves[1].state is Slave.RUN
    sources = 'sources = ["io.ld", "first.ld", "second.ld"]\n[processors]'
    (folder / "ldc.toml").write_text(before.replace("[processors]", sources))
    run.test(folder)
    assert run.system.slaves[1].state is Slave.STOP
    run.scans(60, lambda r: len(r.units(C_END)) == 2)
    assert run.get("second.axis.position") == 10.0
    run.end("untest")
    run.scans(60, lambda r: r.get("between.axis.position") == 10.0)
    assert run.violations == []


@ENGINES
def test_a_fault_in_a_test_brings_program_and_algorithms_back(tmp_path: Path, engine: str) -> None:
    run = Online(modules(tmp_path, SEQUENCE.format(steps='"first", "second"')), engine)
    run.scans(2).scans(8, go=True)
    old = run.system.machine
    inserted(tmp_path, '"first", "between", "second"')
    text = (tmp_path / "between.ld").read_text()
    text = text.replace("    arrived : BOOL;", "    arrived : BOOL;\n    n, m : INT;")
    text = text.replace("RUNG rest", "RUNG bad\n    <MOVE(IN := 1 / n, OUT => m)>\n\nRUNG rest")
    (tmp_path / "between.ld").write_text(text)
    run.test(tmp_path)
    assert run.system.machine is not old
    run.scans(1)
    assert run.system.machine is old and run.controller.state == "running"
    run.scans(60, lambda r: len(r.units(C_END)) == 2)
    assert run.get("first.axis.position") == run.get("second.axis.position") == 10.0
    assert [index for _, index, _ in run.units(C_START)] == [0, 1]
    assert run.violations == []


@ENGINES
def test_what_waits_when_the_program_changes_is_neither_lost_nor_twice(tmp_path: Path, engine: str) -> None:
    """A command is sent once; a change between two scans repeats nothing."""
    folder = modules(tmp_path, SEQUENCE.format(steps='"first", "second"'))
    run = Online(folder, engine).scans(2).scans(4, go=True)
    sent = len(run.units(C_SEND))
    (folder / "second.ld").write_text((folder / "second.ld").read_text().replace("RUNG told", "RUNG spoken"))
    executed = len(run.units(A_EXEC))
    run.test(folder)
    run.scans(2)
    assert len(run.units(C_SEND)) == sent and len(run.units(A_EXEC)) == executed + 20
    assert run.violations == []


@ENGINES
def test_messages_that_wait_are_handled_by_the_program_that_takes_over(tmp_path: Path, engine: str) -> None:
    """Two modules start in one scan: the message of the second still waits when a module is inserted."""
    toml = ('[sequence]\nstart = "go"\nsteps = [{steps}]\n'
            '[messages.both]\nfrom = "go"\nto = ["first", "second"]\n'
            '[messages.START_MODULE]\nclass = "system"\n'
            'to = [{{ module = "second", flag = "seen", data = "who" }}]\n')
    toml = toml.format(steps='"first"').replace("[sequence]", "[sequence]\nrepeat = false")
    folder = modules(tmp_path, toml)
    second = folder / "second.ld"
    second.write_text(second.read_text().replace(
        "target : REAL := 10.0;", "target : REAL := 10.0; seen : BOOL; who : UDINT;").replace(
        "    arrived : BOOL;", "    arrived : BOOL;\n    starts  : INT;").replace(
        "RUNG move", "RUNG count\n    [seen] <ADD(IN1 := starts, IN2 := 1, OUT => starts)>\n\nRUNG move"))
    run = Online(folder, engine).scans(2).scans(2, go=True)
    assert [index for _, index, _ in run.units(C_START)] == [0, 1] and run.get("second.starts") == 0
    text = (folder / "ldc.toml").read_text()
    extra = '[messages.AAA]\nfrom = "go"\nto = ["between"]\n[messages.both]'
    text = text.replace('modules = ["first", "second"]', 'modules = ["first", "between", "second"]')
    (folder / "ldc.toml").write_text(text.replace("[messages.both]", extra))
    mover(folder, "MOVER9", 2, 2000)
    (folder / "between.ld").write_text(MODULE.format(name="between", mover="MOVER9", number=5))
    run.test(folder)
    run.scans(4)
    assert run.get("second.starts") == 2 and run.get("second.who") == 2, "by its index in the new program"
    assert [index for _, index, _ in run.units(C_START)] == [0, 1], "what was TRUE before has not risen"
    assert run.violations == []


def test_a_program_that_is_expected_takes_over_as_one_that_is_not(tmp_path: Path) -> None:
    """What is made ready beside the scans changes nothing before it takes over, and nothing of what happens
    then."""
    rows = []
    for expects in (False, True):
        folder = tmp_path / str(expects)
        folder.mkdir()
        run = Online(modules(folder, SEQUENCE.format(steps='"first", "second"')), "vm")
        run.watch = ("first.axis.position", "second.axis.position", "%QX0.1", "%QX0.2")
        if expects:
            run.controller.expect = run.system.expect
        run.scans(2).scans(8, go=True)
        inserted(folder, '"first", "between", "second"')
        old = run.controller.running
        new = loaded(folder, "vm", old)
        run.controller.stage(prepare(old, new, old.digest, "me"))
        run.controller.expect(new)
        run.scans(3)
        run.controller.test("me")
        run.system.follow()
        run.scans(20)
        run.end("untest")
        run.scans(5)
        run.end("cancel")
        rows.append((run.rows, run.events))
    assert rows[0] == rows[1]
