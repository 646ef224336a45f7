"""Operands and expressions of instructions, with their types: ``tag.member[i].5``, ``(a + 2) * SIN(b)``."""

from __future__ import annotations

import re
from math import isfinite

from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.l5x import arithmetic, types
from ldc.parser.l5x.scope import Externals, Globals, Scope, Tag
from ldc.parser.l5x.support import Support
from ldc.parser.l5x.types import BOOL, DINT, SINT, Array, Structure, Text, Type, is_integer
from ldc.parser.l5x.values import Value, boolean, call, convert, literal
from ldc.parser.literals import Malformed
from ldc.parser.literals import literal as iec_literal
from ldc.source import Span

MAX_DEPTH, _MAX_ALIASES = 100, 8
BLANK = r"\s*+(?>(?:(?:\(\*(?s:.*?)\*\)|/\*(?s:.*?)\*/|//[^\n]*|\#(?:end)?region[^\n]*)\s*+)*)"
"""What stands between tokens: space, and in Structured Text comments."""
_TOKEN = re.compile(BLANK + r"""(?:
    (?P<number>(?:2|8|16)\#[0-9A-Fa-f_]+ | (?:\d[\d_]*(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][+-]?\d+)?)
  | (?P<name>\\?[A-Za-z_]\w*(?::\w+)*)
  | (?P<string>'(?:[^'$]|\$.)*')
  | (?P<sign>\*\*|<=|>=|<>|:=|\S))""", re.VERBOSE)
_STEP = re.compile(r"""\s*(?:\.(?P<bit>\d+)(?![\w.]) | \.(?P<name>[A-Za-z_]\w*) | (?P<indirect>\.\[)
                     | (?P<index>\[(?!:=)))""", re.VERBOSE)
_CALLED = re.compile(r"\s*\(")
_CONSTANT = re.compile(r"\s*(\d+)\s*\]")
_WORDS = {"MOD": "MOD", "AND": "AND", "OR": "OR", "XOR": "XOR"}
_RANK = {"OR": 1, "XOR": 2, "AND": 3, "&": 3, "=": 4, "<>": 4, "<": 4, ">": 4, "<=": 4, ">=": 4,
         "+": 5, "-": 5, "*": 6, "/": 6, "MOD": 6, "**": 7}
BITS = {"SINT": "BYTE", "INT": "WORD", "DINT": "DWORD", "LINT": "LWORD",
        "USINT": "BYTE", "UINT": "WORD", "UDINT": "DWORD", "ULINT": "LWORD"}
"""The bit string that is as wide as an integer."""
_STATUS = "S:FS S:V S:Z S:N S:C S:MINOR".split()


class Wrong(Exception):
    """An operand that is none; it was told."""


class Operands:
    """Reads operands of one POU. ``externals`` collects the globals that it uses; ``scan``: the program whose
    first scan S:FS tells, "" for none; ``strange``: a name was read that nobody declares."""

    def __init__(self, reading: Reading, scope: Scope, globals_: Globals, externals: Externals,
                 support: Support) -> None:
        self.reading, self.scope, self.globals = reading, scope, globals_
        self.externals, self.support = externals, support
        self.scan, self.strange = "", False

    def read(self, text: Span, real: bool = False, hint: Type | None = None) -> Value | None:
        """The operand or expression; None when it is none (that was told). ``real``: the result goes to a
        REAL, so integers are computed as such too. ``hint``: the type of an input or output that no module
        declares."""
        try:
            parser = Parser(self, text, real, hint)
            found = parser.expression(0)
            parser.expect_end()
        except Wrong:
            return None
        return found

    def place(self, text: Span, hint: Type | None = None) -> Value | None:
        """An operand that is written."""
        found = self.read(text, hint=hint)
        if found is not None and not found.place and found.text is not None:
            self.reading.unsupported(text, f"writing `{text.text[:40]}`",
                                     "a string is written as a whole: use MOV, CONCAT, INSERT or DELETE")
            return None
        if found is not None and not found.place:
            self.reading.malformed(text, f"`{text.text[:40]}` cannot be written", help="a tag is needed here")
            return None
        return found

    # ---- tags

    def tag_value(self, tag: Tag, span: Span) -> Value:
        tag.used = True
        if tag.of:
            expr: ast.Expr = ast.Member(ast.Name(tag.of, span), tag.name, span)
        else:
            expr = ast.Name(tag.name, span)
            if not tag.local:
                self.externals.tags.setdefault(tag.name.upper(), tag)
        return Value(expr, tag.type, span, way=(tag, ()), place=True)

    def member(self, value: Value, name: str, span: Span, depth: int = 0) -> Value:
        type_ = value.type
        if isinstance(type_, Text) and name.upper() == "LEN":
            return Value(call("LEN", span, value.expr), DINT, span, place=True, text=value)
        if isinstance(type_, Text) and name.upper() == "DATA":
            return Value(value.expr, Array((type_.length,), SINT), span, text=value)
        if isinstance(type_, Text):
            self.reading.malformed(span, f"a string has no member {name[:40]}", help="it has LEN and DATA")
            raise Wrong
        found = type_.members.get(name.upper()) if isinstance(type_, Structure) else None
        if found is not None and found.alias and depth > _MAX_ALIASES:
            self.reading.malformed(span, f"`{name}` is an alias of itself", help="let it name a place")
            raise Wrong
        if found is not None and found.alias:
            for part in found.alias.split(".")[:_MAX_ALIASES]:
                value = self.bit(value, literal(int(part), span), span) if part.isdecimal() else self.member(
                    value, part, span, depth + 1)
            return value
        own = found.name if found is not None else name
        way = None if value.way is None else (value.way[0], (*value.way[1], name.upper()))
        return Value(ast.Member(value.expr, own, span), found.type if found else None, span, way=way,
                     place=True)

    def bit(self, value: Value, number: Value, span: Span) -> Value:
        if not is_integer(value.type):
            if value.type is None or number.number is None:
                return Value(value.expr, None, span, place=True)
            return Value(ast.Member(value.expr, str(number.number), span), BOOL, span, place=True)
        width = types.WIDTHS[value.type.name]
        if number.number is not None and not 0 <= number.number < width:
            self.reading.malformed(span, f"{value.type.name} has no bit {number.number}",
                                   help=f"the bits are 0 to {width - 1}")
            raise Wrong
        name = self.support.use("logix_bit", T=value.type.name, BITS=BITS[value.type.name])
        way = None
        if value.way is not None and number.number is not None:
            way = (value.way[0], (*value.way[1], f".{number.number}"))
        return Value(call(name, span, value.expr, number.expr), BOOL, span, whole=value, bit=number.expr,
                     way=way, place=True)


class Parser:
    def __init__(self, operands: Operands, text: Span, real: bool, hint: Type | None) -> None:
        self.operands, self.text, self.real, self.hint = operands, text, real, hint
        self.reading = operands.reading
        self.source, self.at, self.depth = text.source, text.start, 0
        self.advance()

    def span(self, start: int, end: int) -> Span:
        return Span(self.source, start, end)

    # ---- tokens

    def advance(self) -> None:
        """The next token in ``kind`` and ``word``; "" at the end."""
        match = _TOKEN.match(self.source.text, self.at, self.text.end)
        if match is None:
            self.kind, self.word, self.start, self.end = "", "", self.text.end, self.text.end
            return
        self.kind, self.word = match.lastgroup, match[match.lastgroup]
        self.start, self.end = match.span(match.lastgroup)
        self.at = self.end
        if self.kind == "name" and self.word.upper() in _WORDS:
            self.kind, self.word = "sign", self.word.upper()

    def wrong(self, message: str, help: str = "", span: Span | None = None) -> Wrong:
        span = span or self.span(self.start, max(self.end, self.start))
        if span.start >= span.end:
            span = self.text
        help = help or "operands are tags, numbers and expressions of them"
        self.reading.malformed(span, message, help=help)
        return Wrong()

    def expect(self, sign: str) -> None:
        if self.word != sign:
            raise self.wrong(f"`{sign}` is missing")
        self.advance()

    def expect_end(self) -> None:
        if self.kind:
            raise self.wrong(f"`{self.word}` is not expected in an operand")

    # ---- expressions

    def expression(self, rank: int) -> Value:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            self.reading.too_large(self.text, MAX_DEPTH, "levels in an expression")
            raise Wrong
        left = self.unary()
        while self.kind == "sign" and _RANK.get(self.word, 0) > rank:
            op = self.word
            self.advance()
            right = self.expression(_RANK[op])
            left = arithmetic.binary(op, left, right, self.real, self.operands.support)
        self.depth -= 1
        return left

    def unary(self) -> Value:
        start, word = self.start, self.word.upper()
        if word in ("-", "+", "NOT"):
            self.advance()
            operand = self.expression(6)
            span = self.span(start, max(operand.span.end, start + 1))
            return arithmetic.unary(word, operand, span)
        return self.primary()

    def primary(self) -> Value:
        start, word, kind = self.start, self.word, self.kind
        if kind == "number":
            self.advance()
            return self.number(word, self.span(start, start + len(word)))
        if kind == "string":
            return self.string(word)
        if word == "(":
            self.advance()
            inner = self.expression(0)
            self.expect(")")
            return inner
        if kind != "name":
            if word == "?":
                raise self.wrong("an operand is `?`",
                                 "give it a tag or a number in the editor that the file comes from")
            raise self.wrong(f"`{word}` is no operand" if word else "an operand is missing")
        return self.named()

    def number(self, word: str, span: Span) -> Value:
        base, sharp, digits = word.partition("#")
        try:
            if sharp:
                return literal(int(digits.replace("_", ""), int(base)), span)
            if word.replace("_", "").isdecimal():
                return literal(int(word.replace("_", "")), span)
            value = float(word)
        except ValueError:
            raise self.wrong(f"`{word[:40]}` is no number", span=span) from None
        if not isfinite(value):
            raise self.wrong("this number is too large for a REAL", span=span)
        return literal(value, span)

    def string(self, word: str) -> Value:
        span = self.span(self.start, self.end)
        try:
            value, type_, shown = iec_literal(word)
        except Malformed:
            raise self.wrong("this is no string", span=span) from None
        self.advance()
        return Value(ast.Literal(value, type_, shown, span), Text(max(len(value), 1)), span)

    # ---- names

    def named(self) -> Value:
        word, start = self.word, self.start
        span = self.span(start, self.end)
        key = word.upper()
        if key in ("TRUE", "FALSE"):
            self.advance()
            return Value(boolean(key == "TRUE", span), BOOL, span)
        if _CALLED.match(self.source.text, self.end, self.text.end):
            self.advance()
            self.advance()
            argument = self.expression(0)
            self.expect(")")
            found = arithmetic.function(key, argument, self.span(start, argument.span.end),
                                        self.operands.support)
            if found is None:
                self.reading.unsupported(span, f"function {key}", "write it with instructions that are read")
                raise Wrong
            return found
        return self.steps(self.root(word, span), start)

    def root(self, word: str, span: Span) -> Value:
        """The tag; ``at`` then stands behind its name."""
        operands = self.operands
        if word[0] == "\\":
            return self.of_program(word[1:], span)
        tag = operands.scope.find(word)
        if tag is not None:
            if tag.alias is not None:
                return self.aliased(tag, span)
            return operands.tag_value(tag, span)
        if word.upper() == "S:FS" and operands.scan:
            wanted = f"{operands.scan}_first_scan"
            flag = operands.globals.add(f"first scan {operands.scan}", wanted, BOOL, span, "S:FS")
            return operands.tag_value(flag, span)
        if word.upper() in _STATUS:
            self.reading.unsupported(span, f"the status bit {word}",
                                     "test the result of the instruction instead")
            raise Wrong
        if ":" in word:
            return self.of_module(word, span)
        operands.strange = True
        if operands.globals.hides(word):
            # Another scope has a tag that our text calls so.
            raise self.wrong(f"there is no tag `{word}` in this scope",
                             "name a tag of the program or of the controller",
                             span)
        return Value(ast.Name(word, span), None, span, place=True)

    def of_program(self, program: str, span: Span) -> Value:
        """``\\Program.tag``: a tag of another program."""
        scope = self.operands.globals.programs.get(program.upper())
        step = _STEP.match(self.source.text, self.at, self.text.end)
        tag = scope.tags.get(step["name"].upper()) if scope and step and step["name"] else None
        if tag is None or tag.alias is not None:
            raise self.wrong(f"`{program}` has no such parameter", "name a program and one of its tags", span)
        self.at = step.end()
        return self.operands.tag_value(tag, self.span(span.start, self.at))

    def aliased(self, tag: Tag, span: Span) -> Value:
        if self.depth >= MAX_DEPTH:
            raise self.wrong(f"`{tag.foreign}` is an alias of itself", "let it name a tag", span)
        inner = Parser(self.operands, tag.alias, False, self.hint)
        inner.depth = self.depth + 10
        found = inner.expression(0)
        inner.expect_end()
        return found

    def of_module(self, word: str, span: Span) -> Value:
        """An input or output that no module of the file declares: a global variable for each that is used."""
        parts, text = [word], self.source.text
        at = self.at
        while True:
            step = _STEP.match(text, self.at, self.text.end)
            if step is None or step["bit"] or step["indirect"]:
                break
            if step["name"]:
                parts.append(step["name"])
                self.at = step.end()
                continue
            constant = _CONSTANT.match(text, step.end(), self.text.end)
            if constant is None:
                break
            parts.append(constant[1])
            self.at = constant.end()
        bit = step is not None and step["bit"]
        type_ = DINT if bit or self.hint is None else self.hint
        whole = self.span(span.start, max(self.at, at))
        tag = self.operands.globals.add("/".join(parts).upper(), "_".join(parts), type_, whole, whole.text)
        return self.operands.tag_value(tag, whole)

    # ---- members, elements, bits

    def steps(self, value: Value, start: int) -> Value:
        text = self.source.text
        while True:
            step = _STEP.match(text, self.at, self.text.end)
            if step is None:
                break
            self.at = step.end()
            kind = step.lastgroup
            if kind == "name":
                value = self.operands.member(value, step["name"], self.span(start, self.at))
            elif kind == "bit":
                number = literal(int(step["bit"]), self.span(*step.span("bit")))
                value = self.operands.bit(value, number, self.span(start, self.at))
            else:
                indexes = self.indexes()
                span = self.span(start, self.at)
                value = (self.operands.bit(value, indexes[0], span) if kind == "indirect"
                         else self.element(value, indexes, span))
        self.advance()
        return value

    def indexes(self) -> list[Value]:
        self.advance()
        real, self.real = self.real, False
        found = [self.expression(0)]
        while self.word == ",":
            self.advance()
            found.append(self.expression(0))
        if self.word != "]":
            raise self.wrong("`]` is missing")
        self.real = real
        self.at = self.end
        return found

    def element(self, value: Value, indexes: list[Value], span: Span) -> Value:
        if value.text is not None and len(indexes) == 1:
            name = self.operands.support.use("logix_char", N=str(value.text.type.length))
            return Value(call(name, span, value.expr, convert(indexes[0], DINT)), SINT, span, text=value.text)
        type_ = value.type.element if isinstance(value.type, Array) else None
        numbers = tuple(i.number for i in indexes)
        way = None
        constant = all(isinstance(n, int) for n in numbers)
        if value.way is not None and isinstance(value.type, Array) and constant:
            way = (value.way[0], (*value.way[1], numbers))
        expr = ast.Index(value.expr, tuple(i.expr for i in indexes), span)
        one = type_ is not None and len(indexes) == 1
        return Value(expr, type_, span, way=way, place=True, array=value if one else None,
                     at=indexes[0].expr if one else None,
                     whole_array=value if type_ is not None else None)
