"""XML of IEC 61131-10: the same program as TC6 and as text has the same image."""

from __future__ import annotations

from pathlib import Path

import pytest

from ldc.cli.main import main
from ldc.pipeline import Compiled, compile_paths
from runtime.vm.machine import Machine

XSI = 'xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'


def variables(text: str) -> str:
    """``a : BOOL = TRUE``, one in a line."""
    made = []
    for line in text.split(";"):
        name, _, rest = line.partition(":")
        kind, _, value = rest.partition("=")
        name, _, place = name.strip().partition(" AT ")
        address = f'<Address address="{place}"/>' if place else ""
        initial = f'<InitialValue><SimpleValue value="{value.strip()}"/></InitialValue>' if value else ""
        made.append(f'<Variable name="{name}"><Type><TypeName>{kind.strip()}</TypeName></Type>'
                    f"{initial}{address}</Variable>")
    return "".join(made)


def wired(*numbers: int) -> str:
    return ("<ConnectionPointIn>" + "".join(f'<Connection refConnectionPointOutId="{n}"/>' for n in numbers)
            + "</ConnectionPointIn>")


def out(number: int) -> str:
    return f'<ConnectionPointOut connectionPointOutId="{number}"/>'


def thing(family: str, kind: str, inside: str = "", place: str = "", **attributes: str) -> str:
    words = "".join(f' {name}="{value}"' for name, value in attributes.items())
    at = '<RelPosition x="{}" y="{}"/>'.format(*place.split()) if place else ""
    return f'<{family}Object xsi:type="{kind}"{words}>{at}{inside}</{family}Object>'


def rail(number: int = 1) -> str:
    return thing("Ld", "LeftPowerRail", out(number))


def contact(number: int, name: str, *sources: int, **more: str) -> str:
    return thing("Ld", "Contact", wired(*sources) + out(number), operand=name, **more)


def coil(name: str, *sources: int, **more: str) -> str:
    return thing("Ld", "Coil", wired(*sources) + out(99), operand=name, **more)


def source(number: int, text: str, place: str = "") -> str:
    return thing("Fbd", "DataSource", out(number), place, identifier=text)


def sink(text: str, number: int, place: str = "") -> str:
    return thing("Fbd", "DataSink", wired(number), place, identifier=text)


def block(kind: str, inputs: dict[str, int], outputs: dict[str, int], place: str = "", **more: str) -> str:
    pins = "".join(f'<InputVariable parameterName="{name}">{wired(number)}</InputVariable>'
                   for name, number in inputs.items())
    ends = "".join(f'<OutputVariable parameterName="{name}">{out(number)}</OutputVariable>'
                   for name, number in outputs.items())
    pins = f"<InputVariables>{pins}</InputVariables><OutputVariables>{ends}</OutputVariables>"
    return thing("Fbd", "Block", pins, place, typeName=kind, **more)


def body(kind: str, inside: str) -> str:
    return f'<MainBody><BodyContent xsi:type="{kind}">{inside}</BodyContent></MainBody>'


def rungs(*drawn: str) -> str:
    return body("LD", "".join(one if one.startswith("<Rung") else f'<Rung evaluationOrder="{at}">{one}</Rung>'
                              for at, one in enumerate(drawn, 1)))


def program(declared: str, body: str, name: str = "main", kind: str = "Program") -> str:
    return f'<{kind} name="{name}"><Vars>{variables(declared)}</Vars>{body}</{kind}>'


def project(types: str, instances: str = "") -> str:
    return (f'<?xml version="1.0" encoding="utf-8"?>\n'
            f'<Project xmlns="www.iec.ch/public/TC65SC65BWG7TF10" {XSI} schemaVersion="1.0">'
            f"<Types><GlobalNamespace>{types}</GlobalNamespace></Types>"
            f"<Instances>{instances}</Instances></Project>")


def read(folder: Path, text: str, name: str = "plant.xml") -> Compiled:
    path = folder / name
    path.write_text(text)
    return compile_paths([str(path)])


def texts(folder: Path, xml: str) -> str:
    """What is imported from it, which has its image; so has what is exported."""
    made = read(folder, xml)
    assert not made.diagnostics, [d.message for d in made.diagnostics]
    assert made.image is not None
    imported, exported = folder / "texts", folder / "again.xml"
    assert main(["import", str(folder / "plant.xml"), "-o", str(imported)]) == 0
    assert main(["export", str(folder / "plant.xml"), "--to", "plcopen", "-o", str(exported)]) == 0
    for again in (imported, exported):
        image = compile_paths([str(again)]).image
        assert image is not None and image.digest == made.image.digest
    return "".join(path.read_text() for path in sorted((imported / "src").rglob("*")) if path.is_file())


def test_a_ladder_with_a_timer_a_latch_edges_and_a_jump(tmp_path: Path) -> None:
    """Without places, as Sysmac Studio writes it; numbers of outputs begin again in every rung."""
    drawn = rungs(
        rail() + contact(2, "start", 1) + contact(3, "stop", 2, negated="true") + source(4, "T#2s")
        + block("TON", {"IN": 3, "PT": 4}, {"Q": 5, "ET": 6}, instanceName="t") + coil("run", 5, latch="set"),
        thing("Ld", "LeftPowerRail", out(1) + out(9)) + contact(2, "stop", 1, edge="rising")
        + coil("run", 2, latch="reset") + contact(3, "start", 9) + contact(4, "hold", 1)
        + coil("both", 3, 4, negated="true"),
        '<Rung evaluationOrder="5" label="over">' + rail() + contact(2, "stop", 1)
        + coil("hold", 2) + "</Rung>",
        rail() + thing("Ld", "CompareContact", wired(1) + out(2) + "<Type>TIME</Type>", operand1="t.ET",
                       operand2="T#1s", compareOperator="&gt;=") + coil("late", 2),
        '<Rung evaluationOrder="3">'
        + thing("Common", "Comment", '<Content xsi:type="SimpleText">not on hold</Content>')
        + rail() + contact(2, "hold", 1) + thing("Common", "Jump", wired(2), targetNetworkLabel="over")
        + "</Rung>")
    text = texts(tmp_path, project(program(
        "start AT %IX0.0 : BOOL; stop AT %IX0.1 : BOOL; hold : BOOL = TRUE;"
        "run AT %QX0.0 : BOOL; both : BOOL;"
        "late : BOOL; t : TON", drawn)))
    assert [line.strip() for line in text[text.index("RUNG"):].splitlines() if line.strip()] == [
        "RUNG", "[start] [/stop] <t: TON(PT := T#2s)> (S run)",
        "RUNG", "[P stop] (R run)",
        "RUNG", "{ [start] | [hold] } (/both)",
        'RUNG "not on hold"', "[hold] >>over",
        "RUNG", "[t.ET >= T#1s] (late)",
        "RUNG over", "[stop] (hold)",
        "END_PROGRAM"]
    assert "hold   : BOOL := TRUE;" in text and "run    AT %QX0.0 : BOOL;" in text


TYPES = """<DataTypeDecl name="Mode"><Documentation>how</Documentation>
<UserDefinedTypeSpec xsi:type="EnumTypeSpec">
<Enumerator name="idle"/><Enumerator name="busy"/></UserDefinedTypeSpec></DataTypeDecl>
<DataTypeDecl name="Places"><UserDefinedTypeSpec xsi:type="ArrayTypeSpec"><BaseType><TypeName>INT</TypeName>
</BaseType><DimensionSpec dimensionNumber="1"><IndexRange lower="1" upper="3"/></DimensionSpec>
</UserDefinedTypeSpec></DataTypeDecl>
<NamespaceDecl name="inner"><DataTypeDecl name="Axis"><UserDefinedTypeSpec xsi:type="StructTypeSpec">
<Member name="goal"><Type><TypeName>Places</TypeName></Type></Member>
<Member name="mode"><Type><TypeName>Mode</TypeName>
</Type><InitialValue><SimpleValue value="busy"/></InitialValue></Member></UserDefinedTypeSpec></DataTypeDecl>
</NamespaceDecl>"""
PAIR = """<Variable name="pair"><Type>
<InstantlyDefinedType xsi:type="ArrayTypeSpec"><BaseType><TypeName>INT</TypeName>
</BaseType><DimensionSpec><IndexRange lower="0" upper="1"/></DimensionSpec></InstantlyDefinedType></Type>
<InitialValue><ArrayValue><Value><SimpleValue value="7"/></Value><Value><SimpleValue value="8"/></Value>
</ArrayValue></InitialValue>
</Variable>"""


def test_types_blocks_functions_and_tasks(tmp_path: Path) -> None:
    counts = ('<FunctionBlock name="Counts"><Parameters><InputVars>' + variables("go : BOOL")
              + "</InputVars><OutputVars>" + variables("done : BOOL; n : INT") + "</OutputVars></Parameters>"
              + body("ST", "<ST><![CDATA[done := go AND n > 3; n := n + 1;]]></ST>") + "</FunctionBlock>")
    twice = ('<Function name="Twice"><ResultType><TypeName>INT</TypeName></ResultType><Parameters><InputVars>'
             + variables("x : INT") + "</InputVars></Parameters>"
             + body("IL", "<IL>LD x\nADD x\nST Twice</IL>") + "</Function>")
    drawn = body("FBD", '<Network xsi:type="FbdNetwork" evaluationOrder="1"><RelPosition x="0" y="0"/>'
                 + source(1, "k", "0 2") + block("Twice", {"x": 1}, {"": 2}, "5 2")
                 + sink("ax.goal[1]", 2, "10 2")
                 + '</Network><Network xsi:type="FbdNetwork" evaluationOrder="2"><RelPosition x="0" y="10"/>'
                 + source(1, "go", "0 2")
                 + block("Counts", {"go": 1}, {"done": 2, "n": 3}, "5 2", instanceName="c")
                 + sink("done", 2, "10 2") + sink("k", 3, "10 4") + "</Network>")
    first = program("ax : Axis; c : Counts; k : INT; go AT %IX0.0 : BOOL; done AT %QX0.0 : BOOL", drawn)
    second = ('<Program name="other"><ExternalVars>'
              + variables("door : BOOL; lamp : BOOL") + "</ExternalVars>"
              + rungs(rail() + contact(2, "door", 1) + coil("lamp", 2)) + "</Program>")
    instances = ('<Configuration name="plant"><Resource name="cpu" resourceTypeName="x"><GlobalVars>'
                 + variables("door AT %IX0.1 : BOOL; lamp AT %QX0.1 : BOOL")
                 + '</GlobalVars><Task name="fast" interval="20000" priority="1"/>'
                 '<Task name="slow" interval="100000" priority="2"/>'
                 '<ProgramInstance name="m" typeName="main" associatedTaskName="fast"/>'
                 '<ProgramInstance name="o" typeName="other" associatedTaskName="slow"/>'
                 "</Resource></Configuration>")
    text = texts(tmp_path, project(TYPES + counts + twice + first.replace("<Vars>", "<Vars>" + PAIR) + second,
                                   instances))
    for line in ("TASK fast (INTERVAL := T#20ms, PRIORITY := 1);",
                 "TASK slow (INTERVAL := T#100ms, PRIORITY := 2);",
                 "PROGRAM m WITH fast : main;", "PROGRAM o WITH slow : other;",
                 "Mode : (idle, busy);  // how",
                 "Places : ARRAY [1..3] OF INT;", "mode  : Mode := busy;", "ARRAY [0..1] OF INT := [7, 8];",
                 "<Twice(x := k, OUT => ax.goal[1]) in=_ out=_>",
                 "<c: Counts(go := go, done => done, n => k) in=_ out=_>",
                 "ADD x", "n := n + 1;"):
        assert line in text, line


def blinker(name: str, body: str) -> str:
    return (f'<FunctionBlock name="{name}"><Parameters><OutputVars>' + variables("light : BOOL")
            + "</OutputVars></Parameters><Vars>" + variables("a : BOOL = TRUE; b : BOOL; ta : TON; tb : TON")
            + f"</Vars>{body}</FunctionBlock>")


def test_three_languages_blink_alike(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ladder, network = [], []
    for number, (now, then, timer) in enumerate((("a", "b", "ta"), ("b", "a", "tb")), 1):
        ladder += [
            thing("Ld", "LeftPowerRail", out(1) + out(2)) + contact(3, now, 1) + source(4, "T#1s")
            + block("TON", {"IN": 3, "PT": 4}, {"Q": 5, "ET": 6}, instanceName=timer)
            + contact(7, then, 2) + coil(then, 5, 7),
            rail() + contact(2, f"{timer}.Q", 1, negated="true") + contact(3, now, 2) + coil(now, 3)]
        both = block("AND", {"IN1": 3, "IN2": 5}, {"OUT": 6}, "23 3")
        network.append(
            f'<Network evaluationOrder="{number}"><RelPosition x="1" y="{number * 25}"/>'
            + source(1, now, "2 5") + source(2, "T#1s", "2 8")
            + block("TON", {"IN": 1, "PT": 2}, {"Q": 3, "ET": 4}, "7 2", instanceName=timer)
            + source(5, now, "18 8") + both.replace('"IN1"', '"IN1" suppressName="true" negated ="true"')
            + sink(now, 6, "29 6") + source(7, then, "18 19")
            + block("OR", {"IN1": 3, "IN2": 7}, {"OUT": 8}, "23 14") + sink(then, 8, "29 16") + "</Network>")
    ladder.append(rail() + contact(2, "a", 1) + coil("light", 2))
    network.append('<Network evaluationOrder="3"><RelPosition x="1" y="80"/>' + source(1, "a", "2 3")
                   + sink("light", 1, "20 3") + "</Network>")
    text = """<ST><![CDATA[ta(IN := a, PT := T#1s);
        IF ta.Q THEN a := FALSE; b := TRUE; END_IF
        tb(IN := b, PT := T#1s);
        IF tb.Q THEN b := FALSE; a := TRUE; END_IF
        light := a;]]></ST>"""
    calls = "<ST>l(light =&gt; q1); f(light =&gt; q2); s(light =&gt; q3);</ST>"
    (tmp_path / "plant.xml").write_text(project(
        blinker("Ladder", rungs(*ladder)) + blinker("Network", body("FBD", "".join(network)))
        + blinker("Text", body("ST", text))
        + program("l : Ladder; f : Network; s : Text; q1 AT %QX8.1 : BOOL; q2 AT %QX8.2 : BOOL;"
                  "q3 AT %QX8.3 : BOOL", body("ST", calls))))
    assert main(["run", str(tmp_path / "plant.xml"), "--scans", "500"]) == 0
    shown = [line.split()[-3:] for line in capsys.readouterr().out.splitlines() if line.startswith("scan")]
    assert len(shown) > 3
    assert all(line in (["q1=0", "q2=0", "q3=0"], ["q1=1", "q2=1", "q3=1"]) for line in shown)


def test_names_that_are_words_here(tmp_path: Path) -> None:
    """A variable `step`, a member `at`, a function block called like a standard one."""
    types = ('<DataTypeDecl name="Spot"><UserDefinedTypeSpec xsi:type="StructTypeSpec">'
             '<Member name="at"><Type>'
             "<TypeName>BOOL</TypeName></Type></Member></UserDefinedTypeSpec></DataTypeDecl>")
    own = ('<FunctionBlock name="SR"><Parameters><InputVars>' + variables("on : BOOL")
           + "</InputVars><OutputVars>" + variables("off : BOOL") + "</OutputVars></Parameters>"
           + body("ST", "<ST>off := NOT on;</ST>")
           + "</FunctionBlock>")
    text = texts(tmp_path, project(types + own + program("step : BOOL; spot : Spot; f : SR", rungs(
        rail() + contact(2, "step", 1) + block("SR", {"on": 2}, {"off": 3}, instanceName="f")
        + coil("spot.at", 3)))))
    for part in ("[step_]", "<f: SR_", "(spot.at_)", "FUNCTION_BLOCK SR_", "off := NOT on_;", ": SR_;"):
        assert part in text, part


def test_a_pou_that_stands_alone(tmp_path: Path) -> None:
    alone = program("a : BOOL; b : BOOL", rungs(rail() + contact(2, "a", 1) + coil("b", 2)))
    assert "[a] (b)" in texts(tmp_path, alone.replace("<Program ", f"<Program {XSI} ", 1))


DRAWN = program("a : BOOL; b : BOOL", rungs("{}"))


@pytest.mark.parametrize("types, told, shown", [
    (DRAWN.format(rail() + thing("Ld", "Lamp", wired(1) + out(2)) + coil("b", 2)),
     ["LD0145 an element Lamp is not read"], '<LdObject xsi:type="Lamp">'),
    (DRAWN.format(rail() + contact(2, "a", 1, blink="1") + coil("b", 2)),
     ["LD0145 an element Contact with blink is not read"],
     '<LdObject xsi:type="Contact" operand="a" blink="1">'),
    (DRAWN.format(rail() + contact(2, "a", 7) + coil("b", 2)),
     ["LD0146 main: contact 2 `a` at (10, 0) is connected to the element output 7, which does not exist"],
     '<Connection refConnectionPointOutId="7"/>'),
    (DRAWN.format(rail() + contact(2, "c", 1) + coil("b", 2)), ["LD0404 there is no variable `c` here"], "c"),
    (program("a : BOOL", body("SFC", thing("Sfc", "MacroStep", out(1), name="wash"))),
     ["LD0145 an element MacroStep is not read"], '<SfcObject xsi:type="MacroStep" name="wash">'),
    (program("a : BOOL", body("SFC", thing("Sfc", "Step", out(1), name="s", initialStep="true")
                              + thing("Sfc", "Transition",
                                      wired(1) + out(2)
                                      + '<Condition><Guess/><Reference name="a"/></Condition>')
                              + thing("Sfc", "JumpStep", wired(2), targetName="s"))),
     ["LD0145 a condition <Guess> is not read"], "<Guess/>"),
    (program("a : BOOL", '<Method name="Go"/>'), ["LD0145 <Method> of `main` is not read"],
     '<Method name="Go"/>'),
    ('<Class name="K"/>', ["LD0145 <Class> `K` is not read"], '<Class name="K"/>'),
])
def test_what_is_not_read_is_told_at_its_place(
    tmp_path: Path, types: str, told: list[str], shown: str
) -> None:
    made = read(tmp_path, project(types))
    found = [d for d in made.diagnostics if d.severity.name == "ERROR"]
    assert [f"{d.code} {d.message}" for d in found][:1] == told
    assert found[0].primary is not None and found[0].primary.span.text == shown
    assert made.image is None


def test_a_file_that_ends_or_is_changed_anywhere(tmp_path: Path) -> None:
    whole = project(TYPES + DRAWN.format(rail() + contact(2, "a", 1) + coil("b", 2)))
    for at in range(120, len(whole), 61):
        assert read(tmp_path, whole[:at]).image is None
        read(tmp_path, whole[:at] + whole[at + 7:])
        read(tmp_path, whole.replace(whole[at: at + 3], "7"))


# ---- charts


def step(name: str, number: int, above: int | None = None, actions: int | None = None, **more: str) -> str:
    acts = f'<ConnectionPointOutAction connectionPointOutId="{actions}"/>' if actions else ""
    return thing("Sfc", "Step", (wired(above) if above else "") + out(number) + acts, name=name, **more)


def way(above: int, number: int, condition: str, **more: str) -> str:
    inside = f"{wired(above)}{out(number)}<Condition>{condition}</Condition>"
    return thing("Sfc", "Transition", inside, **more)


def joint(kind: str, above: tuple[int, ...], below: tuple[int, ...]) -> str:
    return thing("Sfc", kind, "".join(map(wired, above)) + "".join(map(out, below)))


def does(actions: int, *acts: str) -> str:
    return thing("Common", "ActionBlocks", wired(actions) + "".join(
        f"<ActionBlock><ActionQualifier {act}</ActionBlock>" for act in acts))


def drawn(number: int, kind: str, inside: str) -> str:
    network = f'<GraphicalExpression xsi:type="{kind}"><RelPosition x="-17" y="-2"/>{inside}'
    return f"<GraphicalPredicate>{wired(number)}{network}</GraphicalExpression></GraphicalPredicate>"


def text_of(language: str, text: str) -> str:
    return f'<PredicateContent xsi:type="{language}"><{language}>{text}</{language}></PredicateContent>'


def test_a_chart_with_conditions_and_actions_of_all_kinds(tmp_path: Path) -> None:
    """Conditions as networks, ladders, text and names; numbers of outputs count through the whole chart."""
    compared = block("GT", {"IN1": 5, "IN2": 6}, {"OUT": 4}) + source(5, "One.T") + source(6, "T#1s")
    ladder = (rail(17) + thing("Ld", "CompareContact", wired(17) + out(18) + "<Type>TIME</Type>",
                               operand1="Two.T", operand2="T#1s", compareOperator="&gt;"))
    sequence = (
        step("Zero", 1, initialStep="true")
        + way(1, 2, f"<TextualPredicate>{text_of('ST', 'TRUE')}</TextualPredicate>")
        + joint("SelectionConvergence", (40, 2), (3,))
        + step("One", 7, 3, 8)
        + does(8, 'qualifier="N"/><ComplexOperand>light</ComplexOperand>',
               'qualifier="P1"/><ReferenceName>Counting</ReferenceName>',
               'qualifier="L" duration="T#300ms"/><ComplexOperand>horn</ComplexOperand>')
        + way(7, 9, drawn(4, "FbdNetwork", compared))
        + joint("SimultaneousDivergence", (9,), (10, 11))
        + step("Two", 12, 10) + step("Beside", 13, 11, 14)
        + does(14, 'qualifier="N"/><Inline><BodyContent xsi:type="ST"><ST>side := side + 1;</ST>'
                   "</BodyContent></Inline>")
        + joint("SimultaneousConvergence", (12, 13), (15,))
        + way(15, 16, drawn(18, "LadderRung", ladder))
        + step("Three", 19, 16)
        + way(19, 40, '<Reference name="transition_1"/>', priority="1")
        + way(19, 41, f'<TextualPredicate>{text_of("IL", "LD stop")}</TextualPredicate>', priority="2")
        + thing("Sfc", "JumpStep", wired(41), targetName="Zero"))
    more = ('<Action name="Counting"><Body><BodyContent xsi:type="ST"><ST>n := n + 1;</ST></BodyContent>'
            '</Body></Action><Transition name="transition_1"><Condition>'
            + text_of("ST", "transition_1 := Three.T &gt; T#500ms;") + "</Condition></Transition>")
    xml = project(program("light AT %QX0.0 : BOOL; horn AT %QX0.1 : BOOL; stop : BOOL;"
                          "n : INT; side : INT", body("SFC", sequence) + more))
    text = texts(tmp_path, xml)
    for part in ("INITIAL_STEP Zero:", "horn(L, T#300ms);", "FROM One TO (Two, Beside)",
                 "FROM (Two, Beside) TO Three", "(PRIORITY := 2) FROM Three TO Zero",
                 "transition_1 (PRIORITY := 1) FROM Three TO One"):
        assert part in text, part
    machine = Machine(read(tmp_path, xml).program, period_ns=100_000_000)
    shown = ""
    for _ in range(30):
        machine.scan()
        shown += str(int(machine.get("light"))) + str(int(machine.get("horn")))
    assert shown == "00" + "11" * 3 + "10" * 8 + "00" * 17 + "11"
    assert (machine.get("n"), machine.get("side")) == (2, 12)
