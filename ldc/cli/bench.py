"""`ldc bench`: how long a scan takes."""

from __future__ import annotations

import argparse
import json

from ldc.cli.compiling import compiled
from ldc.cli.console import OK
from ldc.cli.inputs import read
from ldc.cli.starting import start
from ldc.parser import ast
from runtime.bench import bench


def run(options: argparse.Namespace) -> int:
    sources = read([options.source])
    result = compiled(sources)
    contacts = sum(_contacts(build.rung) for builds in result.units.values() for build in builds)
    machine = start(result, None, sources.manifest, options.engine)
    figures = bench(machine, contacts, options.stimulus, options.engine)
    if options.json:
        print(json.dumps(figures))
        return OK
    per_contact = figures["ns_per_contact"]
    print(f"engine       {figures['engine']}, stimulus {options.stimulus}")
    print(
        f"scan         {figures['ns_per_scan']:,.0f} ns (median of {figures['scans']:,} scans in batches, "
        f"spread {figures['spread']:.0%})"
    )
    if per_contact is not None:
        print(f"contact      {per_contact:,.1f} ns ({contacts:,} contacts drawn)")
    print(f"state        {figures['state']}")
    return OK


def _contacts(rung: ast.Rung) -> int:
    """Contacts drawn in a rung, those of networks at pins too."""
    count, todo = 0, [item for path in rung.paths for item in path.items]
    while todo:
        match todo.pop():
            case ast.Contact():
                count += 1
            case ast.Branches(paths=paths):
                todo += [item for path in paths for item in path.items]
            case ast.Block(pins=pins):
                todo += [pin.value for pin in pins if isinstance(pin.value, ast.Branches)]
    return count
