"""The diagnostics that exist: one page each in ldc/pages, which `ldc explain` prints."""

from __future__ import annotations

import re
from functools import cache
from importlib import resources

from ldc.patterns import Pattern
from ldc.records import record
from ldc.similar import similar

_TITLE = Pattern(r"# (LD\d{4}): (.+)")


_LOOKALIKES = str.maketrans("OIL", "011")


@record
class Page:
    """`text` is Markdown and begins with its own title line."""

    code: str
    title: str
    text: str


@cache
def codes() -> tuple[str, ...]:
    """Every code that has a page, in order."""
    names = (entry.name for entry in (resources.files("ldc") / "pages").iterdir())
    return tuple(sorted(name[:-3] for name in names if re.fullmatch(r"LD\d{4}\.md", name)))


@cache
def page(code: str) -> Page | None:
    """The page of a code as written in messages (`LD0301`, any case); None when there is none."""
    code = code.upper()
    if code not in codes():
        return None
    text = (resources.files("ldc") / "pages" / f"{code}.md").read_text(encoding="utf-8")
    match = _TITLE.match(text)
    return Page(code, match[2].strip() if match else code, text)


def nearest(code: str, count: int = 3) -> tuple[str, ...]:
    """Codes that look most like what was asked for: those that go on from it, then near ones."""
    asked = code.upper() if code[:1].isalpha() else f"LD{code}"
    asked = asked[:2] + asked[2:].translate(_LOOKALIKES)
    begun = [known for known in codes() if len(asked) > 2 and known.startswith(asked)]
    close = similar(asked, codes(), count, 0.6)
    return tuple(dict.fromkeys([*begun, *close]))[:count]
