"""EN and ENO of calls in statements (IEC 61131-3, 2nd edition, 2.5.1.2 and 2.5.2.1a; docs/st.md).

What declares no such pins itself is called when EN is TRUE, and ENO tells whether it was; the ENO of a
function may also tell that it failed.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.expr import Const, Expr, Place
from ldc.model import actions
from ldc.model import call_findings as findings
from ldc.model.calls import standard_function
from ldc.model.environment import Environment
from ldc.parser import ast
from ldc.parser import statements as st
from ldc.symbols import Signature
from ldc.types import BOOL

_PINS = ("EN", "ENO")


def as_call(env: Environment, node: st.Assign) -> st.Invoke | None:
    """``y := f(EN := c, a, ENO => ok)`` is ``f(EN := c, a, ENO => ok, OUT => y)``; None for what is not
    such."""
    call = node.value
    if type(call) is not ast.Call or not any(a.name and a.name.upper() in _PINS for a in call.arguments):
        return None
    signature = env.signature(call.name.upper())
    function = signature.kind == "FUNCTION" if signature is not None else (
        standard_function(call.name.upper()) is not None)
    if not function:
        return None
    result = ast.Argument("OUT", node.target, True, node.target.span)
    return st.Invoke(ast.Name(call.name, call.span), (*call.arguments, result), node.span)


def apart(
    arguments: tuple[ast.Argument, ...], block: Signature | None, diagnostics: Diagnostics
) -> tuple[tuple[ast.Argument, ...], ast.Argument | None, ast.Argument | None]:
    """The arguments of a call without EN and ENO, and these two where they are given and no pins of the
    function block. A function (``block`` is None) has an ENO by itself."""
    found: dict[str, ast.Argument] = {}
    rest = []
    for argument in arguments:
        key = argument.name.upper() if argument.name is not None else ""
        own = key == "ENO" if block is None else block.pin(key) is not None
        if key not in _PINS or own or argument.output != (key == "ENO"):
            rest.append(argument)
        elif key in found:
            findings.pin_twice(diagnostics, argument.span, key, "given again here", found[key].span,
                               "give it once")
        else:
            found[key] = argument
    return tuple(rest), found.get("EN"), found.get("ENO")


def guarded(call: actions.Call, enable: Expr | None, told: Place | None) -> tuple[actions.Action, ...]:
    """The call, made when ``enable`` is TRUE (None: always); ``told`` takes whether it was. Nothing is
    computed for a call that is not made. A function that is called tells by its own ENO."""
    own = next((pin.target for pin in call.block.outputs if pin.pin == "ENO"), None)
    made = (call,) if told is None else (call, _tell(told, True, call))
    if enable is None:
        return made
    target = told or own
    otherwise = () if target is None else (_tell(target, False, call),)
    return (actions.If((actions.Arm(enable, made),), otherwise, call.span),)


def _tell(target: Place, value: bool, call: actions.Call) -> actions.Assign:
    return actions.Assign(target, Const(value, BOOL), call.span)
