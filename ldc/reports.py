"""Diagnostics for machines: a JSON array, and SARIF 2.1.0 for code scanners."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any
from urllib.parse import quote

from ldc import __version__
from ldc.codes import page
from ldc.diagnostics import Diagnostic, Label, Locate, Place

_SCHEMA = "https://json.schemastore.org/sarif-2.1.0.json"


def json_report(diagnostics: Iterable[Diagnostic], locate: Locate | None = None) -> str:
    """One array of objects with `code`, `severity`, `message`, `help`, `primary` (null when a finding has no
    place) and `secondary`; places have `file`, `line`, `column`, `end_line`, `end_column` (from 1, the end
    is the first character after) and `label`. In a drawing also `drawn`: `pou`, `rung`, `element`, `position`
    in words (DESIGN section 9)."""
    items = [
        {
            "code": d.code,
            "severity": d.severity.value,
            "message": d.message,
            "help": d.help,
            "primary": _place(d.primary) | _drawn(d.primary, locate) if d.primary else None,
            "secondary": [_place(label) | _drawn(label, locate) for label in d.secondary],
        }
        for d in diagnostics
    ]
    return _dumps(items)


def sarif_report(diagnostics: Iterable[Diagnostic], locate: Locate | None = None) -> str:
    """One SARIF run; a rule is a code, its help the page that `ldc explain` prints. Places in drawings are
    logical locations."""
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
                "results": [_result(d, rules.index(d.code), locate) for d in found],
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


def _drawn(label: Label, locate: Locate | None) -> dict[str, Any]:
    found = locate(label.span, "") if locate else None
    return {"drawn": _words(found)} if found else {}


def _words(place: Place) -> dict[str, str]:
    return {"pou": place.pou, "rung": place.rung, "element": place.element, "position": place.position}


def _rule(code: str) -> dict[str, Any]:
    found = page(code)
    if found is None:
        return {"id": code}
    return {
        "id": code,
        "shortDescription": {"text": found.title},
        "help": {"text": found.text, "markdown": found.text},
    }


def _result(diagnostic: Diagnostic, rule: int, locate: Locate | None) -> dict[str, Any]:
    text = diagnostic.message + (f"\nhelp: {diagnostic.help}" if diagnostic.help else "")
    result: dict[str, Any] = {
        "ruleId": diagnostic.code,
        "ruleIndex": rule,
        "level": diagnostic.severity.value,
        "message": {"text": text},
    }
    if diagnostic.primary:
        result["locations"] = [_location(diagnostic.primary, locate)]
    if diagnostic.secondary:
        result["relatedLocations"] = [
            {"id": n, **_location(s, locate)} for n, s in enumerate(diagnostic.secondary)
        ]
    return result


def _location(label: Label, locate: Locate | None) -> dict[str, Any]:
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
    found = locate(label.span, "") if locate else None
    if found:
        words = _words(found)
        name = "/".join(text for text in (found.pou.rpartition(" ")[2], found.rung, found.element) if text)
        location["logicalLocations"] = [{"fullyQualifiedName": name, "kind": "element", "properties": words}]
    return location


def _uri(path: str) -> str:
    """A relative reference as code scanners want it, or a file URI when the path is absolute."""
    return Path(path).as_uri() if Path(path).is_absolute() else quote(Path(path).as_posix())


def _dumps(value: object) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False) + "\n"
