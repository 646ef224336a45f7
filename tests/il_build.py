"""A small assembler for tests of the runtime: IL programs from text, without the compiler."""

from __future__ import annotations

import re

from ldc.expr import BitStep, Const, FieldStep, IndexStep, Load, Place
from ldc.il.program import ARITHMETIC, COMPARISON, Instr, Program, Resource, Run, RungCode, Task, Unit
from ldc.symbols import Location, Variable
from ldc.types import BOOL, ELEMENTARY, TIME, Array, Instance, Struct, Type

_PART = re.compile(r"\.(\w+)|\[([^\]]+)\]")


def var(name: str, type_: Type = BOOL, at: str = "", kind: str = "local", initial=None) -> Variable:
    return Variable(name, type_, kind, initial, location=Location.parse(at) if at else None)


class Assembler:
    """Turns lines like ``AND( a[i].x``, ``LD 5:INT`` or ``FN LIMIT:INT x 9:INT`` into instructions."""

    def __init__(self, variables, globals_=(), units=()) -> None:
        self.local = {v.name.upper(): v for v in variables}
        self.globals = {v.name.upper(): v for v in globals_}
        self.units = {u.name.upper(): u for u in units}

    def place(self, text: str) -> Place:
        if text[0] == "%":
            at = Location.parse(text)
            type_ = (
                TIME
                if text == "%NOW"
                else (
                    BOOL
                    if at is None
                    else ELEMENTARY[
                        {"X": "BOOL", "B": "BYTE", "W": "WORD", "D": "DWORD", "L": "LWORD"}[at.size]
                    ]
                )
            )
            return Place(text, type_, is_global=True)
        root = re.match(r"\w+", text)[0]
        is_global = root.upper() not in self.local or self.local[root.upper()].kind == "external"
        found = self.globals if is_global else self.local
        type_, steps = found[root.upper()].type, []
        for match in _PART.finditer(text, len(root)):
            if match[2]:
                indexes = tuple(self.operand(i.strip()) for i in match[2].split(","))
                steps.append(
                    IndexStep(tuple(i if isinstance(i, Const) else Load(i) for i in indexes), type_.bounds)
                )
                type_ = type_.element
            elif match[1].isdigit():
                steps.append(BitStep(int(match[1])))
                type_ = BOOL
            else:
                steps.append(FieldStep(match[1]))
                type_ = self.member(type_, match[1])
        return Place(root, type_, tuple(steps), is_global)

    def member(self, type_: Type, name: str) -> Type:
        if isinstance(type_, Struct):
            return type_.field(name).type
        unit = self.units[type_.pou.upper()]
        return next(v.type for v in unit.variables if v.name.upper() == name.upper())

    def operand(self, text: str) -> Const | Place:
        if text in ("TRUE", "FALSE"):
            return Const(text == "TRUE", BOOL)
        value, mark, name = text.rpartition(":")
        if mark:
            type_ = ELEMENTARY[name]
            return Const(
                (
                    eval(value)
                    if type_.name in ("STRING", "WSTRING")
                    else float(value) if type_.kind == "real" else int(value)
                ),
                type_,
            )
        if re.fullmatch(r"-?\d+", text):
            return Const(int(text), ELEMENTARY["INT"])
        return self.place(text)

    def instr(self, line: str) -> Instr:
        op, *rest = line.split()
        if op == "FN":
            head, *arguments = rest
            name, _, result = head.partition(":")
            outputs = tuple((a.split("=>")[0], self.place(a.split("=>")[1])) for a in arguments if "=>" in a)
            plain = tuple(self.operand(a) for a in arguments if "=>" not in a)
            return Instr("FN", None, ELEMENTARY[result], name, plain, outputs)
        if op[:3] == "JMP" or op == "LABEL":
            return Instr(op, name=rest[0])
        operand = self.operand(rest[0]) if rest else None
        type_ = operand.type if operand is not None else BOOL
        if op.rstrip("(") in (*ARITHMETIC, *COMPARISON) and operand is None:
            raise ValueError(f"{op} needs an operand here")
        return Instr(op, operand, type_)

    def rung(self, key: str, text: str, label: str | None = None) -> RungCode:
        lines = [line.strip() for part in text.splitlines() for line in part.split(";")]
        return RungCode(key, tuple(self.instr(line) for line in lines if line), label)


def unit(kind: str, name: str, variables, *rungs, globals_=(), units=(), result=None) -> Unit:
    """A POU; each rung is its text, or (key, text) or (key, text, label)."""
    variables = tuple(variables)
    if result is not None:
        variables += (var(name, result),)
    assembler = Assembler(variables, globals_, units)
    made = [assembler.rung(*(r if isinstance(r, tuple) else (f"r{n}", r))) for n, r in enumerate(rungs)]
    return Unit(kind, name, variables, tuple(made), result)


def program(*units: Unit, globals_=(), tasks=(Task("main"),), runs=None, safe=()) -> Program:
    """A project with one resource; every PROGRAM runs once, in the first task, unless ``runs`` says more."""
    if runs is None:
        runs = tuple(Run(u.name, u.name, tasks[0].name) for u in units if u.kind == "PROGRAM")
    return Program(units, (), tuple(globals_), (Resource("res", "cpu", tuple(tasks), tuple(runs)),), safe)


def simple(variables, *rungs, **more) -> Program:
    """One PROGRAM ``main``."""
    return program(unit("PROGRAM", "main", variables, *rungs), **more)


__all__ = ["Array", "Instance", "Struct", "program", "simple", "unit", "var"]
