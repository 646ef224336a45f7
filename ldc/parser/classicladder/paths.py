"""Steps as paths of a rung: series and parallel where that keeps the order, junctions otherwise.

The elements of nested branches are evaluated as they stand in the text, path after path; ClassicLadder goes
from column to column. Where a variable would be read before it is written, or the other way round, the rung
is written element by element in its own order, with the nets as junctions.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ldc.parser import ast, fragments
from ldc.parser.classicladder.steps import RAIL, Net, Step
from ldc.source import Span


def paths(steps: list[Step], span: Span) -> tuple[ast.Path, ...]:
    nested = _nested(steps)
    if nested is None or not _same(steps, [step for tree in nested for step in _leaves(tree)]):
        return tuple(_sequence(steps))
    return tuple(fragments.path(_items(tree), span) for tree in nested)


# ---- series and parallel


@dataclass(slots=True, eq=False)
class _Edge:
    """A part of the rung between two nets. ``parts``: of a series; a step, or a parallel of edges."""

    head: Net | None
    tail: Net | None
    parts: list[Step | list[_Edge]]


def _nested(steps: list[Step]) -> list[_Edge] | None:
    """One tree for each path from the rail; None when some net is neither in series nor in parallel."""
    if any(step.inputs or step.outputs for step in steps):
        return None
    edges = [_Edge(step.head, step.tail, [step]) for step in steps]
    while True:
        merged = _series(_parallel(edges))
        if len(merged) == len(edges):
            break
        edges = merged
    return edges if all(edge.head is RAIL and edge.tail is None for edge in edges) else None


def _parallel(edges: list[_Edge]) -> list[_Edge]:
    """Edges between the same two nets as one. What leaves the rail for nothing stays a path."""
    between: dict[tuple[Net | None, Net | None], list[_Edge]] = {}
    for edge in edges:
        between.setdefault((edge.head, edge.tail), []).append(edge)
    kept = []
    for (head, tail), group in between.items():
        if len(group) == 1 or (head is RAIL and tail is None):
            kept += group
        else:
            kept.append(_Edge(head, tail, [group]))
    return kept


def _series(edges: list[_Edge]) -> list[_Edge]:
    """Nets with one edge to them and one from them disappear."""
    into: dict[Net, list[_Edge]] = {}
    out: dict[Net, list[_Edge]] = {}
    for edge in edges:
        into.setdefault(edge.tail, []).append(edge)
        out.setdefault(edge.head, []).append(edge)
    gone: set[int] = set()
    for net, before in into.items():
        after = out.get(net, [])
        if net is None or len(before) != 1 or len(after) != 1:
            continue
        first, second = before[0], after[0]
        second.head = first.head
        second.parts = [*first.parts, *second.parts]
        gone.add(id(first))
        group = out[first.head]
        group[group.index(first)] = second
    return [edge for edge in edges if id(edge) not in gone]


def _leaves(edge: _Edge) -> Iterator[Step]:
    for part in edge.parts:
        if isinstance(part, Step):
            yield part
        else:
            for branch in part:
                yield from _leaves(branch)


def _items(edge: _Edge) -> list[ast.Item]:
    items: list[ast.Item] = []
    for part in edge.parts:
        if isinstance(part, Step):
            items += fragments.items(part.text, part.span)
        else:
            branches = [_items(branch) for branch in part]
            items.append(
                ast.Branches(tuple(fragments.path(b, b[0].span) for b in branches), branches[0][0].span)
            )
    return items


def _same(drawn: list[Step], written: list[Step]) -> bool:
    """Whether both orders give each variable the same accesses: reads may change places with each other."""
    return _accesses(drawn) == _accesses(written)


def _accesses(steps: list[Step]) -> dict[str, list[frozenset[int] | int]]:
    """By variable, its writers in order, with the readers between them; a call is one of everything."""
    found: dict[str, list] = {}
    calls = any(step.call for step in steps)
    for step in steps:
        touched = {**dict.fromkeys(step.reads, False), **dict.fromkeys(step.writes, True)}
        if calls and (touched or step.call):
            touched[""] = step.acts
        for name, writes in touched.items():
            accesses = found.setdefault(name, [])
            if writes:
                accesses.append(id(step))
            elif accesses and isinstance(accesses[-1], frozenset):
                accesses[-1] |= {id(step)}
            else:
                accesses.append(frozenset((id(step),)))
    return found


# ---- junctions


def _sequence(steps: list[Step]) -> Iterator[ast.Path]:
    """The steps in their order; those that follow each other in the drawing share a path."""
    names: dict[Net, str] = {}
    uses: dict[Net, int] = {}
    for step in steps:
        for net in (step.head, step.tail, *step.inputs.values(), *step.outputs.values()):
            if net is not None:
                names.setdefault(net, f"n{len(names) + 1}")
                uses[net] = uses.get(net, 0) + 1
    items: list[ast.Item] = []
    before: Step | None = None
    for step in steps:
        chained = before is not None and step.head is not RAIL and step.head == before.tail
        if not chained:
            if before is not None:
                yield _closed(items, before, names)
            items = []
        if step.head is not RAIL and not (chained and uses[step.head] == 2):
            items.append(ast.Junction(names[step.head], step.span))
        items += fragments.items(_text(step, names), step.span)
        before = step
    if before is not None:
        yield _closed(items, before, names)


def _closed(items: list[ast.Item], last: Step, names: dict[Net, str]) -> ast.Path:
    if last.tail is not None:
        items.append(ast.Junction(names[last.tail], last.span))
    return fragments.path(items, items[0].span)


def _text(step: Step, names: dict[Net, str]) -> str:
    pins = [f"{pin} := {'TRUE' if net is RAIL else f'@{names[net]}'}" for pin, net in step.inputs.items()]
    pins += [f"{pin} => @{names[net]}" for pin, net in step.outputs.items()]
    return f"{step.text[:-2]}, {', '.join(pins)})>" if pins else step.text
