"""Programs: the main routine becomes a PROGRAM, every routine that is called a FUNCTION_BLOCK.

Tags are global variables, so a routine has no memory of its own; it is called under power, and its rungs run
between those of the caller, as in the controller.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from ldc.parser import ast
from ldc.parser.l5x import neutral, types
from ldc.parser.l5x.neutral import Branch, Element, Instruction
from ldc.parser.l5x.scope import Scope, Tag
from ldc.parser.l5x.structured import Statements
from ldc.parser.l5x.types import BOOL, DINT
from ldc.parser.l5x.values import Value
from ldc.parser.l5x.writer import RETURN, Context, Drawn, Writer
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.texts import prose
from ldc.source import Span

_TITLE = 200
_CONTENTS = frozenset(("RLLContent", "STContent", "FBDContent", "SFCContent"))
"""What tells the language of a routine where its attribute Type is missing."""


@dataclass(slots=True)
class Routine:
    """``rungs`` of a ladder, ``text`` of Structured Text. ``takes``: the operands of its SBR; ``gives``:
    those of its first RET that has some. ``block``: the FUNCTION_BLOCK that it is, "" before it is called."""

    name: str
    span: Span
    rungs: tuple[Drawn, ...] = ()
    text: Node | None = None
    takes: tuple[Span, ...] = ()
    gives: tuple[Span, ...] = ()
    block: str = ""
    calls: set[str] = field(default_factory=set)


def instructions(elements: tuple[Element, ...]):
    """All instructions of a rung, in their order."""
    work = list(reversed(elements))
    while work:
        element = work.pop()
        if isinstance(element, Branch):
            work += reversed([e for level in element.levels for e in level])
        else:
            yield element


def routine_of(node: Node, context: Context) -> Routine | None:
    """A routine as it was written; None when it is in a language that is not read."""
    reading, name = context.reading, node.get("Name")
    routine = Routine(name, node.attribute("Name"))
    contents = (n.tag.removesuffix("Content") for n in node.children if n.tag in _CONTENTS)
    kind = node.get("Type") or next(contents, "")
    if kind == "ST":
        routine.text = node.find("STContent")
        if routine.text is not None:
            _interface(routine, neutral.calls(routine.text.body, reading))
        return routine
    if kind != "RLL":
        reading.unsupported(node.span, f"routine {name} in {kind[:20] or 'an unknown language'}",
                            "only ladder and Structured Text are read; write it in one of these")
        return None
    drawn = []
    for rung in (r for content in node.all("RLLContent") for r in content.all("Rung")):
        if rung.get("Type") not in ("N", ""):
            reading.unsupported(rung.span, f"rung {rung.get('Number')} with pending edits",
                                "accept or cancel the edits and export again")
            continue
        title = " ".join(prose(rung.find("Comment")).split())[:_TITLE] or None
        texts = [child.content for child in rung.all("Text")]
        found = [pair for text in texts for pair in neutral.rungs(text, reading)]
        drawn += [Drawn(elements, span, title if at == 0 else None)
                  for at, (elements, span) in enumerate(found)]
        if title and not any(elements for elements, _ in found):
            reading.left_out(rung.span, f"a rung of {name} that is only a comment", "it holds no instruction")
    routine.rungs = tuple(drawn)
    _interface(routine, (i for rung in drawn for i in instructions(rung.elements)))
    return routine


def _interface(routine: Routine, found: Iterable[Instruction]) -> None:
    """What the instructions of a routine tell of it to others."""
    for instruction in found:
        if instruction.name == "SBR" and not routine.takes:
            routine.takes = instruction.operands
        elif instruction.name == "RET" and not routine.gives:
            routine.gives = instruction.operands
        elif instruction.name in ("JSR", "FOR") and instruction.operands:
            routine.calls.add(instruction.operands[0].text.upper())


def rungs_of(writer: Writer, routine: Routine) -> list[ast.Rung]:
    """The rungs of a ladder routine. A label names its rung; one on an empty rung names the next."""
    names = _labels(writer, routine)
    found = []
    for at, drawn in enumerate(routine.rungs):
        rung = writer.rung(drawn, names.get(at))
        if rung is not None:
            found.append(rung)
        elif at in names:
            # The name is jumped to, so its rung stands even when nothing of it is left.
            always = [writer.always(False, drawn.span), ast.Jump(RETURN, drawn.span)]
            found.append(writer.made(always, drawn.span, names[at], drawn.title))
    return found


def _labels(writer: Writer, routine: Routine) -> dict[int, str]:
    names: dict[int, str] = {}
    seen: set[str] = set()
    waiting: list[str] = []
    for at, drawn in enumerate(routine.rungs):
        found = list(instructions(drawn.elements))
        for i in found:
            if i.name != "LBL" or not i.operands:
                continue
            key = i.operands[0].text.upper()
            if key in seen:
                writer.reading.malformed(i.operands[0],
                                         f"LBL({i.operands[0].text[:40]}) stands twice in the routine",
                                         help="give the rungs different labels")
                continue
            seen.add(key)
            waiting.append(i.operands[0].text)
        if not waiting or all(i.name in ("LBL", "NOP") for i in found):
            continue
        names[at] = writer.context.names.fresh(waiting[0])
        writer.labels |= {label.upper(): names[at] for label in waiting}
        waiting = []
    writer.labels |= {label.upper(): writer.leave for label in waiting}
    return names


@dataclass(slots=True)
class Program:
    """One program of the controller while it is written. ``made``: the blocks of its routines."""

    context: Context
    name: str
    node: Node
    scope: Scope
    routines: dict[str, Routine] = field(default_factory=dict)
    made: list[ast.Pou] = field(default_factory=list)
    returned: dict[tuple[str, int], Tag] = field(default_factory=dict)
    now: Routine | None = None

    def pous(self) -> list[ast.Pou]:
        """The PROGRAM, before it the blocks of its routines."""
        for group in self.node.all("Routines"):
            for node in group.all("Routine"):
                routine = routine_of(node, self.context)
                if routine is not None:
                    self.routines[routine.name.upper()] = routine
            for node in group.all("EncodedData"):
                self.context.reading.unsupported(node.span, f"protected routine {node.get('Name')}",
                                                 "export it without source protection")
        main = self._main()
        if main is None:
            return []
        called = {name for routine in self.routines.values() for name in routine.calls}
        inside = len(main) == 1 and main[0].name.upper() not in called and main[0].text is None
        writer = self.writer("PROGRAM")
        if inside:
            self.now = main[0]
            rungs = rungs_of(writer, main[0])
        else:
            rungs = [writer.made([self.invoke(writer, routine, routine.span)], routine.span)
                     for routine in main]
        self._blocks(main)
        span = self.node.attribute("Name")
        rungs = self._first(writer, span) + rungs
        if not rungs:
            rungs = [writer.made([writer.always(False, span), ast.Jump(RETURN, span)], span)]
        title = prose(self.node.find("Description")) or None
        program = ast.Pou("PROGRAM", self.name, title, None, writer.sections(self.node.whole),
                          ast.LadderBody(tuple(rungs), self.node.whole), self.node.whole, span)
        return [*self.made, program]

    def _main(self) -> list[Routine] | None:
        """What the program runs: its main routine; where none is named, all routines that nobody calls."""
        wanted = self.node.get("MainRoutineName")
        if wanted:
            found = self.routines.get(wanted.upper())
            written = {n.get("Name").upper() for n in self.node.descendants("Routine", "EncodedData")}
            if found is None and wanted.upper() in written:
                return None
            if found is None and self.node.find("Routines") is not None:
                self.context.reading.malformed(self.node.attribute("MainRoutineName"),
                                               f"there is no routine `{wanted[:40]}` in this program",
                                               help="name one of its routines")
                return None
            if found is not None:
                return [found]
        called = {name for routine in self.routines.values() for name in routine.calls}
        found = [r for key, r in self.routines.items() if key not in called]
        if found and not wanted:
            self.context.reading.remark("added", f"a call of {', '.join(r.name for r in found)}",
                                        f"program {self.name} names no main routine", self.node.span)
        return found

    def writer(self, kind: str) -> Writer:
        writer = Writer(self.context, self.scope, kind, routines=self)
        writer.operands.scan = self.name
        return writer

    # ---- routines that are called

    def _blocks(self, main: list[Routine]) -> None:
        """The blocks of all routines that are called, and of those that these call."""
        done: set[str] = set()
        while True:
            routine = next((r for r in self.routines.values() if r.block and r.block not in done), None)
            if routine is None:
                break
            done.add(routine.block)
            self.made.insert(0, self._block(routine))
        for routine in self.routines.values():
            if not routine.block and routine not in main:
                self.context.reading.left_out(routine.span, f"routine {routine.name}", "no routine calls it")

    def _block(self, routine: Routine) -> ast.Pou:
        self.now, span = routine, routine.span
        writer = self.writer("FUNCTION_BLOCK")
        enable, enabled = ast.Name("EN", span), ast.Name("ENO", span)
        if routine.text is not None:
            body: object = Statements(writer).guarded(routine.text, enable, enabled)
        else:
            first = ast.Rung(None, None, (
                ast.Path((ast.Contact("", enable, span), ast.Coil("", enabled, span)), span),
                ast.Path((ast.Contact("/", enable, span), ast.Jump(RETURN, span)), span)), span)
            body = ast.LadderBody((first, *rungs_of(writer, routine)), span)
        pins = (ast.VarBlock("VAR_INPUT", (), (declare("EN", BOOL, span),), span),
                ast.VarBlock("VAR_OUTPUT", (), (declare("ENO", BOOL, span),), span))
        return ast.Pou("FUNCTION_BLOCK", routine.block,
                       f"Routine {routine.name} of {self.node.get('Name')}"[:_TITLE],
                       None, (*pins, *writer.sections(span)), body, span, span)

    def invoke(self, writer: Writer, routine: Routine, span: Span) -> ast.Block:
        """The call of a routine under power."""
        if not routine.block:
            routine.block = self.context.names.fresh(f"{self.name}_{routine.name}")
        name = writer.local(f"call_{routine.name}", ast.NamedType(routine.block, None, span), span,
                            f"call {routine.name.upper()}")
        return writer.block(routine.block, span, [], instance=ast.Name(name, span))

    def call(self, writer: Writer, i: Instruction) -> list[ast.Item]:
        """JSR(routine, number of inputs, inputs ..., places for what it returns ...)."""
        routine = self.routines.get(i.operands[0].text.upper())
        if routine is None:
            writer.reading.malformed(i.operands[0],
                                     f"there is no routine `{i.operands[0].text[:40]}` in this program",
                                     help="JSR calls a routine of its own program")
            return []
        inputs, returns = _divided(i)
        if len(inputs) < len(routine.takes) or len(returns) > len(routine.gives):
            writer.reading.malformed(i.span,
                                     f"routine {routine.name} takes {len(routine.takes)} values and returns "
                                     f"{len(routine.gives)}", help="give JSR as many as SBR and RET have")
            return []
        items: list[ast.Item] = []
        for text, place in zip(inputs, routine.takes, strict=False):
            value, target = writer.read(text), writer.place(place)
            if value is not None and target is not None:
                items.append(writer.store(target, value, text))
        for text in inputs[len(routine.takes) :]:
            writer.reading.left_out(text, f"an input of JSR({routine.name})", "its SBR does not take it")
        items.append(self.invoke(writer, routine, i.span))
        for at, text in enumerate(returns):
            target = writer.place(text)
            if target is not None:
                items.append(writer.store(target, self._result(writer, routine, at, text), text))
        return items

    def broken(self, writer: Writer, span: Span) -> ast.Expr:
        """The flag by which BRK ends the FOR that called its routine."""
        tag = self.context.globals.add(f"break {self.name}".upper(), f"{self.name}_break", BOOL, span)
        return writer.operands.tag_value(tag, span).expr

    def leave(self, writer: Writer, i: Instruction) -> list[ast.Item]:
        """RET: the values go to where the caller takes them, and the routine ends."""
        items: list[ast.Item] = []
        for at, text in enumerate(i.operands):
            value = writer.read(text)
            if value is not None and self.now is not None and at < len(self.now.gives):
                items.append(writer.store(self._result(writer, self.now, at, text), value, text))
        return [*items, ast.Jump(writer.leave, i.span)]

    def _result(self, writer: Writer, routine: Routine, at: int, span: Span) -> Value:
        """The global that holds a value which a routine returns."""
        value = writer.read(routine.gives[at])
        type_ = value.type if value is not None and value.type is not None else DINT
        tag = self.context.globals.add(f"result {self.name} {routine.name} {at}".upper(),
                                       f"{routine.name}_result_{at + 1}", type_, span)
        return writer.operands.tag_value(tag, span)

    # ---- what every program begins with

    def _first(self, writer: Writer, span: Span) -> list[ast.Rung]:
        """The rung that keeps S:FS, when it is used: TRUE in the first scan."""
        first = self.context.globals.added(f"first scan {self.name}")
        if first is None:
            return []
        first.starts[()] = True
        flag = writer.operands.tag_value(first, span)
        begun = ast.Name(writer.local("scanned", types.written(BOOL, span), span), span)
        return [writer.made([ast.Contact("", begun, span), ast.Coil("R", flag.expr, span)], span),
                writer.made([ast.Coil("S", begun, span)], span)]


def declare(name: str, type_: types.Type, span: Span) -> ast.VarDecl:
    return ast.VarDecl(name, None, types.written(type_, span), None, span, span)


def _divided(i: Instruction) -> tuple[tuple[Span, ...], tuple[Span, ...]]:
    """The inputs and the returns of a JSR; without a number all are inputs."""
    rest = i.operands[1:]
    if rest and rest[0].text.isdecimal() and len(rest[0].text) < 5:
        count = int(rest[0].text)
        return rest[1 : 1 + count], rest[1 + count :]
    return rest, ()
