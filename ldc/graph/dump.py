"""A rung's graph, its schedule and its trees as text, and as Graphviz source. Deterministic."""

from __future__ import annotations

from ldc.graph.order import Turn, schedule
from ldc.graph.rung import RAIL, RungGraph
from ldc.graph.texts import element_text
from ldc.graph.tree import Leaf, Parallel, SPTree, Tap, Tree
from ldc.model.elements import Block, Net
from ldc.types import BOOL

_DEEPEST = 40


def graph_text(graph: RungGraph, turns: tuple[Turn, ...] | None = None) -> str:
    """The nets with their types, the elements with the nets that they join, and the schedule."""
    turns = schedule(graph) if turns is None else turns
    lines = [f"rung {graph.key}" + (f' "{graph.title}"' if graph.title else "")]
    lines.append("  nets " + " ".join(_typed(graph, net) for net in range(len(graph.net_names))))
    width = len(str(len(graph.elements) - 1))
    for index, element in enumerate(graph.elements):
        head, tail = (net_name(graph, net) for net in (graph.heads[index], graph.tails[index]))
        if isinstance(element, Block):
            head, tail = head if element.power_in else "_", tail if element.power_out else "_"
        text = element_text(element, lambda net: net_name(graph, net))
        lines.append(f"  {index:>{width}} {head} -> {tail}  {text}")
    lines.append("  order " + " ".join(_turn(turn) for turn in turns))
    return "\n".join(lines) + "\n"


def _typed(graph: RungGraph, net: Net) -> str:
    type_ = graph.net_type(net)
    return net_name(graph, net) + ("" if type_ == BOOL else f":{type_}")


def _turn(turn: Turn) -> str:
    """``3`` or, at a block in a loop, ``3(5,6)``: 5 and 6 count as they were."""
    return f"{turn.element}({','.join(map(str, turn.stale))})" if turn.stale else str(turn.element)


def net_name(graph: RungGraph, net: Net) -> str:
    """``rail``, ``@name`` as drawn, ``#3`` for a net without a name, ``%1`` for one of the reduction."""
    if net >= len(graph.net_names):
        return f"%{net - len(graph.net_names) + 1}"
    name = graph.net_names[net]
    return name if net == RAIL or name.startswith("#") else f"@{name}"


def graph_dot(graph: RungGraph) -> str:
    """Graphviz source: nets are points, elements are arrows; the pins of a block join it by dashed ones."""
    lines = [f"digraph {_quoted(graph.key)} {{", "  rankdir=LR;", "  node [shape=point];"]
    for net in range(len(graph.net_names)):
        lines.append(f"  n{net} [xlabel={_quoted(net_name(graph, net))}];")
    for index, element in enumerate(graph.elements):
        text = _quoted(element_text(element, lambda net: net_name(graph, net)))
        if not isinstance(element, Block):
            lines.append(f"  n{graph.heads[index]} -> n{graph.tails[index]} [label={text}];")
            continue
        lines.append(f"  e{index} [shape=box, label={text}];")
        if element.power_in:
            lines.append(f"  n{graph.heads[index]} -> e{index} [label={_quoted(element.power_in)}];")
        lines += [f"  n{p.source} -> e{index} [style=dashed, label={_quoted(p.pin)}];"
                  for p in element.inputs if isinstance(p.source, int)]
        if element.power_out:
            lines.append(f"  e{index} -> n{graph.tails[index]} [label={_quoted(element.power_out)}];")
        lines += [f"  e{index} -> n{p.target} [style=dashed, label={_quoted(p.pin)}];"
                  for p in element.outputs if isinstance(p.target, int)]
    return "\n".join([*lines, "}"]) + "\n"


def _quoted(text: str) -> str:
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def tree_text(graph: RungGraph, tree: SPTree) -> str:
    """The steps with their trees, one node a line, indented by depth (beyond 40 the depth is a number)."""
    lines = [f"rung {graph.key}" + (f' "{graph.title}"' if graph.title else "")]
    for step in tree.steps:
        lines.append("  run" if step.net is None else f"  keep {net_name(graph, step.net)}")
        stack: list[tuple[int, str, Tree]] = [(2, "", step.tree)]
        while stack:
            depth, label, node = stack.pop()
            indent = "  " * min(depth, _DEEPEST) + (f"[{depth}] " if depth > _DEEPEST else "")
            if isinstance(node, Leaf):
                text = element_text(graph.elements[node.index], lambda net: net_name(graph, net))
                below = [(depth + 1, f"{name} := ", pin) for name, pin in node.pins]
            elif isinstance(node, Tap):
                text, below = f"{'previous ' if node.previous else ''}{net_name(graph, node.net)}", []
            else:
                text = "parallel" if isinstance(node, Parallel) else "series"
                below = [(depth + 1, "", child) for child in node.children]
            lines.append(indent + label + text)
            stack.extend(reversed(below))
    return "\n".join(lines) + "\n"
