"""Reading a source: bytes of a file to a SourceFile, and everything that can be wrong with them."""

from __future__ import annotations

import codecs
import re
from pathlib import Path

from ldc.diagnostics import Diagnostics
from ldc.patterns import Pattern
from ldc.source import SourceFile, Span

LIMIT = 64 * 1024 * 1024
"""Bytes. A text of that size is no ladder that anyone drew; it would only eat the memory."""
_EIGHT_BITS = (b"LDmicro", b"_FILES_CLASSICLADDER")
"""How files of tools begin that write the bytes of a code page; only comments have others than ASCII."""

_TABLE = Pattern(rb'^"?\d*"?\t"?[^"\t\n]*"?\t"?(?:LD|NOP|P\d)', re.MULTILINE)
"""A row of a table that GX Works writes; all but its comments is ASCII."""
_JAPANESE = b"\x83X\x83e\x83b\x83v"  # in code page 932
"""The first word of the names of its columns."""
_XML = Pattern(rb"""\s*<\?xml\s[^>]{0,200}?\bencoding\s*=\s*["']([A-Za-z][\w.-]{0,30})["']""")
_ENCODINGS = Pattern(
    r"(iso|windows|cp|koi8|mac|gb|big5|shift|sjis|euc|ks|us-ascii|ascii|latin)[\w.-]*\Z", re.IGNORECASE
)
_UTF_16 = {
    codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16", b"<\0": "utf-16-le", b"\0<": "utf-16-be"
}


def read_source(path: Path, shown: str, diagnostics: Diagnostics) -> SourceFile | None:
    """The text of a file, or None with one finding added.

    UTF-8, with or without a byte order mark, and for XML what it declares; every kind of line end becomes
    ``\\n``, so that a rung has one digest whatever the editor. `shown` is the name that messages use.
    """
    try:
        with open(path, "rb") as file:
            data = file.read(LIMIT + 1)
    except FileNotFoundError:
        missing(shown, diagnostics)
        return None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        help = "chmod u+r lets you read a file of your own" if isinstance(error, PermissionError) else ""
        diagnostics.error("LD0602", f"cannot read `{shown}`: {reason}", help=help or "ls -l shows what it is")
        return None
    if len(data) > LIMIT:
        diagnostics.error(
            "LD0604",
            f"`{shown}` is larger than {LIMIT // (1024 * 1024)} MiB",
            help="split it into several sources",
        )
        return None
    return _decode(data, shown, diagnostics)


def missing(shown: str, diagnostics: Diagnostics, help: str = "", span: Span | None = None) -> None:
    """Report a file or folder that does not exist."""
    diagnostics.error(
        "LD0601",
        f"there is no file or folder `{shown}`",
        span,
        help=help or "check the spelling and the folder",
    )


def _decode(data: bytes, shown: str, diagnostics: Diagnostics) -> SourceFile | None:
    if data.startswith(codecs.BOM_UTF8):
        data = data[len(codecs.BOM_UTF8) :]
    text = _as_declared(data)
    if text is not None:
        return SourceFile(shown, _line_ends(text))
    try:
        return SourceFile(shown, _line_ends(data.decode("utf-8")))
    except UnicodeDecodeError as error:
        at = error.start
    if data[:100].lstrip().startswith(_EIGHT_BITS):
        return SourceFile(shown, _line_ends(data.decode("latin-1")))
    if _TABLE.search(data, 0, 6_000):
        encoding = "cp932" if _JAPANESE in data[:6_000] else "latin-1"
        return SourceFile(shown, _line_ends(data.decode(encoding, "replace")))
    before = _line_ends(data[:at].decode("utf-8"))
    source = SourceFile(shown, before + _line_ends(data[at : at + 200].decode("utf-8", "replace")))
    if data[:2] in (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE):
        help = "the file is UTF-16: save it as UTF-8"
    else:
        guess = bytes([data[at]]).decode("latin-1")
        as_latin = f" (in Latin-1 it is `{guess}`)" if guess.isprintable() else ""
        help = f"save the file as UTF-8{as_latin}, for example: iconv -f latin1 -t utf-8 OLD > NEW"
    diagnostics.error(
        "LD0603",
        f"`{shown}` is not UTF-8 text",
        Span(source, len(before), len(before) + 1),
        f"byte 0x{data[at]:02X} at offset {at:,}",
        help=help,
    )
    return None


def _as_declared(data: bytes) -> str | None:
    """The text of XML, or of a table with a byte order mark, that is not UTF-8, by its first bytes or its
    declaration; None when it is UTF-8, neither of them, or not what it says."""
    encoding = _UTF_16.get(data[:2])
    if encoding is None and (declared := _XML.match(data)) is not None:
        name = declared[1].decode("ascii")
        encoding = name if _ENCODINGS.match(name) else None
    if encoding is None:
        return None
    try:
        text = data.decode(encoding)
    except (LookupError, ValueError):
        return None
    if encoding == "utf-16" and "\t" in text[:2_000]:
        return text
    return text if text.lstrip()[:1] == "<" else None


def _line_ends(text: str) -> str:
    return text.replace("\r\n", "\n").replace("\r", "\n") if "\r" in text else text
