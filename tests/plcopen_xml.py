"""PLCopen XML of small drawings, written by functions: `contact(2, "a", 1)` is element 2, fed by element 1.

A source is the id of an element, `"4.Q"` for the output Q of block 4, or a tuple of these (OR).
"""

from __future__ import annotations

from xml.sax.saxutils import escape, quoteattr

NAMESPACE = "http://www.plcopen.org/xml/tc6_0201"


def wires(sources) -> str:
    sources = sources if isinstance(sources, tuple) else (sources,)
    lines = ""
    for source in sources:
        if source is None:
            continue
        id_, _, pin = str(source).partition(".")
        formal = f' formalParameter="{pin}"' if pin else ""
        lines += f'<connection refLocalId="{id_}"{formal}/>'
    return f"<connectionPointIn>{lines}</connectionPointIn>"


def element(tag: str, id_: int, inner: str = "", at=None, **attributes) -> str:
    x, y = at or (10 * id_, 10)
    written = "".join(f" {name}={quoteattr(str(value))}" for name, value in attributes.items())
    return f'<{tag} localId="{id_}"{written}>\n<position x="{x}" y="{y}"/>{inner}</{tag}>\n'


def rail(id_: int = 1) -> str:
    return element("leftPowerRail", id_, '<connectionPointOut formalParameter=""/>')


def right(id_: int, sources) -> str:
    return element("rightPowerRail", id_, wires(sources))


def contact(id_: int, name: str, sources=1, at=None, **attributes) -> str:
    inner = f"{wires(sources)}<connectionPointOut/><variable>{escape(name)}</variable>"
    return element("contact", id_, inner, at, **attributes)


def coil(id_: int, name: str, sources, at=None, **attributes) -> str:
    inner = f"{wires(sources)}<connectionPointOut/><variable>{escape(name)}</variable>"
    return element("coil", id_, inner, at, **attributes)


def value(id_: int, text: str, at=None, **attributes) -> str:
    return element("inVariable", id_, f"<connectionPointOut/><expression>{escape(text)}</expression>", at,
                   **attributes)


def result(id_: int, text: str, sources, at=None, **attributes) -> str:
    return element("outVariable", id_, f"{wires(sources)}<expression>{escape(text)}</expression>", at,
                   **attributes)


def block(id_: int, type_: str, inputs: dict, outputs=(), instance: str = "", at=None, in_outs=None,
          modified=None, **attributes) -> str:
    """`modified`: attributes of pins, as `{"CU": 'edge="rising"'}`."""
    modified = modified or {}

    def pin(name: str, inner: str) -> str:
        more = f" {modified[name]}" if name in modified else ""
        return f'<variable formalParameter="{name}"{more}>{inner}</variable>'

    ins = "".join(pin(name, wires(sources)) for name, sources in inputs.items())
    both = "".join(pin(name, wires(sources)) for name, sources in (in_outs or {}).items())
    outs = "".join(pin(name, "<connectionPointOut/>") for name in outputs)
    inner = (f"<inputVariables>{ins}</inputVariables><inOutVariables>{both}</inOutVariables>"
             f"<outputVariables>{outs}</outputVariables>")
    named = {"instanceName": instance} if instance else {}
    return element("block", id_, inner, at, typeName=type_, **named, **attributes)


def variables(text: str) -> str:
    """`a b : BOOL; t : TON` as <variable> elements; upper case types are elementary unless they are blocks."""
    lines = ""
    for group in filter(str.strip, text.split(";")):
        names, type_ = group.split(":")
        type_, _, initial = (part.strip() for part in type_.partition("="))
        elementary = type_ in ("BOOL", "INT", "DINT", "REAL", "TIME", "WORD", "BYTE")
        written = f"<{type_}/>" if elementary else f'<derived name="{type_}"/>'
        start = f"<initialValue><simpleValue value={quoteattr(initial)}/></initialValue>" if initial else ""
        for name in names.split():
            lines += f'<variable name="{name}"><type>{written}</type>{start}</variable>\n'
    return lines


def pou(body: str, declared: str, name: str = "main", kind: str = "program", sections: str = "") -> str:
    return (f'<pou name="{name}" pouType="{kind}"><interface>{sections}<localVars>{variables(declared)}'
            f"</localVars></interface><body>{body}</body></pou>")


def project(*pous: str, types: str = "", instances: str = "", namespace: str = NAMESPACE) -> str:
    return (f'<?xml version="1.0" encoding="utf-8"?>\n<project xmlns="{namespace}"><types><dataTypes>{types}'
            f"</dataTypes><pous>{''.join(pous)}</pous></types><instances>{instances}</instances></project>\n")


def ladder(declared: str, *elements: str) -> str:
    """A project with one program of one LD body."""
    return project(pou(f"<LD>\n{''.join(elements)}</LD>", declared))


def fbd(declared: str, *elements: str) -> str:
    return project(pou(f"<FBD>\n{''.join(elements)}</FBD>", declared))
