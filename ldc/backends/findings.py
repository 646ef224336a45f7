"""What is wrong when a program becomes code of a processor."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics


def compiler_failed(diagnostics: Diagnostics, error: Exception) -> None:
    diagnostics.error("LD0630", str(error), None,
                      help="LDC_CC names the compiler and its further options; it must take those of gcc")
