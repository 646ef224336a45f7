"""The list of modules in a project file: one is put in, and nothing else of the text changes."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ldc.cli.output import write_file
from ldc.diagnostics import Diagnostics, Invalid
from ldc.manifest import Manifest


@contextmanager
def inserted(manifest: Manifest, module: str, after: str | None) -> Iterator[None]:
    """The project file lists the module behind ``after`` (None: as the last one) from now on; what goes wrong
    inside puts it back. Raises Invalid (LD0829) when it cannot be listed there, Failure when the file
    cannot be written."""
    text = with_module(manifest, module, after)
    path = Path(manifest.source.path)
    before = path.read_bytes()
    write_file(path, text.encode("utf-8"))
    try:
        yield
    except BaseException:
        write_file(path, before)
        raise


def with_module(manifest: Manifest, module: str, after: str | None) -> str:
    """The text of the project file with one more module."""
    names = [name.upper() for name in manifest.modules]
    text = manifest.source.text
    if module.upper() in names:
        raise _refused(manifest, f"`{module}` is a module of the project already",
                       "take it away there to move it")
    if not names:
        raise _refused(manifest, "the project lists no modules",
                       'write the PROGRAMs in their order: `modules = ["first", "second"]` under [project]')
    if after is not None and after.upper() not in names:
        raise _refused(manifest, f"`{after}` is no module of the project",
                       f"modules: {', '.join(manifest.modules)}")
    number = names.index(after.upper()) if after is not None else len(names) - 1
    item = manifest.spans["project", "modules", number].value
    return f"{text[:item.end]}, {json.dumps(module)}{text[item.end:]}"


def _refused(manifest: Manifest, what: str, help: str) -> Invalid:
    found = Diagnostics()
    found.error("LD0829", what, manifest.value_span("project", "modules"), "the modules", help=help)
    return Invalid(found)
