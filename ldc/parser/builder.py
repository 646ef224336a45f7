"""The actions of the rules of ladder.lark: from the children's values to the nodes of ast.py.

A terminal's value is its token index. What is wrong beyond the grammar is reported here. When it leaves no
sensible node (a wrong literal, a reserved name), ``failed`` is set, and the unit is dropped.
"""

from __future__ import annotations

from ldc.parser import ast, literals, operators, statements
from ldc.parser.findings import Findings
from ldc.parser.lexer import Tokens
from ldc.patterns import Pattern
from ldc.records import replace
from ldc.source import Span
from ldc.types import ELEMENTARY

Values = list
_PART = Pattern(r"%[XBWDL][0-9]+")


class Builder:
    """One per file. Methods are called by lr.parse, by the name that the grammar gives them."""

    def __init__(self, tokens: Tokens, findings: Findings) -> None:
        self.tokens, self.findings = tokens, findings
        self.source, self.text = tokens.source, tokens.source.text
        self.types, self.starts, self.ends = tokens.types, tokens.starts, tokens.ends
        self.failed = False

    def word(self, index: int) -> str:
        return self.text[self.starts[index] : self.ends[index]]

    def span(self, first: int, last: int) -> Span:
        return Span(self.source, self.starts[first], self.ends[last])

    def declared(self, index: int) -> str:
        """A name that is being declared: not one of an elementary type."""
        word = self.word(index)
        if word.upper() in ELEMENTARY:
            self.failed = True
            self.findings.reserved(index)
        return word

    # ---- lists: built in place, so that a long one costs linear time

    def nothing(self, _: Values) -> list:
        return []

    def first(self, values: Values) -> list:
        return values

    def another(self, values: Values) -> list:
        values[0].append(values[1])
        return values[0]

    def further(self, values: Values) -> list:
        values[0].append(values[2])
        return values[0]

    # ---- the ladder

    def rung(self, values: Values) -> ast.Rung:
        head, paths = values[0], values[1]
        name = title = name_span = None
        for index in head[1:]:
            if self.types[index] == "TEXT":
                title = self.title(index)
            else:
                name, name_span = self.word(index), self.span(index, index)
        end = self.ends[values[2]] if len(values) == 3 else paths[-1].span.end
        return ast.Rung(name, title, tuple(paths), Span(self.source, self.starts[head[0]], end), name_span)

    def rung_head(self, values: Values) -> list[int]:
        return values

    def title(self, index: int) -> str:
        return self.literal([index]).value

    def path(self, values: Values) -> ast.Path:
        items = values[0]
        return ast.Path(tuple(items), Span(self.source, items[0].span.start, items[-1].span.end))

    def contact(self, values: Values) -> ast.Contact:
        modifier = ""
        if len(values) == 4:
            modifier = self.word(values[1]).upper()
            if modifier in "SR":
                self.findings.wrong_modifier(values[1])
                modifier = ""
        return ast.Contact(modifier, values[-2], self.span(values[0], values[-1]))

    def coil(self, values: Values) -> ast.Coil:
        modifier = self.word(values[1]).upper() if len(values) == 4 else ""
        return ast.Coil(modifier, values[-2], self.span(values[0], values[-1]))

    def junction(self, values: Values) -> ast.Junction:
        return ast.Junction(self.word(values[1]), self.span(*values))

    def jump(self, values: Values) -> ast.Jump:
        target = self.word(values[1])
        return ast.Jump("RETURN" if target.upper() == "RETURN" else target, self.span(*values))

    def branches(self, values: Values) -> ast.Branches:
        return ast.Branches(tuple(values[1]), self.span(values[0], values[2]))

    def instance_block(self, values: Values) -> ast.Block:
        low, instance, _, name, _, pins, _, powers, high = values
        return self._block(low, instance, name, pins, powers, high)

    def function_block(self, values: Values) -> ast.Block:
        low, name, _, pins, _, powers, high = values
        return self._block(low, None, name, pins, powers, high)

    def _block(self, low: int, instance, name: int, pins: list, powers: list, high: int) -> ast.Block:
        chosen: dict[str, str] = {}
        for side, pin in powers:
            word = self.word(side).lower()
            if word not in ("in", "out") or word in chosen:
                self.findings.power_pin(side, word in chosen)
            chosen[word] = self.word(pin)
        return ast.Block(instance, self.word(name), tuple(pins), chosen.get("in"), chosen.get("out"),
                         self.span(low, high))

    def power(self, values: Values) -> list[tuple[int, int]]:
        values[0].append((values[1], values[3]))
        return values[0]

    def pin_in(self, values: Values) -> ast.Pin:
        return self._pin(values, False)

    def pin_out(self, values: Values) -> ast.Pin:
        return self._pin(values, True)

    def _pin(self, values: Values, output: bool) -> ast.Pin:
        name, _, value = values
        return ast.Pin(self.word(name), value, output, Span(self.source, self.starts[name], value.span.end))

    def pin_positional(self, values: Values) -> ast.Pin:
        return ast.Pin(None, values[0], False, values[0].span)

    # ---- statements

    def assign(self, values: Values) -> statements.Assign:
        target, _, value = values
        return statements.Assign(target, value, target.span.to(value.span))

    def invoke(self, values: Values) -> statements.Invoke:
        callee, _, arguments, close = values
        span = Span(self.source, callee.span.start, self.ends[close])
        return statements.Invoke(callee, tuple(arguments), span)

    def assign_all(self, values: Values) -> tuple[statements.Assign, ...]:
        """``a := b := 0``: the innermost first, ``b := 0; a := b;``."""
        target, _, rest = values
        rest = rest if isinstance(rest, tuple) else (rest,)
        span = target.span.to(rest[0].span)
        return (*rest, statements.Assign(target, rest[-1].target, span))

    def latch(self, values: Values) -> statements.If:
        """``q S= condition;`` sets, ``R=`` resets: ``IF condition THEN q := TRUE; END_IF;``."""
        target, word, _, condition = values
        kind, span = self.word(word).upper(), target.span.to(condition.span)
        if kind not in ("S", "R"):
            self.failed = True
            self.findings.no_latch(word)
        text = "TRUE" if kind == "S" else "FALSE"
        value = ast.Literal(kind == "S", "BOOL", text, self.span(word, word))
        arm = statements.Arm(condition, (statements.Assign(target, value, target.span),), condition.span)
        return statements.If((arm,), None, span)

    def for_head(self, values: Values) -> statements.ForHead:
        step = values[6] if len(values) > 5 else None
        span = values[0].span.to(values[-1].span)
        return statements.ForHead(values[0], values[2], values[4], step, span)

    def case_value(self, values: Values) -> statements.Label:
        return statements.Label(values[0], None, values[0].span)

    def case_range(self, values: Values) -> statements.Label:
        low, _, high = values
        return statements.Label(low, high, low.span.to(high.span))

    # ---- expressions

    def chain_start(self, values: Values) -> list:
        values[1] = self._operator(values[1])
        return values

    def chain_more(self, values: Values) -> list:
        values[0] += (self._operator(values[1]), values[2])
        return values[0]

    def _operator(self, index: int) -> str:
        word = self.word(index).upper()
        return "AND" if word == "&" else word

    def tree(self, values: Values) -> ast.Expr:
        return operators.tree(values[0])

    def complement(self, values: Values) -> ast.Unary:
        return self._unary("NOT", values)

    def negation(self, values: Values) -> ast.Unary:
        return self._unary("-", values)

    def unchanged(self, values: Values) -> ast.Expr:
        """A plus sign."""
        index, operand = values
        return replace(operand, span=Span(self.source, self.starts[index], operand.span.end))

    def _unary(self, operator: str, values: Values) -> ast.Unary:
        index, operand = values
        return ast.Unary(operator, operand, Span(self.source, self.starts[index], operand.span.end))

    def number(self, values: Values) -> ast.Literal:
        return self._literal(self.word(values[0]), self.span(values[0], values[0]), literals.number)

    def negative(self, values: Values) -> ast.Literal:
        return self._signed("-", values)

    def positive(self, values: Values) -> ast.Literal:
        return self._signed("", values)

    def _signed(self, sign: str, values: Values) -> ast.Literal:
        index, literal = values
        span = Span(self.source, self.starts[index], literal.span.end)
        return self._literal(sign + literal.text, span, literals.number)

    def literal(self, values: Values) -> ast.Literal | ast.EnumLiteral:
        index, = values
        word, span = self.word(index), self.span(index, index)
        literal = self._literal(word, span, literals.literal)
        if literals.is_enumeration(word):
            return ast.EnumLiteral(literal.type or "", str(literal.value), span)
        return literal

    def _literal(self, text: str, span: Span, parse) -> ast.Literal:
        try:
            value, kind, text = parse(text)
        except literals.Malformed as problem:
            self.failed = True
            self.findings.literal(span, problem)
            value, kind = 0, None
        return ast.Literal(value, kind, text, span)

    def parenthesised(self, values: Values) -> ast.Expr:
        """No node of its own; the span takes the parentheses in."""
        return replace(values[1], span=self.span(values[0], values[2]))

    def call(self, values: Values) -> ast.Call:
        return ast.Call(self.word(values[0]), tuple(values[2]), self.span(values[0], values[3]))

    def argument(self, values: Values) -> ast.Argument:
        return ast.Argument(None, values[0], False, values[0].span)

    def argument_in(self, values: Values) -> ast.Argument:
        return self._argument(values, False)

    def argument_out(self, values: Values) -> ast.Argument:
        return self._argument(values, True)

    def _argument(self, values: Values, output: bool) -> ast.Argument:
        name, _, value = values
        span = Span(self.source, self.starts[name], value.span.end)
        return ast.Argument(self.word(name), value, output, span)

    def name(self, values: Values) -> ast.Name:
        index, = values
        start, end = self.starts[index], self.ends[index]
        return ast.Name(self.text[start:end], Span(self.source, start, end))

    def direct(self, values: Values) -> ast.Direct:
        index, = values
        return ast.Direct(self.word(index).upper(), self.span(index, index))

    def member(self, values: Values) -> ast.Member:
        base, _, name = values
        return ast.Member(base, self.word(name), Span(self.source, base.span.start, self.ends[name]))

    def bit(self, values: Values) -> ast.Member:
        """``word.%X3`` of the 3rd edition is ``word.3``; ``word.%B1`` keeps its name, and may have a bit
        itself."""
        base, _, at = values
        part, _, bit = self.word(at).upper().partition(".")
        if not _PART.fullmatch(part) or bit and (part[1] == "X" or not bit.isdecimal()):
            self.failed = True
            self.findings.part_of(at)
        span = Span(self.source, base.span.start, self.ends[at])
        if part.startswith("%X"):
            return ast.Member(base, part[2:], span)
        whole = ast.Member(base, part, span)
        return ast.Member(whole, bit, span) if bit else whole

    def index(self, values: Values) -> ast.Index:
        base, _, indexes, close = values
        return ast.Index(base, tuple(indexes), Span(self.source, base.span.start, self.ends[close]))
