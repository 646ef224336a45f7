"""PLCopen TC6 XML (2.00, 2.01) with LD, FBD, ST and IL bodies to ast.File."""

from __future__ import annotations

from ldc.parser.plcopen.drawing import position
from ldc.parser.plcopen.project import is_xml, read

__all__ = ["is_xml", "position", "read"]
