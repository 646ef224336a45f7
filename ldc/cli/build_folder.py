"""What builds of all targets have: the build before, the places of variables, the sources in the folder."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from ldc.cli.console import Failure
from ldc.cli.output import write_file
from ldc.il import image
from ldc.il.block import Block, Spot
from ldc.il.homes import direct_addresses
from ldc.il.layout import state


def before(folder: Path, image_name: str, about_name: str) -> tuple[image.Layout | None, dict[str, int]]:
    """Layout and areas of the build before in this folder; of one that cannot be read nothing is kept."""
    try:
        found = json.loads((folder / about_name).read_bytes())["areas"]
        layout = image.load((folder / image_name).read_bytes()).layout
        return layout, {area: size
                        for area, size in found.items() if isinstance(size, int) and 0 < size <= 1 << 20}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None, {}


def places(block: Block) -> Iterable[tuple[str, dict[str, object]]]:
    """Path, type and place of every variable."""
    return ((path, _place(spot)) for path, spot in _variables(block))


def _variables(block: Block) -> Iterable[tuple[str, Spot]]:
    for variable in block.program.globals:
        yield variable.name, block.variable(variable.name, variable)
    for address in direct_addresses(block.units.values()):
        yield address, block.direct(address)
    for run in block.program.resources[block.resource].runs:
        for variable in state(block.units[run.pou.upper()]):
            path = f"{run.name}.{variable.name}"
            yield path, block.variable(path, variable)


def _place(spot: Spot) -> dict[str, object]:
    where: dict[str, object] = {"type": str(spot.type), "offset": spot.offset}
    return where if spot.bit is None else where | {"bit": spot.bit}


def write_sources(wanted: Mapping[str, str], folder: Path) -> None:
    """Files by name; other C in the folder is of an older build and goes. Raises Failure."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for old in folder.glob("*.[ch]"):
            if old.name not in wanted:
                old.unlink()
    except OSError as error:
        raise Failure(f"cannot write `{folder}`: {error.strerror}") from error
    for name, text in wanted.items():
        write_file(folder / name, text.encode())
