"""IL as text: printed for other IEC 61131-3 compilers, and read back."""

from __future__ import annotations

from ldc.il.printer import print_program, print_unit
from ldc.il.reader import parse_unit

__all__ = ["parse_unit", "print_program", "print_unit"]
