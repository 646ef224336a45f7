"""Run-time faults that the meaning of a function can end in."""

from __future__ import annotations


class DivisionByZero(ZeroDivisionError):
    """DIV or MOD by zero: of integers, REAL, LREAL and TIME alike (DESIGN section 4)."""

    def __init__(self) -> None:
        super().__init__("division by zero")
