"""Whether the places of elements alone show in which order they are evaluated (docs/plcopen.md).

Elements follow each other by their places (or numbers), each behind what feeds it, network by network. Which
of a loop begins is found by going back from what is written, as the generator of Beremiz and OpenPLC does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import networkx as nx

Place = tuple[float, ...]
Wires = Iterable[tuple[str, str]]
"""From an id to an id."""


def shown(written: Sequence[tuple[str, str]], places: Mapping[str, Place], wires: Wires) -> bool:
    """Whether elements in the order written, each an id and its kind, are evaluated in that order when only
    their places tell it. What feeds an element goes before it in both."""
    import networkx as nx  # slow to load, and only drawings of `ldc export` need it

    kinds = dict(written)
    graph = nx.DiGraph()
    graph.add_nodes_from(kinds)
    graph.add_edges_from((a, b) for a, b in wires if a in kinds and b in kinds)
    as_written = {id_: number for number, id_ in enumerate(kinds)}
    by_place = {id_: number for number, id_ in enumerate(sorted(kinds, key=places.__getitem__))}
    networks = sorted(nx.weakly_connected_components(graph), key=lambda ids: min(map(by_place.get, ids)))
    drawn = chain.from_iterable(_fed_first(graph.subgraph(network), by_place) for network in networks)
    return list(_bare(_fed_first(graph, as_written), kinds)) == list(_bare(drawn, kinds))


WRITES = ("coil", "outVariable", "inOutVariable")
"""What ways back begin at."""


def any_loop(starts: Iterable[str], sources: Callable[[str], Sequence[str]]) -> bool:
    """Whether something feeds itself, found by going back from ``starts``: at least one element of each loop."""
    return _backwards(starts, sources)[1]


def in_loops(kinds: Mapping[str, str], sources: Mapping[str, Sequence[str]]
             ) -> tuple[list[str], list[set[str]]]:
    """The elements, given in the order of their places, in that of their turns, and the loops: what is on one
    changes places among each other. What a way back comes to first is the last of its loop."""
    turns = list(kinds)
    starts = sorted(kinds, key=lambda id_: (kinds[id_] not in WRITES, kinds[id_] != "block"))
    if not _backwards(starts, lambda id_: sources.get(id_, ()))[1]:
        return turns, []
    import networkx as nx  # few files need it

    number = _numbers(starts, kinds, sources)
    graph = nx.DiGraph((source, id_) for id_, found in sources.items() for source in found)
    loops = [found for found in nx.strongly_connected_components(graph)
             if len(found) > 1 or any(id_ in sources.get(id_, ()) for id_ in found)]
    of = {id_: at for at, loop in enumerate(loops) for id_ in loop}
    places: list[list[int]] = [[] for _ in loops]
    for at, id_ in enumerate(kinds):
        if id_ in of:
            places[of[id_]].append(at)
    for own in places:
        elements = [turns[at] for at in own]
        for at, id_ in zip(own, sorted(elements, key=lambda id_: (number[id_], kinds[id_] != "contact"))):
            turns[at] = id_
    return turns, loops


def _numbers(starts: Iterable[str], kinds: Mapping[str, str], sources: Mapping[str, Sequence[str]]
             ) -> dict[str, int]:
    """In which order ways back come to elements; through a contact they go as often as they come to it, and it
    has the number of the first that it feeds."""
    def behind(id_: str) -> list[str]:
        """What an element is wired to, perhaps through contacts."""
        is_contact: dict[str, bool] = {}
        work = [iter(sources.get(id_, ()))]
        while work:
            source = next(work[-1], None)
            if source is None:
                work.pop()
            elif source not in is_contact:
                is_contact[source] = kinds.get(source) == "contact"
                if is_contact[source]:
                    work.append(iter(sources.get(source, ())))
        return [source for source, is_one in is_contact.items() if not is_one]

    back, _ = _backwards((id_ for id_ in starts if kinds[id_] != "contact"), behind)
    number = {id_: at for at, id_ in enumerate(back)}
    for id_ in back:
        work = [id_]
        while work:
            for source in sources.get(work.pop(), ()):
                if kinds.get(source) == "contact" and source not in number:
                    number[source] = number[id_]
                    work.append(source)
    return {id_: number.get(id_, len(back)) for id_ in kinds}


def _backwards(starts: Iterable[str], sources: Callable[[str], Sequence[str]]) -> tuple[list[str], bool]:
    """What ways back come to, each element behind its sources, but for those from which the way came; and
    whether there are such."""
    done: list[str] = []
    begun: set[str] = set()
    on_way: set[str] = set()
    meets_itself = False
    for start in starts:
        if start in begun:
            continue
        way = [(start, iter(sources(start)))]
        begun.add(start)
        on_way.add(start)
        while way:
            id_, rest = way[-1]
            following = next(rest, None)
            if following is None:
                way.pop()
                on_way.discard(id_)
                done.append(id_)
            elif following not in begun:
                begun.add(following)
                on_way.add(following)
                way.append((following, iter(sources(following))))
            else:
                meets_itself |= following in on_way
    return done, meets_itself


def _fed_first(graph: nx.DiGraph, turns: Mapping[str, int]) -> Iterable[str]:
    """The order of the turns with everything behind what feeds it, but where a loop forbids that."""
    import networkx as nx

    if nx.is_directed_acyclic_graph(graph):
        return nx.lexicographical_topological_sort(graph, key=turns.__getitem__)
    return sorted(graph, key=turns.__getitem__)


def _bare(order: Iterable[str], kinds: Mapping[str, str]) -> Iterator[frozenset[str]]:
    """An order as far as it matters: contacts may change places with contacts, and a variable behind an
    output is written by its block."""
    contacts: set[str] = set()
    for id_ in order:
        if kinds[id_] == "contact":
            contacts.add(id_)
        elif kinds[id_] != "outVariable":
            yield frozenset(contacts)
            yield frozenset((id_,))
            contacts = set()
    yield frozenset(contacts)
