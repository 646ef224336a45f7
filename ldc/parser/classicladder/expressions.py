"""The expressions in compare and operate blocks: ``@200/0@:=MINI(@200/1@,@200/2@)+$1F``, 32 bits wide.

``@type/offset@`` is a variable, ``@type/offset[type/offset]@`` one that an index chooses. From loose
to tight: ``|``, ``&``, ``+ -``, ``* / %``, ``^``. As in the tool, ``a ^ b`` squares b times. In tools with
registers ``^`` is XOR, between ``|`` and ``&``, and a division by zero gives 0.
"""

from __future__ import annotations

import re

from ldc.parser.classicladder.container import Line
from ldc.parser.classicladder.settings import CLASSIC, REGISTERS
from ldc.parser.classicladder.variables import Place, Variables, base
from ldc.source import Span

_MAX_LENGTH, _MAX_DEPTH = 1_000, 8
_TOKEN = re.compile(
    r"\s*(?:(?P<var>@(\d{1,4})/(\d{1,6})(?:\[(\d{1,4})/(\d{1,6})\])?@)|(?P<hex>\$[0-9A-Fa-f]{1,8})"
    r"|(?P<dec>\d{1,10})|(?P<char>'[^']{1,4}')|(?P<name>[A-Z]+)|(?P<op><>|<=|>=|:=|[-+*/%&|^!<>=(),]))",
    re.ASCII,
)
_COMPARISONS = ("<>", "<=", ">=", "<", ">", "=")
_ADDITIONS = {"+": "+", "-": "-"}
_PRODUCTS = {"*": "*", "/": "/", "%": "MOD"}
_SAFE = {"/": "divide", "%": "remainder"}
_BY = {"POW": "pow", "SHL": "shift_left", "SHR": "shift_right", "ROL": "rotate_left", "ROR": "rotate_right"}
INDEX = re.compile(r"@(\d{1,4})/\d{1,6}\[")


class Wrong(Exception):
    """The expression breaks the rules; the message says how."""


class Expression:
    """One expression. ``names``: the variables in it, for the order of evaluation."""

    def __init__(self, variables: Variables, line: Line) -> None:
        self.variables, self.line = variables, line
        self.names: set[str] = set()
        self.newest = variables.settings.age == REGISTERS
        self.at, self.depth = 0, 0
        self.tokens: list[re.Match] = []

    def compare(self) -> str:
        """A BOOL expression."""
        self._scan()
        left = self._or()
        operator = self._take(_COMPARISONS)
        if operator is None:
            raise Wrong("there is no comparison in it")
        right = self._or()
        self._end()
        return f"{left} {operator} {right}"

    def operate(self) -> tuple[Place, str]:
        """The target, and what is stored there as an expression of its type."""
        self._scan()
        target = self._variable()
        if self._take((":=", "=")) is None:
            raise Wrong("`:=` is missing behind the target")
        value = self._or()
        self._end()
        if not target.writable:
            raise Wrong("its target cannot be written")
        if target.type == "BOOL":
            return target, f"({value}) <> 0"
        return target, f"DINT_TO_REAL({value})" if target.type == "REAL" else value

    # ---- tokens

    def _scan(self) -> None:
        text, at = self.line.text.rstrip(), 0
        if len(text) > _MAX_LENGTH:
            raise Wrong("it is too long")
        while at < len(text):
            match = _TOKEN.match(text, at)
            if match is None:
                raise Wrong(f"`{text[at : at + 10]}` has no meaning in it")
            self.tokens.append(match)
            at = match.end()

    def _take(self, operators) -> str | None:
        if self.at < len(self.tokens) and self.tokens[self.at]["op"] in operators:
            self.at += 1
            return self.tokens[self.at - 1]["op"]
        return None

    def _end(self) -> None:
        if self.at < len(self.tokens):
            raise Wrong(f"`{self.tokens[self.at][0].strip()}` is too much in it")

    # ---- the grammar: each gives the text of a DINT expression

    def _or(self) -> str:
        return self._bits("|", "OR", self._xor if self.newest else self._and)

    def _xor(self) -> str:
        return self._bits("^", "XOR", self._and)

    def _and(self) -> str:
        return self._bits("&", "AND", self._sum)

    def _bits(self, operator: str, word: str, operand) -> str:
        operands = [operand()]
        while self._take((operator,)):
            operands.append(operand())
        if len(operands) == 1:
            return operands[0]
        return f"DWORD_TO_DINT({f' {word} '.join(f'DINT_TO_DWORD({o})' for o in operands)})"

    def _sum(self) -> str:
        return self._chain(_ADDITIONS, self._product)

    def _product(self) -> str:
        return self._zero_divisors() if self.newest else self._chain(_PRODUCTS, self._power)

    def _zero_divisors(self) -> str:
        """Products where a division by zero gives 0."""
        made, single = self._term(), True
        while (operator := self._take(tuple(_PRODUCTS))) is not None:
            by = self._term()
            if operator == "*" or by.strip("(-)").isdigit() and by != "0":
                made, single = f"{made} {_PRODUCTS[operator]} {by}", False
            else:
                function = self.variables.supporting(_SAFE[operator])
                made, single = f"{function}({made}, {by})", True
        return made if single else f"({made})"

    def _chain(self, operators: dict[str, str], operand) -> str:
        parts = [operand()]
        while (operator := self._take(tuple(operators))) is not None:
            parts += [operators[operator], operand()]
        return parts[0] if len(parts) == 1 else f"({' '.join(parts)})"

    def _power(self) -> str:
        value = self._term()
        if self._take(("^",)) is None:
            return value
        if self.variables.settings.age != CLASSIC:
            self.variables.reading.unsupported(
                self.line.span, "`^`, which some versions take for a power and some for XOR,",
                "write it with `*`, or with `|`, `&` and `-`")
        function = self.variables.supporting("power")
        self._deeper()
        times = self._power()
        self.depth -= 1
        return f"{function}({value}, {times})"

    def _term(self) -> str:
        if self._take(("!",)) is not None:
            self._deeper()
            value = self._term()
            self.depth -= 1
            return f"BOOL_TO_DINT({value} = 0)"
        if self._take(("(",)) is not None:
            self._deeper()
            value = self._or()
            self._close()
            self.depth -= 1
            return f"({value})"
        sign = self._take(("-",))
        if self.at == len(self.tokens):
            raise Wrong("it ends too early")
        token = self.tokens[self.at]
        number = _constant(token)
        if number is not None:
            self.at += 1
            number = -number if sign else number
            number = (number + (1 << 31)) % (1 << 32) - (1 << 31)
            return f"({number})" if number < 0 else str(number)
        if sign:
            raise Wrong("`-` stands before something that is no number")
        return self._function(token["name"]) if token["name"] else self._value()

    def _deeper(self) -> None:
        self.depth += 1
        if self.depth > _MAX_DEPTH:
            raise Wrong(f"it is nested more than {_MAX_DEPTH} deep")

    def _close(self) -> None:
        if self._take((")",)) is None:
            raise Wrong("`)` is missing")

    def _function(self, name: str) -> str:
        self.at += 1
        if self._take(("(",)) is None:
            raise Wrong(f"`(` is missing behind {name}")
        values = [self._argument()]
        while self._take((",",)) is not None:
            values.append(self._argument())
        self._close()
        if name == "ABS" and len(values) == 1:
            return f"ABS({values[0]})"
        if name in ("MINI", "MAXI"):
            return f"{name[:3]}({', '.join(values)})" if len(values) > 1 else values[0]
        if name in ("MOY", "AVG"):
            return f"(({' + '.join(values)}) / {len(values)})"
        if name in _BY and len(values) == 2:
            return f"{self.variables.supporting(_BY[name])}({', '.join(values)})"
        if name in _BY:
            raise Wrong(f"{name} takes two values")
        raise Wrong(f"there is no function {name}")

    def _argument(self) -> str:
        return self._value() if self._number() is None else self._term()

    def _number(self) -> int | None:
        """The constant that comes next, without its sign."""
        at = self.at
        if at < len(self.tokens) and self.tokens[at]["op"] == "-":
            at += 1
        return _constant(self.tokens[at]) if at < len(self.tokens) else None

    def _value(self) -> str:
        """A variable as a number."""
        place = self._variable()
        if place.type == "BOOL":
            return f"BOOL_TO_DINT({place.text})"
        return f"REAL_TRUNC_DINT({place.text})" if place.type == "REAL" else place.text

    def _variable(self) -> Place:
        token = self.tokens[self.at] if self.at < len(self.tokens) else None
        if token is None or token["var"] is None:
            raise Wrong("a variable is missing in it")
        self.at += 1
        start = self.line.span.start
        span = Span(self.line.span.source, start + token.start("var"), start + token.end("var"))
        index = None
        if token[4] is not None:
            place = self.variables.place(int(token[4]), int(token[5]), span)
            if place.type != "DINT":
                raise Wrong("an index is a word")
            self.names.add(base(place.text))
            index = place.text
        place = self.variables.place(int(token[2]), int(token[3]), span, index)
        self.names.add(base(place.text))
        return place


def _constant(token: re.Match) -> int | None:
    if token["dec"]:
        return int(token["dec"])
    if token["hex"]:
        return int(token["hex"][1:], 16)
    if token["char"]:
        value = 0
        for character in token["char"][1:-1]:
            value = value * 256 + (ord(character) & 0xFF)
        return value
    return None
