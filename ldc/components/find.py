"""The components that a project may use: descriptors in its folder, and those of installed packages."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from ldc.components import findings
from ldc.components.descriptor import SUFFIX, Component, load
from ldc.diagnostics import Diagnostics
from ldc.patterns import Pattern
from ldc.reading import read_source
from ldc.records import record
from ldc.source import SourceFile

_QUOTED = Pattern(r'^[ \t]*#[ \t]*include[ \t]*"([^"\n]+)"', re.MULTILINE)
GROUP = "ldc.components"
"""The entry point group. The value of an entry point is a package; the descriptors lie in its folder."""


@record
class Known:
    """Components by name in capitals, and the descriptors that are wrong."""

    components: dict[str, Component]
    broken: tuple[SourceFile, ...] = ()


def components(sources: Iterable[tuple[SourceFile, Path]], diagnostics: Diagnostics) -> Known:
    """The components of descriptors (text, folder). Names and ids are unique."""
    found: dict[str, Component] = {}
    ids: dict[str, Component] = {}
    broken: list[SourceFile] = []
    for source, folder in sources:
        made = load(source, folder, diagnostics)
        if made is None:
            broken.append(source)
            continue
        same_name, same_id = found.get(made.name.upper()), ids.get(made.id.upper())
        if same_name is not None:
            findings.twice(
                diagnostics,
                made.span("component", "name"),
                f"name `{made.name}`",
                same_name.span("component", "name"),
            )
        elif same_id is not None:
            findings.twice(
                diagnostics, made.span("component", "id"), f"id `{made.id}`", same_id.span("component", "id")
            )
        else:
            found[made.name.upper()], ids[made.id.upper()] = made, made
            continue
        broken.append(source)
    return Known(found, tuple(broken))


def in_folder(folder: Path, deep: bool) -> list[Path]:
    """Descriptors below a folder, sorted; those in folders whose name begins with a dot are left out."""
    pattern = f"**/*{SUFFIX}" if deep else f"*{SUFFIX}"
    hits = (path for path in folder.glob(pattern) if path.is_file())
    return sorted(
        path for path in hits if not any(part.startswith(".") for part in path.relative_to(folder).parts)
    )


def installed(diagnostics: Diagnostics) -> Iterator[tuple[SourceFile, Path]]:
    """The descriptors of every package that registers some, those of ldc itself first."""
    # Slow to load, and most projects bring all that they use.
    from importlib import metadata, resources

    points = sorted(metadata.entry_points(group=GROUP), key=lambda point: (point.name != "ldc", point.name))
    for point in points:
        try:
            folder = Path(str(resources.files(point.value)))
        except (ImportError, TypeError) as error:
            findings.broken_package(diagnostics, point.name, point.value, str(error))
            continue
        for path in in_folder(folder, deep=True):
            source = read_source(path, str(path), diagnostics)
            if source is not None:
                yield source, path.parent


def body_sources(component: Component, diagnostics: Diagnostics) -> tuple[SourceFile, ...] | None:
    """The files of a component's body, or None with findings. They lie inside the descriptor's folder."""
    found = []
    root = component.folder.resolve()
    at = component.span("function", "sources")
    for name in component.sources:
        path = component.folder / name
        if not path.resolve().is_relative_to(root):
            findings.no_source(
                diagnostics, at, component.name, name, "it lies outside of the component's folder"
            )
            return None
        if not path.is_file():
            findings.no_source(diagnostics, at, component.name, name, "there is no such file")
            return None
        source = read_source(path, path.as_posix(), diagnostics)
        if source is None:
            return None
        found.append(source)
    return tuple(found)


def quoted(text: str) -> list[str]:
    """The names that a C source includes in quotes."""
    return _QUOTED.findall(text)


def own_files(component: Component, diagnostics: Diagnostics) -> dict[str, SourceFile]:
    """The sources of a C or C++ component and the headers of its folder that they include, by absolute path:
    all that its code is made from beside its descriptor."""
    root = component.folder.resolve()
    todo = list(body_sources(component, diagnostics) or ())
    found = {str(Path(source.path).resolve()): source for source in todo}
    while todo:
        source = todo.pop()
        for name in quoted(source.text):
            for folder in (Path(source.path).parent, component.folder):
                path = (folder / name).resolve()
                if str(path) in found or not path.is_relative_to(root) or not path.is_file():
                    continue
                header = read_source(path, (folder / name).as_posix(), diagnostics)
                if header is not None:
                    found[str(path)] = header
                    todo.append(header)
    return found
