"""What ladders mean, by example: the same drawing as text and as PLCopen XML does the same, scan by scan."""

from __future__ import annotations

from dataclasses import dataclass

import pytest
from plcopen_xml import block, coil, contact, ladder, rail, result, value

from ldc.manifest import Sources
from ldc.model.settings import Settings
from ldc.pipeline import Compiled, compile_project
from ldc.source import SourceFile
from runtime.vm.machine import Machine


@dataclass(frozen=True)
class Example:
    """``rungs`` and ``drawn`` say the same. ``inputs``: what is set before each scan; ``rows``: the watched
    variables after it. ``bools`` and ``others``: what is declared, ``others`` as ``name : TYPE``."""

    bools: str
    rungs: str
    drawn: tuple[str, ...]
    watch: str
    inputs: tuple[dict, ...]
    rows: tuple[str, ...]
    others: str = ""

    @property
    def text(self) -> str:
        others = "".join(f" {line.strip()};" for line in self.others.split(";") if line.strip())
        names = ", ".join(self.bools.split())
        return f"PROGRAM main\nVAR {names} : BOOL;{others} END_VAR\n{self.rungs}\nEND_PROGRAM\n"

    @property
    def xml(self) -> str:
        return ladder(f"{self.bools} : BOOL; {self.others}", rail(), *self.drawn)


EXAMPLES = {
    "a contact is not read again for a second coil": Example(
        "a q", "RUNG [/a] (a) (q)",
        (contact(2, "a", negated="true"), coil(3, "a", 2), coil(4, "q", 2)), "a q",
        ({}, {}, {}), ("1 1", "0 0", "1 1")),
    "a coil that is not negated sees the power of before": Example(
        "a q w", "RUNG [a] { (/a) | (q) }; RUNG [a] (w)",
        (contact(2, "a"), coil(3, "a", 2, negated="true"), coil(4, "q", 2), contact(5, "a", at=(20, 50)),
         coil(6, "w", 5, at=(60, 50))), "a q w", ({}, {}, {"a": 1}), ("1 0 1", "0 1 0", "0 1 0")),
    "ENO is written before what follows reads it": Example(
        "a q w", "RUNG [a] <DIV(IN1 := 10, IN2 := i, OUT => j)> (q) [q] (w)",
        (contact(2, "a"), value(3, "10"), value(4, "i"),
         block(5, "DIV", {"EN": 2, "IN1": 3, "IN2": 4}, ("ENO", "OUT")),
         result(6, "j", "5.OUT"), coil(7, "q", "5.ENO"), contact(8, "q", 7), coil(9, "w", 8)), "q w j",
        ({"a": 1, "i": 0}, {"i": 5}, {"a": 0, "i": 1}), ("0 0 0", "1 1 2", "0 0 2"), "i : INT; j : INT"),
    "one edge contact feeds two coils by one memory": Example(
        "a q w", "RUNG [P a] (q) (w)",
        (contact(2, "a", edge="rising"), coil(3, "q", 2), coil(4, "w", 2)), "q w",
        ({}, {"a": 1}, {}, {"a": 0}, {"a": 1}), ("0 0", "1 1", "0 0", "0 0", "1 1")),
    "two edge contacts of one variable have a memory each": Example(
        "a b q w", "RUNG [P a] (q)\nRUNG [b] [P a] (w)",
        (contact(2, "a", edge="rising"), coil(3, "q", 2), contact(4, "b", at=(20, 50)),
         contact(5, "a", 4, at=(40, 50), edge="rising"), coil(6, "w", 5, at=(60, 50))), "q w",
        ({"b": 1}, {"a": 1}, {}), ("0 0", "1 1", "0 0")),
    "parallel branches to one coil are ORed": Example(
        "a b c q", "RUNG { [a] | [b] | [/c] } (q)",
        (contact(2, "a"), contact(3, "b", at=(20, 30)), contact(4, "c", at=(20, 50), negated="true"),
         coil(5, "q", (2, 3, 4))), "q", ({"c": 1}, {"a": 1}, {"b": 1}, {"a": 0}, {"b": 0}, {"c": 0}),
        ("0", "1", "1", "1", "0", "1")),
    "the last of two coils of one variable wins": Example(
        "a b q", "RUNG [a] (q)\nRUNG [b] (q)",
        (contact(2, "a"), coil(3, "q", 2), contact(4, "b", at=(20, 50)), coil(5, "q", 4, at=(60, 50))), "q",
        ({"a": 1}, {"b": 1}, {"a": 0}), ("0", "1", "1")),
    "chained coils pass power": Example(
        "a q w z", "RUNG [a] (q) (/w) (S z)",
        (contact(2, "a"), coil(3, "q", 2), coil(4, "w", 3, negated="true"), coil(5, "z", 4, storage="set")),
        "q w z", ({}, {"a": 1}, {"a": 0}), ("0 1 0", "1 0 1", "0 1 1")),
    "a contact behind a coil reads what the coil wrote": Example(
        "a q w", "RUNG [a] (q) [/q] (w)",
        (contact(2, "a"), coil(3, "q", 2), contact(4, "q", 3, negated="true"), coil(5, "w", 4)), "q w",
        ({}, {"a": 1}), ("0 0", "1 0")),
    "a reset wins over a set that stands before it": Example(
        "a b q", "RUNG [a] (S q)\nRUNG [b] (R q)",
        (contact(2, "a"), coil(3, "q", 2, storage="set"), contact(4, "b", at=(20, 50)),
         coil(5, "q", 4, at=(60, 50), storage="reset")), "q",
        ({"a": 1}, {"b": 1}, {"a": 0, "b": 0}), ("1", "0", "0")),
    "a timer in a dead branch runs down": Example(
        "a b q", "RUNG [a] [b] <t: TOF(PT := T#20ms)> (q)",
        (contact(2, "a"), contact(3, "b", 2), value(4, "T#20ms"),
         block(5, "TOF", {"IN": 3, "PT": 4}, ("Q",), "t"), coil(6, "q", "5.Q")), "q",
        ({"a": 1, "b": 1}, {"a": 0}, {}, {}), ("1", "1", "1", "0"), "t : TOF"),
    "a counter is reset by its own output in the next scan": Example(
        "a q", "RUNG [a] <n: CTU(R := { [n.Q] }, PV := 2)> (q)",
        (contact(2, "a"), contact(3, "n.Q"), value(4, "2"),
         block(5, "CTU", {"CU": 2, "R": 3, "PV": 4}, ("Q", "CV"), "n"), coil(6, "q", "5.Q")), "q n.CV",
        ({"a": 1}, {"a": 0}, {"a": 1}, {"a": 0}, {"a": 1}), ("0 1", "0 1", "1 2", "0 0", "0 1"), "n : CTU"),
}


def compiled(path: str, source: str) -> Compiled:
    result = compile_project(Sources((SourceFile(path, source),), Settings(), None))
    assert result.program is not None, [d.message for d in result.diagnostics]
    return result


def trace(path: str, source: str, example: Example) -> tuple[str, ...]:
    machine, rows = Machine(compiled(path, source).program), []
    for row in example.inputs:
        for name, given in row.items():
            machine.set(name, given)
        machine.scan()
        rows.append(" ".join(str(int(machine.get(name))) for name in example.watch.split()))
    return tuple(rows)


@pytest.mark.parametrize("title", EXAMPLES)
def test_text(title: str) -> None:
    example = EXAMPLES[title]
    assert trace("main.ld", example.text, example) == example.rows


@pytest.mark.parametrize("title", EXAMPLES)
def test_drawing(title: str) -> None:
    example = EXAMPLES[title]
    assert trace("plc.xml", example.xml, example) == example.rows


@pytest.mark.parametrize("path", ["main.ld", "plc.xml"])
def test_an_edge_contact_that_feeds_two_coils_has_one_hidden_variable(path: str) -> None:
    example = EXAMPLES["one edge contact feeds two coils by one memory"]
    unit = compiled(path, example.text if path == "main.ld" else example.xml).program.unit("main")
    assert sum(v.name.startswith("_ldc_r") for v in unit.variables) == 1

