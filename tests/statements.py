"""ST programs at random, and what they mean: a small interpreter of the parser's statements."""

from __future__ import annotations

from hypothesis import strategies as st

from ldc.parser import ast, statements

RANGES = {"INT": (-32768, 32767), "SINT": (-128, 127), "USINT": (0, 255)}
TYPES = {"i0": "INT", "i1": "INT", "i2": "INT", "k0": "INT", "k1": "SINT", "k2": "USINT", "n": "INT"}
BOOLS = ("b0", "b1", "b2")
HEAD = """FUNCTION after : INT
VAR_INPUT
    a : INT;
END_VAR
VAR_OUTPUT
    twice : INT;
END_VAR
    after := a + 1;
    twice := a * 2;
END_FUNCTION

FUNCTION_BLOCK adder
VAR_INPUT
    v : INT;
END_VAR
VAR_OUTPUT
    sum : INT;
END_VAR
    sum := sum + v;
END_FUNCTION_BLOCK

TYPE
    Holder : STRUCT
        inner : adder;
    END_STRUCT;
END_TYPE

PROGRAM main
VAR
    i0, i1, i2, k0, n : INT;
    k1 : SINT;
    k2 : USINT;
    b0, b1, b2 : BOOL;
    field : ARRAY [0..3] OF INT;
    total : adder;
    row : ARRAY [0..1] OF Holder;
END_VAR
"""

ints = st.sampled_from(["i0", "i1", "i2"])
callees = st.sampled_from(["total", "total", "row[0].inner", "row[1].inner"])
numbers = st.sampled_from(["1", "2", "3", "-1", "-4", "7", "40", "1000", "32767", "-32768"])
_leaves = ints | ints | st.just("k0") | st.integers(0, 3).map("field[{}]".format) | ints.map("field[{}]".format)


def _arithmetic(inner):
    pairs = st.tuples(inner, st.sampled_from(["+", "-", "*", "+", "/", "MOD"]), inner | numbers)
    calls = st.tuples(inner, ints).map(lambda t: f"after(a := {t[0]}, twice => {t[1]})")
    return pairs.map(lambda t: f"({t[0]} {t[1]} {t[2]})") | calls


values = st.recursive(_leaves, _arithmetic, max_leaves=4)
compares = st.tuples(values, st.sampled_from(["<", "<=", "=", "<>", ">", ">="]), values | numbers).map(
    lambda t: f"{t[0]} {t[1]} {t[2]}")
conditions = st.recursive(
    st.sampled_from(BOOLS) | compares.map("({})".format),
    lambda inner: st.tuples(inner, st.sampled_from(["AND", "OR", "XOR", "AND_THEN", "OR_ELSE"]), inner).map(
        lambda t: f"({t[0]} {t[1]} {t[2]})") | inner.map("(NOT {})".format), max_leaves=3)


@st.composite
def blocks(draw, depth: int = 0, loops: int = 0) -> str:
    return "\n".join(draw(st.lists(one(depth, loops), min_size=depth == 0, max_size=4 if depth < 2 else 2))) + "\n"


@st.composite
def one(draw, depth: int, loops: int) -> str:
    kinds = ["set", "set", "bit", "field", "call", "enabled", "if", "if", "case", "for", "while", "repeat"]
    kind = draw(st.sampled_from(kinds[:6] if depth >= 3 else kinds))
    if loops and draw(st.integers(0, 5)) == 0:
        return f"IF {draw(conditions)} THEN {draw(st.sampled_from(['EXIT', 'CONTINUE']))}; END_IF;"
    if draw(st.integers(0, 30)) == 0:
        return f"IF {draw(conditions)} THEN RETURN; END_IF;"
    inner = blocks(depth + 1, loops)
    match kind:
        case "set":
            return f"{draw(ints)} := {draw(values)};"
        case "bit":
            return f"{draw(st.sampled_from(BOOLS))} := {draw(conditions)};"
        case "field":
            return f"field[{draw(st.integers(0, 3) | ints)}] := {draw(values)};"
        case "call":
            return f"{draw(callees)}(v := {draw(values)}, sum => {draw(ints)});"
        case "enabled" if draw(st.booleans()):
            return (f"{draw(callees)}(EN := {draw(conditions)}, v := {draw(values)}, sum => {draw(ints)}, "
                    f"ENO => {draw(st.sampled_from(BOOLS))});")
        case "enabled":
            return (f"{draw(ints)} := after(EN := {draw(conditions)}, a := {draw(values)}, "
                    f"twice => {draw(ints)}, ENO => {draw(st.sampled_from(BOOLS))});")
        case "if":
            arms = " ELSIF ".join(f"{draw(conditions)} THEN\n{draw(inner)}" for _ in range(draw(st.integers(1, 3))))
            other = f"ELSE {draw(inner)}" if draw(st.booleans()) else ""
            return f"IF {arms}{other}END_IF;"
        case "case":
            chosen = draw(st.lists(st.integers(-3, 30), unique=True, min_size=1, max_size=20))
            arms = "".join(f"{n}: {draw(inner) if at < 3 else f'i0 := {at};'}" for at, n in enumerate(chosen))
            other = f"ELSE {draw(inner)}" if draw(st.booleans()) else ""
            return f"CASE {draw(values)} OF {arms} 40..50, 60: {draw(inner)}{other}END_CASE;"
    body = draw(blocks(depth + 1, loops + 1))
    if kind == "for":
        name = draw(st.sampled_from(["k0", "k1", "k2"]))
        low, high = RANGES[TYPES[name]]
        ends = [draw(st.integers(-4, 4) | st.sampled_from([low, low + 2, high, high - 3])) for _ in range(2)]
        start, stop = (min(max(e, low), high) for e in ends)
        if abs(stop - start) > 300:
            stop = start
        by = draw(st.sampled_from(["", "BY 2", "BY -1", "BY -3", "BY 100"] if low else ["", "BY 3", "BY -1"]))
        if name == "k0" and draw(st.booleans()):
            return f"FOR k0 := {draw(ints)} MOD 5 TO {draw(ints)} MOD 7 BY {draw(ints)} MOD 3 + 4 DO\n{body}END_FOR;"
        return f"FOR {name} := {start} TO {stop} {by} DO\n{body}END_FOR;"
    if kind == "while":
        return f"n := 0; WHILE n < 6 AND {draw(conditions)} DO\nn := n + 1;\n{body}END_WHILE;"
    return f"n := 0; REPEAT\nn := n + 1;\n{body}UNTIL n > 5 OR {draw(conditions)} END_REPEAT;"


programs = blocks().map(lambda body: f"{HEAD}{body}END_PROGRAM\n")


class Fault(Exception):
    """A division by zero or an index outside of the array."""


class TooLong(Exception):
    """More rounds than a test should wait for."""


class _Exit(Exception):
    pass


class _Continue(Exception):
    pass


class _Return(Exception):
    pass


def wrap(value: int, kind: str = "INT") -> int:
    low, high = RANGES[kind]
    return (value - low) % (high - low + 1) + low


class Interpreter:
    """Executes the program ``main`` of HEAD; ``values`` are its variables by name."""

    def __init__(self, file: ast.File) -> None:
        self.body = next(p for p in file.pous if p.name == "main").body.statements
        self.values: dict[str, object] = dict.fromkeys(TYPES, 0) | dict.fromkeys(BOOLS, False)
        self.field, self.rounds = [0] * 4, 0
        self.sums: dict[str, int] = {}

    def scan(self) -> None:
        self.rounds = 0
        try:
            self.run(self.body)
        except _Return:
            pass

    def run(self, body) -> None:
        for statement in body:
            self.one(statement)

    def one(self, node) -> None:
        match node:
            case statements.Assign(target, ast.Call(arguments=(enable, given, taken, told))):
                on = self.value(enable.value)
                if on:
                    a = self.value(given.value)
                    # The result is stored first, then the other outputs, in declared order.
                    self.store(target, wrap(a + 1))
                    self.values[taken.value.name] = wrap(a * 2)
                self.values[told.value.name] = on
            case statements.Assign(target, value):
                found = self.value(value)
                self.store(target, found)
            case statements.Invoke(callee, arguments=(given, taken)):
                self.add(callee, given, taken)
            case statements.Invoke(callee, arguments=(enable, given, taken, told)):
                on = self.value(enable.value)
                if on:
                    self.add(callee, given, taken)
                self.values[told.value.name] = on
            case statements.If(arms, otherwise):
                chosen = next((a for a in arms if self.value(a.condition)), otherwise)
                self.run(chosen.body if chosen else ())
            case statements.Case(selector, choices, otherwise):
                number = self.value(selector)
                fits = (c for c in choices if any(
                    self.value(x.low) <= number <= self.value(x.high or x.low) for x in c.labels))
                chosen = next(fits, otherwise)
                self.run(chosen.body if chosen else ())
            case statements.For():
                self.count(node)
            case statements.While(condition, body):
                while self.value(condition) and self.round(body):
                    pass
            case statements.Repeat(body, condition):
                while self.round(body) and not self.value(condition):
                    pass
            case statements.Leave(word):
                raise {"EXIT": _Exit, "CONTINUE": _Continue, "RETURN": _Return}[word]

    def add(self, callee: ast.Expr, given: ast.Argument, taken: ast.Argument) -> None:
        """A call of an adder."""
        key = callee.span.text
        self.sums[key] = wrap(self.sums.get(key, 0) + self.value(given.value))
        self.store(taken.value, self.sums[key])

    def round(self, body) -> bool:
        """Whether the loop goes on."""
        self.rounds += 1
        if self.rounds > 3000:
            raise TooLong
        try:
            self.run(body)
        except _Continue:
            pass
        except _Exit:
            return False
        return True

    def count(self, node: statements.For) -> None:
        name, head = node.head.variable.name, node.head
        low, high = RANGES[TYPES[name]]
        self.values[name] = self.value(head.start)
        stop = self.value(head.stop)
        step = 1 if head.step is None else self.value(head.step)
        while (self.values[name] <= stop if step >= 0 else self.values[name] >= stop) and self.round(node.body):
            following = self.values[name] + step
            if not low <= following <= high:
                return
            self.values[name] = following

    def store(self, target: ast.Expr, value: object) -> None:
        if isinstance(target, ast.Index):
            self.field[self.index(target)] = value
        else:
            self.values[target.name] = value

    def index(self, node: ast.Index) -> int:
        at = self.value(node.indexes[0])
        if not 0 <= at <= 3:
            raise Fault
        return at

    def value(self, node: ast.Expr):
        match node:
            case ast.Literal(value):
                return value
            case ast.Name(name):
                return self.values[name]
            case ast.Index():
                return self.field[self.index(node)]
            case ast.Unary("NOT", operand):
                return not self.value(operand)
            case ast.Call(arguments=(given, taken)):
                a = self.value(given.value)
                self.values[taken.value.name] = wrap(a * 2)
                return wrap(a + 1)
            case ast.Binary("AND_THEN", left, right):
                return self.value(left) and self.value(right)
            case ast.Binary("OR_ELSE", left, right):
                return self.value(left) or self.value(right)
            case ast.Binary(op, left, right):
                return self.binary(op, self.value(left), self.value(right))
        raise TypeError(node)

    def binary(self, op: str, a, b):
        match op:
            case "AND":
                return a and b
            case "OR":
                return a or b
            case "XOR":
                return a != b
            case "/" | "MOD":
                if b == 0:
                    raise Fault
                quotient = abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)
                return wrap(quotient if op == "/" else a - quotient * b)
            case "+" | "-" | "*":
                return wrap({"+": a + b, "-": a - b, "*": a * b}[op])
        return {"<": a < b, "<=": a <= b, "=": a == b, "<>": a != b, ">": a > b, ">=": a >= b}[op]
