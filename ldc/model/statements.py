"""Types of statements: the AST of an ST body becomes actions (IEC 61131-3, 2nd edition, 3.3.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, Const, Expr, IndexStep, Load, Place
from ldc.library import functions
from ldc.model import action_calls, actions, enabling, expressions, ladder_blocks, parts, places
from ldc.model import statement_findings as findings
from ldc.model import type_findings
from ldc.model.elements import Block
from ldc.model.environment import Environment
from ldc.model.initial import computed
from ldc.model.ladder import not_a_condition
from ldc.model.values import Untyped, coerce, converted, settle, unsigned
from ldc.parser import ast
from ldc.parser import statements as st
from ldc.types import BOOL, DINT, Elementary, Enum, Instance, Type, storage

_COUNTING = ("int", "uint")
_CHOOSING = ("int", "uint", "bits")
_ANY = "*"
"""Stands among the variables that a loop writes when it may write all."""


def body(
    env: Environment, nodes: Iterable[st.Statement], diagnostics: Diagnostics
) -> tuple[actions.Action, ...]:
    """The actions of statements. One that is wrong is told and left out."""
    return _Typing(env, diagnostics).list(nodes)


def condition(env: Environment, node: ast.Expr, what: str, diagnostics: Diagnostics) -> Expr | None:
    """A BOOL expression; ``what`` names it in messages."""
    return _Typing(env, diagnostics).condition(node, what)


class _Typing:
    """``counting``: the FOR heads around, with the places that they count with."""

    def __init__(self, env: Environment, diagnostics: Diagnostics) -> None:
        self.env, self.diagnostics = env, diagnostics
        self.counting: list[tuple[Place, st.ForHead]] = []
        self.written: set[str] = set()

    def list(self, nodes: Iterable[st.Statement]) -> tuple[actions.Action, ...]:
        made = []
        for node in nodes:
            action = _TYPING[type(node)](self, node)
            if type(action) is tuple:
                made += action
            elif action is not None:
                made.append(action)
        return tuple(made)

    # ---- simple statements

    def assign(self, node: st.Assign) -> actions.Assign | actions.Call | None:
        called = enabling.as_call(self.env, node)
        if called is not None:
            return self.invoke(called)
        if parts.is_part(node.target):
            return self._assign_part(node)
        place = places.place(self.env, node.target, self.diagnostics, write=True)
        if place is None:
            expressions.value(self.env, node.value, None, self.diagnostics)
            return None
        self._wrote(place)
        value = expressions.expression(self.env, node.value, place.type, self.diagnostics,
                                       f"`{node.target.span.text}`")
        if value is None:
            return None
        return actions.Assign(place, value, node.span)

    def _assign_part(self, node: st.Assign) -> actions.Assign | None:
        """``word.%B1 := value``."""
        found = parts.part(self.env, node.target, self.diagnostics, write=True)
        wanted = found.type if found is not None else None
        value = expressions.expression(self.env, node.value, wanted, self.diagnostics,
                                       f"`{node.target.span.text}`")
        if found is None or value is None:
            return None
        if parts.calls_in_index(found.place):
            type_findings.bad_bit(self.diagnostics, node.target.span,
                                  "the index of this element calls a function",
                                  "a part of the element is assigned",
                                  "compute the index into a variable before")
            return None
        self._wrote(found.place)
        return actions.Assign(found.place, parts.assigned(found, value, node.span), node.span)

    def invoke(self, node: st.Invoke) -> actions.Call | tuple[actions.Action, ...] | None:
        """Pins are wired as those of a block in a ladder, but no power goes through it."""
        callee = node.callee
        action = action_calls.called(self.env, callee)
        if action is not None:
            return self._perform(node, action)
        name, instance = callee.name if type(callee) is ast.Name else "", None
        if not name or self.env.variable(name.upper()) is not None and not self._is_function(name):
            place = places.place(self.env, callee, self.diagnostics)
            if place is None:
                return None
            if not isinstance(place.type, Instance):
                type_findings.not_a_value(
                    self.diagnostics, callee.span, f"`{callee.span.text}` cannot be called",
                    f"this is {type_findings.described(place.type)}",
                    "only function blocks and functions are called")
                return None
            name, instance = place.type.pou, callee
        signature = self.env.signature(name.upper()) if instance is not None else None
        arguments, enable, told = enabling.apart(node.arguments, signature, self.diagnostics)
        drawn = _drawn(instance, name, arguments, node)
        block = ladder_blocks.block(self.env, drawn, _no_net, self.diagnostics)
        return self._called(node, block, enable, told)

    def _perform(self, node: st.Invoke, action: action_calls.Called) -> tuple[actions.Action, ...] | None:
        """An action of the POU itself may write any of its variables."""
        if action.instance is None:
            self.written.add(_ANY)
        arguments, enable, told = enabling.apart(node.arguments, None, self.diagnostics)
        name = action.owner.actions[action.number - 1]
        block = action_calls.block(self.env, action, _drawn(None, name, arguments, node), _no_net,
                                   self.diagnostics)
        return self._called(node, block, enable, told)

    def _called(self, node: st.Invoke, block: Block | None, enable: ast.Argument | None,
                told: ast.Argument | None) -> tuple[actions.Action, ...] | None:
        condition = self.condition(enable.value if enable is not None else None, "EN")
        taken = self._told(told) if told is not None else None
        if block is None or (condition is None) != (enable is None) or (taken is None) != (told is None):
            return None
        for pin in block.outputs:
            self._wrote(pin.target)
        return enabling.guarded(actions.Call(block, node.span), condition, taken)

    def _told(self, argument: ast.Argument) -> Place | None:
        """The variable that takes ENO."""
        place = places.place(self.env, argument.value, self.diagnostics, write=True)
        if place is None:
            return None
        self._wrote(place)
        fits = coerce(Const(True, BOOL), place.type, self.diagnostics, argument.span, "this variable")
        return place if fits is not None else None

    def _is_function(self, name: str) -> bool:
        """Whether the name is that of the FUNCTION itself, which is the variable of its result too."""
        signature = self.env.signature(name.upper())
        return signature is not None and signature.kind == "FUNCTION"

    def leave(self, node: st.Leave) -> actions.Leave:
        return actions.Leave(node.word, node.span)

    def empty(self, node: st.Empty) -> None:
        return None

    # ---- choices

    def condition(self, node: ast.Expr | None, what: str) -> Expr | None:
        if node is None:
            return None
        found = expressions.value(self.env, node, BOOL, self.diagnostics)
        if found is None:
            return None
        if type(found) is Untyped and found.value in (0, 1) and isinstance(found.value, int):
            return Const(bool(found.value), BOOL, node.span)
        typed = coerce(found, None, self.diagnostics, node.span)
        if typed is None or storage(typed.type) == BOOL:
            return typed
        not_a_condition(self.diagnostics, node.span, what, typed.type)
        return None

    def if_(self, node: st.If) -> actions.If | None:
        arms = []
        for arm in node.arms:
            condition = self.condition(arm.condition, "a condition")
            inner = self.list(arm.body)
            if condition is not None:
                arms.append(actions.Arm(condition, inner))
        otherwise = self.list(node.otherwise.body) if node.otherwise else ()
        return actions.If(tuple(arms), otherwise, node.span) if arms else None

    def case(self, node: st.Case) -> actions.Case | None:
        selector = self._selector(node.selector)
        choices, taken = [], []
        for choice in node.choices:
            labels = self._labels(choice, selector.type, taken) if selector is not None else ()
            choices.append(actions.Choice(labels, self.list(choice.body)))
        self._overlaps(taken)
        if selector is not None and isinstance(selector.type, Enum):
            known = {number for _, number in selector.type.values}
            if not known.issuperset(number for low, high, _ in taken for number in (low, high)):
                selector = converted(selector, DINT)  # labels that no value has
        otherwise = self.list(node.otherwise.body) if node.otherwise else ()
        return actions.Case(selector, tuple(choices), otherwise, node.span) if selector is not None else None

    def _selector(self, node: ast.Expr | None) -> Expr | None:
        found = expressions.value(self.env, node, None, self.diagnostics) if node is not None else None
        found = coerce(found, None, self.diagnostics, node.span) if found is not None else None
        if found is None:
            return None
        base = storage(found.type)
        if isinstance(found.type, Enum) or isinstance(base, Elementary) and base.kind in _CHOOSING:
            return found
        findings.bad_selector(self.diagnostics, node.span, found.type)
        return None

    def _labels(self, choice: st.Choice, type_: Type, taken: list) -> tuple[tuple[int, int], ...]:
        made = []
        for label in choice.labels:
            low = self._label(label.low, type_)
            high = low if label.high is None else self._label(label.high, type_)
            if low is None or high is None:
                continue
            if low > high:
                findings.bad_label(self.diagnostics, label.span, "this range is empty",
                                   f"{low} is above {high}", "write the smaller value first")
                continue
            made.append((low, high))
            taken.append((low, high, label.span))
        return tuple(made)

    def _label(self, node: ast.Expr, type_: Type) -> int | None:
        found = computed(self.env, node, type_, self.diagnostics, "this label")
        if found is None or type(found) is Const:
            return None if found is None else found.value
        findings.bad_label(self.diagnostics, node.span, "a label of CASE is constant",
                           "known only when the program runs",
                           "write a number, a constant or the name of a value")
        return None

    def _overlaps(self, taken: list) -> None:
        taken = sorted(taken, key=lambda entry: (entry[0], entry[2].start))
        for before, after in zip(taken, taken[1:]):
            if after[0] <= before[1]:
                first, second = sorted((before[2], after[2]), key=lambda span: span.start)
                findings.label_twice(self.diagnostics, second, first)

    # ---- loops

    def for_(self, node: st.For) -> actions.For | None:
        place = self._counter(node.head)
        if place is None:
            self.list(node.body)
            return None
        head, base = node.head, storage(place.type)
        number = unsigned(base) or base
        start = expressions.expression(self.env, head.start, base, self.diagnostics, "the start")
        stop = self._stop(head, number)
        step, down = self._step(head, number)
        outer, self.written = self.written, set()
        taken = len(self.env.taken)
        self.counting.append((place, head))
        inner = self.list(node.body)
        self.counting.pop()
        self.written.update(target.root.upper() for target in self.env.taken[taken:])
        variable = self.env.variable(place.root.upper())
        untouched = self.written.isdisjoint((_ANY, place.root.upper()))
        free = (untouched and not place.steps and not place.is_global and variable is not None
                and variable[0].location is None)
        self.written |= outer
        if start is None or stop is None or step is None:
            return None
        return actions.For(place, start, stop, step, number, down, free, inner, node.span)

    def _counter(self, head: st.ForHead | None) -> Place | None:
        if head is None:
            return None
        place = places.place(self.env, head.variable, self.diagnostics, write=True)
        if place is None:
            return None
        base = storage(place.type)
        if not isinstance(base, Elementary) or base.kind not in _CHOOSING or isinstance(place.type, Enum):
            findings.bad_variable(self.diagnostics, head.variable.span,
                                  f"this is {type_findings.described(place.type)}",
                                  "use a variable of an integer type or a bit string")
            return None
        if any(isinstance(s, IndexStep) and not all(isinstance(i, Const) for i in s.indexes)
               for s in place.steps):
            findings.bad_variable(self.diagnostics, head.variable.span, "an element with a computed index",
                                  "use a variable of its own")
            return None
        self._wrote(place)
        return place

    def _stop(self, head: st.ForHead, number: Elementary) -> Expr | None:
        """The end of the loop, in the type that the variable counts as, or in one that holds both."""
        found = expressions.value(self.env, head.stop, number, self.diagnostics)
        if found is None:
            return None
        typed = type(found) in (Const, Load, Apply) and not isinstance(found.type, Enum)
        own = found.type if typed else number
        own = unsigned(own) or storage(own)
        counts = isinstance(own, Elementary) and own.kind in _COUNTING
        wide = functions.common((number, own)) if counts else None
        return coerce(found, wide or number, self.diagnostics, head.stop.span, "the end")

    def _step(self, head: st.ForHead, base: Elementary) -> tuple[Expr | None, bool]:
        """The step and whether it is subtracted: an unsigned variable may count down by a constant."""
        if head.step is None:
            return Const(1, base, head.span), False
        found = expressions.value(self.env, head.step, base, self.diagnostics)
        if found is None:
            return None, False
        down = (type(found) is Untyped and base.kind == "uint" and isinstance(found.value, int)
                and found.value < 0)
        if down:
            found = settle(Untyped(-found.value, found.span), base, self.diagnostics)
        if found is not None:
            found = coerce(found, base, self.diagnostics, head.step.span, "the step")
        known = expressions.constant(self.env, found) if found is not None else None
        if known == 0:
            findings.zero_step(self.diagnostics, head.step.span)
            return None, False
        return (found if known is None else Const(known, base, head.step.span)), down

    def _wrote(self, target: Place | int) -> None:
        self.written.add(target.root.upper())
        for place, head in self.counting:
            if place.root.upper() == target.root.upper() and place.steps == target.steps:
                findings.variable_written(self.diagnostics, target.span or head.span, head.variable.span.text,
                                          head.variable.span)

    def while_(self, node: st.While) -> actions.While | None:
        condition = self.condition(node.condition, "a condition")
        inner = self.list(node.body)
        return None if condition is None else actions.While(condition, inner, node.span)

    def repeat(self, node: st.Repeat) -> actions.Repeat | None:
        inner = self.list(node.body)
        condition = self.condition(node.condition, "a condition")
        return None if condition is None else actions.Repeat(inner, condition, node.span)


def _drawn(instance: ast.Expr | None, name: str, arguments: tuple[ast.Argument, ...], node: st.Invoke
           ) -> ast.Block:
    """A call as a block without power."""
    pins = tuple(ast.Pin(a.name, a.value, a.output, a.span) for a in arguments)
    return ast.Block(instance, name, pins, "_", "_", node.span)


def _no_net(node: ast.Expr) -> int:
    raise TypeError(f"{node!r} is no network: statements have none")


_TYPING: dict[type, Callable] = {
    st.Assign: _Typing.assign, st.Invoke: _Typing.invoke, st.If: _Typing.if_, st.Case: _Typing.case,
    st.For: _Typing.for_, st.While: _Typing.while_, st.Repeat: _Typing.repeat, st.Leave: _Typing.leave,
    st.Empty: _Typing.empty,
}
