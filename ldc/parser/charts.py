"""The body of a POU that is a sequential function chart: its words cut into steps, transitions and actions.

The body of an action is a ladder when it begins with RUNG, a list when it begins as one, statements
otherwise, in .ld and .st files alike. A part that is wrong gives its findings and is left out.
"""

from __future__ import annotations

from ldc.parser import ast, sfc
from ldc.parser.findings import cut
from ldc.parser.lexer import SECTIONS
from ldc.parser.listing import is_list
from ldc.parser.structured import read_body
from ldc.parser.units import Units
from ldc.records import replace
from ldc.similar import similar
from ldc.source import Span

STARTS = ("INITIAL_STEP", "STEP", "TRANSITION", "ACTION")
ENDS = ("END_STEP", "END_TRANSITION", "END_ACTION")
_BOUNDS = frozenset((*STARTS, *ENDS, *SECTIONS))


def read_chart(units: Units, first: int, end: int, span: Span, ladder: bool) -> tuple[sfc.SfcBody, set[str]]:
    """The chart that the tokens ``first`` to ``end`` (exclusive) are, and the names (capitals) of rungs that
    were left out. ``ladder``: what an empty body is."""
    reader = _Reader(units, first, end, ladder)
    reader.read()
    chart = sfc.SfcBody(tuple(reader.steps), tuple(reader.transitions), tuple(reader.actions), span)
    return chart, reader.lost


def read_actions(
    units: Units, first: int, end: int, language: str | None
) -> tuple[tuple[sfc.Action, ...], set[str]]:
    """The actions of a POU that is no chart, and the rungs that were left out. ``language``: of the file, ST
    or IL; None for ladders."""
    reader = _Reader(units, first, end, language is None, language == "IL")
    reader.read_actions()
    return tuple(reader.actions), reader.lost


class _Reader:
    """Goes through the tokens once; ``at`` is the next one. ``listed``: bodies are Instruction List."""

    def __init__(self, units: Units, first: int, end: int, ladder: bool, listed: bool = False) -> None:
        self.units, self.findings = units, units.findings
        self.tokens, self.types = units.tokens, units.types
        self.at, self.end, self.ladder, self.listed = first, end, ladder, listed
        self.steps: list[sfc.Step] = []
        self.transitions: list[sfc.Transition] = []
        self.actions: list[sfc.Action] = []
        self.lost: set[str] = set()

    def read(self) -> None:
        while self.at < self.end:
            self.findings.enough(self.at)
            kind = self._kind()
            if kind in ("STEP", "INITIAL_STEP"):
                self._step()
            elif kind == "TRANSITION":
                self._transition()
            elif kind == "ACTION":
                self._action()
            else:
                self._stray()

    def read_actions(self) -> None:
        while self.at < self.end:
            self.findings.enough(self.at)
            if self._kind() == "ACTION":
                self._action()
                continue
            begin = self.at
            self.at += 1
            self._seek()
            if not self.units.bad(begin, self.at):
                self.findings.unexpected(begin, "ACTION or the end", "actions are the last part of a POU: "
                                         "move this above the first of them, or into one")

    # ---- helpers

    def _kind(self) -> str:
        return self.types[self.at] if self.at < self.end else ""

    def _seek(self, *stops: str) -> int:
        """Go on to a word that begins or ends a part of a chart, or to one of ``stops``."""
        types, at = self.types, self.at
        while at < self.end and types[at] not in _BOUNDS and types[at] not in stops:
            at += 1
        self.at = at
        return at

    def _stray(self) -> None:
        begin = self.at
        self.at += 1
        if self.types[begin] in SECTIONS:
            self.findings.late_declarations(begin)
            while self.at < self.end and self.types[self.at] != "END_VAR":
                self.at += 1
            self.at += self.at < self.end
            return
        self._seek()
        if not self.units.bad(begin, self.at):
            word = cut(self.tokens.text(begin)).upper()
            near = similar(word, STARTS, 1, 0.75) if self.types[begin] == "NAME" else ()
            self.findings.outside_of_chart(begin, near[0] if near else "")
            self.at += bool(near) and self._kind() in ENDS

    def _head(self, symbol: str):
        """``STEP name:`` or ``ACTION name:``, as far as it goes."""
        first = self.at
        for word in (self._kind(), "NAME", ":"):
            if self._kind() != word:
                break
            self.at += 1
        head = self.units.parse(symbol, first, self.at, "heading")
        self.at += head is None and self._kind() == ":"
        return head

    def _close(self, end: str, opening: int, understood: bool) -> Span:
        """Take the END of a part; its whole span. Of one that was not understood it is not missed."""
        last = self.at - 1
        if self._kind() == end:
            self.at += 1
        elif self._kind() in ENDS:
            self.findings.wrong_end(self.at, end, opening)
            self.at += 1
        elif self._misspelt(last, end):
            self.findings.wrong_end(last, end, opening)
        elif understood:
            shown = self.at < len(self.types)
            self.findings.missing_end(end, opening, self.at,
                                      self.findings.shown(self.at) if shown else "the end of the file")
        return self.tokens.span(opening, max(opening, self.at - 1))

    def _misspelt(self, index: int, end: str) -> bool:
        return self.types[index] == "NAME" and bool(
            similar(cut(self.tokens.text(index)).upper(), [end], 1, 0.75))

    # ---- parts

    def _step(self) -> None:
        opening = self.at
        head = self._head("step_head")
        associations: list[sfc.Association] = []
        while self.at < self.end and self._kind() not in _BOUNDS:
            first = self.at
            if self._kind() == "RUNG":
                self._stray()
                continue
            stop = self._seek(";")
            if stop - first == 1 and self._kind() != ";" and self._misspelt(first, "END_STEP"):
                break
            stop = self.at = stop + (self._kind() == ";")
            found = self.units.parse("association", first, stop, "action of this step")
            if found is not None:
                associations.append(found)
        span = self._close("END_STEP", opening, head is not None)
        if head is not None:
            initial = head.word == "INITIAL_STEP"
            self.steps.append(sfc.Step(head.name, initial, tuple(associations), span, head.name_span))

    def _transition(self) -> None:
        opening = self.at
        self.at += 1
        stop = self._seek(";", ":", "RUNG")
        stop = self.at = stop + (self._kind() in (";", ":"))
        head = self.units.parse("transition", opening, stop, "transition")
        condition = None if head is None else head.condition
        if self.types[stop - 1] == ":" or self._kind() == "RUNG":
            condition = self._body("END_TRANSITION")
            if head is not None and head.name is None:
                self.findings.transition_without_name(opening)
                head = None
        elif self._kind() not in _BOUNDS and self._kind():
            first = self._seek_from()
            self.findings.unexpected(first, "END_TRANSITION", "a transition has one condition")
        span = self._close("END_TRANSITION", opening, head is not None)
        if head is not None:
            self.transitions.append(replace(head, condition=condition, span=span))

    def _seek_from(self) -> int:
        first = self.at
        self._seek()
        return first

    def _action(self) -> None:
        opening = self.at
        head = self._head("action_head")
        body = self._body("END_ACTION")
        span = self._close("END_ACTION", opening, head is not None)
        if head is not None:
            self.actions.append(sfc.Action(head.name, body, span, head.name_span))

    # ---- bodies

    def _body(self, end: str) -> sfc.Body:
        """All up to the next word of the chart."""
        first, start = self.at, self.tokens.ends[self.at - 1]
        stop = self._seek()
        if stop > first and self._kind() != end and self._misspelt(stop - 1, end):
            stop -= 1  # _close reports it
        to = self.tokens.starts[stop] if stop < len(self.types) else self.tokens.ends[-1]
        span = Span(self.tokens.source, start, max(start, to))
        if self.listed or is_list(self.tokens, first, stop):
            return ast.TextBody("IL", span)
        if first < stop and self.types[first] == "RUNG" or first == stop and self.ladder:
            return ast.LadderBody(tuple(self._rungs(first, stop)), span)
        return read_body(self.units, first, stop, span)

    def _rungs(self, first: int, stop: int) -> list[ast.Rung]:
        found: list[ast.Rung] = []
        while first < stop:
            following = next((i for i in range(first + 1, stop) if self.types[i] == "RUNG"), stop)
            rung = self.units.parse("rung", first, following, "rung")
            if rung is not None:
                found.append(rung)
            elif self.types[first + 1 : first + 2] == ["NAME"]:
                self.lost.add(self.tokens.text(first + 1).upper())
            first = following
        return found
