"""What `ldc import` writes: a project of text files, and a report of what became of everything."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from itertools import groupby

from ldc.diagnostics import Diagnostic, Diagnostics
from ldc.parser import ast, format_of
from ldc.parser.sfc import SfcBody, rungs_of
from ldc.parser.write import Part, ending, written
from ldc.render import plural
from ldc.source import SourceFile

_LONGEST_NAME = 80
_KINDS = {
    "mapped": "Mapped to other means with the same effect",
    "renamed": "Renamed",
    "added": "Added",
    "left out": "Left out, without effect on what the program does",
}


def sources(files: Sequence[ast.File], diagnostics: Diagnostics) -> dict[str, ast.File]:
    """The trees of foreign files as text files by path: types, a file for each POU in their order, one for
    those that stand for instructions of the other tool, global variables and configurations."""
    parts: dict[str, list[Part]] = {}
    types = [type_ for file in files for type_ in file.types]
    if types:
        parts["src/types.st"] = types
    taken = {"types", "globals"}
    for file in files:
        for helps, group in groupby(file.pous, key=lambda pou, file=file: _helps(pou, file)):
            pous = list(group)
            if helps:
                parts[f"src/{_free('support', taken)}.st"] = pous
            else:
                parts |= {f"src/{_free(pou.name, taken)}{ending(pou)}": [pou] for pou in pous}
    shared = [block for file in files for block in file.globals]
    shared += [configuration for file in files for configuration in file.configurations]
    if shared:
        parts["src/globals.st"] = shared
    texts = {path: written(group, path, diagnostics) for path, group in parts.items()}
    return {path: file for path, file in texts.items() if file.source.text}


def _helps(pou: ast.Pou, file: ast.File) -> bool:
    """Whether the POU is text of the reader's own, which comes with it."""
    return pou.span.source.path != file.source.path and ending(pou) == ".st"


def _free(name: str, taken: set[str]) -> str:
    """A file name for a POU that no other one has, on systems that take no notice of case too."""
    stem = base = name[:_LONGEST_NAME]
    number = 1
    while stem.lower() in taken:
        number += 1
        stem = f"{base}_{number}"
    taken.add(stem.lower())
    return stem


def project_file(name: str, files: Sequence[ast.File], texts: dict[str, ast.File]) -> str:
    """`ldc.toml`. Files with POUs are listed only when their order is not that of their names: programs
    run in that order."""
    paths = [path for path, file in texts.items() if file.pous]
    listed = "" if paths == sorted(paths) else "".join(f'    "{path}",\n' for path in paths)
    kept = [f"{json.dumps(path)} = {json.dumps(value)}\n" for file in files for path, value in file.safe]
    safe = f"\n[safe]\n{''.join(kept)}" if kept else ""
    found = f'[\n{listed}    "src/*",\n]' if listed else '["src/*"]'
    return f'[project]\nname = "{project_name(name)}"\nsources = {found}\n{safe}'


def project_name(folder: str) -> str:
    return re.sub(r"[^A-Za-z0-9_-]+", "_", folder).strip("_") or "project"


def readme(name: str, files: Sequence[ast.File], texts: dict[str, ast.File]) -> str:
    """What the folder is and how to go on."""
    ladder = next((path for path in texts if path.endswith(".ld")), None)
    came = ", ".join(f"`{_name(file.source)}` ({_format(file)})" for file in files)
    draw = f"    ldc draw {ladder}\n" if ladder else ""
    return (f"# {project_name(name)}\n\nImported from {came}. "
            "`import-report.md` tells what became of everything.\n\n"
            f"    ldc check .\n{draw}    ldc run . --scans 20\n    ldc fmt . --check\n")


def report(
    files: Sequence[ast.File], texts: dict[str, ast.File], found: Iterable[Diagnostic], proof: str
) -> str:
    """`import-report.md`. `proof`: what is known about the project and its source."""
    lines = ["# Import report", "", *_table(("source", "format", "POUs", "rungs", "types", "variables"),
                                            map(_counts, files)), "", proof, ""]
    rows = [(f"{pou.kind} {pou.name}", _content(pou), f"`{path}`")
            for path, file in texts.items() for pou in file.pous]
    rows += [(f"TYPE {type_.name}", "", f"`{path}`") for path, file in texts.items() for type_ in file.types]
    rows += [(f"CONFIGURATION {c.name}", plural(sum(len(r.tasks) for r in c.resources), "task"), f"`{path}`")
             for path, file in texts.items() for c in file.configurations]
    lines += ["## What is where", "", *_table(("part", "content", "file"), rows), ""]
    for kind, title in _KINDS.items():
        remarks = [(str(r.span.position[0]), f"`{r.what}`", f"`{r.into}`" if kind == "renamed" else r.into)
                   for file in files for r in file.remarks if r.kind == kind]
        if remarks:
            heads = ("line", "there", "why" if kind == "left out" else "here")
            lines += [f"## {title}: {len(remarks):,}", "", *_table(heads, remarks), ""]
    told = [(_place(d), f"{d.severity.value} {d.code}", d.message) for d in found]
    if told:
        lines += [f"## Findings: {len(told):,}", "", *_table(("place", "code", "finding"), told), "",
                  "`ldc explain CODE` tells more.", ""]
    return "\n".join(lines)


def _counts(file: ast.File) -> tuple[str, ...]:
    rungs = sum(len(rungs_of(pou)) for pou in file.pous)
    blocks = [*file.globals, *(block for pou in file.pous for block in pou.var_blocks)]
    blocks += [block for c in file.configurations for block in c.var_blocks]
    numbers = (len(file.pous), rungs, len(file.types), sum(len(block.variables) for block in blocks))
    return (f"`{_name(file.source)}`", _format(file), *(f"{number:,}" for number in numbers))


def _content(pou: ast.Pou) -> str:
    if isinstance(pou.body, ast.LadderBody):
        return plural(len(pou.body.rungs), "rung")
    if isinstance(pou.body, SfcBody):
        return f"chart of {plural(len(pou.body.steps), 'step')}"
    return "Instruction List" if isinstance(pou.body, ast.TextBody) else "Structured Text"


def _name(source: SourceFile) -> str:
    return source.path.replace("\\", "/").rpartition("/")[2]


def _format(file: ast.File) -> str:
    found = format_of(file.source)
    return found.name if found else "text"


def _place(found: Diagnostic) -> str:
    if found.primary is None:
        return ""
    span = found.primary.span
    return f"{_name(span.source)}:{span.position[0]}"


def _table(heads: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> list[str]:
    return [_row(heads), _row(("---",) * len(heads)), *map(_row, rows)]


def _row(cells: tuple[str, ...]) -> str:
    return "| " + " | ".join(" ".join(cell.replace("|", "\\|").split()) for cell in cells) + " |"
