"""Where generated Python may keep variables: what a read, a write and a rung cost (docs/adr/0006).

The same rungs of six contacts and a coil, on 500 and on 4,000 variables in random order. Best of several
rounds, in which the four ways alternate.
"""

from __future__ import annotations

import random
import time

import _tables

RUNGS, ROUNDS = 1000, 40
WAYS = ("globals", "slots", "list", "dict")


def _name(way: str, n: int) -> str:
    return {"globals": f"v{n}", "slots": f"s.v{n}", "list": f"s[{n}]", "dict": f"s['v{n}']"}[way]


def _function(way: str, count: int, lines: list[str], values: list[bool]):
    """A function of these lines, in which ``{n}`` stands for variable n, on variables of its own."""
    names = [f"v{n}" for n in range(count)]
    keys = [_name(way, n) for n in range(count)]
    space: dict[str, object] = {}
    head = "def scan(s=s):"
    match way:
        case "globals":
            space |= zip(names, values, strict=True)
            head = f"def scan():\n global {', '.join(names)}"
        case "slots":
            space["s"] = holder = type("Variables", (), {"__slots__": tuple(names)})()
            for name, value in zip(names, values, strict=True):
                setattr(holder, name, value)
        case "list":
            space["s"] = list(values)
        case "dict":
            space["s"] = dict(zip(names, values, strict=True))
    exec("\n".join([head, *(" " + line.format(*keys) for line in lines)]), space)
    return space["scan"]


def _times(count: int, lines: list[str]) -> list[float]:
    """Nanoseconds per line, for each way."""
    values = [random.random() < 0.5 for _ in range(count)]
    functions = [_function(way, count, lines, values) for way in WAYS]
    best = [float("inf")] * len(WAYS)
    for _ in range(ROUNDS):
        for n, function in enumerate(functions):
            start = time.perf_counter_ns()
            function()
            best[n] = min(best[n], (time.perf_counter_ns() - start) / len(lines))
    return best


def main() -> None:
    random.seed(1)
    columns = [_times(500, ["{3}"] * RUNGS), _times(500, ["{3} = True"] * RUNGS)]
    for count in (500, 4000):
        rungs = []
        for _ in range(RUNGS):
            a, b, c, d, e, f, q = (f"{{{random.randrange(count)}}}" for _ in range(7))
            rungs.append(f"{q} = ({a} or {b}) and not {c} and ({d} or {e} and {f})")
        columns.append(_times(count, rungs))
    rows = [[way, *(f"{column[n]:.1f} ns" for column in columns)] for n, way in enumerate(WAYS)]
    _tables.show("variables of generated Python", ["kept as", "read", "write", "rung of 500", "rung of 4,000"], rows)


if __name__ == "__main__":
    main()
