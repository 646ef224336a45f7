"""What is wrong when a program becomes firmware, and when firmware runs in QEMU: LD064x."""

from __future__ import annotations

from ldc.components.project import Native
from ldc.diagnostics import Diagnostics
from ldc.similar import similar
from ldc.source import SourceFile, Span


def no_board(diagnostics: Diagnostics, wanted: str, known: list[str]) -> None:
    close = similar(wanted, known, 1)
    hint = f"did you mean `{close[0]}`?" if close else f"there are {', '.join(known)}."
    _board(diagnostics, f"there is no board `{wanted}`", None, "",
           f"{hint} A board file is named with its ending, `my.toml`")


def other_target(diagnostics: Diagnostics, name: str, has: str, target: str) -> None:
    _board(diagnostics, f"board `{name}` has a {has}, not a {target}", None, "", f"build with --target {has}")


def board_lacks(diagnostics: Diagnostics, source: SourceFile, key: str) -> None:
    _board(diagnostics, f"the board has no `{key}`", Span(source, 0, 0), "in this file",
           "docs/firmware.md shows a whole board file")


def _board(diagnostics: Diagnostics, message: str, span: Span | None, label: str, help_: str) -> None:
    diagnostics.error("LD0640", message, span, label, help=help_)


def arm_compiler_failed(diagnostics: Diagnostics, error: Exception) -> None:
    diagnostics.error("LD0641", f"firmware: {error}", None,
                      help="LDC_ARM_CC names the compiler; it must be a gcc for arm-none-eabi with newlib")


def does_not_fit(diagnostics: Diagnostics, board: str, what: str, size: int, over: int) -> None:
    _fit(diagnostics, f"the program does not fit into the {what} of board `{board}`: it has {size:,} bytes, "
         f"{over:,} are missing", "take a board with more memory (--board), or less program")


def call_too_large(diagnostics: Diagnostics, native: Native, size: int, room: int) -> None:
    _fit(diagnostics, f"a call of {native.unit.name} on a slave takes {size:,} bytes of shared memory, which "
         f"has {room:,} for it",
         "give the component smaller inputs, outputs and state, or let the master run it")


def _fit(diagnostics: Diagnostics, message: str, help_: str) -> None:
    diagnostics.error("LD0642", message, None, help=help_)


def no_processor(diagnostics: Diagnostics, native: Native, board: str) -> None:
    component = native.component
    diagnostics.error(
        "LD0646", f"component {component.name} runs on {component.processor}, which board `{board}` has not",
        component.span("function", "processor"), "its processor", help="this board has a master and slave1")


def no_end(diagnostics: Diagnostics, board: str, seconds: float) -> None:
    diagnostics.error("LD0643", f"the firmware did not end in QEMU (`{board}`) within {seconds:g} s", None,
                      help="run fewer scans, or give it more time: LDC_QEMU_TIMEOUT=600")


def trap(diagnostics: Diagnostics, board: str, status: int, pc: int, where: str | None) -> None:
    place = f" at {where}" if where else f" at address {pc:#010x}" if pc else ""
    message = f"the processor of `{board}` stopped by a fault of its own{place}: {_meaning(status)}"
    diagnostics.error("LD0644", message, None,
                      help="a component that writes outside of its memory does this, or "
                      "too deep a call: `stack` in the board file")


def _meaning(status: int) -> str:
    """What the bits of CFSR say (Armv7-M Architecture Reference Manual, B3.2.15)."""
    bits = {0: "code outside of memory", 1: "data access not allowed", 8: "code outside of memory",
            9: "access to memory that is not there", 10: "access to memory that is not there",
            12: "no memory for the stack", 16: "undefined instruction", 17: "jump to no code",
            18: "broken return", 19: "no such coprocessor", 24: "access that is not aligned",
            25: "division by zero"}
    found = [text for bit, text in bits.items() if status >> bit & 1]
    return found[0] if found else f"status {status:#010x}"


def too_much_watched(diagnostics: Diagnostics, board: str) -> None:
    _failed(diagnostics, f"board `{board}` has no memory left to watch so many variables",
            "watch fewer (--watch), or take a board with more memory (--board)")


def qemu_failed(diagnostics: Diagnostics, machine: str, status: int, said: str) -> None:
    lines = said.strip().splitlines() or ["it says nothing"]
    _failed(diagnostics, f"QEMU (`-M {machine}`) ended with status {status}: {lines[-1][:200]}",
            "QEMU 7.2 or newer is needed; LDC_QEMU_ARM names another one")


def _failed(diagnostics: Diagnostics, message: str, help_: str) -> None:
    diagnostics.error("LD0645", message, None, help=help_)
