"""The modules in a project file: one is put into the list and into the steps of the sequence; nothing else
of the text changes."""

from __future__ import annotations

import codecs
import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from ldc.cli.output import write_file
from ldc.coordination import StepSetting
from ldc.diagnostics import Diagnostics, Invalid
from ldc.manifest import Manifest, Sources
from ldc.parser import parse_file


@contextmanager
def inserted(sources: Sources, module: str, after: str | None) -> Iterator[None]:
    """The project file lists the module behind ``after`` (None: as the last one) from now on; what goes wrong
    inside puts it back, unless somebody has changed it since. Raises Invalid (LD0829) when it cannot be
    listed there, Failure when the file cannot be written."""
    manifest = sources.manifest
    text = with_module(manifest, module, after, _starts(sources, module))
    path = Path(manifest.source.path)
    before = path.read_bytes()
    written = _as_in(before, text)
    write_file(path, written)
    try:
        yield
    except BaseException:
        if path.read_bytes() == written:
            write_file(path, before)
        raise


def _as_in(before: bytes, text: str) -> bytes:
    """The text with the line ends of a file and its byte order mark, which are lost when it is read."""
    ends = "\r\n" if b"\r\n" in before else "\n"
    mark = codecs.BOM_UTF8 if before.startswith(codecs.BOM_UTF8) else b""
    return mark + text.replace("\n", ends).encode("utf-8")


def with_module(manifest: Manifest, module: str, after: str | None, starts: bool = False) -> str:
    """The text of the project file with one more module. ``starts``: it is one that a sequence starts: where
    the project writes the steps of its own and none of it, it has one behind the last step of the module
    before."""
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
    name = json.dumps(module)
    edits = [(manifest.spans["project", "modules", number].value.end, f", {name}")]
    sequence = manifest.coordination.sequence
    steps = sequence.steps if starts and sequence is not None else None
    if steps is not None and not any(step.module.upper() == module.upper() for step in steps):
        edits.append(_step(manifest, steps, names[number], name))
    for at, more in sorted(edits, reverse=True):
        text = f"{text[:at]}{more}{text[at:]}"
    return text


def _step(manifest: Manifest, steps: Sequence[StepSetting], before: str, name: str) -> tuple[int, str]:
    """Where the step of a module comes, and its text: behind the last step of the module before, on a line of
    its own where the others are; as the last one when that module has none."""
    known = [step for step in steps if step.module.upper() == before] or [steps[-1]]
    span = manifest.spans[known[-1].key].value
    line = manifest.source.text[manifest.source.text.rfind("\n", 0, span.start) + 1 : span.start]
    between = f"\n{line}" if line and not line.strip() else " "
    written = f"{{ module = {name} }}" if span.text.startswith("{") else name
    return span.end, f",{between}{written}"


def _starts(sources: Sources, module: str) -> bool:
    """Whether it is a PROGRAM with an input `start`."""
    ignored = Diagnostics()
    pous = (pou for file in sources.files for pou in parse_file(file, ignored).pous)
    found = next((pou for pou in pous if pou.kind == "PROGRAM" and pou.name.upper() == module.upper()), None)
    return found is not None and any(
        variable.name.upper() == "START" for block in found.var_blocks if block.kind == "VAR_INPUT"
        for variable in block.variables)


def _refused(manifest: Manifest, what: str, help: str) -> Invalid:
    found = Diagnostics()
    found.error("LD0829", what, manifest.value_span("project", "modules"), "the modules", help=help)
    return Invalid(found)
