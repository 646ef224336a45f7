"""XML of IEC 61131-10, the standard that TC6 became, as the elements of TC6 that say the same.

There, names begin with a capital, kinds stand in ``xsi:type``, types are text, operands are attributes, and
a wire names an output by its number, which counts in one network. Every element made stands where the one
stood that it is made of, so that findings point into the file.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ldc.diagnostics import Diagnostics
from ldc.parser.plcopen import findings, sequences
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.networks import Networks
from ldc.parser.plcopen.sequences import content, kind
from ldc.types import ELEMENTARY

POUS = {"Program": "program", "FunctionBlock": "functionBlock", "Function": "function"}
_SECTIONS = {
    "InputVars": "inputVars", "OutputVars": "outputVars", "InoutVars": "inOutVars", "InOutVars": "inOutVars",
    "ExternalVars": "externalVars", "Vars": "localVars", "TempVars": "tempVars", "GlobalVars": "globalVars",
}
_OF_POUS = frozenset((*_SECTIONS, "Parameters", "ResultType", "MainBody", "Action", "Transition",
                      "Documentation", "AddData", "UsingDirective"))
ATTRIBUTES = frozenset("""
    abstract accessSpecifier associatedTaskName compareOperator dimensionNumber evaluationOrder final
    identifier latch location non_retain operand operand1 operand2 orderWithinParamSet parameterName
    refConnectionPointOutId resourceTypeName schemaVersion size suppressName targetNetworkLabel""".split())
"""Those of its elements that TC6 does not have."""
_QUALIFIERS = {"constant": "constant", "retain": "retain", "non_retain": "nonretain"}


def is_project(root: Node) -> bool:
    """Whether a document is one: a project, or a POU that stands alone, as one editor writes it."""
    return root.tag in POUS or root.tag == "Project" and root.find("Types") is not None


def project(root: Node, diagnostics: Diagnostics) -> Node:
    """The ``project`` of TC6 that says the same; what it cannot say is told (LD0145)."""
    reader = _Edition(diagnostics)
    pous: list[Node] = []
    types: list[Node] = []
    work = [root] if root.tag in POUS else [*root.all("Types")]
    while work:
        node = work.pop()
        if node.tag in POUS:
            pous.append(reader.pou(node))
        elif node.tag == "DataTypeDecl":
            types.append(reader.data_type(node))
        elif node.tag in ("Class", "Interface"):
            reader.unread(node, f"<{node.tag}> `{node.get('name')[:40]}`", "make it a function block")
        elif node.tag in ("Types", "GlobalNamespace", "NamespaceDecl"):
            work += reversed(node.children)
    configurations = [reader.configuration(node) for outer in root.all("Instances")
                      for node in outer.all("Configuration")]
    return root.like("project", (
        root.like("types", (root.like("dataTypes", types), root.like("pous", pous))),
        root.like("instances", (root.like("configurations", configurations),))))


class _Edition:
    def __init__(self, diagnostics: Diagnostics) -> None:
        self.diagnostics = diagnostics

    def unread(self, node: Node, what: str, help: str) -> None:
        message = f"{what} is not read"
        findings.unsupported(self.diagnostics, node.span, message, "in XML of IEC 61131-10", help)

    # ---- program organisation units

    def pou(self, node: Node) -> Node:
        for child in node.children:
            if child.tag not in _OF_POUS:
                self.unread(child, f"<{child.tag[:40]}> of `{node.get('name')[:40]}`",
                            "leave it out, or write it in the body")
        declared = [self.section(child) for holder in (*node.all("Parameters"), node)
                    for child in holder.all(*_SECTIONS)]
        result = [node.like("returnType", self.type(child)) for child in node.all("ResultType")]
        parts = [node.like("interface", (*result, *declared)), *self._documentation(node)]
        for main in node.all("MainBody"):
            parts.append(self.body(main))
        actions = [self._action(child) for child in node.all("Action")]
        conditions = [self._transition(child) for child in node.all("Transition")]
        for tag, found in (("actions", actions), ("transitions", conditions)):
            if found:
                parts.append(node.like(tag, found))
        return node.like("pou", parts, {"name": node.get("name"), "pouType": POUS[node.tag]})

    def _action(self, node: Node) -> Node:
        return node.like("action", [self.body(child) for child in node.all("Body", "MainBody")])

    def _transition(self, node: Node) -> Node:
        texts = [text for child in node.all("Condition") for text in sequences.predicate(child, self.unread)]
        return node.like("transition", [node.like("body", texts)])

    def body(self, node: Node) -> Node:
        """Sections of a body follow each other."""
        drawn = Networks(self.unread, self.body)
        contents = list(node.all("BodyContent"))
        for one in contents:
            language = kind(one)
            text = one.find("ST") or one.find("IL")
            if text is not None and len(contents) == 1:
                return node.like("body", (text,))
            if language == "SFC" and len(contents) == 1:
                drawn.chart(one)
                return node.like("body", (one.like("SFC", drawn.elements),))
            if language in ("LD", "LdSection", "FBD", "FbdSection"):
                drawn.add(one)
            else:
                self.unread(one, f"a body in {language[:40] or 'no language'}" if len(contents) == 1
                            else f"a section in {language[:40]} beside others",
                            "write it in Structured Text, as a ladder or as a function block diagram")
        return node.like("body", (node.like("LD", drawn.elements),))

    # ---- declarations

    def section(self, node: Node) -> Node:
        flags = {ours: node.get(theirs) for theirs, ours in _QUALIFIERS.items() if node.get(theirs)}
        return node.like(_SECTIONS[node.tag], [self.variable(child) for child in node.all("Variable")], flags)

    def variable(self, node: Node) -> Node:
        parts = [node.like("type", self.type(child)) for child in node.all("Type")]
        parts += [child.like("initialValue", self._values(child)) for child in node.all("InitialValue")]
        parts += self._documentation(node)
        place = node.find("Address")
        attributes = {"name": node.get("name")}
        if place is not None and place.get("address").strip():
            written = place.get("address").strip()
            area = f"{place.get('location').strip()}{place.get('size').strip()}"
            attributes["address"] = written if written.startswith("%") else f"%{area}{written}"
        return node.like("variable", parts, attributes)

    def _documentation(self, node: Node) -> Iterator[Node]:
        return (child.like("documentation", child.children) for child in node.all("Documentation"))

    def data_type(self, node: Node) -> Node:
        parts = [node.like("baseType", self._spec(child)) for child in node.all("UserDefinedTypeSpec")]
        return node.like("dataType", (*parts, *self._documentation(node)))

    def type(self, node: Node) -> list[Node]:
        """What is in a ``type``: one element."""
        for child in node.children:
            if child.tag == "TypeName":
                name = child.content
                word = name.text.upper()
                return [content(child, word if word in ELEMENTARY else "derived", {"name": name.text})]
            if child.tag == "InstantlyDefinedType":
                return self._spec(child)
        return []

    def _spec(self, node: Node) -> list[Node]:
        reads: dict[str, Callable[[Node], Node]] = {
            "ArrayTypeSpec": self._array, "StructTypeSpec": self._structure,
            "EnumTypeSpec": self._enumeration, "EnumTypeWithNamedValueSpec": self._enumeration,
        }
        read = reads.get(kind(node))
        if read is not None:
            return [read(node)]
        self.unread(node, f"a type of the kind {kind(node)[:40] or '?'}",
                    "declare it as an array, structure or enumeration")
        return []

    def _array(self, node: Node) -> Node:
        bounds = [limits.like("dimension", ())
                  for one in node.all("DimensionSpec") for limits in one.all("IndexRange")]
        of = [base.like("baseType", self.type(base)) for base in node.all("BaseType")]
        return node.like("array", (*bounds, *of))

    def _structure(self, node: Node) -> Node:
        return node.like("struct", [self.variable(member) for member in node.all("Member")])

    def _enumeration(self, node: Node) -> Node:
        values = [one.like("value", ()) for one in node.all("Enumerator")]
        base = [one.like("baseType", self.type(one)) for one in node.all("BaseType") if one.children]
        return node.like("enum", (node.like("values", values), *base))

    def _values(self, node: Node) -> list[Node]:
        """Values of variables, which are built as in TC6."""
        found = []
        for child in node.all("SimpleValue", "ArrayValue", "StructValue"):
            inner = [one.like("value", self._values(one)) for one in child.all("Value")]
            found.append(child.like(child.tag[0].lower() + child.tag[1:], inner))
        return found

    # ---- configurations

    def configuration(self, node: Node) -> Node:
        parts = [self.section(child) for child in node.all("GlobalVars")]
        return node.like("configuration", (*parts, *map(self._resource, node.all("Resource"))))

    def _resource(self, node: Node) -> Node:
        tasks = []
        programs = list(node.all("ProgramInstance"))
        for task in node.all("Task"):
            name = task.get("name")
            own = [p.like("pouInstance", ()) for p in programs if p.get("associatedTaskName") == name]
            programs = [p for p in programs if p.get("associatedTaskName") != name]
            attributes = {"name": name, "priority": task.get("priority")}
            if interval := task.get("interval").strip():
                micros = task.number("interval")
                seconds = f"PT{micros // 1_000_000}.{micros % 1_000_000:06}S"
                attributes["interval"] = seconds if micros else interval
            tasks.append(task.like("task", own, attributes))
        shared = [self.section(child) for child in node.all("GlobalVars")]
        loose = [p.like("pouInstance", ()) for p in programs]
        return node.like("resource", (*shared, *tasks, *loose))
