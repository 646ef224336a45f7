"""An LDmicro project as a file: rungs, subprograms, labels, one task."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import PurePath

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, fragments
from ldc.parser.foreign import Names, Reading
from ldc.parser.ldmicro import instructions as steps
from ldc.parser.ldmicro import peripherals
from ldc.parser.ldmicro.context import Body, Context
from ldc.parser.ldmicro.table import COUNTERS, END_OF_RUNG, HANDLERS, HARMLESS, LEAVING, STAY_SAME, TIMERS
from ldc.parser.ldmicro.text import PARALLEL, Group, Leaf, Text, read_text
from ldc.parser.ldmicro.variables import Variables, limits, number, sections
from ldc.source import SourceFile, Span

_CYCLE = re.compile(r"\d{1,12}")
_BREAK = re.compile(r"(?:\\r|\\n|\r|\n)+")
_FOREIGN_SETTINGS = ("MICRO", "CRYSTAL", "BAUD", "COMPILED", "COMPILER")


def project(source: SourceFile, diagnostics: Diagnostics) -> ast.File:
    """The whole file (codes LD015x)."""
    reading = Reading(source, "LDmicro", diagnostics)
    text = read_text(reading)
    if reading.lost:
        return ast.File(source, (), (), (), (), (), True, tuple(reading.remarks))
    for key in _FOREIGN_SETTINGS:
        if key in text.settings:
            reading.remark(
                "left out", f"{key}={text.settings[key][0]}", "about the chip", text.settings[key][1]
            )
    return _Writer(reading, text).file()


class _Writer:
    def __init__(self, reading: Reading, text: Text) -> None:
        self.reading, self.text = reading, text
        cycle = _CYCLE.match(text.settings.get("CYCLE", ("", None))[0])
        self.cycle = int(cycle[0]) if cycle else 0
        names = Names(reading)
        self.name = names.fresh(PurePath(reading.source.path).stem, pou=True)
        periods = {leaf.span.start: self._period(leaf) for rung in text.rungs for leaf in rung.leaves()
                   if leaf.word in (*TIMERS, "TIME2COUNT") and len(leaf.args) > 1}
        variables = Variables(reading, text, names, limits(text, periods))
        self.context = Context(reading, names, variables, periods, self._resets())
        self.master = any(leaf.word == "MASTER_RELAY" for rung in text.rungs for leaf in rung.leaves())

    def _period(self, leaf: Leaf) -> int | None:
        """Scans of a timer; None when a variable holds them."""
        delay = number(leaf.args[1])
        if delay is None and leaf.word != "TIME2COUNT":
            return None
        if not self.cycle:
            self.reading.unsupported(
                leaf.span, f"{leaf.word} without a cycle time", "set CYCLE: timers count scans"
            )
            return 1
        given = number(leaf.args[2]) if len(leaf.args) > 2 else None
        early = self.text.version == "0.1" and leaf.word in ("TON", "TOF", "RTO")
        adjust = given if given is not None else -1 if early else 0
        scans = ((delay or 0) + self.cycle * adjust) // self.cycle
        if (delay or 0) < self.cycle or scans < 1 or scans >= 1 << 31:
            self.reading.malformed(leaf.span, f"{leaf.word} of {leaf.args[1]} us lasts {max(scans, 0)} scans",
                                   help="a timer lasts a scan at least: see CYCLE and the delay")
            return 1
        return scans

    def _resets(self) -> dict[str, str]:
        found: dict[str, str] = {}
        for word in reversed(COUNTERS):
            for rung in self.text.rungs:
                for leaf in rung.leaves():
                    if leaf.word == word and leaf.args:
                        found[leaf.args[0]] = leaf.args[2] if len(leaf.args) > 2 else "0"
        return found

    # ---- the file

    def file(self) -> ast.File:
        bodies = self._bodies()
        blocks = []
        for name, rungs, span in bodies[1:]:
            self.context.subprograms[name] = self.context.names.name(name, span, f"SUBPROG {name}", pou=True)
        written = [self._body(rungs, not index) for index, (_, rungs, _) in enumerate(bodies)]
        context, shared = self.context, len(bodies) > 1
        for (label, _, span), (rungs, body, _) in zip(bodies[1:], written[1:], strict=True):
            blocks.append(self._subprogram(context.subprograms[label], body, rungs, span))
        rungs, body, title = written[0]
        rungs = (*self._beginning(body), *rungs)
        everything = list(context.variables.found.values())
        declared = (
            [*_externals(body.used.values(), self.text.head)] if shared else [*sections("VAR", everything)]
        )
        declared += _instances(body, self.text.head)
        span = Span(self.reading.source, self.text.head.start, len(self.reading.source.text))
        main = ast.Pou("PROGRAM", self.name, title, None, tuple(declared), ast.LadderBody(rungs, span), span,
                       self.text.head)
        globals_ = sections("VAR_GLOBAL", everything) if shared else ()
        return ast.File(self.reading.source, (*context.blocks.values(), *blocks, main), (), globals_,
                        self._configuration(), (), self.reading.lost, tuple(self.reading.remarks))

    def _configuration(self) -> tuple[ast.Configuration, ...]:
        if not self.cycle:
            return ()
        span = self.text.settings["CYCLE"][1]
        return (
            fragments.configuration(self.context.names.fresh("plc"), self.name, f"T#{self.cycle}us", span),
        )

    def _beginning(self, body: Body) -> Iterator[ast.Rung]:
        """What holds at the beginning of each scan: the master relay is on, nothing was sent."""
        head = self.text.head
        for name, element in ((steps.MASTER, "[TRUE] ({})"), (peripherals.SENT, "[TRUE] (R {})")):
            variable = self.context.variables.found.get(f"+{name}")
            if variable is not None:
                body.used[variable.name] = variable
                items = fragments.items(element.format(variable.name), head)
                yield ast.Rung(None, None, (fragments.path(items, head),), head)

    def _subprogram(self, name: str, body: Body, rungs: tuple[ast.Rung, ...], span: Span) -> ast.Pou:
        run = fragments.variable("RUN", "BOOL", span)
        done = fragments.variable("DONE", "BOOL", span)
        declared = (
            ast.VarBlock("VAR_INPUT", (), (run,), span),
            ast.VarBlock("VAR_OUTPUT", (), (done,), span),
            *_externals(body.used.values(), span),
            *_instances(body, span),
        )
        first = (fragments.path(fragments.items("[RUN] (DONE)", span), span),
                 fragments.path(fragments.items("[/RUN] >>RETURN", span), span))
        return ast.Pou("FUNCTION_BLOCK", name, None, None, declared,
                       ast.LadderBody((ast.Rung(None, None, first, span), *rungs), span), span, span)

    def _bodies(self) -> list[tuple[str, list[tuple[int, Group]], Span]]:
        """The rungs of the program and of each subprogram, with their numbers; the program first."""
        bodies = [("", [], self.text.head)]
        at = 0
        for index, rung in enumerate(self.text.rungs):
            only = rung.parts[0] if len(rung.parts) == 1 else None
            word = only.word if isinstance(only, Leaf) else ""
            if word == "SUBPROG" and only.args and not at:
                if any(only.args[0] == body[0] for body in bodies):
                    self.reading.malformed(rung.span, f"there are two SUBPROG `{only.args[0][:40]}`")
                bodies.append((only.args[0], [], only.span))
                at = len(bodies) - 1
            elif word == "ENDSUB" and at:
                at = 0
            else:
                bodies[at][1].append((index + 1, rung))
        if at:
            self.reading.malformed(bodies[at][2], f"SUBPROG `{bodies[at][0][:40]}` has no ENDSUB")
        return bodies

    # ---- rungs

    def _body(
        self, rungs: list[tuple[int, Group]], main: bool
    ) -> tuple[tuple[ast.Rung, ...], Body, str | None]:
        """The rungs of a POU; comments stand over the rung behind them, the last ones over the POU."""
        self.context.body = Body()
        labels = self._labels(rungs)
        self.context.labels = labels
        named = set(labels.values())
        written: list[ast.Rung] = []
        comments: list[str] = []
        for index, (_, rung) in enumerate(rungs):
            if _is_comment(rung):
                comments.append(_comment(rung.parts[0]))
            items = () if _is_comment(rung) else self._rung(rung)
            name = f"rung_{index}" if f"rung_{index}" in named else None
            if name and not items:  # a place to jump to, where nothing is done
                items = fragments.items("[FALSE] >>RETURN", rung.span)
            if not items:
                continue
            title = " / ".join(filter(None, comments)) or None
            comments = []
            written.append(ast.Rung(name, title, (fragments.path(items, rung.span),), rung.span,
                                    rung.span if name else None))
        return (
            tuple(written),
            self.context.body,
            (" / ".join(filter(None, comments)) or None) if main else None,
        )

    def _labels(self, rungs: list[tuple[int, Group]]) -> dict[str, str]:
        """The name of the rung that each label, and each number that is jumped to, stands for: the first
        one there that does something; RETURN behind the last."""
        found: dict[str, str] = {}
        jumps = {
            leaf.args[0] for _, rung in rungs for leaf in rung.leaves() if leaf.word == "GOTO" and leaf.args
        }
        follows = "RETURN"
        last = len(self.text.rungs) + 1
        numbered: dict[int, list[str]] = {}
        for target in jumps:
            if (value := number(target)) is not None:
                numbered.setdefault(min(max(value, 1), last), []).append(target)
        found |= dict.fromkeys(numbered.get(last, ()), "RETURN")
        for index in range(len(rungs) - 1, -1, -1):
            position, rung = rungs[index]
            if not _is_comment(rung) and any(leaf.word not in ("LABEL", "COMMENT") for leaf in rung.leaves()):
                follows = f"rung_{index}"
            for leaf in rung.leaves():
                if leaf.word == "LABEL" and leaf.args:
                    found[leaf.args[0]] = follows
            found |= dict.fromkeys(numbered.get(position, ()), follows)
        return found

    def _rung(self, rung: Group) -> tuple[ast.Item, ...]:
        leaves = list(rung.leaves())
        self.context.first = leaves[0].span.start if leaves else -1
        leaving = next((n for n, leaf in enumerate(leaves) if leaf.word in LEAVING), len(leaves))
        for leaf in leaves[leaving + 1 :]:
            if leaf.word not in HARMLESS:
                self.reading.unsupported(leaf.span, f"{leaf.word} behind a jump in the same rung",
                                         "put what follows a GOTO or RETURN into a rung of its own")
        items = self._acting(self._series(rung))
        if self.master and items:
            name = self.context.added(steps.MASTER, "BOOL", leaves[0],
                                      "the power of all rungs between two master relays")
            items = [*fragments.items(f"[{name}]", rung.span), *items]
        return tuple(items)

    def _acting(self, items: list[ast.Item]) -> list[ast.Item]:
        """Without the contacts at the end, whose power nobody reads."""
        kept = list(items)
        while kept:
            last = kept[-1]
            if isinstance(last, ast.Branches):
                paths = [fragments.path(found, path.span) for path in last.paths
                         if (found := self._acting(list(path.items)))]
                if paths:
                    kept[-1:] = paths[0].items if len(paths) == 1 else [ast.Branches(tuple(paths), last.span)]
                    break
            elif not isinstance(last, ast.Contact):
                break
            elif not isinstance(last.expr, ast.Literal) and not self.reading.lost:
                self.reading.left_out(
                    last.span, last.span.text.split("\n")[0][:60], "its power leads nowhere"
                )
            kept.pop()
        return kept

    def _series(self, group: Group) -> list[ast.Item]:
        items: list[ast.Item] = []
        for part in group.parts:
            items += self._part(part)
        return items

    def _part(self, part: Leaf | Group) -> list[ast.Item]:
        if isinstance(part, Leaf):
            return self._leaf(part)
        return self._parallel(part) if part.kind == PARALLEL else self._series(part)

    def _parallel(self, group: Group) -> list[ast.Item]:
        """Branches. One that only computes adds no power beside others; behind a branch that ends the rung,
        power is what it was before."""
        ends = any(_words(part) & END_OF_RUNG for part in group.parts)
        paths = []
        for part in group.parts:
            items = self._part(part)
            if not ends and _words(part) <= STAY_SAME and len(group.parts) > 1:
                items += fragments.items("[FALSE]", part.span)
            paths.append(fragments.path(items or fragments.items("[TRUE]", part.span), part.span))
        if ends:
            paths.append(fragments.path(fragments.items("[TRUE]", group.span), group.span))
        return [ast.Branches(tuple(paths), group.span)] if paths else []

    def _leaf(self, leaf: Leaf) -> list[ast.Item]:
        count, handler = HANDLERS.get(leaf.word, (0, None))
        if handler is None:
            known = leaf.word in ("PLACEHOLDER", "SUBPROG", "ENDSUB")
            if known:
                self.reading.malformed(leaf.span, f"{leaf.word} stands where it has no meaning")
            else:
                self.reading.unsupported(leaf.span, f"the instruction {leaf.word[:40]}",
                                         "docs/import-ldmicro.md lists what is read")
            return []
        if len(leaf.args) < count:
            self.reading.malformed(leaf.span, f"{leaf.word} has {len(leaf.args)} of {count} operands")
            return []
        lost, self.reading.lost = self.reading.lost, False
        text = handler(self.context, leaf)
        broken, self.reading.lost = self.reading.lost, lost or self.reading.lost
        return list(fragments.items(text, leaf.span)) if text and not broken else []


def _words(part: Leaf | Group) -> set[str]:
    return {part.word} if isinstance(part, Leaf) else {leaf.word for leaf in part.leaves()}


def _is_comment(rung: Group) -> bool:
    """A rung that begins with a comment is one."""
    return bool(rung.parts) and isinstance(rung.parts[0], Leaf) and rung.parts[0].word == "COMMENT"


def _comment(leaf: Leaf) -> str:
    return _BREAK.sub(" ", leaf.rest).strip()


def _externals(used, span: Span) -> tuple[ast.VarBlock, ...]:
    declared = tuple(fragments.variable(v.name, v.type, v.span) for v in used)
    return (ast.VarBlock("VAR_EXTERNAL", (), declared, span),) if declared else ()


def _instances(body: Body, span: Span) -> tuple[ast.VarBlock, ...]:
    declared = tuple(fragments.variable(name, type_, at) for name, (type_, at) in body.instances.items())
    return (ast.VarBlock("VAR", (), declared, span),) if declared else ()
