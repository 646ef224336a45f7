"""A whole project as one TC6 XML 2.01 file, the same text for the same project (so it bears no date)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from xml.etree.ElementTree import Element, indent, tostring

from ldc import __version__
from ldc.diagnostics import Diagnostics
from ldc.draw import pins_from
from ldc.export.plcopen import chart
from ldc.export.plcopen.declarations import Notes, section, type_, type_decl
from ldc.export.plcopen.instances import configuration
from ldc.export.plcopen.ladder import Body
from ldc.export.plcopen.tags import NAMESPACE, XHTML, add, code, formatted, own_data, prose, without_margin
from ldc.export.plcopen.turns import drop_shown
from ldc.graph.rung import RungGraph
from ldc.model.project import Model
from ldc.parser import ast
from ldc.parser.plcopen.document import Document
from ldc.parser.plcopen.kept import fingerprint
from ldc.parser.sfc import Action, SfcBody, Transition
from ldc.parser.sfc import Body as ChartPart
from ldc.parser.statements import StatementBody
from ldc.parser.unparse import rung_text
from ldc.source import SourceFile

_KINDS = {"PROGRAM": "program", "FUNCTION_BLOCK": "functionBlock", "FUNCTION": "function"}
_NO_DATE = "1970-01-01T00:00:00"
_Graphs = Mapping[int, RungGraph]
"""The graph of each rung, by ``id`` of the rung."""
Graphs = Mapping[str, Sequence[tuple[ast.Rung, RungGraph]]]
"""The rungs of each POU in order, by its name."""


def export(files: Sequence[ast.File], model: Model, graphs: Graphs, name: str, period: int) -> str:
    """The XML of a project that was compiled without errors. ``period``: nanoseconds between two scans."""
    root = Element("project", {"xmlns": NAMESPACE, "xmlns:xhtml": XHTML})
    add(root, "fileHeader", companyName="", productName="ldc", productVersion=__version__,
        creationDateTime=_NO_DATE)
    header = add(root, "contentHeader", name=name or "project", modificationDateTime=_NO_DATE)
    coordinates = add(header, "coordinateInfo")
    for language in ("fbd", "ld", "sfc"):
        add(add(coordinates, language), "scaling", x="8", y="8")
    types = add(root, "types")
    data_types, pous = add(types, "dataTypes"), add(types, "pous")
    drawn: list[Body] = []
    own = {id(rung): graph for built in graphs.values() for rung, graph in built}
    notes = {key: note for file in files for key, note in _notes(file).items()}
    for file in files:
        for declared in file.types:
            type_decl(data_types, declared, notes)
        for pou in file.pous:
            drawn += _pou(pous, pou, own, notes, pins_from(model.signatures))
    instances = add(add(root, "instances"), "configurations")
    configuration(instances, files, model, period, notes)
    if model.safe:
        safe = own_data(root, "safe")
        for path, value in model.safe.items():
            add(safe, "value", of=path, kind=type(value).__name__, is_=str(value))
    _keep_rungs(root, drawn)
    return _text(root)


def _text(root: Element) -> str:
    return f'<?xml version="1.0" encoding="utf-8"?>\n{tostring(root, encoding="unicode")}\n'


def _pou(parent: Element, pou: ast.Pou, graphs: _Graphs, notes: Notes, pins_of: Callable) -> list[Body]:
    """A POU with its body; the ladders in it, in the order in which they stand there."""
    made = add(parent, "pou", name=pou.name, pouType=_KINDS[pou.kind])
    interface, ladders = add(made, "interface"), []
    if pou.result is not None:
        type_(add(interface, "returnType"), pou.result, notes)
    for block in pou.var_blocks:
        section(interface, block, notes)
    if isinstance(pou.body, SfcBody):
        for one in _named(made, "action", pou.body.actions):
            ladders += _body(one[0], one[1].body, graphs, pins_of)
        conditions = [way for way in pou.body.transitions if isinstance(way.condition, ChartPart)]
        for one in _named(made, "transition", conditions):
            ladders += _body(one[0], one[1].condition, graphs, pins_of)
        chart.draw(made, pou.body)
    else:
        for one in _named(made, "action", pou.actions):
            ladders += _body(one[0], one[1].body, graphs, pins_of)
        ladders += _body(made, pou.body, graphs, pins_of)
    if pou.title:
        formatted(made, "documentation", prose(pou.title))
    return ladders


def _named(parent: Element, tag: str, parts: Sequence[Action] | Sequence[Transition]
           ) -> Iterator[tuple[Element, Action | Transition]]:
    """An element for each action or transition of a chart with a body."""
    holder = add(parent, f"{tag}s") if parts else parent
    for part in parts:
        yield add(holder, tag, name=part.name), part


def _body(parent: Element, body: ChartPart, graphs: _Graphs, pins_of: Callable) -> list[Body]:
    if isinstance(body, ast.LadderBody):
        ladder = Body(parent, pins_of)
        for rung in body.rungs:
            ladder.rung(rung, graphs[id(rung)])
        drop_shown(ladder.ladder)
        return [ladder]
    language = "ST" if isinstance(body, StatementBody) else "IL"
    formatted(add(parent, "body"), language, code(without_margin(body.span.text)))
    return []


def _notes(file: ast.File) -> dict[tuple[str, int], str]:
    """Comments behind declarations, in their line; of a structure, behind its head."""
    position = file.source.position
    by_line: dict[int, str] = {}
    for comment in file.comments:
        if comment.text.startswith("{"):
            continue  # a pragma
        text = comment.text[2:-2] if comment.text.startswith(("(*", "/*")) else comment.text[2:]
        by_line.setdefault(position(comment.span.start)[0], " ".join(text.split()))
    blocks = [*file.globals, *(block for pou in file.pous for block in pou.var_blocks)]
    for part in file.configurations:
        blocks += (*part.var_blocks, *(block for resource in part.resources for block in resource.var_blocks))
    variables = [variable for block in blocks for variable in block.variables]
    ends: list[tuple[ast.VarDecl | ast.TypeDecl, int]] = []
    for declared in file.types:
        structure = isinstance(declared.type, ast.StructType)
        ends.append((declared, declared.type.span.start + 1 if structure else declared.span.end))
        variables += declared.type.fields if structure else ()
    ends += [(variable, variable.group_span.end) for variable in variables]
    lines = ((declared, position(max(end - 1, 0))[0]) for declared, end in ends)
    return {(file.source.path, declared.span.start): by_line[line]
            for declared, line in lines if line in by_line}


def _keep_rungs(root: Element, drawn: Sequence[Body]) -> None:
    """Put the text of each rung beside the drawing, with a digest of the elements as they will be read."""
    indent(root)
    read = Document(SourceFile("export.xml", _text(root)), Diagnostics()).root
    bodies = [node for node in read.descendants("body") if node.find("LD") is not None]
    for ladder, node in zip(drawn, bodies, strict=True):
        elements = {child.get("localId"): child for child in node.find("LD").children}
        kept = own_data(ladder.body, "rungs")
        for one in ladder.drawn:
            ids = [str(id_) for id_ in one.ids]
            add(kept, "rung", code(f"{rung_text(one.rung)}\n"), elements=" ".join(ids),
                digest=fingerprint([elements[id_] for id_ in ids]))
    indent(root)
