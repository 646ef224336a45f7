"""Files of other tools, damaged at random: `python tests/fuzz_importers.py --seconds 600 [PATH ...]`.

Takes the examples of this repository and, when it lies beside it, the collection of files that others drew.
Every damaged file is compiled, and its findings are rendered with their drawings. What raises, and what takes
longer than `--limit` seconds, is reported once per place in the code, and kept with `--keep FOLDER`. Status 1
when there was something.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import signal
import sys
import time
import traceback
from pathlib import Path

from ldc.diagnostics import Diagnostics
from ldc.draw import Locator
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser.formats import SUFFIXES
from ldc.pipeline import Options, compile_project
from ldc.reading import read_source
from ldc.render import render
from ldc.reports import json_report, sarif_report
from ldc.source import SourceFile

ROOT = Path(__file__).resolve().parent.parent
FOLDERS = (ROOT.parent / "shared" / "corpus", ROOT / "samples", ROOT / "tests" / "errors")
LARGEST = 60_000
"""Characters of a file that is damaged: larger ones take too long to be tried often."""
WORDS = (
    "0", "1", "-1", "2147483648", "99999999999999999999", "1e400", "TRUE", "T#1s", "''", '""', "(", ")", "[",
    "]", "{", "}", "<", ">", "<a>", "</a>", "&amp;", "&#0;", "&#x110000;", "<![CDATA[", "]]>", "<!--", "\n",
    "\t", "\0", ";", ",", ":", ":=", "=>", "@n1", ">>", "END_PROGRAM", "END_VAR", "VAR", "RUNG", "%IX0.0",
    "%QW99999999", "é", "\ufeff", "\U0001f600", "NOT ", " OR ", "localId", 'refLocalId="1"',
    'typeName="CTU"', 'negated="true"', "null", "[[[[[[[[", "XIC(a)", "OTE(b)", "BST ", "NXB ", "BND ",
    "SERIES", "PARALLEL", "END",
)


VALUES = re.compile(r"""(?<=")[^"<>\n]*(?=")|(?<=>)[^<>]+(?=</)|(?<=[ ,:(\[])[\w.+-]+(?=[ ,;:)\]\n])""")
LEAVES = re.compile(r"<(\w[\w:.-]*)[^<>]*(?:/>|>[^<>]*</\1>)|<(\w[\w:.-]*)[^<>]*>(?:\s*<[^<>]*/>)*\s*</\2>")
PLAIN = tuple(word for word in WORDS if not set(word) & set("<>&\"\0\n"))


def bent(text: str, random_: random.Random) -> str:
    """The text with some values changed, and leaves of XML moved, so that it is often still well-formed."""
    for _ in range(random_.choice((1, 1, 2, 3, 6))):
        pattern = LEAVES if "<" in text and random_.random() < 0.4 else VALUES
        places = [match.span() for match in pattern.finditer(text)]
        if not places:
            break
        (a, b), (c, d) = random_.choice(places), random_.choice(places)
        new = random_.choice(PLAIN) if pattern is VALUES and random_.random() < 0.4 else text[c:d]
        match random_.randrange(4):
            case 0:
                text = text[:a] + text[b:]
            case 1 if pattern is LEAVES:
                text = text[:b] + new + text[b:]
            case _:
                text = text[:a] + new + text[b:]
    return text


def damaged(text: str, other: str, random_: random.Random) -> str:
    """One to four things are done to a text; ``other``: a text that parts may come from."""
    if random_.random() < 0.6:
        return bent(text, random_)
    for _ in range(random_.randint(1, 4)):
        a = random_.randrange(len(text) + 1)
        b = min(len(text), a + random_.choice((1, 2, 8, 40, 400)))
        match random_.randrange(9):
            case 0:
                text = text[:a]
            case 1:
                text = text[:a] + text[b:]
            case 2:
                text = text[:b] + text[a:b] * random_.choice((1, 2, 30)) + text[b:]
            case 3:
                text = text[:a] + random_.choice(WORDS) * random_.choice((1, 1, 1, 200)) + text[a:]
            case 4:
                text = text[:a] + random_.choice(WORDS) + text[b:]
            case 5:
                start = random_.randrange(len(other) + 1)
                text = text[:a] + other[start : start + 200] + text[b:]
            case 6:
                lines = text.splitlines(keepends=True)
                random_.shuffle(lines) if random_.random() < 0.1 else lines.reverse()
                text = "".join(lines)
            case 7:
                digits = [i for i, c in enumerate(text) if c.isdigit()]
                if digits:
                    at = random_.choice(digits)
                    text = text[:at] + random_.choice("0123456789") + text[at + 1 :]
            case _:
                lines = text.splitlines(keepends=True)
                if len(lines) > 1:
                    i, j = random_.randrange(len(lines)), random_.randrange(len(lines))
                    lines[i], lines[j] = lines[j], lines[i]
                    text = "".join(lines)
    return text


def compile_and_show(source: SourceFile) -> None:
    """All that a command does with a source, but for running it."""
    result = compile_project(Sources((source,), Settings(), None), Options(keep=False))
    locate = Locator(result.project.files)
    render(result.diagnostics, locate=locate)
    json_report(result.diagnostics, locate)
    sarif_report(result.diagnostics, locate)


def sources(paths: list[Path]) -> list[SourceFile]:
    """The files to damage: those that a reader takes, but for huge ones."""
    endings = {*SUFFIXES, ".ld", ".st", ".il"}
    found = []
    for path in paths:
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file() and (file.suffix.lower() in endings or "corpus" in file.parts):
                source = read_source(file, file.name, Diagnostics())
                if source is not None and 0 < len(source.text) <= LARGEST:
                    found.append(source)
    return found


class TooSlow(Exception):
    """Raised by the alarm."""


def _alarm(*_) -> None:
    raise TooSlow


def attempt(source: SourceFile, limit: int) -> str:
    """What goes wrong with a source, its place in the first line; empty when nothing does. A process of its
    own tries, so that a crash of the interpreter is a finding too."""
    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.close(reading)
        said = ""
        signal.signal(signal.SIGALRM, _alarm)
        signal.alarm(limit)
        try:
            compile_and_show(source)
        except BaseException as error:
            said = f"{where(error)}\n{traceback.format_exc(limit=-4)}"
        signal.alarm(0)
        with os.fdopen(writing, "w", encoding="utf-8", errors="replace") as pipe:
            pipe.write(said[:20_000])
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, encoding="utf-8") as pipe:
        said = pipe.read()
    _, status = os.waitpid(child, 0)
    ended = f"the interpreter ended with status {status} ({source.path.rpartition('.')[2]})"
    return said or (ended if status else "")


def where(error: BaseException) -> str:
    """The place in the code that raised, which tells findings apart."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "/ldc/" in f.filename]
    at = f"{Path(frames[-1].filename).name}:{frames[-1].lineno}" if frames else "?"
    return f"{type(error).__name__} at {at}"


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    existing = [folder for folder in FOLDERS if folder.exists()]
    parser.add_argument("paths", nargs="*", type=Path, default=existing)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=int, default=20, help="seconds that one file may take")
    parser.add_argument("--keep", type=Path, help="folder for the files that fail")
    options = parser.parse_args(arguments)
    random_, files = random.Random(options.seed), sources(options.paths)
    if not files:
        parser.error("nothing to damage")
    for source in {source.path.rpartition(".")[2]: source for source in files}.values():
        attempt(source, options.limit) or compile_and_show(source)  # what it loads is loaded once
    found: dict[str, str] = {}
    tried, slowest, end = 0, 0.0, time.monotonic() + options.seconds
    while time.monotonic() < end:
        source, other = random_.choice(files), random_.choice(files)
        text = damaged(source.text, other.text, random_)
        tried, begin = tried + 1, time.monotonic()
        said = attempt(SourceFile(source.path, text), options.limit)
        slowest = max(slowest, time.monotonic() - begin)
        place = said.partition("\n")[0]
        if said and place not in found:
            found[place] = source.path
            print(f"a damaged {source.path}: {said}", flush=True)
            if options.keep:
                options.keep.mkdir(parents=True, exist_ok=True)
                kept = options.keep / f"{len(found):03}-{source.path}"
                kept.write_text(text, encoding="utf-8", errors="replace", newline="")
    print(f"{tried} files tried from {len(files)}, {len(found)} findings, the slowest took {slowest:.1f} s")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
