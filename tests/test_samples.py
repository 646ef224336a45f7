"""Every sample: drawn, reduced, lowered and proved as its goldens say; traced alike by every engine."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import pytest

from ldc import pipeline
from ldc.cli.starting import start
from ldc.diagnostics import Diagnostics
from ldc.graph import dump
from ldc.il import image
from ldc.il import text as il_text
from ldc.il.typecheck import check_unit
from ldc.source import SourceFile
from runtime import stimuli, trace
from runtime.cost import Cost
from runtime.timing import Timing
from runtime.vm.stepping import Stepper

SAMPLES = sorted(p.parent for p in (Path(__file__).parents[1] / "samples").glob("*/ldc.toml")
                 if "[plant]" not in p.read_text())
"""One with a plant has tests of its own: its inputs come from there."""
samples = pytest.mark.parametrize("folder", SAMPLES, ids=lambda p: p.name)


def compiled(folder: Path, **options) -> pipeline.Compiled:
    result = pipeline.compile_paths([str(folder)], pipeline.Options(**options))
    assert not [f"{d.code} {d.message}" for d in result.diagnostics if d.severity != "note"]
    return result


def traced(folder: Path, program, engine=lambda machine: machine, cost: Cost | None = None) -> str:
    """The trace that ``ldc run`` writes; ``engine(machine)`` has the ``scan`` to use."""
    result = compiled(folder, verify=False)
    machine = start(replace(result, program=program), None, result.sources.manifest, cost=cost)
    findings, path = Diagnostics(), folder / result.sources.manifest.inputs
    planned = stimuli.read(SourceFile(path.name, path.read_text()), machine.symbols, findings)
    assert not len(findings)
    text, scan = io.StringIO(), engine(machine).scan
    rows = trace.Trace(machine, result.sources.manifest.watch, text)
    for _ in range(planned.last + 1):
        planned.apply(machine)
        scan()
        rows.sample()
    assert not machine.faults
    return text.getvalue()


@samples
def test_stages(folder: Path, golden) -> None:
    result = compiled(folder)
    parts = []
    for pou, rungs in result.units.items():
        for build in rungs:
            parts += [f"==== {pou} / {build.code.key}: {build.verdict.kind}, {build.verdict.operands} operands",
                      dump.graph_text(build.graph), dump.tree_text(build.graph, build.tree)]
    golden(f"samples/{folder.name}.stages", "\n".join(part.rstrip("\n") for part in parts) + "\n")
    golden(f"samples/{folder.name}.il", il_text.print_program(result.program))
    golden(f"samples/{folder.name}.digest", result.image.digest + "\n")


@samples
def test_every_rung_is_proved_or_checked(folder: Path) -> None:
    for rungs in compiled(folder).units.values():
        assert {r.verdict.kind for r in rungs} <= {"proof", "check"}


@samples
def test_il_is_well_typed_at_every_nesting_limit(folder: Path) -> None:
    for limit in (None, 1, 0):
        for unit in compiled(folder, max_paren_depth=limit).program.units:
            assert not check_unit(unit)


@samples
def test_image_is_deterministic_and_reads_back(folder: Path) -> None:
    one, two = compiled(folder).image, compiled(folder).image
    assert one.data == two.data and one.digest == two.digest
    again = image.load(one.data)
    assert again.digest == one.digest and again.layout == one.layout
    assert image.build(again.program).data == one.data


@samples
def test_trace(folder: Path, golden_at) -> None:
    golden_at(folder / "expected.csv", traced(folder, compiled(folder).program))


@samples
def test_stepping_gives_the_same_trace(folder: Path) -> None:
    assert traced(folder, compiled(folder).program, Stepper) == (folder / "expected.csv").read_text()


@samples
def test_executing_by_pieces_gives_the_same_trace(folder: Path) -> None:
    def timing(machine) -> Timing:
        return Timing(machine)

    assert traced(folder, compiled(folder).program, timing, Cost()) == (folder / "expected.csv").read_text()


@samples
def test_an_image_read_from_bytes_gives_the_same_trace(folder: Path) -> None:
    program = image.load(compiled(folder).image.data).program
    assert traced(folder, program) == (folder / "expected.csv").read_text()


@samples
def test_nesting_limit_changes_no_trace(folder: Path) -> None:
    assert traced(folder, compiled(folder, max_paren_depth=0).program) == (folder / "expected.csv").read_text()
