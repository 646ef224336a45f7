"""PLCopen TC6 XML 2.01 of a project."""

from __future__ import annotations

from ldc.export.plcopen.project import export

__all__ = ["export"]
