"""Compiles that remember rungs give what a fresh compile gives, whatever was edited in between
(docs/incremental.md)."""

from __future__ import annotations

import tempfile
from pathlib import Path

from hypothesis import example, given, settings
from hypothesis import strategies as st

from ldc import pipeline
from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.parser.unread import UnreadPaths
from ldc.pipeline.memory import Memory, memory_of
from ldc.source import SourceFile

TEXT = """TYPE colour : (red, green, blue); pair : STRUCT a : INT; b : BOOL; END_STRUCT; level : INT (0..9); END_TYPE
VAR_GLOBAL shared : BOOL; total : INT := 3; END_VAR
VAR_GLOBAL CONSTANT most : INT := 4; END_VAR
FUNCTION_BLOCK watch
VAR_INPUT run : BOOL; limit : INT := 5; END_VAR
VAR_OUTPUT q : BOOL; n : INT; END_VAR
VAR x : BOOL; END_VAR
RUNG [P run] <ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG [n > limit] (q)
END_FUNCTION_BLOCK
FUNCTION twice : INT
VAR_INPUT v : INT; END_VAR
RUNG <ADD(IN1 := v, IN2 := v, OUT => twice)>
END_FUNCTION
PROGRAM first "One"
VAR a AT %IX0.0 : BOOL; b AT %IX0.1 : BOOL; q AT %QX0.0 : BOOL; END_VAR
VAR x, y, z, shown : BOOL; n : INT; s : pair; c : colour; l : level; END_VAR
VAR f : ARRAY[1..4] OF INT; w : watch; t : TON; d : WORD; END_VAR
RUNG seal "Seal in" { [a] | [q] } [/b] (q)
RUNG [a] (x)
RUNG [b] (x)
RUNG [P a] (S y)
RUNG { [a] @m [b] | [x] @k [y] } (z); @m [y] @k
RUNG { [a] @m [b] | [x] @k [y] } (shown); @m [y] @k
RUNG [a] <w: watch(limit := most)> (y)
RUNG [w.n > f[2]] (z)
RUNG [a] <MOVE(IN := twice(n), OUT => f[n + 1])>
RUNG [n / total > 1] <MOVE(IN := n, OUT => s.a)>
RUNG [c = red] (s.b)
RUNG [a] >>seal
RUNG [d.3] [x] <t: TON(PT := T#2s)> (z)
RUNG [%IX0.1] [b] (%QX0.3)
RUNG rest (* why *) [shared] (y)
END_PROGRAM
PROGRAM second
VAR a, q, x : BOOL; n : INT; END_VAR
RUNG [a] (x)
RUNG seal { [a] | [q] } [/x] (q)
RUNG [a] <MOVE(IN := n, OUT => total)>
RUNG [a] >>RETURN
END_PROGRAM
"""
WORDS = ("a", "b", "x", "n", "red", "seal", "rest", "shared", "most", "total", "limit", "w", "%IX0.0", "%IX0.1",
         "INT", "DINT", "BOOL", "TON", "TOF", "watch", "twice", "4", "1", "nothing", "CONSTANT", "VAR_GLOBAL",
         "VAR", "AT %IX0.1", "AT %IX0.4", "", "P ", "/", "'", "(*")
LINES = TEXT.splitlines()
SMALL = ["PROGRAM p", "VAR a, b : BOOL; END_VAR", "RUNG [a] (b)", "END_PROGRAM"]

edits = st.lists(st.one_of(
    st.tuples(st.just("swap"), st.integers(0, 45), st.integers(0, 45)),
    st.tuples(st.just("delete"), st.integers(0, 45), st.just(0)),
    st.tuples(st.just("copy"), st.integers(0, 45), st.integers(0, 45)),
    st.tuples(st.just("space"), st.integers(0, 45), st.integers(0, 9)),
    st.tuples(st.sampled_from(WORDS[:-4]), st.sampled_from(WORDS), st.integers(0, 9))), min_size=1, max_size=4)


def edited(lines: list[str], changes: list) -> list[str]:
    lines = list(lines)
    for what, one, other in changes:
        if isinstance(one, str):
            at = -1
            text = "\n".join(lines)
            for _ in range(other + 1):
                found = text.find(what, at + 1)
                at = found if found >= 0 else at
            if at >= 0:
                text = text[:at] + one + text[at + len(what):]
            lines = text.split("\n")
            continue
        one, other = one % len(lines), other % len(lines)
        if what == "swap":
            lines[one], lines[other] = lines[other], lines[one]
        elif what == "delete" and len(lines) > 1:
            del lines[one]
        elif what == "copy":
            lines.insert(other, lines[one])
        else:
            lines[one] = " " * other + lines[one]
    return lines


def compiled(lines: list[str], memory: Memory | None, **more) -> pipeline.Compiled:
    source = SourceFile("main.ld", "\n".join(lines) + "\n")
    return pipeline.compile_project(Sources((source,), Settings(), None),
                                    pipeline.Options(keep=False, memory=memory, **more))


def told(result: pipeline.Compiled) -> list:
    """Findings with all their places; the image says the rest: code, spans, verdicts."""
    def place(label):
        return label.span.start, label.span.end, label.text

    return [(d.code, d.message, d.help, d.severity, d.primary and place(d.primary),
             [*map(place, d.secondary)]) for d in result.diagnostics]


def same(lines: list[str], path: Path, **more) -> pipeline.Compiled:
    fresh, recalled = compiled(lines, None, **more), compiled(lines, Memory(path), **more)
    assert told(recalled) == told(fresh)
    assert (fresh.image is None) == (recalled.image is None)
    if fresh.image is not None:
        assert recalled.image.data == fresh.image.data
        verdicts = [[build.verdict for builds in made.units.values() for build in builds]
                    for made in (fresh, recalled)]
        assert verdicts[0] == verdicts[1]
    return recalled


def read(result: pipeline.Compiled) -> int:
    """How many rungs were compiled anew."""
    rungs = [build.rung for builds in result.units.values() for build in builds]
    return sum(not isinstance(rung.paths, UnreadPaths) for rung in rungs)


@given(st.lists(edits, min_size=1, max_size=4))
@settings(max_examples=35, deadline=None)
@example([[("%IX0.1", "%IX0.0", 0)]])
@example([[("total", "shared", 0)], [("shared", "total", 0)]])
@example([[("INT", "DINT", 0)], [("INT", "DINT", 2)], [("INT", "DINT", 5)]])
def test_random_edits_give_what_a_fresh_compile_gives(changes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "memory.rungs")
        lines = LINES
        same(lines, path)
        for some in changes:
            lines = edited(lines, some)
            same(lines, path)
        same(LINES, path)


def test_only_what_an_edit_touches_is_compiled_anew(tmp_path) -> None:
    path = tmp_path / "memory.rungs"
    first = same(LINES, path)
    assert first.image is not None and read(first) == 22
    told_of = read(same(LINES, path))  # notes about bridges, a warning about a coil: made again, told again
    assert told_of < 4
    changed = [line.replace("[/b] (q)", "[/y] (q)") for line in LINES]
    assert read(same(changed, path)) == told_of + 1
    assert read(same(["(* moved *)", *changed], path)) == told_of
    assert read(same([line.replace("x, y, z", "more, x, y, z") for line in changed], path)) == told_of
    same([line.replace("x, y, z", "x, y, z, x") for line in changed], path)  # wrong: nothing is forgotten
    assert read(same(changed, path)) == told_of
    options = {"max_paren_depth": 1}
    same(changed, path, **options)
    same(changed, path, verify=False)
    same(changed, path)


def test_what_a_rung_depends_on_makes_it_another_one(tmp_path, monkeypatch) -> None:
    """A declaration far away changes what the code of an unchanged rung is."""
    for number, (old, new) in enumerate((
            ("total : INT := 3", "total : DINT := 3"), ("most : INT := 4", "most : INT := 6"),
            ("limit : INT := 5", "limit : INT := 7"), ("(red, green", "(green, red"),
            ("twice : INT", "twice : DINT"), ("b AT %IX0.1", "b AT %IX0.0"), ("ARRAY[1..4]", "ARRAY[0..4]"), ("a : INT; b", "a : DINT; b"))):
        path = tmp_path / f"{number}.rungs"
        same(LINES, path)
        same("\n".join(LINES).replace(old, new, 1).split("\n"), path)


def test_a_damaged_file_counts_as_none_and_files_are_few(tmp_path, monkeypatch) -> None:
    path = tmp_path / "memory.rungs"
    same(LINES, path)
    data = bytearray(path.read_bytes())
    for at in (0, 40, len(data) // 2, len(data) - 1):
        broken = bytearray(data)
        broken[at] ^= 1
        path.write_bytes(broken)
        assert Memory(path).rows(b"") is None
        same(LINES, path)
    path.write_bytes(b"")
    same(LINES, path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for number in range(40):
        compiled(SMALL, memory_of(f"/p{number}"))
    assert len(list((tmp_path / "cache" / "ldc" / "rungs").iterdir())) == 32


def test_rungs_that_are_gone_are_forgotten(tmp_path) -> None:
    path = tmp_path / "memory.rungs"
    same(LINES, path)
    size = path.stat().st_size
    same([line for line in LINES if "watch" not in line and "w.n" not in line], path)
    same(SMALL, path)
    assert path.stat().st_size < size / 5
