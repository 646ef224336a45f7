"""A sequential function chart as it is drawn: which steps a transition leads from and to, and its parts.

Wires are drawn at their lower end, so everything is found upwards: from a transition to the steps above it,
from a step to the transitions above it, through divergences and convergences.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, sfc
from ldc.parser import statements as st
from ldc.parser.plcopen import additional, boxes, findings, invocations, kept, texts
from ldc.parser.plcopen.body import ladder, rungs_of
from ldc.parser.plcopen.chart_parts import Parts
from ldc.parser.plcopen.conversions import written_out
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.drawing import CALLED, ELEMENTS, Drawing, is_call
from ldc.parser.plcopen.guarded import Additions
from ldc.patterns import Pattern
from ldc.source import Span

_JOINTS = ("selectionDivergence", "selectionConvergence", "simultaneousDivergence", "simultaneousConvergence")
_CHART = ("step", "transition", "jumpStep", "actionBlock", *_JOINTS)
_FLAGS = frozenset(("SFCINIT", "SFCRESET", "SFCERROR", "SFCENABLELIMIT", "SFCERRORSTEP", "SFCERRORPOU",
                    "SFCQUITERROR", "SFCPAUSE", "SFCTRANS", "SFCCURRENTSTEP", "SFCTIP", "SFCTIPMODE"))
_WORD = Pattern(r"[A-Za-z_]\w*+", re.ASCII)
_NOTES = ("comment", "vendorElement", "documentation", "addData", "label", "rightPowerRail")


class ChartReader:
    """Reads the chart ``body`` in ``holder`` of the POU ``pou``. ``where`` names the POU in messages;
    ``more`` takes what drawings need beside what is declared; ``around``: names in capitals of the actions
    that the chart is inside of; ``unread``: elements that were told to be none."""

    def __init__(self, pou: Node, holder: Node, body: Node, where: str, more: Additions,
                 diagnostics: Diagnostics, around: tuple[str, ...] = ()) -> None:
        self.pou, self.holder, self.body, self.where, self.more = pou, holder, body, where, more
        self.diagnostics, self.around = diagnostics, around
        self.nodes: dict[str, Node] = {}
        self.unread: set[str] = set()
        self._calls: dict[int, Node] = {}
        self._read: set[int] = set()
        self._rails = list(body.all("leftPowerRail"))
        for node in body.children:
            if node.tag in _CHART or node.tag in ELEMENTS:
                self._known(node)
            elif node.tag not in _NOTES:
                self.unread.add(node.get("localId").strip())
                message = f"{where}: <{node.tag[:40]}> is not read in a chart"
                findings.unsupported(diagnostics, node.span, message, "drawn here",
                                     "draw the steps that it stands for")
        steps = {node.get("localId").strip(): node for node in body.all("step")}
        self.parts = Parts(pou, body, steps, where, self._drawn, self._nested, diagnostics)
        found = [holder for tag in ("actions", "transitions") for holder in pou.all(tag)]
        ends = [(node.start, node.end) for node in (*found, body)]
        self.span = Span(body.span.source, min(start for start, _ in ends), max(end for _, end in ends))

    def _malformed(self, span: Span, message: str, help: str = "") -> None:
        findings.malformed(self.diagnostics, span, f"{self.where}: {message}", help)

    def _known(self, node: Node) -> None:
        id_ = node.get("localId").strip()
        if not id_ or id_ in self.nodes:
            what = f"two elements have the localId {id_[:20]}" if id_ else f"a {node.tag} has no localId"
            self._malformed(node.span, what)
        else:
            self.nodes[id_] = node

    def _drawn(self, node: Node, name: str, holder: Node) -> ast.LadderBody:
        return ladder(node, f"{self.where}.{name}", self.more, self.diagnostics, holder)

    def _nested(self, node: Node, name: str, holder: Node) -> st.StatementBody:
        return nested(self.pou, node, name, holder, self.where, self.more, self.diagnostics, self.around)

    # ---- the whole

    def chart(self) -> sfc.SfcBody:
        if not self.around:
            self._tell_flags()
        elsewhere = _needed(self.pou, self.body) - _named(self.body)
        actions = self.parts.actions(elsewhere)
        transitions = tuple(kept.transitions(self.holder, list(self._transitions())))
        calls = (*self._shown(), *self._called())
        steps = self.parts.steps([call.name for call in calls])
        return sfc.SfcBody(steps, transitions, (*actions, *self.parts.inline, *calls), self.span)

    def _tell_flags(self) -> None:
        """Variables that control or watch a chart in editors of the CODESYS family, when they are declared."""
        for node in self.pou.descendants("variable"):
            if node.get("name").strip().upper() in _FLAGS and additional.FAMILY in self.pou.document.source.text:
                findings.chart_flag(self.diagnostics, node.attribute("name"), node.get("name").strip())

    def _transitions(self) -> Iterator[tuple[Node, sfc.Transition]]:
        """In the order in which they are drawn, each with what draws it."""
        targets: dict[str, list[ast.Name]] = {}
        for node in self.body.all("step", "jumpStep"):
            attribute = "name" if node.tag == "step" else "targetName"
            step = texts.name(node, self.diagnostics, attribute)
            for above in self._above(node):
                if above.tag != "transition":
                    self._wrong(node, above, "a transition")
                elif step is not None:
                    known = targets.setdefault(above.get("localId").strip(), [])
                    if all(name.name.upper() != step.upper() for name in known):
                        known.append(ast.Name(step, node.attribute(attribute)))
        drawn = list(self.body.all("transition"))
        if any(self._position(node) for node in drawn):
            drawn.sort(key=self._position)
        priorities = {node.get("priority").strip() for node in drawn}
        for number, node in enumerate(drawn, 1):
            sources = []
            for above in self._above(node):
                if above.tag != "step":
                    self._wrong(node, above, "a step")
                elif (name := texts.name(above, self.diagnostics)) is not None:
                    sources.append(ast.Name(name, above.attribute("name")))
            leads = targets.get(node.get("localId").strip(), [])
            if not sources or not leads:
                if self.unread:  # it may have led there
                    continue
                why = "no step is above it" if not sources else "it leads to no step"
                self._malformed(node.span, f"a transition is not connected: {why}",
                                "connect it in the editor that the file comes from")
                continue
            given = bool(node.get("priority").strip()) and len(priorities) > 1
            priority = node.number("priority") if given else None
            condition, name = self._condition(node, number)
            if condition is not None:
                yield node, sfc.Transition(name, priority, tuple(sources), tuple(leads), condition,
                                           node.whole, node.span)

    def _position(self, node: Node) -> int:
        at = node.find("position")
        return at.number("x") if at is not None else 0

    def _wrong(self, node: Node, above: Node, wanted: str) -> None:
        self._malformed(node.span, f"above a {node.tag} stands {wanted}, not a {above.tag}",
                        "steps and transitions alternate: draw the chart again")

    # ---- upwards

    def _wires(self, node: Node) -> Iterator[Node]:
        """What an element is wired to."""
        for point in node.all("connectionPointIn"):
            for wire in point.all("connection"):
                id_ = wire.get("refLocalId").strip()
                found = self.nodes.get(id_)
                if found is not None:
                    yield found
                elif id_ not in self.unread:
                    findings.no_such_element(self.diagnostics, wire.span, f"{self.where}: {node.tag} "
                                             f"{node.get('localId')[:20]}", f"the element {id_[:20]}")

    def _above(self, node: Node) -> Iterator[Node]:
        """Steps and transitions above an element, from left to right. Several above a transition wait for
        each other, so a choice may only be joined above a step. A branch of a choice that ends with a jump
        joins nothing, though CODESYS wires the jump to the convergence."""
        seen: set[int] = set()
        work = list(self._wires(node))[::-1]
        while work:
            above = work.pop()
            if id(above) in seen:
                continue
            seen.add(id(above))
            if above.tag not in _JOINTS:
                yield above
                continue
            joined = list(self._wires(above))
            if above.tag == "selectionConvergence":
                joined = [wired for wired in joined if wired.tag != "jumpStep"]
            if above.tag == "selectionConvergence" and node.tag == "transition" and len(joined) > 1:
                self._wrong(node, above, "a step")
                continue
            work += reversed(joined)

    # ---- conditions

    def _condition(self, node: Node, number: int) -> tuple[ast.Expr | sfc.Body | None, str | None]:
        """The condition, and the name of the transition when that is a body."""
        condition = node.find("condition")
        point = None
        if condition is not None:
            point = condition.find("connectionPointIn")
            if point is None and condition.find("connection") is not None:  # TC6 1.0
                point = condition.like("connectionPointIn", condition.children)
        if point is None:
            return self.parts.condition(node, condition, number)
        sources = [self.nodes.get(wire.get("refLocalId").strip()) for wire in point.all("connection")]
        negated = condition.flag("negated")
        self._read |= {id(source) for source in sources}
        if len(sources) == 1 and sources[0] is not None and boxes.drawn(sources[0]).tag == "inVariable":
            text = sources[0].find("expression")
            value = texts.expression(text.content, self.diagnostics) if text is not None else None
            negated ^= sources[0].flag("negated")
            return texts.negated(value) if negated and value is not None else value, None
        return self._drawing(node, point, negated, number)

    def _drawing(self, node: Node, point: Node, negated: bool, number: int
                 ) -> tuple[ast.LadderBody | None, str | None]:
        """A condition drawn with contacts and blocks: all that leads to it, as a rung. Function blocks are
        called in every execution of the chart, also when the step above is not active: a timer that stood
        still would not see that its input is FALSE. The condition reads their outputs."""
        name = self.parts.fresh(f"transition_{number}")
        goal = node.like(node.tag, [point], {"localId": node.get("localId"), "name": name,
                                             "negated": "true" if negated else "false"})
        used: dict[int, Node] = {id(node): goal}
        self._feeding([goal], used, calls_end=True)
        calls = [found for found in used.values() if is_call(found, self.more)]
        if calls:  # EN at the rail is no condition
            used |= {id(rail): rail for rail in self._rails}
        behind = dict(self._calls) | {id(call): call for call in calls}
        self._feeding([call for call in calls if id(call) not in self._calls], behind)
        if any(found.tag in _CHART and found is not goal for found in (*used.values(), *behind.values())):
            self._malformed(node.span, "the condition of a transition is wired to the chart itself",
                            "wire it to contacts, blocks and variables")
            return None, None
        self._calls = behind
        self._read |= used.keys() | behind.keys()
        parts = [part.like(CALLED, part.children) if is_call(part, self.more) else part
                 for part in used.values()]
        return rungs_of(self._of(parts, ("transition",)), self.diagnostics), name

    def _feeding(self, work: list[Node], found: dict[int, Node], calls_end: bool = False) -> None:
        """Adds all that leads to the elements ``work``; but not, if so, what leads to calls."""
        while work:
            for pin in _points(work.pop()):
                for wire in pin.all("connection"):
                    node = self.nodes.get(wire.get("refLocalId").strip())
                    if node is not None and id(node) not in found:
                        found[id(node)] = node
                        if not (calls_end and is_call(node, self.more)):
                            work.append(node)

    def _of(self, nodes: Iterable[Node], goals: tuple[str, ...] = ()) -> Drawing:
        """A part of what is drawn beside the chart."""
        body = self.body.like(self.body.tag, sorted(nodes, key=lambda node: node.start))
        return Drawing(body, self.where, self.more, self.diagnostics, goals)

    def _shown(self) -> tuple[sfc.Action, ...]:
        """Variables that are wired to steps, which show whether these are active, as one action. What else is
        drawn beside the chart is executed like function blocks that conditions are wired to."""
        rest = {id(node): node for node in self.nodes.values()
                if node.tag not in (*_CHART, "leftPowerRail") and id(node) not in self._read}
        found: list[st.Assign] = []
        for node in list(rest.values()):
            sources = [self.nodes.get(id_) for id_, _ in node.wires()]
            target = node.words("variable" if node.tag == "coil" else "expression")
            if target is None or len(sources) != 1 or sources[0] is None or sources[0].tag != "step":
                continue
            if boxes.drawn(node) is node and not boxes.modifier(node, "storage"):
                del rest[id(node)]
                step = ast.Name(sources[0].get("name").strip(), sources[0].attribute("name"))
                value: ast.Expr = ast.Member(step, "X", node.span)
                value = texts.negated(value) if node.flag("negated") else value
                place = texts.expression(target, self.diagnostics)
                found += [st.Assign(place, value, node.whole)] if place is not None else []
        behind = dict(rest)
        self._feeding(list(rest.values()), behind)
        for node in list(behind.values()):
            if node.tag in _CHART:
                self._malformed(node.span, f"a {node.tag} is wired to a drawing beside the chart",
                                "read `step.X` there, or set a variable in an action of the step")
                behind = {}
                break
        self._calls = {**self._calls, **behind}
        if not found:
            return ()
        name, span = self.parts.fresh("shown"), self.body.span
        return (sfc.Action(name, st.StatementBody(tuple(found), span), span, span),)

    def _called(self) -> tuple[sfc.Action, ...]:
        """The function blocks that conditions are wired to, what leads to them, and what is drawn beside the
        chart, as one action."""
        if not self._calls:
            return ()
        body, span = rungs_of(self._of(self._calls.values()), self.diagnostics), self.body.span
        if not (body.rungs or body.unread):
            return ()
        return (sfc.Action(self.parts.fresh("blocks"), body, span, span),)


def nested(pou: Node, node: Node, name: str, holder: Node, where: str, more: Additions,
           diagnostics: Diagnostics, around: tuple[str, ...] = ()) -> st.StatementBody:
    """The chart ``node`` that is the body of an action of a POU: the call of a function block, which has the
    actions that the chart names, and stands still while the action is not executed."""
    where = f"{where}.{name}"
    named = _needed(pou, node)
    if not named.isdisjoint((name.upper(), *around)):
        message = f"{where}: a chart names the action that it is inside of"
        findings.unsupported(diagnostics, node.span, message, "an SFC",
                             "make it a function block, and call that")
        return st.StatementBody((), node.span)
    parts = [part if part.tag != "actions" else part.like("actions", [
        action for action in part.children if action.get("name").strip().upper() in named])
        for part in pou.children]
    inside = more.inside()
    own = pou.like(pou.tag, parts)
    chart = ChartReader(own, holder, node, where, inside, diagnostics, (*around, name.upper())).chart()
    if any(isinstance(body, ast.TextBody) for body in sfc.bodies(chart)):
        message = f"{where}: a chart inside of an action has a body in IL"
        findings.unsupported(diagnostics, node.span, message, "an SFC", "write the body in Structured Text")
        return st.StatementBody((), node.span)
    chart = invocations.standard(chart, more.local, more.interfaces)
    if more.numbers:
        pins = invocations.numbers(more.local, more.interfaces)
        chart = written_out(chart, more.numbers, pins, diagnostics)
    return more.chart(texts.label(where, "chart"), f"{name}_chart", chart, inside.variables,
                      _words(pou, {name.upper(), *named}), node.span)


def _named(chart: Node) -> set[str]:
    """Names in capitals of the actions that a chart may name."""
    return ({found.get("name").strip().upper() for found in chart.descendants("reference")}
            | {found.content.text.upper() for found in chart.descendants("attribute")})


def _needed(pou: Node, chart: Node) -> set[str]:
    """The same, with those of the charts that are in actions which it names."""
    known = {action.get("name").strip().upper(): action
             for holder in pou.all("actions") for action in holder.all("action")}
    found: set[str] = set()
    work = list(_named(chart))
    while work:
        name = work.pop()
        if name not in found:
            found.add(name)
            work += [one for inner in _charts(known.get(name)) for one in _named(inner)]
    return found


def _charts(action: Node | None) -> Iterator[Node]:
    for holder in action.all("body") if action is not None else ():
        yield from holder.all("SFC")


def _words(pou: Node, without: set[str]) -> frozenset[str]:
    """The words in the bodies of a POU, in capitals, but not in actions of these names."""
    parts = [part for holder in pou.all("actions") for part in holder.all("action")
             if part.get("name").strip().upper() not in without]
    parts += pou.all("body", "transitions")
    return frozenset(word.upper() for part in parts for word in _WORD.findall(part.whole.text))


def _points(node: Node) -> Iterator[Node]:
    """The inputs of an element of LD or FBD."""
    yield from node.all("connectionPointIn")
    for group in node.all("inputVariables", "inOutVariables"):
        for pin in group.all("variable"):
            yield from pin.all("connectionPointIn")
