"""The rungs of ``_programs.mixed`` as a person would write them in C for speed: bytes, ``&`` and ``|``, no branch."""

from __future__ import annotations

from collections.abc import Sequence

from _programs import Network, Rung, inputs_of, mixed

_HEAD = """#include <stdint.h>
typedef struct {{ uint8_t in, q, running; int64_t pt, et, start; }} ton;
typedef struct {{ uint8_t cu, r, q, last; int16_t pv, cv; }} ctu;
typedef struct {{ int64_t now; uint8_t x[{inputs}], m[{count}]; ton t[{count}]; ctu c[{count}]; }} plant;

static inline void run_ton(ton *t, int64_t now) {{
    int64_t keep = -(int64_t)(t->running & t->in);
    t->start = (t->start & keep) | (now & ~keep);
    t->running = t->in;
    int64_t elapsed = now - t->start;
    elapsed = elapsed < t->pt ? elapsed : t->pt;
    t->et = elapsed > 0 ? elapsed : 0;
    t->q = (t->et >= t->pt) & t->in;
}}

static inline void run_ctu(ctu *c) {{
    uint8_t up = c->cu & !c->last & (c->cv < 32767);
    c->last = c->cu;
    c->cv = (int16_t)((c->cv + up) & -!c->r);
    c->q = c->cv >= c->pv;
}}

uint64_t size(void) {{ return sizeof(plant); }}
uint8_t *inputs(plant *p) {{ return p->x; }}
uint8_t *results(plant *p) {{ return p->m; }}
void scan(plant *p) {{
"""


def yardstick(count: int, seed: int = 1) -> str:
    """C with ``scan``, which executes all rungs on a ``plant``."""
    lines = [line for n, rung in enumerate(mixed(count, seed)) for line in _rung(n, rung)]
    return _HEAD.format(inputs=inputs_of(count), count=count) + "\n".join(f"    {line}" for line in lines) + "\n}\n"


def _rung(n: int, rung: Rung) -> Sequence[str]:
    power = _series(rung.network)
    if rung.block is None:
        return (f"p->m[{n}] = {power};",)
    type_, preset = rung.block[:2]
    if type_ == "TON":
        at = f"p->t[{n}]"
        return (f"{at}.in = {power};", f"{at}.pt = INT64_C({preset * 1_000_000});", f"run_ton(&{at}, p->now);",
                f"p->m[{n}] = {at}.q;")
    at = f"p->c[{n}]"
    return (f"{at}.cu = {power};", f"{at}.r = {_contact(rung.block[2])};", f"{at}.pv = {preset};", f"run_ctu(&{at});",
            f"p->m[{n}] = {at}.q;")


def _series(network: Network) -> str:
    return " & ".join(f"({' | '.join(map(_series, item))})" if isinstance(item, list) else _contact(item)
                      for item in network)


def _contact(contact: tuple[bool, str]) -> str:
    closed, name = contact
    return f"{'!' if closed else ''}p->{name[0]}[{name[1:]}]"
