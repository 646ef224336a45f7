"""What comes with a backend: files of C and templates; and digests of what is made from them."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.resources import files

import jinja2


def digest(*texts: str) -> str:
    """SHA-256 over some texts and where each ends."""
    return hashlib.sha256("\0".join(texts).encode()).hexdigest()


class Room:
    """The folders ``runtime`` and ``templates`` of the package of a backend."""

    def __init__(self, package: str) -> None:
        self._folder = files(package)
        self.read = cache(self._read)
        self._environment = cache(self._make)

    def _read(self, name: str) -> str:
        """A file of ``runtime``."""
        return (self._folder / "runtime" / name).read_text(encoding="utf-8")

    def render(self, template: str, **values: object) -> str:
        """A template, filled in; a name that it lacks raises."""
        return self._environment().get_template(template).render(**values)

    def _make(self) -> jinja2.Environment:
        templates = self._folder / "templates"
        loader = jinja2.FunctionLoader(lambda name: (templates / name).read_text(encoding="utf-8"))
        return jinja2.Environment(loader=loader, trim_blocks=True, lstrip_blocks=True, autoescape=False,
                                  keep_trailing_newline=True, undefined=jinja2.StrictUndefined)
