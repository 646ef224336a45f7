"""What a name means in a POU, as bytes: two rungs of one text mean the same where all their names do.

An element asks its surroundings about names only (``Environment``), and about types that these lead to. So
the meanings of all words of a rung, with the kind of its POU, tell all that its typing depends on.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

from ldc.model.scope import Scope
from ldc.symbols import Signature, Variable
from ldc.types import Array, Elementary, Instance, Struct, Type

NOTHING = b"-"


def surroundings(scope: Scope) -> str:
    """What a rung depends on beside its names."""
    return repr((scope.pou.upper(), scope.kind, scope.library, scope.image_bytes, scope.statements,
                 sorted(scope.flags)))


def meaning(scope: Scope, name: str) -> bytes:
    """All that a name (in capitals) may stand for in the POU; ``NOTHING`` when that is nothing."""
    found = scope.variable(name)
    others = (scope.enum_values(name), scope.signature(name), scope.type_named(name), scope.labels.get(name),
              tuple(map(_said, scope.reached(name))), name in scope.model.lists)
    if found is None and not any(others):
        return NOTHING
    variable = None if found is None else (*_said(found[0]), found[1])
    if variable is not None and type(found[0].type) is Elementary and not any(others):
        return repr(variable).encode()  # most names, and nothing that these lead to
    starts: list[Type] = [] if found is None else [found[0].type]
    if others[1] is not None:
        starts += _types(others[1])
    if others[2] is not None:
        starts.append(others[2])
    starts += (v.type for v in scope.reached(name))
    text = repr((variable, others, *_reached(scope, starts)))
    return hashlib.sha256(text.encode("utf-8", "surrogatepass")).digest()


def _said(v: Variable) -> tuple:
    """What a declaration says, wherever it stands."""
    at = None if v.location is None else (str(v.location), v.location.count)
    return v.name, _brief(v.type), v.kind, v.initial, v.retain, v.constant, at


def _brief(type_: Type) -> str | Type:
    return type_.name if isinstance(type_, Elementary) else type_


def _reached(scope: Scope, starts: list[Type]) -> Iterator[Signature | None]:
    """The signatures of all blocks that values of the types hold, each once."""
    todo, seen = starts, set()
    while todo:
        match todo.pop():
            case Array(element=element):
                todo.append(element)
            case Struct(fields=fields):
                todo += [field.type for field in fields]
            case Instance(pou) if pou not in seen:
                seen.add(pou)
                signature = scope.signature(pou)
                yield signature
                todo += [] if signature is None else _types(signature)


def _types(signature: Signature) -> list[Type]:
    pins = (*signature.inputs, *signature.outputs, *signature.in_outs)
    return [pin.type for pin in pins] + ([] if signature.result is None else [signature.result])
