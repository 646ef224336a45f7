"""A component as a function block: what the ladder sees of it (SPEC 8, DESIGN 6)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

from ldc.components import findings
from ldc.components.descriptor import ENABLE, ERROR, POWER, TIME_STEP, Component, Pin
from ldc.diagnostics import Diagnostics
from ldc.parser import ast, parse_expression, parse_file
from ldc.source import SourceFile, Span


def pou(
    component: Component,
    sources: tuple[SourceFile, ...],
    diagnostics: Diagnostics,
    on_slave: bool = False,
) -> ast.Pou | None:
    """The FUNCTION_BLOCK of a component: ``enable``, inputs and parameters in, outputs, ``ENO`` and
    ``error`` out, the state as its variables. ``sources`` are the files of its body. None with findings
    when the body of an IL or ST component cannot be read. ``on_slave``: a slave executes it by itself, so
    that its local pins are none of the ladder, but variables of the body."""
    name_span = component.span("component", "name")
    inputs, outputs = (
        tuple(p for p in pins if not (on_slave and p.local)) for pins in (component.inputs, component.outputs)
    )
    local = tuple(p for p in (*component.inputs, *component.outputs) if on_slave and p.local)
    sections = [
        _section(
            "VAR_INPUT",
            (
                *_enable(component),
                *_declared(inputs, diagnostics),
                *_declared(component.parameters, diagnostics),
            ),
            component,
        ),
        _section("VAR_OUTPUT", _outputs(component, outputs, diagnostics), component),
        *_state((*local, *component.state), component, diagnostics),
        _section("VAR_TEMP", (_variable(TIME_STEP, "TIME", name_span),), component),
    ]
    if component.native:
        body = ast.NativeBody(component.language, component.span("function", "sources"))
    else:
        found = _text_body(component, sources, diagnostics)
        if found is None:
            return None
        sections += found.var_blocks
        body = found.body
    return ast.Pou(
        "FUNCTION_BLOCK",
        component.name,
        component.text or component.function or None,
        None,
        tuple(s for s in sections if s.variables),
        body,
        name_span,
        name_span,
    )


def _section(kind: str, variables: tuple[ast.VarDecl, ...], component: Component, *qualifiers: str
             ) -> ast.VarBlock:
    return ast.VarBlock(kind, qualifiers, variables, component.span("component", "name"))


def _state(pins: tuple[Pin, ...], component: Component, diagnostics: Diagnostics) -> Iterator[ast.VarBlock]:
    """In their order, which is that of the members of the structure in C."""
    for retain, group in groupby(pins, lambda pin: pin.retain):
        yield _section("VAR", _declared(tuple(group), diagnostics), component, *["RETAIN"] * retain)


def _enable(component: Component) -> tuple[ast.VarDecl, ...]:
    at = component.span("requires", "power") if component.requires_power else None
    return () if at is None else (_variable(ENABLE, "BOOL", at),)


def _outputs(
    component: Component, outputs: tuple[Pin, ...], diagnostics: Diagnostics
) -> tuple[ast.VarDecl, ...]:
    """The output that power leaves by stands first: that is where the ladder goes on."""
    declared = _declared(outputs, diagnostics)
    at = component.span("provides", "power")
    power = component.power
    if power is None:
        first = ()
    elif power == POWER:
        first = (_variable(POWER, "BOOL", at),)
    else:
        first = tuple(v for v in declared if v.name.upper() == power.upper())
    return (*first, *(v for v in declared if v not in first), _variable(ERROR, "UINT", at))


def _variable(name: str, type_: str, at: Span) -> ast.VarDecl:
    return ast.VarDecl(name, None, ast.NamedType(type_, None, at), None, at, at)


def _declared(pins: tuple[Pin, ...], diagnostics: Diagnostics) -> tuple[ast.VarDecl, ...]:
    return tuple(
        ast.VarDecl(p.name, None, p.type, _initial(p, diagnostics), p.span, p.span, _note(p)) for p in pins
    )


def _initial(pin: Pin, diagnostics: Diagnostics) -> ast.Expr | None:
    """The initial value, with the place of the descriptor's own text: that is where it is wrong if it is."""
    if pin.value is None:
        return None
    at = pin.value_span
    quoted = at.text[:1] in ("'", '"')
    if at.text == pin.value or quoted and at.text[1:-1] == pin.value:
        return parse_expression(at.source, at.start + quoted, at.end - quoted, diagnostics)
    return parse_expression(SourceFile(at.source.path, pin.value), 0, len(pin.value), diagnostics)


def _note(pin: Pin) -> str | None:
    bounds = (
        ""
        if pin.low is None and pin.high is None
        else (f"{'' if pin.low is None else pin.low} .. {'' if pin.high is None else pin.high}")
    )
    return (
        ", ".join(part for part in (pin.text, " ".join(p for p in (bounds, pin.unit) if p)) if part) or None
    )


def _text_body(
    component: Component, sources: tuple[SourceFile, ...], diagnostics: Diagnostics
) -> ast.Pou | None:
    """The one FUNCTION_BLOCK of the component's name in its sources; it declares VARs only."""
    found = [
        p
        for source in sources
        for p in parse_file(source, diagnostics).pous
        if p.name.upper() == component.name.upper() and p.kind == "FUNCTION_BLOCK"
    ]
    if len(found) != 1:
        findings.no_body(diagnostics, component.span("function", "sources"), component.name, len(found))
        return None
    for block in found[0].var_blocks:
        if block.kind not in ("VAR", "VAR_TEMP"):
            findings.pins_in_body(diagnostics, block.span, block.kind, component.name)
            return None
    return found[0]
