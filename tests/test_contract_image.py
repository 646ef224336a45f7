"""Contract: images are the same bytes for the same input, and layouts stay (DESIGN section 4)."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from contract import good, program

from ldc.il import text
from ldc.il.image import Image, load

SAMPLES = Path(__file__).resolve().parent.parent / "samples"
PLAIN = program("RUNG x [P a] (b)\nRUNG [b] (c)", "a, b, c : BOOL; n : DINT; z : INT;")


def offsets(image: Image) -> dict[str, int]:
    return {s.path: s.offset for s in image.layout.symbols}


@pytest.mark.parametrize("other", [
    PLAIN.replace("RUNG", "(* why *)\n\n  RUNG").replace("END_VAR", "// all\nEND_VAR // of them"),
    PLAIN.replace("[b] (c)", "[ b ]\n\t( c ) ;"),
    PLAIN.replace("RUNG x", 'RUNG x "a title"'),
    PLAIN.replace("[P a]", "[p A]").replace("[b]", "[B]").replace("END_VAR", "end_var"),
])
def test_comments_layout_and_case_leave_the_digest(other: str) -> None:
    assert good(other).image.digest == good(PLAIN).image.digest


@pytest.mark.parametrize(("old", "new"), [
    ("[b]", "[/b]"), ("z : INT", "z : INT := 1"), ("z : INT", "z : UINT"), ("RUNG x", "RUNG y"),
    ("n :", "m :"),
])
def test_what_matters_changes_the_digest(old: str, new: str) -> None:
    assert good(PLAIN.replace(old, new)).image.digest != good(PLAIN).image.digest


def test_the_same_bytes_in_every_process() -> None:
    """Whatever order Python hashes names in."""
    script = ("import hashlib, sys\nfrom ldc.pipeline import compile_paths\n"
              "print(*(hashlib.sha256(compile_paths([p]).image.data).hexdigest() for p in sys.argv[1:]))")
    folders = [p.as_posix() for p in sorted(SAMPLES.iterdir()) if (p / "ldc.toml").exists()]
    assert folders
    command = [sys.executable, "-c", script, *folders]
    found = [subprocess.run(command, capture_output=True, text=True, check=True,
                            env=os.environ | {"PYTHONHASHSEED": seed}).stdout for seed in ("1", "2")]
    assert found[0] == found[1]


def test_an_image_is_read_back_whole() -> None:
    image = good(PLAIN).image
    again = load(image.data)
    assert (again.layout, again.digest, again.data) == (image.layout, image.digest, image.data)
    code, read = ([i for rung in made.program.units[0].rungs for i in rung.code] for made in (image, again))
    assert code == read
    assert [(i.element, str(i.span), i.span.text) for i in code] == [
        (i.element, str(i.span), i.span.text) for i in read]
    assert text.print_program(again.program) == text.print_program(image.program)


def test_printed_il_makes_the_same_image_every_time() -> None:
    printed = text.print_program(good(PLAIN).program)
    noted = printed.replace("    LD ", "  LD    ").replace("END_VAR", "END_VAR (* declared *)")
    assert good(noted, "a.il").image.digest == good(printed, "b.il").image.digest


def test_added_declarations_move_nothing() -> None:
    before = good(PLAIN).image
    more = PLAIN.replace("a, b", "wide : LREAL; t : TON; a, b").replace("z : INT", "y, z : INT")
    after = good(more, previous=before.layout).image
    kept = offsets(before)
    assert {path: at for path, at in offsets(after).items() if path in kept} == kept
    spans = sorted((s.offset, s.offset + s.size) for s in after.layout.symbols)
    assert all(end <= start for (_, end), (start, _) in zip(spans, spans[1:]))
    assert good(PLAIN, previous=before.layout).image.data == before.data


def test_only_what_changed_its_type_gets_another_place() -> None:
    before = good(PLAIN).image
    after = good(PLAIN.replace("n : DINT", "n : LINT"), previous=before.layout).image
    was, now = offsets(before), offsets(after)
    assert {path for path in was if was[path] != now[path]} == {"main.n"}


def test_edge_memories_keep_their_place_when_rungs_come_and_go() -> None:
    before = good(PLAIN).image
    after = good(PLAIN.replace("RUNG x", "RUNG [P b] (c)\nRUNG x"), previous=before.layout).image
    memory = next(path for path in offsets(before) if "_ldc_x_P_a" in path)
    assert offsets(after)[memory] == offsets(before)[memory]
