"""What the typing of an expression asks its surroundings: two answer, a POU and a declaration."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Protocol

from ldc.expr import Place
from ldc.symbols import Signature, Variable
from ldc.types import Enum, Type


class Environment(Protocol):
    """Names are given in capitals. ``kind`` is that of the POU, "" outside of one; ``statements``: it is
    an ST body, whose calls may have outputs; ``taken`` collects the places that these write; ``flags``: steps
    and actions of the chart that is the body."""

    pou: str
    kind: str
    library: bool
    image_bytes: int
    statements: bool
    taken: list[Place]
    flags: frozenset[str]

    def variable(self, key: str) -> tuple[Variable, bool] | None:
        """The variable, and whether it is a global one."""

    def path(self, first: str, second: str) -> tuple[Variable, bool] | str | None:
        """The variable ``second`` of the program or the list of globals ``first``, as ``variable`` gives it;
        words that say why there is none; None when nothing is called ``first``."""

    def silent(self, key: str) -> bool:
        """Whether an unknown name was reported at its declaration already (no cascades)."""

    def silent_pin(self, pou: str, key: str) -> bool:
        """The same for a pin of a POU."""

    def type_named(self, key: str) -> Type | None:
        """A type of the project."""

    def enum_values(self, key: str) -> tuple[tuple[Enum, int], ...]:
        """The enumerations that have a value of this name, with its number."""

    def signature(self, key: str) -> Signature | None:
        """A POU of the project or a standard function block."""

    def names(self) -> Iterable[str]:
        """Everything that may stand for a value here, for suggestions."""

    def callables(self) -> Iterable[str]:
        """The POUs of the project, for suggestions."""
