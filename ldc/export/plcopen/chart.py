"""A sequential function chart as an SFC body: steps with their action blocks, transitions, the bars between
them, jumps; all wires are vertical."""

from __future__ import annotations

from collections.abc import Sequence
from xml.etree.ElementTree import Element

from ldc.export.plcopen.chart_places import Extent, chart_places
from ldc.export.plcopen.chart_plan import JUMP, STEP, TRANSITION, Part, plan, test_order
from ldc.export.plcopen.places import CHARACTER, GAP, LINE, value_width
from ldc.export.plcopen.tags import add, code, formatted, number, own_data
from ldc.draw.labels import text_width
from ldc.parser import sfc
from ldc.parser.unparse import expr_text

_STEP_HEIGHT, _STEP_WIDTH = 30, 46
_WAY_HEIGHT, _WAY_WIDTH = 2, 20
_JUMP = 12
_BAR = {"selection": 1, "simultaneous": 3}
"""How high bars are."""

_Out = tuple[int, int, int]
"""An output: the id of its element, and where it lies."""


def draw(pou: Element, chart: sfc.SfcBody) -> Element:
    """The body of a POU that is a chart; the bodies of its actions and transitions stand beside it."""
    return _Drawing(pou, chart).draw()


class _Drawing:
    def __init__(self, pou: Element, chart: sfc.SfcBody) -> None:
        self.chart = chart
        self.body = add(pou, "body")
        self.sfc = add(self.body, "SFC")
        self.plan = plan(chart)
        widths = [_even(max(_STEP_WIDTH, (text_width(s.name) + 2) * CHARACTER)) for s in chart.steps]
        self.widths, self.half = widths, max(widths, default=0) // 2
        self.conditions = [_shown(t) for t in chart.transitions]
        self.places = chart_places(self.plan, self._extent)
        self.last = 0
        self.feeds: dict[int, _Out] = {}
        self.ids = {id(part): self._id() for part in (*self.plan.steps, *self.plan.transitions)}
        self.priorities = self._priorities()

    def draw(self) -> Element:
        parts = (*self.plan.steps, *self.plan.transitions)
        for part in parts:
            self._outputs(part)
        for part in self.plan.steps:
            self._step(part, self.chart.steps[part.index])
        for part in self.plan.transitions:
            self._transition(part, self.chart.transitions[part.index])
        for part in parts:
            for child in part.children:
                if child.kind == JUMP:
                    self._jump(child)
        self._keep()
        return self.body

    # ---- sizes and places

    def _extent(self, part: Part) -> Extent:
        if part.kind == JUMP:
            right = _JUMP + (text_width(self.chart.steps[part.index].name) + 1) * CHARACTER
            return Extent(_JUMP, right, _JUMP)
        if part.kind == TRANSITION:
            text = text_width(self.conditions[part.index]) * CHARACTER
            return Extent(_WAY_WIDTH, _WAY_WIDTH + text, _WAY_HEIGHT)
        used = self.chart.steps[part.index].associations
        beside = GAP + _block_width(used) if used else 0
        return Extent(self.half, self.half + beside, max(_STEP_HEIGHT, len(used) * LINE + 3))

    def _at(self, part: Part) -> tuple[int, int]:
        """The axis and the upper edge."""
        return self.places.axis[id(part)], self.places.levels[part.level]

    def _id(self) -> int:
        self.last += 1
        return self.last

    def _element(self, tag: str, id_: int, place: tuple[int, int], size: tuple[int, int],
                 **attributes: object) -> Element:
        made = add(self.sfc, tag, localId=id_, width=number(size[0]), height=number(size[1]), **attributes)
        add(made, "position", x=number(place[0]), y=number(place[1]))
        return made

    # ---- elements

    def _step(self, part: Part, step: sfc.Step) -> None:
        (axis, y), id_, width = self._at(part), self.ids[id(part)], self.widths[part.index]
        feed = self._feed(part)
        made = self._element("step", id_, (axis - width // 2, y), (width, _STEP_HEIGHT), name=step.name,
                             initialStep="true" if step.initial else None)
        if feed is not None:
            _input(made, (width // 2, 0), (axis, y), feed)
        if part.children:
            _output(made, (width // 2, _STEP_HEIGHT), "connectionPointOut")
        if step.associations:
            _output(made, (width, _STEP_HEIGHT // 2), "connectionPointOutAction")
            self._actions(step, (id_, axis + width // 2, y + _STEP_HEIGHT // 2), axis + self.half + GAP)

    def _actions(self, step: sfc.Step, feed: _Out, x: int) -> None:
        used, width = step.associations, _block_width(step.associations)
        y = feed[2] - LINE // 2
        made = self._element("actionBlock", self._id(), (x, y), (width, len(used) * LINE))
        _input(made, (0, LINE // 2), (x, feed[2]), feed)
        for row, one in enumerate(used):
            duration = None if one.time is None else code(expr_text(one.time))
            indicator = code(expr_text(one.indicators[0])) if one.indicators else None
            action = add(made, "action", localId=self._id(), qualifier=one.qualifier, width=number(width),
                         height=number(LINE), duration=duration, indicator=indicator)
            add(action, "relPosition", x="0", y=number(row * LINE))
            add(action, "reference", name=code(expr_text(one.action)))

    def _transition(self, part: Part, way: sfc.Transition) -> None:
        axis, y = self._at(part)
        feed = self._feed(part)
        made = self._element("transition", self.ids[id(part)], (axis - _WAY_WIDTH // 2, y),
                             (_WAY_WIDTH, _WAY_HEIGHT), priority=self.priorities[part.index])
        _input(made, (_WAY_WIDTH // 2, 0), (axis, y), feed)
        add(add(made, "connectionPointOut"), "relPosition", x=number(_WAY_WIDTH // 2), y=number(_WAY_HEIGHT))
        condition = add(made, "condition")
        if isinstance(way.condition, sfc.Body):
            add(condition, "reference", name=way.name)
        else:
            inline = add(condition, "inline", name=way.name or "")
            formatted(inline, "ST", code(self.conditions[part.index]))

    def _jump(self, part: Part) -> None:
        axis, y = self._at(part)
        made = self._element("jumpStep", self._id(), (axis - _JUMP // 2, y), (_JUMP, _JUMP),
                             targetName=self.chart.steps[part.index].name)
        _input(made, (_JUMP // 2, 0), (axis, y), self.feeds[id(part)])

    # ---- wires and bars

    def _outputs(self, part: Part) -> None:
        """What feeds the children of a part: the part itself, or the divergence below it."""
        axis, y = self._at(part)
        out = (self.ids[id(part)], axis, y + (_STEP_HEIGHT if part.kind == STEP else _WAY_HEIGHT))
        if len(part.children) < 2:
            self.feeds.update((id(child), out) for child in part.children)
            return
        kind = "selection" if part.kind == STEP else "simultaneous"
        left, right = axis, self.places.axis[id(part.children[-1])]
        id_, top, height = self._id(), self.places.below[id(part)], _BAR[kind]
        bar = self._element(f"{kind}Divergence", id_, (left, top), (right - left, height))
        _input(bar, (axis - left, 0), (axis, top), out)
        for child in part.children:
            at = self.places.axis[id(child)]
            _output(bar, (at - left, height), "connectionPointOut")
            self.feeds[id(child)] = (id_, at, top + height)

    def _feed(self, part: Part) -> _Out | None:
        """What feeds a part: what it hangs below, or the convergence above it."""
        feed = self.feeds.get(id(part))
        wires = self.plan.joined.get((part.kind, part.index))
        if feed is None or wires is None:
            return feed
        kind = "selection" if part.kind == STEP else "simultaneous"
        sources = sorted((self.places.axis[id(one)], self.feeds[id(one)]) for one in (part, *wires))
        (left, _), (right, _) = sources[0], sources[-1]
        id_, top, height = self._id(), self.places.above[id(part)], _BAR[kind]
        bar = self._element(f"{kind}Convergence", id_, (left, top), (right - left, height))
        for x, source in sources:
            _input(bar, (x - left, 0), (x, top), source)
        axis = self.places.axis[id(part)]
        add(add(bar, "connectionPointOut"), "relPosition", x=number(axis - left), y=number(height))
        return id_, axis, top + height

    # ---- the order of transitions

    def _priorities(self) -> list[int | None]:
        """Those of the chart; where it is not drawn from left to right what is tested one after the other,
        priorities for all that say so."""
        ways = self.chart.transitions
        axes = [self.places.axis[id(part)] for part in self.plan.transitions]
        order = test_order(ways)
        rightmost: dict[str, int] = {}
        for index in order:
            for source in ways[index].sources:
                if axes[index] <= rightmost.get(source.name.upper(), -1):
                    turn = {way: place for place, way in enumerate(order, 1)}
                    return [turn[way] for way in range(len(ways))]
                rightmost[source.name.upper()] = axes[index]
        return [way.priority for way in ways]

    def _keep(self) -> None:
        """What the drawing does not say of transitions: their order, names, and that of their steps."""
        ways, parts = self.chart.transitions, self.plan.transitions
        if not ways:
            return
        axes = [self.places.axis[id(part)] for part in parts]
        drawn = sorted(range(len(ways)), key=axes.__getitem__)
        kept = own_data(self.body, "transitions")
        kept.set("drawn", " ".join(str(self.ids[id(parts[index])]) for index in drawn))
        for part, way, written in zip(parts, ways, self.priorities, strict=True):
            ends = [" ".join(name.name for name in names) for names in (way.sources, way.targets)]
            add(kept, "transition", id=self.ids[id(part)], name=way.name, from_=ends[0], to=ends[1],
                priority=way.priority, written=written)


def _even(size: int) -> int:
    return size + size % 2


def _shown(way: sfc.Transition) -> str:
    """What stands beside a transition."""
    return way.name or "" if isinstance(way.condition, sfc.Body) else expr_text(way.condition)


def _block_width(used: Sequence[sfc.Association]) -> int:
    """Columns for qualifiers with their times, actions and indicators."""
    columns = ([one.qualifier + ("" if one.time is None else f" {expr_text(one.time)}") for one in used],
               [expr_text(one.action) for one in used],
               [expr_text(one.indicators[0]) for one in used if one.indicators])
    return sum(max(map(value_width, texts)) for texts in columns if texts)


def _input(element: Element, at: tuple[int, int], place: tuple[int, int], source: _Out) -> None:
    """An input and its wire, drawn from there to the output."""
    point = add(element, "connectionPointIn")
    add(point, "relPosition", x=number(at[0]), y=number(at[1]))
    wire = add(point, "connection", refLocalId=source[0])
    for x, y in (place, source[1:]):
        add(wire, "position", x=number(x), y=number(y))


def _output(element: Element, at: tuple[int, int], tag: str) -> None:
    add(add(element, tag, formalParameter=""), "relPosition", x=number(at[0]), y=number(at[1]))
