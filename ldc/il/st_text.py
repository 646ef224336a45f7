"""A program as Structured Text: what any POU does, whatever it was drawn or written in.

Bodies are made from the IL: statements with expressions, jumps as IF, WHILE and, where ranges cross, a loop
over numbered parts. The text compiles to a program that does the same, scan by scan.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping

from ldc.expr import Apply, BitStep, Const, Expr, FieldStep, IndexStep, Load, Place, Step
from ldc.il import structure as il
from ldc.il.control import Plan, plan
from ldc.il.declare import Declarations
from ldc.il.literals import literal, type_text
from ldc.il.names import Names
from ldc.il.plain import has_paths, without_paths
from ldc.il.program import Program, Unit
from ldc.il.reads import loads, read_once, reads
from ldc.records import replace
from ldc.symbols import Variable
from ldc.types import DINT, Array, Instance, Struct, Type, holds_blocks

_INFIX = {"OR": (1, "OR"), "XOR": (2, "XOR"), "AND": (3, "AND"), "EQ": (4, "="), "NE": (4, "<>"),
          "LT": (5, "<"), "GT": (5, ">"), "LE": (5, "<="), "GE": (5, ">="), "ADD": (6, "+"), "SUB": (6, "-"),
          "MUL": (7, "*"), "DIV": (7, "/"), "MOD": (7, "MOD")}
_CHAINS = frozenset(("OR", "XOR", "AND", "ADD", "MUL"))
_UNARY, _ATOM = 8, 9
_PREFIX, _PLAIN = "_LDC_", "ldc_"
_PART = "ldc_part"


def print_st(program: Program, bodies: Mapping[str, str] = {}) -> str:
    """The whole project as one text. ``bodies``: POUs, by name in capitals, whose text is there already (they
    were written in Structured Text). Standard function blocks are left out, every compiler has them."""
    bodies = {u.name.upper(): bodies[u.name.upper()] for u in program.units
              if u.name.upper() in bodies and not has_paths(u)}
    program = without_paths(program)
    units = tuple(_plain_names(unit) for unit in program.units if not unit.standard)
    declarations = _Declarations(Names(), program.units)
    functions = {u.name.upper(): u for u in program.units if u.kind == "FUNCTION"}
    used = [v.type for u in units for v in u.variables] + [v.type for v in program.globals]
    lines = list(declarations.types(map(_plain_type, (*program.types, *used))))
    for unit, plain in zip((u for u in program.units if not u.standard), units, strict=True):
        text = bodies.get(unit.name.upper())
        if text is None:
            lines += _Body(unit, plain, functions, program.globals, declarations).lines()
        else:
            lines += text.rstrip("\n").split("\n")
        lines.append("")
    lines += declarations.configuration(program)
    return "\n".join(lines).rstrip("\n") + "\n" if lines else ""


class _Declarations(Declarations):
    """Types that the compiler made have names that a source may have."""

    def type_of(self, type_: Type) -> str:
        return super().type_of(_plain_type(type_))


def _plain_type(type_: Type) -> Type:
    match type_:
        case Array(element=element):
            return replace(type_, element=_plain_type(element))
        case Struct(name, fields):
            name = _PLAIN + name[len(_PREFIX):] if name.upper().startswith(_PREFIX) else name
            return Struct(name, tuple(replace(f, type=_plain_type(f.type)) for f in fields))
    return type_


def _plain_names(unit: Unit) -> Unit:
    """The variables that the compiler made under names that a source may have."""
    names = _renamed(unit.variables)
    return replace(unit, variables=tuple(
        replace(v, name=names.get(v.name.upper(), v.name), kind="local" if v.kind == "hidden" else v.kind)
        for v in unit.variables))


def _renamed(variables: Iterable[Variable]) -> dict[str, str]:
    taken = {v.name.upper() for v in variables} | {_PART.upper()}
    made: dict[str, str] = {}
    for v in variables:
        if not v.name.upper().startswith(_PREFIX):
            continue
        name = plain = _PLAIN + v.name[len(_PREFIX):]
        number = 1
        while name.upper() in taken:
            number += 1
            name = f"{plain}_{number}"
        taken.add(name.upper())
        made[v.name.upper()] = name
    return made


class _Body:
    """Prints one unit. ``plain`` has the names of the text, the statements those of the IL."""

    def __init__(self, unit: Unit, plain: Unit, functions: Mapping[str, Unit], shared: Iterable[Variable],
                 declarations: Declarations) -> None:
        self.unit, self.plain, self.declarations = unit, plain, declarations
        self.shared = {v.name.upper(): v for v in shared}
        self.code = il.structure(unit, functions, self.shared.values(), alone=lambda node: False)
        self.plan: Plan = plan(self.code.flat)
        self.names = _renamed((*unit.variables, *self.code.temporaries))
        self.out: list[str] = []
        self.indent = 1
        self.own = {v.name.upper(): v for v in unit.variables}
        self.pins: list[tuple[Place, Expr]] = []
        # Instances that calls are given: by pins, and by the temporaries that FUNCTIONs work on.
        self.lent: list[tuple[Place, Expr]] = []
        self.lenders: dict[str, Expr] = {}
        self.used: dict[str, Place] = {}
        self.within = read_once(self.code.statements)
        # Calls that wait for the expression that reads their result, by its temporary.
        self.waiting: dict[str, il.CallFunction] = {}
        self.named: set[str] = set()

    def lines(self) -> Iterator[str]:
        """The POU, line by line."""
        self._body()
        unit = self.plain
        result = f" : {type_text(unit.result)}" if unit.result is not None else ""
        title = f" (* {_comment(unit.title)} *)" if unit.title else ""
        own = [v for v in unit.variables
               if not (unit.kind == "FUNCTION" and v.name.upper() == unit.name.upper())
               and not (v.kind == "temp" and holds_blocks(v.type))]  # of instances lent to a FUNCTION
        temps = [replace(v, name=self.names[v.name.upper()]) for v in self.code.temporaries
                 if v.name.upper() in self.named]
        if self.plan.segments:
            temps.append(Variable(_PART, DINT, "temp"))
        yield f"{unit.kind} {unit.name}{result}{title}"
        yield from self.declarations.variables((*own, *self._externals(own), *temps), None)
        yield from self.out
        yield f"END_{unit.kind}"

    def _externals(self, own: Iterable[Variable]) -> list[Variable]:
        known = {v.name.upper() for v in own}
        found = (self.shared.get(key) for key in self.used if key not in known)
        return [replace(v, kind="external", location=None, retain=False) for v in found if v is not None]

    # ---- the body

    def _body(self) -> None:
        plan_, flat = self.plan, self.code.flat
        statements: dict[int, list[il.Statement]] = {}
        for statement in self.code.statements:
            statements.setdefault(statement.at, []).append(statement)
        segments = {at: number for number, at in enumerate(plan_.segments)}
        ends: list[tuple[int, str]] = []
        if segments:
            self._line(f"{_PART} := 0;")
            self._open("WHILE TRUE DO")
        inside = False
        for at in range(len(flat.code)):
            while ends and ends[-1][0] == at:
                self._close(ends.pop()[1])
            if at in segments:
                if inside:
                    self._close("END_IF;")
                self._open(f"IF {_PART} < {segments[at] + 1} THEN")
                inside = True
            if at in flat.starts:
                self._rung(at)
            if at in plan_.loops.ends:
                self._open("WHILE TRUE DO")
                ends.append((plan_.loops.ends[at] + 1, "END_WHILE;"))
            for statement in statements.get(at, ()):
                _PRINTERS[type(statement)](self, statement)
            if at in plan_.blocks:
                ends.append((plan_.blocks[at], "END_IF;"))
            elif at in plan_.others:
                self._flush()
                ends.pop()
                self.indent -= 1
                self._open("ELSE")
                ends.append((plan_.others[at], "END_IF;"))
        self._flush()
        while ends:
            self._close(ends.pop()[1])
        if segments:
            self._close("END_IF;")
            self._line("EXIT;")
            self._close("END_WHILE;")

    def _rung(self, at: int) -> None:
        rung = self.unit.rungs[self.code.flat.places[at][0]]
        about = ": ".join(part for part in (rung.name, rung.title) if part)
        if about:
            self._line(f"(* {_comment(about)} *)")

    def _line(self, text: str) -> None:
        self._flush()
        self.out.append("    " * self.indent + text)

    def _open(self, text: str) -> None:
        self._line(text)
        self.indent += 1

    def _close(self, text: str) -> None:
        self._flush()
        self.indent -= 1
        self._line(text)

    def _when(self, condition: Expr | None, text: str) -> None:
        if condition is None or condition == Const(True, condition.type):
            self._line(text)
            return
        self._open(f"IF {self._text(condition)} THEN")
        self._line(text)
        self._close("END_IF;")

    # ---- statements

    def assign(self, s: il.Assign) -> None:
        if holds_blocks(s.target.type):
            self._lend(s)
            return
        if self._is_pin(s.target):
            if self.pins and not _same_instance(self.pins[0][0], s.target.root, s.target.steps[:-1]):
                self._flush()
            if any(reads(call, s.target.root) for call in self.waiting.values()):
                self._settle()
            self.pins.append((s.target, s.value))
            return
        self._line(f"{self._place(s.target)} := {self._text(s.value)};")

    def _lend(self, s: il.Assign) -> None:
        """An instance that a call is given is named in it; that it is taken back needs no words."""
        if self._is_pin(s.target):
            self.lent.append((s.target, s.value))
        elif s.target.root.upper().startswith(_PREFIX):
            self.lenders[s.target.root.upper()] = s.value

    def _is_pin(self, target: Place) -> bool:
        """Whether it is an input of an instance, set by its name: such ones join their call."""
        if not target.steps or not isinstance(target.steps[-1], FieldStep):
            return False
        variables = self.shared if target.is_global else self.own
        variable = variables.get(target.root.upper())
        type_ = None if variable is None else variable.type
        for step in target.steps[:-1]:
            match type_, step:
                case Array(element=inner), IndexStep():
                    type_ = inner
                case Struct(), FieldStep(name):
                    type_ = type_.field(name).type
                case _:
                    return False
        return isinstance(type_, Instance)

    def _flush(self) -> None:
        """Pins that no call followed are assignments. FUNCTIONs that no expression has called by now are
        called."""
        pins, self.pins = self.pins, []
        lines = [f"{self._place(target)} := {self._text(value)};" for target, value in pins]
        self._settle()
        self.out += ("    " * self.indent + line for line in lines)

    def _settle(self) -> None:
        """Calls whose results are not read where they stand keep them in temporaries."""
        waiting, self.waiting = self.waiting, {}
        for call in waiting.values():
            self.out.append("    " * self.indent + f"{self._place(call.result)} := {self._called(call)};")

    def latch(self, s: il.Latch) -> None:
        self._when(s.condition, f"{self._place(s.target)} := {'TRUE' if s.value else 'FALSE'};")

    def block(self, s: il.CallBlock) -> None:
        pins = self.pins
        instance = s.instance
        mine = [pin for pin in self.lent if _same_instance(pin[0], instance.root, instance.steps)]
        self.lent = [pin for pin in self.lent if pin not in mine]
        joined = s.condition is None and pins and _same_instance(pins[0][0], instance.root, instance.steps)
        names = [target.steps[-1].name.upper() for target, _ in pins]
        own = any(p.root == s.instance.root for _, value in pins for p in loads(value))
        if not joined or len(set(names)) < len(names) or own:
            self._when(s.condition, f"{self._place(s.instance)}({self._given(mine)});")
            return
        self.pins = []
        self._line(f"{self._place(s.instance)}({self._given((*pins, *mine))});")

    def _given(self, pins: Iterable[tuple[Place, Expr]]) -> str:
        return ", ".join(f"{target.steps[-1].name} := {self._text(value)}" for target, value in pins)

    def function(self, s: il.CallFunction) -> None:
        if s in self.within:
            if any(reads(s, target.root) for target, _ in self.pins):
                self._flush()
            self.waiting[s.result.root.upper()] = s
            return
        self._settle()
        outputs = {name.upper(): place for name, place in s.outputs}
        given = []
        for variable, value in zip(s.function.arguments, s.arguments, strict=True):
            if holds_blocks(variable.type):
                outputs.pop(variable.name.upper(), None)
                value = self.lenders.get(value.place.root.upper(), value)
                given.append(f"{variable.name} := {self._text(value)}")
            elif variable.kind == "in_out":
                place = outputs.pop(variable.name.upper())
                self._line(f"{self._place(place)} := {self._text(value)};")
                given.append(f"{variable.name} := {self._place(place)}")
            else:
                given.append(f"{variable.name} := {self._text(value)}")
        kinds = {v.name.upper(): v.name for v in s.function.variables}
        given += [f"{kinds[name]} => {self._place(place)}" for name, place in outputs.items()]
        call = f"{s.function.name}({', '.join(given)});"
        self._line(call if s.result is None else f"{self._place(s.result)} := {call}")

    def _called(self, s: il.CallFunction) -> str:
        """A call of a FUNCTION that writes nothing but its result."""
        given = zip(s.function.arguments, s.arguments, strict=True)
        return f"{s.function.name}({', '.join(f'{v.name} := {self._text(value)}' for v, value in given)})"

    def native(self, s: il.CallNative) -> None:
        external = self.unit.external
        self._line(f"(* here runs {external.entry}, written in {external.language} *)")

    def label(self, s: il.Label) -> None:
        """Where a jump leads: the blocks around it say that."""

    def leave(self, s: il.Return) -> None:
        self._when(s.condition, "RETURN;")

    def jump(self, s: il.Goto) -> None:
        self._flush()
        plan_ = self.plan
        if s.at in plan_.others:
            return
        if s.at in plan_.blocks:
            self._open(f"IF {'FALSE' if s.condition is None else self._negated(s.condition)} THEN")
        elif s.at in plan_.loops.jumps:
            if plan_.loops.ends.get(s.target) == s.at:
                if s.condition is not None:
                    self._when_text(self._negated(s.condition), "EXIT;")
            else:
                self._when(s.condition, "EXIT;" if s.target > s.at else "CONTINUE;")
        else:
            past = s.target >= len(self.code.flat.code)
            number = len(plan_.segments) if past else bisect_left(plan_.segments, s.target)
            if s.condition is not None:
                self._open(f"IF {self._text(s.condition)} THEN")
            self._line(f"{_PART} := {number};")
            self._line("CONTINUE;")
            if s.condition is not None:
                self._close("END_IF;")

    def _when_text(self, condition: str, text: str) -> None:
        self._open(f"IF {condition} THEN")
        self._line(text)
        self._close("END_IF;")

    def _negated(self, condition: Expr) -> str:
        if isinstance(condition, Apply) and condition.op == "NOT":
            return self._text(condition.args[0])
        return f"NOT {self._text(condition, _UNARY)}"

    # ---- expressions

    def _text(self, expr: Expr, level: int = 0) -> str:
        """An expression for a place that takes operators of ``level`` and above without brackets."""
        match expr:
            case Const():
                return literal(expr.value, expr.type, True)
            case Load(place):
                call = self.waiting.pop(place.root.upper(), None) if not place.steps else None
                return self._place(place) if call is None else self._called(call)
        text, own = self._operation(expr)
        return text if own >= level else f"({text})"

    def _operation(self, expr: Apply) -> tuple[str, int]:
        op, args = expr.op, expr.args
        if op == "MOVE":
            return self._text(args[0], _ATOM), _ATOM
        if op == "NOT":
            return f"NOT {self._text(args[0], _UNARY)}", _UNARY
        if op in _INFIX and len(args) >= 2 and (len(args) == 2 or op in _CHAINS):
            level, sign = _INFIX[op]
            first = self._text(args[0], level if op in _CHAINS or level > 5 else level + 1)
            rest = (self._text(a, level + 1) for a in args[1:])
            return f" {sign} ".join((first, *rest)), level
        return f"{op}({', '.join(self._text(a) for a in args)})", _ATOM

    def _place(self, place: Place) -> str:
        if place.is_global:
            self.used.setdefault(place.root.upper(), place)
        else:
            self.named.add(place.root.upper())
        text = place.root if place.is_global else self.names.get(place.root.upper(), place.root)
        for step in place.steps:
            match step:
                case FieldStep(name):
                    text += f".{name}"
                case BitStep(bit):
                    text += f".{bit}"
                case IndexStep(indexes):
                    text += f"[{', '.join(self._index(i) for i in indexes)}]"
        return text

    def _index(self, index: Expr) -> str:
        return str(index.value) if isinstance(index, Const) else self._text(index)


_B = _Body
_PRINTERS: dict[type, Callable[[_Body, il.Statement], None]] = {
    il.Assign: _B.assign, il.Latch: _B.latch, il.CallBlock: _B.block, il.CallFunction: _B.function,
    il.CallNative: _B.native, il.Label: _B.label, il.Goto: _B.jump, il.Return: _B.leave,
}


def _same_instance(pin: Place, root: str, steps: tuple[Step, ...]) -> bool:
    return pin.root.upper() == root.upper() and pin.steps[:-1] == steps


def _comment(text: str) -> str:
    return text.replace("(*", "( *").replace("*)", "* )")
