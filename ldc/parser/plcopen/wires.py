"""Types of what wires between blocks carry, and what other editors make of a number on its way.

A net has the type of the pin that feeds it. Where it goes to a pin of another type, the conversion stands
between the two: a widening, or one that other editors do by themselves (kinds.py), with a warning.
"""

from __future__ import annotations

from ldc.library import blocks, functions
from ldc.parser import ast
from ldc.parser.plcopen import kinds
from ldc.parser.plcopen.drawing import Element
from ldc.parser.plcopen.guarded import Additions
from ldc.types import BOOL, ELEMENTARY, Elementary


def pin_type(type_: str, is_function: bool, pin: str, more: Additions) -> Elementary | None:
    """The elementary type of a pin of a function block, or of a function of the project other than its
    result; None when it has another one or is not known."""
    key = pin.upper()
    own = (more.functions if is_function else more.interfaces).get(type_.upper())
    if own is not None:
        found = next((v.type for group in own.values() for v in group if v.name.upper() == key), None)
        name = found.name.upper() if isinstance(found, ast.NamedType) else ""
        type_of_pin = ELEMENTARY.get(name)
    else:
        signature = None if is_function else blocks.signature(type_.upper())
        declared = signature.pin(key) if signature is not None else None
        type_of_pin = declared.type if declared is not None else None
    return type_of_pin if isinstance(type_of_pin, Elementary) else None


def carried(source: Element, pin: str, more: Additions) -> Elementary | None:
    """The number that an output of a block gives; None when it is none, or not known: an operator's depends
    on its operands."""
    if source.kind != "block" or pin.upper() == "ENO":
        return None
    type_, is_function = source.node.get("typeName").strip(), not source.node.get("instanceName").strip()
    found = pin_type(type_, is_function, pin, more)
    if found is None and is_function and type_.upper() not in more.functions:
        found = kinds.result(type_)
    return found if found is not None and found.name in kinds.NUMBERS else None


def is_power(source: Element, pin: str) -> bool:
    """Whether an output surely carries BOOL; ``pin`` in capitals."""
    if source.kind != "block":
        return source.kind in ("contact", "coil")
    type_ = source.node.get("typeName").strip().upper()
    if pin == "ENO" or not source.node.get("instanceName") and type_ in kinds.COMPARING:
        return True
    signature = blocks.signature(type_)
    return signature is not None and any(p.name == pin and p.type == BOOL for p in signature.outputs)


def conversion(source: Elementary | None, target: Elementary | None) -> str | None:
    """The function between a pin that gives one type and a pin that takes another; None when none is needed,
    or the value may not fit."""
    if source is None or target is None or source == target:
        return None
    if functions.widens(source, target) or kinds.needed(kinds.Kind(source, source.bits), target):
        return f"{source.name}_TO_{target.name}"
    return None
