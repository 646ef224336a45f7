"""Attributes that TC6 does not have: what a vendor says by them is told once, never dropped in silence."""

from __future__ import annotations

import re

from ldc.parser.foreign import Reading
from ldc.parser.plcopen.document import Document
from ldc.patterns import Pattern
from ldc.source import Span

_OF_TC6 = frozenset("""
    address alias attribute author companyName companyURL connectionPointOutId constant
    contentDescription creationDateTime direction duration edge edgeIn edgeOut executionOrderId
    formalParameter globalId handleUnknown height hidden indicator initialStep instanceName
    instancePathAndName interval label language length localId lower member modificationDateTime name negated
    negatedIn negatedOut nonpersistent nonretain organization persistent pouType priority productName
    productRelease productVersion qualifier refLocalId repetitionValue retain single storage storageIn
    storageOut targetName type typeName upper value version width x y WorksheetName xmlns""".split())
"""Of versions 1.0 to 2.01, with those that all editors write beside them and that are read."""
_READ = frozenset((("variable", "comment"), ("pouInstance", "taskName"), ("programInstance", "taskName")))
"""Of other editors, and read: the kind of element and the attribute."""
_TAG = Pattern(r"""<!--.*?(?:-->|\Z)|<!\[CDATA\[.*?(?:\]\]>|\Z)|<\?.*?(?:\?>|\Z)
    |<(/?)([^\s/<>!?]+)((?:[^<>"']|"[^<"]*"|'[^<']*')*?)(/?)>""", re.DOTALL | re.VERBOSE)
_ATTRIBUTE = Pattern(r"""\s([^\s=<>"'/]+)\s*=\s*(?:"([^"]*)"|'([^']*)')""")
_OPEN_TO_ALL = ("addData", "documentation", "content", "ST", "IL", "STContent")
"""What is in them is a vendor's, or text with tags of its own."""


def tell(document: Document, reading: Reading, further: frozenset[str]) -> None:
    """Report each unknown attribute that says something, once for a kind of element, at the first (LD0172).
    ``further``: known ones that TC6 does not have."""
    strange = {name for name in document.names - _OF_TC6 - further
               if not name.startswith(("xmlns:", "xsi:", "xml:"))}
    if not strange:
        return
    text = document.source.text
    found: dict[tuple[str, str], list[int]] = {}
    within: list[str] = []
    for match in _TAG.finditer(text):
        if match[2] is None:
            continue
        tag = match[2].rpartition(":")[2]
        if within:
            if tag == within[-1] and not match[4]:
                if match[1]:
                    within.pop()
                else:
                    within.append(tag)
            continue
        for one in _ATTRIBUTE.finditer(match[3]):
            if one[1] in strange and (one[2] or one[3] or "").strip() and (tag, one[1]) not in _READ:
                found.setdefault((tag, one[1]), []).append(match.start(3) + one.start(1))
        if tag in _OPEN_TO_ALL and not match[1] and not match[4]:
            within.append(tag)
    for (tag, name), places in found.items():
        span = Span(document.source, places[0], places[0] + len(name))
        what = f"attribute `{name[:40]}` of <{tag[:40]}>"
        reading.remark("left out", what.replace("`", ""), "no part of PLCopen XML", span)
        reading.diagnostics.note(
            "LD0172", f"the {what} is no part of PLCopen XML and is left out", span,
            "not read" if len(places) == 1 else f"not read, here and in {len(places) - 1:,} more",
            help="it is the editor's own; if the program depends on it, draw that with contacts and blocks")
