"""`ldc component new|check|list|header`: components by themselves."""

from __future__ import annotations

import argparse
import re
import sys
from importlib import resources
from pathlib import Path

from ldc import pipeline
from ldc.cli.compiling import native_code
from ldc.cli.console import OK, Failure, UsageError, report, say
from ldc.cli.output import write_file, write_result
from ldc.components import find, header, host
from ldc.components.descriptor import SUFFIX
from ldc.diagnostics import Diagnostics, Invalid
from ldc.manifest import NAME, Sources, find_sources
from ldc.model.settings import Settings
from ldc.parser.lexer import KEYWORDS
from ldc.reading import missing, read_source
from ldc.render import plural

_ENDINGS = {"c": ".c", "c++": ".cpp", "st": ".st", "il": ".il"}


def run(options: argparse.Namespace) -> int:
    return {"new": _new, "check": _check, "list": _list, "header": _header}[options.action](options)


def _new(options: argparse.Namespace) -> int:
    name, folder = options.name, Path(options.folder)
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]{0,62}", name) or name.upper() in KEYWORDS:
        raise UsageError(f"`{name}` is no name: letters, digits and _, no word of the language")
    small, ending = name.lower(), _ENDINGS[options.language]
    texts = resources.files("ldc.cli") / "component_project"
    filled = {
        "{NAME}": name.upper(),
        "{name}": small,
        "{id}": f"{folder.resolve().name.lower()}.{small}",
        "{language}": options.language,
        "{source}": f"{small}{ending}",
    }
    filled["{id}"] = re.sub(r"[^a-z0-9_.]+", "_", filled["{id}"]).strip("_.")
    files = {
        folder / f"{small}{SUFFIX}": "descriptor.toml",
        folder / f"{small}{ending}": f"{'cpp' if options.language == 'c++' else options.language}.txt",
    }
    for path in files:
        if path.exists():
            raise UsageError(f"`{path}` is there already; nothing was written")
    if not folder.is_dir():
        raise Failure(f"there is no folder `{folder}`")
    for path, template in files.items():
        text = (texts / template).read_text(encoding="utf-8")
        for mark, value in filled.items():
            text = text.replace(mark, value)
        write_file(path, text.encode("utf-8"))
    say(f"made component {name.upper()}: {', '.join(path.as_posix() for path in files)}")
    say(
        f"try: ldc component check {next(iter(files)).as_posix()}    "
        f"in a ladder: <x: {name.upper()}(target := 10.0)>"
    )
    return OK


def _check(options: argparse.Namespace) -> int:
    """Every component is read, typed, rewritten and compiled, whether a program uses it or not."""
    result = _compiled(_sources(options.sources))
    report(result.diagnostics)
    native_code(result)
    say(f"checked {plural(len(result.components), 'component')}: no errors")
    return OK


def _list(options: argparse.Namespace) -> int:
    diagnostics = Diagnostics()
    nothing = not options.sources and not Path(NAME).is_file() and not find.in_folder(Path("."), deep=False)
    descriptors = () if nothing else _sources(options.sources).descriptors
    own = find.components(descriptors, diagnostics).components
    installed = find.components(find.installed(diagnostics), diagnostics).components
    rows = [("NAME", "ID", "VERSION", "LANGUAGE", "PROCESSOR", "WHAT IT DOES")]
    rows += [
        (c.name, c.id, c.version, c.language, c.processor, c.text or c.function)
        for c in {**installed, **own}.values()
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        sys.stdout.write(
            "  ".join(f"{cell:<{width}}" for cell, width in zip(row, widths, strict=True)).rstrip() + "\n"
        )
    return report(diagnostics)


def _header(options: argparse.Namespace) -> int:
    sources = _sources([options.source])
    result = _compiled(sources)
    wanted = {folder / source.path for source, folder in sources.descriptors}
    natives = [n for n in result.natives if n.component.folder / n.component.source.path in wanted]
    if len(natives) != 1:
        raise UsageError(f"`{options.source}` is not the descriptor of one component in C or C++")
    memory = host.memory_of(result.model.globals.values())
    write_result(header.text(natives[0].component, natives[0].unit, memory), options.output)
    return OK


def _compiled(sources: Sources) -> pipeline.Compiled:
    result = pipeline.compile_project(sources,
                                      pipeline.Options(keep=False, every_component=True, algorithms=False))
    if result.diagnostics.has_errors:
        raise Invalid(result.diagnostics)
    return result


def _sources(paths: list[str]) -> Sources:
    """A descriptor stands for itself in the project around it; everything else as for other commands."""
    diagnostics = Diagnostics()
    bare = [Path(p) for p in paths if Path(p).is_dir() and not (Path(p) / NAME).is_file()]
    descriptors = [Path(p) for p in paths if p.lower().endswith(SUFFIX)]
    descriptors += [path for folder in bare for path in find.in_folder(folder, deep=True)]
    others = [p for p in paths if not p.lower().endswith(SUFFIX) and Path(p) not in bare]
    if not paths and (Path(NAME).is_file() or not find.in_folder(Path("."), deep=False)):
        others = ["."]
    elif not paths:
        descriptors = find.in_folder(Path("."), deep=False)
    project = _project_around(descriptors[0]) if descriptors and not others else None
    sources = find_sources(others or ([str(project)] if project else []), diagnostics)
    found = []
    for path in descriptors:
        if not path.is_file():
            missing(str(path), diagnostics)
        elif (source := read_source(path, path.as_posix(), diagnostics)) is not None:
            found.append((source, path.parent))
    if diagnostics.has_errors:
        raise Invalid(diagnostics)
    if not descriptors:
        return sources
    return Sources(sources.files, sources.settings or Settings(), sources.manifest, tuple(found))


def _project_around(path: Path) -> Path | None:
    """The nearest folder with a project file: its globals are what the component may name."""
    return next((folder for folder in path.resolve().parents if (folder / NAME).is_file()), None)
