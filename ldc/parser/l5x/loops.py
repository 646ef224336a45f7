"""FAL and FSC: an expression for each element of arrays; FOR: a routine for each number.

Each is a POU of its own, since it names tags of the program: a FUNCTION_BLOCK without memory, in an Add-On
Instruction a FUNCTION.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser import statements as st
from ldc.parser.foreign import supporting
from ldc.parser.l5x import types
from ldc.parser.l5x.files import control_of
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.support import templates
from ldc.parser.l5x.types import BOOL, is_integer, is_real
from ldc.parser.l5x.values import Value, boolean, convert, literal
from ldc.records import is_record, replace
from ldc.source import Span

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

_MODES = {"ALL": 0, "INC": -1}


def _loop(w: Writer, i: Instruction) -> list[ast.Item]:
    control, mode = control_of(w, i, 0), _mode(w, i.operands[3])
    if control is None or mode is None:
        return []
    inner = w.inside()
    inner_control = inner.place(i.operands[0])
    body = _assigned(inner, i) if i.name == "FAL" else _found(inner, i, inner_control)
    if body is None or inner_control is None:
        return []
    made = _pou(inner, f"logix_{i.name.lower()}", inner_control, body, i.span)
    w.context.made.append(made)
    pins: list[tuple[str, ast.Expr]] = [("mode", ast.Literal(mode, None, str(mode), i.operands[3]))]
    if made.kind == "FUNCTION":
        pins += [(v.name, ast.Name(v.name, i.span)) for v in _in_outs(w, i.span)]
        return [w.block(made.name, i.span, pins, "power", "OUT")]
    name = w.local(i.name.lower(), ast.NamedType(made.name, None, i.span), i.span)
    return [w.block(made.name, i.span, pins, instance=ast.Name(name, i.span))]


def _mode(w: Writer, text: Span) -> int | None:
    word = text.text.upper()
    if word in _MODES:
        return _MODES[word]
    value = w.read(text) if word != "?" else None
    if value is not None and isinstance(value.number, int) and value.number > 0:
        return value.number
    w.reading.malformed(text, f"`{text.text[:20]}` is no mode", help="write ALL, INC or a number above 0")
    return None


def _assigned(inner: Writer, i: Instruction) -> tuple[st.Statement, ...] | None:
    target = inner.place(i.operands[4])
    value = inner.read(i.operands[5], real=target is not None and is_real(target.type))
    if target is None or value is None:
        return None
    if target.whole is not None:
        inner.reading.unsupported(i.operands[4], "FAL into bits", "give it an array of numbers")
        return None
    return (st.Assign(target.expr, convert(value, target.type), i.span),)


def _found(inner: Writer, i: Instruction, control: Value | None) -> tuple[st.Statement, ...] | None:
    condition = inner.read(i.operands[4])
    if condition is None or control is None:
        return None
    true = boolean(True, i.span)
    hits = tuple(st.Assign(ast.Member(control.expr, name, i.span), true, i.span) for name in ("FD", "IN"))
    return (st.If((st.Arm(condition.expr, hits, i.span),), None, i.span),)


def _for(w: Writer, i: Instruction) -> list[ast.Item]:
    """FOR(routine, index, first, last, step) under power: the routine for each number, until a BRK in it."""
    routine = w.routines.routines.get(i.operands[0].text.upper()) if w.routines is not None else None
    if routine is None:
        w.reading.malformed(i.operands[0], f"there is no routine `{i.operands[0].text[:40]}` in this program",
                            help="FOR calls a routine of its own program")
        return []
    inner = w.inside()
    index, first, last, step = (
        inner.place(text) if at == 0 else inner.read(text) for at, text in enumerate(i.operands[1:]))
    if None in (index, first, last, step):
        return []
    if not is_integer(index.type) or index.whole is not None:
        w.reading.malformed(i.operands[1], f"`{i.operands[1].text[:40]}` cannot count",
                            help="give FOR a SINT, INT or DINT tag")
        return []
    span, kind = i.span, index.type
    here, limit, by = index.expr, convert(last, kind), convert(step, kind)
    call = w.routines.invoke(inner, routine, span)
    enable, enabled = ast.Name("EN", span), ast.Name("ENO", span)
    broken = w.routines.broken(inner, span)
    none, false = literal(0, span).expr, boolean(False, span)

    def both(a: ast.Expr, op: str, sign: str) -> ast.Expr:
        return ast.Binary("AND", ast.Binary(op, a, none, span), ast.Binary(sign, here, limit, span), span)

    body = (
        st.Invoke(call.instance, (ast.Argument("EN", boolean(True, span), False, span),), span),
        st.If((st.Arm(broken, (st.Leave("EXIT", span),), span),), None, span),
        st.Assign(here, ast.Binary("+", here, by, span), span))
    going = ast.Binary("OR", both(by, ">=", "<="), both(by, "<", ">="), span)
    loop = (st.Assign(broken, false, span), st.Assign(here, convert(first, kind), span),
            st.While(going, body, span, span), st.Assign(broken, false, span))
    pins = (ast.VarBlock("VAR_INPUT", (), (_flag("EN", span),), span),
            ast.VarBlock("VAR_OUTPUT", (), (_flag("ENO", span),), span))
    name = w.context.names.fresh(f"logix_for_{routine.name}")
    statements = (st.Assign(enabled, enable, span), st.If((st.Arm(enable, loop, span),), None, span))
    w.context.made.append(ast.Pou("FUNCTION_BLOCK", name, None, None, (*pins, *inner.sections(span)),
                                  st.StatementBody(statements, span), span, span))
    instance = w.local(f"for_{routine.name}", ast.NamedType(name, None, span), span)
    return [w.block(name, span, [], instance=ast.Name(instance, span))]


def _flag(name: str, span: Span) -> ast.VarDecl:
    return ast.VarDecl(name, None, types.written(BOOL, span), None, span, span)


def _in_outs(w: Writer, span: Span) -> tuple[ast.VarDecl, ...]:
    """What the logic of an Add-On Instruction works on, to be handed on."""
    found = [ast.VarDecl("self", None, types.written(w.owner, span), None, span, span)] if w.owner else []
    found += [ast.VarDecl(t.name, None, types.written(t.type, span), None, span, span)
              for t in w.scope.tags.values() if t.local and t.type is not None]
    return tuple(found)


def _pou(inner: Writer, template: str, control: Value, body: tuple[st.Statement, ...], span: Span) -> ast.Pou:
    (pou,) = supporting(templates()[template], f"{template}.st")
    name = inner.context.names.fresh(template)
    result = ast.Name(name if inner.owner else "passed", span)
    statements = _put(pou.body.statements, {"control": control.expr, template: result}, body)
    sections = pou.var_blocks + inner.sections(span)
    kind, declared = "FUNCTION", ast.VarBlock("VAR_IN_OUT", (), _in_outs(inner, span), span)
    if inner.owner is None:
        passed = ast.VarDecl("passed", None, types.written(BOOL, span), None, span, span)
        kind, declared = "FUNCTION_BLOCK", ast.VarBlock("VAR_OUTPUT", (), (passed,), span)
    return replace(pou, kind=kind, name=name, result=pou.result if kind == "FUNCTION" else None,
                   var_blocks=(pou.var_blocks[0], declared, *sections[1:]),
                   body=st.StatementBody(statements, pou.body.span))


def _put(node: object, names: dict[str, ast.Expr], body: tuple[st.Statement, ...]) -> object:
    """The tree with other expressions for some names, and ``body`` for the statement ``body()``."""
    if isinstance(node, tuple):
        found: list[object] = []
        for part in node:
            called = part.callee if isinstance(part, st.Invoke) else None
            if isinstance(called, ast.Name) and called.name == "body":
                found += body
            else:
                found.append(_put(part, names, body))
        return tuple(found)
    if isinstance(node, ast.Name):
        return names.get(node.name, node)
    if is_record(node) and not isinstance(node, Span):
        return replace(node, **{f: _put(getattr(node, f), names, body) for f in node.__match_args__})
    return node


TABLE = {"FAL": (6, 6, _loop), "FSC": (5, 5, _loop), "FOR": (5, 5, _for)}
