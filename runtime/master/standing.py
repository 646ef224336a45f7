"""What stands in a master after a fault or in an emergency, and what leads back (SPEC 2.5, 5)."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ldc.il.areas import areas
from runtime import units
from runtime.machine import Machine
from runtime.master.findings import LinkFault, SlaveAnew
from runtime.master.mail import Mail
from runtime.master.modules import Life, Modules
from runtime.master.proxy import Proxy
from runtime.processors.states import BEGUN_ANEW
from runtime.protocol.check import Code
from runtime.protocol.memory import Memory, bit

Tell = Callable[[str, int, str], None]


class Standing:
    """Over the modules, algorithms and messages of one program. ``tell`` is given units as they happen: name,
    index, detail."""

    def __init__(self, memory: Memory, modules: Modules, proxies: Sequence[Proxy], mail: Mail, tell: Tell
                 ) -> None:
        self._memory, self._modules, self._proxies, self._mail = memory, modules, proxies, mail
        self._tell = tell

    def request(self, proxy: Proxy) -> None:
        """AFR: the algorithm has been asked for and has not ended."""
        word, mask = bit(_AFR + proxy.placed.aid - 1)
        (self._memory.bits.set if proxy.executing else self._memory.bits.clear)(word, mask)

    def link_fails(self, proxy: Proxy, machine: Machine) -> LinkFault:
        """P has given a transfer up: the module stands, its outputs are safe, the others go on."""
        self.request(proxy)
        proxy.tell_error(proxy.fault)
        for life in self._modules.lives:
            if proxy in life.proxies:
                self._abort(life)
        self._mail.raise_system("P_FAULT", proxy.placed.aid | proxy.fault << 16)
        return LinkFault(proxy.placed.slave, proxy.placed.path, proxy.fault, machine.scans, machine.now_ns)

    def begins_anew(self, proxy: Proxy, machine: Machine) -> SlaveAnew | None:
        """A slave has begun anew, in `serror`, and knows nothing of what it executed. None when all that is
        known already."""
        slave = proxy.placed.slave
        if all(other.error == BEGUN_ANEW for other in self._proxies if other.placed.slave == slave):
            return None
        proxy.error = BEGUN_ANEW
        self.slave_fails(proxy)
        for other in self._proxies:
            if other.placed.slave == slave:
                other.tell_error(BEGUN_ANEW)
        return SlaveAnew(slave, machine.scans, machine.now_ns)

    def slave_fails(self, proxy: Proxy) -> None:
        """A slave is in `serror`: all that it executed has ended, without a word of each algorithm."""
        for other in self._proxies:
            if other.placed.slave == proxy.placed.slave:
                other.give_up()
                self.request(other)
        for life in self._modules.lives:
            if not life.stands and any(proxy.blocked for proxy in life.proxies):
                self._abort(life)
        self._mail.raise_system("ALARM", proxy.error << 16 | proxy.placed.aid)

    def _abort(self, life: Life) -> None:
        if self._memory.bits.test(life.word, life.mask):
            self._modules.clear(life)
            self._tell(units.C_END, life.module.index, "abort")
        for proxy in life.proxies:
            proxy.blocked = True
            proxy.stop()
        self._modules.hold(life)

    def everything(self, causes: Sequence[tuple[str, int]]) -> None:
        """An emergency has begun: no module is in work, no algorithm is wanted, no message waits but those
        that tell why."""
        for life in self._modules.lives:
            self._modules.clear(life)
            self._modules.hold(life)
        for proxy in self._proxies:
            proxy.give_up()
            self.request(proxy)
        self._mail.clear()
        for name, value in causes:
            self._mail.raise_system(name, value)

    def release(self) -> tuple[Proxy, ...]:
        """Modules can be started again, the links of slaves with a fault are made new: the algorithms of
        those."""
        faulty = {p.placed.slave for p in self._proxies if p.blocked or p.fault is not Code.OK}
        self._modules.release()
        renewed = tuple(proxy for proxy in self._proxies if proxy.placed.slave in faulty)
        for proxy in renewed:
            proxy.renew()
        return renewed


_AFR = areas()["AFR"].base
