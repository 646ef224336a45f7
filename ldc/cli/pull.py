"""`ldc pull`: the sources of the program that runs, or whether those here are the same."""

from __future__ import annotations

import argparse
from pathlib import Path

from ldc.cli import link, settled, shipped
from ldc.cli.console import say
from ldc.cli.inputs import read
from ldc.diagnostics import Diagnostics, Invalid
from ldc.render import plural, visible
from runtime.online.wire import Pull


def run(options: argparse.Namespace) -> int:
    """Raises Invalid (LD0830, LD0866) with --check when anything differs."""
    sources = read(options.sources)
    answer = link.ask(link.runtime_of(options, sources), Pull())
    texts = answer.sources or []
    if not options.check:
        place = shipped.write(texts, Path(options.folder))
        say(visible(f"{plural(len(texts), 'file')} of program {answer.state.digest[:12]} in {place}"))
        return 0
    found = shipped.differences(shipped.texts_of(sources), texts)
    diagnostics = Diagnostics()
    for path, what in found:
        diagnostics.error("LD0830", f"`{path}` is not what runs: {what}",
                          help="`ldc pull -o DIR` gives what runs; `ldc online stage` makes this run")
    against = [*diagnostics, *settled.drift(sources.manifest, answer.settings)]
    if against:
        raise Invalid(against)
    say(f"{plural(len(texts), 'file')}, all as in program {answer.state.digest[:12]}, "
        f"settings {answer.state.settings[:12]}")
    return 0
