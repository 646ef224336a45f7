"""Located inputs and outputs of the master that a plant is wired to: copied between field and process image
at the boundaries of a scan."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from runtime.field import Field
from runtime.machine import Machine
from runtime.symbols import Symbol


class Wiring:
    """``points``: addresses or paths of located variables of the areas I and Q that are points of the
    field."""

    def __init__(self, field: Field, points: Iterable[str]) -> None:
        self._field, self._points = field, tuple(points)
        self._machine: Machine | None = None
        self._inputs: tuple[tuple[str, Symbol], ...] = ()
        self._outputs: tuple[Callable[[object], None], ...] = ()
        self._sense: Callable[[], tuple] = tuple
        self._read: Callable[[], tuple] = tuple
        self._given: tuple = ()
        self._shown: tuple = ()

    def bind(self, machine: Machine) -> None:
        """Goes on with the variables of a machine; what it does not have is wired to nothing."""
        known = zip(self._points, machine.known(self._points), strict=True)
        symbols = [(point, symbol) for point, symbol in known if symbol is not None]
        self._machine = machine
        self._inputs = tuple((point, s) for point, s in symbols if s.area == "I")
        self._sense = self._field.readers([point for point, _ in self._inputs])
        self._given = (None,) * len(self._inputs)
        outputs = [(point, s) for point, s in symbols if s.area == "Q"]
        self._outputs = tuple(self._field.writer(point) for point, _ in outputs)
        self._read = machine.reader(s for _, s in outputs)
        self._shown = ()

    def input(self, symbol: Symbol) -> Callable[[], object] | None:
        """What reads the point of an input at the plant, None when it is not wired."""
        found = (point for point, s in self._inputs if s.place == symbol.place)
        return next(map(self._field.reader, found), None)

    def before(self) -> None:
        """Inputs of the machine get what the plant has written, as far as it has changed."""
        given, now = self._given, self._sense()
        if now != given:
            self._given = now
            for (_, symbol), value, before in zip(self._inputs, now, given, strict=True):
                if value != before:
                    self._machine.put(symbol, value)

    def after(self) -> None:
        """The plant sees the outputs of the scan."""
        now = self._read()
        if now != self._shown:
            self._shown = now
            for write, value in zip(self._outputs, now, strict=True):
                write(value)
