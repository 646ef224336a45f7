"""From what is remembered of a rung to its code, and back (docs/incremental.md)."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping

from ldc.graph.keys import stem
from ldc.il.program import RungCode
from ldc.il.verify import Verdict
from ldc.model import Scope
from ldc.model.elements import Coil
from ldc.model.meaning import meaning, surroundings
from ldc.model.walk import callees
from ldc.parser import ast
from ldc.parser.unread import Head, UnreadPaths
from ldc.patterns import Pattern
from ldc.pipeline.memory import Memory
from ldc.pipeline.results import Options, RungBuild
from ldc.records import record
from ldc.source import Span
from ldc.symbols import Location, Variable

_WORD = Pattern(r"[^\W\d]\w*")


@record
class RungResult:
    """What a rung gives to its body; ``build`` is None when it is wrong."""

    build: RungBuild | None
    coils: tuple[Coil, ...] = ()
    temps: tuple[Variable, ...] = ()
    hidden: tuple[Variable, ...] = ()


class Meanings(dict[str, bytes]):
    """What the words of a body mean, each looked up once."""

    def __init__(self, scope: Scope, locations: Mapping[str, Location]) -> None:
        super().__init__()
        self._scope, self._locations = scope, locations

    def __missing__(self, word: str) -> bytes:
        key = word.upper()
        found = self[word] = meaning(self._scope, key) + str(self._locations.get(key, "")).encode()
        return found


class Recall:
    """The remembered rungs of one body. ``locations``: of variables by name in capitals."""

    def __init__(self, memory: Memory, scope: Scope, locations: Mapping[str, Location], options: Options
                 ) -> None:
        self._memory, self._meanings = memory, Meanings(scope, locations)
        self._around = repr((surroundings(scope), options.verify, options.max_paren_depth)).encode()

    def name(self, rung: ast.Rung, key: str, label: str | None) -> bytes:
        """The digest of all that the code of a rung depends on."""
        text = rung.span.text
        parts = [self._around, repr((text, key, label)).encode("utf-8", "surrogatepass")]
        parts += map(self._meanings.__getitem__, dict.fromkeys(_WORD.findall(text)))
        return hashlib.sha256(b"\0".join(parts)).digest()

    def find(self, name: bytes, rung: ast.Rung, key: str, label: str | None) -> RungResult | None:
        """What was made of such a rung before, at the place of this one."""
        rows = self._memory.rows(name)
        if rows is None:
            return None
        code, proof, operands, temps, hidden, coils = rows
        reader, source, base = self._memory.reader, rung.span.source, rung.span.start
        instrs = tuple([
            reader.instr(row, element, None if start is None else Span(source, base + start, base + end))
            for row, element, start, end in code])
        made = RungCode(key, instrs, label, rung.title, rung.name, proof, rung.span)
        verdict = None if operands is None else Verdict(proof, operands)
        return RungResult(
            RungBuild(rung, made, verdict),
            tuple([Coil(kind, reader.place(place), Span(source, base + start, base + end))
                   for kind, place, start, end in coils]),
            tuple([reader.variable(row) for row in temps]), tuple([reader.variable(row) for row in hidden]))

    def keep(self, name: bytes, rung: ast.Rung, made: RungResult) -> None:
        """Remembers a rung that nothing was told about."""
        build = made.build
        if build is None:
            return
        writer, base, end = self._memory.writer, rung.span.start, rung.span.end
        code = []
        for instr in build.code.code:
            span = instr.span
            if span is not None and (span.source is not rung.span.source or span.start < base or span.end > end):
                return
            place = (None, None) if span is None else (span.start - base, span.end - base)
            code.append([writer.instr(instr), instr.element, *place])
        coils = [[c.kind, writer.place(c.place), c.span.start - base, c.span.end - base] for c in made.coils]
        operands = None if build.verdict is None else build.verdict.operands
        rows = [code, build.code.proof, operands, [writer.variable(v) for v in made.temps],
                [writer.variable(v) for v in made.hidden], coils]
        self._memory.keep(rung.span.text, _head(rung), name, rows)


def _head(rung: ast.Rung) -> Head:
    if isinstance(rung.paths, UnreadPaths):
        return rung.paths.head
    at = 0 if rung.name_span is None else rung.name_span.start - rung.span.start
    calls = frozenset(name.upper() for name, _ in callees(rung))
    return Head(rung.name, rung.title, at, jump_targets(rung), calls, stem(rung))


def jump_targets(rung: ast.Rung) -> tuple[str, ...]:
    """The labels that the elements of a rung jump to."""
    if isinstance(rung.paths, UnreadPaths):
        return rung.paths.head.jumps
    found, todo = [], list(reversed(rung.paths))
    while todo:
        for item in todo.pop().items:
            if isinstance(item, ast.Jump):
                found.append(item.target)
            elif isinstance(item, ast.Branches):
                todo += item.paths
    return tuple(found)
