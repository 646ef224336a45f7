"""An instruction list as one PROGRAM: rungs begin where LD does after an output."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import PurePath

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.foreign import Names, Reading, supporting
from ldc.parser.melsec.circuit import Block, path_of
from ldc.parser.melsec.devices import Devices
from ldc.parser.melsec.family import Family, family_of
from ldc.parser.melsec.lines import Instruction, Lines
from ldc.parser.melsec.outputs import NO_WIRE, Outputs, label_of
from ldc.parser.melsec.power import Power
from ldc.parser.melsec.rows import Rows
from ldc.parser.melsec.table import first_step
from ldc.source import SourceFile, Span
from ldc.types import ELEMENTARY

FORMAT = "MELSEC"
_CONTACT = re.compile(r"(LD|AND|OR)(P|F)?\Z|(LDI|ANI|ORI)\Z")
_COMPARISON = re.compile(r"(LD|AND|OR)(D)?(=|<>|<=|>=|<|>)\Z")
_INVERTED = {"LDI": "LD", "ANI": "AND", "ORI": "OR"}
_EDGES = {None: "", "P": "P", "F": "N"}
_NO_EFFECT = ("NOP", "WDT", "NOPLF", "PAGE")
_ENDS = ("END", "FEND")
_DEFINITION = re.compile(r"([XYMSTCDLBWR]|S[MT]|ZR)0*([0-9A-F]+)\s*[=:]\s*(\S.*)", re.IGNORECASE)
_WORDS = re.compile(r'[^\s"]+')
_FILE = "blocks/fx.st"


class Program:
    """Reads one list. ``power``: of the rung that is open, which began with ``begin`` and stands behind the
    contact ``rail``; ``controls``: relays of master controls that are open, by level."""

    def __init__(self, source: SourceFile, diagnostics: Diagnostics) -> None:
        self.reading = Reading(source, FORMAT, diagnostics, mend="correct the list")
        first = first_step(source)
        self.lines = Rows(self.reading, first["gap"]) if first else Lines(self.reading)
        self.devices = Devices(self.reading, self._family())
        self.names = Names(self.reading)
        self.outputs = Outputs(self.devices, self._instance, self._labels())
        self.extra: list[ast.VarDecl] = []
        self.rungs: list[ast.Rung] = []
        self.labels: dict[str, Span] = {}
        self.label: str | None = None
        self.controls: dict[int, ast.Name] = {}
        self.power = Power(self.reading)
        self.begin: Instruction | None = None
        self.last: Span | None = None
        self.rail: list[ast.Item] = []

    def _family(self) -> Family:
        controller = [self.lines.controller] if isinstance(self.lines, Rows) else []
        found = self.lines.instructions
        return family_of([*controller, *(c.text for c in self.lines.comments)], {it.name for it in found},
                         {operand.text for it in found for operand in it.operands})

    def file(self) -> ast.File:
        at, instructions = 0, self.lines.instructions
        self._directions()
        while at < len(instructions) and instructions[at].name not in _ENDS:
            self._step(instructions, at)
            at += 1
        self._finish()
        behind = [it for it in instructions[at + 1 :] if it.name not in ("NOP", *_ENDS)]
        if behind:
            self.reading.unsupported(behind[0].span, f"what stands behind {instructions[at].name}",
                                     "subroutines and interrupts are not read: write them into the program")
        return self._file()

    def _labels(self) -> dict[str, str]:
        """What labels mean that stand behind another one (the first) or behind the last rung (the end)."""
        found: dict[str, str] = {}
        group: list[str] = []
        for it in self.lines.instructions:
            label = label_of(it.name)
            if label and not it.operands:
                group.append(label)
            elif it.name.startswith("LD"):
                found |= dict.fromkeys(group[1:], group[0]) if group else {}
                group = []
            elif it.name in _ENDS:
                break
        return found | dict.fromkeys(group, "RETURN") | {"P63": "RETURN"}

    def _directions(self) -> None:
        """Relays that make counters of FX count down are known before the counters."""
        for it in self.lines.instructions:
            for operand in it.operands:
                if re.match(r"M82[0-3]\d\Z", operand.text):
                    self.devices.device(operand, frozenset("M"), "relay")

    # ---- one instruction

    def _step(self, instructions: list[Instruction], at: int) -> None:
        it = instructions[at]
        contact = _CONTACT.match(it.name)
        comparison = _COMPARISON.match(it.name)
        if contact or comparison:
            self._contact(instructions, at, contact, comparison)
        elif it.name in ("ANB", "ORB"):
            self.power.join(it)
        elif it.name in ("INV", "MEP", "MEF"):
            self._result(it)
        elif it.name in ("MPS", "MRD", "MPP"):
            self.power.branch(it)
        elif it.name in ("MC", "MCR"):
            self._control(it)
        elif label_of(it.name) and not it.operands:
            self._label(label_of(it.name), it)
        elif it.name not in _NO_EFFECT:
            self._output(it)
        self.last = it.span

    def _contact(self, instructions: list[Instruction], at: int, contact, comparison) -> None:
        it = instructions[at]
        word = comparison[1] if comparison else _INVERTED.get(it.name) or contact[1]
        if word == "LD" and self.power.ended and not _continues(instructions, at):
            self._finish()
        if word == "LD" and self.power.point is None:
            self.begin, self.rail = it, self._control_contact(it.span)
        item = self._element(it, contact, comparison)
        block = Block([item] if item is not None else [])
        if word == "LD":
            self.power.load(block)
        elif word == "AND":
            self.power.series(it, block)
        else:
            self.power.parallel(it, block)
        self.power.failed |= item is None

    def _control_contact(self, span: Span) -> list[ast.Item]:
        """What a rung in the zone of a master control begins with."""
        if not self.controls:
            return []
        return [ast.Contact("", ast.Name(self.controls[max(self.controls)].name, span), span)]

    def _element(self, it: Instruction, contact, comparison) -> ast.Contact | None:
        operands = self.outputs.operands(it, range(2, 3) if comparison else range(1, 2))
        if operands is None:
            return None
        if comparison:
            bits = 32 if comparison[2] else 16
            values = [self.devices.value(operand, bits) for operand in operands]
            if None in values:
                return None
            return ast.Contact("", ast.Binary(comparison[3], *values, it.span), it.span)
        expr = self.devices.bit(operands[0])
        if expr is None:
            return None
        modifier = "/" if it.name in _INVERTED else _EDGES[contact[2]]
        if isinstance(expr, (ast.Literal, ast.Unary)):
            return self._known(it, expr, modifier)
        if isinstance(expr, ast.Binary) and modifier:
            return self._not_bit(it, expr, modifier)
        return ast.Contact(modifier, expr, it.span)

    def _known(self, it: Instruction, expr: ast.Expr, modifier: str) -> ast.Contact | None:
        """A contact of M8000, M8001 or M8003, which are no variables."""
        if modifier in ("P", "N"):
            self.reading.unsupported(it.span, f"{it.name} of {it.operands[0].text}",
                                     "M8002 is on in the first scan")
            return None
        if modifier == "/" and isinstance(expr, ast.Unary):
            expr = expr.operand
        elif modifier == "/":
            expr = ast.Literal(not expr.value, "BOOL", "FALSE" if expr.value else "TRUE", expr.span)
        return ast.Contact("", expr, it.span)

    def _not_bit(self, it: Instruction, expr: ast.Binary, modifier: str) -> ast.Contact | None:
        """A closed contact of a bit of a register."""
        if modifier != "/":
            self.reading.unsupported(it.span, f"the edge of {it.operands[0].text}",
                                     "copy the bit to a relay first")
            return None
        return ast.Contact("", ast.Binary("=", expr.left, expr.right, expr.span), it.span)

    def _result(self, it: Instruction) -> None:
        """INV, MEP and MEF change the power that has come so far."""
        if it.name == "INV":
            item = ast.Block(None, "NOT", (), "IN", "OUT", it.span)
        else:
            type_ = "R_TRIG" if it.name == "MEP" else "FX_FALLING"
            item = ast.Block(self._instance("edge", type_, it.span), type_, (), None, None, it.span)
        self.power.series(it, Block([item], changes=True))

    def _output(self, it: Instruction) -> None:
        paths = self.outputs.write(it)
        if paths:
            self.power.output(it, paths)
            return
        self.power.failed = True
        if paths is not None:
            self.reading.unsupported(it.span, f"the instruction {it.name[:40]}",
                                     "docs/import-melsec.md lists the instructions that are read")

    def _control(self, it: Instruction) -> None:
        operands = self.outputs.operands(it, range(2, 3) if it.name == "MC" else range(1, 2))
        level = re.match(r"N?([0-7])\Z", operands[0].text) if operands is not None else None
        if level is None:
            self.power.failed = True
            if operands is not None:
                self.reading.malformed(operands[0].span, f"`{operands[0].text[:40]}` is no level",
                                       help="levels of master controls are N0 to N7")
        elif it.name == "MCR":
            self._finish()
            self.controls = {n: name for n, name in self.controls.items() if n < int(level[1])}
        else:
            target = self.devices.write(operands[1], frozenset("YM"), "relay")
            self.power.failed |= target is None
            if target is not None:
                self.power.output(it, [[ast.Coil("", target, it.span)]])
                self.last = it.span
                self._finish()
                self.controls[int(level[1])] = target

    def _label(self, label: str, it: Instruction) -> None:
        self._finish()
        if label in self.labels:
            self.reading.malformed(it.span, f"the label {label} stands here a second time")
            return
        self.labels[label] = it.span
        self.label = self.label or label

    def _finish(self) -> None:
        """End the rung that is open."""
        begin, power = self.begin, self.power
        if begin is not None and self.last is not None:
            items = power.items(begin.span, self.last)
            if items:
                name, self.label = self.label, None
                title = "; ".join(text for text in begin.above if not _DEFINITION.match(text))[:200] or None
                path = path_of([*self.rail, *items])
                span = begin.span.to(self.last)
                self.rungs.append(ast.Rung(name, title, (path,), span, self.labels.get(name)))
        self.power, self.begin = Power(self.reading), None

    # ---- the file

    def _instance(self, base: str, type_: str, span: Span) -> ast.Name:
        name = self.names.fresh(f"{base}_{len(self.extra) + 1}")
        self.extra.append(ast.VarDecl(name, None, ast.NamedType(type_, None, span), None, span, span))
        what = " ".join(_WORDS.findall(span.text))
        kind = "a value" if type_ in ELEMENTARY else "an instance"
        self.reading.remark("added", what, f"{name}, {kind} of {type_}", span)
        return ast.Name(name, span)

    def _file(self) -> ast.File:
        source, devices = self.reading.source, self.devices
        whole = Span(source, 0, len(source.text))
        helpers = self._helpers()
        needed = {device.type for device in devices.used} | {v.type.name for v in self.extra}
        needed |= devices.functions
        pous = tuple(pou for pou in _supporting() if pou.name in needed)
        for taken in (*(device.name for device in devices.used), *(pou.name for pou in pous)):
            self.names.fresh(taken)
        file_name = PurePath(re.split(r"[\\/]", source.path)[-1]).stem
        name = self.names.name(file_name, Span(source, 0, 0), key="")
        sections = devices.sections(self._notes(), self.extra)
        pou = ast.Pou("PROGRAM", name, self._title(), None, sections,
                      ast.LadderBody((*helpers, *self.rungs), whole), whole, Span(source, 0, 0))
        behind = [c for c in self.lines.comments if not c.alone]
        if behind:
            self.reading.remark("left out", f"{len(behind)} comments behind instructions",
                                "a rung has a title alone", behind[0].span)
        return ast.File(source, (pou, *pous), (), (), (), (), self.reading.lost, tuple(self.reading.remarks))

    def _helpers(self) -> list[ast.Rung]:
        """Rungs that drive special relays."""
        rungs = []
        for relay, type_, period in self.devices.helpers():
            span = self.devices.used[relay].span
            given = [] if period is None else [("PERIOD", period)]
            if given and self.devices.family.late:
                given.append(("AHEAD", period // 2))
            pins = tuple(ast.Pin(pin, ast.Literal(value, None, str(value), span), False, span)
                         for pin, value in given)
            name = self._instance(f"drives_{relay.name}", type_, span)
            block = ast.Block(name, type_, pins, NO_WIRE, None, span)
            coil = ast.Coil("", ast.Name(relay.name, span), span)
            rungs.append(ast.Rung(None, None, (path_of([block, coil]),), span))
        return rungs

    def _title(self) -> str | None:
        """The first comment, unless it belongs to a rung."""
        comment = self.lines.comments[0] if self.lines.comments else None
        first = self.lines.instructions[0] if self.lines.instructions else None
        if comment is None or first is None or comment.span.start > first.span.start:
            return None
        return None if comment.text in first.above else comment.text[:200]

    def _notes(self) -> dict[str, str]:
        """What comments on lines of their own say of devices, as `X0 = Start`."""
        notes: dict[str, str] = {}
        for comment in self.lines.comments:
            match = _DEFINITION.match(comment.text) if comment.alone else None
            if match is not None:
                notes.setdefault(f"{match[1]}{match[2]}".upper(), match[3])
        return notes


def _supporting() -> tuple[ast.Pou, ...]:
    text = (resources.files("ldc.parser.melsec") / _FILE).read_text(encoding="utf-8")
    return supporting(text, f"ldc/parser/melsec/{_FILE}")


def _continues(instructions: list[Instruction], at: int) -> bool:
    """Whether a LD behind an output begins a block that ANB joins to what is there."""
    depth = 0
    for index in range(at, len(instructions)):
        it = instructions[index]
        contact = _CONTACT.match(it.name) or _COMPARISON.match(it.name)
        if it.name in ("ANB", "ORB"):
            depth -= 1
            if depth == 0:
                return it.name == "ANB"
        elif contact:
            depth += it.name.startswith("LD")
        elif it.name not in ("NOP", "INV", "MEP", "MEF"):
            return False
    return False
