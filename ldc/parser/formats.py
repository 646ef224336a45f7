"""The formats of other tools that are read as they are; each is known by its content.

A format is a package beside this module with ``recognises(source) -> bool``, cheap, and
``read(source, diagnostics) -> ast.File``. What a reader imports is loaded when a file needs it.
"""

from __future__ import annotations

from collections.abc import Callable

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, classicladder, l5x, ldmicro, melsec, openplc, plcopen
from ldc.records import record
from ldc.source import SourceFile, Span


@record
class Format:
    """``name`` as people call it; ``suffixes`` (lower case) that its files usually have. ``position``: of
    the drawn element that begins at a span, in words; None when the line says it. ``settled``: the files of
    one project, changed by what only all of them tell."""

    name: str
    suffixes: tuple[str, ...]
    recognises: Callable[[SourceFile], bool]
    read: Callable[[SourceFile, Diagnostics], ast.File]
    position: Callable[[Span], str] | None = None
    settled: Callable[[tuple[ast.File, ...], Diagnostics], tuple[ast.File, ...]] | None = None


FORMATS: tuple[Format, ...] = (
    Format("L5X", (".l5x",), l5x.recognises, l5x.read),
    Format("PLCopen XML", (".xml",), plcopen.is_xml, plcopen.read, plcopen.position),
    Format("OpenPLC", (".ld", ".fbd", ".json"), openplc.is_openplc, openplc.read, openplc.position,
           openplc.settled),
    Format("LDmicro", (".ld",), ldmicro.recognises, ldmicro.read),
    Format("ClassicLadder", (".clp", ".clprj"), classicladder.recognises, classicladder.read),
    Format("MELSEC", (".il", ".csv", ".txt"), melsec.is_list, melsec.read, None, melsec.settled),
)
"""Asked in this order."""

SUFFIXES = tuple(dict.fromkeys(suffix for format in FORMATS for suffix in format.suffixes))


_TEXTS = (".ld", ".il")
"""Endings that text of this project has too."""


def format_of(source: SourceFile) -> Format | None:
    """The foreign format of a source, None for the text languages of this project."""
    return next((format for format in FORMATS if format.recognises(source)), None)


def settled(files: tuple[ast.File, ...], diagnostics: Diagnostics) -> tuple[ast.File, ...]:
    """All files of a project, those of each format as they are together."""
    formats = [format_of(file.source) for file in files]
    for format in FORMATS:
        own = [at for at, known in enumerate(formats) if known is format and format.settled]
        if own:
            made = dict(zip(own, format.settled(tuple(files[at] for at in own), diagnostics), strict=True))
            files = tuple(made.get(at, file) for at, file in enumerate(files))
    return files


def named(source: SourceFile) -> tuple[Format, ...]:
    """The formats that the ending of a path promises; none for endings of text."""
    ending = next((s for s in SUFFIXES if source.path.lower().endswith(s)), None)
    return tuple(f for f in FORMATS if ending in f.suffixes) if ending not in _TEXTS else ()


def not_as_named(source: SourceFile, promised: tuple[Format, ...], diagnostics: Diagnostics) -> ast.File:
    """A file that begins otherwise than files of its name do (LD0609): nothing of it is read."""
    names = " or ".join(f.name for f in promised)
    at = len(source.text) - len(source.text.lstrip())
    diagnostics.error("LD0609", f"this is no file of {names}",
                      Span(source, at, min(at + 1, len(source.text))),
                      "not how such a file begins",
                      help=f"save it again in {names}, or give it the ending of what it is")
    return ast.File(source, (), (), (), (), (), True)
