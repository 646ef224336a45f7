"""The table of `ldc online watch` on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ldc.cli.console import wants_color
from runtime.online.wire import Answer
from runtime.values import milliseconds


@contextmanager
def shown() -> Iterator[Callable[[Answer], None]]:
    """Shows each answer in the place of the one before; the last one stays."""
    console = Console(no_color=not wants_color(sys.stdout), highlight=False)
    with Live(console=console, auto_refresh=False) as live:
        yield lambda answer: live.update(_table(answer), refresh=True)


def _table(answer: Answer) -> Table:
    title = f"after {answer.scan} scans, {milliseconds(answer.now_ns)} ms; Ctrl-C ends"
    table = Table(title=title, title_justify="left", title_style="bold", header_style="dim", box=SIMPLE_HEAD,
                  min_width=len(title))
    table.add_column("variable")
    table.add_column("type", style="dim")
    table.add_column("value", justify="right")
    for value in answer.values:
        on = value.type == "BOOL" and value.value == "1"
        table.add_row(Text(value.path), value.type, Text(value.shown, "bold green" if on else ""))
    return table
