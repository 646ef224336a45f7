"""Files that others drew, when a collection of them lies beside the repository: none raises, most compile."""

from __future__ import annotations

from pathlib import Path

import pytest

from ldc.pipeline import compile_paths

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "corpus" / "plcopen"
COMPILE = 8


def test_files_of_others() -> None:
    files = sorted(FOLDER.rglob("*.xml"))
    if not files:
        pytest.skip(f"no collection in {FOLDER.name}")
    good = [path for path in files if compile_paths([str(path)]).program is not None]
    assert len(good) >= COMPILE
