"""The modules of a program in their master: start bits, parameters, the end (SPEC 1.2, 6.2; C.START, C.END).

A module with a VAR_INPUT `start` is in work from lcf = 1 until it says `done` and none of its algorithms
executes. The logic of all modules runs in every scan, so one without `start` is in work while an algorithm of
it executes. """

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from ldc.il.areas import areas
from ldc.il.coordination import Module, Value
from ldc.types import BOOL
from runtime.machine import Machine
from runtime.master.proxy import Proxy
from runtime.protocol.memory import Memory, bit
from runtime.symbols import Symbol


@dataclass(slots=True, eq=False)
class Life:
    """A module at work. ``word``, ``mask``: its start bit. ``runs``: its program instances, by number.
    ``parameters``: form and variable by address in LCD. ``stands``: after a fault, so that it cannot be
    started and its outputs keep their safe values, ``held``."""

    module: Module
    word: int
    mask: int
    proxies: tuple[Proxy, ...]
    start: Symbol | None = None
    runs: tuple[int, ...] = ()
    parameters: dict[int, tuple[str, Symbol]] = field(default_factory=dict)
    stands: bool = False
    held: list[tuple[Symbol, object]] = field(default_factory=list)

    @property
    def executes(self) -> bool:
        """At least one algorithm of it executes."""
        for proxy in self.proxies:
            if proxy.executing:
                return True
        return False


class Modules:
    """``memory``: of the master. Bits in LCF may be set by anybody who may (messages, the customised program)
    between two scans. ``stand``: one of the modules does."""

    def __init__(self, memory: Memory, modules: Iterable[Module], proxies: Sequence[Proxy]) -> None:
        self._memory = memory
        self._machine: Machine | None = None
        base = areas()["LCF"].base
        self.lives = tuple(
            Life(module, *bit(base + module.index),
                 tuple(p for p in proxies if p.placed.module == module.index)) for module in modules)
        self._words = {word: [life for life in self.lives if life.word == word]
                       for word in dict.fromkeys(life.word for life in self.lives)}
        self._by_index = {life.module.index: life for life in self.lives}
        self.stand = False
        self._seen = dict.fromkeys(self._words, 0)
        self._rests = dict.fromkeys(self._words, 0)
        self._done: Callable[[], tuple] = tuple
        self._done_at: dict[int, int] = {}

    def bind(self, machine: Machine) -> None:
        """Goes on with the variables of a machine. LCD gets what the modules' inputs have."""
        self._machine = machine
        layout = machine.layout
        for life in self.lives:
            module = life.module
            life.runs = tuple(n for n, (run, _) in enumerate(layout.programs)
                              if run.pou.upper() == module.name.upper())
            life.start = machine.symbols.find(module.start) if module.start else None
            life.parameters = {p.address: (p.form, machine.symbols.find(p.path)) for p in module.parameters}
            for address, (form, symbol) in life.parameters.items():
                self._memory.data.write(address, struct.pack(form, machine.value(symbol)))
            if life.stands:
                self.hold(life)
        ending = [life for life in self.lives if life.module.done]
        self._done_at = {life.module.index: n for n, life in enumerate(ending)}
        self._done = machine.reader(machine.find(life.module.done for life in ending))

    def take_over(self, other: Modules) -> None:
        """Before ``bind``: modules of the same name stay in work, or stand; those that are gone do not."""
        bits = self._memory.bits
        before = {life.module.name.upper(): (bits.test(life.word, life.mask), life.stands)
                  for life in other.lives}
        for life in other.lives:
            bits.clear(life.word, life.mask)
        for life in self.lives:
            working, life.stands = before.get(life.module.name.upper(), (False, False))
            if working:
                bits.set(life.word, life.mask)
                self._seen[life.word] |= life.mask

    def renumbered(self, other: Modules) -> dict[int, int]:
        """The indices of the modules that another program had, there and here."""
        here = {life.module.name.upper(): life.module.index for life in self.lives}
        names = {life.module.index: life.module.name.upper() for life in other.lives}
        return {index: here[name] for index, name in names.items() if name in here}

    def __getitem__(self, index: int) -> Life:
        return self._by_index[index]

    @property
    def working(self) -> bool:
        """Some start bit is 1."""
        load = self._memory.bits.load
        for word in self._words:
            if load(word):
                return True
        return False

    # ---- start -----------------------------------------------------------------------------------

    def raise_start(self, index: int) -> None:
        """Sets the start bit of a module, unless it stands after a fault."""
        life = self._by_index[index]
        if not life.stands:
            self._memory.bits.set(life.word, life.mask)

    def give(self, index: int, address: int) -> None:
        """An input of a module gets what was written to LCD."""
        form, symbol = self._by_index[index].parameters[address]
        (value,) = struct.unpack(form, self._memory.data.read(address, struct.calcsize(form)))
        self._machine.assign(symbol, value != 0 if symbol.type == BOOL else value)

    def set(self, index: int, symbol: Symbol, value: Value) -> None:
        """An input of a module gets a value, in LCD too when it is a parameter."""
        self._machine.assign(symbol, value)
        for address, (form, known) in self._by_index[index].parameters.items():
            if known is symbol:
                self._memory.data.write(address, struct.pack(form, value))

    def started(self) -> Iterator[Life]:
        """C.START: tells modules whose start bit has changed by `start`; those that begin. One that is
        started again as soon as it has ended first executes once without `start`, so that its logic sees the
        end."""
        for word, lives in self._words.items():
            now, before = self._memory.bits.load(word) & ~self._rests[word], self._seen[word]
            self._rests[word] = 0
            if now == before:
                continue
            self._seen[word] = now
            for life in lives:
                if (now ^ before) & life.mask:
                    begins = bool(now & life.mask)
                    if life.start is not None:
                        self._machine.assign(life.start, begins)
                    if begins:
                        yield life

    def executes(self, proxy: Proxy) -> Life | None:
        """An algorithm begins: its module, when that has no `start` and is in work from now on."""
        for life in self.lives:
            works = self._memory.bits.test(life.word, life.mask)
            if life.start is None and proxy in life.proxies and not works:
                self._memory.bits.set(life.word, life.mask)
                self._seen[life.word] |= life.mask
                return life
        return None

    # ---- end -------------------------------------------------------------------------------------

    def ended(self) -> Iterator[Life]:
        """C.END: clears the start bits of modules that have ended, those without `start` by their
        algorithms."""
        done: tuple | None = None
        for word, lives in self._words.items():
            working = self._memory.bits.load(word) & self._seen[word]
            if not working:
                continue
            for life in lives:
                if working & life.mask and not life.executes:
                    at = None if life.start is None else self._done_at.get(life.module.index)
                    if at is not None and done is None:
                        done = self._done()
                    if at is None or done[at]:
                        yield self.clear(life)

    def clear(self, life: Life) -> Life:
        """The start bit of a module becomes 0."""
        self._memory.bits.clear(life.word, life.mask)
        self._rests[life.word] |= life.mask
        return life

    def hold(self, life: Life) -> None:
        """From now on the module stands and its outputs have their safe values, until ``release``."""
        self.stand = life.stands = True
        life.held = self._machine.safe_values(life.runs)

    def release(self) -> None:
        self.stand = False
        for life in self.lives:
            life.stands, life.held = False, []

    def force(self) -> None:
        """Outputs of modules that stand get their safe values; to be called after the logic."""
        for life in self.lives:
            for symbol, value in life.held:
                self._machine.assign(symbol, value)
