"""The findings about statements, LD042x: one function raises each code."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics, Label
from ldc.model.type_findings import described
from ldc.source import Span
from ldc.types import Type


def label_twice(diagnostics: Diagnostics, span: Span, first: Span) -> None:
    diagnostics.error("LD0420", "two labels of this CASE hold the same value", span,
                      "it would never be chosen", secondary=(Label(first, "chosen already here"),),
                      help="give every value to one label")


def bad_label(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0421", message, span, label, help=help)


def bad_selector(diagnostics: Diagnostics, span: Span, type_: Type) -> None:
    diagnostics.error("LD0422", "CASE chooses by an integer or an enumeration", span,
                      f"this is {described(type_)}", help="use IF ... ELSIF for other types")


def bad_variable(diagnostics: Diagnostics, span: Span, label: str, help: str) -> None:
    diagnostics.error("LD0423", "FOR counts with an integer variable", span, label, help=help)


def zero_step(diagnostics: Diagnostics, span: Span) -> None:
    diagnostics.error("LD0424", "a FOR by 0 never ends", span, "the step is 0",
                      help="count by another number")


def variable_written(diagnostics: Diagnostics, span: Span, name: str, head: Span) -> None:
    diagnostics.warning("LD0425", f"`{name}` is written in the FOR that counts with it", span, "written here",
                        secondary=(Label(head, "counted here"),),
                        help="use EXIT to leave the loop, or WHILE for a loop that counts by itself")
