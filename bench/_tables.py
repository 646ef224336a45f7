"""One way to print figures: the machine's noise (min and max) stands beside every median."""

from __future__ import annotations

import statistics
from collections.abc import Sequence

from rich.console import Console
from rich.table import Table


def show(title: str, columns: Sequence[str], rows: Sequence[Sequence[str]], note: str = "") -> None:
    """Prints a table; ``note`` says how to read it."""
    table = Table()
    for n, column in enumerate(columns):
        table.add_column(column, justify="left" if n == 0 else "right", no_wrap=True)
    for row in rows:
        table.add_row(*row)
    console = Console(width=110, highlight=False)
    console.print(title, style="bold")
    console.print(table)
    if note:
        console.print(note + "\n")


def spread(values: Sequence[float], digits: int = 2, unit: str = "") -> str:
    """``median (min .. max) unit``."""
    low, high = min(values), max(values)
    text = f"{statistics.median(values):.{digits}f} ({low:.{digits}f} .. {high:.{digits}f})"
    return f"{text} {unit}" if unit else text


def verdict(value: float, bound: float, at_least: bool) -> str:
    """``ok`` or by how much the figure misses what we ask of it."""
    good = value >= bound if at_least else value <= bound
    sign = ">=" if at_least else "<="
    return f"{'ok' if good else 'NOT REACHED'} ({sign} {bound:g})"
