"""What is wrong when a program becomes code of a processor."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.il.program import Unit


def no_body(diagnostics: Diagnostics, unit: Unit) -> None:
    diagnostics.error("LD0630", f"`{unit.name}` is a component in {unit.external.language}, which native code "
                      "cannot call", None, help="run it with --engine vm")


def compiler_failed(diagnostics: Diagnostics, error: Exception) -> None:
    diagnostics.error("LD0631", str(error), None,
                      help="LDC_CC names the compiler and its further options; it must take those of gcc")
