"""Programs of any size to measure with: the same generator for every tool that is compared."""

from __future__ import annotations

import random


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


def mixed_rungs(count: int, seed: int = 1) -> str:
    """``count`` rungs of six contacts in random series and parallel, every 10th with a TON and every
    20th with a CTU: what a plant's program looks like on the average."""
    rng = random.Random(seed)
    inputs = min(4000, 4 * count)
    lines = ["PROGRAM bench", "VAR"]
    lines += [f"    x{n} AT %IX{n // 8}.{n % 8} : BOOL;" for n in range(inputs)]
    lines += [f"    m{n} : BOOL;" for n in range(count)]
    lines += [f"    t{n} : TON;" for n in range(0, count, 10)]
    lines += [f"    c{n} : CTU;" for n in range(5, count, 20)]
    lines.append("END_VAR")
    for n in range(count):
        contacts = [f"[{rng.choice(('', '/'))}{_operand(rng, inputs, n)}]" for _ in range(6)]
        a, b, c, d, e, f = contacts
        shape = rng.randrange(3)
        network = (f"{{ {a} {b} | {c} }} {d} {{ {e} | {f} }}", f"{a} {{ {b} {{ {c} | {d} }} | {e} }} {f}",
                   f"{{ {a} | {b} | {c} }} {{ {d} {e} | {f} }}")[shape]
        block = f" <t{n}: TON(PT := T#{rng.randrange(1, 50)}00ms)>" if n % 10 == 0 else (
            f" <c{n}: CTU(R := {{ {_contact(rng, inputs, n)} }}, PV := {rng.randrange(2, 99)})>" if n % 20 == 5 else "")
        lines.append(f"RUNG {network}{block} (m{n})")
    return "\n".join([*lines, "END_PROGRAM", ""])


def _operand(rng: random.Random, inputs: int, n: int) -> str:
    return f"m{rng.randrange(n)}" if n and rng.random() < 0.3 else f"x{rng.randrange(inputs)}"


def _contact(rng: random.Random, inputs: int, n: int) -> str:
    return f"[{_operand(rng, inputs, n)}]"
