"""Diagnostics: what is wrong, where, and what to do about it (DESIGN section 9)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import StrEnum

from ldc.records import field, record
from ldc.source import Span


class Severity(StrEnum):
    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@record
class Label:
    """Says what is there, at a place."""

    span: Span
    text: str = ""


@record
class Place:
    """Where in a drawing a label is: the POU, the rung (number, name), the element and its position there,
    in words; empty what is not known. ``picture(width, colour)``: lines that show the rung."""

    pou: str
    rung: str = ""
    element: str = ""
    position: str = ""
    picture: Callable[[int, bool], list[str]] | None = field(default=None, compare=False)


Locate = Callable[[Span, str], Place | None]
"""The place of a span in a drawing, None when it is in none; marked in the picture with a style."""


@record
class Diagnostic:
    """One finding. ``code`` is stable (``LD0301``), ``help`` says what to do. ``about``: the path of a
    variable or the name of a task, when who tells it has no sources."""

    code: str
    message: str
    primary: Label | None = None
    secondary: tuple[Label, ...] = ()
    help: str = ""
    severity: Severity = Severity.ERROR
    about: str = ""

    @property
    def sort_key(self) -> tuple[str, int, str, str]:
        at = self.primary.span if self.primary else None
        return (at.source.path if at else "", at.start if at else -1, self.code, self.message)


class Diagnostics:
    """The bag that a stage adds findings to. Grows only; never printed from here."""

    def __init__(self) -> None:
        self._items: dict[tuple, Diagnostic] = {}

    def add(self, diagnostic: Diagnostic) -> None:
        self._items.setdefault(diagnostic.sort_key, diagnostic)

    def error(
        self, code: str, message: str, span: Span | None = None, label: str = "",
        *, secondary: Iterable[Label] = (), help: str = "",
    ) -> None:
        self._report(Severity.ERROR, code, message, span, label, secondary, help)

    def warning(
        self, code: str, message: str, span: Span | None = None, label: str = "",
        *, secondary: Iterable[Label] = (), help: str = "",
    ) -> None:
        self._report(Severity.WARNING, code, message, span, label, secondary, help)

    def note(
        self, code: str, message: str, span: Span | None = None, label: str = "",
        *, secondary: Iterable[Label] = (), help: str = "",
    ) -> None:
        self._report(Severity.NOTE, code, message, span, label, secondary, help)

    def _report(self, severity, code, message, span, label, secondary, help) -> None:
        primary = Label(span, label) if span else None
        self.add(Diagnostic(code, message, primary, tuple(secondary), help, severity))

    def extend(self, other: Iterable[Diagnostic]) -> None:
        for diagnostic in other:
            self.add(diagnostic)

    def __iter__(self):
        """Sorted by file, place, code; none repeated."""
        return iter(sorted(self._items.values(), key=lambda d: d.sort_key))

    def __len__(self) -> int:
        return len(self._items)

    @property
    def has_errors(self) -> bool:
        return any(d.severity is Severity.ERROR for d in self._items.values())


class Invalid(Exception):
    """The input is wrong and the caller cannot go on; carries the findings, and what finds them in
    drawings."""

    def __init__(self, diagnostics: Iterable[Diagnostic], locate: Locate | None = None) -> None:
        self.diagnostics, self.locate = tuple(diagnostics), locate
        super().__init__("; ".join(f"{d.code} {d.message}" for d in self.diagnostics))
