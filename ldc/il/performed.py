"""Actions put in where they are called: ``ACT`` becomes the code of the action (docs/st.md).

An action has the variables of its POU, so its code is that of the POU, with labels and temporaries of its
own. RETURN in it leads behind it. A function block gets its actions once more at its beginning, each executed
instead of the body when the input that chooses one says so.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence

from ldc.diagnostics import Diagnostics
from ldc.expr import Const, Place
from ldc.free_names import claimed
from ldc.il.program import Instr, RungCode, Unit
from ldc.il.rename import renamed
from ldc.model import call_findings as findings
from ldc.records import record, replace
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import INT

MOST = 200_000
"""Instructions of a POU with its actions put in: where each calls another twice they grow by powers of
two."""

_RETURNS = {"RET": "JMP", "RETC": "JMPC", "RETCN": "JMPCN"}
_NAMED = frozenset(("JMP", "JMPC", "JMPCN", "LABEL"))


@record
class Action:
    """What was made of its body. ``name`` as declared."""

    name: str
    codes: tuple[RungCode, ...]
    temps: tuple[Variable, ...]
    span: Span


def performed(unit: Unit, actions: Sequence[Action], selector: str | None, diagnostics: Diagnostics) -> Unit:
    """The unit without ``ACT``. ``selector``: the input that tells a function block which action is meant."""
    work = _Performed(actions, (code.key for code in unit.rungs), diagnostics)
    rungs = tuple(work.expanded(unit.rungs))
    if selector is not None:
        rungs = (*work.chosen(selector), *rungs)
    return replace(unit, rungs=rungs, variables=(*unit.variables, *work.temps.values()))


class _Performed:
    """``temps``: temporaries of actions that were put in. Each action has its own, since it may be called
    while others keep values; it is never called while it is executed itself."""

    def __init__(self, actions: Sequence[Action], keys: Iterable[str], diagnostics: Diagnostics) -> None:
        self.actions = {action.name.upper(): action for action in actions}
        self.numbers = {name: number for number, name in enumerate(self.actions, 1)}
        self.diagnostics = diagnostics
        self.temps: dict[str, Variable] = {}
        self._codes: dict[str, tuple[RungCode, ...]] = {}
        self._open: list[str] = []
        self._keys = {key.upper() for key in keys}
        self._copies = self._ends = self._size = 0
        self._told = False

    def expanded(self, codes: Iterable[RungCode]) -> Iterator[RungCode]:
        """The code with actions put in: between rungs where nothing stands around a call, else inside."""
        label: str | None = None
        for code in codes:
            if label is not None and code.label is not None:
                yield RungCode(self._key(label), (), label)
            elif label is not None:
                code = replace(code, label=label)
            label = None
            if len(code.code) == 1 and code.code[0].op == "ACT":
                label = self._end()
                yield replace(code, code=())
                for inner in self._copy(code.code[0], label):
                    yield replace(inner, key=self._key(inner.key))
            elif any(instr.op == "ACT" for instr in code.code):
                yield replace(code, code=tuple(self._inside(code.code)))
            else:
                yield code
        if label is not None:
            yield RungCode(self._key(label), (Instr("RET"),), label)

    def chosen(self, selector: str) -> Iterator[RungCode]:
        """Each action, executed instead of the body when the selector has its number."""
        label: str | None = None
        for name, action in self.actions.items():
            number, following = self.numbers[name], self._end()
            test = (Instr("LD", Place(selector, INT), INT), Instr("EQ", Const(number, INT), INT),
                    Instr("JMPCN", name=following))
            yield RungCode(self._key(f"_ldc_action_{number}"), test, label, span=action.span)
            done = self._end()
            for inner in self._copy(Instr("ACT", name=name, span=action.span), done):
                yield replace(inner, key=self._key(inner.key))
            yield RungCode(self._key(done), (Instr("RET"),), done)
            label = following
        yield RungCode(self._key(label), (), label)

    def _inside(self, code: Iterable[Instr]) -> Iterator[Instr]:
        for instr in code:
            if instr.op != "ACT":
                yield instr
                continue
            end = self._end()
            for inner in self._copy(instr, end):
                if inner.label is not None:
                    yield Instr("LABEL", name=inner.label, span=inner.span)
                yield from (replace(one, element=-1) for one in inner.code)
            yield Instr("LABEL", name=end, span=instr.span)

    # ---- one action

    def _copy(self, call: Instr, end: str) -> Iterator[RungCode]:
        """The code of an action once more, with labels that no other copy has; RETURN leads to ``end``."""
        codes = () if self._told else self._code(call)
        self._copies += 1
        labels = {name.upper(): f"_ldc_c{self._copies}_{number}"
                  for number, name in enumerate(_labels(codes), 1)}

        def own(instr: Instr) -> Instr:
            if instr.op in _RETURNS:
                return replace(instr, op=_RETURNS[instr.op], name=end)
            return replace(instr, name=labels[instr.name.upper()]) if instr.op in _NAMED else instr

        for code in codes:
            self._size += len(code.code)
            if self._size > MOST:
                if not self._told:
                    findings.actions_too_large(self.diagnostics, call.span, MOST)
                self._told = True
                return
            label = None if code.label is None else labels[code.label.upper()]
            yield replace(code, code=tuple(map(own, code.code)), label=label)

    def _code(self, call: Instr) -> tuple[RungCode, ...]:
        """The code of an action, with those that it calls put in and with its own temporaries."""
        name = call.name.upper()
        if name in self._open:
            cycle = [*self._open[self._open.index(name):], name]
            findings.action_calls_itself(self.diagnostics, call.span, [self.actions[n].name for n in cycle])
            return ()
        known = self._codes.get(name)
        if known is None:
            self._open.append(name)
            action = self.actions[name]
            names = {t.name.upper(): f"_ldc_a{self.numbers[name]}{t.name.removeprefix('_ldc')}"
                     for t in action.temps}
            self.temps.update((new, replace(t, name=new)) for t in action.temps
                              for new in (names[t.name.upper()],))
            made = action.codes if not names else _with_names(action.codes, names)
            known = self._codes[name] = tuple(self.expanded(made))
            self._open.pop()
        return known

    # ---- names

    def _key(self, wanted: str) -> str:
        """A key that no rung has."""
        return claimed(wanted, self._keys)

    def _end(self) -> str:
        self._ends += 1
        return f"_ldc_done_{self._ends}"


def _labels(codes: Sequence[RungCode]) -> list[str]:
    return [code.label for code in codes if code.label] + [
        i.name for code in codes for i in code.code if i.op == "LABEL"]


def _with_names(codes: Sequence[RungCode], names: Mapping[str, str]) -> tuple[RungCode, ...]:
    def name_of(place: Place) -> str:
        return place.root if place.is_global else names.get(place.root.upper(), place.root)

    return tuple(replace(code, code=tuple(renamed(i, name_of) for i in code.code)) for code in codes)
