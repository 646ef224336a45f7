"""Calls of actions: bodies of a POU that are executed in its scope, where they are called (docs/st.md).

An action of the POU itself is ``name()``, one of an instance of a function block ``instance.name()``; a
ladder draws ``<name()>`` and ``<instance: name()>``. An instance is told by a pin which of its actions a call
means.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.expr import Const, Place
from ldc.free_names import free_name
from ldc.model import places
from ldc.model.elements import Block, PinIn
from ldc.model.environment import Environment
from ldc.model.pins import NetOf
from ldc.model.wiring import Wiring
from ldc.parser import ast
from ldc.records import record, replace
from ldc.symbols import ACTION, Parameter, Signature
from ldc.types import INT, Instance

SELECTOR = "ldc_action"


@record
class Called:
    """The action ``number`` (from 1) of a POU; ``instance``: where it is called, None for the POU itself."""

    owner: Signature
    number: int
    instance: Place | None


def called(env: Environment, callee: ast.Expr) -> Called | None:
    """The action that ``callee`` is: ``name``, ``Pou.name`` within the POU, ``instance.name``; or None."""
    if type(callee) is ast.Name:
        return _own(env, callee.name)
    if type(callee) is not ast.Member:
        return None
    base = callee.base
    around = env.signature(env.pou.upper())
    if type(base) is ast.Name and around is not None and around.called(base.name):
        return _own(env, callee.name)
    return of_instance(env, base, callee.name)


def of_instance(env: Environment, instance: ast.Expr, name: str) -> Called | None:
    """The action with the name that the instance of a function block has, if it does."""
    place = places.place(env, instance, Diagnostics())
    if place is None or not isinstance(place.type, Instance):
        return None
    owner = env.signature(place.type.pou)
    number = owner.action(name) if owner is not None else 0
    return Called(owner, number, place) if number else None


def _own(env: Environment, name: str) -> Called | None:
    owner = env.signature(env.pou.upper())
    number = owner.action(name) if owner is not None else 0
    return Called(owner, number, None) if number else None


def block(
    env: Environment, found: Called, node: ast.Block, net_of: NetOf, diagnostics: Diagnostics
) -> Block | None:
    """The call as a block with EN and ENO, and no other pins."""
    if found.instance is not None and not places.lent(env, found.instance, diagnostics):
        return None
    signature = Signature(ACTION, found.owner.actions[found.number - 1])
    made = Wiring(env, node, signature, net_of, diagnostics).function()
    if made is None or found.instance is None:
        return made
    pin = selector(found.owner)
    chosen = PinIn(pin.name, pin.type, Const(found.number, INT), node.span)
    return replace(made, instance=found.instance, inputs=(*made.inputs, chosen))


def selector(owner: Signature) -> Parameter:
    """The pin that tells a function block which of its actions a call means; it is 0 for its body."""
    return owner.inputs[-1]


def selector_name(taken: frozenset[str]) -> str:
    """What it is called, beside names in capitals that the POU has."""
    return free_name(SELECTOR, taken)
