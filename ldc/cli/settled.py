"""What of `ldc.toml` a change of the running program brings along, and what stays as the runtime was started
(docs/online.md, "What of ldc.toml").

The runtime remembers the settings that it was started with and does not change; whoever stages, or asks
whether what runs is what is here, compares.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ldc.diagnostics import Diagnostic, Diagnostics
from ldc.durations import duration_text
from ldc.manifest import Manifest
from ldc.source import SourceFile, Span
from ldc.toml_tables import parse_toml

_FILES = ("run.inputs", "plant.file", "plant.parameters")
"""Settings that name files, whose contents count too."""

_STAYS = ("run.period", "run.retain", "run.retain_every", "memory.image_bytes", "plant.step", "plant.seed",
          *_FILES)
_TABLES = ("processors", "cost", "watchdogs")
"""Whole tables that stay."""

_NAMED = ("messages", "tasks")
"""Sections whose keys are tables, each a thing of its own."""

WATCH = "run.watch"
"""Stays when what is shown goes into a trace, or was named with --watch."""


def fixed(manifest: Manifest | None, watch: bool = False) -> dict[str, str]:
    """The settings that stay, by `section.key`: their values as JSON, empty for those that are not given; of
    files also digests of the contents, by `section.key#`. ``watch``: what is watched stays too."""
    data = _values(manifest.source) if manifest is not None else {}
    found = {key: _text(data.get(key)) for key in (*_STAYS, *((WATCH,) if watch else ()))}
    for table in _TABLES:
        rows = {key: value for key, value in data.items() if key.startswith(f"{table}.")}
        found[table] = _text(rows or None)
    for key in _FILES:
        found[f"{key}#"] = _contents(manifest.folder / str(data[key])) if key in data else ""
    return found


def told(options: argparse.Namespace) -> dict[str, str]:
    """What the command line said instead of the project, by option, as it is written there."""
    return {option: value for option, value in _optional(options).items() if value}


def _optional(said: argparse.Namespace | Manifest | None) -> dict[str, str]:
    """Settings for which there are options, by option; empty for those that are not given."""
    values = ((name, said and getattr(said, name)) for name in ("period", "inputs", "retain", "retain_every"))
    return {f"--{name.replace('_', '-')}": duration_text(value) if isinstance(value, int) else str(value or "")
            for name, value in values}


def options_of(begun: Mapping[str, str]) -> list[str]:
    """Those of ``told`` that a runtime was started with, as a command line has them."""
    return [f"{key} {value}" for key, value in begun.items() if key.startswith("--")]


def stays(manifest: Manifest | None, begun: Mapping[str, str]) -> list[Diagnostic]:
    """A warning (LD0863) for every setting that is another one than ``begun``, with which the runtime was
    started: the program that runs does not take it."""
    found = Diagnostics()
    for name, label in _differing(manifest, begun):
        found.warning("LD0863", f"{_shown(name)} stays as it was when the runtime was started",
                      _span(manifest, name), label,
                      help="it counts from the next start on; what else has changed can be staged")
    return list(found)


def drift(manifest: Manifest | None, begun: Mapping[str, str]) -> list[Diagnostic]:
    """An error (LD0866) for every setting here that is not what the runtime was started with."""
    found = Diagnostics()
    overridden = {_setting(option) for option in begun if option.startswith("--")}
    differing = (row for row in _differing(manifest, begun) if row[0] not in overridden)
    for name, label in (*differing, *_overridden(manifest, begun)):
        found.error("LD0866", f"{_shown(name)} is not what the runtime was started with",
                    _span(manifest, name), label, help="it counts from the next start of the runtime on")
    return list(found)


def _overridden(manifest: Manifest | None, begun: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """Settings for which the command line said something else."""
    for option, here in _optional(manifest).items():
        if option in begun and begun[option] != here:
            yield _setting(option), f"it was started with `{option} {begun[option]}`"


def _setting(option: str) -> str:
    """What the project calls an option."""
    return f"run.{option[2:].replace('-', '_')}"


def _differing(manifest: Manifest | None, begun: Mapping[str, str]) -> Iterator[tuple[str, str]]:
    """The settings that are other ones than ``begun``, and what is different."""
    ours = fixed(manifest, watch=True)
    for key, was in begun.items():
        name = key.rstrip("#")
        if key.startswith("--"):
            continue  # an option is none of the project
        if ours.get(key, "") == was or name != key and ours.get(name) != begun.get(name):
            continue  # the same; or another file, which was told
        if name != key:
            label = "the file has other contents now"
        elif key in _TABLES and was:
            label = "it was another one then"
        else:
            label = f"it was {was[:80]} then" if was else "it was not given then"
        yield name, label


def brought(running: str, coming: str, begun: Mapping[str, str]) -> list[str]:
    """The settings that come with a change, as people know them: those that differ between the texts of the
    project files of the program that runs and of the one that is to, and do not stay."""
    return [_shown(key) for key in changed(running, coming)
            if key not in begun and key.partition(".")[0] not in begun]


def changed(before: str, after: str) -> list[str]:
    """The settings that two texts of a project file give differently, by `section.key`."""
    there, here = (_values(SourceFile("ldc.toml", text)) for text in (before, after))
    return [key for key in dict.fromkeys((*here, *there)) if here.get(key) != there.get(key)]


def _values(source: SourceFile) -> dict[str, Any]:
    """Values by `section.key`, in the order of the file. Nothing for a text that is no project file."""
    data = parse_toml(source, Diagnostics()) or {}
    return dict(_pairs(data))


def _pairs(data: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for section, table in data.items():
        if not isinstance(table, dict) or not table:
            yield section, table
        else:
            yield from ((f"{section}.{key}", value) for key, value in table.items())


def _text(value: object) -> str:
    return "" if value is None else json.dumps(value, default=str)


def _contents(path: Path) -> str:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()[:12]
    except OSError:
        return "-"


def _shown(key: str) -> str:
    section, _, name = key.partition(".")
    if not name:
        return f"[{section}]"
    return f"[{key}]" if section in _NAMED else f"[{section}] {name}"


def _span(manifest: Manifest | None, key: str) -> Span | None:
    """Where the setting stands; else where its table, else the file begins."""
    if manifest is None:
        return None
    section, _, name = key.partition(".")
    entry = manifest.spans.get((section, name)) or manifest.spans.get((section,))
    return entry.value if entry else Span(manifest.source, 0, 0)
