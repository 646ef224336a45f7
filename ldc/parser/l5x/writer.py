"""The rungs of one routine: trees of instructions become contacts, coils and blocks, in the same order.

A rung is evaluated from left to right, a branch from top to bottom, and every output passes the power on:
that is the order of the ladder language too, so what stands in a rung keeps its place.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.foreign import Names, Reading
from ldc.parser.l5x import instructions
from ldc.parser.l5x.neutral import Branch, Element, Instruction
from ldc.parser.l5x.operands import BITS, Operands
from ldc.parser.l5x.scope import Externals, Globals, Scope
from ldc.parser.l5x.support import Support
from ldc.parser.l5x.types import BOOL, DINT, Structure, Type, Types, is_structure
from ldc.parser.l5x.values import Value, boolean, convert, negated
from ldc.records import record
from ldc.source import Span

if TYPE_CHECKING:
    from ldc.parser.l5x.addon import AddOn
    from ldc.parser.l5x.routines import Program

_PLACES = (ast.Name, ast.Member, ast.Index, ast.Direct)
RETURN = "RETURN"


@dataclass(slots=True)
class Context:
    """What the parts of one file share. ``made``: POUs that single instructions needed."""

    reading: Reading
    names: Names
    types: Types
    globals: Globals
    support: Support
    addons: dict[str, AddOn] = field(default_factory=dict)
    made: list[ast.Pou] = field(default_factory=list)


@record
class Drawn:
    """A rung as it was written."""

    elements: tuple[Element, ...]
    span: Span
    title: str | None


class Writer:
    """``scope``: the tags that the routine sees; ``leave``: the rung that ends the POU, or RETURN.
    ``routines`` know how to call others (None in an Add-On Instruction)."""

    def __init__(self, context: Context, scope: Scope, kind: str, leave: str = RETURN,
                 routines: Program | None = None, owner: Structure | None = None) -> None:
        self.context, self.reading, self.support = context, context.reading, context.support
        self.scope, self.kind, self.leave, self.routines, self.owner = scope, kind, leave, routines, owner
        self.externals = Externals()
        self.operands = Operands(context.reading, scope, context.globals, self.externals, context.support)
        self.locals: dict[str, ast.VarDecl] = {}
        self.labels: dict[str, str] = {}
        self.zone: str | None = None

    def inside(self) -> Writer:
        """For a POU that works on the same tags."""
        other = Writer(self.context, self.scope, self.kind, self.leave, self.routines, self.owner)
        other.operands.scan = self.operands.scan
        return other

    # ---- operands

    def read(self, text: Span, real: bool = False, hint: Type | None = None) -> Value | None:
        return self.operands.read(text, real, hint)

    def place(self, text: Span, hint: Type | None = None) -> Value | None:
        return self.operands.place(text, hint)

    def structure(self, text: Span, name: str) -> tuple[Value, Structure] | None:
        """A tag of a predefined structure, TIMER and the like."""
        found = self.place(text)
        if found is None:
            return None
        if found.type is not None and not is_structure(found.type, name):
            self.reading.malformed(text, f"`{text.text[:40]}` is no {name}",
                                   help=f"give it a tag of type {name}")
            return None
        return found, self.context.types.named(name, text)

    def start(self, value: Value, steps: tuple, number: object) -> None:
        """The value that a place has when the controller begins to run."""
        if value.way is None or value.way[0].local:
            return
        tag, way = value.way
        if tag.of and self.owner is not None:
            self.owner.starts[(tag.foreign.upper(), *way, *steps)] = number
        elif not tag.of:
            tag.starts[(*way, *steps)] = number

    def local(self, wanted: str, type_: ast.TypeExpr, span: Span, key: str | None = None) -> str:
        """A variable of the POU; the same one for the same ``key``."""
        if key is None or key not in self.locals:
            name = self.context.names.fresh(wanted)
            self.locals[key or name] = ast.VarDecl(name, None, type_, None, span, span)
            return name
        return self.locals[key].name

    # ---- items

    def contact(self, value: Value, span: Span, closed: bool = False) -> ast.Contact:
        if isinstance(value.expr, _PLACES):
            return ast.Contact("/" if closed else "", value.expr, span)
        return ast.Contact("", negated(value.expr) if closed else value.expr, span)

    def always(self, value: bool, span: Span) -> ast.Contact:
        return ast.Contact("", boolean(value, span), span)

    def coil(self, value: Value, span: Span) -> ast.Item:
        """What gives a BOOL the power, and passes it on."""
        if value.whole is None:
            return ast.Coil("", value.expr, span)
        return self.set_bit(value, span, None)

    def set_bit(self, value: Value, span: Span, to: ast.Expr | None) -> ast.Block:
        """Gives a bit of an integer the power, or (under power) the value ``to``."""
        name = self.support.use("logix_set_bit", T=value.whole.type.name, BITS=BITS[value.whole.type.name])
        pins = [("bit", value.bit), ("whole", value.whole.expr)]
        if to is None:
            return self.block(name, span, pins, "power", "OUT")
        return self.block(name, span, [("power", to), *pins])

    def block(self, type_: str, span: Span, pins: Iterable[tuple[str, ast.Expr]], power_in: str | None = None,
              power_out: str | None = None, outputs: Iterable[tuple[str, ast.Expr]] = (),
              instance: ast.Expr | None = None) -> ast.Block:
        written = (*(ast.Pin(name, expr, False, expr.span) for name, expr in pins),
                   *(ast.Pin(name, expr, True, expr.span) for name, expr in outputs))
        return ast.Block(instance, type_, written, power_in, power_out, span)

    def store(self, target: Value, value: Value, span: Span) -> ast.Block:
        """Under power the target becomes the value, converted."""
        if target.whole is not None:
            return self.set_bit(target, span, convert(value, BOOL))
        if target.text is not None:
            name = self.support.use("logix_resize", N=str(target.text.type.length))
            return self.block(name, span, [("source", target.text.expr), ("length", convert(value, DINT))],
                              outputs=[("OUT", target.text.expr)])
        return self.block("MOVE", span, [("IN", convert(value, target.type))], outputs=[("OUT", target.expr)])

    # ---- rungs

    def rung(self, drawn: Drawn, name: str | None) -> ast.Rung | None:
        """None when nothing is left of it, or when something of it was wrong."""
        lost = self.reading.lost
        self.reading.lost = self.operands.strange = False
        zone = self.zone
        items = self.series(drawn.elements)
        if not self.operands.strange:
            items = self._useful(items)
        failed, self.reading.lost = self.reading.lost, self.reading.lost or lost
        if failed or not items or not self._ends_well(items, False)[0]:
            return None
        if zone is not None:
            items = [ast.Contact("", ast.Name(zone, drawn.span), drawn.span), *items]
        return self.made(items, drawn.span, name, drawn.title)

    def made(self, items: Iterable[ast.Item], span: Span, name: str | None = None,
             title: str | None = None) -> ast.Rung:
        return ast.Rung(name, title, (ast.Path(tuple(items), span),), span, span if name else None)

    def series(self, elements: tuple[Element, ...]) -> list[ast.Item]:
        items: list[ast.Item] = []
        for element in elements:
            items += self._branch(element) if isinstance(element, Branch) else self._instruction(element)
        return items

    def _branch(self, branch: Branch) -> list[ast.Item]:
        levels = [self.series(level) for level in branch.levels]
        if not any(levels):
            return []
        if len(levels) == 1:
            return levels[0]
        paths = tuple(ast.Path(tuple(items), items[0].span.to(items[-1].span)) if items else
                      ast.Path((self.always(True, branch.span),), branch.span) for items in levels)
        return [ast.Branches(paths, branch.span)]

    def _instruction(self, instruction: Instruction) -> list[ast.Item]:
        return instructions.write(self, instruction)

    def _useful(self, items: list[ast.Item]) -> list[ast.Item]:
        """Without the contacts at the end, which lead to nothing."""
        items, told = list(items), False
        while items:
            last = items.pop()
            if isinstance(last, ast.Contact):
                if not told and not isinstance(last.expr, ast.Literal) or not items:
                    self.reading.left_out(last.span, "a condition", "no instruction behind it does anything")
                    told = True
                continue
            if not isinstance(last, ast.Branches):
                return [*items, last]
            lefts = [(path, left) for path in last.paths if (left := self._useful(list(path.items)))]
            if len(lefts) > 1:
                return [*items, ast.Branches(tuple(ast.Path(tuple(left), p.span) for p, left in lefts),
                                             last.span)]
            if lefts:
                return [*items, *lefts[0][1]]
        return items

    def _ends_well(self, items: Iterable[ast.Item], jumped: bool) -> tuple[bool, bool]:
        """Whether nothing is done behind a jump, which leaves at once in the controller and behind its rung
        here; and whether a jump was passed."""
        for item in items:
            if isinstance(item, ast.Branches):
                for path in item.paths:
                    good, jumped = self._ends_well(path.items, jumped)
                    if not good:
                        return False, jumped
            elif isinstance(item, ast.Jump):
                jumped = True
            elif jumped and not isinstance(item, ast.Contact):
                self.reading.unsupported(item.span,
                                         "an instruction behind a jump, return or end on the same rung",
                                         "draw it before the jump, or on a rung of its own")
                return False, jumped
        return True, jumped

    def sections(self, span: Span) -> tuple[ast.VarBlock, ...]:
        """The declarations that the rungs need."""
        local = (ast.VarBlock("VAR", (), tuple(self.locals.values()), span),) if self.locals else ()
        return (*self.externals.sections(span), *local)
