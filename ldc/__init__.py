"""ldc: ladder diagrams and multi-language components, compiled to proved IEC 61131-3 IL."""

__version__ = "0.1.0"
