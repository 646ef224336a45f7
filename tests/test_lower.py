"""What rungs become: instruction by instruction, few and in the right order (DESIGN sections 3 and 4)."""

from __future__ import annotations

import pytest
from test_verify import build

from ldc.il import text as il_text

CASES = {
    "seal_in": "{ [a] | [q] } [/b] (q)",
    "power is computed once, coils in a row": "[a] (q) (z) [b] (f)",
    "two coils at taps": "[a] { [b] (q) | [c] (z) }",
    "the bridge has one temporary": "{ [a] @x [b] | [c] @y [d] } (q); @x [e] @y",
    "rising edge": "[a] [P b] (q)",
    "edge coil": "[a] (P q)",
    "timer": "[a] <t: TON(PT := T#1s)> (q)",
    "counter with a network": "[a] <n: CTU(R := { [b] | [c] }, PV := i, CV => j)> (q)",
    "a function under power": "[a] <ADD(IN1 := i, IN2 := 1, OUT => j)> (q)",
    "a function without a condition": "<ADD(IN1 := i, IN2 := 1, OUT => j)> (q)",
    "a division reports zero at ENO": "[a] <DIV(IN1 := i, IN2 := j, OUT => k)> (q)",
    "a comparison is plain power": "[i > j] { [a] | [i + 1 < k] } (q)",
    "what may fault waits for power": "[j <> 0] [i / j > 2] (q)",
    "a value on a junction": "[a] <ADD(IN1 := i, IN2 := 1, OUT => @s)> (q); <MOVE(IN := @s, OUT => k)>",
    "jumps come last": "{ [a] (q) >>other | [b] (z) >>RETURN }",
    "a loop remembers": "[a] @w <t: TON(PT := T#1s)> @m (q); @m [/b] @w",
}


def test_listings(golden) -> None:
    parts = []
    for title, rung in CASES.items():
        result, made = build(rung)
        listing = il_text.print_unit(result.program.unit("p"), result.program.units)
        body = listing[listing.index('(* rung "r1"'):listing.index('(* rung "other"')]
        parts.append(f"(* {title}: {made.verdict.kind} of {made.verdict.operands} *)\n"
                     f"(* {rung} *)\n{body.split('*)', 1)[1].strip(chr(10))}\n")
    golden("lower/listings.il", "\n".join(parts))


def ladder(steps: int) -> str:
    """Two chains side by side with a contact from one to the other after every step."""
    paths = ["[a] @t0; [b] @u0"]
    paths += [f"@t{i} [a] @t{i + 1}; @u{i} [b] @u{i + 1}; @t{i + 1} [c] @u{i + 1}" for i in range(steps)]
    return ";\n".join([*paths, f"@u{steps} (q)"])


@pytest.mark.parametrize("steps", [3, 30, 300])
def test_networks_that_are_no_series_and_parallel_stay_linear(steps: int) -> None:
    _, made = build(ladder(steps))
    assert len(made.code.code) <= 8 * steps + 8
    assert made.verdict.kind == "proof"
