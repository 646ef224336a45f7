"""The actions of the grammar's rules for sequential function charts (see builder.py)."""

from __future__ import annotations

from ldc.parser import ast, sfc
from ldc.parser.builder import Values
from ldc.parser.declarations import FileBuilder
from ldc.records import record, replace
from ldc.source import Span


@record
class ChartHead:
    """``STEP name:``, ``INITIAL_STEP name:``, ``ACTION name:``."""

    word: str
    name: str
    name_span: Span


class ChartBuilder(FileBuilder):
    """All actions: those of ladders and declarations, and these."""

    def chart_head(self, values: Values) -> ChartHead:
        word, name, _ = values
        return ChartHead(self.types[word], self.declared(name), self.span(name, name))

    def association(self, values: Values) -> sfc.Association | None:
        """``action(qualifier, time, indicators);`` without a qualifier it is N."""
        action, _, arguments, _, last = values
        span = Span(self.source, action.span.start, self.ends[last])
        plain = sfc.Association(action, "N", None, (), span)
        if not arguments:
            return plain
        first, *rest = arguments
        word = first.value.name.upper() if isinstance(first.value, ast.Name) and first.name is None else ""
        named = next((argument for argument in rest if argument.name is not None), None)
        if word not in sfc.QUALIFIERS or named is not None:
            self.failed = True
            self.findings.no_qualifier(first.span if named is None else named.span)
            return None
        timed = word in sfc.TIMED
        is_time = bool(rest) and isinstance(rest[0].value, ast.Literal)
        if timed and not rest or is_time and not timed:
            self.failed = True
            self.findings.time_of_action(rest[0].span if rest else first.span, word, timed)
            return None
        time = rest.pop(0).value if timed else None
        return replace(plain, qualifier=word, time=time, indicators=tuple(a.value for a in rest))

    def transition(self, values: Values) -> sfc.Transition:
        """Without a condition when ``:`` follows; charts.py reads its body then."""
        (word, name, priority), _, sources, _, targets = values[:5]
        condition = values[6] if len(values) == 8 else ast.LadderBody((), self.span(word, values[-1]))
        return sfc.Transition(
            None if name is None else self.declared(name), priority, tuple(sources), tuple(targets),
            condition, self.span(word, values[-1]), None if name is None else self.span(name, name))

    def transition_head(self, values: Values) -> tuple[int, int | None, int | None]:
        """The word, the name, the priority."""
        priority = values.pop() if isinstance(values[-1], tuple) else (None,)
        return values[0], values[1] if len(values) == 2 else None, priority[0]

    def priority(self, values: Values) -> tuple[int]:
        _, word, _, number, _ = values
        if self.word(word).upper() != "PRIORITY":
            self.failed = True
            self.findings.no_priority(word)
        return (self.number([number]).value,)

    def one_step(self, values: Values) -> list[ast.Name]:
        return [self.name(values)]

    def several_steps(self, values: Values) -> list[ast.Name]:
        return [self.name([index]) for index in values[1]]
