"""What is in the elements of a chart in XML of IEC 61131-10: conditions and actions, as those of TC6.

A condition is text, a name, or a network that stands inside of its transition; an action is a name, a
variable or a body of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from ldc.parser.plcopen.document import Node

TAGS = {"Step": "step", "Transition": "transition", "JumpStep": "jumpStep", "ActionBlocks": "actionBlock",
        "SelectionDivergence": "selectionDivergence", "SelectionConvergence": "selectionConvergence",
        "SimultaneousDivergence": "simultaneousDivergence",
        "SimultaneousConvergence": "simultaneousConvergence"}
ATTRIBUTES = ("initialStep", "priority", "targetName")
PARTS = ("ConnectionPointOutAction", "Condition", "ActionBlock")
_NAMED = ("ReferenceName", "ComplexOperand")


def kind(node: Node) -> str:
    """What ``xsi:type`` says, without a prefix."""
    found = next((value for name, value in node.attributes.items() if name.rpartition(":")[2] == "type"), "")
    return found.strip().rpartition(":")[2]


def content(node: Node, tag: str, attributes: dict[str, str]) -> Node:
    """An element whose start tag is the text of another one: findings about it show that text."""
    text = node.content
    return Node(node.document, tag, text.start, text.end, text.start, attributes)


def networks(node: Node) -> Iterator[Node]:
    """The networks that a transition's condition is drawn with."""
    for condition in node.all("Condition"):
        for predicate in condition.all("GraphicalPredicate"):
            yield from predicate.all("GraphicalExpression")


def predicate(node: Node, tell: Callable[[Node, str, str], None]) -> list[Node]:
    """The text of a condition, in the language that it is written in."""
    found = []
    for one in node.all("PredicateContent"):
        text = one.find("ST") or one.find("IL")
        if text is not None:
            found.append(text)
        else:
            tell(one, f"a condition in {kind(one)[:40] or 'no language'}", "write it in Structured Text")
    return found


def parts(node: Node, points: Callable[[Node], list[Node]], body: Callable[[Node], Node],
          tell: Callable[[Node, str, str], None]) -> Iterator[Node]:
    """The condition of a transition, the actions of a block. ``points`` gives the inputs of an element,
    ``body`` reads a body, ``tell`` reports what is not read."""
    for condition in node.all("Condition"):
        inside: list[Node] = []
        for child in condition.children:
            if child.tag == "Reference":
                inside.append(child.like("reference", ()))
            elif child.tag == "TextualPredicate":
                inside.append(child.like("inline", predicate(child, tell)))
            elif child.tag == "GraphicalPredicate":
                inside += points(child)
            elif child.tag not in ("Documentation", "AddData"):
                tell(child, f"a condition <{child.tag[:40]}>", "write it in Structured Text")
        yield condition.like("condition", inside)
    for block in node.all("ActionBlock"):
        qualifier = block.find("ActionQualifier") or block
        inside = []
        for child in block.children:
            if child.tag in _NAMED:
                inside.append(content(child, "reference", {"name": child.content.text}))
            elif child.find("BodyContent") is not None:
                inside.append(child.like("inline", body(child).children))
            elif child.tag not in ("ActionQualifier", "RelPosition", "Size", "Documentation", "AddData"):
                tell(child, f"<{child.tag[:40]}> of an action", "name an action or a variable")
        yield qualifier.like("action", inside, {**block.attributes, **qualifier.attributes})
