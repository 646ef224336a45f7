"""Diagnostics as they appear: excerpts, carets, long lines, wide characters, JSON and SARIF."""

from __future__ import annotations

import json
import re

from hypothesis import given
from hypothesis import strategies as st

from ldc.diagnostics import Diagnostic, Diagnostics, Label, Severity
from ldc.render import render, summary, visible
from ldc.reports import json_report, sarif_report
from ldc.source import SourceFile, Span

TEXT = """\
PROGRAM main
VAR
    motor AT %QX0.0 : BOOL;
    motor AT %QX0.1 : BOOL;
END_VAR

RUNG seal_in
    { [start] | [motor] } [/stop] (motor)
END_PROGRAM
"""
MAIN = SourceFile("main.ld", TEXT)
OTHER = SourceFile("lib/blocks.ld", "FUNCTION_BLOCK pump\n\tRUNG [入力] [x] (出力)\nEND_FUNCTION_BLOCK\n")


def at(text: str, source: SourceFile = MAIN, occurrence: int = 1) -> Span:
    start = -1
    for _ in range(occurrence):
        start = source.text.index(text, start + 1)
    return Span(source, start, start + len(text))


def finding(
    code: str,
    message: str,
    span: Span | None,
    label: str = "",
    *secondary: Label,
    help: str = "",
    severity: Severity = Severity.ERROR,
) -> Diagnostic:
    return Diagnostic(code, message, Label(span, label) if span else None, secondary, help, severity)


SAMPLES = [
    finding(
        "LD0001",
        "`motor` is declared twice",
        at("motor", occurrence=2),
        "again here",
        Label(at("motor"), "first declared here"),
        help="give one of them another name",
    ),
    finding(
        "LD0002",
        "two labels on one line",
        at("[motor]"),
        "this contact",
        Label(at("[/stop]"), "before this one"),
        Label(at("(motor)"), "and this coil"),
    ),
    finding(
        "LD0003",
        "labels in two files",
        at("start"),
        "unknown here",
        Label(at("[x]", OTHER), "known there"),
        Label(at("PROGRAM"), "in this program"),
    ),
    finding(
        "LD0004", "over several lines", Span(MAIN, TEXT.index("VAR"), TEXT.index("END_VAR") + 7), "these"
    ),
    finding(
        "LD0005",
        "wide characters and a tab",
        at("[x]", OTHER),
        "the third",
        Label(at("出力", OTHER), "a coil"),
    ),
    finding("LD0006", "at the very end", Span(MAIN, len(TEXT), len(TEXT)), "something is missing"),
    finding("LD0007", "without a place", None, help="first line\nsecond line", severity=Severity.WARNING),
    finding(
        "LD0008",
        "labels that overlap",
        at("{ [start] | [motor] }"),
        "all of it",
        Label(at("[start]"), "a part"),
        Label(at("start"), "a smaller part"),
    ),
    finding("LD0009", "only a note", at("END_PROGRAM"), severity=Severity.NOTE),
]


def test_samples(golden) -> None:
    golden("render/samples.txt", render(SAMPLES))


def test_samples_in_color(golden) -> None:
    shown = render(SAMPLES, color=True)
    golden("render/samples_color.txt", shown.replace("\x1b", "<ESC>"))
    assert re.sub(r"\x1b\[[\d;]*m", "", shown) == render(SAMPLES)


def test_long_lines_are_cut_around_the_label(golden) -> None:
    line = "RUNG " + " ".join(f"[contact_{n}]" for n in range(1000)) + " (coil)"
    source = SourceFile("long.ld", line)
    shown = render(
        [
            finding("LD0001", "near the start", at("contact_1]", source), "here"),
            finding("LD0002", "in the middle", at("contact_500", source), "here"),
            finding(
                "LD0003", "at the end", at("coil", source), "here", Label(at("RUNG", source), "far away")
            ),
        ],
        width=80,
    )
    assert max(len(line) for line in shown.splitlines() if line[0:1].isdigit()) <= 80
    golden("render/long_lines.txt", shown)


def test_a_terminal_is_never_given_what_the_source_wants_it_to_obey() -> None:
    source = SourceFile("evil\x1b]0;title\x07.ld", "RUNG \x1b[2J\x9b31m\x00 [x]\n")
    shown = render(
        [finding("LD0001", "found \x1b[31m\u202e", at("[x]", source), "a \x07 label", help="\x1bc")]
    )
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f\u202e]", shown)


def test_many_are_counted_not_shown_and_errors_come_before_warnings() -> None:
    warnings = [finding(f"LD{n:04d}", f"w{n}", None, severity=Severity.WARNING) for n in range(60)]
    error = finding("LD0100", "the one that matters", None)
    shown = render([*warnings, error])
    assert "the one that matters" in shown
    assert "... and 11 more, not shown" in shown
    assert shown.endswith("\n1 error, 60 warnings\n")
    assert render([]) == ""
    assert summary([]) == "no problems"


@given(
    st.text(alphabet="ab[](){}|@\t\n\r é入\u0301\x1b\x00", max_size=80),
    st.lists(st.tuples(st.integers(0, 90), st.integers(0, 40), st.text(max_size=8)), min_size=1, max_size=5),
    st.integers(20, 60),
)
def test_every_span_of_every_text_can_be_shown(
    text: str, places: list[tuple[int, int, str]], width: int
) -> None:
    source = SourceFile("any.ld", text)
    spans = [Label(Span(source, min(s, len(text)), min(s, len(text)) + n), t) for s, n, t in places]
    shown = render([Diagnostic("LD0001", "m", spans[0], tuple(spans[1:]))], width=width)
    assert "^" in shown
    for label in spans:
        assert " ".join(visible(" ".join(label.text.split())).split()) in " ".join(shown.split())


def test_json_is_a_list_of_places_and_words() -> None:
    first, *_, last = json.loads(json_report(SAMPLES))
    assert first == {
        "code": "LD0001",
        "severity": "error",
        "message": "`motor` is declared twice",
        "help": "give one of them another name",
        "primary": {
            "file": "main.ld",
            "line": 4,
            "column": 5,
            "end_line": 4,
            "end_column": 10,
            "label": "again here",
        },
        "secondary": [
            {
                "file": "main.ld",
                "line": 3,
                "column": 5,
                "end_line": 3,
                "end_column": 10,
                "label": "first declared here",
            }
        ],
    }
    assert last["severity"] == "note"
    assert json.loads(json_report([])) == []


def test_sarif_has_the_shape_that_code_scanners_ask_for() -> None:
    log = json.loads(sarif_report(SAMPLES))
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    rules = run["tool"]["driver"]["rules"]
    assert run["tool"]["driver"]["name"] == "ldc"
    assert len({rule["id"] for rule in rules}) == len(rules)
    for result, sample in zip(run["results"], SAMPLES, strict=True):
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"] == sample.code
        assert result["level"] in ("none", "note", "warning", "error")
        assert result["message"]["text"].startswith(sample.message)
        for place in [*result.get("locations", []), *result.get("relatedLocations", [])]:
            physical = place["physicalLocation"]
            assert re.fullmatch(r"[\w./%-]+", physical["artifactLocation"]["uri"])
            region = physical["region"]
            assert 1 <= region["startLine"] <= region["endLine"]
            assert (region["startLine"], region["startColumn"]) <= (region["endLine"], region["endColumn"])


def test_sarif_names_files_by_uri() -> None:
    bag = Diagnostics()
    for path in ("a b/ü.ld", "/plant/main.ld"):
        bag.error("LD0601", path, Span(SourceFile(path, "x"), 0, 1))
    results = json.loads(sarif_report(bag))["runs"][0]["results"]
    uris = [r["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] for r in results]
    assert uris == ["file:///plant/main.ld", "a%20b/%C3%BC.ld"]
