"""Diagnostics for machines: a JSON array, and SARIF 2.1.0 for code scanners."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ldc import __version__
from ldc.codes import page
from ldc.diagnostics import Diagnostic, Label

_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def json_report(diagnostics: Iterable[Diagnostic]) -> str:
    """One array of objects with `code`, `severity`, `message`, `help`, `primary` (null when a finding has no
    place) and `secondary`; places have `file`, `line`, `column`, `end_line`, `end_column` (from 1, the end
    is the first character after) and `label`."""
    items = [
        {
            "code": d.code,
            "severity": d.severity.value,
            "message": d.message,
            "help": d.help,
            "primary": _place(d.primary) if d.primary else None,
            "secondary": [_place(label) for label in d.secondary],
        }
        for d in diagnostics
    ]
    return _dumps(items)


def sarif_report(diagnostics: Iterable[Diagnostic]) -> str:
    """One SARIF run; a rule is a code, its help the page that `ldc explain` prints."""
    found = list(diagnostics)
    rules = sorted({d.code for d in found})
    log = {
        "$schema": _SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "ldc",
                        "version": __version__,
                        "rules": [_rule(code) for code in rules],
                    }
                },
                "columnKind": "unicodeCodePoints",
                "results": [_result(d, rules.index(d.code)) for d in found],
            }
        ],
    }
    return _dumps(log)


def _place(label: Label) -> dict[str, Any]:
    source = label.span.source
    line, column = source.position(label.span.start)
    end_line, end_column = source.position(max(label.span.end, label.span.start))
    return {
        "file": source.path,
        "line": line,
        "column": column,
        "end_line": end_line,
        "end_column": end_column,
        "label": label.text,
    }


def _rule(code: str) -> dict[str, Any]:
    found = page(code)
    if found is None:
        return {"id": code}
    return {
        "id": code,
        "shortDescription": {"text": found.title},
        "help": {"text": found.text, "markdown": found.text},
    }


def _result(diagnostic: Diagnostic, rule: int) -> dict[str, Any]:
    text = diagnostic.message + (f"\nhelp: {diagnostic.help}" if diagnostic.help else "")
    result: dict[str, Any] = {
        "ruleId": diagnostic.code,
        "ruleIndex": rule,
        "level": diagnostic.severity.value,
        "message": {"text": text},
    }
    if diagnostic.primary:
        result["locations"] = [_location(diagnostic.primary)]
    if diagnostic.secondary:
        result["relatedLocations"] = [{"id": n, **_location(s)} for n, s in enumerate(diagnostic.secondary)]
    return result


def _location(label: Label) -> dict[str, Any]:
    place = _place(label)
    location: dict[str, Any] = {
        "physicalLocation": {
            "artifactLocation": {"uri": _uri(place["file"])},
            "region": {
                "startLine": place["line"],
                "startColumn": place["column"],
                "endLine": place["end_line"],
                "endColumn": place["end_column"],
            },
        }
    }
    if label.text:
        location["message"] = {"text": label.text}
    return location


def _uri(path: str) -> str:
    """A relative reference as code scanners want it, or a file URI when the path is absolute."""
    return Path(path).as_uri() if Path(path).is_absolute() else quote(Path(path).as_posix())


def _dumps(value: object) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False) + "\n"
