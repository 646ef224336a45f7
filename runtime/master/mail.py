"""Messages of a program in its master: what broadcasts them, and what they do to modules (SPEC 3; C.BCAST,
C.MSG)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from ldc.il.coordination import Message, Subscriber, Value
from runtime.machine import Machine
from runtime.master.messages import Messages, Outcome
from runtime.master.modules import Modules
from runtime.protocol.memory import Memory
from runtime.symbols import Symbol


_OF_MODULES = ("START_MODULE", "STOP_MODULE")
"""Messages of the system whose data are the index of a module."""


class Mail:
    """``messages``: those of the system first, each class in ascending order."""

    def __init__(self, memory: Memory, messages: Iterable[Message], modules: Modules) -> None:
        self._modules = modules
        self._all = tuple(messages)
        self._messages = Messages(memory, self._all)
        self._sources = tuple(m for m in self._all if m.source)
        self._system = {m.name: m for m in self._all if m.system and m.subscribers}
        self._machine: Machine | None = None
        self._read: Callable[[], tuple] = tuple
        self._before: tuple | None = None
        self._data: dict[str, Symbol] = {}
        self._targets: dict[str, Symbol] = {}
        self._flags: list[Symbol] = []
        self._waits = True

    def bind(self, machine: Machine) -> None:
        """Goes on with the variables of a machine."""
        find = machine.symbols.find
        self._machine, self._before = machine, None
        self._read = machine.reader(find(m.source) for m in self._sources)
        self._data = {m.name: find(m.data) for m in self._all if m.data}
        pins = (pin for m in self._all for s in m.subscribers for pin in (s.flag, s.data) if pin)
        self._targets = {pin: find(pin) for pin in pins}

    def take_over(self, other: Mail) -> None:
        """After ``bind``: goes on with what waits; flags that are TRUE for the next execution fall after it.
        Of a message that was not there before, what is TRUE now has not risen."""
        known = self._machine.known(symbol.path for symbol in other._flags)
        self._flags = [symbol for symbol in known if symbol is not None]
        renumbered = self._modules.renumbered(other._modules)
        stay = all(renumbered.get(life.module.index) == life.module.index for life in other._modules.lives)
        if other._all == self._all and stay:
            return

        def now(message: Message, value: Value | None) -> Value | None:
            return renumbered[value] if message.system and message.name in _OF_MODULES else value

        self._messages.take_over(other._messages, now)
        before = {message.name.upper() for message in other._sources}
        for message, on in zip(self._sources, self._read(), strict=True):
            if message.name.upper() not in before:
                self._messages.rises(message, bool(on))

    def broadcast(self) -> Iterator[tuple[Message, Outcome]]:
        """C.BCAST: the messages whose source has risen in this scan."""
        now = self._read()
        if now == self._before:
            return
        self._before = now
        for message, on in zip(self._sources, now, strict=True):
            if self._messages.rises(message, bool(on)):
                symbol = self._data.get(message.name)
                value = None if symbol is None else self._machine.value(symbol)
                self._waits = True
                yield message, self._messages.broadcast(message, value)

    def raise_system(self, name: str, value: int = 0) -> Message | None:
        """Broadcasts a message of the system, when somebody has subscribed to it."""
        message = self._system.get(name)
        if message is not None:
            self._waits = True
            self._messages.broadcast(message, value)
        return message

    def fall(self) -> None:
        """The flags that the last ``handle`` has set were seen by one execution: they are FALSE again."""
        for symbol in self._flags:
            self._machine.assign(symbol, False)
        self._flags.clear()

    def handle(self, note: Callable[[Message, Subscriber], None]) -> None:
        """C.MSG: every subscriber of every message that waits; ``note`` is told each."""
        if not self._waits:
            return

        def call(message: Message, subscriber: Subscriber, value: Value | None) -> None:
            note(message, subscriber)
            if subscriber.data and value is not None:
                self._modules.set(subscriber.module, self._targets[subscriber.data], value)
            if subscriber.flag is None:
                self._modules.raise_start(subscriber.module)
            else:
                symbol = self._targets[subscriber.flag]
                self._machine.assign(symbol, True)
                self._flags.append(symbol)

        self._waits = self._messages.handle(call) > 0

    def clear(self) -> None:
        """Nothing waits any longer."""
        self._messages.clear()
