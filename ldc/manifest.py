"""The project file `ldc.toml`, and which sources the arguments of a command mean.

[project]     name, version, sources (globs), modules (names in order)
[processors]  name = "master" | "slave"
[tasks.NAME]  interval, priority, watchdog, programs, processor
[memory]      image_bytes (of each of %I, %Q and %M)
[safe]        output = value that it takes after a fault
[run]         period, watch, inputs, retain, retain_every
[cost]        instruction, ...: what execution takes in virtual time (docs/scheduling.md)
[watchdogs]   slave1, ...: what the algorithms of a period may take there

The tables of how modules work together are in `ldc/coordination.py`.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta, Struct

from ldc import coordination
from ldc.components.find import in_folder
from ldc.coordination import CoordinationSettings
from ldc.diagnostics import Diagnostics
from ldc.durations import parse_duration
from ldc.model.settings import Settings, TaskSetting
from ldc.parser.formats import SUFFIXES
from ldc.patterns import Pattern
from ldc.reading import missing, read_source
from ldc.records import field, record
from ldc.source import SourceFile, Span, as_text
from ldc.toml_spans import Entry
from ldc.toml_tables import Tables, parse_toml

NAME = "ldc.toml"
EXTENSIONS = tuple(dict.fromkeys((".ld", ".st", ".il", *SUFFIXES)))
_SHARED = (".csv", ".txt")
"""Endings that data and notes have too: such a file is a source where a glob or an argument names them."""
OPENPLC = "project.json"
_POU_ENDINGS = (".ld", ".fbd", ".st", ".il", ".py", ".cpp")

_NO_SLAVE = Pattern(r"slave(?![1-4]$)\d+")
_SLAVE, _SLAVES = re.compile(r"slave[1-4]"), 4

Name = Annotated[str, Meta(min_length=1)]
Role = Literal["master", "slave"]
SafeValue = bool | Annotated[int, Meta(ge=-(1 << 63), le=(1 << 63) - 1)] | float | str


class ProjectTable(Struct):
    name: Name = ""
    version: str = "0.1.0"
    sources: Annotated[tuple[Name, ...], Meta(min_length=1)] = ("**/*.ld", "**/*.st", "**/*.il")
    modules: tuple[Name, ...] = ()


class TaskTable(Struct):
    interval: Name | None = None
    priority: Annotated[int, Meta(ge=0, le=65535)] = 0
    watchdog: Name | None = None
    programs: tuple[Name, ...] = ()
    processor: Name = "master"


class MemoryTable(Struct):
    image_bytes: Annotated[int, Meta(ge=1, le=1 << 20)] = 1024


class RunTable(Struct):
    period: Name | None = None
    watch: tuple[Name, ...] = ()
    inputs: Name | None = None
    retain: Name | None = None
    retain_every: Name | None = None


class CostTable(Struct):
    instruction: Name | None = None
    arithmetic: Name | None = None
    comparison: Name | None = None
    function: Name | None = None
    call: Name | None = None
    task: Name | None = None
    frame: Name | None = None
    word: Name | None = None
    algorithm: Name | None = None
    algorithms: dict[Name, Name] = {}


@record
class Manifest:
    """A project file, checked. Durations are nanoseconds; globs and paths are as written, relative to
    `folder`. `processors`: name to role. `cost`: keys of `[cost]` that are given, None: no such table.
    `watchdogs`: of slaves, by their numbers.
    `spans`: where the keys stand, for findings of later stages."""

    source: SourceFile
    folder: Path
    name: str
    version: str
    sources: tuple[str, ...]
    modules: tuple[str, ...]
    processors: dict[str, str]
    tasks: tuple[TaskSetting, ...]
    image_bytes: int
    safe: dict[str, SafeValue]
    period: int | None
    watch: tuple[str, ...]
    inputs: str | None
    retain: str | None
    retain_every: int | None
    coordination: CoordinationSettings
    cost: dict[str, int | dict[str, int]] | None
    watchdogs: dict[int, int]
    spans: dict[tuple[str | int, ...], Entry] = field(repr=False)

    @property
    def settings(self) -> Settings:
        """What the model needs to know."""
        return Settings(image_bytes=self.image_bytes, tasks=self.tasks, modules=self.modules, safe=self.safe)

    def value_span(self, *path: str | int) -> Span | None:
        entry = self.spans.get(path)
        return entry.value if entry else None


@record
class Sources:
    """What the arguments of a command mean: files in a fixed order, settings, the project file if any.
    ``descriptors``: those of components, each with its folder."""

    files: tuple[SourceFile, ...]
    settings: Settings
    manifest: Manifest | None
    descriptors: tuple[tuple[SourceFile, Path], ...] = ()


def find_sources(paths: Iterable[str | Path], diagnostics: Diagnostics) -> Sources:
    """Read what the arguments name: sources, an `ldc.toml`, or folders with one; or the folder or
    `project.json` of an OpenPLC project, which means that file and those under `pous`.

    Files keep the order of the arguments, those of a project that of its globs; a file that is named
    twice is read once. What cannot be read is left out, with a finding.
    """
    found: dict[Path, str] = {}
    manifests: dict[Path, Manifest] = {}
    for argument in map(str, paths):
        path = Path(argument)
        if os.path.isdir(argument):
            name = next((name for name in (NAME, OPENPLC) if (path / name).is_file()), None)
            if name is None:
                _no_manifest(path, argument, diagnostics)
                continue
            path = path / name
        if path.name.lower() == OPENPLC and path.is_file():
            found = {_real(p): _shown(p) for p in _openplc_files(path)} | found
        elif path.suffix.lower() in EXTENSIONS:
            found.setdefault(_real(path), argument)
        elif path.suffix.lower() == ".toml" and not path.name.lower().endswith(".ldc.toml"):
            if _real(path) not in manifests:
                source = read_source(path, _shown(path), diagnostics)
                manifest = load_manifest(source, path.parent, diagnostics) if source else None
                if manifest:
                    manifests[_real(path)] = manifest
                    found.update({_real(p): _shown(p) for p in _project_files(manifest, diagnostics)})
        elif not os.path.exists(argument):
            missing(argument, diagnostics)
        else:
            _unknown_kind(path, argument, diagnostics)
    if len(manifests) > 1:
        first, second = list(manifests.values())[:2]
        diagnostics.error(
            "LD0608",
            f"two projects at once: `{first.source.path}` and `{second.source.path}`",
            help="name one of them; files of the other can be named one by one",
        )
    files = [read_source(path, shown, diagnostics) for path, shown in found.items()]
    manifest = next(iter(manifests.values()), None)
    settings = manifest.settings if manifest else Settings()
    descriptors = _descriptors(found, manifest, diagnostics)
    return Sources(tuple(f for f in files if f), settings, manifest, descriptors)


def _descriptors(
    files: Iterable[Path], manifest: Manifest | None, diagnostics: Diagnostics
) -> tuple[tuple[SourceFile, Path], ...]:
    """Those in the folder of the project, or beside files that are named alone."""
    folders = [(manifest.folder, True)] if manifest else [
        (folder, False) for folder in sorted({f.parent for f in files})]
    paths = [path for folder, deep in folders for path in in_folder(folder, deep)]
    read = ((read_source(path, _shown(path), diagnostics), path.parent) for path in paths)
    return tuple((source, folder) for source, folder in read if source is not None)


def load_manifest(source: SourceFile, folder: Path, diagnostics: Diagnostics) -> Manifest | None:
    """The project file as checked values, or None (with findings) when anything in it is wrong."""
    data = parse_toml(source, diagnostics)
    if data is None:
        return None
    before = len(diagnostics)
    tables = Tables(source, data, diagnostics)
    tables.check_sections(("project", "processors", "tasks", "memory", "safe", "run", "cost", "watchdogs",
                           *coordination.SECTIONS))
    project = tables.table(("project",), ProjectTable)
    memory = tables.table(("memory",), MemoryTable)
    run = tables.table(("run",), RunTable)
    processors = {
        name: tables.value(("processors", name), value, Role)
        for name, value in tables.mapping("processors").items()
    } or {"master": "master"}
    safe = {
        name: tables.value(("safe", name), value, SafeValue) for name, value in tables.mapping("safe").items()
    }
    tasks = tuple(_task(name, tables, processors) for name in tables.mapping("tasks"))
    period = _duration(tables, ("run", "period"), run.period) if run.period else None
    retain_every = _duration(tables, ("run", "retain_every"), run.retain_every) if run.retain_every else None
    together = coordination.read(tables, _duration)
    cost = _cost(tables) if "cost" in data else None
    _check_modules(tables, project.modules)
    _check_processors(tables, processors)
    watchdogs = _watchdogs(tables, processors)
    if len(diagnostics) > before:
        return None
    for task in tasks:
        if task.watchdog is not None and cost is None:
            span = tables.spans["tasks", task.name, "watchdog"].value
            diagnostics.warning("LD0832", f"the watchdog of task `{task.name}` never comes", span,
                                "executions take no time", help="say in [cost] what an instruction takes")
    return Manifest(
        source,
        folder,
        project.name or as_text(folder.resolve().name),
        project.version,
        project.sources,
        project.modules,
        processors,
        tasks,
        memory.image_bytes,
        safe,
        period,
        run.watch,
        run.inputs,
        run.retain,
        retain_every,
        together,
        cost,
        watchdogs,
        tables.spans,
    )


def _task(name: str, tables: Tables, processors: dict[str, str]) -> TaskSetting:
    path = ("tasks", name)
    table = tables.table(path, TaskTable)
    interval = _duration(tables, (*path, "interval"), table.interval) if table.interval else None
    if table.processor not in processors:
        tables.wrong(
            (*path, "processor"),
            f"task `{name}` runs on `{table.processor}`, which is no processor of this project",
            f"processors: {', '.join(processors)}",
        )
    watchdog = _duration(tables, (*path, "watchdog"), table.watchdog) if table.watchdog else None
    return TaskSetting(name, interval, table.priority, table.programs, table.processor, watchdog)


def _cost(tables: Tables) -> dict[str, int | dict[str, int]]:
    """Nanoseconds by key; of algorithms by name of the unit, as written."""
    table = tables.table(("cost",), CostTable)
    found: dict[str, int | dict[str, int]] = {
        name: _duration(tables, ("cost", name), text) for name in CostTable.__struct_fields__
        if name != "algorithms" and (text := getattr(table, name)) is not None}
    algorithms = {unit: _duration(tables, ("cost", "algorithms", unit), text)
                  for unit, text in table.algorithms.items()}
    return {**found, "algorithms": algorithms} if algorithms else found


def _watchdogs(tables: Tables, processors: Mapping[str, str]) -> dict[int, int]:
    """How long all algorithms that are due together on a slave may take, in ns, by its number."""
    given = tables.mapping("watchdogs")
    if not given:
        return {}
    from ldc.components.pace import slaves  # most projects name no slave

    known, found = {f"slave{number}": number for number in sorted(slaves(processors))}, {}
    for name, value in given.items():
        path = ("watchdogs", name)
        if name.lower() not in known:
            tables.wrong(path, f"`{name}` is no slave of this project",
                         f"slaves: {', '.join(known) or 'none'}; tasks of the master have `watchdog` in "
                         "[tasks]")
            continue
        found[known[name.lower()]] = _duration(tables, path, tables.value(path, value, Name))
    return found


def _duration(tables: Tables, path: tuple[str, ...], text: str) -> int:
    """Nanoseconds of a duration that must be greater than 0."""
    value = parse_duration(text)
    if value is None or value <= 0:
        tables.wrong(
            path, f"`{text}` is not a time greater than zero", "write a number and a unit: 500us, 10ms, 1s"
        )
    return value or 1


def _check_modules(tables: Tables, modules: Sequence[str]) -> None:
    """The place of a module in the list is its index, so a name may stand there once."""
    for index, name in enumerate(modules):
        if name.upper() in (other.upper() for other in modules[:index]):
            tables.wrong(
                ("project", "modules"), f"module `{name}` is listed twice", "the order gives each its index"
            )


def _check_processors(tables: Tables, processors: dict[str, str]) -> None:
    masters = [name for name, role in processors.items() if role == "master"]
    if len(masters) != 1 and None not in processors.values():
        tables.wrong(
            ("processors",),
            f"a project has one master, this one has {', '.join(masters) or 'none'}",
            'give the role "master" to one processor and "slave" to the others',
        )
    for name, role in processors.items():
        if role == "slave" and _NO_SLAVE.fullmatch(name.lower()):
            tables.wrong(("processors", name), f"`{name}` is no number of a slave",
                         "slave1 to slave4 have that number, a slave of another name the next free one")
    slaves = [name for name, role in processors.items() if role == "slave"]
    for name in sorted(slaves, key=lambda name: _SLAVE.fullmatch(name.lower()) is None)[_SLAVES:]:
        tables.wrong(("processors", name), f"`{name}` is one slave too many: a project has {_SLAVES} at most",
                     "let another slave execute its algorithms")


def _project_files(manifest: Manifest, diagnostics: Diagnostics) -> list[Path]:
    """The files that the globs of a project mean, each once: globs that are written in their order, with
    what each finds sorted by path; what the usual ones find sorted all together."""
    files: dict[Path, None] = {}

    def by_path(path: Path) -> tuple[str, ...]:
        return path.relative_to(manifest.folder).parts

    for pattern in manifest.sources:
        try:
            hits = [
                path
                for path in manifest.folder.glob(pattern)
                if _is_source(path, pattern) and path.is_file() and not _hidden(path, manifest.folder)
            ]
        except (ValueError, NotImplementedError, IndexError):
            hits = []
        explicit = manifest.value_span("project", "sources")
        if not hits and explicit:
            diagnostics.error(
                "LD0613",
                f"`{pattern}` matches no source",
                explicit,
                f"looked in `{_shown(manifest.folder)}`",
                help="sources are .ld, .st and .il files; folders whose name begins with a dot are left out",
            )
        files |= dict.fromkeys(sorted(hits, key=by_path))
    written = manifest.value_span("project", "sources")
    if not files and not written:
        diagnostics.error(
            "LD0607",
            f"the project `{manifest.name}` has no sources",
            help=f"put a .ld file beside `{manifest.source.path}`, or name the sources under [project]",
        )
    return list(files) if written else sorted(files, key=by_path)


def _openplc_files(project: Path) -> list[Path]:
    """The file of an OpenPLC project and those of its POUs, sorted by path."""
    pous = (path for path in (project.parent / "pous").rglob("*")
            if path.suffix.lower() in _POU_ENDINGS and path.is_file())
    return [project, *sorted(pous)]


def _is_source(path: Path, pattern: str = "") -> bool:
    """Whether a file that a glob finds is one by its ending."""
    ending = path.suffix.lower()
    return ending in EXTENSIONS and (ending not in _SHARED or pattern.lower().endswith(ending))


def _hidden(path: Path, folder: Path) -> bool:
    return any(part.startswith(".") and part != ".." for part in path.relative_to(folder).parts)


def _real(path: Path) -> Path:
    try:
        return path.resolve()
    except (OSError, RuntimeError, ValueError):
        return path


def _shown(path: Path) -> str:
    return path.as_posix()


def _no_manifest(folder: Path, argument: str, diagnostics: Diagnostics) -> None:
    try:
        inside = sorted(entry.name for entry in folder.iterdir() if _is_source(entry))
    except OSError:
        inside = []
    help = f"`ldc new {argument}` makes a project in an empty folder"
    if inside:
        more = ", ..." if len(inside) > 3 else ""
        help = f"name its sources ({', '.join(inside[:3])}{more}), or write an {NAME} (it may be empty)"
    diagnostics.error("LD0606", f"the folder `{argument}` has no {NAME}", help=help)


def _unknown_kind(path: Path, argument: str, diagnostics: Diagnostics) -> None:
    kind = f"`{path.suffix}` files" if path.suffix else "files without an extension"
    diagnostics.error(
        "LD0605",
        f"cannot compile `{argument}`: ldc does not read {kind}",
        help=f"sources end in {', '.join(EXTENSIONS)}; a project is an {NAME} or a folder with one",
    )
