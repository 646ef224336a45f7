"""The findings about IL text, LD07xx: one function raises each code."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics, Label
from ldc.source import Span


def unknown_instruction(diagnostics: Diagnostics, span: Span, text: str, help: str) -> None:
    diagnostics.error("LD0701", f"there is no instruction or function `{text}`", span, "unknown instruction",
                      help=help or "an IL line is `label: OPERATOR operand` or the name of a function")


def operand_missing(diagnostics: Diagnostics, span: Span, op: str, what: str) -> None:
    diagnostics.error("LD0702", f"`{op}` needs {what}", span, "nothing follows", help=f"write `{op} name`")


def malformed(diagnostics: Diagnostics, span: Span, message: str, help: str) -> None:
    diagnostics.error("LD0703", message, span, "does not belong here", help=help)


def unbalanced(diagnostics: Diagnostics, span: Span, label: str, help: str) -> None:
    diagnostics.error("LD0704", "the parentheses do not balance", span, label, help=help)


def unknown_label(diagnostics: Diagnostics, span: Span, name: str, help: str) -> None:
    diagnostics.error("LD0705", f"there is no label `{name}` in this POU", span, "jumps to nowhere",
                      help=help or f"write `{name}:` before the instruction that is meant")


def duplicate_label(diagnostics: Diagnostics, span: Span, name: str, first: Span) -> None:
    diagnostics.error("LD0706", f"label `{name}` stands twice in this POU", span, "again here",
                      secondary=(Label(first, "first here"),),
                      help="rename one of the two and the jumps to it")


def undefined(diagnostics: Diagnostics, span: Span, op: str) -> None:
    diagnostics.error("LD0707", f"`{op}` has no value to work on", span, "the accumulator is undefined here",
                      help="load a value by LD first; CAL, JMP and RET leave none behind, nor does a label "
                           "to which a way comes without one")


def wrong_types(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str = "") -> None:
    diagnostics.error("LD0708", message, span, label, help=help)


def not_simple(diagnostics: Diagnostics, span: Span, what: str) -> None:
    diagnostics.error("LD0709", f"{what} must be a variable or a literal in IL", span,
                      "this is an expression",
                      help="compute it before by instructions of its own and store it in a variable")


def not_callable(diagnostics: Diagnostics, span: Span, op: str, label: str) -> None:
    diagnostics.error("LD0710", f"`{op}` calls instances of function blocks", span, label,
                      help="declare an instance, `timer : TON;`; functions are called by their name alone")


def inside_parentheses(diagnostics: Diagnostics, span: Span, op: str, opened: Span) -> None:
    diagnostics.error("LD0711", f"{op} may not stand within parentheses", span, "between ( and )",
                      secondary=(Label(opened, "opened here"),),
                      help="close the parentheses before, or keep the value in a variable")


def too_deep(diagnostics: Diagnostics, span: Span, most: int) -> None:
    diagnostics.error("LD0712", f"parentheses nest deeper than {most} levels", span, "one level too deep",
                      help="keep values in between in variables")
