"""Contacts, coils, one-shots, timers, counters and jumps of LDmicro as ladder text.

A function of this module and its neighbours takes an instruction and gives the elements that mean it, in
series; power passes through them as it does in LDmicro.
"""

from __future__ import annotations

from ldc.parser.ldmicro.context import Context, as_string
from ldc.parser.ldmicro.text import Leaf
from ldc.parser.ldmicro.variables import BIT, STRINGS, number, wider

_COMPARISONS = {"EQU": "=", "NEQ": "<>", "GRT": ">", "GEQ": ">=", "LES": "<", "LEQ": "<="}
_KINDS = {"/": 0, "\\": 1, "-": 2, "o": 3}
_MODIFIERS = ("/", "S", "R")
MASTER = "master_relay"


def contacts(context: Context, leaf: Leaf) -> str:
    name = context.bit(leaf.args[0], leaf)
    if leaf.args[2:3] not in ((), ("0",)):
        context.reading.remark("left out", leaf.args[0], "that it begins as 1 in the simulator", leaf.span)
    return f"[/{name}]" if leaf.args[1] != "0" else f"[{name}]"


def coil(context: Context, leaf: Leaf) -> str:
    """The first flag that is set decides: negated, set, reset, toggle."""
    name = context.bit(leaf.args[0], leaf)
    flags = leaf.args[1:5]
    for modifier, flag in zip(_MODIFIERS, flags, strict=False):
        if flag != "0":
            return f"({modifier} {name})" if modifier != "/" else f"(/{name})"
    if flags[3:] not in ((), ("0",)):
        block = context.supporting("toggle")
        return f"<{context.instance(block, f'toggle_{name}', leaf)}: {block}(COIL := {name})>"
    return f"({name})"


def comparison(context: Context, leaf: Leaf) -> str:
    left, right = leaf.args[:2]
    types = [t for text in (left, right) if (t := context.operand_type(text, leaf))]
    type_ = wider(*types) if types else "DINT"
    a, b = (context.operand(text, type_, leaf) for text in (left, right))
    return f"[{a} {_COMPARISONS[leaf.word]} {b}]"


def bit_test(context: Context, leaf: Leaf) -> str:
    variable = context.integer(leaf.args[0], leaf)
    string = STRINGS[variable.type]
    mask = f"SHL({string}#1, {context.operand(leaf.args[1], 'INT', leaf)})"
    sign = "<>" if leaf.word == "IF_BIT_SET" else "="
    return f"[({as_string(variable.name, variable.type)} AND {mask}) {sign} {string}#0]"


def nothing(context: Context, leaf: Leaf) -> str:
    return ""


def opened(context: Context, leaf: Leaf) -> str:
    return "[FALSE]"


def watchdog(context: Context, leaf: Leaf) -> str:
    context.reading.left_out(leaf.span, "CLRWDT", "it keeps the watchdog of the chip quiet")
    return ""


def rising(context: Context, leaf: Leaf) -> str:
    return f"<{context.instance('R_TRIG', 'osr', leaf)}: R_TRIG()>"


def one_shot(context: Context, leaf: Leaf) -> str:
    word = leaf.word.lower()
    block = context.supporting(word)
    return f"<{context.instance(block, word, leaf)}: {block}()>"


# ---- timers and counters: their count is a variable like any other


def timer(context: Context, leaf: Leaf) -> str:
    count = context.integer(leaf.args[0], leaf)
    period = context.periods.get(leaf.span.start)
    if period is None:
        text = context.operand(leaf.args[1], count.type, leaf)
    else:
        text = str(period)
        if leaf.word == "TOF":
            count.initial = text
    word = leaf.word.lower()
    block = context.supporting(word, type=count.type)
    name = context.instance(block, f"{word}_{count.name}", leaf)
    return f"<{name}: {block}(PERIOD := {text}, COUNT := {count.name})>"


def time_to_count(context: Context, leaf: Leaf) -> str:
    target = context.integer(leaf.args[0], leaf)
    return f"<MOVE(IN := {context.periods.get(leaf.span.start) or 1}, OUT => {target.name})>"


def counter(context: Context, leaf: Leaf) -> str:
    name, limit, *more = leaf.args
    count = context.integer(name, leaf)
    init = more[0] if more else "0"
    kind = _KINDS.get(more[1] if len(more) > 1 else "/")
    if kind is None:
        context.reading.malformed(leaf.span, f"a counter has no input `{more[1][:20]}`")
        kind = 0
    first = context.operand(init, count.type, leaf)
    fixed = number(init) is not None
    if fixed and first != "0":
        count.initial = first
    word = leaf.word.lower()
    block = context.supporting(word, type=count.type)
    instance = context.instance(block, f"{word}_{count.name}", leaf)
    maximum = context.operand(limit, count.type, leaf)
    load = "FALSE" if fixed else "TRUE"
    return (f"<{instance}: {block}(KIND := {kind}, MAX := {maximum}, FIRST := {load}, INIT := {first}, "
            f"COUNT := {count.name})>")


def reset(context: Context, leaf: Leaf) -> str:
    """RES: a counter gets the value that it begins with, a timer 0, a PWM output is switched off."""
    name = leaf.args[0]
    if name[:1] == "P":
        target = context.added(f"{name}_duty", "INT", leaf, f"the duty cycle of {name} in percent")
        return f"<MOVE(IN := 0, OUT => {target})>"
    count = context.integer(name, leaf)
    value = context.operand(context.resets.get(name, "0"), count.type, leaf)
    return f"<MOVE(IN := {value}, OUT => {count.name})>"


# ---- the order of rungs


def master_relay(context: Context, leaf: Leaf) -> str:
    block = context.supporting("master_relay")
    relay = context.added(MASTER, BIT, leaf, "the power of all rungs between two master relays")
    return f"<{context.instance(block, 'master', leaf)}: {block}(RELAY := {relay})>"


def goto(context: Context, leaf: Leaf) -> str:
    target = context.labels.get(leaf.args[0])
    if target is None:
        context.reading.malformed(leaf.span, f"there is no LABEL `{leaf.args[0][:40]}` in this (sub)program")
        return ""
    return f">>{target}"


def leave(context: Context, leaf: Leaf) -> str:
    return ">>RETURN"


def gosub(context: Context, leaf: Leaf) -> str:
    name = context.subprograms.get(leaf.args[0])
    if name is None:
        context.reading.malformed(leaf.span, f"there is no SUBPROG `{leaf.args[0][:40]}`")
        return ""
    instance = f"call_{name}"
    context.body.instances[instance] = (name, leaf.span)
    return f"<{instance}: {name}()>"
