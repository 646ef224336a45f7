"""Statements to IL: jumps in the shapes that engines turn back into ``if`` and ``while`` (docs/st.md).

Each statement of a body has its own code, so that a fault names it. Conditions are computed whole: there
is no short circuit (IEC 61131-3, 3.3.1). Operands are computed from left to right where a call writes
variables.
"""

from __future__ import annotations

from collections.abc import Callable

from ldc.expr import SHORT_CIRCUIT, TRUE, Apply, Const, Expr, IndexStep, Load, Place, nodes
from ldc.il.emit import Emitter
from ldc.il.lower_blocks import BlockLowering
from ldc.il.program import Instr, RungCode
from ldc.il.values import Value, disjunction
from ldc.library import functions
from ldc.model import actions
from ldc.model.values import converted
from ldc.records import entity, replace
from ldc.symbols import Variable
from ldc.types import BOOL, Elementary, storage

# Arms after one another become nested ELSEs; engines in Python nest no deeper than about 30.
_ARMS = 12


def lower_body(body: tuple[actions.Action, ...], max_paren_depth: int | None = None, stem: str = "s"
               ) -> tuple[tuple[RungCode, ...], tuple[Variable, ...]]:
    """The code of each statement (keys ``s1``, ``s2``, ...) and the temporaries of all of them."""
    rungs, temps = [], {}
    for number, action in enumerate(body, 1):
        emit = Emitter(f"{stem}{number}", max_paren_depth)
        _Lowering(emit).action(action)
        rungs.append(RungCode(emit.key, emit.finish(), span=action.span))
        temps.update(emit.temps)
    return tuple(rungs), tuple(temps.values())


def lower_together(key: str, body: tuple[actions.Action, ...], max_paren_depth: int | None = None
                   ) -> tuple[tuple[Instr, ...], tuple[Variable, ...]]:
    """Several statements as one piece of code, and its temporaries."""
    emit = Emitter(key, max_paren_depth)
    _Lowering(emit).body(body)
    return emit.finish(), tuple(emit.temps.values())


@entity
class _Loop:
    """Where EXIT and CONTINUE of a loop go; ``left``: whether some EXIT does. ``again`` emits what is
    done before the next round."""

    exit: str
    again: Callable[[], None]
    left: bool = False


class _Lowering:
    def __init__(self, emit: Emitter) -> None:
        self.emit = emit
        self.blocks = BlockLowering(emit, _no_nets, {})
        self.loops: list[_Loop] = []

    def body(self, body: tuple[actions.Action, ...]) -> None:
        for action in body:
            self.action(action)
            if isinstance(action, actions.Leave):
                return  # what follows is never reached

    def action(self, action: actions.Action) -> None:
        mark = self.emit.mark()
        self.emit.span = action.span
        _LOWERING[type(action)](self, action)
        self.emit.release(mark)

    # ---- expressions

    def value(self, expr: Expr) -> None:
        self.emit.value(self.ordered(expr))

    def ordered(self, expr: Expr) -> Value:
        """The expression with the calls that write variables made now, and what stands left of them."""
        return self._ordered(expr) if _writes(expr) else expr

    def _ordered(self, expr: Value) -> Value:
        if isinstance(expr, Load):
            return Load(self._ordered_place(expr.place), expr.span)
        if expr.op in SHORT_CIRCUIT:
            return self._short_circuit(expr)
        arguments = list(expr.args)
        last = max((n for n, a in enumerate(arguments) if _writes(a)), default=-1)
        for n, argument in enumerate(arguments):
            if n <= last or expr.outputs:
                arguments[n] = self.ordered(argument)
            if n < last and not isinstance(arguments[n], Const):
                arguments[n] = self._kept(arguments[n])
        made = replace(expr, args=tuple(arguments))
        return self._call(made) if expr.outputs else made

    def _short_circuit(self, expr: Apply) -> Load:
        """``LD a / ST t / JMPCN skip / LD b / ST t / skip:``."""
        emit, skip = self.emit, self.emit.label()
        first, second = expr.args
        again = isinstance(first, Apply) and first.op in SHORT_CIRCUIT
        decided = self._short_circuit(first) if again else self._kept(first)
        emit.value(decided)
        emit.put("JMPCN" if expr.op == "AND_THEN" else "JMPC", name=skip)
        self.value(second)
        emit.store(decided.place)
        emit.put("LABEL", name=skip)
        return decided

    def _ordered_place(self, place: Place) -> Place:
        """The place with the indexes that call something computed now."""
        steps = tuple(IndexStep(tuple(self._kept(i) for i in s.indexes), s.bounds)
                      if isinstance(s, IndexStep) and any(map(_writes, s.indexes)) else s
                      for s in place.steps)
        return replace(place, steps=steps)

    def _kept(self, expr: Value) -> Load:
        """A value in a temporary, which nothing that follows changes."""
        self.emit.value(self.ordered(expr))
        place = self.emit.temp(expr.type)
        self.emit.store(place)
        return Load(place)

    def _call(self, call: Apply) -> Load:
        """A FUNCTION with outputs: its result and they go through temporaries, for their types may differ."""
        emit = self.emit
        targets = [(output, emit.place(self._ordered_place(output.place))) for output in call.outputs]
        taken = tuple((output.name, emit.temp(output.type)) for output in call.outputs)
        copies = [place for output, (_, place) in zip(call.outputs, taken, strict=True) if output.both]
        inputs = len(call.args) - len(copies)
        for value, copy in zip(call.args[inputs:], copies, strict=True):
            emit.value(value)
            emit.store(copy)
        args = (*call.args[:inputs], *map(Load, copies))
        rest = tuple(emit.simple(a) for a in args[1:])
        for first in args[:1]:
            emit.value(first)
        outer, emit.span = emit.span, call.span
        emit.put("FN", None, call.type, call.op, rest, taken)
        result = emit.temp(call.type)
        emit.store(result)
        for (output, target), (_, place) in zip(targets, taken, strict=True):
            emit.value(Load(place))
            source, wanted = storage(output.type), storage(target.type)
            if source != wanted and isinstance(source, Elementary) and isinstance(wanted, Elementary):
                emit.put("FN", None, wanted, functions.conversion(source, wanted))
            emit.store(target)
        emit.span = outer
        return Load(result)

    # ---- simple statements

    def assign(self, action: actions.Assign) -> None:
        """The value is computed before the index of the place."""
        emit = self.emit
        value = self.ordered(action.value)
        if any(isinstance(s, IndexStep) and any(map(_writes, s.indexes)) for s in action.place.steps):
            value = self._kept(value)
        place = emit.place(self._ordered_place(action.place))
        emit.value(value)
        emit.store(place)

    def call(self, action: actions.Call) -> None:
        block = action.block
        if any(isinstance(p.source, Apply) and _writes(p.source) for p in block.inputs):
            inputs = tuple(replace(p, source=self._kept(p.source)) for p in block.inputs)
            block = replace(block, inputs=inputs)
        self.blocks.lower(-1, block, {}, TRUE, False)

    def leave(self, action: actions.Leave) -> None:
        if action.word == "RETURN":
            self.emit.put("RET")
        elif action.word == "EXIT":
            self.loops[-1].left = True
            self.emit.put("JMP", name=self.loops[-1].exit)
        else:
            self.loops[-1].again()

    # ---- choices

    def if_(self, action: actions.If) -> None:
        arms = [(arm.condition, arm.body) for arm in action.arms]
        self._arms(arms, action.otherwise)

    def _arms(self, arms: list[tuple[Expr, tuple]], otherwise: tuple) -> None:
        """``cond JMPCN next … JMP end next: …``. After a number of arms a flag tells whether to go on."""
        emit = self.emit
        end, last = emit.label(), len(arms) - 1
        more = emit.temp(BOOL) if last >= _ARMS else None
        used = False
        if more is not None:
            emit.value(Const(False, BOOL))
            emit.store(more)
        for number, (condition, inner) in enumerate(arms[:_ARMS]):
            final = number == last and not otherwise
            follows = end if final else emit.label()
            self.value(condition)
            emit.put("JMPCN", name=follows)
            used |= final
            self.body(inner)
            if not final:
                if not self._left():
                    emit.put("JMP", name=end)
                    used = True
                emit.put("LABEL", name=follows)
        if more is None:
            self.body(otherwise)
        else:
            emit.value(TRUE)
            emit.store(more)
        if used:
            emit.put("LABEL", name=end)
        if more is not None:
            skip = emit.label()
            emit.value(Load(more))
            emit.put("JMPCN", name=skip)
            self._arms(arms[_ARMS:], otherwise)
            emit.put("LABEL", name=skip)

    def _left(self) -> bool:
        """Whether what was emitted last never goes on to what follows."""
        return bool(self.emit.out) and getattr(self.emit.out[-1], "op", "") in ("JMP", "RET")

    def case(self, action: actions.Case) -> None:
        emit = self.emit
        selector = emit.simple(self.ordered(action.selector))
        if isinstance(selector, Place) and any(isinstance(step, IndexStep) for step in selector.steps):
            selector = self._kept(Load(selector)).place
        chosen = selector if isinstance(selector, Const) else Load(selector)
        self._choices(chosen, [c for c in action.choices if c.labels], action.otherwise)

    def _choices(self, selector: Value, choices: list[actions.Choice], otherwise: tuple) -> None:
        """Few choices one after the other; of many it is first found out which half is meant."""
        if not choices:
            self.body(otherwise)
        elif len(choices) <= _ARMS:
            self._arms([(_chosen(selector, c), c.body) for c in choices], otherwise)
        else:
            half = len(choices) // 2
            self.emit.value(disjunction([_chosen(selector, c) for c in choices[:half]]))
            end, other = self.emit.label(), self.emit.label()
            self.emit.put("JMPCN", name=other)
            self._choices(selector, choices[:half], ())
            self.emit.put("JMP", name=end)
            self.emit.put("LABEL", name=other)
            self._choices(selector, choices[half:], otherwise)
            self.emit.put("LABEL", name=end)

    # ---- loops

    def while_(self, action: actions.While) -> None:
        emit = self.emit
        again, end = emit.label(), emit.label()
        loop = _Loop(end, lambda: emit.put("JMP", name=again))
        emit.put("LABEL", name=again)
        if action.condition != TRUE:
            self.value(action.condition)
            emit.put("JMPCN", name=end)
            loop.left = True
        self._inside(loop, action.body)
        loop.again()
        if loop.left:
            emit.put("LABEL", name=end)

    def repeat(self, action: actions.Repeat) -> None:
        emit = self.emit
        again, end = emit.label(), emit.label()

        def until() -> None:
            """Computed at CONTINUE too, so that no jump leads into the middle of the loop."""
            self.value(action.condition)
            if inner:
                emit.put("JMPCN", name=again)
                emit.put("JMP", name=end)
                loop.left = True
            else:
                emit.put("JMPCN", name=again)

        loop, inner = _Loop(end, until), True
        emit.put("LABEL", name=again)
        self._inside(loop, action.body)
        inner = False
        until()
        if loop.left:
            emit.put("LABEL", name=end)

    def for_(self, action: actions.For) -> None:
        """Counts without overflow: a value past the limit of the type ends the loop as well."""
        emit, place = self.emit, action.place
        self.value(action.start)
        emit.store(place)
        stop, step = self._once(action.stop), self._once(action.step)
        again, end = emit.label(), emit.label()
        loop = _Loop(end, lambda: self._count(action, stop, step, again, end), True)
        emit.put("LABEL", name=again)
        emit.value(self._past(converted(Load(place), storage(stop.type)), stop, step, action.down))
        emit.put("JMPC", name=end)
        self._inside(loop, action.body)
        emit.span = action.span
        loop.again()
        emit.put("LABEL", name=end)

    def _once(self, expr: Expr) -> Const | Load:
        """A bound of the loop, computed before it begins."""
        return expr if isinstance(expr, Const) else self._kept(expr)

    def _past(self, now: Value, bound: Value, step: Const | Load, down: bool) -> Apply:
        """Whether ``now`` is beyond ``bound`` in the direction of the step."""
        above, below = Apply("GT", (now, bound), BOOL), Apply("LT", (now, bound), BOOL)
        if isinstance(step, Const):
            return below if down or step.value < 0 else above
        if not storage(step.type).range[0]:
            return above
        zero = Const(0, step.type)
        return Apply("OR", (Apply("AND", (Apply("GE", (step, zero), BOOL), above), BOOL),
                            Apply("AND", (Apply("LT", (step, zero), BOOL), below), BOOL)), BOOL)

    def _count(self, action: actions.For, stop: Const | Load, step: Const | Load, again: str,
               end: str) -> None:
        emit, place = self.emit, action.place
        base = action.number
        now = converted(Load(place), base)
        following = Apply("SUB" if action.down else "ADD", (now, step), base)
        if action.free and isinstance(stop, Const) and isinstance(step, Const):
            furthest = stop.value - step.value if action.down else stop.value + step.value
            if base.range[0] <= furthest <= base.range[1]:
                emit.value(converted(following, storage(place.type)))
                emit.store(place)
                emit.put("JMP", name=again)
                return
        mark = emit.mark()
        made = emit.temp(base)
        emit.value(following)
        emit.store(made)
        emit.value(self._past(now, Load(made), step, action.down))
        emit.put("JMPC", name=end)
        emit.value(converted(Load(made), storage(place.type)))
        emit.store(place)
        emit.put("JMP", name=again)
        emit.release(mark)

    def _inside(self, loop: _Loop, body: tuple[actions.Action, ...]) -> None:
        self.loops.append(loop)
        self.body(body)
        self.loops.pop()


def _chosen(selector: Value, choice: actions.Choice) -> Value:
    return disjunction([_within(selector, low, high) for low, high in choice.labels])


def _within(selector: Value, low: int, high: int) -> Apply:
    if low == high:
        return Apply("EQ", (selector, Const(low, selector.type)), BOOL)
    return Apply("AND", (Apply("GE", (selector, Const(low, selector.type)), BOOL),
                         Apply("LE", (selector, Const(high, selector.type)), BOOL)), BOOL)


def _writes(expr: Value) -> bool:
    """Whether an expression has to be made in order: it calls a function that writes variables, or jumps."""
    return any(type(node) is Apply and (node.outputs or node.op in SHORT_CIRCUIT) for node in nodes(expr))


def _no_nets(net: int, value: Value) -> None:
    raise TypeError(f"net {net}: statements feed no nets")


_LOWERING: dict[type, Callable] = {
    actions.Assign: _Lowering.assign, actions.Call: _Lowering.call, actions.If: _Lowering.if_,
    actions.Case: _Lowering.case, actions.For: _Lowering.for_, actions.While: _Lowering.while_,
    actions.Repeat: _Lowering.repeat, actions.Leave: _Lowering.leave,
}
