"""The tables of the grammar: kept where they can be, made anew where not, and the same in both cases."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from ldc.parser import lr, tables
from ldc.parser.chart_rules import ChartBuilder


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """An empty cache folder, and tables that nobody has asked for yet."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    tables.tables.cache_clear()
    yield tmp_path
    tables.tables.cache_clear()


def test_tables_are_read_back_as_they_were_made(fresh: Path) -> None:
    made = tables.tables()
    stored, = (fresh / "ldc").iterdir()
    tables.tables.cache_clear()
    assert dataclasses.astuple(tables.tables()) == dataclasses.astuple(made)
    assert [p.name for p in (fresh / "ldc").iterdir()] == [stored.name]


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b"\xff\xfe", b'{"actions": []}', b'{"rules": 5}'])
def test_a_spoilt_cache_is_replaced(fresh: Path, content: bytes) -> None:
    """lark numbers the states anew each time, so that only what the tables say can be compared."""
    made = tables.tables()
    stored, = (fresh / "ldc").iterdir()
    stored.write_bytes(content)
    tables.tables.cache_clear()
    again = tables.tables()
    assert (len(again.actions), sorted(again.rules)) == (len(made.actions), sorted(made.rules))
    assert stored.read_bytes() != content


def test_a_cache_folder_that_cannot_be_written_is_no_error(fresh: Path) -> None:
    (fresh / "ldc").write_text("a file is in the way")
    assert tables.tables().starts.keys() == set(tables.STARTS)


def test_every_rule_has_its_action() -> None:
    """``bind`` looks each one up; a rule without one would fail only when it is first used."""
    names = {action for _, _, action in tables.tables().rules if action}
    assert names <= set(dir(ChartBuilder))
    assert lr.bind(tables.tables(), ChartBuilder)
