"""The fenced blocks of a document: taken out, compiled, and run as a reader would run them.

The first word behind a fence is the language. ``ld``: compiled; a block that is only ``VAR ... END_VAR``
declares what the rungs in the blocks after it use. Words such as ``LD0303`` are the findings that it must
give. A word with a dot is a file name: the block is written there, in the folder of the document.
``console``: every line ``$ ldc ...`` (or ``$ cat FILE``, ``$ echo $?``) is run there, and what follows must be
what it prints; ``...`` stands for any text, alone in a line for any lines.
"""

from __future__ import annotations

import re
import shlex
import tempfile
from collections.abc import Iterator
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path

from ldc import pipeline
from ldc.cli.main import main
from ldc.diagnostics import Severity

_FENCE = re.compile(r"^```(\w+)([^\n]*)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
_HEAD = re.compile(r"\s*(?:(?:\(\*.*?\*\)|//[^\n]*)\s*)*", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Block:
    """``start`` and ``end``: where its text stands in the document; ``line``: of its fence, from 1."""

    language: str
    words: tuple[str, ...]
    text: str
    line: int
    start: int
    end: int

    @property
    def file(self) -> str | None:
        return next((word for word in self.words if "." in word), None)

    @property
    def codes(self) -> list[str]:
        return sorted(word for word in self.words if re.fullmatch(r"LD\d{4}", word))


def blocks(text: str) -> Iterator[Block]:
    """The fenced blocks that have a language, in order."""
    for match in _FENCE.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        yield Block(match[1], tuple(match[2].split()), match[3], line, match.start(3), match.end(3))


def programs(text: str) -> Iterator[tuple[Block, str]]:
    """Each ``ld`` block with the whole program that it stands for."""
    declared = ""
    for block in blocks(text):
        if block.language != "ld":
            continue
        body = block.text[_HEAD.match(block.text).end():]
        if body.startswith("VAR") and not body.startswith("VAR_GLOBAL"):
            declared = block.text
        elif body.startswith("RUNG"):
            yield block, f"PROGRAM main\n{declared}\n{block.text}END_PROGRAM\n"
        else:
            yield block, block.text


def findings(program: str, path: Path) -> list[str]:
    """Codes of the errors and warnings that the program gives, sorted."""
    path.write_text(program, encoding="utf-8")
    found = pipeline.compile_paths([str(path)]).diagnostics
    return sorted({d.code for d in found if d.severity is not Severity.NOTE})


def dialogue(text: str) -> list[tuple[str, str]]:
    """The commands of a console block, each with the output that follows it."""
    parts = re.split(r"^\$ (.*)\n", text, flags=re.MULTILINE)
    assert not parts[0].strip(), "a console block begins with a command"
    return list(zip(parts[1::2], parts[2::2], strict=True))


class Shell:
    """Runs commands in the current folder; keeps the last exit status."""

    def __init__(self) -> None:
        self.status = 0

    def run(self, command: str) -> str:
        """What the command prints, on both streams in the order of printing."""
        name, *arguments = shlex.split(command, comments=True)
        if command == "echo $?":
            return f"{self.status}\n"
        if name == "cat":
            return "".join(Path(argument).read_text(encoding="utf-8") for argument in arguments)
        assert name == "ldc", command
        # A file, not a string: processes that a command starts write into it as well.
        with tempfile.TemporaryFile("w+", encoding="utf-8") as printed:
            with redirect_stdout(printed), redirect_stderr(printed):
                self.status = main(arguments)
            printed.seek(0)
            return printed.read()


def agrees(expected: str, printed: str) -> bool:
    """Whether the output is the expected one, blank lines at the end and ``...`` aside."""
    lines = []
    for line in expected.rstrip("\n").split("\n"):
        if line.strip() == "...":
            lines.append(r"(?:.*\n)*?")
        else:
            lines.append(".*?".join(map(re.escape, line.split("..."))) + r"\n")
    return re.fullmatch("".join(lines), printed.rstrip("\n") + "\n") is not None


def replay(text: str) -> str:
    """The document with the output that its commands print now; what agrees stays as it is."""
    shell, made, at = Shell(), [], 0
    for block in blocks(text):
        if block.file:
            path = Path(block.file)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.text, encoding="utf-8")
        elif block.language == "console":
            made.append(text[at:block.start])
            at = block.end
            for command, expected in dialogue(block.text):
                printed = shell.run(command)
                if not agrees(expected, printed):
                    expected = printed.rstrip("\n") + "\n" if printed.strip() else ""
                made.append(f"$ {command}\n{expected}")
    return "".join(made) + text[at:]
