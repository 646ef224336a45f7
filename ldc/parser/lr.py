"""The LALR(1) driver: tokens of one unit to what the actions of its rules make, or what was expected.

Our own loop instead of lark's: it works on token indexes and passes one-child rules through, which makes
it several times as fast; the tables are lark's.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, cached_property

from ldc.parser.tables import END, Tables
from ldc.records import record

Action = Callable[[object, list], object]


@record
class Failure:
    """No tree: the token at ``index`` cannot stand where it stands (``END``: the unit ends too early)."""

    tables: Tables
    states: tuple[int, ...]
    index: int

    @cached_property
    def expected(self) -> frozenset[str]:
        """The terminals that could stand here instead."""
        row = self.tables.actions[self.states[-1]]
        return frozenset(t for t in row if t in self.tables.terminals and self._accepts(t))

    def _accepts(self, terminal: str) -> bool:
        """Whether the reductions that this terminal starts end in shifting it (or in acceptance)."""
        states, actions = list(self.states), self.tables.actions
        while True:
            action = actions[states[-1]].get(terminal)
            if action is None:
                return False
            if action >= 0:
                return True
            size, symbol, _ = self.tables.rules[-1 - action]
            if size:
                del states[-size:]
            states.append(actions[states[-1]][symbol])
            if terminal == END and states[-1] in self.tables.ends.values():
                return True


@cache
def bind(tables: Tables, actions: type) -> list[tuple[int, str, Action | None]]:
    """The rules with the methods of the class ``actions`` that they call; None passes the child on."""
    return [(size, symbol, getattr(actions, name) if name else None) for size, symbol, name in tables.rules]


def parse(
    tables: Tables, actions: object, start: str, types: Sequence[str], first: int, end: int
) -> object:
    """The value of ``start`` for the tokens ``first`` to ``end`` (exclusive), or a ``Failure``.

    A terminal's value is its index in ``types``; a method of ``actions``, by the name that the grammar gives
    it, takes the list of its children's values.
    """
    rules = bind(tables, type(actions))
    table = tables.actions
    final = tables.ends[start]
    states = [tables.starts[start]]
    values: list = []
    for index in range(first, end + 1):
        terminal = types[index] if index < end else END
        while True:
            action = table[states[-1]].get(terminal)
            if action is None:
                return Failure(tables, tuple(states), index)
            if action >= 0:
                states.append(action)
                values.append(index)
                break
            size, symbol, make = rules[-1 - action]
            if make is None:
                states.pop()
            elif size:
                value = make(actions, values[-size:])
                del values[-size:]
                del states[-size:]
                values.append(value)
            else:
                values.append(make(actions, []))
            states.append(table[states[-1]][symbol])
            if index == end and states[-1] == final:
                return values[-1]
    raise AssertionError("an LR parser ends with its end token")
