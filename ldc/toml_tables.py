"""Tables of a TOML file as typed values; everything that does not fit is a finding with its place."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, Literal, TypeVar, get_args, get_origin

import msgspec
from msgspec import Struct

from ldc.diagnostics import Diagnostics
from ldc.patterns import Pattern
from ldc.similar import similar
from ldc.source import SourceFile, Span
from ldc.toml_spans import Entry, toml_spans

T = TypeVar("T", bound=Struct)
Path = tuple[str | int, ...]

_WORDS = {
    "str": "a text in quotes",
    "int": "a whole number",
    "float": "a number",
    "bool": "true or false",
    "array": "a list in brackets",
    "object": "a table",
    "null": "nothing",
}
_EXPECTED = Pattern(r"Expected `([^`]+)`(?:, got `([^`]+)`| (?:of length )?(.+?))?(?: - at `\$(.*)`)?\Z")


class Tables:
    """A parsed TOML text; ``what`` it is, for messages. Every method reports what is wrong and goes on
    with the default."""

    def __init__(self, source: SourceFile, data: Mapping[str, Any], diagnostics: Diagnostics,
                 what: str = "the project file") -> None:
        self.spans: dict[Path, Entry] = toml_spans(source)
        self._data = data
        self._diagnostics = diagnostics
        self._what = what

    def check_sections(self, known: Iterable[str]) -> None:
        """Report every top-level key that is not one of `known`."""
        self._check_keys((), self._data, tuple(known))

    def table(self, path: Path, kind: type[T]) -> T:
        """The table at `path` as a `kind`; all defaults when it is not there."""
        data: Any = self._data
        for key in path:
            data = data.get(key, {}) if isinstance(data, dict) else data
        if not isinstance(data, dict):
            self.wrong(path, f"`{_dotted(path)}` must be a table",
                       f"write [{_dotted(path)}] on a line of its own")
            return kind()
        return self._checked(path, data, kind)

    def records(self, path: Path, kind: type[T]) -> tuple[T, ...]:
        """The list of inline tables at `path`, each as a `kind`; what is no table is left out."""
        data: Any = self._data
        for key in path:
            data = data.get(key, {} if key != path[-1] else []) if isinstance(data, dict) else []
        if not isinstance(data, list):
            self.wrong(path, f"`{_dotted(path)}` must be a list of tables",
                       "write [{ name = ..., type = ... }]")
            return ()
        found = (self.record((*path, number), item, kind) for number, item in enumerate(data))
        return tuple(item for item in found if item is not None)

    def record(self, path: Path, item: Any, kind: type[T], help: str = "write { name = ..., type = ... }"
               ) -> T | None:
        """An item of a list, at `path`, as a `kind`; None when it is no table. ``help``: what to write."""
        if isinstance(item, dict):
            return self._checked(path, item, kind)
        self.wrong(path, f"an item of `{_dotted(path)}` must be a table", help)
        return None

    def has(self, section: str) -> bool:
        """Whether the file has the section, empty or not."""
        return section in self._data

    def _checked(self, path: Path, data: Mapping[str, Any], kind: type[T]) -> T:
        fields = {f.encode_name: f for f in msgspec.structs.fields(kind)}
        self._check_keys(path, data, tuple(fields))
        good = {}
        for name, value in data.items():
            if (
                name in fields
                and (checked := self.value((*path, name), value, fields[name].type)) is not None
            ):
                good[fields[name].name] = checked
        return kind(**good)

    def mapping(self, section: str) -> dict[str, Any]:
        """The keys and raw values of a section; empty when it is not there or is no table."""
        data = self._data.get(section, {})
        if isinstance(data, dict):
            return data
        self.wrong((section,), f"`{section}` must be a table", f"write [{section}] on a line of its own")
        return {}

    def value(self, path: Path, value: Any, kind: Any) -> Any:
        """`value` as a `kind`, or None with a finding."""
        try:
            return msgspec.convert(value, kind)
        except msgspec.ValidationError as error:
            choices = " or ".join(f'"{one}"' for one in _choices(kind))
            self.wrong(path, f"`{_dotted(path)}`{_explain(str(error), value)}",
                       choices and f"write {choices}")
            return None

    def wrong(self, path: Path, message: str, help: str = "", label: str = "") -> None:
        """Report a value that does not fit."""
        entry = self.spans.get(path) or self.spans.get(path[:-1])
        self._diagnostics.error("LD0612", message, entry.value if entry else None, label, help=help)

    def _check_keys(self, path: Path, data: Mapping[str, Any], known: tuple[str, ...]) -> None:
        for key in data:
            if key in known:
                continue
            close = similar(key.lower(), known, 1)
            entry = self.spans.get((*path, key)) or next(
                (e for p, e in self.spans.items() if p[: len(path) + 1] == (*path, key)), None
            )
            where = f"[{_dotted(path)}]" if path else self._what
            self._diagnostics.error(
                "LD0611",
                f"{where} has no key `{key}`",
                entry.key if entry else None,
                "not known",
                help=f"did you mean `{close[0]}`?" if close else f"known keys: {', '.join(known)}",
            )


def _dotted(path: Path) -> str:
    """The path as people write it; the number of an item is left out."""
    return ".".join(str(key) for key in path if isinstance(key, str))


def parse_toml(source: SourceFile, diagnostics: Diagnostics) -> dict[str, Any] | None:
    """The values of a TOML text, or None with a finding at the place where it breaks."""
    import tomllib  # slow to load, and a file alone has no project file

    try:
        return tomllib.loads(source.text)
    except tomllib.TOMLDecodeError as error:
        text = str(error)
    except RecursionError:
        text = "brackets are nested too deeply"
    except ValueError:
        text = "a number has too many digits"
    match = re.search(r" \(at (?:line (\d+), column (\d+)|end of document)\)", text)
    offset = len(source.text)
    if match and match[1]:
        offset = source.line_starts[int(match[1]) - 1] + int(match[2]) - 1
    what = text[: match.start()] if match else text
    diagnostics.error(
        "LD0610",
        f"`{source.path}` is not valid TOML",
        Span(source, offset, offset + 1),
        what[:1].lower() + what[1:],
        help="a text stands in quotes, a list in brackets, a table begins with [name]",
    )
    return None


def _choices(kind: Any) -> tuple[str, ...]:
    """What a Literal allows, with or without None; nothing for other types."""
    if get_origin(kind) is Literal:
        return get_args(kind)
    return tuple(one for part in get_args(kind) for one in _choices(part))


def _explain(error: str, value: Any) -> str:
    """msgspec's message in the words of the reader of a TOML file."""
    match = _EXPECTED.match(error)
    if not match:
        return f": {error[:1].lower()}{error[1:]}".replace("invalid enum value", "unknown choice")
    expected, got, bound, at = match.groups()
    names = [_WORDS.get(name, name) for name in expected.split(" | ") if name != "null"]
    wanted = " or ".join(names)
    if bound:
        return f"{at or ''} must be {wanted}{' of length' if 'length' in error else ''} {bound}"
    return f"{at or ''} must be {wanted}, not {_WORDS.get(got or '', got)}"
