"""What is wrong with how a project says that its modules work together (LD0614 to LD0625)."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.source import Span


class Findings:
    """Reports to a bag; ``wrong`` tells whether it did."""

    def __init__(self, diagnostics: Diagnostics) -> None:
        self._diagnostics = diagnostics
        self.wrong = False

    def _error(self, code: str, message: str, span: Span | None, label: str, help: str) -> None:
        self.wrong = True
        self._diagnostics.error(code, message, span, label, help=help)

    def no_module(self, span: Span | None, name: str, label: str, help: str) -> None:
        self._error("LD0614", f"`{name}` is no module of this project", span, label, help)

    def cannot_start(self, span: Span | None, name: str, label: str) -> None:
        self._error("LD0615", f"module `{name}` cannot be started", span, label,
                    "declare `VAR_INPUT start : BOOL;` and `VAR_OUTPUT done : BOOL;` in the module")

    def bad_parameter(self, span: Span | None, message: str, label: str, help: str) -> None:
        self._error("LD0616", message, span, label, help)

    def no_bool(self, span: Span | None, what: str, path: str, label: str, help: str) -> None:
        self._error("LD0617", f"{what} needs a BOOL, and `{path}` is none", span, label, help)

    def bad_data(self, span: Span | None, message: str, label: str, help: str) -> None:
        self._error("LD0618", message, span, label, help)

    def bad_message(self, span: Span | None, name: str, label: str, help: str) -> None:
        self._error("LD0619", f"message `{name}` cannot be what is written", span, label, help)

    def too_much(self, span: Span | None, message: str, label: str, help: str) -> None:
        self._error("LD0621", message, span, label, help)

    def bad_plant(self, span: Span | None, path: str, label: str, help: str) -> None:
        self._error("LD0622", f"cannot use `{path}` for the plant", span, label, help)

    def unheard(self, span: Span | None, name: str) -> None:
        self._diagnostics.warning("LD0623", f"nobody hears message `{name}`", span, "no subscriber",
                                  help='name those who get it: to = ["inject"]')

    def no_steps(self, span: Span | None) -> None:
        self._error("LD0624", "the sequence has no steps", span, "no module can be started",
                    "name steps, or give modules of [project] `VAR_INPUT start : BOOL;` and "
                    "`VAR_OUTPUT done : BOOL;`")

    def misses_scans(self, span: Span | None, message: str, name: str, label: str) -> None:
        self._error("LD0625", f"a flag of message `{message}` could be missed by module `{name}`", span,
                    label, "let a task without an interval run the module, or start it by the message: leave "
                    "`flag` out")
