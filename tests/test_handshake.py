"""The transfer U* between processors: nothing lost, nothing twice, whatever the order of steps (SPEC 2.3)."""

from __future__ import annotations

import subprocess
from pathlib import Path

import cffi
import native
import pytest

from ldc.components import toolchain

pytestmark = native.needs_gcc
ROOM = Path(__file__).resolve().parents[1] / "ldc" / "backends" / "firmware" / "runtime"


@pytest.fixture(scope="module")
def driver(tmp_path_factory: pytest.TempPathFactory):
    target = tmp_path_factory.mktemp("handshake") / "driver.so"
    sources = Path(__file__).with_name("p_driver.c"), ROOM / "p_handshake.c"
    flags = "-std=c11 -O2 -Wall -Wextra -Werror -fPIC -shared -pthread".split()
    command = [toolchain.find(toolchain.GCC), *flags, "-I", str(ROOM), "-o", str(target), *map(str, sources)]
    subprocess.run(command, check=True)
    ffi = cffi.FFI()
    ffi.cdef("uint16_t p_crc(uint16_t, const uint8_t *, uint32_t); uint32_t two_threads(uint32_t);"
             "uint32_t random_order(uint32_t, uint64_t, uint32_t); int32_t refused(uint32_t);")
    return ffi.dlopen(str(target))


def test_the_checksum_is_that_of_modbus(driver) -> None:
    assert driver.p_crc(0xFFFF, b"123456789", 9) == 0x4B37


@pytest.mark.parametrize("seed", (1, 2, 3, 4))
def test_every_message_arrives_once_and_in_order(driver, seed: int) -> None:
    assert driver.random_order(100_000, seed * 7919, 0) == 0


def test_damaged_data_are_sent_again(driver) -> None:
    """One of fifty is damaged, so that no message is damaged three times by this seed."""
    assert driver.random_order(20_000, 12345, 20) == 0


def test_two_processors_at_once(driver) -> None:
    assert driver.two_threads(10_000) == 0


@pytest.mark.parametrize("code", (1, 2, 3, 4, 8, 10, 11))
def test_what_is_wrong_with_a_message_is_told(driver, code: int) -> None:
    assert driver.refused(code) == code
