"""`ldc import`: a project of another tool as a project of text files."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from ldc import pipeline, unfinished
from ldc.cli import imported
from ldc.cli.compiling import locator
from ldc.cli.console import OK, WRONG, Failure, InternalFault, UsageError, report, say
from ldc.cli.inputs import read
from ldc.diagnostics import Diagnostics, Invalid
from ldc.manifest import NAME, Sources
from ldc.parser import format_of
from ldc.parser.formats import named
from ldc.records import replace
from ldc.render import plural


def run(options: argparse.Namespace) -> int:
    """What is wrong in the files refuses them, unless what can be read is wanted."""
    folder = Path(options.folder)
    _must_be_free(folder, options.folder)
    sources = read(options.files)
    for source in sources.files:
        if format_of(source) is None and not named(source):
            raise UsageError(f"`{source.path}` is text of this language: it needs no import")
    compiled = _compile(sources)
    wrong, files = compiled.diagnostics.has_errors, compiled.project.files
    if wrong and not (options.keep_going and any(f.pous or f.types or f.globals for f in files)):
        raise Invalid(compiled.diagnostics, locator(compiled))
    report(compiled.diagnostics, locator(compiled))
    unwritable = Diagnostics()
    texts = imported.sources(files, unwritable)
    if unwritable.has_errors:  # what a reader lets pass and a text cannot say, as a reserved word as a name
        report(unwritable)
        wrong = True
        if not options.keep_going:
            return WRONG
    proof = "The source has errors: see the findings for what is missing here."
    if not wrong:
        settings = replace(sources.settings, safe=dict(compiled.model.safe))
        _compare(compiled, Sources(tuple(f.source for f in texts.values()), settings, None))
        proof = f"The project compiles to the same image as its source: digest `{compiled.image.digest}`."
    written = {path: file.source.text for path, file in texts.items()}
    written |= {
        NAME: imported.project_file(folder.resolve().name, files, texts),
        "README.md": imported.readme(folder.resolve().name, files, texts),
        "import-report.md": imported.report(files, texts, [*compiled.diagnostics, *unwritable], proof),
    }
    _write(folder, written)
    say(f"imported {plural(sum(len(f.pous) for f in files), 'POU')} into {plural(len(texts), 'source')} "
        f"in {options.folder}; import-report.md there tells what became of everything")
    say(f"try: ldc check {options.folder}    ldc draw {options.folder}    ldc run {options.folder}")
    return WRONG if wrong else OK


def _must_be_free(folder: Path, shown: str) -> None:
    try:
        unfinished.sweep(folder)  # of an import that was killed
        if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise UsageError(f"`{shown}` is there and not an empty folder; nothing was written")
    except OSError as error:
        raise Failure(f"cannot make `{shown}`: {error.strerror}") from error


def _compile(sources: Sources) -> pipeline.Compiled:
    return pipeline.compile_project(sources, pipeline.Options(verify=False, keep=False))


def _compare(compiled: pipeline.Compiled, sources: Sources) -> None:
    again = _compile(sources)
    if again.image is None or again.image.digest != compiled.image.digest:
        raise InternalFault("the imported project is not the same program as its source",
                            "\n".join(d.message for d in again.diagnostics))


def _write(folder: Path, texts: dict[str, str]) -> None:
    """All files, or none: they come to the folder's place when all are there. An empty folder that is there
    stays the one it is: somebody may be in it."""
    there = folder.is_dir()
    try:
        with unfinished.folder_in(folder if there else folder.parent) as temporary:
            for path, text in texts.items():
                (temporary / path).parent.mkdir(parents=True, exist_ok=True)
                (temporary / path).write_text(text, encoding="utf-8")
            if there:
                for entry in temporary.iterdir():
                    os.replace(entry, folder / entry.name)
            else:
                os.replace(temporary, folder)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise Failure(f"cannot write `{folder}`: {reason}") from error
