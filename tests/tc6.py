"""What TC6 XML 2.01 demands of the elements that an export may hold: children in order, attributes that must
be there (facts of the published schema, in a table of our own), ids, wires and places."""

from __future__ import annotations

import re
from xml.etree import ElementTree

NAMESPACE, XHTML = "{http://www.plcopen.org/xml/tc6_0201}", "{http://www.w3.org/1999/xhtml}"
_PINS = "position! inputVariables! inOutVariables! outputVariables! addData documentation"
_IN, _OUT = "position! connectionPointIn", "position! connectionPointOut"
_MORE = "addData documentation"
_VARIABLES = "localVars tempVars inputVars outputVars inOutVars externalVars globalVars".split()

# tag: children in order (`!` must, `*` any number), attributes that must be there
RULES: dict[str, tuple[str, str]] = {
    "project": ("fileHeader! contentHeader! types! instances! addData documentation", ""),
    "fileHeader": ("", "companyName productName productVersion creationDateTime"),
    "contentHeader": ("Comment coordinateInfo! addDataInfo addData", "name"),
    "coordinateInfo": ("pageSize fbd! ld! sfc!", ""), "fbd": ("scaling!", ""), "ld": ("scaling!", ""),
    "sfc": ("scaling!", ""), "scaling": ("", "x y"),
    "types": ("dataTypes! pous!", ""), "dataTypes": ("dataType*", ""), "pous": ("pou*", ""),
    "dataType": (f"baseType! initialValue {_MORE}", "name"),
    "pou": (f"interface actions transitions body* {_MORE}", "name pouType"),
    "body": (f"IL ST FBD LD SFC {_MORE}", ""),
    "variable": (f"type! initialValue {_MORE}", "name"),
    "position": ("", "x y"), "relPosition": ("", "x y"),
    "contact": (f"{_IN} connectionPointOut variable! {_MORE}", "localId"),
    "coil": (f"{_IN} connectionPointOut variable! {_MORE}", "localId"),
    "block": (_PINS, "localId typeName"),
    "inVariable": (f"{_OUT} expression! {_MORE}", "localId"),
    "outVariable": (f"{_IN} expression! {_MORE}", "localId"),
    "leftPowerRail": (f"position! connectionPointOut* {_MORE}", "localId"),
    "rightPowerRail": (f"position! connectionPointIn* {_MORE}", "localId"),
    "jump": (f"{_IN} {_MORE}", "localId label"), "return": (f"{_IN} {_MORE}", "localId"),
    "label": (f"position! {_MORE}", "localId label"),
    "step": (f"{_IN} connectionPointOut connectionPointOutAction {_MORE}", "localId name"),
    "transition": (f"{_IN} connectionPointOut condition {_MORE}", "localId"),
    "condition": ("reference connectionPointIn inline", ""), "reference": ("", "name"),
    "inline": (f"IL ST FBD LD SFC {_MORE}", "name"),
    "jumpStep": (f"{_IN} {_MORE}", "localId targetName"),
    "selectionDivergence": (f"{_IN} connectionPointOut* {_MORE}", "localId"),
    "simultaneousDivergence": (f"{_IN} connectionPointOut* {_MORE}", "localId"),
    "selectionConvergence": (f"position! connectionPointIn* connectionPointOut {_MORE}", "localId"),
    "simultaneousConvergence": (f"position! connectionPointIn* connectionPointOut {_MORE}", "localId"),
    "actionBlock": (f"{_IN} action* {_MORE}", "localId"),
    "connectionPointOutAction": ("relPosition expression addData", "formalParameter"),
    "actions": ("action*", ""), "transitions": ("transition*", ""),
    "comment": (f"position! content! {_MORE}", "localId width height"),
    "connectionPointIn": ("relPosition connection* expression addData", ""),
    "connectionPointOut": ("relPosition expression addData", ""),
    "connection": ("position* addData", "refLocalId"),
    "instances": ("configurations!", ""), "configurations": ("configuration*", ""),
    "configuration": (f"resource* globalVars* accessVars configVars {_MORE}", "name"),
    "resource": (f"task* globalVars* pouInstance* {_MORE}", "name"),
    "task": (f"pouInstance* {_MORE}", "name priority"), "pouInstance": (_MORE, "name typeName"),
    "array": ("dimension* baseType!", ""), "dimension": ("", "lower upper"), "range": ("", "lower upper"),
    "subrangeSigned": ("range! baseType!", ""), "subrangeUnsigned": ("range! baseType!", ""),
    "enum": ("values! baseType", ""), "struct": ("variable*", ""), "derived": ("addData", "name"),
    "addData": ("data*", ""),
} | {tag: (f"variable* {_MORE}", "") for tag in _VARIABLES}


OF_POU = {"action": "named", "transition": "named"}
"""Actions and transitions of a POU are called like those of a chart and hold something else."""
RULES["named"] = (f"body! {_MORE}", "name")
RULES["action"] = (f"relPosition! reference inline connectionPointOut {_MORE}", "localId")


def broken_rules(xml: str) -> list[str]:
    """Where a file breaks the rules; empty when it does not."""
    found: list[str] = []
    root = ElementTree.fromstring(xml)
    pins = {id(pin) for block in root.iter(f"{NAMESPACE}block") for group in block for pin in group}
    texts = {id(node.find(f"{NAMESPACE}variable"))
             for tag in ("contact", "coil") for node in root.iter(NAMESPACE + tag)}
    named = {id(node) for tag in ("actions", "transitions") for holder in root.iter(NAMESPACE + tag)
             for node in holder}
    work = [root]
    while work:
        node = work.pop()
        tag = node.tag.removeprefix(NAMESPACE)
        if tag == "data":
            if node.get("handleUnknown") not in ("preserve", "discard", "implementation") or len(node) != 1:
                found.append("data of ours is not as it must be")
            continue
        if id(node) in pins:
            if "formalParameter" not in node.attrib:
                found.append("a pin without a name")
        elif id(node) not in texts and tag in RULES:
            found += _node(node, OF_POU.get(tag, tag) if id(node) in named else tag)
        elif tag in ("ST", "IL", "documentation", "content"):
            if [child.tag for child in node] != [f"{XHTML}p"]:
                found.append(f"<{tag}> holds no paragraph")
            continue
        work += node
    for body in (*root.iter(f"{NAMESPACE}LD"), *root.iter(f"{NAMESPACE}SFC")):
        found += _wires(body) + _places(body)
    return found


def _node(node: ElementTree.Element, tag: str) -> list[str]:
    children, attributes = RULES[tag]
    pattern = "".join({"!": f"(?:{word[:-1]};)", "*": f"(?:{word[:-1]};)*"}.get(word[-1], f"(?:{word};)?")
                      for word in children.split())
    said = "".join(f"{child.tag.removeprefix(NAMESPACE)};" for child in node)
    found = [] if re.fullmatch(pattern, said) else [f"<{tag}> holds {said}"]
    return found + [f"<{tag}> has no {name}" for name in attributes.split() if name not in node.attrib]


def _wires(body: ElementTree.Element) -> list[str]:
    ids = [node.get("localId") for node in body]
    found = [f"id {id_} is not unique" for id_ in ids if ids.count(id_) > 1 or not id_.isdigit()]
    ends = {(node.get("localId"), point) for node in body for point in _outputs(node)}
    for node in body:
        x, y = _at(node)
        for point in node.iter(f"{NAMESPACE}connectionPointIn"):
            rel = point.find(f"{NAMESPACE}relPosition")
            for wire in point.findall(f"{NAMESPACE}connection"):
                path = [(float(p.get("x")), float(p.get("y"))) for p in wire]
                if path[0] != (x + float(rel.get("x")), y + float(rel.get("y"))):
                    found.append(f"a wire of {node.get('localId')} does not begin at its input")
                if (wire.get("refLocalId"), path[-1]) not in ends:
                    found.append(f"a wire of {node.get('localId')} does not end at {wire.get('refLocalId')}")
                if any(a[0] != b[0] and a[1] != b[1] for a, b in zip(path, path[1:])):
                    found.append(f"a wire of {node.get('localId')} is oblique")
    return found


def _at(node: ElementTree.Element) -> tuple[float, float]:
    position = node.find(f"{NAMESPACE}position")
    return float(position.get("x")), float(position.get("y"))


def _outputs(node: ElementTree.Element) -> list[tuple[float, float]]:
    x, y = _at(node)
    points = (point.find(f"{NAMESPACE}relPosition") for tag in ("", "Action")
              for point in node.iter(f"{NAMESPACE}connectionPointOut{tag}"))
    return [(x + float(rel.get("x")), y + float(rel.get("y"))) for rel in points if rel is not None]


def _places(body: ElementTree.Element) -> list[str]:
    """Elements that lie on each other."""
    boxes = []
    for node in body:
        (x, y), width, height = _at(node), float(node.get("width")), float(node.get("height"))
        boxes.append((y, y + height, x, x + width, node.get("localId")))
    boxes.sort()
    found = []
    for number, (top, bottom, left, right, id_) in enumerate(boxes):
        for other_top, _, other_left, other_right, other in boxes[number + 1 :]:
            if other_top >= bottom:
                break
            if left < other_right and other_left < right:
                found.append(f"{id_} and {other} lie on each other")
    return found
