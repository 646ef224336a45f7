"""An instruction list as one PROGRAM: rungs begin where LD does after an output."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import PurePath

from ldc.diagnostics import Diagnostics
from ldc.parser import ast
from ldc.parser.foreign import Names, Reading, supporting
from ldc.parser.melsec.circuit import MAX_DEPTH, Block, Point, path_of
from ldc.parser.melsec.devices import Device, Devices
from ldc.parser.melsec.lines import Instruction, Lines
from ldc.parser.melsec.outputs import NO_WIRE, Outputs, label_of
from ldc.source import SourceFile, Span

FORMAT = "MELSEC"
_CONTACT = re.compile(r"(LD|AND|OR)(P|F)?\Z|(LDI|ANI|ORI)\Z")
_COMPARISON = re.compile(r"(LD|AND|OR)(D)?(=|<>|<=|>=|<|>)\Z")
_INVERTED = {"LDI": "LD", "ANI": "AND", "ORI": "OR"}
_EDGES = {None: "", "P": "P", "F": "N"}
_BRANCHES = ("MPS", "MRD", "MPP")
_NO_EFFECT = ("NOP", "WDT")
_DEFINITION = re.compile(r"([XYMSTCDL])0*(\d+)\s*[=:]\s*(\S.*)", re.IGNORECASE)
_FILE = "blocks/fx.st"


class Program:
    """Reads one list. ``point``: where the next output goes, None before the first LD; ``blocks``: begun by LD
    and not joined yet; ``stored``: points that MPS keeps; ``controls``: relays of master controls that are
    open, by level."""

    def __init__(self, source: SourceFile, diagnostics: Diagnostics) -> None:
        self.reading = Reading(source, FORMAT, diagnostics)
        self.lines = Lines(self.reading)
        self.devices = Devices(self.reading)
        self.names = Names(self.reading)
        self.outputs = Outputs(self.devices, self._instance, self._labels())
        self.extra: list[ast.VarDecl] = []
        self.rungs: list[ast.Rung] = []
        self.labels: dict[str, Span] = {}
        self.label: str | None = None
        self.controls: dict[int, ast.Name] = {}
        self._reset()

    def file(self) -> ast.File:
        at, instructions = 0, self.lines.instructions
        self._directions()
        while at < len(instructions) and instructions[at].name not in ("END", "FEND"):
            self._step(instructions, at)
            at += 1
        self._finish()
        for rest in instructions[at + 1 : at + 2]:
            if any(it.name not in ("NOP", "END") for it in instructions[at + 1 :]):
                self.reading.unsupported(rest.span, f"what stands behind {instructions[at].name}",
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
            elif it.name in ("END", "FEND"):
                break
        return found | dict.fromkeys(group, "RETURN") | {"P63": "RETURN"}

    def _reset(self) -> None:
        self.root: Point | None = None
        self.point: Point | None = None
        self.blocks: list[Block] = []
        self.stored: list[Point] = []
        self.begin: Instruction | None = None
        self.rail: list[ast.Item] = []
        self.jumped = False
        self.last: Span | None = None
        self.failed = False

    def _directions(self) -> None:
        """Relays that make counters count down are known before the counters."""
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
            self._join(it)
        elif it.name in ("INV", "MEP", "MEF"):
            self._result(it)
        elif it.name in _BRANCHES:
            self._branch(it)
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
        block = Block([item]) if (item := self._element(it, contact, comparison)) is not None else Block()
        self.failed |= item is None
        if word == "LD":
            ended = self.point is not None and not self.blocks and (self.point.branches or self.failed)
            if ended and not self._continues(instructions, at):
                self._finish()
            if self.point is None:
                self.begin = it
                self.rail = self._rail(it.span)
                self.root = self.point = Point(block)
            else:
                self.blocks.append(block)
        elif self.point is None:
            self._no_power(it)
        elif word == "AND":
            self._series(it, block)
        elif self._may_be_parallel(it):
            self._top().parallel(block)
            self._deep(it, self._top().depth)

    def _rail(self, span: Span) -> list[ast.Item]:
        """What a rung begins with: the contact of the master control that it stands in."""
        if not self.controls:
            return []
        name = self.controls[max(self.controls)]
        return [ast.Contact("", ast.Name(name.name, span), span)]

    def _element(self, it: Instruction, contact, comparison) -> ast.Contact | None:
        operands = self.outputs.operands(it, range(2, 3) if comparison else range(1, 2))
        if operands is None:
            return None
        if comparison:
            bits = 32 if comparison[2] or any(re.match(r"C2\d\d\Z", o.text) for o in operands) else 16
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
        return ast.Contact(modifier, expr, it.span)

    def _known(self, it: Instruction, expr: ast.Expr, modifier: str) -> ast.Contact | None:
        """A contact of M8000, M8001 or M8003, which are no variables."""
        if modifier in ("P", "N"):
            self.reading.unsupported(it.span, f"{it.name} of {it.operands[0].text}", "M8002 is on in the first scan")
            return None
        if modifier == "/":
            if isinstance(expr, ast.Unary):
                expr = expr.operand
            else:
                expr = ast.Literal(not expr.value, "BOOL", "FALSE" if expr.value else "TRUE", expr.span)
        return ast.Contact("", expr, it.span)

    def _continues(self, instructions: list[Instruction], at: int) -> bool:
        """Whether a LD behind an output begins a block that ANB joins to what is there."""
        depth = 0
        for it in instructions[at:]:
            if it.name.startswith("LD") and (_CONTACT.match(it.name) or _COMPARISON.match(it.name)):
                depth += 1
            elif it.name in ("ANB", "ORB"):
                depth -= 1
                if depth == 0:
                    return it.name == "ANB"
            elif not (_CONTACT.match(it.name) or _COMPARISON.match(it.name)
                      or it.name in ("NOP", "INV", "MEP", "MEF")):
                return False
        return False

    # ---- power

    def _top(self) -> Block:
        return self.blocks[-1] if self.blocks else self.point.block

    def _series(self, it: Instruction, block: Block) -> None:
        """Behind an output a new branch begins."""
        if not self.blocks and self.point.branches:
            self.point = self.point.behind()
            self._deep(it, self.point.depth)
        self._top().series(block)

    def _join(self, it: Instruction) -> None:
        if self.point is None or not self.blocks:
            self.reading.left_out(it.span, f"{it.name} without a second block", "there is nothing that it could join")
            return
        block = self.blocks.pop()
        if it.name == "ANB":
            if not self.failed:
                self._series(it, block.joined(it.span))
                self._deep(it, self._top().depth)
        elif self._may_be_parallel(it):
            self._top().parallel(block)
            self._deep(it, self._top().depth)

    def _may_be_parallel(self, it: Instruction) -> bool:
        """OR is parallel to all that leads to the point: not possible behind an output or a stored point."""
        if self.blocks or self.point is self.root and not self.point.branches:
            return True
        self.failed = True
        self.reading.unsupported(it.span, f"{it.name} behind an output", "begin the rung anew with LD")
        return False

    def _deep(self, it: Instruction, depth: int) -> None:
        if depth > MAX_DEPTH and not self.failed:
            self.failed = True
            self.reading.too_large(it.span, MAX_DEPTH, "circuits in one another")

    def _result(self, it: Instruction) -> None:
        """INV, MEP and MEF change the power that has come so far."""
        if self.point is None:
            self._no_power(it)
        elif it.name == "INV":
            self._series(it, Block([ast.Block(None, "NOT", (), "IN", "OUT", it.span)], changes=True))
        else:
            type_ = "R_TRIG" if it.name == "MEP" else "FX_FALLING"
            name = self._instance("edge", type_, it.span)
            self._series(it, Block([ast.Block(name, type_, (), None, None, it.span)], changes=True))

    def _branch(self, it: Instruction) -> None:
        if self.point is None:
            self._no_power(it)
        elif it.name == "MPS":
            self._close_blocks(it)
            self.stored.append(self.point)
            self.point = self.point.behind()
            self._deep(it, self.point.depth)
        elif not self.stored:
            self.failed = True
            self.reading.malformed(it.span, f"{it.name} without MPS before it")
        else:
            self._close_blocks(it)
            self.point = (self.stored.pop() if it.name == "MPP" else self.stored[-1]).behind()

    def _close_blocks(self, it: Instruction) -> None:
        if self.blocks:
            self.failed = True
            self.reading.malformed(it.span, "a block that LD begins is not joined", "before this",
                                   "ANB or ORB joins the blocks before an output")
            self.blocks = []

    def _no_power(self, it: Instruction) -> None:
        self.reading.malformed(it.span, f"{it.name} stands before any LD", help="a rung begins with LD or LDI")

    # ---- outputs

    def _output(self, it: Instruction) -> None:
        paths = self.outputs.write(it)
        if paths == []:
            self.failed = True
            self.reading.unsupported(it.span, f"the instruction {it.name[:40]}",
                                     "docs/import-melsec.md lists the instructions that are read")
        elif paths is None:
            self.failed = True
        elif self.point is None:
            self._no_power(it)
        elif self.jumped:
            self.failed = True
            self.reading.unsupported(it.span, f"{it.name} behind a jump", "begin the rung anew with LD")
        else:
            self._close_blocks(it)
            self.point.branches += paths
            self.jumped = it.name in ("CJ", "CJP")

    def _control(self, it: Instruction) -> None:
        operands = self.outputs.operands(it, range(2, 3) if it.name == "MC" else range(1, 2))
        if operands is None:
            self.failed = True
            return
        level = re.match(r"N?(\d{1,2})\Z", operands[0].text)
        if level is None:
            self.reading.malformed(operands[0].span, f"`{operands[0].text[:40]}` is no level of a master control",
                                   help="levels are N0 to N7")
            self.failed = True
        elif it.name == "MCR":
            self._finish()
            self.controls = {n: name for n, name in self.controls.items() if n < int(level[1])}
        else:
            target = self.devices.write(operands[1], frozenset("YM"), "relay")
            if target is None or self.point is None:
                self.failed = True
                if target is not None:
                    self._no_power(it)
                return
            self._close_blocks(it)
            self.point.branches.append([ast.Coil("", target, it.span)])
            self._finish()
            self.controls[int(level[1])] = target

    def _label(self, label: str, it: Instruction) -> None:
        self._finish()
        if label in self.labels:
            self.reading.malformed(it.span, f"the label {label} stands here a second time")
            return
        self.labels[label] = it.span
        self.label = self.label or label

    # ---- rungs

    def _finish(self) -> None:
        """End the rung that is open."""
        begin, root = self.begin, self.root
        if root is None or begin is None:
            self._reset()
            return
        self._close_blocks_at_end()
        if not self.failed and self.stored:
            self.failed = True
            self.reading.malformed(self.last or begin.span, "MPS without MPP", "before this")
        items = [] if self.failed else self.rail + root.items(begin.span)
        if not self.failed and not _has_output(root):
            self.reading.malformed(begin.span, "a rung without an output", "it begins here")
        elif items:
            name, self.label = self.label, None
            span = begin.span.to(self.last or begin.span)
            title = "; ".join(text for text in begin.above if not _DEFINITION.match(text))[:200] or None
            self.rungs.append(ast.Rung(name, title, (path_of(items),), span, self.labels.get(name)))
        self._reset()

    def _close_blocks_at_end(self) -> None:
        if self.blocks and not self.failed:
            self.failed = True
            self.reading.malformed(self.last, "a block that LD begins is not joined", "before the end of the rung",
                                   "ANB or ORB joins the blocks before an output")

    # ---- the file

    def _instance(self, base: str, type_: str, span: Span) -> ast.Name:
        name = self.names.fresh(base)
        self.extra.append(ast.VarDecl(name, None, ast.NamedType(type_, None, span), None, span, span))
        self.reading.remark("added", span.text, f"{name}, an instance of {type_}", span)
        return ast.Name(name, span)

    def _file(self) -> ast.File:
        source, devices = self.reading.source, self.devices
        whole = Span(source, 0, len(source.text))
        helpers = self._helpers()
        needed = {device.type for device in devices.used} | devices.functions | {v.type.name for v in self.extra}
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
            self.reading.remark("left out", f"{len(behind)} comments behind instructions", "a rung has a title alone",
                                behind[0].span)
        return ast.File(source, (pou, *pous), (), (), (), (), self.reading.lost, tuple(self.reading.remarks))

    def _helpers(self) -> list[ast.Rung]:
        """Rungs that drive special relays."""
        rungs = []
        for relay, type_, period in self.devices.helpers():
            span = self.devices.used[Device("M", int(relay[1:]))].span
            pins = [ast.Pin("Q", ast.Name(relay, span), True, span)]
            if period is not None:
                pins.insert(0, ast.Pin("PERIOD", ast.Literal(period, None, str(period), span), False, span))
            block = ast.Block(self._instance(f"drives_{relay}", type_, span), type_, tuple(pins), NO_WIRE, NO_WIRE,
                              span)
            rungs.append(ast.Rung(None, None, (path_of([block]),), span))
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
                notes.setdefault(f"{match[1].upper()}{match[2]}", match[3])
        return notes


def _supporting() -> tuple[ast.Pou, ...]:
    text = (resources.files("ldc.parser.melsec") / _FILE).read_text(encoding="utf-8")
    return supporting(text, f"ldc/parser/melsec/{_FILE}")


def _has_output(point: Point) -> bool:
    work = [point]
    while work:
        for branch in work.pop().branches:
            if not isinstance(branch, Point):
                return True
            work.append(branch)
    return False
