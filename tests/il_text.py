"""IL as a person types it, for tests: text in, units and findings out."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.expr import Const, Place
from ldc.il import standard
from ldc.il.program import Unit
from ldc.il.text import parse_unit
from ldc.model import Scope, resolve
from ldc.parser import ast, parse_file
from ldc.source import SourceFile
from ldc.types import BOOL, DINT, INT, REAL, TIME, WORD, Instance


def read_all(text: str) -> tuple[dict[str, Unit], Diagnostics]:
    """The units of a whole ``.il`` text by name in capitals, and the findings."""
    diagnostics = Diagnostics()
    project = ast.Project((parse_file(SourceFile("test.il", text), diagnostics),))
    model = resolve(project, diagnostics)
    units = {}
    for name in model.order:
        unit = parse_unit(model.pous[name], Scope(model, name), diagnostics)
        if unit is not None:
            units[name] = unit
    return units, diagnostics


VARIABLES = """VAR
    a, b, c : BOOL;
    i, j : INT;
    d : DINT;
    u : UINT;
    x : REAL;
    y : LREAL;
    n : BYTE;
    w : WORD;
    t : TIME;
    day : DATE;
    clock : TIME_OF_DAY;
    text : STRING[20];
    delay : TON;
    count : CTU;
    latch : SR;
    timers : ARRAY [0..1] OF TON;
    list : ARRAY [1..4] OF INT;
END_VAR
VAR CONSTANT
    most : INT := 7;
END_VAR
"""


def read(body: str, before: str = "") -> tuple[Unit | None, Diagnostics]:
    """A PROGRAM with the variables above; ``before``: other POUs and types."""
    units, diagnostics = read_all(f"{before}PROGRAM main\n{VARIABLES}{body}\nEND_PROGRAM\n")
    return units.get("MAIN"), diagnostics


def code(body: str, before: str = "") -> list[str]:
    """The instructions of a body that must be right, one text each."""
    unit, diagnostics = read(body, before)
    assert unit is not None, [f"{d.code} {d.message}" for d in diagnostics]
    return [line(i) for rung in unit.rungs for i in ([] if rung.label is None else [f"{rung.label}:"])
            + list(rung.code)]


def line(instr) -> str:
    if isinstance(instr, str):
        return instr
    if instr.op == "LABEL":
        return f"{instr.name}:"
    operand = instr.operand
    shown = repr(operand.value) if isinstance(operand, Const) else str(operand) if operand is not None else ""
    args = ", ".join(repr(a.value) if isinstance(a, Const) else str(a) for a in instr.args)
    outputs = "".join(f" {name}=>{place}" for name, place in instr.outputs)
    return " ".join(filter(None, (instr.op, str(instr.type), instr.name, shown, args))) + outputs


A, B, Q = Place("a", BOOL), Place("b", BOOL), Place("q", BOOL)
I, D, X, W, T = Place("i", INT), Place("d", DINT), Place("x", REAL), Place("w", WORD), Place("t", TIME)
DELAY = Place("delay", Instance("TON"))


def library(*names: str) -> tuple[Unit, ...]:
    return tuple(standard.unit(name) for name in names)
