"""Programs of any size to measure with: the same generator for every tool that is compared."""

from __future__ import annotations

import random
from collections.abc import Iterator
from dataclasses import dataclass


def simple_rungs(count: int) -> str:
    """``count`` rungs of ``(a AND b OR c) AND NOT d``, each with inputs and an output of its own."""
    lines = ["PROGRAM bench", "VAR"]
    for n in range(count):
        for k, name in enumerate("abcd"):
            bit = 4 * n + k
            lines.append(f"    {name}{n} AT %IX{bit // 8}.{bit % 8} : BOOL;")
        lines.append(f"    q{n} AT %QX{n // 8}.{n % 8} : BOOL;")
    lines.append("END_VAR")
    lines += [f"RUNG {{ [a{n}] [b{n}] | [c{n}] }} [/d{n}] (q{n})" for n in range(count)]
    return "\n".join([*lines, "END_PROGRAM", ""])


Contact = tuple[bool, str]
"""Whether it is closed, and its operand."""
Network = tuple["Contact | list[Network]", ...]
"""A series of contacts and of parallels (lists)."""


@dataclass(frozen=True, slots=True)
class Rung:
    """``network`` feeds coil ``m<n>`` through ``block``: ("TON", milliseconds), ("CTU", preset, its
    contact at R) or None."""

    network: Network
    block: tuple | None


def inputs_of(count: int) -> int:
    """How many inputs %IX ``count`` mixed rungs use."""
    return min(4000, 4 * count)


def mixed(count: int, seed: int = 1) -> Iterator[Rung]:
    """``count`` rungs of six contacts in random series and parallel, every 10th with a TON and every
    20th with a CTU: what a plant's program looks like on the average."""
    rng = random.Random(seed)
    inputs = inputs_of(count)
    for n in range(count):
        a, b, c, d, e, f = ((rng.choice(("", "/")) == "/", _operand(rng, inputs, n)) for _ in range(6))
        shape = rng.randrange(3)
        network = (([(a, b), (c,)], d, [(e,), (f,)]), (a, [(b, [(c,), (d,)]), (e,)], f),
                   ([(a,), (b,), (c,)], [(d, e), (f,)]))[shape]
        block: tuple | None = None
        if n % 10 == 0:
            block = "TON", rng.randrange(1, 50) * 100
        elif n % 20 == 5:
            reset = False, _operand(rng, inputs, n)
            block = "CTU", rng.randrange(2, 99), reset
        yield Rung(network, block)


def mixed_rungs(count: int, seed: int = 1) -> str:
    """The rungs of ``mixed`` as ladder text."""
    lines = ["PROGRAM bench", "VAR"]
    lines += [f"    x{n} AT %IX{n // 8}.{n % 8} : BOOL;" for n in range(inputs_of(count))]
    lines += [f"    m{n} : BOOL;" for n in range(count)]
    lines += [f"    t{n} : TON;" for n in range(0, count, 10)]
    lines += [f"    c{n} : CTU;" for n in range(5, count, 20)]
    lines.append("END_VAR")
    for n, rung in enumerate(mixed(count, seed)):
        match rung.block:
            case ("TON", preset):
                block = f" <t{n}: TON(PT := T#{preset}ms)>"
            case ("CTU", preset, reset):
                block = f" <c{n}: CTU(R := {{ {_text((reset,))} }}, PV := {preset})>"
            case _:
                block = ""
        lines.append(f"RUNG {_text(rung.network)}{block} (m{n})")
    return "\n".join([*lines, "END_PROGRAM", ""])


def _text(network: Network) -> str:
    return " ".join(
        f"{{ {' | '.join(map(_text, item))} }}" if isinstance(item, list) else f"[{'/' * item[0]}{item[1]}]"
        for item in network)


def _operand(rng: random.Random, inputs: int, n: int) -> str:
    return f"m{rng.randrange(n)}" if n and rng.random() < 0.3 else f"x{rng.randrange(inputs)}"
