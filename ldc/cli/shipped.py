"""The sources of a program as the runtime gets them and gives them back: paths within the project."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path, PurePosixPath

from ldc.cli.console import Failure
from ldc.components import find
from ldc.diagnostics import Diagnostics
from ldc.manifest import Sources
from ldc.source import SourceFile, as_text

Texts = tuple[tuple[str, str], ...]

PROJECT = "project"
"""The folder of a project that is pulled with sources from above it."""

_DEEPEST = 8


def texts_of(sources: Sources) -> Texts:
    """Path and text of every source, of the project file, of the descriptors and of the files in C and C++
    that belong to them, sorted by path."""
    files: list[SourceFile] = [*sources.files, *(source for source, _ in sources.descriptors)]
    if sources.manifest:
        files.append(sources.manifest.source)
    ignored = Diagnostics()  # the compile tells them
    for component in find.components(sources.descriptors, ignored).components.values():
        files += find.own_files(component, ignored).values()
    root = _root(sources)
    return tuple(sorted({_within(root, file): file.text for file in files}.items()))


def name_of(sources: Sources, file: SourceFile) -> str:
    """What a file is called in ``texts_of``."""
    return _within(_root(sources), file)


def _root(sources: Sources) -> Path:
    if sources.manifest:
        return sources.manifest.folder.resolve()
    folders = [Path(f.path).resolve().parent for f in sources.files]
    return Path(os.path.commonpath(folders)) if folders else Path.cwd()


def _within(root: Path, file: SourceFile) -> str:
    return as_text(Path(os.path.relpath(Path(file.path).resolve(), root)).as_posix())


def differences(ours: Iterable[tuple[str, str]], theirs: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Path and what is different about it: ``changed``, ``only here``, ``only in the runtime``."""
    here, there = dict(ours), dict(theirs)
    found = []
    for path in sorted({*here, *there}):
        if path not in there:
            found.append((path, "only here"))
        elif path not in here:
            found.append((path, "only in the runtime"))
        elif here[path] != there[path]:
            found.append((path, "changed"))
    return found


def write(texts: Sequence[tuple[str, str]], folder: Path) -> Path:
    """Writes what a runtime gave into a folder that is new or empty. Sources that lie above the project stay
    there: the project is then as many folders deeper. Where it is. Raises Failure when the folder is neither,
    or a path leads out of it."""
    paths = [PurePosixPath(path).parts for path, _ in texts]
    above = [next((n for n, part in enumerate(parts) if part != ".."), len(parts)) for parts in paths]
    depth = max(above, default=0)
    targets: dict[Path, str] = {}
    for (path, text), parts, ups in zip(texts, paths, above, strict=True):
        rest = parts[ups:]
        target = folder.joinpath(*[PROJECT] * (depth - ups), *rest)
        leads_out = path.startswith("/") or ".." in rest or "\0" in path
        if not rest or leads_out or depth > _DEEPEST or target in targets:
            raise Failure(f"the runtime has a source `{path[:80]}`, which has no place in `{folder}`")
        targets[target] = text
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise Failure(f"`{folder}` is not empty")
        for target, text in targets.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(text.encode("utf-8"))
    except OSError as error:
        raise Failure(f"cannot write to `{folder}`: {error.strerror or error}") from error
    return folder.joinpath(*[PROJECT] * depth)
