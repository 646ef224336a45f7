"""docs/library.md is what the tables say."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from ldc.library import blocks, functions

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "library.md"


def test_the_page_is_up_to_date():
    script = ROOT / "script" / "library-docs.py"
    found = subprocess.run([sys.executable, str(script), "--check"], check=False)
    assert found.returncode == 0, "run script/library-docs.py"


def test_every_function_and_block_is_on_the_page():
    text = PAGE.read_text(encoding="utf-8")
    conversions = {}
    for line in text.splitlines():
        if line.startswith("| `") and "_TO_` |" in line:
            start, targets = line.strip("| ").split("` | ")
            conversions |= {start.strip("`") + target: True for target in targets.split()}
    for name, row in functions.TABLE.items():
        assert row.internal or f"`{name}`" in text or name in conversions, name
    for name in blocks.names():
        assert f"`{name}`" in text
