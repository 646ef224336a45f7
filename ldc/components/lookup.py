"""Looking up the symbols that C names, and what is told when they are not there."""

from __future__ import annotations

from ldc.components import findings
from ldc.components.address_map import AddressMap, Symbol
from ldc.diagnostics import Diagnostics
from ldc.similar import similar
from ldc.source import Span


def symbol(memory: AddressMap, macro: str, name: str, span: Span, diagnostics: Diagnostics) -> Symbol | None:
    """The symbol that the processor of the map may read; None with a finding."""
    found = memory.find(macro, name)
    if found is None:
        close = similar(name, memory.names(macro), 2)
        findings.unknown_symbol(diagnostics, span, macro, name, close, memory.processor)
        return None
    if memory.processor not in found.readers:
        readers = ", ".join(sorted(found.readers))
        findings.no_access(diagnostics, span, name, found.area, memory.processor, readers)
        return None
    return found


def writable(memory: AddressMap, found: Symbol, span: Span, diagnostics: Diagnostics) -> bool:
    """Whether the processor may write the symbol; a finding when not (single writer, SPEC 1.2)."""
    if memory.processor in found.writers:
        return True
    writers = ", ".join(sorted(found.writers)) or "nobody"
    findings.no_write(diagnostics, span, found.name, found.area, memory.processor, writers)
    return False
