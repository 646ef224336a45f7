"""IL -> Python source, one function per POU (and per program instance).

The accumulator is executed symbolically: it is a Python expression until a store needs it. Everything
that can fault is a statement of its own, so the line of an exception tells the IL instruction, and no
rung pays for a ``try``. What an unevaluated expression reads is evaluated before a store changes it.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable

from ldc.il.flat import JUMPS, Flat
from ldc.il.pieces import FORGETS
from ldc.il.program import Instr
from ldc.records import record
from ldc.types import REAL, Instance, Type, default, is_scalar, storage
from runtime.layout import slot
from runtime.vm import expression as ex
from runtime.vm.access import Access
from runtime.vm.calls import SELECTIONS, is_integral
from runtime.vm.expression import Expression
from runtime.vm.writer import BadCode

ARITY = 8


@record
class Source:
    """Python text of one function and, per line (from 1), the flat position of its instruction (-1: none)."""

    text: str
    lines: tuple[int, ...]
    flat: Flat


class Body(Access):
    """Translates one unit."""

    # ---- the whole function ----------------------------------------------------------------------

    def source(self) -> Source:
        """The function's text. Raises BadCode for IL that no verified program holds."""
        self._body()
        head = [f"def {self.function}({', '.join(self._parameters())}):"]
        if self.written:
            head.append(" global " + ", ".join(sorted(self.written)))
        head += [f" {text}" for text in self._prologue()]
        lines = head + self.lines
        origins = [-1] * len(head) + self.origins
        return Source("\n".join(lines) + "\n", (-1, *origins), self.flat)

    def _parameters(self) -> list[str]:
        if self.unit.kind == "FUNCTION":
            return [f"l_{slot(v.name)}" for v in self.unit.arguments]
        return ["self"] if self.unit.kind == "FUNCTION_BLOCK" else []

    def _prologue(self) -> list[str]:
        """Initial values of the locals that may be read before they are written."""
        made = []
        changed = self.unit.changed
        for v in self.unit.variables:
            local = f"l_{slot(v.name)}"
            if not self.names.is_local(v.name.upper()) or v.kind == "external":
                continue
            if v.kind in ("input", "in_out"):
                if v in changed and not is_scalar(v.type):
                    made.append(f"{local} = {self.pool.copier(v.type)}({local})")
            elif not is_scalar(v.type):
                made.append(f"{local} = {self.pool.maker(v.type, v.initial)}()")
            elif local not in self.settled:
                value = default(v.type) if v.initial is None else v.initial
                made.append(f"{local} = {ex.constant(value, v.type).text}")
        return made

    def _result(self) -> str:
        """The return statement of a FUNCTION (its result, then outputs and in_outs); of others, nothing."""
        if self.unit.kind != "FUNCTION":
            return "return"
        given = [f"l_{slot(self.unit.name)}"] if self.unit.result is not None else ["None"]
        given += [f"l_{slot(v.name)}" for v in self.unit.variables if v.kind in ("output", "in_out")]
        for name in given:
            self._use_local(name)
        return f"return {', '.join(given)}"

    def _body(self) -> None:
        code, flat, blocks, others = self.flat.code, self.flat, self.plan.blocks, self.plan.others
        segments = dict(zip(self.plan.segments, range(len(self.plan.segments)), strict=True))
        ends: list[int] = []
        handlers = self._handlers()
        if segments:
            self._emit("pc = 0")
            self._emit("while True:")
            self.indent += 1
        base = self.indent
        for at, instr in enumerate(code):
            while ends and ends[-1] == at:
                self._close(ends)
            if at in segments:
                self._segment(segments[at], base)
            if at in self.plan.loops.ends:
                self._emit("while True:")
                self.indent += 1
                ends.append(self.plan.loops.ends[at] + 1)
            if at in flat.starts or at in flat.labels:
                self._arrive(at)
            if at in flat.labels:
                self.acc = None
            elif at in flat.starts and (instr.op in FORGETS) and not self.stack:
                self.temporaries = 0
            self.at = at
            handlers[instr.op](instr)
            if at in blocks:
                ends.append(blocks[at])
            elif at in others:
                self._close(ends)
                self._emit("else:")
                self._open()
                ends.append(others[at])
        while ends:
            self._close(ends)
        if segments:
            self.indent = base
            self._emit("break")
            self.indent -= 1
        self.at = -1
        if self.stack:
            raise BadCode(f"{self.unit.name}: {len(self.stack)} parentheses are open at the end")
        if self.unit.kind == "FUNCTION":
            self._emit(self._result())
        elif not self.lines:
            self._emit("pass")

    def _arrive(self, at: int) -> None:
        """A rung begins, or something jumps here."""

    def _tick(self, target: int) -> None:
        """The jump in work goes backwards."""
        self._emit("_tick()")

    def _open(self) -> None:
        self.indent += 1
        self._emit("pass")

    def _close(self, ends: list[int]) -> None:
        ends.pop()
        self.indent -= 1

    def _segment(self, number: int, base: int) -> None:
        """Opens the tests ``if pc < n`` that lead to a segment: a tree, so that skipping is logarithmic."""
        count = len(self.plan.segments)
        depths = 1
        while ARITY ** depths < count:
            depths += 1
        for level in range(depths - 1, -1, -1):
            size = ARITY ** level
            if number % size == 0:
                self.indent = base + depths - 1 - level
                self._emit(f"if pc < {min((number // size + 1) * size, count)}:")
                self.indent += 1
        self.indent = base + depths
        self._emit("pass")

    # ---- instructions ----------------------------------------------------------------------------

    def _handlers(self) -> dict[str, Callable[[Instr], None]]:
        table: dict[str, Callable[[Instr], None]] = {
            "LD": self._ld, "LDN": self._ld, "ST": self._st, "STN": self._st,
            "S": self._set, "R": self._set, ")": self._close_parenthesis, "NOT": self._not,
            "LABEL": self._label, "CAL": self._call,
            "CALC": self._call, "CALCN": self._call, "RET": self._return, "RETC": self._return,
            "RETCN": self._return, "FN": self._function_call, "EXT": self._native,
        }
        table |= dict.fromkeys(JUMPS, self._jump)
        operators = ("AND", "OR", "XOR", "ANDN", "ORN", "XORN", "ADD", "SUB", "MUL", "DIV", "MOD",
                     "GT", "GE", "EQ", "NE", "LE", "LT")
        table |= dict.fromkeys(operators, self._operator)
        return table | {f"{op}(": self._open_parenthesis for op in operators}

    def _ld(self, instr: Instr) -> None:
        value = self._load(instr.operand)
        self.acc = ex.invert(value) if instr.op == "LDN" else value

    def _st(self, instr: Instr) -> None:
        value = self._keep()
        self._store(instr.operand, ex.invert(value) if instr.op == "STN" else value)

    def _set(self, instr: Instr) -> None:
        condition = self._keep()
        value = "True" if instr.op == "S" else "False"
        if condition.text == "False":
            return
        self._hazard(self.names.root(instr.operand), instr.operand)
        unconditional = condition.text == "True"
        if not unconditional:
            self._emit(f"if {condition.text}:")
            self.indent += 1
        target, statement = self._target(instr.operand)
        self._emit(statement(value) if statement else f"{target} = {value}")
        if not unconditional:
            self.indent -= 1

    def _not(self, instr: Instr) -> None:
        self.acc = self._small(ex.invert(self._whole(self._accumulator())))

    def _operator(self, instr: Instr) -> None:
        self._combine(instr.op, self._accumulator(), self._load(instr.operand), instr.type)

    def _combine(self, op: str, left: Expression, right: Expression, type_: Type) -> None:
        if op[-1] == "N" and op in ("ANDN", "ORN", "XORN"):
            op, right = op[:-1], ex.invert(self._whole(right))
        if op in ("AND", "OR", "XOR"):
            self.acc = self._small(ex.logic(op, self._whole(left), self._whole(right)))
        elif op in ("GT", "GE", "EQ", "NE", "LE", "LT"):
            self.acc = self._small(ex.compare(op, self._whole(left), self._whole(right)))
        else:
            self.acc = self._small(self._arithmetic(op, left, right, type_))

    def _arithmetic(self, op: str, left: Expression, right: Expression, type_: Type) -> Expression:
        kind = storage(type_)
        if storage(right.type) != kind or storage(left.type) != kind or kind.kind in ("date", "tod", "dt"):
            return self._meaning(op, [left, right], type_)
        if op in ("ADD", "SUB", "MUL"):
            if kind.kind == "real":
                left, right = self._whole(left), self._whole(right)
            made = ex.arithmetic({"ADD": "+", "SUB": "-", "MUL": "*"}[op], left, right, type_)
            return self._rounded(made)
        left, right = self._whole(left), self._whole(right)
        if kind.kind == "real":
            return self._spill(self._rounded(ex.binary(left, "/", right, ex.PRODUCT, type_)))
        if not kind.range[0]:
            sign = "//" if op == "DIV" else "%"
            return self._spill(ex.binary(left, sign, right, ex.PRODUCT, type_))
        name = "_div" if op == "DIV" else "_mod"
        return self._spill(Expression(f"{name}({left.text}, {right.text})", type_, unwrapped=op == "DIV"))

    def _rounded(self, value: Expression) -> Expression:
        if storage(value.type) != REAL:
            return value
        return Expression(f"_f32({value.text})", value.type, ex.ATOM, value.reads, value.depth + 1)

    def _open_parenthesis(self, instr: Instr) -> None:
        self.stack.append((instr.op[:-1], self._accumulator(), instr.type))
        self.acc = None if instr.operand is None else self._load(instr.operand)

    def _close_parenthesis(self, instr: Instr) -> None:
        if not self.stack:
            raise BadCode(f"{self.unit.name}: nothing to close at instruction {self.at}")
        op, left, type_ = self.stack.pop()
        self._combine(op, left, self._accumulator(), type_)

    # ---- control ---------------------------------------------------------------------------------

    def _label(self, instr: Instr) -> None:
        self.acc = None

    def _jump(self, instr: Instr) -> None:
        self._settle_stack()
        condition = "True" if instr.op == "JMP" else self._condition(instr.op == "JMPCN")
        if self.at in self.plan.others:
            return
        if self.at in self.plan.blocks:
            self._emit(f"if {_negated(condition)}:")
            self._open()
            return
        if self.stack:
            raise BadCode(f"{self.unit.name}: a jump out of parentheses at instruction {self.at}")
        if self.at in self.plan.loops.jumps:
            self._loop_jump(condition)
            return
        target = self.flat.targets[self.at]
        if condition != "True":
            self._emit(f"if {condition}:")
            self.indent += 1
        if target <= self.at:
            self._tick(target)
        past = target >= len(self.flat.code)
        segments = self.plan.segments
        self._emit(f"pc = {len(segments) if past else bisect_left(segments, target)}")
        self._emit("continue")
        if condition != "True":
            self.indent -= 1

    def _loop_jump(self, condition: str) -> None:
        """To the begin of the innermost loop or behind its end; the last backward jump is the end itself."""
        target = self.flat.targets[self.at]
        if self.plan.loops.ends.get(target) == self.at:
            if condition != "True":
                self._emit(f"if {_negated(condition)}: break")
            self._tick(target)
        elif target > self.at:
            self._emit(f"if {condition}: break")
        else:
            self._emit(f"if {condition}:")
            self.indent += 1
            self._tick(target)
            self._emit("continue")
            self.indent -= 1

    def _condition(self, negated: bool) -> str:
        kept = self._keep()
        return ex.invert(kept).text if negated else kept.text

    def _return(self, instr: Instr) -> None:
        result = self._result()
        if instr.op == "RET":
            self._emit(result)
            return
        self._emit(f"if {self._condition(instr.op == 'RETCN')}: {result}")

    def _call(self, instr: Instr) -> None:
        place = instr.operand
        if instr.op == "CAL":
            self.acc = None
        self._before_store(None)
        type_ = place.type
        if not isinstance(type_, Instance):
            raise BadCode(f"{self.unit.name}: {place} is no function block")
        if instr.op != "CAL":
            self._emit(f"if {self._condition(instr.op == 'CALCN')}:")
            self.indent += 1
        self._emit(f"{self.pool.block(type_.pou)}({self._load(place).text})")
        if instr.op != "CAL":
            self.indent -= 1

    def _native(self, instr: Instr) -> None:
        self.acc = None
        self._before_store(None)
        self._emit(f"{self.pool.native(self.unit)}(self, {self._whole(self._load(instr.operand)).text})")

    # ---- functions -------------------------------------------------------------------------------

    def _function_call(self, instr: Instr) -> None:
        unit = self.pool.function(instr.name)
        args = [] if self.pool.ignores_accumulator(instr.name) else [self._accumulator()]
        args += [self._load(a) for a in instr.args]
        if unit is None:
            args = [self._whole(a) for a in args]
            if instr.name in SELECTIONS and all(is_integral(a.type) for a in args):
                args = [a if a.is_atom or a.text.lstrip("-").isdigit() else self._spill(a) for a in args]
            made = self.pool.inline(instr.name, args, instr.type)
            if made is not None:
                self.acc = self._small(made)
            elif instr.name in ("ADD", "SUB", "MUL", "DIV", "MOD") and len(args) == 2:
                self._combine(instr.name, args[0], args[1], instr.type)
            else:
                self.acc = self._meaning(instr.name, args, instr.type)
            return
        outputs = [v for v in unit.variables if v.kind in ("output", "in_out")]
        text = f"{self.pool.user(unit)}({', '.join(self._whole(a).text for a in args)})"
        names = [self._fresh() for _ in range(len(outputs) + 1)]
        self.acc = None
        self._before_store(None)
        self._emit(f"{', '.join(names)} = {text}")
        given = {v.name.upper(): Expression(n, v.type) for v, n in zip(outputs, names[1:], strict=True)}
        self.acc = Expression(names[0], instr.type)
        for name, place in instr.outputs:
            self._store(place, given[name.upper()])

    def _meaning(self, op: str, args: list[Expression], type_: Type) -> Expression:
        """A call of the library's meaning, evaluated now: it may fault."""
        args = [self._whole(a) for a in args]
        name = self.pool.meaning(op, tuple(a.type for a in args), type_)
        return self._spill(Expression(f"{name}({', '.join(a.text for a in args)})", type_))


def _negated(condition: str) -> str:
    if condition.startswith("not ") and condition[4:].isidentifier():
        return condition[4:]
    return f"not ({condition})"


