"""Helpers of the tests of the model: from text to typed elements, and typed expressions as text."""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.diagnostics import Diagnostics
from ldc.expr import Apply, Const, Expr, Load
from ldc.model import Scope, resolve
from ldc.model.elements import Block, Coil, Contact, Element
from ldc.model.project import Model
from ldc.model.walk import elements_in
from ldc.parser import ast, parse_file
from ldc.source import SourceFile


@dataclass
class Modelled:
    """What a text became. ``elements``: typed elements of each POU in the order of the text."""

    model: Model
    diagnostics: Diagnostics
    elements: dict[str, list[Element | None]] = field(default_factory=dict)

    @property
    def codes(self) -> list[str]:
        return [d.code for d in self.diagnostics]

    @property
    def text(self) -> str:
        """All findings, one a line: code, what is marked, message, help."""
        return "\n".join(f"{d.code} [{d.primary.span.text if d.primary else ''}] {d.message} | {d.help}"
                         for d in self.diagnostics)


class Nets:
    """Numbers the networks and junctions at pins; ``types`` are those of junctions by name."""

    def __init__(self, types: dict | None = None) -> None:
        self.types = types or {}
        self.numbers: dict[object, int] = {}

    def __call__(self, node: ast.Branches | ast.Junction) -> int:
        key = node.name.upper() if isinstance(node, ast.Junction) else id(node)
        return self.numbers.setdefault(key, len(self.numbers) + 1)

    def type_of(self, node: ast.Branches | ast.Junction):
        return self.types.get(node.name) if isinstance(node, ast.Junction) else None


def modelled(*texts: str, settings=None, nets: Nets | None = None, name: str = "x.ld") -> Modelled:
    """Parses and resolves the texts as one project and types all its rungs."""
    diagnostics = Diagnostics()
    files = tuple(parse_file(SourceFile(f"{i}{name}" if i else name, t), diagnostics)
                  for i, t in enumerate(texts))
    model = resolve(ast.Project(files), diagnostics, settings)
    found = Modelled(model, diagnostics)
    for key, pou in model.pous.items():
        scope = Scope(model, pou.name)
        if isinstance(pou.body, ast.LadderBody):
            items = [item for rung in pou.body.rungs
                     for item in sorted(elements_in(rung), key=lambda e: e.span.start)]
            found.elements[key] = [scope.element(i, nets or Nets(), diagnostics) for i in items]
    return found


def program(declarations: str, rungs: str = "", before: str = "") -> str:
    """A project with one PROGRAM called main."""
    return f"{before}\nPROGRAM main\nVAR\n{declarations}\nEND_VAR\n{rungs}\nEND_PROGRAM\n"


def first(declarations: str, rung: str, before: str = "", nets: Nets | None = None) -> Element | None:
    """The first element of a rung, which must be without findings (those of level error)."""
    found = modelled(program(declarations, f"RUNG {rung}", before), nets=nets)
    assert not found.diagnostics.has_errors, found.text
    return found.elements["MAIN"][0]


def findings(declarations: str, rung: str, before: str = "", nets: Nets | None = None) -> str:
    """All that is said about a rung."""
    return modelled(program(declarations, f"RUNG {rung}", before), nets=nets).text


def shown(expr: Expr) -> str:
    """A typed expression as text: ``GT(INT_TO_DINT(a), 5:DINT)``."""
    match expr:
        case Const(value, type_):
            return f"{value!r}:{type_}"
        case Load(place):
            return str(place)
        case Apply():
            return f"{expr.op}({', '.join(map(shown, expr.args))})"


def shown_element(element: Element) -> str:
    """An element as text, with its pins."""
    match element:
        case Contact(kind, expr):
            return f"{kind} {shown(expr)}"
        case Coil(kind, place):
            return f"{kind} {place}"
        case Block():
            sources = [f"{p.pin}:={p.source if isinstance(p.source, int) else shown(p.source)}"
                       for p in element.inputs]
            targets = [f"{p.pin}=>{p.target}" for p in element.outputs]
            return f"{element.callee}({', '.join(sources + targets)}) {element.power_in}>{element.power_out}"
    return f"jump {element.label}"
