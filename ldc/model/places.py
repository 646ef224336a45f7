"""Places: what a name, a member, an index or an address refers to, and whether it may be written."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ldc.diagnostics import Diagnostics
from ldc.expr import Const, Expr, FieldStep, IndexStep, Place, Step
from ldc.model import call_findings, declaration_findings, expressions, parts
from ldc.model import type_findings as findings
from ldc.model.environment import Environment
from ldc.model.names import PREFIX, suggest
from ldc.model.values import AnyEnum, Untyped, as_index, settle
from ldc.parser import ast
from ldc.records import replace
from ldc.source import Span
from ldc.symbols import Location, Parameter, Variable
from ldc.types import (
    BOOL,
    BYTE,
    DINT,
    DWORD,
    LWORD,
    REAL,
    TIME,
    WORD,
    Array,
    Elementary,
    Enum,
    Instance,
    Struct,
    Subrange,
    Type,
    holds_blocks,
)

_ADDRESS_TYPES = {"X": BOOL, "B": BYTE, "W": WORD, "D": DWORD, "L": LWORD}
_INTRINSIC = {"%NOW": TIME, "%FIRST_SCAN": BOOL}

_INSTEAD = {
    "FUNCTION_BLOCK": "declare an instance: `name : {};`", "FUNCTION": "call it: `{}(...)`",
    "PROGRAM": "variables that several programs use are declared in VAR_GLOBAL",
}


def variable_place(found: tuple[Variable, bool], span: Span | None) -> Place:
    variable, is_global = found
    return Place(variable.name, variable.type, (), is_global, span)


def place(env: Environment, node: ast.Expr, diagnostics: Diagnostics, write: bool = False) -> Place | None:
    """The place that ``node`` names; with ``write`` it must be one that may be written."""
    chain = []
    base = node
    while type(base) is ast.Member or type(base) is ast.Index:
        if parts.is_part(base):
            findings.bad_bit(diagnostics, base.span, f"the part `{base.name}` is no variable",
                             "a variable is needed here",
                             "parts are read, and assigned to in statements: take a variable between")
            return None
        if type(base) is ast.Member and parts.is_part(base.base):
            base = parts.without_parts(env, base, diagnostics)
            if base is None:
                return None
        chain.append(base)
        base = base.base
    if type(base) is ast.Name:
        found = env.variable(base.name.upper())
        if found is None and chain and type(chain[-1]) is ast.Member:
            found = _by_path(env, base, chain[-1], diagnostics)
            if found is None:
                return None
            chain.pop()
        elif found is None:
            _unknown(env, base, diagnostics)
            return None
        if not chain and not write:
            return variable_place(found, node.span)
        root, type_, is_global, variable = found[0].name, found[0].type, found[1], found[0]
    elif type(base) is ast.Direct:
        direct = _direct(env, base, diagnostics)
        if direct is None:
            return None
        root, type_, is_global, variable = direct.root, direct.type, True, None
    else:
        findings.not_a_value(diagnostics, base.span, "a variable is needed here", "this is no variable",
                             "name a variable, an element of an array, a member or an address")
        return None
    steps: list[Step] = []
    read_only = ""
    for link in reversed(chain):
        if isinstance(link, ast.Index):
            stepped = _index(env, link, type_, diagnostics)
        else:
            stepped = _member(env, link, type_, diagnostics)
            if isinstance(type_, Instance):
                read_only = _output_of(env, type_, link.name)
        if stepped is None:
            return None
        steps.append(stepped[0])
        type_ = stepped[1]
    found = Place(root, type_, tuple(steps), is_global, node.span)
    if write and not (_own(env, found, steps[:-1], diagnostics) and _writable(
            env, node, root, variable, is_global, read_only, diagnostics)):
        return None
    return found


def lent(env: Environment, place: Place, diagnostics: Diagnostics) -> bool:
    """Whether an instance, or what holds some, may be called or changed: not the copy that an input has, nor
    what another instance was lent, which is over with its call."""
    return _own(env, place, place.steps, diagnostics)


def _own(env: Environment, place: Place, steps: Sequence[Step], diagnostics: Diagnostics) -> bool:
    variable, is_global = env.variable(place.root.upper()) or (None, True)
    if variable is not None and variable.kind == "input" and not is_global and holds_blocks(variable.type):
        call_findings.only_read(diagnostics, place.span, variable.name, "VAR_INPUT of this POU",
                                "declare it in VAR_IN_OUT")
        return False
    for owner, step in owners(env, place, steps):
        pin = handed_pin(env, owner, step)
        if pin is not None:
            call_findings.only_read(diagnostics, place.span, pin.name, f"a pin of {owner}",
                                    "name the instance that the call gave")
            return False
    return True


def handed_pin(env: Environment, owner: Type, step: Step) -> Parameter | None:
    """The pin of an instance that takes other instances, if the step leads to one."""
    signature = env.signature(owner.pou) if isinstance(owner, Instance) else None
    pin = signature.pin(step.name) if signature is not None else None
    return pin if pin is not None and holds_blocks(pin.type) else None


def owners(env: Environment, place: Place, steps: Sequence[Step]) -> Iterator[tuple[Type, Step]]:
    """The steps into a variable that holds instances, each with the type of what it leads into."""
    found = env.variable(place.root.upper())
    type_ = None if found is None else found[0].type
    for step in steps:
        if type_ is None or not holds_blocks(type_):
            return
        yield type_, step
        if isinstance(type_, Array):
            type_ = type_.element
        elif isinstance(type_, Struct):
            type_ = type_.field(step.name).type
        else:
            pin = handed_pin(env, type_, step)
            type_ = None if pin is None else pin.type


def _by_path(
    env: Environment, base: ast.Name, member: ast.Member, diagnostics: Diagnostics
) -> tuple[Variable, bool] | None:
    """A variable of another program, or of a list of globals."""
    found = env.path(base.name.upper(), member.name.upper())
    if found is None:
        _unknown(env, base, diagnostics)
    elif isinstance(found, str):
        if not env.silent(base.name.upper()) and not env.silent_pin(base.name.upper(), member.name.upper()):
            call_findings.not_reached(diagnostics, member.span, f"{base.name}.{member.name}", found)
    else:
        return found
    return None


def _unknown(env: Environment, node: ast.Name, diagnostics: Diagnostics) -> None:
    key = node.name.upper()
    if env.silent(key):
        return
    choices = env.enum_values(key)
    signature = env.signature(key)
    if choices:
        findings.not_a_value(diagnostics, node.span, f"`{node.name}` is no variable",
                             f"this is a value of {choices[0][0]}", "name a variable")
    elif signature is not None:
        kind = signature.kind.lower().replace("_", " ")
        findings.not_a_value(diagnostics, node.span, f"`{node.name}` is no variable", f"this is a {kind}",
                             _INSTEAD[signature.kind].format(signature.name))
    elif env.type_named(key) is not None:
        findings.not_a_value(diagnostics, node.span, f"`{node.name}` is no variable", "this is a type",
                             f"declare a variable: `name : {node.name};`")
    elif (own := env.signature(env.pou.upper())) is not None and own.action(node.name):
        findings.not_a_value(diagnostics, node.span, f"`{node.name}` is no variable", "this is an action",
                             f"call it: `{node.name}();`")
    else:
        findings.unknown_name(diagnostics, node.span, node.name, suggest(node.name, env.names()))


def _direct(env: Environment, node: ast.Direct, diagnostics: Diagnostics) -> Place | None:
    key = node.address.upper()
    if env.library and key in _INTRINSIC:
        return Place(key, _INTRINSIC[key], (), True, node.span)
    location = checked_location(node.address, env.image_bytes, node.span, diagnostics)
    if location is None:
        return None
    return Place(str(location), _ADDRESS_TYPES[location.size], (), True, node.span)


def checked_location(
    text: str, image_bytes: int, span: Span, diagnostics: Diagnostics, count: int = 1,
) -> Location | None:
    """An address that lies within the process image, with all ``count`` elements."""
    location = Location.parse(text)
    if location is None:
        declaration_findings.bad_address(
            diagnostics, span, text, "not understood",
            "addresses are written %IX0.0 (byte.bit, bits 0 to 7), %QB1, %MW2, %ID3, %QL4")
        return None
    if count != 1:
        location = replace(location, count=count)
    last = location.byte + (location.bit + location.extent + 7) // 8
    if last > image_bytes:
        declaration_findings.bad_address(
            diagnostics, span, text, f"needs byte {last - 1} of {image_bytes}",
            f"%{location.area} has the bytes 0 to {image_bytes - 1}; choose a lower address "
            "or make the image larger in ldc.toml")
        return None
    return location


def _member(
    env: Environment, node: ast.Member, type_: Type, diagnostics: Diagnostics
) -> tuple[Step, Type] | None:
    if parts.names_bit(env, node, type_):
        step = parts.bit(env, node, type_, diagnostics)
        return None if step is None else (step, BOOL)
    if isinstance(type_, Struct):
        field = type_.field(node.name)
        if field is not None:
            return FieldStep(field.name), field.type
        names = [f.name for f in type_.fields]
    elif isinstance(type_, Instance):
        signature = env.signature(type_.pou)
        pin = signature.pin(node.name) if signature is not None else None
        if signature is None or pin is None and env.silent_pin(type_.pou, node.name.upper()):
            return None
        if pin is not None:
            return FieldStep(pin.name), pin.type
        names = [p.name for p in signature.inputs + signature.outputs + signature.in_outs]
    else:
        findings.not_a_value(diagnostics, node.base.span,
                             f"`{node.name}` is asked of a value without members",
                             f"this is {findings.described(type_)}",
                             "only structures and function blocks have members; a bit has a number, or a "
                             "constant as its name")
        return None
    findings.unknown_member(diagnostics, node.span, type_, node.name,
                            suggest(node.name, names) or ("it has " + ", ".join(names[:12]) if names else
                                                          "only inputs and outputs are seen from outside"))
    return None


def _index(
    env: Environment, node: ast.Index, type_: Type, diagnostics: Diagnostics
) -> tuple[Step, Type] | None:
    if not isinstance(type_, Array):
        findings.bad_index(diagnostics, node.base.span, "an index is put on what is no array",
                           f"this is {findings.described(type_)}", "take the index away")
        return None
    count = len(type_.bounds)
    if len(node.indexes) != count:
        findings.bad_index(diagnostics, node.span,
                           f"the array has {count} dimension{'s' if count > 1 else ''}",
                           f"{len(node.indexes)} given",
                           "give one index for each dimension")
        return None
    indexes = [_one_index(env, written, *bounds, diagnostics)
               for written, bounds in zip(node.indexes, type_.bounds, strict=True)]
    if None in indexes:
        return None
    return IndexStep(tuple(indexes), type_.bounds), type_.element


def _one_index(
    env: Environment, node: ast.Expr, low: int, high: int, diagnostics: Diagnostics
) -> Expr | None:
    found = expressions.value(env, node, None, diagnostics)
    if found is None:
        return None
    if type(found) is AnyEnum:
        return settle(found, None, diagnostics)
    if type(found) is Untyped:
        found = Const(found.value, DINT if isinstance(found.value, int) else REAL, node.span)
    number = as_index(found)
    if number is not None:
        (findings.enumerated if isinstance(found.type, Enum) else findings.counted)(
            diagnostics, node.span, found.type, number.type)
        found = number
    type_ = found.type.base if isinstance(found.type, Subrange) else found.type
    if not isinstance(type_, Elementary) or type_.kind not in ("int", "uint"):
        findings.bad_index(diagnostics, node.span, "an index must be an integer",
                           f"this is {findings.described(type_)}")
        return None
    known = expressions.constant(env, found)
    if known is not None and not low <= known <= high:
        findings.out_of_bounds(diagnostics, node.span, known, low, high)
        return None
    return found


def _output_of(env: Environment, type_: Instance, name: str) -> str:
    """The name of the instance's type when the pin is one that only the block itself writes: an output, or a
    VAR_IN_OUT, of which an instance keeps the value that its last call left."""
    signature = env.signature(type_.pou)
    key = name.upper()
    return signature.name if any(p.name.upper() == key for p in signature.outputs + signature.in_outs) else ""


def _writable(
    env: Environment, node: ast.Expr, root: str, variable: Variable | None, is_global: bool,
    read_only: str, diagnostics: Diagnostics,
) -> bool:
    declared = variable.span if variable is not None else None
    location = variable.location if variable is not None else Location.parse(root)
    if read_only:
        why, help = f"an output of {read_only}", "only the block itself writes its outputs"
    elif variable is not None and variable.name.upper() in env.flags:
        why, help = "kept by the chart", "a transition activates steps, a step its actions"
    elif variable is not None and variable.constant:
        why, help = "a constant", "take the CONSTANT away, or write another variable"
    elif variable is not None and variable.kind == "input":
        if not variable.name.upper().startswith(PREFIX):
            call_findings.own_input(diagnostics, node.span, variable.name, declared)
            return True
        why, help = "the edge of an input", "copy it to a variable of its own"
    elif location is not None and location.area == "I":
        why, help = "an input of the controller", "inputs are read only; use %Q or %M"
    elif is_global and env.kind == "FUNCTION":
        why, help = "outside of this FUNCTION", "a FUNCTION has no side effects; return it as an output"
    else:
        return True
    call_findings.not_writable(diagnostics, node.span, root if variable is None else node.span.text, why,
                               help, declared)
    return False

