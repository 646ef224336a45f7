"""Where things are, in columns and lines: nets get ranks, lanes get lines, and nothing may collide."""

from __future__ import annotations

from collections import defaultdict, deque

from ldc.draw import figures
from ldc.draw.figures import Figure
from ldc.draw.labels import Options
from ldc.draw.sketch import RAIL, RIGHT, Group, Lane, Plan, Sketch, measure_group, sketch
from ldc.parser import ast
from ldc.records import record, replace

BUDGET = 60_000
"""Figures that may be arranged, all attempts of a rung together, before junctions become tags."""


@record
class Arrangement:
    """``rank``: column boundary of each net. The figures of the last columns, from ``zone`` on, are the
    coils and jumps at the right; the right rail has the rank ``columns``. ``lines``: of the picture."""

    figures: tuple[Figure, ...]
    rank: dict[int, int]
    starts: frozenset[int]
    zone: int
    columns: int
    lines: int


def arrange(rung: ast.Rung, options: Options) -> Arrangement:
    """The arrangement of a rung with as many junctions drawn as wires as go without crossings."""
    nodes = list(figures.drawn(rung))
    junctions = [number for number, node in enumerate(n for n in nodes if isinstance(n, ast.Junction))]
    plain = sketch(rung, Plan(), options)
    if not junctions and not plain.networks:
        return _place(plain, check=False)
    for late in (frozenset(), frozenset(junctions)):
        plan = Plan(frozenset(junctions), (), frozenset(range(plain.networks)), late)
        found = _attempt(rung, plan, options)
        if found is not None:
            return found
    return _search(rung, plain, options, BUDGET // (len(nodes) + 1))


def _search(rung: ast.Rung, plain: Sketch, options: Options, attempts: int) -> Arrangement:
    """Begin with tags and local rails everywhere; keep each improvement that collides with nothing."""
    plan, best = Plan(), _place(plain, check=False)
    for better in _improvements(rung, plain):
        if attempts <= 0:
            break
        for candidate in better(plan):
            attempts -= 1
            found = _attempt(rung, candidate, options)
            if found is not None:
                plan, best = candidate, found
                break
            if attempts <= 0:
                break
    return best


def _improvements(rung: ast.Rung, plain: Sketch):
    """Functions from the plan so far to plans that are better, the best first."""
    for network in range(plain.networks):
        yield lambda plan, n=network: [replace(plan, railed=plan.railed | {n})]
    number = 0
    for index, path in enumerate(rung.paths):
        inside = list(figures.drawn(replace(rung, paths=(path,))))
        own = [number + i for i, _ in enumerate(n for n in inside if isinstance(n, ast.Junction))]
        number += len(own)
        places = [None]
        if isinstance(path.items[0], ast.Junction):
            places += [
                (index, at, k)
                for at, (group, owner) in enumerate(plain.groups) if owner < index
                for k in range(1, len(group.lanes) + 1)
            ]
        if len(own) > 1:
            yield lambda plan, own=own, places=places: _joined(plan, own, places)
        for one in own:
            yield lambda plan, one=one, places=places: _joined(plan, [one], places)


def _joined(plan: Plan, numbers: list[int], places: list[tuple[int, int, int] | None]) -> list[Plan]:
    if plan.joined.issuperset(numbers):
        return []
    joined = plan.joined | frozenset(numbers)
    moved = {place[0] for place in plan.places}
    return [
        replace(plan, joined=joined, late=late, places=plan.places + ((place,) if place else ()))
        for place in places if place is None or place[0] not in moved
        for late in (plan.late, plan.late | frozenset(numbers))
    ]


def _attempt(rung: ast.Rung, plan: Plan, options: Options) -> Arrangement | None:
    return _place(sketch(rung, plan, options), check=True)


def _place(drawn: Sketch, check: bool) -> Arrangement | None:
    above, below = measure_group(drawn.root)
    _lines(drawn.root, above)
    ranked = _ranks(drawn)
    if ranked is None:
        return None
    rank, zone, columns = ranked
    found = Arrangement(
        tuple(drawn.figures), rank, frozenset(drawn.starts), zone, columns, above + 1 + below
    )
    return None if check and _collides(found) else found


def _lines(group: Group, y: int) -> None:
    """Give every lane its line, the first lane of ``group`` line ``y``."""
    for index, lane in enumerate(group.lanes):
        y += lane.above if index else 0
        _lane_lines(lane, y)
        y += lane.below + 1


def _lane_lines(lane: Lane, y: int) -> None:
    lane.y = y
    for item in lane.items:
        if isinstance(item, Group):
            _lines(item, y)
            continue
        item.y = y
        for port, offset, _ in item.ports():
            if port.group is not None:
                _lines(port.group, y + offset)


# ---- ranks ------------------------------------------------------------------------------------


def _ranks(drawn: Sketch) -> tuple[dict[int, int], int, int] | None:
    """Longest paths from the left rail; coils and jumps at the right end as late as possible. None when
    the wires go round."""
    after: dict[int, list[tuple[int, int]]] = defaultdict(list)
    waits: dict[int, int] = defaultdict(int)

    def arc(a: int, b: int, weight: int) -> None:
        after[a].append((b, weight))
        waits[b] += 1

    for number, figure in enumerate(drawn.figures):
        node = ~number
        arc(figure.head, node, 0)
        if figure.tail != RIGHT:
            arc(node, figure.tail, 1)
        for port, _, left in figure.ports():
            if port.net is not None:
                arc(*((port.net, node, 0) if left else (node, port.net, 1)))
    for start, head in drawn.starts.items():
        arc(head, start, 1)
    rank: dict[int, int] = dict.fromkeys((*after, *waits), 0)
    ready = deque(node for node in rank if not waits[node])
    order = []
    while ready:
        node = ready.popleft()
        order.append(node)
        for other, weight in after[node]:
            rank[other] = max(rank[other], rank[node] + weight)
            waits[other] -= 1
            if not waits[other]:
                ready.append(other)
    if len(order) < len(rank):
        return None
    depth = _depths(drawn, order)
    zone = max((rank[n] + (n < 0) for n in order if n not in depth), default=0)
    loose = any(f.wired_out and f.tail != RIGHT and rank[f.tail] == zone for f in drawn.figures)
    columns = zone + max(depth.values(), default=1 if loose else 0)
    for node, steps in depth.items():
        rank[node] = columns - steps
    for net in drawn.late:
        if net in rank:  # a junction alone may be on no way
            rank[net] = min((rank[node] for node, _ in after[net]), default=rank[net])
    for number, figure in enumerate(drawn.figures):
        figure.column = rank[~number]
    rank[RAIL], rank[RIGHT] = 0, columns
    return rank, zone, columns


def _depths(drawn: Sketch, order: list[int]) -> dict[int, int]:
    """Columns from the right rail of the coils and jumps that end the rung and of the nets between
    them. A net counts only if nothing but coils stands on either side of it."""
    leaving: dict[int, list[int]] = defaultdict(list)
    mixed: set[int] = {RAIL, RIGHT, *drawn.starts}
    for number, figure in enumerate(drawn.figures):
        leaving[figure.head].append(number)
        if figure.kind not in ("coil", "jump"):
            mixed.add(figure.tail)
        mixed.update(port.net for port, _, _ in figure.ports() if port.net is not None)
    depth: dict[int, int] = {}
    for node in reversed(order):
        if node < 0:
            figure = drawn.figures[~node]
            if figure.kind in ("coil", "jump") and (figure.tail == RIGHT or figure.tail in depth):
                depth[node] = 1 + depth.get(figure.tail, 0)
        elif node not in mixed and leaving[node] and all(~n in depth for n in leaving[node]):
            depth[node] = max(depth[~n] for n in leaving[node])
    return depth


# ---- collisions -------------------------------------------------------------------------------


def attachments(found: Arrangement) -> dict[int, list[int]]:
    """The lines at which wires meet each net."""
    lines: dict[int, list[int]] = defaultdict(list)
    for figure in found.figures:
        if figure.wired_in:
            lines[figure.head].append(figure.y)
        if figure.wired_out:
            lines[figure.tail].append(figure.y)
        for port, offset, _ in figure.ports():
            if port.net is not None:
                lines[port.net].append(figure.y + offset)
    return lines


def wires(found: Arrangement):
    """(net, line, rank from, rank to) of every horizontal wire beside its figure's own column."""
    for figure in found.figures:
        left, right = figure.column, figure.column + 1
        if figure.wired_in:
            yield figure.head, figure.y, found.rank[figure.head], left
        if figure.wired_out:
            yield figure.tail, figure.y, right, found.rank[figure.tail]
        for port, offset, is_left in figure.ports():
            if port.net is not None:
                ends = (found.rank[port.net], left) if is_left else (right, found.rank[port.net])
                yield port.net, figure.y + offset, *ends


def _collides(found: Arrangement) -> bool:
    """Whether two nets would touch or cross, or a wire would run through a figure."""
    cells: dict[tuple[int, int], int] = {}
    points: dict[tuple[int, int], int] = {(0, line): RAIL for line in range(found.lines)}

    def taken(table: dict[tuple[int, int], int], key: tuple[int, int], owner: int) -> bool:
        return table.setdefault(key, owner) != owner

    for number, figure in enumerate(found.figures):
        for line in range(figure.y - figure.above, figure.y + figure.below + 1):
            if taken(cells, (figure.column, line), ~number):
                return True
    for net, line, start, end in wires(found):
        if any(taken(cells, (column, line), net) for column in range(start, end)):
            return True
        if any(taken(points, (rank, line), net) for rank in range(start, end + 1)):
            return True
    for net, lines in attachments(found).items():
        if net in (RAIL, RIGHT):
            continue
        rank = found.rank[net]
        if any(taken(points, (rank, line), net) for line in range(min(lines), max(lines) + 1)):
            return True
    return False
