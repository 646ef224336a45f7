"""`ldc fmt`: .ld and .st sources in their one canonical form."""

from __future__ import annotations

import argparse
from pathlib import Path

from ldc.cli.console import OK, WRONG, report, say
from ldc.cli.inputs import read
from ldc.cli.output import write_file
from ldc.diagnostics import Diagnostics, Severity
from ldc.parser import format_of, parse_file
from ldc.parser.format import format_file
from ldc.render import plural


def run(options: argparse.Namespace) -> int:
    """Files with syntax errors are reported and left as they are; the others are still formatted."""
    diagnostics = Diagnostics()
    changed = total = 0
    # Files have a form whatever they belong to, so several projects may be named here.
    sources = {Path(file.path).resolve(): file for path in options.sources for file in read([path]).files}
    for source in sources.values():
        if not source.path.lower().endswith((".ld", ".st")):
            continue
        if (foreign := format_of(source)) is not None:
            say(f"left as it is: {source.path} is a file of {foreign.name} (ldc import makes text of it)")
            continue
        own = Diagnostics()
        file = parse_file(source, own)
        diagnostics.extend(own)
        if own.has_errors:
            continue
        total += 1
        # What is on the disk counts: line ends and a byte order mark are brought into form as well.
        path, data = Path(source.path), format_file(file).encode("utf-8")
        if path.read_bytes() == data:
            continue
        changed += 1
        say(f"{'would reformat' if options.check else 'reformatted'} {source.path}")
        if not options.check:
            write_file(path, data)
    status = report(d for d in diagnostics if d.severity is Severity.ERROR)
    if total or status == OK:
        say(_summary(changed, total, options.check))
    return WRONG if options.check and changed else status


def _summary(changed: int, total: int, check: bool) -> str:
    if not total:
        return "no .ld or .st files to format"
    if not changed:
        return f"{plural(total, 'file')} in canonical form" if total > 1 else "1 file, in canonical form"
    return f"{plural(changed, 'file')} of {total} {'would change' if check else 'changed'}"
