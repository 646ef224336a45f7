"""Instruction lists of Mitsubishi controllers (MELSEC) to ast.File, as ladders."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.melsec.table import first_step
from ldc.patterns import Pattern
from ldc.source import SourceFile

__all__ = ["is_list", "read", "settled"]

_FIRST = Pattern(
    r"""(?>(?:\s++|;[^\n]*|//[^\n]*|\(\*(?s:.*?)\*\))*)(?:\d+[ \t]+)?
        (?:(?:LD|LDI|LDP|LDF)[ \t]+(?:[XYB][0-9A-F]+|(?:[MTCLF]|S[MT]?)\d+|[DW]\d+\.[0-9A-F])
            [ \t]*(?:[;/(\n]|\Z)
            | LDD?[<>=]{1,2}[ \t]
         | NOP[ \t]*(?:[;/(\n]|\Z) | P\d+[ \t]*:?[ \t]*\n)""",
    re.VERBOSE | re.IGNORECASE)


def is_list(source: SourceFile) -> bool:
    """Whether the first line that says something is an instruction with a device of such a controller
    (Instruction List of IEC 61131-3 begins with a heading), or a table of GX Works begins."""
    return _FIRST.match(source.text) is not None or first_step(source) is not None


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The list as one PROGRAM (codes LD0150 to LD0153)."""
    from ldc.parser.melsec.program import Program

    return Program(source, diagnostics).file()


def settled(files: tuple[ast.File, ...], diagnostics: Diagnostics) -> tuple[ast.File, ...]:
    """The lists of one project, which share their devices."""
    from ldc.parser.melsec import together

    return together.settled(files, diagnostics)
