"""Programs with other modules, messages and sequences take over from each other at any moment: no message is
lost or comes twice (docs/messages.md, docs/online.md)."""

from __future__ import annotations

import itertools
import tempfile
from pathlib import Path

from hypothesis import example, given, settings
from hypothesis import strategies as st
from test_system_online import Online

MODULES = ("beat", "counts", "works")
TEXT = """PROGRAM beat
VAR
    turn : TON;
    now  : BOOL;
END_VAR

RUNG
    [/now] <turn: TON(PT := T#30ms)> (now)
END_PROGRAM

PROGRAM counts
VAR_INPUT
    heard : BOOL;
    ended : BOOL;
    which : UDINT;
END_VAR
VAR
    all  : INT;
    ends : INT;
END_VAR

RUNG
    [heard] <ADD(IN1 := all, IN2 := 1, OUT => all)>

RUNG
    [ended] <ADD(IN1 := ends, IN2 := 1, OUT => ends)>
END_PROGRAM

PROGRAM works
VAR_INPUT
    start : BOOL;
END_VAR
VAR_OUTPUT
    done : BOOL;
END_VAR
VAR
    work : TON;
END_VAR

RUNG
    [start] <work: TON(PT := T#50ms)> (done)
END_PROGRAM
"""
BEATS = '[messages.beats]\nfrom = "beat.now"\nto = [{ module = "counts", flag = "heard" }]\n'
OTHER = '[messages.AAA]\nfrom = "works.done"\nto = ["works"]\n'
ENDS = '[messages.STOP_MODULE]\nclass = "system"\nto = [{ module = "counts", flag = "ended", data = "which" }]\n'
SEQUENCE = '[sequence]\nsteps = ["works"]\n'

Variant = tuple[tuple[str, ...], bool, bool, bool]
variants = st.tuples(st.sampled_from(list(itertools.permutations(MODULES))), st.booleans(), st.booleans(), st.booleans())


ALL, BACK = (MODULES, True, True, True), (MODULES[::-1], True, False, True)


def written(folder: Path, variant: Variant) -> Path:
    order, beats, other, sequence = variant
    listed = ", ".join(f'"{name}"' for name in order)
    (folder / "main.ld").write_text(TEXT)
    (folder / "ldc.toml").write_text(f'[project]\nname = "plant"\nmodules = [{listed}]\n' + OTHER * other
                                     + BEATS * beats + ENDS + SEQUENCE * sequence)
    return folder


@example(ALL, [(1, BACK if n % 2 else ALL, True) for n in range(1, 14)])  # in every phase of all that is under way
@settings(max_examples=10, deadline=None)
@given(first=variants, changes=st.lists(st.tuples(st.integers(1, 9), variants, st.booleans()), min_size=1, max_size=4))
def test_messages_are_neither_lost_nor_twice_over_any_changes(first: Variant, changes) -> None:
    """Counted is what rose while the program of that scan had the message; ends of modules come with the index
    that the module has then."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        run = Online(written(folder, first), "vm")
        now, before = first, False
        heard = told = ended = 0

        def scans(count: int) -> None:
            """Counts what rises in a scan, and is heard in the next one."""
            nonlocal heard, told, ended, before
            for _ in range(count):
                told += run.get("counts.ended")
                run.system.scan()
                beat = run.get("beat.now")
                heard += beat and not before and now[1]
                before = beat
                if run.get("counts.ended"):
                    ended += 1
                    assert run.get("counts.which") == now[0].index("works")
                assert run.get("counts.heard") == (beat and now[1])
                assert run.get("counts.ends") == told and ended - told in (0, 1)

        scans(5)
        for count, variant, stays in changes:
            running = now
            run.test(written(folder, variant))
            now = variant
            scans(count)
            if stays:
                run.controller.commit("me")
            else:
                run.end("cancel")
                now = running
                scans(count)
        assert run.get("counts.all") == heard - run.get("counts.heard")
        assert run.violations == [] and not run.system.machine.faults
