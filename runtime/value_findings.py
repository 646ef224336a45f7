"""Why a value cannot be forced, set, read or traced: each code in one place (docs/commissioning.md)."""

from __future__ import annotations

from ldc.diagnostics import Diagnostic, Diagnostics


def _one(code: str, message: str, help: str) -> Diagnostic:
    found = Diagnostics()
    found.error(code, message, help=help)
    return next(iter(found))


def no_value(action: str, path: str, why: object) -> Diagnostic:
    """``action``: force, set, read, trace; ``why``: of the path or of the value."""
    return _one("LD0855", f"cannot {action} `{path[:100]}`: {why}",
                "name one value, as in `motor`, `warm.Q`, `conveyor.warm.Q` or `%QX0.0`, and give it what "
                "its type takes")


def force_lost(path: str, old: object, new: object | None) -> Diagnostic:
    what = f"is {old} in the running program and {new} in the new one" if new else "is not in the new program"
    return _one("LD0856", f"`{path}` is forced and {what}", "let it go with `ldc online unforce` first")


def bad_trigger(text: str, why: str) -> Diagnostic:
    return _one("LD0857", f"`{text[:100]}` is no trigger: {why}",
                'write a variable and what becomes of it: "motor rises", "motor falls", "level > 80.0", '
                '"state = filling"')


def not_forced(path: str) -> Diagnostic:
    return _one("LD0858", f"`{path[:100]}` is not forced", "`ldc online forces` lists what is")


def too_much(what: str, help: str) -> Diagnostic:
    return _one("LD0859", what, help)
