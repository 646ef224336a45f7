"""An L5X export to the tree that every source gives."""

from __future__ import annotations

import re

from ldc.diagnostics import Diagnostics, Severity
from ldc.library import blocks, functions
from ldc.parser import ast
from ldc.parser.foreign import Names, Reading
from ldc.parser.l5x import instructions, modules, tasks, types
from ldc.parser.l5x.addon import AddOn
from ldc.parser.l5x.routines import Program
from ldc.parser.l5x.scope import Globals, Scope, Tag
from ldc.parser.l5x.starts import initial, told
from ldc.parser.l5x.support import Support
from ldc.parser.l5x.types import BOOL, Member, Structure, Text, Type, Types
from ldc.parser.l5x.writer import Context
from ldc.parser.plcopen.document import Document, Node
from ldc.parser.plcopen.texts import prose
from ldc.records import replace
from ldc.source import SourceFile, Span

NAME = "L5X"
_LONGEST_CLOCK = "T#106751d"
_MEMBER = re.compile(r"\.\s*([A-Za-z_]\w*)")


def read(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The types, tags, Add-On Instructions, programs and tasks of the controller (codes LD0150 to LD0153)."""
    reading = Reading(source, NAME, diagnostics)
    root = Document(source, diagnostics).root
    controller = root.find("Controller") if root is not None else None
    if root is not None and controller is None:
        reading.malformed(root.span, "there is no <Controller>",
                          help="export a controller, program, routine or Add-On Instruction")
    if controller is None:
        return ast.File(source, (), (), (), (), (), True)
    before = sum(d.severity is Severity.ERROR for d in diagnostics)
    file = _Reader(controller, reading).file()
    lost = reading.lost or sum(d.severity is Severity.ERROR for d in diagnostics) > before
    return replace(file, incomplete=lost)


class _Reader:
    def __init__(self, controller: Node, reading: Reading) -> None:
        self.controller, self.reading = controller, reading
        names = Names(reading)
        self.context = Context(reading, names, Types(names), Globals(names, reading), Support(names))
        self.declared: list[Structure] = []
        self.tag_names: dict[tuple[str, str], str] = {}
        self.named: frozenset[str] | None = None

    def file(self) -> ast.File:
        self._name_tags()
        made = self._types()
        addons = self._addons()
        for node, structure in made:
            self._members(node, structure)
        for addon in addons:
            addon.declare(self._sizes)
        scope = Scope()
        modules.declare(self.controller, scope, self.context)
        for structure, member in types.measure([*self.declared, *self.context.types.used]):
            self.reading.malformed(member.span, f"{structure.foreign} would hold itself by {member.name}",
                                   help="take the member away")
        self._tags(self.controller, scope, "")
        programs = self._programs(scope)
        for addon in addons:
            addon.settle()
        pous = [pou for addon in addons if (pou := addon.pou()) is not None]
        for program in programs:
            pous += program.pous()
        pous = self._clocked(pous)
        configurations = tasks.configurations(self.controller,
                                              {p.node.get("Name").upper(): p.name for p in programs},
                                              self.context)
        structures = [*self.declared, *(s for s in self.context.types.used if s not in self.declared)]
        declarations = tuple(types.declaration(s) for s in structures)
        return ast.File(self.reading.source, (*self.context.support.pous(), *self.context.made, *pous),
                        declarations, self._globals(),
                        configurations, (), False, tuple(self.reading.remarks))

    # ---- types

    def _types(self) -> list[tuple[Node, Structure]]:
        """The structures of the file, still without members."""
        nodes = [n for group in self.controller.all("DataTypes", "Datatypes")
                 for n in group.all("DataType", "Datatype")]
        known = self.context.types.known
        made: list[tuple[Node, Structure]] = []
        for node in nodes:
            name = node.get("Name")
            key = name.upper()
            if types.is_predefined(name):
                self.reading.remark("left out", f"the type {name}", "it is built in", node.span)
                continue
            if key in known:
                self.reading.malformed(node.attribute("Name"), f"type `{name[:40]}` is defined twice",
                                       help="keep one of them")
                continue
            if node.get("Family") == "StringFamily":
                data = next((m for m in node.descendants("Member") if m.get("Name").upper() == "DATA"), None)
                known[key] = Text(max(data.number("Dimension", 82), 1) if data is not None else 82)
                self.reading.remark("mapped", f"string type {name}", types.text(known[key]), node.span)
                continue
            span = node.attribute("Name")
            known[key] = structure = Structure(self._free(name, span, f"type {key}"), name, span)
            made.append((node, structure))
        self.declared += [structure for _, structure in made]
        return made

    def _members(self, node: Node, structure: Structure) -> None:
        """The members. Bits of an integer of the same structure are its bits, unless it is hidden and nothing
        names it: they are BOOLs then, and it is left out."""
        names = Names(self.reading)
        members = [member for group in node.all("Members") for member in group.all("Member")]
        whole = {m.get("Name").upper(): type_name(m).upper() for m in members if self._is_whole(m)}
        for member in members:
            foreign, span = member.get("Name"), member.attribute("Name")
            if member.flag("Hidden") and not self._named(foreign):
                self.reading.remark("left out", f"{structure.foreign}.{foreign}",
                                    "it only holds the bits that have names", span)
                continue
            type_ = self._type(member, "Dimension", "Dimensions")
            if type_ is None:
                self.reading.left_out(span, f"member {structure.foreign}.{foreign}",
                                      f"the file does not tell its type {type_name(member)[:40]}")
                continue
            note = prose(member.find("Description")) or None
            if type_ == BOOL and member.get("Target").upper() in whole:
                held, bit = member.get("Target"), member.number("BitNumber", 0)
                integer = whole[held.upper()]
                if not 0 <= bit < types.WIDTHS[integer]:
                    self.reading.malformed(member.attribute("BitNumber"), f"{integer} has no bit {bit}",
                                           help=f"the bits are 0 to {types.WIDTHS[integer] - 1}")
                    continue
                self.reading.remark("mapped", f"{structure.foreign}.{foreign}", f"bit {bit} of {held}", span)
                structure.members[foreign.upper()] = Member(foreign, type_, span, note, alias=f"{held}.{bit}")
                continue
            structure.members[foreign.upper()] = Member(
                names.name(foreign, span), type_, span, note)

    def _is_whole(self, member: Node) -> bool:
        """Whether a member is an integer whose bits other members of its structure may be."""
        if type_name(member).upper() not in types.WIDTHS or self._sizes(member, "Dimension", "Dimensions"):
            return False
        return not member.flag("Hidden") or self._named(member.get("Name"))

    def _named(self, member: str) -> bool:
        """Whether something of the file names a member of that name, whatever it is a member of."""
        if self.named is None:
            text = self.controller.span.source.text
            self.named = frozenset(match[1].upper() for match in _MEMBER.finditer(text))
        return member.upper() in self.named

    def _type(self, node: Node, *dimensions: str) -> Type | None:
        name = type_name(node)
        span = node.attribute("DataType" if node.get("DataType") else "Datatype")
        found = self.context.types.named(name, span)
        return self.context.types.dimensioned(found, self._sizes(node, *dimensions))

    def _sizes(self, node: Node, *attributes: str) -> tuple[int, ...]:
        for attribute in attributes or ("Dimensions", "Dimension"):
            text = node.get(attribute)
            if not text:
                continue
            found = types.sizes(text)
            if found is None or types.total(found) > types.MAX_ELEMENTS:
                self.reading.malformed(node.attribute(attribute),
                                       f"`{text[:40]}` are no dimensions of an array",
                                       help=f"at most {types.MAX_ELEMENTS:,} elements in all")
                return ()
            return found
        return ()

    def _free(self, wanted: str, span: Span, key: str) -> str:
        """A name for a type or POU: none that the standard library has."""
        upper = wanted.upper()
        if functions.is_function(upper) or blocks.signature(upper) is not None:
            self.reading.remark("renamed", wanted, f"{wanted}_", span)
            return self.context.names.fresh(f"{wanted}_")
        return self.context.names.name(wanted, span, key)

    # ---- Add-On Instructions

    def _addons(self) -> list[AddOn]:
        found: list[AddOn] = []
        groups = list(self.controller.all("AddOnInstructionDefinitions"))
        for node in (n for group in groups for n in group.all("AddOnInstructionDefinition")):
            name, span = node.get("Name"), node.attribute("Name")
            key = name.upper()
            if key in self.context.addons or key in instructions.TABLE or key in self.context.types.known:
                self.reading.malformed(span, f"Add-On Instruction `{name[:40]}` has the name of another "
                                       "instruction or type", help="give it a name of its own")
                continue
            function = self._free(name, span, f"addon {key}")
            data = Structure(self.context.names.fresh(f"{function}_data"), name, span)
            addon = AddOn(self.context, node, data, function)
            self.context.addons[key] = addon
            self.context.types.known[key] = data
            self.declared.append(data)
            found.append(addon)
        for group in groups:
            for node in group.all("EncodedData"):
                self.reading.unsupported(node.span, f"protected Add-On Instruction {node.get('Name')}",
                                         "export it without source protection")
        return found

    # ---- tags

    def _tags(self, holder: Node, scope: Scope, program: str) -> None:
        for node in (n for group in holder.all("Tags") for n in group.all("Tag")):
            foreign, span = node.get("Name"), node.attribute("Name")
            key = foreign.upper()
            note = prose(node.find("Description")) or None
            if node.get("TagType") == "Alias":
                text = node.attribute("AliasFor")
                scope.tags.setdefault(key, Tag(foreign, foreign, None, span, alias=text))
                self.reading.remark("mapped", foreign, f"another name for {text.text}", span)
                continue
            data = told(node)
            if data is None and any(n.get("Format") == "L5K" for n in node.all("Data")):
                self.reading.left_out(span, f"the value of `{foreign}` at the start",
                                      "it is not exported in decorated form; the tag begins with 0")
            type_ = self._type(node)
            tag = Tag(self.tag_names[program, key], foreign, type_, span, type_name(node),
                      constant=node.flag("Constant"), data=data, note=note)
            scope.tags.setdefault(key, tag)
            self.context.globals.declare(tag)
            if node.get("TagType") in ("Produced", "Consumed"):
                self.reading.remark("mapped", f"{node.get('TagType').lower()} tag {foreign}",
                                    "a variable that nobody else reads or writes", span)

    def _name_tags(self) -> None:
        """Tags choose first. A program tag whose name another has gets the program in front."""
        seen: set[str] = set()
        holders = [self.controller,
                   *(n for group in self.controller.all("Programs") for n in group.all("Program"))]
        for holder in holders:
            program = holder.get("Name").upper() if holder is not self.controller else ""
            for node in (n for group in holder.all("Tags") for n in group.all("Tag")):
                foreign, key = node.get("Name"), (program, node.get("Name").upper())
                if key in self.tag_names or node.get("TagType") == "Alias":
                    continue
                wanted = f"{holder.get('Name')}_{foreign}" if foreign.upper() in seen and program else foreign
                seen.add(foreign.upper())
                made = self.tag_names[key] = self.context.names.fresh(wanted)
                if made != foreign:
                    self.reading.remark("renamed", foreign, made, node.attribute("Name"))

    def _programs(self, scope: Scope) -> list[Program]:
        found = []
        for node in (n for group in self.controller.all("Programs") for n in group.all("Program")):
            name, span = node.get("Name"), node.attribute("Name")
            made = self._free(name, span, f"program {name.upper()}")
            own = Scope(scope)
            self.context.globals.programs[name.upper()] = own
            self._tags(node, own, name.upper())
            found.append(Program(self.context, made, node, own))
        return found

    def _known(self, tag: Tag) -> bool:
        """Whether the tag can be declared; one that cannot is left out unless some logic uses it."""
        if tag.type is None and tag.used:
            self.reading.malformed(tag.span,
                                   f"the file does not tell the type {tag.type_name[:40]} of `{tag.foreign}`",
                                   help="export the type with what uses it")
        elif tag.type is None:
            self.reading.left_out(tag.span, f"tag {tag.foreign}",
                                  f"the file does not tell its type {tag.type_name[:40]}; nothing uses it")
        return tag.type is not None

    def _globals(self) -> tuple[ast.VarBlock, ...]:
        sections = []
        known = [t for t in self.context.globals.tags if self._known(t)]
        for constant in (False, True):
            declared = tuple(
                ast.VarDecl(t.name, None, types.written(t.type or t.type_name, t.span),
                            initial(t, self.reading), t.span,
                            t.span, t.note)
                for t in known if t.constant is constant)
            if declared:
                sections.append(ast.VarBlock("VAR_GLOBAL", ("CONSTANT",) if constant else (), declared,
                                             self.controller.span))
        if self.context.support.clock is not None:
            sections.append(ast.VarBlock("VAR_GLOBAL", (), self._clock(self.controller.span),
                                         self.controller.span))
        return tuple(sections)

    # ---- the clock of the timers

    def _clock(self, span: Span) -> tuple[ast.VarDecl, ...]:
        """The time that timers read, and the timer that gives it."""
        return tuple(ast.VarDecl(name, None, ast.NamedType(type_, None, span), None, span, span)
                     for name, type_ in zip(self.context.support.clock, ("TIME", "TON"), strict=True))

    def _clocked(self, pous: list[ast.Pou]) -> list[ast.Pou]:
        """Every PROGRAM begins by reading the time, when there are timers."""
        if self.context.support.clock is None:
            return pous
        found = []
        for pou in pous:
            if pou.kind == "PROGRAM" and isinstance(pou.body, ast.LadderBody):
                span = pou.name_span
                time, timer = (ast.Name(v.name, span) for v in self._clock(span))
                pins = (ast.Pin("IN", ast.Literal(True, "BOOL", "TRUE", span), False, span),
                        ast.Pin("PT", ast.Literal(106_751 * 86_400 * 10**9, "TIME", _LONGEST_CLOCK, span),
                                False, span),
                        ast.Pin("ET", time, True, span))
                block = ast.Block(timer, "TON", pins, "_", "_", span)
                rung = ast.Rung(None, "The time that the timers of this program see",
                                (ast.Path((block,), span),), span)
                externals = ast.VarBlock("VAR_EXTERNAL", (), self._clock(span), span)
                pou = replace(pou, var_blocks=(externals, *pou.var_blocks),
                              body=ast.LadderBody((rung, *pou.body.rungs), pou.body.span))
            found.append(pou)
        return found


def type_name(node: Node) -> str:
    return node.get("DataType") or node.get("Datatype")
