"""The canonical form of statements: a line for each, blocks indented, long calls a line for each pin."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

from ldc.parser import ast, unparse
from ldc.parser import statements as st
from ldc.parser.layout import WIDTH
from ldc.source import Span


class Lines(Protocol):
    """What takes the lines, with the comments that stand beside them in the source."""

    def own_lines(self, comments: Sequence[ast.Comment], indent: str) -> None: ...

    def above(self, start: int, indent: str) -> None: ...

    def line(self, text: str, end: int, opens: bool = False) -> None: ...


class StatementPrinter:
    def __init__(self, lines: Lines) -> None:
        self.lines = lines

    def list(self, statements: Iterable[st.Statement], indent: str) -> None:
        for statement in statements:
            self.lines.above(statement.span.start, indent)
            _PRINTERS[type(statement)](self, statement, indent)

    def _open(self, text: str, head: Span, body: Iterable[st.Statement], indent: str) -> None:
        """A line that opens a block, and the block."""
        self.lines.line(indent + text, head.end, opens=True)
        self.list(body, indent + unparse.INDENT)

    def _branch(self, text: str, head: Span, body: Iterable[st.Statement], indent: str) -> None:
        """A further branch of a block; comments before it belong to the branch that ends."""
        self.lines.above(head.start, indent + unparse.INDENT)
        self._open(text, head, body, indent)

    def _close(self, word: str, span: Span, indent: str) -> None:
        start = span.text.upper().rfind(word)
        self.lines.above(span.start + start, indent + unparse.INDENT)
        self.lines.line(f"{indent}{word};", span.end)

    def simple(self, statement: st.Statement, indent: str) -> None:
        text = indent + statement_text(statement)
        if len(text) > WIDTH and isinstance(statement, st.Invoke) and len(statement.arguments) > 1:
            inner = indent + unparse.INDENT
            arguments = f",\n{inner}".join(map(unparse.argument_text, statement.arguments))
            text = f"{indent}{unparse.expr_text(statement.callee)}(\n{inner}{arguments});"
        self.lines.line(text, statement.span.end)

    def if_(self, statement: st.If, indent: str) -> None:
        for number, arm in enumerate(statement.arms):
            text = f"{'ELSIF' if number else 'IF'} {unparse.expr_text(arm.condition)} THEN"
            (self._branch if number else self._open)(text, arm.head, arm.body, indent)
        self._otherwise(statement.otherwise, indent)
        self._close("END_IF", statement.span, indent)

    def _otherwise(self, otherwise: st.Otherwise | None, indent: str) -> None:
        if otherwise is not None:
            self._branch("ELSE", otherwise.head, otherwise.body, indent)

    def case(self, statement: st.Case, indent: str) -> None:
        head = f"{indent}CASE {unparse.expr_text(statement.selector)} OF"
        self.lines.line(head, statement.head.end, opens=True)
        inner = indent + unparse.INDENT
        for choice in statement.choices:
            self.lines.above(choice.head.start, inner)
            self._open(f"{', '.join(map(label_text, choice.labels))}:", choice.head, choice.body, inner)
        self._otherwise(statement.otherwise, indent)
        self._close("END_CASE", statement.span, indent)

    def for_(self, statement: st.For, indent: str) -> None:
        head = statement.head
        step = "" if head.step is None else f" BY {unparse.expr_text(head.step)}"
        text = (f"FOR {unparse.expr_text(head.variable)} := {unparse.expr_text(head.start)}"
                f" TO {unparse.expr_text(head.stop)}{step} DO")
        self._open(text, statement.head_span, statement.body, indent)
        self._close("END_FOR", statement.span, indent)

    def while_(self, statement: st.While, indent: str) -> None:
        head = f"WHILE {unparse.expr_text(statement.condition)} DO"
        self._open(head, statement.head, statement.body, indent)
        self._close("END_WHILE", statement.span, indent)

    def repeat(self, statement: st.Repeat, indent: str) -> None:
        self._open("REPEAT", statement.head, statement.body, indent)
        self.lines.above(statement.tail.start, indent + unparse.INDENT)
        until = f"{indent}UNTIL {unparse.expr_text(statement.condition)}"
        self.lines.line(until, statement.condition.span.end)
        self._close("END_REPEAT", statement.span, indent)


def statement_text(statement: st.Assign | st.Invoke | st.Leave | st.Empty) -> str:
    """A statement that is no block, with its semicolon."""
    match statement:
        case st.Assign(target, value):
            return f"{unparse.expr_text(target)} := {unparse.expr_text(value)};"
        case st.Invoke(callee, arguments):
            return f"{unparse.expr_text(callee)}({', '.join(map(unparse.argument_text, arguments))});"
        case st.Leave(word):
            return f"{word};"
    return ";"


def label_text(label: st.Label) -> str:
    """``3`` or ``3..5``."""
    high = "" if label.high is None else f"..{unparse.expr_text(label.high)}"
    return unparse.expr_text(label.low) + high


_PRINTERS: dict[type, Callable] = {
    st.Assign: StatementPrinter.simple, st.Invoke: StatementPrinter.simple, st.Leave: StatementPrinter.simple,
    st.Empty: StatementPrinter.simple, st.If: StatementPrinter.if_, st.Case: StatementPrinter.case,
    st.For: StatementPrinter.for_, st.While: StatementPrinter.while_, st.Repeat: StatementPrinter.repeat,
}
