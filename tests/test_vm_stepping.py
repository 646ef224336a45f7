"""Stepping one IL instruction at a time does what the compiled functions do, bit by bit."""

from __future__ import annotations

from pathlib import Path
from random import Random

import everywhere
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from il_build import program, simple, unit, var

from ldc.il.program import Task
from ldc.types import DINT, INT, LREAL, REAL, SINT, TIME, UINT, WORD, Array, Field, Instance, String, Struct
from runtime.cost import Cost
from runtime.vm.machine import Machine
from runtime.vm.paced import Machine as PacedMachine
from runtime.vm.stepping import Stepper

POINT = Struct("point", (Field("x", INT), Field("on", var("_").type)))
BLOCK = unit(
    "FUNCTION_BLOCK",
    "acc",
    [
        var("IN", kind="input"),
        var("D", INT, kind="input"),
        var("N", INT, kind="output"),
        var("Q", kind="output"),
        var("k", INT, kind="temp"),
    ],
    "LD IN; ANDN Q; JMPCN out; LD N; ADD D; ST k; DIV D; ST N; LABEL out; LD IN; ST Q",
)
FUNCTION = unit(
    "FUNCTION",
    "twice",
    [var("n", INT, kind="input"), var("odd", kind="output"), var("k", INT)],
    "LD n; MOD 2; NE 0; ST odd; LD k; ADD n; ADD n; ST twice; RETC; ST k",
    result=INT,
)
NAMES = [
    *(var(n) for n in ("b0", "b1", "b2", "b3")),
    var("b4", at="%QX0.2"),
    var("b5", at="%IX0.0"),
    *(var(n, INT) for n in ("i0", "i1")),
    var("i2", INT, at="%QW0"),
    var("i3", INT, kind="temp"),
    var("b6", kind="temp"),
    var("w0", WORD),
    var("w1", WORD, at="%MW0"),
    var("raw", UINT, at="%MW0"),
    var("s0", SINT),
    var("d0", DINT),
    var("r0", REAL),
    var("r1", REAL),
    var("l0", LREAL),
    var("t0", TIME),
    var("t1", TIME),
    var("a", Array(((-1, 2),), INT)),
    var("ab", Array(((0, 1), (0, 1)), var("_").type)),
    var("p", POINT),
    var("ps", Array(((0, 1),), POINT)),
    var("f", Instance("acc")),
    var("fs", Array(((0, 2),), Instance("acc"))),
    var("str", String("STRING", 6), initial=b"abc"),
]
BOOLS = [
    "b0",
    "b1",
    "b2",
    "b3",
    "b4",
    "b5",
    "b6",
    "w0.3",
    "w1.0",
    "ab[0,1]",
    "ab[i0,i1]",
    "p.on",
    "ps[1].on",
    "f.Q",
    "fs[i0].IN",
    "f.IN",
    "TRUE",
    "FALSE",
    "%QX0.2",
    "%MX0.0",
    "%FIRST_SCAN",
]
INTS = [
    "i0",
    "i1",
    "i2",
    "i3",
    "a[0]",
    "a[i0]",
    "a[i1]",
    "p.x",
    "ps[i1].x",
    "f.N",
    "f.D",
    "0",
    "1",
    "-1",
    "2",
    "32767",
    "-32768",
]
PER_TYPE = {
    "INT": INTS,
    "WORD": ["w0", "w1", "65535:WORD", "5:WORD"],
    "SINT": ["s0", "-128:SINT", "3:SINT"],
    "DINT": ["d0", "-2147483648:DINT", "70000:DINT"],
    "REAL": ["r0", "r1", "0.1:REAL", "3e38:REAL", "0:REAL"],
    "LREAL": ["l0", "0.1:LREAL", "1e308:LREAL"],
    "TIME": ["t0", "t1", "%NOW", "9223372036854775807:TIME", "7:TIME"],
}
CONVERSIONS = {
    "INT": ["SINT", "DINT", "WORD", "REAL", "LREAL"],
    "WORD": ["INT"],
    "SINT": ["INT"],
    "DINT": ["INT", "SINT", "REAL"],
    "REAL": ["INT", "LREAL", "DINT"],
    "LREAL": ["REAL"],
    "TIME": [],
}
ARITHMETIC = {
    "WORD": ["AND", "OR", "XOR", "ANDN"],
    "TIME": ["ADD", "SUB"],
    "REAL": ["ADD", "SUB", "MUL", "DIV"],
    "LREAL": ["ADD", "SUB", "MUL", "DIV"],
}


def writable(operand: str) -> bool:
    return operand[0] not in "-0123456789TF" and operand not in ("%NOW", "%FIRST_SCAN")


class Generator:
    """Random IL from a seed; a list of rungs, each a list of lines, so that a failure can be cut down."""

    def __init__(self, seed: int) -> None:
        self.random = Random(seed)
        self.labels = 0

    def one(self, options):
        return self.random.choice(options)

    def target(self, options) -> str:
        return self.one([o for o in options if writable(o)])

    def number(self, type_: str, depth: int = 0) -> list[str]:
        """Instructions that leave a value of the type in the accumulator."""
        operands = PER_TYPE[type_]
        lines = [f"LD {self.one(operands)}"]
        for _ in range(self.random.randint(0, 4)):
            op = self.one(ARITHMETIC.get(type_, ["ADD", "SUB", "MUL", "DIV", "MOD"]))
            kind = self.random.randint(0, 9)
            if kind == 0 and type_ == "INT":
                two = f"{self.one(operands)} {self.one(operands)}"
                lines.append(
                    self.one(
                        [
                            f"FN LIMIT:INT {two}",
                            f"FN MAX:INT {two}",
                            f"FN MIN:INT {self.one(operands)}",
                            "FN ABS:INT",
                        ]
                    )
                )
            elif kind == 1 and type_ == "INT":
                lines.append(f"FN twice:INT odd=>{self.one(['b0', 'ab[i1,i0]', 'b6'])}")
            elif kind == 2 and depth < 3:
                first, *rest = self.number(type_, depth + 1)
                lines += [f"{op}( {first[3:]}", *rest, ")"]
            elif kind == 3 and CONVERSIONS[type_]:
                other = self.one(CONVERSIONS[type_])
                lines += [f"FN {type_}_TO_{other}:{other}", f"FN {other}_TO_{type_}:{type_}"]
            elif kind == 4:
                lines.append(f"ST {self.target(operands)}")
            else:
                lines.append(f"{op} {self.one(operands)}")
        return lines

    def condition(self, depth: int = 0) -> list[str]:
        """Instructions that leave a BOOL in the accumulator."""
        if self.random.random() < 0.25:
            type_ = self.one(list(PER_TYPE))
            sign = self.one(["GT", "GE", "EQ", "NE", "LE", "LT"])
            lines = [*self.number(type_, 2), f"{sign} {self.one(PER_TYPE[type_])}"]
        else:
            lines = [f"{self.one(['LD', 'LDN'])} {self.one(BOOLS)}"]
        for _ in range(self.random.randint(0, 5)):
            op = self.one(["AND", "OR", "XOR", "ANDN", "ORN", "XORN"])
            kind = self.random.randint(0, 9)
            if kind < 3 and depth < 3:
                first, *rest = self.condition(depth + 1)
                if first.startswith("LD ") and first[3:] in BOOLS:
                    lines += [f"{op}( {first[3:]}", *rest, ")"]
            elif kind == 3:
                lines.append("NOT")
            elif kind == 4:
                lines.append(f"{self.one(['ST', 'STN', 'S', 'R'])} {self.target(BOOLS)}")
            else:
                lines.append(f"{op} {self.one(BOOLS)}")
        return lines

    def statements(self, depth: int = 0) -> list[str]:
        lines: list[str] = []
        for _ in range(self.random.randint(1, 3)):
            kind = self.random.randint(0, 9)
            if kind < 4:
                lines += self.condition()
                lines += [
                    f"{self.one(['ST', 'STN', 'S', 'R'])} {self.target(BOOLS)}"
                    for _ in range(self.random.randint(1, 3))
                ]
            elif kind < 7:
                type_ = self.one(list(PER_TYPE))
                lines += [*self.number(type_), f"ST {self.target(PER_TYPE[type_])}"]
            elif kind == 7 and depth < 3:
                self.labels += 1
                label = f"L{self.labels}"
                lines += [*self.condition(), f"{self.one(['JMPC', 'JMPCN'])} {label}"]
                lines += [*self.statements(depth + 1), f"LABEL {label}"]
            elif kind == 8:
                lines += [*self.condition(), self.one(["CAL f", "CAL fs[i0]", "CALC f", "CALCN fs[1]"])]
            else:
                lines += self.one(
                    [
                        ["LD p", "ST ps[i0]"],
                        ["LD ps[1]", "ST p"],
                        ["LD str", "FN CONCAT:STRING str", "ST str"],
                        ["LD b0", "RETC"],
                    ]
                )
        return lines

    def rungs(self) -> list[list[str]]:
        made = []
        for _ in range(self.random.randint(1, 4)):
            made.append(self.statements())
            if self.random.random() < 0.25:
                made[-1] += [*self.condition(), f"JMPC r{self.random.randint(0, 4)}"]
        return made + [[] for _ in range(5 - len(made))]


def assemble(rungs: list[list[str]]):
    texts = [(f"r{n}", "\n".join(lines), f"r{n}") for n, lines in enumerate(rungs)]
    main = unit("PROGRAM", "main", NAMES, *texts, units=[BLOCK])
    return program(FUNCTION, BLOCK, main, tasks=(Task("main", watchdog=20),))


def state(machine: Machine) -> list:
    return [(s.path, repr(machine.value(s))) for s in machine.symbols.all(hidden=True)]


def differences(rungs: list[list[str]], seed: int) -> list:
    """What three scans with random inputs leave different; empty when stepping, and executing by pieces, equal
    compiled."""
    source, random = assemble(rungs), Random(seed)
    compiled, stepped, pieced = Machine(source), Machine(source), PacedMachine(source, cost=Cost(1))
    stepper = Stepper(stepped)
    for _ in range(3):
        for name in ("b0", "b1", "b5", "i0", "i1", "w0"):
            value = random.randint(0, 1) if name[0] == "b" else random.randint(0, 2)
            for machine in (compiled, stepped, pieced):
                machine.set(name, value)
        compiled.scan()
        stepper.scan()
        pieced.scan()
        for other in (stepped, pieced):
            found = [pair for pair in zip(state(compiled), state(other), strict=True) if pair[0] != pair[1]]
            if found or compiled.faults != other.faults or compiled.checksum() != other.checksum():
                return [*found, compiled.faults, other.faults]
    return []


@settings(max_examples=200, deadline=None)
@given(st.integers(0, 2**40))
def test_stepping_equals_compiled(seed: int) -> None:
    rungs = Generator(seed).rungs()
    assert differences(rungs, seed) == [], "\n".join(line for rung in rungs for line in rung)


def test_what_one_sees_while_stepping() -> None:
    block = unit(
        "FUNCTION_BLOCK", "inv", [var("a", kind="input"), var("q", kind="output")], ("turn", "LDN a; ST q")
    )
    main = unit(
        "PROGRAM",
        "main",
        [var("x", initial=True), var("y"), var("z"), var("i", Instance("inv"))],
        ("one", "LD x; AND( y; OR x; ); ST z"),
        ("two", "LD z; ST i.a; CAL i"),
        ("three", "LD i.q; ST y"),
        units=[block],
    )
    machine = Machine(program(block, main))
    stepper = Stepper(machine, {("inv", "turn"), ("main", "three")})
    assert stepper.place is None and stepper.step().instruction == 1
    assert stepper.accumulator is True
    stepper.step()
    assert stepper.accumulator is False and stepper.deferred == (("AND", True),)
    assert stepper.step_rung().rung == "two" and machine.get("z") is True
    assert str(stepper.run()) == "inv, rung turn, instruction 0"
    assert [f.path for f in stepper.frames] == ["main", "i"]
    assert stepper.run().rung == "three"
    assert stepper.run() is None and machine.scans == 1 and machine.get("y") is False
    machine.scan()
    assert stepper.step() is not None and machine.scans == 2


def test_a_fault_while_stepping_ends_the_task_only() -> None:
    bad = unit("PROGRAM", "bad", [var("n", INT)], "LD 1; DIV n; ST n")
    good = unit("PROGRAM", "good", [var("n", INT)], "LD 1; ST n")
    from ldc.il.program import Run

    machine = Machine(
        program(
            bad, good, tasks=(Task("a"), Task("b")), runs=(Run("bad", "bad", "a"), Run("good", "good", "b"))
        )
    )
    stepper = Stepper(machine)
    assert stepper.step().pou == "bad"
    assert stepper.step().pou == "good"
    assert machine.faults[0].place.instruction == 1
    assert stepper.step() is not None and stepper.step() is None and machine.get("good.n") == 1


def test_an_empty_program_steps_to_its_end() -> None:
    stepper = Stepper(Machine(simple([var("a")])))
    assert stepper.step() is None and stepper.machine.scans == 1


@pytest.mark.parametrize("member", ["x", "row[0]", "rows[k].x"])
def test_what_was_loaded_stays_when_an_element_is_stored(tmp_path: Path, member: str) -> None:
    """Of an element of an array the member was read later, after a store within brackets to the same."""
    text = ("TYPE\n  inner : STRUCT x : INT; END_STRUCT;\n  point : STRUCT x : INT; row : ARRAY [0..1] OF INT; "
            "rows : ARRAY [0..1] OF inner; END_STRUCT;\nEND_TYPE\n"
            "PROGRAM main\nVAR\n  ps : ARRAY [0..2] OF point; i, k, n : INT;\nEND_VAR\n"
            f"  LD ps[i].{member}\n  ADD( ps[i].{member}\n  ADD 5\n  ST ps[i].{member}\n  )\n  ST n\nEND_PROGRAM\n")
    assert everywhere.trace(tmp_path, text, "main.il", [{}, {}, {"i": 1}], ["n"]) == [(5,), (15,), (5,)]
