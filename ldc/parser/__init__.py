"""The text language: source to ast.File, and back (unparse, format)."""

from __future__ import annotations

from ldc.parser.reader import parse_expression, parse_file

__all__ = ["parse_expression", "parse_file"]
