"""What contacts in a drawn loop let pass: they are read when the block is executed that they lead to.

In a rung of text a loop is opened at a block: what comes back to it has the power of the scan before, with the
contacts on the way. In a drawing only the value of a function is of the scan before, as in Beremiz and OpenPLC.
So that value is kept in a variable, from which the contacts lead to the block; where something else reads them
too, they stand twice.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from copy import copy

from ldc.parser import ast
from ldc.parser.plcopen import texts
from ldc.parser.plcopen.drawing import (
    KEEP, KEPT, Drawing, Element, Input, Output, is_call, is_conditional,
)
from ldc.records import replace


def keep(drawing: Drawing, loops: Collection[Collection[str]]) -> None:
    """Have the contacts that lead from a block to one that has its turn not behind it read what was kept."""
    for loop in loops:
        for block in [e for e in drawing.elements.values() if e.kind == "block" and e.id in loop]:
            _Way(drawing, loop, block).change()


class _Way:
    """The contacts of a loop from which power comes to a block."""

    def __init__(self, drawing: Drawing, loop: Collection[str], block: Element) -> None:
        self.drawing, self.elements, self.block = drawing, drawing.elements, block
        self.loop = loop
        self.contacts: dict[str, Element] = {}
        work = [block]
        while work:
            for pin in work.pop().inputs:
                for id_, _ in sorted(pin.sources):
                    if id_ in loop and id_ not in self.contacts and self.elements[id_].kind == "contact":
                        self.contacts[id_] = self.elements[id_]
                        work.append(self.elements[id_])

    def change(self) -> None:
        fed = {id_: [s for s, _ in _sources(contact)] for id_, contact in self.contacts.items()}
        late = _closed((id_ for id_, contact in self.contacts.items() if any(map(self.is_before, _sources(contact)))),
                       lambda id_: [other for other, sources in fed.items() if id_ in sources])
        if not late:
            return
        readers: dict[str, list[str]] = {}
        for element in self.elements.values():
            for id_, _ in _sources(element):
                readers.setdefault(id_, []).append(element.id)
        others = {id_ for id_ in late if any(r != self.block.id and r not in late for r in readers[id_])}
        twice = _closed(others, lambda id_: [source for source in fed[id_] if source in late])
        named = {id_: f"{id_} before {self.block.id}" if id_ in twice else id_ for id_ in late}
        for id_ in late:
            contact = self.contacts[id_]
            if id_ in twice:
                contact = self.elements[named[id_]] = copy(contact)
                contact.id, contact.inputs = named[id_], [replace(pin) for pin in contact.inputs]
            contact.order = min(contact.order, self.block.order)
            self._rewire(contact, named, True)
        self._rewire(self.block, named, False)

    def is_before(self, output: Output) -> bool:
        """Whether an output has the value of the scan before when the block is executed."""
        element = self.elements.get(output[0])
        return output[0] in self.loop and element.kind == "block" and element.order >= self.block.order and (
            is_call(element.node, self.drawing.more) or not is_conditional(element))

    def _rewire(self, element: Element, named: dict[str, str], is_contact: bool) -> None:
        for pin in element.inputs:
            pin.sources = frozenset(
                (named[output[0]], output[1]) if output[0] in named else
                self._kept(output) if is_contact and self.is_before(output) else output
                for output in sorted(pin.sources))

    def _kept(self, output: Output) -> Output:
        """What an output was in the scan before: of a function, a variable that is written behind it."""
        block = self.elements[output[0]]
        if is_call(block.node, self.drawing.more):
            return self.drawing.of_before(output)
        key = f"{block.id} {output[1]} before"
        if key not in self.elements:
            span = block.node.span
            type_ = block.node.get("typeName").strip()
            name = self.drawing.more.fresh(texts.label(f"{type_}_{block.id}_{output[1]}", "kept"))
            made = ast.VarDecl(name, None, ast.NamedType("BOOL", None, span), None, span, span)
            self.drawing.more.variables.append(made)
            for id_, tag in ((key, KEPT), (f"{key}, kept", KEEP)):
                node = block.node.like(tag, (), {"localId": id_, "name": name})
                self.elements[id_] = element = Element(id_, node, None, 0)
                element.order = (*block.order, 1)
            element.inputs.append(Input("", node, frozenset((output,))))
        return key, ""


def _sources(element: Element) -> list[Output]:
    return [output for pin in element.inputs for output in pin.sources]


def _closed(found: Iterable[str], following: Callable[[str], Collection[str]]) -> list[str]:
    """What is found, and what follows any of it."""
    closed = dict.fromkeys(found)
    work = list(closed)
    while work:
        for id_ in following(work.pop()):
            if id_ not in closed:
                closed[id_] = None
                work.append(id_)
    return list(closed)
