"""Add-On Instructions: a structure with the data of an instance, and a FUNCTION with the logic.

An instance is data alone, as in the controller: its parameters are read and written from outside, it lies in
arrays and in other structures. InOut parameters are VAR_IN_OUT; required inputs are pins; required outputs
are stored behind the call, under power. Without power the inputs are passed and nothing else is done, unless
the instruction has an EnableInFalse routine (1756-PM010, scan modes).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ldc.parser import ast
from ldc.parser import statements as st
from ldc.parser.foreign import Names
from ldc.parser.l5x import types
from ldc.parser.l5x.neutral import Instruction
from ldc.parser.l5x.routines import Routine, declare, routine_of, rungs_of
from ldc.parser.l5x.scope import Scope, Tag
from ldc.parser.l5x.starts import told
from ldc.parser.l5x.structured import Statements
from ldc.parser.l5x.types import BOOL, Member, Structure, Type
from ldc.parser.l5x.values import Value, convert
from ldc.parser.l5x.writer import Context, Writer
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.texts import prose
from ldc.records import record
from ldc.source import Span

SELF = "self"
_SCANS = {"Prescan": "ExecutePrescan", "Postscan": "ExecutePostscan"}


@record
class Parameter:
    """``usage``: Input, Output or InOut; ``pin``: what the FUNCTION calls it."""

    name: str
    usage: str
    type: Type | None
    required: bool
    pin: str
    span: Span


@dataclass(slots=True)
class AddOn:
    """One definition. ``data``: the type of an instance; ``function``: the name of the logic."""

    context: Context
    node: Node
    data: Structure
    function: str
    parameters: list[Parameter] = field(default_factory=list)
    scope: Scope = field(default_factory=Scope)

    def declare(self, sizes) -> None:
        """The members of the structure and the tags that the logic sees. ``sizes`` reads dimensions."""
        names, pins = Names(self.context.reading), Names(self.context.reading)
        for taken in (SELF, "EnableIn", self.function):
            pins.fresh(taken)
        parameters = [n for group in self.node.all("Parameters") for n in group.all("Parameter")]
        local = [n for group in self.node.all("LocalTags") for n in group.all("LocalTag")]
        for node in (*parameters, *local):
            self._declare(node, names, pins, sizes)
        for name in ("EnableIn", "EnableOut"):
            if name.upper() not in self.data.members:
                span = self.node.attribute("Name")
                self.data.members[name.upper()] = Member(names.fresh(name), BOOL, span)
                self.scope.tags[name.upper()] = Tag(name, name, BOOL, span, of=SELF)

    def _declare(self, node: Node, names: Names, pins: Names, sizes) -> None:
        foreign, span = node.get("Name"), node.attribute("Name")
        usage = node.get("Usage") if node.tag == "Parameter" else ""
        key = foreign.upper()
        note = prose(node.find("Description")) or None
        if node.get("TagType") == "Alias":
            text = node.get("AliasFor")
            self.data.members[key] = Member(foreign, None, span, note, alias=text)
            self.scope.tags[key] = Tag(foreign, foreign, None, span, alias=node.attribute("AliasFor"))
        else:
            type_name = node.get("DataType")
            type_ = self.context.types.dimensioned(
                self.context.types.named(type_name, node.attribute("DataType")), sizes(node))
            if usage == "InOut":
                name = pins.name(foreign, span)
                self.scope.tags[key] = Tag(name, foreign, type_, span, type_name, local=True)
            else:
                name = names.name(foreign, span)
                data = told(node, "DefaultData")
                self.data.members[key] = Member(name, type_, span, note, data)
                self.scope.tags[key] = Tag(name, foreign, type_, span, type_name, of=SELF)
        if usage:
            found = self.scope.tags[key]
            pin = found.name if usage == "InOut" or key == "ENABLEIN" else pins.name(foreign, span)
            self.parameters.append(Parameter(foreign, usage, found.type, node.flag("Required"), pin, span))

    def settle(self) -> None:
        """Parameters that are other names for a place get its type, once all types are known."""
        writer = Writer(self.context, self.scope, "FUNCTION", owner=self.data)
        for at, p in enumerate(self.parameters):
            tag = self.scope.tags[p.name.upper()]
            if tag.alias is not None:
                value = writer.read(tag.alias)
                self.parameters[at] = replace(p, type=value.type if value is not None else None)

    def _scanned(self, routine: str) -> Node | None:
        return next((n for group in self.node.all("Routines") for n in group.all("Routine")
                     if n.get("Name").upper() == routine.upper()), None)

    # ---- the logic

    def pou(self) -> ast.Pou | None:
        """The FUNCTION; None when its logic is not read."""
        reading, span = self.context.reading, self.node.attribute("Name")
        for routine, flag in _SCANS.items():
            if self.node.flag(flag) and self._scanned(routine) is not None:
                reading.unsupported(self._scanned(routine).span,
                                    f"the {routine} routine of an Add-On Instruction",
                                    "give the tags their values at the start")
        if self.node.find("EncodedData") is not None or self.node.get("EncryptionConfig"):
            reading.unsupported(self.node.span, f"protected Add-On Instruction {self.node.get('Name')}",
                                "export it without source protection")
            return None
        logic, idle = self._scanned("Logic"), None
        if self.node.flag("ExecuteEnableInFalse"):
            idle = self._scanned("EnableInFalse")
        done = self.context.names.fresh("done")
        writer = Writer(self.context, self.scope, "FUNCTION", done, owner=self.data)
        routines = [None if n is None else routine_of(n, self.context) for n in (logic, idle)]
        if any(r is not None and r.text is not None for r in routines):
            body: object = self._statements(writer, routines[0], routines[1], span)
        else:
            body = ast.LadderBody(tuple(self._rungs(writer, routines[0], routines[1], done, span)), span)
        in_outs = tuple(declare_as(p.pin, p.type, p.span) for p in self.parameters if p.usage == "InOut")
        inputs = (declare("EnableIn", BOOL, span),
                  *(declare_as(p.pin, p.type, p.span) for p in self._pins("Input")))
        data = ast.VarDecl(SELF, None, types.written(self.data, span), None, span, span)
        sections = (ast.VarBlock("VAR_INPUT", (), inputs, span),
                    ast.VarBlock("VAR_IN_OUT", (), (data, *in_outs), span),
                    *writer.sections(span))
        title = prose(self.node.find("Description")) or None
        return ast.Pou("FUNCTION", self.function, title, types.written(BOOL, span), sections, body,
                       self.node.whole, span)

    def _pins(self, usage: str) -> list[Parameter]:
        return [p for p in self.parameters if p.usage == usage and p.required
                and p.name.upper() != "ENABLEIN"]

    def _own(self, name: str, span: Span) -> ast.Expr:
        member = self.data.members.get(name.upper())
        return ast.Member(ast.Name(SELF, span), member.name if member else name, span)

    def _value(self, writer: Writer, parameter: Parameter) -> Value:
        tag = self.scope.tags[parameter.name.upper()]
        found = writer.read(tag.alias) if tag.alias is not None else None
        return found or writer.operands.tag_value(tag, parameter.span)

    def _rungs(self, writer: Writer, logic: Routine | None, idle: Routine | None, done: str,
               span: Span) -> list[ast.Rung]:
        enable = ast.Name("EnableIn", span)
        rungs = []
        for p in self._pins("Input"):
            pin = Value(ast.Name(p.pin, p.span), p.type, p.span)
            rungs.append(writer.made([writer.store(self._value(writer, p), pin, p.span)], p.span))
        coils = [ast.Coil("", self._own(name, span), span) for name in ("EnableIn", "EnableOut")]
        rungs.append(writer.made([ast.Contact("", enable, span), *coils], span))
        start = self.context.names.fresh("enabled")
        away = start if idle is not None else done
        modifier = "" if idle is not None else "/"
        rungs.append(writer.made([ast.Contact(modifier, enable, span), ast.Jump(away, span)], span))
        if idle is not None:
            rungs += rungs_of(writer, idle)
            writer.zone = None
            rungs.append(writer.made([ast.Jump(done, span)], span))
            never = [ast.Contact("/", enable, span), ast.Jump(done, span)]
            rungs.append(writer.made(never, span, start))
        rungs += rungs_of(writer, logic) if logic is not None else []
        result = [ast.Contact("", self._own("EnableOut", span), span),
                  ast.Coil("", ast.Name(self.function, span), span)]
        return [*rungs, writer.made(result, span, done)]

    def _statements(self, writer: Writer, logic: Routine | None, idle: Routine | None,
                    span: Span) -> st.StatementBody:
        """Statements, or for a ladder among them the finding that both have to be of one language."""
        enable = ast.Name("EnableIn", span)
        found: list[st.Statement] = [
            st.Assign(self._value(writer, p).expr,
                      convert(Value(ast.Name(p.pin, span), p.type, span), p.type), span)
            for p in self._pins("Input")]
        found += [st.Assign(self._own(name, span), enable, span) for name in ("EnableIn", "EnableOut")]
        result = st.Assign(ast.Name(self.function, span), self._own("EnableOut", span), span)
        bodies = []
        for routine in (logic, idle):
            if routine is not None and routine.text is None:
                self.context.reading.unsupported(routine.span, "an Add-On Instruction in two languages",
                                                 "write its routines in one")
            text = routine.text.body if routine is not None and routine.text is not None else None
            bodies.append(Statements(writer, (result,)).read(text) if text is not None else ())
        otherwise = st.Otherwise(bodies[1], span) if bodies[1] else None
        found.append(st.If((st.Arm(enable, bodies[0], span),), otherwise, span))
        return st.StatementBody((*found, result), span)

    # ---- a call

    def call(self, writer: Writer, i: Instruction) -> list[ast.Item]:
        """NAME(instance, arguments of the required parameters and InOut parameters in their order)."""
        wanted = [p for p in self.parameters
                  if (p.required or p.usage == "InOut") and p.name.upper() not in ("ENABLEIN", "ENABLEOUT")]
        given = len(i.operands)
        if given != len(wanted) + 1:
            writer.reading.malformed(i.span, f"{i.name} takes {len(wanted) + 1} operands, {given} are given",
                                     help="an instance, then " + (", ".join(p.name for p in wanted)
                                                                  or "nothing else"))
            return []
        instance = writer.place(i.operands[0])
        if instance is None:
            return []
        if instance.type is not None and instance.type is not self.data:
            writer.reading.malformed(i.operands[0], f"`{i.operands[0].text[:40]}` is no instance of {i.name}",
                                     help=f"give it a tag of type {self.node.get('Name')}")
            return []
        pins: list[tuple[str, ast.Expr]] = [(SELF, instance.expr)]
        behind: list[ast.Item] = []
        for p, text in zip(wanted, i.operands[1:], strict=True):
            if p.usage == "Input":
                value = writer.read(text, hint=p.type)
                if value is not None:
                    pins.append((p.pin, convert(value, p.type)))
                continue
            place = writer.place(text, p.type)
            if place is None:
                continue
            if p.usage == "InOut":
                pins.append((p.pin, place.expr))
            else:
                behind.append(writer.store(place, writer.operands.member(instance, p.name, text), text))
        block = writer.block(self.function, i.span, pins, "EnableIn", "OUT")
        if not behind:
            return [block]
        levels = ([block], [*behind, writer.always(False, i.span)])
        return [ast.Branches(tuple(ast.Path(tuple(items), i.span) for items in levels), i.span)]


def declare_as(name: str, type_: Type | None, span: Span) -> ast.VarDecl:
    return ast.VarDecl(name, None, types.written(type_ or "UNKNOWN", span), None, span, span)
