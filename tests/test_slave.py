"""Algorithms on slaves: how they start, run at their own pace, rest, err and end; what is sent for it."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from slave_rig import AXIS, MAIN, MS, Rig, compiled, write

from ldc import pipeline
from ldc.cli.compiling import native_code
from ldc.il import image
from ldc.il.areas import areas
from ldc.il.placement import placed, points
from runtime.field import Field, UnknownPoint, field_size
from runtime.processors.states import Algorithm, Slave
from runtime.protocol.check import Code
from runtime.protocol.envelope import Command
from runtime.protocol.sender import Done, Fault
from runtime.slave.algorithm import makers
from runtime.vm.machine import Machine

PATH = "main.axis"
GO = {"enable": 1, "target": 2.0, "limit": 100.0}
LANGUAGES = pytest.mark.parametrize("language", ["c", "st"])
ALONE = "PROGRAM main\nVAR axis : AXIS; END_VAR\nRUNG <axis: AXIS() in=_>\nEND_PROGRAM\n"
MOVER = "PROGRAM main\nVAR mover : MOVER; END_VAR\nRUNG <mover: MOVER()>\nEND_PROGRAM\n"
TABLE = """\
PROGRAM main
VAR a : ARRAY [1..{0}] OF AXIS; END_VAR
RUNG <a[1]: AXIS(target := 1.0)>
END_PROGRAM
"""


@pytest.fixture(params=["c", "st"])
def rig(request, tmp_path: Path) -> Rig:
    return Rig(compiled(write(tmp_path, request.param)))


def states(told: list[dict]) -> list[Algorithm]:
    return [Algorithm(values["AFS"]) for values in told]


def test_from_start_to_rest(rig: Rig) -> None:
    slave = rig.slaves[0]
    rig.send(PATH, Command.START, **GO)
    rig.talk()
    assert slave.state is Slave.READY and slave.executing == 0 and slave.live
    rig.run(12)
    first, *_, last = rig.told(PATH)
    assert (first["AFS"], first["us"], first["position"]) == (Algorithm.RUNNING, 0, 0.0)
    assert last["position"] == pytest.approx(1.1, abs=1e-5) and last["us"] == 1000
    assert slave.state is Slave.RUN and slave.executing == 1
    rig.run(15)
    there = {"arrived": 1, "position": 2.0, "us": 1000, "error": 0, "AFS": Algorithm.RUNNING}
    assert rig.told(PATH)[-1] == there
    rig.run(5)
    assert rig.told(PATH) == []  # nothing changes: nothing is sent
    rig.send(PATH, Command.UPDATE, **GO | {"enable": 0, "limit": 1000.0})
    rig.run(5)
    told = rig.told(PATH)
    assert states(told) == [Algorithm.RUNNING, Algorithm.RUNNING, Algorithm.DONE]
    assert [values["position"] for values in told] == pytest.approx([1.0, 0.0, 0.0], abs=1e-5)
    assert slave.state is Slave.STOP and slave.executing == 0 and not slave.live
    units = [event.unit for event in rig.units if event.unit not in ("A.EXEC", "A.FEEDBACK")]
    assert units == ["A.START", "A.DEFRAME", "A.DEFRAME", "A.END"]
    executed = len([event for event in rig.units if event.unit == "A.EXEC"])
    rig.run(10)
    assert len([event for event in rig.units if event.unit == "A.EXEC"]) == executed
    rig.sound()


def test_a_second_start_goes_on_with_the_state(rig: Rig) -> None:
    rig.send(PATH, Command.START, **GO)
    rig.run(30)
    rig.send(PATH, Command.STOP)
    rig.run(20)
    assert rig.slaves[0].state is Slave.STOP
    rig.told(PATH)
    rig.send(PATH, Command.START, **GO | {"target": 3.0})
    rig.run(2)
    first, second = rig.told(PATH)
    assert (first["us"], first["position"]) == (0, 2.0)  # no time has passed for it
    assert second["position"] == pytest.approx(2.1, abs=1e-5)
    rig.sound()


def test_stop_ends_at_once_and_local_outputs_are_safe(rig: Rig) -> None:
    speed = rig.field.reader(f"{PATH}.speed_out")
    assert speed() == 0.5  # as its descriptor says, before anything runs
    rig.send(PATH, Command.START, **GO)
    rig.run(3)
    assert speed() == pytest.approx(100.0, abs=1e-3)
    rig.told(PATH)
    rig.send(PATH, Command.STOP)
    rig.run(3)
    assert speed() == 0.5 and rig.slaves[0].executing == 0 and rig.slaves[0].state is Slave.STOP
    assert rig.told(PATH) == []
    assert [e.detail for e in rig.units if e.unit == "A.END"] == ["stop"]
    rig.sound()


def test_an_error_of_the_body_ends_it(rig: Rig) -> None:
    rig.send(PATH, Command.START, **GO)
    rig.run(3)
    rig.field.writer(f"{PATH}.measured")(401.0)
    rig.told(PATH)
    rig.run(3)
    (told,) = rig.told(PATH)
    assert (told["error"], told["AFS"]) == (20, Algorithm.ERROR)
    assert rig.slaves[0].state is Slave.STOP and rig.field.reader(f"{PATH}.speed_out")() == 0.5
    rig.send(PATH, Command.UPDATE, **GO)  # its master may not know yet
    rig.run(2)
    assert rig.told(PATH) == [] and rig.slaves[0].executing == 0
    rig.field.writer(f"{PATH}.measured")(0.0)
    rig.send(PATH, Command.START, **GO)
    rig.run(2)
    assert [(t["error"], t["AFS"]) for t in rig.told(PATH)] == [(0, Algorithm.RUNNING)] * 2
    rig.sound()


@pytest.mark.parametrize(("measured", "error"), [(501.0, 7), (-10.5, 7), (float("nan"), 6), (500.0, 20)])
def test_local_inputs_are_checked_on_the_slave(rig: Rig, measured: float, error: int) -> None:
    rig.field.writer(f"{PATH}.measured")(measured)
    rig.send(PATH, Command.START, **GO)
    rig.run(2)
    assert [(t["error"], t["AFS"]) for t in rig.told(PATH)] == [(error, Algorithm.ERROR)]
    rig.sound()


@pytest.mark.parametrize(("change", "code"), [
    ({"target": 400.5}, Code.RANGE), ({"limit": 0.5}, Code.RANGE), ({"target": float("inf")}, Code.TYPE),
    ({"enable": 2}, Code.TYPE)])
def test_parameters_are_checked_again_by_p(rig: Rig, change: dict, code: Code) -> None:
    rig.send(PATH, Command.START, **GO | change)
    rig.run(3)
    assert rig.links[PATH].events == [Fault(1, code)]
    assert rig.slaves[0].state is Slave.STOP and not rig.slaves[0].live
    rig.sound()


def test_commands_that_do_not_fit_the_state(rig: Rig) -> None:
    rig.send(PATH, Command.UPDATE, **GO)
    rig.run(2)
    assert rig.links[PATH].events.pop() == Fault(1, Code.STATE)
    rig.links[PATH].end.reset()
    rig.run(2)
    rig.send(PATH, Command.START, **GO)
    rig.run(2)
    rig.send(PATH, Command.START, **GO)
    rig.run(2)
    assert rig.links[PATH].events[-1] == Fault(2, Code.STATE)
    assert rig.slaves[0].executing == 1  # the first one goes on
    rig.links[PATH].end.reset()
    rig.run(2)
    assert rig.slaves[0].executing == 0 and rig.slaves[0].state is Slave.STOP
    rig.sound()


def test_a_fault_in_il_leads_to_serror(tmp_path: Path) -> None:
    main = MAIN.replace("axis : AXIS", "axis, other : AXIS").replace(
        "RUNG", "RUNG <other: AXIS(target := 2.0)>\nRUNG")
    rig = Rig(compiled(write(tmp_path, "st", main)))
    slave = rig.slaves[0]
    for path in (PATH, "main.other"):
        rig.send(path, Command.START, **GO)
    rig.run(3)
    rig.field.writer(f"{PATH}.measured")(-6.0)
    rig.told(PATH)
    rig.run(2)
    assert [(t["error"], t["AFS"]) for t in rig.told(PATH)] == [(801, Algorithm.ERROR)]
    assert slave.state is Slave.ERROR and slave.executing == 0
    (told,) = [fault.fault for fault in slave.faults]
    assert (told.code, told.task, told.scan) == ("LD0801", "main.axis on slave1", 3)
    assert told.diagnostic().primary.span.text.startswith("us / REAL_TO_UDINT")
    rig.told("main.other")
    rig.send("main.other", Command.START, **GO)
    rig.run(2)
    assert states(rig.told("main.other")) == [Algorithm.ERROR] and slave.executing == 0
    rig.field.writer(f"{PATH}.measured")(0.0)
    rig.links[PATH].end.reset()
    rig.run(2)
    assert slave.state is Slave.STOP
    rig.send(PATH, Command.START, **GO)
    rig.send("main.other", Command.START, **GO)
    rig.run(2)
    assert [t["position"] for t in rig.told(PATH)] == pytest.approx([0.0, 0.1], abs=1e-5)  # made anew
    assert rig.told("main.other")[0]["position"] > 0  # as it was
    rig.sound()


def test_a_number_that_cannot_be_sent_is_an_error(tmp_path: Path) -> None:
    rig = Rig(compiled(write(tmp_path)))
    rig.send(PATH, Command.START, **GO)
    rig.run(3)
    rig.field.writer(f"{PATH}.measured")(-6.0)
    before = rig.told(PATH)[-1]
    rig.run(3)
    (told,) = rig.told(PATH)
    assert told == before | {"error": 6, "AFS": Algorithm.ERROR}  # with the outputs as they were
    assert rig.slaves[0].executing == 0
    rig.sound()


def test_an_emergency_ends_all_until_a_reset(rig: Rig) -> None:
    rig.send(PATH, Command.START, **GO)
    rig.run(3)
    rig.slaves[0].emergency()
    assert rig.slaves[0].executing == 0 and rig.slaves[0].state is Slave.ERROR
    assert rig.field.reader(f"{PATH}.speed_out")() == 0.5
    rig.run(2)
    rig.links[PATH].end.reset()
    rig.run(2)
    assert rig.slaves[0].state is Slave.STOP
    rig.sound()


def test_a_master_that_does_not_answer(rig: Rig) -> None:
    rig.send(PATH, Command.START, **GO)
    rig.run(3)
    slave = rig.slaves[0]
    for _ in range(30):
        slave.communicate()
        slave.execute()
        rig.now += MS
    assert slave.state is Slave.ERROR and slave.executing == 0
    for _ in range(4):
        rig.links[PATH].end.reset()
        rig.run(10)
    assert slave.state is Slave.STOP
    rig.send(PATH, Command.START, **GO)
    rig.run(3)
    assert slave.executing == 1 and states(rig.told(PATH))[-1] is Algorithm.RUNNING


def test_feedback_no_more_often_than_the_master_scans(tmp_path: Path) -> None:
    rig = Rig(compiled(write(tmp_path)), scan_ms=10)
    rig.send(PATH, Command.START, **GO)
    rig.run(15)
    assert len(rig.told(PATH)) == 2
    rig.field.writer(f"{PATH}.measured")(450.0)
    rig.run(1)
    assert len(rig.told(PATH)) == 1  # an error waits for nothing


@LANGUAGES
def test_without_a_pin_for_the_power_it_executes_until_a_stop(tmp_path: Path, language: str) -> None:
    write(tmp_path, language, main=ALONE)
    descriptor = (tmp_path / "axis.ldc.toml").read_text()
    descriptor = descriptor.replace("[requires]\n", "[requires]\npower = false\n")
    (tmp_path / "axis.ldc.toml").write_text(descriptor)
    body = (tmp_path / f"axis.{language}").read_text()
    body = body.replace("in->enable", "true").replace("SEL(enable, 0.0, target)", "target")
    body = body.replace("enable AND ", "")
    (tmp_path / f"axis.{language}").write_text(body)
    rig = Rig(compiled(tmp_path))
    rig.send(PATH, Command.START, target=0.0, limit=1.0)
    rig.run(20)
    assert rig.slaves[0].executing == 1 and states(rig.told(PATH))[-1] is Algorithm.RUNNING
    rig.send(PATH, Command.STOP)
    rig.run(2)
    assert rig.slaves[0].executing == 0
    rig.sound()


@LANGUAGES
def test_a_component_in_an_algorithm_is_called_there(tmp_path: Path, language: str) -> None:
    write(tmp_path, language, main=MOVER)
    (tmp_path / "mover.ldc.toml").write_text(
        '[component]\nname = "MOVER"\nid = "t.mover"\n[provides]\noutputs = [{ name = "y", type = "REAL" }]\n'
        '[function]\nlanguage = "st"\nsources = ["mover.st"]\nprocessor = "slave"\nperiod_us = 2000\n')
    (tmp_path / "mover.st").write_text(
        "FUNCTION_BLOCK MOVER\nVAR inner : AXIS; END_VAR\n"
        "    inner(enable := enable, target := 1.0, limit := 100.0);\n    y := inner.position;\n"
        "END_FUNCTION_BLOCK\n")
    rig = Rig(compiled(tmp_path))
    assert [(p.path, p.period_ns) for p in rig.placed] == [("main.mover", 2 * MS)]
    rig.send("main.mover", Command.START, enable=1)
    rig.run(7)
    assert [t["y"] for t in rig.told("main.mover")] == pytest.approx([0.0, 0.2, 0.4, 0.6], abs=1e-5)


@LANGUAGES
def test_four_slaves_with_paces_of_their_own(tmp_path: Path, language: str) -> None:
    write(tmp_path, language, slaves=4)
    declared, rungs = ["axis : AXIS;"], []
    for n in (2, 3, 4):
        text = AXIS.replace('"AXIS"', f'"AXIS{n}"').replace("test.axis", f"test.axis{n}")
        text = text.replace("slave1", f"slave{n}").replace("= 1000\n", f"= {n}000\n")
        text = text.replace("LANGUAGE", language).replace("SUFFIX", f"{n}.{language}")
        body = (tmp_path / f"axis.{language}").read_text()
        body = body.replace("axis", f"axis{n}").replace("AXIS", f"AXIS{n}")
        (tmp_path / f"axis{n}.ldc.toml").write_text(text.replace(f'"axis.{n}', f'"axis{n}'))
        (tmp_path / f"axis{n}.{language}").write_text(body)
        declared.append(f"a{n} : AXIS{n};")
        rungs.append(f"RUNG <a{n}: AXIS{n}(target := 2.0)>")
    (tmp_path / "main.ld").write_text(
        f"PROGRAM main\nVAR\n{' '.join(declared)}\nEND_VAR\nRUNG <axis: AXIS(target := 2.0)>\n"
        + "\n".join(rungs) + "\nEND_PROGRAM\n")
    rig = Rig(compiled(tmp_path))
    assert [p.slave for p in rig.placed] == [1, 2, 3, 4] and [p.slot for p in rig.placed] == [0] * 4
    for p in rig.placed:
        rig.send(p.path, Command.START, **GO)
    rig.run(13)
    counts = [sum(e.unit == "A.EXEC" and e.processor == f"slave{n}" for e in rig.units) for n in (1, 2, 3, 4)]
    assert counts == [13, 7, 5, 4]
    assert [rig.told(p.path)[-1]["us"] for p in rig.placed] == [1000, 2000, 3000, 4000]
    rig.sound()


def test_32_algorithms_on_one_slave(tmp_path: Path) -> None:
    rig = Rig(compiled(write(tmp_path, main=TABLE.format(32))))
    assert [p.slot for p in rig.placed] == list(range(32))
    for number, p in enumerate(rig.placed):
        rig.send(p.path, Command.START, enable=1, target=float(number), limit=1000.0)
    rig.run(40)
    assert rig.slaves[0].executing == 0xFFFFFFFF
    assert [rig.told(p.path)[-1]["position"] for p in rig.placed] == [float(n) for n in range(32)]
    for p in rig.placed:
        rig.send(p.path, Command.STOP)
    rig.run(3)
    assert rig.slaves[0].executing == 0 and rig.slaves[0].state is Slave.STOP
    rig.sound()


def test_parameters_lie_in_ad(rig: Rig) -> None:
    rig.send(PATH, Command.START, **GO)
    rig.run(2)
    raw = rig.slaves[0].memory.data.read(areas()["AD"].base, 12)
    assert memoryview(raw).cast("f").tolist()[1:] == [2.0, 100.0] and raw[0] == 1


steps = st.sampled_from(["start", "on", "off", "stop", "error", "reset"])
commands = st.lists(st.tuples(steps, st.integers(0, 6)), max_size=12)


@pytest.fixture(scope="module")
def axis(tmp_path_factory):
    return compiled(write(tmp_path_factory.mktemp("axis"), "c"))


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(commands)
def test_whatever_a_master_does_the_invariants_hold(axis, steps: list[tuple[str, int]]) -> None:
    rig = Rig(axis)
    end, measured = rig.links[PATH].end, rig.field.writer(f"{PATH}.measured")
    for step, milliseconds in steps:
        measured(450.0 if step == "error" else 0.0)
        if step == "reset":
            end.reset()
        elif end.ready and step == "stop":
            rig.send(PATH, Command.STOP)
        elif end.ready and step != "error":
            command = Command.START if step == "start" else Command.UPDATE
            rig.send(PATH, command, **GO | {"enable": int(step != "off")})
        rig.run(milliseconds)
    end.reset()
    rig.run(3)
    assert rig.slaves[0].state is Slave.STOP and rig.slaves[0].executing == 0
    rig.sound()


def test_another_placement_keeps_what_stays(tmp_path: Path) -> None:
    rig = Rig(compiled(write(tmp_path)))
    rig.send(PATH, Command.START, **GO)
    rig.run(10)
    main = MAIN.replace("axis : AXIS", "before, axis : AXIS").replace("RUNG", "RUNG <before: AXIS()>\nRUNG")
    result = compiled(write(tmp_path, main=main))
    program = image.load(result.image.data).program
    new = placed(program, previous=rig.placed)
    assert [(p.path, p.slot, p.aid) for p in new] == [("main.before", 1, 2), (PATH, 0, 1)]
    where = points(program, new, rig.field.places)
    assert where.items() >= rig.field.places.items()
    slave = rig.slaves[0]
    field = Field(bytearray(field_size(where)), where)
    slave.place(new, makers(program, native_code(result)), field)  # of the image: without places in sources
    assert slave.executing == 1
    rig.told(PATH)
    rig.run(1)
    assert rig.told(PATH)[-1]["position"] == pytest.approx(1.0, abs=1e-5)
    slave.place((), {})
    assert slave.executing == 0 and slave.state is Slave.STOP
    rig.sound()


@pytest.mark.parametrize(("text", "kept"), [("y := x + 1;", True), ("y := x + 2;", False)])
def test_an_algorithm_whose_blocks_change_is_made_anew(tmp_path: Path, text: str, kept: bool) -> None:
    def program(body: str) -> pipeline.Compiled:
        write(tmp_path, "st", plus__st="FUNCTION_BLOCK PLUS\nVAR_INPUT x : DINT; END_VAR\n"
              f"VAR_OUTPUT y : DINT; END_VAR\n    {body}\nEND_FUNCTION_BLOCK\n")
        (tmp_path / "axis.st").write_text(
            "FUNCTION_BLOCK AXIS\nVAR plus : PLUS; END_VAR\n    plus(x := 1);\n"
            "    position := position + DINT_TO_REAL(plus.y);\nEND_FUNCTION_BLOCK\n")
        return compiled(tmp_path)

    rig = Rig(program("y := x + 1;"))
    rig.send(PATH, Command.START, **GO)
    rig.run(3)
    new = program(text).program
    rig.slaves[0].place(placed(new, previous=rig.placed), makers(new))
    assert rig.slaves[0].executing == int(kept)


# ---- placement, proxies, field -------------------------------------------------------------------


def test_a_placement_of_slots_of_different_sizes(tmp_path: Path) -> None:
    write(tmp_path, main="PROGRAM main\nVAR a, b : AXIS; w : WIDE; c : AXIS; END_VAR\n"
          "RUNG <a: AXIS()> <b: AXIS()> <w: WIDE()> <c: AXIS()>\nEND_PROGRAM\n")
    pins = ",\n".join(f'{{ name = "i{n}", type = "INT" }}' for n in range(20))
    (tmp_path / "wide.ldc.toml").write_text(
        f'[component]\nname = "WIDE"\nid = "t.wide"\n[requires]\ninputs = [\n{pins}\n]\n'
        '[function]\nlanguage = "st"\nsources = ["wide.st"]\nprocessor = "slave"\nperiod_us = 2000\n')
    (tmp_path / "wide.st").write_text("FUNCTION_BLOCK WIDE\n    error := 0;\nEND_FUNCTION_BLOCK\n")
    a, b, w, c = placed(compiled(tmp_path).program)
    assert [(p.slot, p.blocks, p.aid) for p in (a, b, w, c)] == [(0, 1, 1), (1, 1, 2), (2, 2, 3), (3, 1, 4)]
    assert w.parameters[-1].low == -32768 and w.parameters[-1].pid == 21


def test_more_instances_than_slots(tmp_path: Path) -> None:
    result = pipeline.compile_paths([str(write(tmp_path, main=TABLE.format(33)))])
    assert [d.code for d in result.diagnostics] == ["LD1022"]
    assert len(placed(compiled(write(tmp_path, main=TABLE.format(32))).program)) == 32


@LANGUAGES
def test_the_proxy_checks_and_takes_what_is_fed_back(tmp_path: Path, language: str) -> None:
    program = compiled(write(tmp_path, language)).program
    machine = Machine(program)
    (p,) = placed(program)
    fed = {pin.name: f"{PATH}.{pin.variable}" for pin in p.feedback if pin.variable}
    machine.set("go", True)
    machine.set(fed["arrived"], True)
    machine.set(fed["position"], 1.5)
    machine.scan()
    assert (machine.get("lamp"), machine.get("pos"), machine.get("axis.error")) == (True, 1.5, 0)
    assert machine.get("axis.enable") is True and machine.get("axis.target") == 2.0
    machine.set(fed["error"], 20)
    machine.scan()
    assert machine.get("axis.error") == 20
    machine.set("axis.limit", 2000.0)
    machine.scan()
    assert machine.get("axis.error") == 7


@LANGUAGES
def test_without_its_slave_a_component_is_called(tmp_path: Path, language: str) -> None:
    traces = []
    for slaves, options in ((0, {}), (1, {"algorithms": False})):
        result = compiled(write(tmp_path, language, slaves=slaves), **options)
        assert not placed(result.program) and not result.program.algorithms
        machine = Machine(result.program, bindings=native_code(result))
        machine.set("go", True)
        trace = []
        for _ in range(5):
            machine.scan()
            trace.append(machine.get("pos"))
        traces.append(trace)
    assert traces[0] == traces[1] == pytest.approx([0.0, 1.0, 2.0, 2.0, 2.0])


def test_an_image_holds_the_algorithms(tmp_path: Path) -> None:
    result = compiled(write(tmp_path))
    program = image.load(result.image.data).program
    assert placed(program) == placed(result.program)
    assert makers(program).keys() == {"AXIS"}
    (tmp_path / "axis.c").write_text((tmp_path / "axis.c").read_text() + "/* changed */\n")
    assert compiled(tmp_path).image.digest != result.image.digest


def test_points_of_the_field(tmp_path: Path) -> None:
    program = compiled(write(tmp_path)).program
    where = points(program, placed(program))
    assert where["%IX0.0"] == where["MAIN.GO"] and where["%QX0.0"].type == "bool32"
    assert len({point.index for point in where.values()}) == 4
    buffer = bytearray(field_size(where))
    field, other = Field(buffer, where), Field(buffer, where)
    field.writer("Main.Axis.Measured")(0.1)
    assert other.reader("main.axis.measured")() == pytest.approx(0.1, abs=1e-8)
    field.writer("%IX0.0")(True)
    assert other.reader("main.go")() is True and other.asked == {"MAIN.AXIS.MEASURED", "MAIN.GO"}
    with pytest.raises(UnknownPoint, match="no point `main.axis.measure`, did you mean `main.axis.measured`"):
        field.reader("main.axis.measure")


def test_a_local_pin_is_none_of_the_ladder(tmp_path: Path) -> None:
    main = MAIN.replace("position => pos", "speed_out => pos")
    result = pipeline.compile_paths([str(write(tmp_path, main=main))])
    assert result.diagnostics.has_errors
    compiled(tmp_path, algorithms=False)


def test_transfers_are_done_and_nothing_is_left(rig: Rig) -> None:
    rig.send(PATH, Command.START, **GO)
    rig.run(2)
    assert rig.links[PATH].events == [Done(1)]
    rig.sound()
