"""Instruction lists of Mitsubishi FX controllers (MELSEC) to ast.File, as ladders."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.source import SourceFile

__all__ = ["is_list", "read"]

_FIRST = re.compile(
    r"""(?:\s++|;[^\n]*|//[^\n]*|\(\*(?s:.*?)\*\))*+(?:\d+[ \t]+)?
        (?:(?:LD|LDI|LDP|LDF)[ \t]+[XYMSTCL]\d+[ \t]*(?:[;/(\n]|\Z) | LDD?[<>=]{1,2}[ \t]
         | NOP[ \t]*(?:[;/(\n]|\Z) | P\d+[ \t]*:?[ \t]*\n)""",
    re.VERBOSE | re.IGNORECASE)


def is_list(source: SourceFile) -> bool:
    """Whether the first line that says something is an instruction with a device of such a controller:
    Instruction List of IEC 61131-3 begins with a heading."""
    return _FIRST.match(source.text) is not None


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The list as one PROGRAM (codes LD0150 to LD0153)."""
    from ldc.parser.melsec.program import Program

    return Program(source, diagnostics).file()
