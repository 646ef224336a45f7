"""Sequential function charts in PLCopen XML: what each drawn part becomes, what is told about wrong ones."""

from __future__ import annotations

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plcopen_xml import block, coil, contact, element, project, rail, value, variables, wires

from ldc import pipeline
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.source import SourceFile
from runtime.vm.machine import Machine

PERIOD = 10_000_000
DECLARED = "go back x y z q : BOOL; n k : INT; warm : TON; pause : TIME"


def step(id_: int, name: str, above=None, initial: bool = False, more: str = "", at=None) -> str:
    first = {"initialStep": "true"} if initial else {}
    return element("step", id_, wires(above) + more, at, name=name, **first)


def way(id_: int, above, condition: str, at=None, **attributes) -> str:
    return element("transition", id_, f"{wires(above)}<condition>{condition}</condition>", at, **attributes)


def joint(id_: int, tag: str, *above) -> str:
    return element(tag, id_, "".join(map(wires, above)))


def jump(id_: int, target: str, above) -> str:
    return element("jumpStep", id_, wires(above), targetName=target)


def when(text: str) -> str:
    return f'<inline name=""><ST>{text}</ST></inline>'


def named(name: str) -> str:
    return f'<reference name="{name}"/>'


def does(id_: int, above, *actions: str) -> str:
    return element("actionBlock", id_, wires(above) + "".join(actions))


def act(inner: str, qualifier: str = "", **attributes) -> str:
    given = {"qualifier": qualifier} if qualifier else {}
    return element("action", 900, inner, None, **given, **attributes)


Bodies = dict[str, str] | None


def chart(*parts: str, actions: Bodies = None, transitions: Bodies = None) -> str:
    """A project with one program that is a chart; bodies of actions and transitions by name."""
    more = ""
    for tag, bodies in (("action", actions), ("transition", transitions)):
        inner = "".join(f'<{tag} name="{name}"><body>{body}</body></{tag}>'
                        for name, body in (bodies or {}).items())
        more += f"<{tag}s>{inner}</{tag}s>" if inner else ""
    return project(f'<pou name="main" pouType="program"><interface><localVars>{variables(DECLARED)}'
                   f"</localVars></interface>{more}<body><SFC>\n{''.join(parts)}</SFC></body></pou>")


def compiled(text: str) -> pipeline.Compiled:
    return pipeline.compile_project(Sources((SourceFile("plc.xml", text),), Settings(), None))


def codes(text: str) -> list[str]:
    return [d.code for d in compiled(text).diagnostics]


def trace(text: str, names: str, **inputs: str) -> list[str]:
    """A line of digits for each name; inputs likewise, a digit for each scan."""
    result = compiled(text)
    assert not result.diagnostics.has_errors, [f"{d.code} {d.message}" for d in result.diagnostics]
    machine = Machine(result.program, period_ns=PERIOD)
    rows = {name: "" for name in names.split()}
    for scan in range(len(next(iter(inputs.values())))):
        for name, values in inputs.items():
            machine.set(name, values[scan] == "1")
        machine.scan()
        assert not machine.faults
        for name in rows:
            rows[name] += str(int(machine.get(name)))
    return list(rows.values())


def two(condition: str, *more: str, **bodies) -> str:
    """A, left by ``condition``, and B, left by ``back``."""
    return chart(step(1, "A", None, True), way(2, 1, condition), step(3, "B", 2), way(4, 3, named("back")),
                 jump(5, "A", 4), *more, **bodies)


def test_flags_of_charts_are_told_where_they_have_a_meaning() -> None:
    text = two(named("go")).replace("<localVars>", f"<localVars>{variables('SFCPause : BOOL')}")
    assert codes(text) == []
    family = '<addData><data name="http://www.3s-software.com/plcopenxml/x"/></addData>'
    assert codes(text.replace("<types>", f"{family}<types>")) == ["LD0160"]


def test_steps_a_jump_and_an_action_block() -> None:
    text = two(when("go AND NOT x"), does(6, 3, act(named("q")), act(named("count"), "P1")),
               actions={"count": "<ST>n := n + 1;</ST>"})
    got = trace(text, "A.X B.X q n", go="01101", x="01000", back="00010")
    assert got == ["11010", "00101", "00101", "00112"]


def test_a_choice_goes_from_left_to_right_or_by_priority() -> None:
    def choice(left: dict, right: dict) -> str:
        return chart(
            step(1, "A", None, True), joint(2, "selectionDivergence", 1),
            way(3, 2, named("go"), (50, 10), **right), way(4, 2, named("x"), (20, 10), **left),
            step(5, "B", 3), step(6, "C", 4), way(7, 5, named("back")), way(8, 6, named("back")),
            joint(9, "selectionConvergence", 7, 8), jump(10, "A", 9))

    given = {"go": "01001", "x": "01000", "back": "00100"}
    assert trace(choice({}, {}), "A.X B.X C.X", **given) == ["10110", "00001", "01000"]
    ranked = choice({"priority": 2}, {"priority": 1})
    assert trace(ranked, "A.X B.X C.X", **given) == ["10110", "01001", "00000"]


def test_a_branch_that_ends_with_a_jump_joins_nothing() -> None:
    """CODESYS wires the jump to the convergence below it."""
    text = chart(
        step(1, "A", None, True), joint(2, "selectionDivergence", 1), way(3, 2, named("go")),
        way(4, 2, named("x")), step(5, "B", 3), way(6, 5, named("back")), jump(7, "A", 6), step(8, "C", 4),
        way(9, 8, named("back")), joint(10, "selectionConvergence", 7, 9), step(11, "D", 10),
        way(12, 11, named("y")), jump(13, "A", 12))
    given = {"go": "01000000", "x": "00010000", "back": "00101000", "y": "00000010"}
    assert trace(text, "A.X B.X C.X D.X", **given) == ["10100011", "01000000", "00010000", "00001100"]
    assert codes(text) == []


def test_simultaneous_sequences() -> None:
    text = chart(
        step(1, "A", 12, True), way(2, 1, named("go")), joint(3, "simultaneousDivergence", 2),
        step(4, "B", 3), step(5, "C", 3), way(6, 4, named("x")), step(7, "D", 6),
        joint(8, "simultaneousConvergence", 7, 5), way(12, 8, named("y")))
    assert trace(text, "A.X B.X C.X D.X", go="0100000", x="0001000", y="0010010") == [
        "1000011", "0110000", "0111100", "0001100"]
    assert codes(text) == []


@pytest.mark.parametrize(("condition", "parts", "opens"), [
    (named("x"), "", "x"),
    ('<connectionPointIn><connection refLocalId="20"/></connectionPointIn>', value(20, "x"), "x"),
    ('<connection refLocalId="20"/>', value(20, "x"), "x"),
    ('<connectionPointIn><connection refLocalId="21"/></connectionPointIn>',
     rail(20) + contact(21, "x", 22) + contact(22, "y", 20, negated="true"), "x and not y"),
    ('<connectionPointIn><connection refLocalId="21"/><connection refLocalId="22"/></connectionPointIn>',
     rail(20) + contact(21, "x", 20) + contact(22, "y", 20), "x or y"),
    ('<connectionPointIn><connection refLocalId="21" formalParameter="OUT"/></connectionPointIn>',
     block(21, "AND", {"IN1": 22, "IN2": 23}, ["OUT"]) + value(22, "x") + value(23, "y"), "x and y"),
    (when("x OR y AND NOT z"), "", "x or y and not z"),
    (when(":= x AND y;"), "", "x and y"),
    (when("<xhtml:p xmlns:xhtml='u'><![CDATA[x AND y]]></xhtml:p>"), "", "x and y"),
])
@pytest.mark.parametrize("negated", [False, True])
def test_conditions(condition: str, parts: str, opens: str, negated: bool) -> None:
    text = two(condition, parts)
    if negated:
        text = text.replace("<condition>", '<condition negated="true">', 1)
        opens = f"not ({opens})"
    for bits in range(8):
        values = {name: bool(bits >> n & 1) for n, name in enumerate("xyz")}
        got, = trace(text, "B.X", **{name: str(int(on)) * 2 for name, on in values.items()})
        assert got == f"0{int(eval(opens, {}, values))}", (values, opens)


def test_timers_that_are_wired_to_transitions_are_called_in_every_execution() -> None:
    """Otherwise one would not see that its step has ended, and the next round would not wait."""
    timer = block(21, "TON", {"IN": 20, "PT": 22}, ["Q", "ET"], "warm") + value(22, "T#20ms")
    assert trace(two(wires("21.Q"), timer + rail(20)), "B.X", back="000000") == ["000111"]
    got = trace(two(wires("21.Q"), timer + value(20, "A.X")), "B.X warm.IN", back="000010000000")
    assert got == ["000100011111", "111011100000"]


def test_what_several_conditions_are_wired_to_is_called_once() -> None:
    counter = block(21, "CTU", {"EN": 20, "CU": 23, "R": 24, "PV": 22}, ["ENO", "Q", "CV"],
                    "count") + value(22, "2") + rail(20)
    compared = block(25, "EQ", {"IN1": "21.CV", "IN2": 26}, ["OUT"]) + value(26, "0")
    text = chart(step(1, "A", None, True), way(2, 1, wires("21.Q")), step(3, "B", 2),
                 way(4, 3, wires(("25.OUT", "27"))), jump(5, "A", 4), counter, compared,
                 contact(23, "x", 20), contact(24, "y", 20), contact(27, "z", "21.ENO"))
    text = text.replace("<localVars>", f"<localVars>{variables('count : CTU')}", 1)
    rounds = trace(text, "B.X count.CV", x="0101000100", y="0000001000", z="0000000000")
    assert rounds == ["0000111000", "0112220111"]
    assert trace(text, "B.X", x="0101000000", y="0000000000", z="0000000100") == ["0000111011"]


COUNTS = value(3, "n") + value(4, "1") + element(
    "outVariable", 5, wires("2.OUT") + "<expression>n</expression>")
DRAWN = "<FBD>" + block(2, "ADD", {"IN1": 3, "IN2": 4}, ["OUT"]) + COUNTS + "</FBD>"


@pytest.mark.parametrize(("language", "body"), [
    ("ST", "<ST>n := n + 1;</ST>"),
    ("IL", "<IL>LD n\nADD 1\nST n\n</IL>"),
    ("LD", "<LD>" + rail(1) + block(2, "ADD", {"EN": 1, "IN1": 3, "IN2": 4}, ["OUT"]) + COUNTS + "</LD>"),
    ("FBD", DRAWN),
])
def test_actions_in_every_language(language: str, body: str) -> None:
    by_name = two(named("go"), does(6, 3, act(named("count"))), actions={"count": body})
    inside = two(named("go"), does(6, 3, act(f"<inline>{body}</inline>")))
    for text in (by_name, inside):
        assert trace(text, "n", go="010000", back="000100") == ["012333"], language


@pytest.mark.parametrize("body", [
    "<ST>:= x AND y;</ST>", "<ST>x AND y</ST>", "<ST>opens := x AND y;</ST>",
    "<ST>IF x THEN opens := y; END_IF;</ST>", "<IL>LD x\nAND y</IL>", "<IL>LD x\nAND( y\n)</IL>",
    "<IL>LD x\nAND y\nST opens\nJMPC over\nLD k\nST n\nover:</IL>", "<IL>LDN x\nRETC\nLD y</IL>",
    "<LD>" + rail(1) + contact(2, "x", 1) + contact(3, "y", 2) + coil(4, "opens", 3) + "</LD>",
    "<FBD>" + block(2, "AND", {"IN1": 3, "IN2": 4}, ["OUT"]) + value(3, "x") + value(4, "y")
    + element("outVariable", 5, wires("2.OUT") + "<expression>opens</expression>") + "</FBD>",
])
def test_transitions_by_name_in_every_language(body: str) -> None:
    text = two(named("opens"), transitions={"opens": body})
    assert trace(text, "A.X", x="00101", y="01101", back="00000") == ["11000"]


@pytest.mark.parametrize(("qualifier", "duration", "on"), [
    ("N", "", "01110000"), ("L", "T#20ms", "01100000"), ("L", "20ms", "01100000"),
    ("L", "PT0.02S", "01100000"), ("D", "T#20ms", "00010000"), ("D", "T#0s", "01110000"),
    ("SD", "pause", "00011111"), ("SL", "T#40ms", "01111000"), ("S", "", "01111111"),
    ("P0", "", "00001000"), ("DS", "T#20ms", "00011111"),
])
def test_qualifiers_and_durations(qualifier: str, duration: str, on: str) -> None:
    given = {"duration": duration} if duration else {}
    text = two(named("go"), does(6, 3, act(named("q"), qualifier, indicator="z", **given)))
    pause = 'name="pause"><type><TIME/></type>'
    text = text.replace(pause, f'{pause}<initialValue><simpleValue value="T#20ms"/></initialValue>')
    assert trace(text, "q", go="01000000", back="00001000") == [on]


def vendor(guid: str, action: str) -> str:
    return (f'<addData><data name="http://www.3s-software.com/plcopenxml/sfc/element"><attributes xmlns="">'
            f'<attribute guid="{guid}">{action}</attribute></attributes></data></addData>')


@pytest.mark.parametrize(("guid", "on"), [
    ("700a583f-b4d4-43e4-8c14-629c7cd3bec8", "0123333"), ("a6b08bd8-b696-47e3-9cbf-7408b61c9ff8", "0111111"),
    ("a2621e18-7de3-4ea6-ae6d-89e9e0b7befd", "0000111"),
])
@pytest.mark.parametrize("body", ["<ST>n := n + 1;</ST>", DRAWN])
def test_what_one_vendor_puts_into_steps_has_no_final_execution(guid: str, on: str, body: str) -> None:
    text = chart(step(1, "A", None, True), way(2, 1, named("go")),
                 step(3, "B", 2, more=vendor(guid, "count")), way(4, 3, named("back")), jump(5, "A", 4),
                 actions={"count": body})
    assert trace(text, "n", go="0100000", back="0000100") == [on]


INNER = (step(1, "Low", 4, initial=True) + does(9, 1, act(named("Level"))) + way(2, 1, when("go"))
         + step(3, "High", 2) + does(10, 3, act(named("z")), act('<inline><ST>k := k + 1;</ST></inline>'))
         + way(4, 3, when("High.T &gt;= T#20ms")))
LEVEL = f"<LD>{rail()}{contact(2, 'back', 1, edge='rising')}{coil(3, 'y', 2)}</LD>"


def outer(inner: str, **actions: str) -> str:
    """On and off by `x`; while it is on, a chart is executed."""
    return chart(step(1, "Rest", 4, initial=True), way(2, 1, named("x")), step(3, "Busy", 2),
                 does(5, 3, act(named("Nested"))), way(4, 3, when("NOT x")),
                 actions={"Nested": f"<SFC>{inner}</SFC>", **actions})


def test_a_chart_inside_of_an_action_stands_still_while_that_is_not_executed() -> None:
    """It is executed while the step is active, and once more when that ends; then it goes on where it was."""
    xml = outer(INNER, Level=LEVEL)
    assert codes(xml) == []
    x, go, back = "01110000111111", "00010000000000", "01011111001000"
    assert trace(xml, "Busy.X y z k", x=x, go=go, back=back) == [
        "01110000111111", "01011111001000", "00011111000000", "00012222333333"]


def test_a_timer_of_a_chart_inside_of_an_action_goes_with_it() -> None:
    text = INNER.replace("k := k + 1;", "k := k + 1; warm(IN := go, PT := T#20ms); q := warm.Q;")
    x, go = "0111111111", "0001111111"
    assert trace(outer(text, Level=LEVEL), "q k", x=x, go=go) == ["0000011111", "0001234567"]
    shared = outer(text, Level=LEVEL).replace("NOT x", "NOT warm.Q")
    assert trace(shared, "Busy.X q k", x=x, go=go) == ["0101011111", "0000011111", "0001234567"]


def test_a_chart_inside_of_an_action_may_hold_another_one_but_not_itself() -> None:
    deeper = step(1, "A", 4, initial=True) + way(2, 1, when("go")) + step(3, "B", 2) + does(
        9, 3, act(named("Deep"))) + way(4, 3, when("FALSE"))
    xml = outer(deeper, Deep=f"<SFC>{INNER}</SFC>", Level=LEVEL)
    assert codes(xml) == []
    names = [pou.name for pou in compiled(xml).model.pous.values()]
    assert [name for name in names if name.startswith("main_")] == ["main_Nested_Deep", "main_Nested"]
    for inner, more in ((deeper.replace("Deep", "Nested"), {}), (deeper, {"Deep": f"<SFC>{deeper}</SFC>"}),
                        (deeper, {"Deep": f"<SFC>{deeper.replace('Deep', 'Nested')}</SFC>"})):
        found = [d for d in compiled(outer(inner, **more)).diagnostics if d.severity.name == "ERROR"]
        assert [d.code for d in found] == ["LD0145"]
        assert "names the action that it is inside of" in found[0].message


def test_a_chart_inside_of_an_action_in_il_is_told_and_inputs_are_inputs_of_it() -> None:
    assert "LD0145" in codes(outer(INNER, Level="<IL>LD go\nST y</IL>"))
    xml = outer(INNER, Level=LEVEL).replace(
        variables("go : BOOL"), f"</localVars><inputVars>{variables('go : BOOL')}</inputVars><localVars>")
    made = compiled(xml)
    assert made.image is not None
    assert [v.name for v in made.model.pous["MAIN_NESTED"].signature.inputs] == ["go"]


def shows(id_: int, name: str, source: str, **more: str) -> str:
    return element("outVariable", id_, f"{wires(source)}<expression>{name}</expression>", **more)


def test_variables_that_are_wired_to_steps_show_whether_they_are_active() -> None:
    """As in the example of a chart in the format's own description."""
    xml = chart(step(1, "One", 3, initial=True), way(2, 1, named("go")), step(4, "Two", 2),
                way(3, 4, named("back")), shows(5, "x", "1.x"), shows(6, "y", "4.x", negated="true"),
                coil(7, "z", "4.x"))
    one, two = "1001000", "0110111"
    assert trace(xml, "x y z One.X", go="0100100", back="0001000") == [one, one, two, one]


def test_what_is_drawn_beside_a_chart_is_executed_or_told() -> None:
    xml = chart(step(1, "One", initial=True), rail(7), contact(8, "go", 7), coil(9, "q", 8),
                value(10, "n"), value(11, "1"), block(12, "ADD", {"IN1": 10, "IN2": 11}, ["OUT"]),
                shows(13, "n", 12))
    assert trace(xml, "q n", go="0110") == ["0110", "1234"]
    found = compiled(chart(step(1, "One", initial=True), value(2, "x"))).diagnostics
    assert [d.code for d in found] == ["LD0147"]
    wired = chart(step(1, "One", initial=True), contact(2, "go", "1.x"), coil(3, "q", 2))
    assert codes(wired) == ["LD0144"]


def test_a_drawn_condition_does_not_take_the_name_of_a_transition() -> None:
    """`transition_1` is what a condition without a name is called, and what a transition may be called."""
    xml = chart(step(1, "One", 4, initial=True), rail(7), contact(8, "go", 7),
                element("transition", 2, f"{wires(1)}<condition>{wires(8)}</condition>"), step(3, "Two", 2),
                way(4, 3, named("Transition_1")),
                transitions={"Transition_1": "<ST>IF back THEN Transition_1 := TRUE; END_IF;</ST>"})
    assert trace(xml, "One.X Two.X", go="01000", back="00010") == ["10011", "01100"]


def test_names_of_actions_that_others_have() -> None:
    text = two(named("go"), does(6, 3, act(named("B")), act(named("q"))),
               actions={"B": "<ST>n := n + 1;</ST>"})
    assert trace(text, "n q", go="01000", back="00000") == ["01234", "01111"]


def test_bodies_number_their_elements_alike() -> None:
    """Instances that drawings need get names of their own."""
    rising = {"EN": 'edge="rising"'}
    edge = ("<LD>" + rail(1) + block(2, "ADD", {"EN": 3, "IN1": 4, "IN2": 5}, ["OUT"], modified=rising)
            + contact(3, "x", 1) + value(4, "{0}") + value(5, "1")
            + element("outVariable", 6, wires("2.OUT") + "<expression>{0}</expression>") + "</LD>")
    text = two(named("go"), does(6, 1, act(named("one")), act(named("other"))),
               actions={"one": edge.replace("{0}", "n"), "other": edge.replace("{0}", "k")})
    assert trace(text, "n k", x="010110") == ["011222"] * 2


WRONG = [
    (two(named("go"), element("macroStep", 9, wires(2), name="Wash")), ["LD0145"]),
    (two(named("nothing")), ["LD0404"]),
    (two(""), ["LD0144"]),
    (two(named("go"), way(9, None, named("x"))), ["LD0144"]),
    (two(named("go"), way(9, 1, named("x"))), ["LD0144"]),
    (two(named("go"), jump(9, "A", 77)), ["LD0146"]),
    (two(named("go"), step(1, "W")), ["LD0144"]),
    (two(named("go"), step(9, "W", 1)), ["LD0144"]),
    (chart(step(1, "A", None, True), way(2, 1, named("go")), jump(3, "Nowhere", 2)), ["LD0228"]),
    (two(named("go"), does(9, 3, act(named("q"), "L"))), ["LD0144"]),
    (two(named("go"), does(9, 3, act(named("q"), "DL"))), ["LD0145"]),
    (two(named("go"), does(9, 3, act(""))), ["LD0144"]),
    (two(named("go"), does(9, 2, act(named("q")))), ["LD0144"]),
    (two(named("go"), does(9, 3, act(named("none")))), ["LD0229"]),
    (two(when("x :=")), ["LD0101"]),
    (two('<connectionPointIn><connection refLocalId="3"/></connectionPointIn>'), ["LD0144"]),
    (chart(step(1, "A", None, True), way(2, 1, named("go")), way(3, 2, named("x")), jump(4, "A", 3)),
     ["LD0144", "LD0144", "LD0144"]),
    (two(named("go"), does(9, 3, act(named("a"))), actions={"a": "<SFC></SFC>"}), ["LD0226"]),
    (two(named("go"), step(9, "W", more=vendor("01580b27-6378-448b-8ecb-0e4b795b58d6", "TRUE"))), ["LD0145"]),
    (chart(), ["LD0226"]),
]


@pytest.mark.parametrize(("text", "wanted"), WRONG, ids=range(len(WRONG)))
def test_what_is_wrong_is_told(text: str, wanted: list[str]) -> None:
    assert sorted(codes(text)) == wanted


WHOLE = two(named("go"), does(6, 3, act(named("q"), "D", duration="T#1s"), act(named("count"), "P1")),
            joint(7, "selectionDivergence", 1), way(8, 7, '<connectionPointIn><connection refLocalId="21"/>'
                                                          "</connectionPointIn>"), jump(9, "B", 8),
            rail(20), contact(21, "x", 20), actions={"count": "<ST>n := n + 1;</ST>"},
            transitions={"opens": "<ST>x</ST>"})


def test_the_whole_of_the_broken_ones_is_right() -> None:
    assert codes(WHOLE) == []


@settings(deadline=None, suppress_health_check=list(HealthCheck), max_examples=120)
@given(st.integers(0, len(WHOLE)), st.integers(1, 60),
       st.sampled_from(("", '"', "</SFC>", "<step/>", "1", "refLocalId")))
def test_broken_files_give_findings_only(start: int, length: int, put: str) -> None:
    result = compiled(WHOLE[:start] + put + WHOLE[start + length:])
    assert result.program is not None or result.diagnostics.has_errors


def test_wires_in_circles_end() -> None:
    ring = chart(step(1, "A", 5, True), joint(4, "selectionConvergence", 5),
                 joint(5, "selectionConvergence", 4))
    assert set(codes(ring)) <= {"LD0144", "LD0230"}
