"""The self-check of every compile: the IL of a rung against its drawing (DESIGN section 3).

Runs the graph (the reference meaning), the series/parallel tree and the IL over the same columns
(``symbolic``) and compares what each leaves behind: variables, hidden memories, calls, jumps.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping

from ldc.expr import Const, Expr, FieldStep, Place
from ldc.graph.evaluate import evaluate
from ldc.graph.memory import Memories
from ldc.graph.order import Turn
from ldc.graph.rung import RungGraph
from ldc.graph.tree import SPTree
from ldc.graph.tree_eval import evaluate_tree
from ldc.il.assignments import ALL, Operands, Term, Value
from ldc.il.lower_blocks import DIVISIONS, eno_drawn
from ldc.il.program import ARITHMETIC, COMPARISON, LOGIC, Instr
from ldc.il.symbolic import Memory
from ldc.library import blocks, functions
from ldc.model.elements import Block
from ldc.records import record
from ldc.symbols import Location, Variable
from ldc.types import BOOL, Instance, Type, default


@record
class Verdict:
    """``kind``: "proof" (all assignments of at most twelve operands), "check" (4,096 assignments) or
    "wrong"; then ``stage`` ("tree" or "il"), ``what`` differs and an ``example`` of operand values."""

    kind: str
    operands: int
    stage: str = ""
    what: str = ""
    example: tuple[tuple[str, object], ...] = ()


def verify(graph: RungGraph, turns: tuple[Turn, ...], memories: Memories, tree: SPTree | None,
           code: tuple[Instr, ...], temps: Iterable[Variable] = (),
           locations: Mapping[str, Location] | None = None, nullary: Collection[str] = ()) -> Verdict:
    """Compares drawing, tree (None: it is known to be right) and IL of one rung. ``temps``: variables of the
    IL that are not compared; ``locations``: located variables by capital name; ``nullary``: FUNCTIONs without
    inputs, in capitals."""
    operands = Operands()
    ignored = {(False, v.name.upper()) for v in temps}

    def run(stage: Callable[[GraphDomain], object]) -> tuple[Memory, dict]:
        memory = Memory(operands, locations)
        domain = GraphDomain(memory)
        stage(domain)
        return memory, _taken(domain.jumps)

    drawn = run(lambda domain: evaluate(graph, turns, domain, memories))
    reduced = drawn if tree is None else run(
        lambda domain: evaluate_tree(graph, tree, turns, domain, memories))
    memory = Memory(operands, locations)
    lowered = memory, _taken(execute(code, memory, nullary))
    kind = "proof" if operands.exhaustive else "check"
    count = len(operands.columns)
    for stage, other in (("tree", reduced), ("il", lowered)):
        difference = _difference(drawn, other, ignored) if other is not drawn else None
        if difference is not None:
            what, lanes = difference
            return Verdict("wrong", count, stage, what, _example(operands, lanes))
    return Verdict(kind, count)


# -- the drawing


class _Outputs(dict):
    """Output pins of a block, read when asked for: one that nothing uses is no operand."""

    def __init__(self, read: Callable[[str], Value]) -> None:
        super().__init__()
        self._read = read

    def __missing__(self, pin: str) -> Value:
        value = self[pin] = self._read(pin)
        return value


class GraphDomain:
    """Values of all assignments at once for the reference evaluator."""

    true, false = ALL, 0

    def __init__(self, memory: Memory) -> None:
        self.memory = memory
        self.jumps: list[tuple[int, str | None, int]] = []

    @staticmethod
    def and_(a: int, b: int) -> int:
        return a & b

    @staticmethod
    def or_(a: int, b: int) -> int:
        return a | b

    @staticmethod
    def not_(a: int) -> int:
        return ALL & ~a

    def contact(self, expr: Expr, power: int) -> int:
        value = self.memory.value(expr)
        return power & (value if type(value) is int else self.memory.operands.boolean(value))

    def value(self, expr: Expr, when: int) -> Value:
        return self.memory.value(expr)

    def zero(self, type_: Type) -> Value:
        return self.memory.value(Const(default(type_), type_))

    def store(self, place: Place, value: Value, when: int) -> None:
        self.memory.write(place, value, when)

    def choose(self, when: int, yes: Value, no: Value) -> Value:
        return self.memory.operands.choose(when, yes, no)

    def convert(self, value: Value, source: Type, target: Type) -> Value:
        return self.memory.apply(functions.conversion(source, target), [value], target)

    def recall(self, name: str, type_: Type = BOOL) -> Value:
        return self.memory.read(Place(name, type_))

    def remember(self, name: str, value: Value, type_: Type = BOOL) -> None:
        self.memory.write(Place(name, type_), value, ALL)

    def call_block(self, index: int, block: Block, inputs: Mapping[str, Value]) -> Mapping[str, Value]:
        instance = self.memory.taken(block.instance)
        for pin, value in inputs.items():
            self.memory.write(_pin(instance, block, pin), value, ALL)
        self.memory.call(instance, not block.signature.standard, ALL)
        return _Outputs(lambda pin: self.memory.read(_pin(instance, block, pin)))

    def call_function(self, index: int, block: Block, enable: int,
                      inputs: Mapping[str, Value]) -> tuple[int, Mapping[str, Value]]:
        if block.is_action:
            self._perform(block, enable)
            return enable, {}
        types = {p.pin: p.type for p in block.inputs}
        names = list(inputs)
        values = [inputs[name] for name in names]
        kinds = [types.get(name, BOOL) for name in names]
        eno = enable
        if block.callee in DIVISIONS and eno_drawn(block):
            divisor = next((p.source for p in block.inputs if p.pin == names[1]), None)
            if not (isinstance(divisor, Const) and divisor.value != 0):
                zero = self.zero(kinds[1])
                unequal = self.memory.operator("NE", [values[1], zero], kinds[1:] * 2, BOOL)
                eno &= self.memory.operands.boolean(unequal)

        seen = self.memory.seen(block.callee)

        def read(pin: str) -> Value:
            if pin == "OUT":
                return self.memory.operator(block.callee, values, kinds, block.signature.result, seen)
            parameter = block.signature.pin(pin)
            return self.memory.apply(f"{block.callee}.{parameter.name.upper()}", values, parameter.type, seen)

        return eno, _Outputs(read)

    def _perform(self, block: Block, when: int) -> None:
        if block.instance is None:
            self.memory.perform(block.callee, when)
            return
        chosen = next(pin for pin in block.inputs if pin.pin != "EN")
        instance = self.memory.taken(block.instance)
        pin = Place(instance.root, chosen.type, (*instance.steps, FieldStep(chosen.pin)), instance.is_global)
        self.memory.write(pin, self.memory.value(chosen.source), when)
        self.memory.call(instance, True, when)
        self.memory.write(pin, self.zero(chosen.type), when)

    def jump(self, index: int, label: str | None, when: int) -> None:
        self.jumps.append((index, label, when))


def _pin(instance: Place, block: Block, name: str) -> Place:
    parameter = block.signature.pin(name)
    return Place(instance.root, parameter.type, (*instance.steps, FieldStep(name)), instance.is_global)


# -- the IL


def execute(code: tuple[Instr, ...], memory: Memory,
            nullary: Collection[str] = ()) -> list[tuple[int, str | None, int]]:
    """Runs instructions on all assignments at once; assignments that jumped ahead wait at the label.

    The accumulator is the first argument of a function, but of those in ``nullary``, which take none.
    """
    jumps: list[tuple[int, str | None, int]] = []
    waiting: dict[str, int] = {}
    stack: list[tuple[str, Value, Type]] = []
    labels = {i.name for i in code if i.op == "LABEL"}
    active, acc, acc_type = ALL, 0, BOOL

    def load(operand: Const | Place) -> Value:
        return memory.value(operand) if isinstance(operand, Const) else memory.read(operand, active)

    for n, instr in enumerate(code):
        op, operand = instr.op, instr.operand
        if op in ("LD", "LDN"):
            acc, acc_type = load(operand), instr.type
            if op == "LDN":
                acc = memory.operator("NOT", [acc], [acc_type], acc_type)
        elif op in ("ST", "STN"):
            value = acc if op == "ST" else memory.operator("NOT", [acc], [instr.type], instr.type)
            memory.write(operand, memory.operands.boolean(value) if instr.type == BOOL else value, active)
        elif op in ("S", "R"):
            memory.write(operand, ALL if op == "S" else 0, active & memory.operands.boolean(acc))
        elif op == ")":
            opened, left, left_type = stack.pop()
            acc, acc_type = _binary(memory, opened, left, left_type, acc, acc_type)
        elif op == "NOT":
            acc = memory.operator("NOT", [acc], [acc_type], acc_type)
        elif op.endswith("("):
            stack.append((op[:-1], acc, acc_type))
            if operand is not None:
                acc, acc_type = load(operand), operand.type
        elif op == "FN":
            values = ([] if instr.name.upper() in nullary else [acc]) + [load(a) for a in instr.args]
            seen = memory.seen(instr.name)
            for name, place in instr.outputs:
                out = memory.apply(f"{instr.name}.{name.upper()}", values, place.type, seen)
                memory.write(place, out, active)
            types = [acc_type, *(a.type for a in instr.args)]
            acc, acc_type = memory.operator(instr.name, values, types, instr.type, seen), instr.type
        elif op == "CAL":
            standard = isinstance(operand.type, Instance) and blocks.signature(operand.type.pou) is not None
            memory.call(operand, not standard, active)
        elif op == "ACT":
            memory.perform(instr.name, active)
        elif op == "LABEL":
            active |= waiting.pop(instr.name, 0)
        elif op.startswith(("JMP", "RET")):
            taken = active
            if op.endswith("CN"):
                taken &= ~memory.operands.boolean(acc)
            elif op.endswith("C"):
                taken &= memory.operands.boolean(acc)
            active &= ~taken
            if op.startswith("JMP") and instr.name in labels:
                waiting[instr.name] = waiting.get(instr.name, 0) | taken
            else:
                jumps.append((n, instr.name or None, taken))
        else:
            acc, acc_type = _binary(memory, op, acc, acc_type, load(operand), operand.type)
    return jumps


def _binary(memory: Memory, op: str, left: Value, left_type: Type, right: Value, right_type: Type):
    if op in ("ANDN", "ORN", "XORN"):
        op, right = op[:-1], memory.operator("NOT", [right], [right_type], right_type)
    result = BOOL if op in COMPARISON else left_type
    assert op in LOGIC or op in COMPARISON or op in ARITHMETIC, op
    return memory.operator(op, [left, right], [left_type, right_type], result), result


# -- comparing


def _taken(jumps: list[tuple[int, str | None, int]]) -> dict[str | None, int]:
    """Where each assignment goes: the first jump in order that it takes."""
    left, taken = ALL, {}
    for _, label, when in sorted(jumps, key=lambda jump: jump[0]):
        if when & left:
            key = label.upper() if label else None
            taken[key] = taken.get(key, 0) | when & left
        left &= ~when
    return taken


def _difference(a: tuple[Memory, dict], b: tuple[Memory, dict], ignored: set[tuple]
                ) -> tuple[str, int] | None:
    """The first thing that two runs leave differently, and the assignments that show it."""
    (left, left_jumps), (right, right_jumps) = a, b
    if left_jumps != right_jumps:
        return "the jump that is taken", _jump_lanes(left_jumps, right_jumps)
    for one, other in zip(left.events, right.events):
        if one != other:
            return f"the call of {_name(one[1], one[2][0][0])}", ALL
    if len(left.events) != len(right.events):
        return "the number of calls", ALL
    for root in dict.fromkeys((*left.logs, *right.logs)):
        if root in ignored:
            continue
        mine, theirs = dict(left.state(root)), dict(right.state(root))
        for steps in dict.fromkeys((*mine, *theirs)):
            x, y = mine.get(steps), theirs.get(steps)
            if x != y:
                lanes = x ^ y if isinstance(x, int) and isinstance(y, int) else ALL
                return f"the value of {_name(root, steps)}", lanes
    return None


def _jump_lanes(a: dict, b: dict) -> int:
    for label in dict.fromkeys((*a, *b)):
        if a.get(label, 0) != b.get(label, 0):
            return a.get(label, 0) ^ b.get(label, 0)
    return ALL


def _name(root: tuple, steps: tuple) -> str:
    return "".join([str(root[1]), *map(_step_text, steps)])


def _step_text(step: object) -> str:
    if isinstance(step, str):
        return f".{step}"
    if step[0] == "ix":
        return f"[{', '.join(_describe(i) if isinstance(i, Term) else str(i) for i in step[1:])}]"
    return f".{step[1]}" if step[0] == "bit" else f"%{step[1] // 8}.{step[1] % 8}"


def _example(operands: Operands, lanes: int) -> tuple[tuple[str, object], ...]:
    lane = (lanes & -lanes).bit_length() - 1 if lanes else 0
    return tuple((_describe(term), bool(column >> lane & 1)) for term, column in operands.columns.items())


def _describe(term: Term) -> str:
    key = term.key
    if key[0] == "var":
        return _name(key[1], key[2])
    if key[0] == "const":
        return str(key[1])
    return f"{key[0]}({', '.join(_describe(t) for t in key[2:] if isinstance(t, Term))})"
