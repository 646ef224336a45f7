"""Structured Text routines: their expressions convert types as ladder instructions do."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser import statements as st
from ldc.parser.l5x import neutral
from ldc.parser.l5x.calls import called
from ldc.parser.l5x.operands import BITS, BLANK, Parser, Wrong
from ldc.parser.l5x.types import DINT, Atom, is_real
from ldc.parser.l5x.values import Value, convert
from ldc.parser.plcopen.document import Node
from ldc.source import Span

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

MAX_DEPTH = 100
_WORD = re.compile(BLANK + r"([A-Za-z_]\w*|\[:=\]|:=|\.\.|\S)")
_CALL = re.compile(BLANK + r"[A-Za-z_]\w*\s*\(")
_LABEL = re.compile(BLANK + r"-?[\w#]+\s*(?::(?!=)|,|\.\.)")
_ENDS = {"IF": "END_IF", "CASE": "END_CASE", "FOR": "END_FOR", "WHILE": "END_WHILE", "REPEAT": "END_REPEAT"}


class Statements:
    """Reads the statements of one POU. ``writer`` knows its tags; ``last`` is done before a RETURN."""

    def __init__(self, writer: Writer, last: tuple[st.Statement, ...] = ()) -> None:
        self.writer, self.operands, self.reading, self.last = writer, writer.operands, writer.reading, last

    def guarded(self, node: Node, enable: ast.Expr, enabled: ast.Expr) -> st.StatementBody:
        """``ENO := EN; IF EN THEN statements END_IF;``"""
        span = node.span
        body = st.If((st.Arm(enable, self.read(node.body), span),), None, span)
        return st.StatementBody((st.Assign(enabled, enable, span), body), span)

    def read(self, text: Span) -> tuple[st.Statement, ...]:
        """The statements of a text; what is wrong is told, and reading goes on behind the next semicolon."""
        self.source, self.at, self.end, self.depth = text.source, text.start, text.end, 0
        found: list[st.Statement] = []
        while self.peek():
            found += self.block(())
            if self.peek():
                self.complain(f"`{self.peek()}` is not expected here")
                self.next()
        return tuple(found)

    # ---- tokens

    def peek(self) -> str:
        match = _WORD.match(self.source.text, self.at, self.end)
        return match[1] if match else ""

    def next(self) -> Span:
        match = _WORD.match(self.source.text, self.at, self.end)
        if match is None:
            return Span(self.source, self.at, self.at)
        self.at = match.end()
        return Span(self.source, match.start(1), match.end(1))

    def complain(self, message: str, help: str = "") -> None:
        match = _WORD.match(self.source.text, self.at, self.end)
        start, end = match.span(1) if match else (max(self.end - 1, 0), self.end)
        self.reading.malformed(Span(self.source, start, end), message, help=help or "check the statement")

    def expect(self, word: str) -> None:
        if self.peek().upper() != word:
            self.complain(f"`{word}` is missing")
            raise Wrong
        self.next()

    def expression(self, real: bool = False) -> Value:
        parser = Parser(self.operands, Span(self.source, self.at, self.end), real, None)
        found = parser.expression(0)
        self.at = parser.start
        return found

    # ---- statements

    def block(self, ends: tuple[str, ...]) -> tuple[st.Statement, ...]:
        """Up to one of the words that end it."""
        found = []
        while (word := self.peek().upper()) and word not in ends:
            try:
                if word in (*_ENDS.values(), "ELSE", "ELSIF", "UNTIL"):
                    break
                found += self.statements(word)
            except Wrong:
                semicolon = self.source.text.find(";", self.at, self.end)
                self.at = self.end if semicolon < 0 else semicolon + 1
        return tuple(found)

    def statements(self, word: str) -> tuple[st.Statement, ...]:
        """One statement, with what has to be done before it."""
        if word != "RETURN" and word not in _ENDS and _CALL.match(self.source.text, self.at, self.end):
            return self.call(word)
        return (*(self.last if word == "RETURN" else ()), self.statement(word))

    def call(self, word: str) -> tuple[st.Statement, ...]:
        """An instruction: what a rung with power does by it."""
        found = neutral.call(self.rest(), self.reading)
        if found is None:
            raise Wrong
        instruction, self.at = found
        statements = called(self.writer, instruction)
        if statements is None:
            self.reading.unsupported(instruction.span, f"instruction {word} in Structured Text",
                                     "call it in a ladder routine")
            raise Wrong
        self.expect(";")
        return tuple(part for one in statements
                     for part in ((*self.last, one) if isinstance(one, st.Leave) else (one,)))

    def rest(self) -> Span:
        """From the next word on."""
        match = _WORD.match(self.source.text, self.at, self.end)
        return Span(self.source, match.start(1) if match else self.end, self.end)

    def statement(self, word: str) -> st.Statement:
        start = self.at
        if word == ";":
            return st.Empty(self.next())
        if word in _ENDS:
            self.depth += 1
            if self.depth > MAX_DEPTH:
                self.reading.too_large(self.next(), MAX_DEPTH, "statements inside one another")
                self.at = self.end
                raise Wrong
            try:
                found = getattr(self, f"_{word.lower()}")(self.next())
            finally:
                self.depth -= 1
            if self.peek() == ";":
                self.next()
            return found
        if word in ("EXIT", "RETURN", "CONTINUE"):
            span = self.next()
            self.expect(";")
            return st.Leave(word, span)
        target = self.expression()
        sign = self.next()
        if sign.text == "[:=]":
            # It differs by this alone: before the first scan the place is 0.
            self.writer.start(target, (), 0.0 if is_real(target.type) else 0)
        if sign.text not in (":=", "[:=]") or not target.place:
            self.at = start
            self.complain("this is no statement")
            raise Wrong
        value = self.expression(is_real(target.type))
        self.expect(";")
        span = Span(self.source, target.span.start, self.at)
        if target.whole is None:
            return st.Assign(target.expr, convert(value, target.type), span)
        whole = target.whole
        name = self.operands.support.use("logix_set_bit", T=whole.type.name, BITS=BITS[whole.type.name])
        pins = (("power", value.expr), ("bit", target.bit), ("whole", whole.expr))
        return st.Invoke(ast.Name(name, span), tuple(ast.Argument(n, e, False, span) for n, e in pins), span)

    def condition(self) -> ast.Expr:
        return self.expression().expr

    def close(self, word: str, head: Span) -> Span:
        self.expect(word)
        return Span(self.source, head.start, self.at)

    def _if(self, head: Span) -> st.If:
        arms = []
        while True:
            condition = self.condition()
            self.expect("THEN")
            head_span = Span(self.source, head.start, self.at)
            arms.append(st.Arm(condition, self.block(("ELSIF", "ELSE", "END_IF")), head_span))
            if self.peek().upper() != "ELSIF":
                break
            head = self.next()
        otherwise = self._otherwise("END_IF")
        return st.If(tuple(arms), otherwise, self.close("END_IF", arms[0].head))

    def _otherwise(self, end: str) -> st.Otherwise | None:
        if self.peek().upper() != "ELSE":
            return None
        head = self.next()
        return st.Otherwise(self.block((end,)), head)

    def _case(self, head: Span) -> st.Case:
        selector = self.condition()
        self.expect("OF")
        head_span = Span(self.source, head.start, self.at)
        choices = []
        while self.peek() and self.peek().upper() not in ("ELSE", "END_CASE"):
            start, labels = self.at, []
            while True:
                low, high = self.condition(), None
                if self.peek() == "..":
                    self.next()
                    high = self.condition()
                labels.append(st.Label(low, high, low.span))
                if self.peek() != ",":
                    break
                self.next()
            self.expect(":")
            choices.append(st.Choice(tuple(labels), self._choice(), Span(self.source, start, self.at)))
        otherwise = self._otherwise("END_CASE")
        return st.Case(selector, tuple(choices), otherwise, head_span, self.close("END_CASE", head))

    def _choice(self) -> tuple[st.Statement, ...]:
        """Statements up to the next label: a number that is followed by ``:``, ``,`` or ``..``."""
        found = []
        while (word := self.peek().upper()) and word not in ("ELSE", "END_CASE"):
            if _LABEL.match(self.source.text, self.at, self.end):
                break
            found += self.statements(word)
        return tuple(found)

    def _for(self, head: Span) -> st.For:
        variable = self.expression()
        self.expect(":=")
        start = self._counted(variable)
        self.expect("TO")
        stop, step = self._counted(variable), None
        if self.peek().upper() == "BY":
            self.next()
            step = self._counted(variable)
        self.expect("DO")
        span = Span(self.source, head.start, self.at)
        body = self.block(("END_FOR",))
        return st.For(st.ForHead(variable.expr, start, stop, step, span), body, span,
                      self.close("END_FOR", head))

    def _counted(self, variable: Value) -> ast.Expr:
        return convert(self.expression(), variable.type if isinstance(variable.type, Atom) else DINT)

    def _while(self, head: Span) -> st.While:
        condition = self.condition()
        self.expect("DO")
        span = Span(self.source, head.start, self.at)
        return st.While(condition, self.block(("END_WHILE",)), span, self.close("END_WHILE", head))

    def _repeat(self, head: Span) -> st.Repeat:
        body = self.block(("UNTIL",))
        start = self.at
        self.expect("UNTIL")
        condition = self.condition()
        if self.peek() == ";":
            self.next()
        span = self.close("END_REPEAT", head)
        return st.Repeat(body, condition, head, Span(self.source, start, self.at), span)

