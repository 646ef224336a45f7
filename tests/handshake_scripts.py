"""Two processors that execute a sequence of the papers with guards: what goes wrong with it, over all
interleavings.

A script is lines of ``set FLAG``, ``clear FLAG``, ``send``, ``check`` or ``wait``, each with a guard or
without: ``set sms if msf=1 msb=0`` is one step, done when the flags are so. Both processors start again from
the top; the master stops after some transfers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from explore import ends, explore

LOST, DUPLICATE, DEADLOCK, EARLY = "lost", "duplicate", "deadlock", "reads before send"


@dataclass(frozen=True)
class Outcome:
    states: int
    failures: frozenset[str]


@dataclass(frozen=True, slots=True)
class State:
    """``sent``: the transfer that lies in the slot; ``begun``: that the master is at; ``seen``: the one whose
    flags the slave has reacted to; ``taken``: those that the slave has taken, in order; ``failed``: what has
    gone wrong."""

    m: int = 0
    s: int = 0
    flags: frozenset[str] = frozenset()
    sent: int = 0
    begun: int = 1
    seen: int = 0
    taken: tuple[int, ...] = ()
    failed: frozenset[str] = frozenset()


def _lines(text: str) -> list[tuple[str, str, dict[str, bool]]]:
    found = []
    for line in text.strip().splitlines():
        action, _, guard = line.strip().partition("if ")
        kind, *name = action.split()
        found.append((kind, " ".join(name), {g[:-2]: g[-1] == "1" for g in guard.split()}))
    return found


def run(master: str, slave: str, transfers: int = 3) -> Outcome:
    """What can go wrong, each path up to its first failure, and the number of states."""
    programs = _lines(master), _lines(slave)

    def step(state: State, who: int) -> State | None:
        at = (state.m, state.s)[who]
        kind, name, guard = programs[who][at]
        if any((flag in state.flags) != value for flag, value in guard.items()):
            return None
        after = (at + 1) % len(programs[who])
        if who == 0:
            new = replace(state, m=after, begun=state.begun + (after == 0))
        else:
            new = replace(state, s=after, seen=state.begun if at == 0 else state.seen)
        match kind:
            case "set":
                return replace(new, flags=new.flags | {name})
            case "clear":
                return replace(new, flags=new.flags - {name})
            case "send":
                return replace(new, sent=state.begun)
            case "check":
                early = frozenset((EARLY,)) if state.sent < state.seen else frozenset()
                return replace(new, taken=(*state.taken, state.sent), failed=early)
        return new

    def judged(state: State) -> State:
        failed = set(state.failed)
        if len(set(state.taken)) < len(state.taken):
            failed.add(DUPLICATE)
        if any(n not in state.taken for n in range(1, state.begun)):
            failed.add(LOST)
        return replace(state, failed=frozenset(failed))

    def moves(state: State) -> list[State]:
        if state.failed:
            return []
        whose = (0, 1) if state.begun <= transfers else (1,)
        return [judged(new) for who in whose if (new := step(state, who)) is not None]

    graph = explore(State(), moves)
    failures = set().union(*(state.failed for state in graph.states))
    if any(not state.failed and (state.begun <= transfers or state.flags) for state in ends(graph)):
        failures.add(DEADLOCK)
    return Outcome(len(graph), frozenset(failures))
