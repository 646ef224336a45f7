"""The benchmark: the same stimuli and states every time, and numbers that mean something."""

from __future__ import annotations

import pytest
from il_build import simple, var

from ldc.types import BYTE, INT
from runtime.bench import bench, scans_of, xorshift64
from runtime.vm.machine import Machine

INPUTS = [var(f"i{n}", at=f"%IX{n // 8}.{n % 8}") for n in range(70)]


def machine(*more) -> Machine:
    code = """LD i0; AND i1; ORN i69; ST q; LD q; AND( i5; XOR i6; ); ST r
        LD n; ADD 1; ST n
        LD i0; JMPCN no; LD h; ADD 1; ST h; LABEL no"""
    return Machine(simple([*INPUTS, var("q"), var("r"), var("n", INT), var("h", INT), *more], code))


@pytest.mark.parametrize("stimulus", ["fixed", "flip", "random"])
def test_the_state_depends_on_the_program_and_the_stimulus_only(stimulus: str) -> None:
    first, second = (bench(machine(), 6, stimulus, batches=3, scans=50) for _ in range(2))
    assert first["state"] == second["state"]
    assert set(first) == {"engine", "scans", "contacts", "ns_per_scan", "ns_per_contact", "spread", "state"}
    assert first["scans"] == 200 and first["engine"] == "vm" and first["contacts"] == 6
    assert 0 < first["ns_per_contact"] == first["ns_per_scan"] / 6
    assert 0 <= first["spread"]


def test_flip_inverts_one_input_after_the_other() -> None:
    m = machine()
    bench(m, 6, "flip", batches=1, scans=1)
    assert m.get("i0") and m.get("i1") and not any(m.get(f"i{n}") for n in range(2, 70))
    m = machine()
    bench(m, 6, "flip", batches=1, scans=36)
    assert (
        not m.get("i0") and not m.get("i1") and all(m.get(f"i{n}") for n in range(2, 70)) and m.get("h") == 70
    )


def test_random_sets_all_inputs_from_the_bits_of_xorshift64() -> None:
    m = machine(var("whole", BYTE, at="%IB8"))
    bench(m, 6, "random", batches=1, scans=1, seed=1)
    state = 1
    for _ in range(2):
        state = xorshift64(state)
        low = state
        state = xorshift64(state)
    bits = low | state << 64
    assert [m.get(f"i{n}") for n in range(70)] == [bool(bits >> n & 1) for n in range(70)]
    assert m.get("whole") == bits >> 64 & 0x3F


def test_xorshift64_is_marsaglias() -> None:
    assert [xorshift64(1), xorshift64(xorshift64(1))] == [1082269761, 1152992998833853505]


def test_batches_shrink_for_large_programs() -> None:
    assert scans_of(0) == 2000 and scans_of(800) == 500 and scans_of(10**9) == 10


def test_an_unknown_stimulus_is_refused() -> None:
    with pytest.raises(ValueError, match="no stimulus noise"):
        bench(machine(), 1, "noise")
