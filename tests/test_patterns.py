"""A pattern is a regular expression for everybody who uses one, and compiled no sooner than that."""

from __future__ import annotations

import re

import pytest

from ldc.patterns import Pattern


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
