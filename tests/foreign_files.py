"""What tests of other tools' formats share: a text compiled and run, and texts that are broken at random."""

from __future__ import annotations

from hypothesis import strategies as st

from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser.unparse import rung_text
from ldc.pipeline import Compiled, compile_project
from ldc.source import SourceFile
from runtime.vm.machine import Machine


def compiled(text: str, path: str) -> Compiled:
    return compile_project(Sources((SourceFile(path, text),), Settings(), None))


def said(result: Compiled) -> list[str]:
    """Findings but notes, as code and message."""
    return [f"{d.code} {d.message}" for d in result.diagnostics if d.severity != "note"]


def remarks(result: Compiled) -> list[tuple[str, str, str]]:
    return [(r.kind, r.what, r.into) for file in result.project.files for r in file.remarks]


def machine(text: str, path: str) -> Machine:
    result = compiled(text, path)
    assert result.program is not None, said(result)
    return Machine(result.program)


def run(text: str, path: str, rows: list[dict], watch: str) -> list[str]:
    """The watched variables after each scan; a row sets variables before its scan."""
    running, found = machine(text, path), []
    for row in rows:
        for name, value in row.items():
            running.set(name, value)
        running.scan()
        found.append(" ".join(str(int(running.get(name))) for name in watch.split()))
    return found


def drawn(text: str, path: str, pou: str) -> list[str]:
    """The rungs of a POU as text in one line each."""
    result = compiled(text, path)
    (body,) = [p.body for f in result.project.files for p in f.pous if p.name == pou]
    return [" ".join(rung_text(r).split()) for r in body.rungs]


def broken(text: str) -> st.SearchStrategy[str]:
    """The text with some characters changed, taken out or put in, cut, or with lines that changed places."""
    places = st.integers(0, len(text))
    piece = st.one_of(
        st.text(max_size=3), st.sampled_from(("-1", "99999999999", "/", ",", "END", "\n", "@", "("))
    )

    def changed(edits: list[tuple[int, int, str]]) -> str:
        made = text
        for at, length, new in edits:
            made = made[:at] + new + made[at + length :]
        return made

    edits = st.lists(st.tuples(places, st.integers(0, 4), piece), min_size=1, max_size=4).map(changed)
    swapped = st.permutations(range(text.count("\n") + 1)).map(
        lambda order: "\n".join(text.split("\n")[i] for i in order))
    return st.one_of(edits, places.map(lambda at: text[:at]), swapped)
