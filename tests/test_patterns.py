"""A pattern is a regular expression for everybody who uses one, and compiled no sooner than that."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from ldc.patterns import Pattern

ROOT = Path(__file__).resolve().parent.parent
_POSSESSIVE_GROUP = re.compile(r"\)(?:[*+?]|\{[0-9,]*\})\+")


def test_it_does_what_a_compiled_expression_does() -> None:
    ours, theirs = Pattern(r"(?P<word>[a-z]+)\d", re.IGNORECASE), re.compile(r"(?P<word>[a-z]+)\d", re.IGNORECASE)
    text = "AB1 cd2 !"
    assert ours.findall(text) == theirs.findall(text) == ["AB", "cd"]
    assert ours.match(text, 4)["word"] == "cd" and ours.fullmatch(text) is None
    assert [found.span() for found in ours.finditer(text)] == [found.span() for found in theirs.finditer(text)]
    assert ours.sub("-", text) == "- - !" and ours.groups == 1 and ours.pattern == theirs.pattern


def test_it_is_compiled_when_it_is_used() -> None:
    wrong = Pattern("(")
    with pytest.raises(re.error):
        wrong.match("a")


def test_what_an_expression_has_not_it_has_not() -> None:
    with pytest.raises(AttributeError, match="matches"):
        Pattern("a").matches


def test_no_group_is_repeated_possessively() -> None:
    """Before CPython 3.11.5, Debian 12's among them, `(?:ab?c)*+` matches "a" (gh-106052); `(?>(?:ab?c)*)` means
    what it says."""
    found = [f"{path.relative_to(ROOT)}:{number}" for package in ("ldc", "runtime")
             for path in sorted((ROOT / package).rglob("*.py"))
             for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
             if _POSSESSIVE_GROUP.search(line)]
    assert not found
