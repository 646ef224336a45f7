"""`ldc explain CODE`: the page of a diagnostic."""

from __future__ import annotations

import argparse
import sys

from ldc.cli.console import OK, UsageError, is_terminal, wants_color
from ldc.codes import nearest, page


def run(options: argparse.Namespace) -> int:
    found = page(options.code.strip("[]"))
    if found is None:
        close = [f"{other.code} ({other.title})" for other in map(page, nearest(options.code)) if other]
        raise UsageError(f"no page `{options.code}`" + (f"; near it: {', '.join(close)}" if close else ""))
    if is_terminal(sys.stdout):
        from rich.console import Console
        from rich.markdown import Markdown

        Console(no_color=not wants_color(sys.stdout)).print(Markdown(found.text, code_theme="ansi_dark"))
    else:
        sys.stdout.write(found.text)
    return OK
