"""A whole file: cut into units at the keywords, each parsed alone.

Keywords are reserved, so RUNG, VAR and the like are found without knowing what stands between them. One
bad rung or declaration gives its findings and is left out; the rest is read. Cost is linear.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.parser import ast, charts, sfc, statements
from ldc.parser.beyond import take_out
from ldc.parser.findings import TooMany, cut
from ldc.parser.lexer import BAD, QUALIFIERS, SECTIONS, Tokens, lex
from ldc.parser.listing import is_list
from ldc.parser.structured import read_body
from ldc.parser.units import Units
from ldc.parser.unread import Heads
from ldc.records import replace
from ldc.similar import similar
from ldc.source import SourceFile, Span

POUS = ("PROGRAM", "FUNCTION", "FUNCTION_BLOCK")
_SHARED = ("VAR_GLOBAL", "VAR_CONFIG")
_STARTERS = frozenset((*POUS, "TYPE", "CONFIGURATION", *_SHARED))
_ENDS = frozenset(f"END_{kind}" for kind in (*POUS, "TYPE", "CONFIGURATION", "RESOURCE", "VAR"))
_STOPS = _STARTERS | _ENDS | {*SECTIONS, "RUNG", "RESOURCE", "TASK", "ACTION"}
_SECTIONS = frozenset(SECTIONS)
_LANGUAGES = {".st": "ST", ".il": "IL"}


def parse_file(source: SourceFile, diagnostics: Diagnostics, heads: Heads | None = None) -> ast.File:
    """What a source says; what cannot be read is left out and told (codes LD01xx). ``heads``: of rungs that
    were read before, which are not read again.

    The ending of the path decides about bodies: ``.st`` and ``.il`` hold text, any other ladders. A body in a
    ``.st`` file that begins as a list is one.
    """
    tokens = lex(source)
    reader = Reader(tokens, diagnostics, heads)
    try:
        reader.read()
    except TooMany:
        reader.units.lost = True
    comments = tuple(ast.Comment(source.text[a:b], Span(source, a, b)) for a, b in tokens.comments)
    return ast.File(source, tuple(reader.pous), tuple(reader.type_decls), tuple(reader.globals),
                    tuple(reader.configurations), comments, reader.units.lost or reader.lost_label())


def parse_expression(source: SourceFile, start: int, end: int, diagnostics: Diagnostics) -> ast.Expr | None:
    """The expression that the characters ``start`` to ``end`` of a source are."""
    tokens = lex(source, start, end)
    return Units(tokens, diagnostics).parse("single_expression", 0, len(tokens.types), "expression")


def parse_type(source: SourceFile, start: int, end: int, diagnostics: Diagnostics) -> ast.TypeExpr | None:
    """The type that the characters ``start`` to ``end`` of a source name: ``REAL``, ``ARRAY [0..9] OF
    INT``."""
    tokens = lex(source, start, end)
    return Units(tokens, diagnostics).parse("single_type", 0, len(tokens.types), "type")


def parse_sections(tokens: Tokens, diagnostics: Diagnostics) -> tuple[ast.VarBlock, ...]:
    """The sections `VAR ... END_VAR` among the tokens; what stands between them is not looked at."""
    return Reader(tokens, diagnostics).sections()


class Reader:
    """Goes through the tokens once; ``at`` is the next one."""

    def __init__(self, tokens: Tokens, diagnostics: Diagnostics, heads: Heads | None = None) -> None:
        self.tokens, self.types = tokens, tokens.types
        self.heads = heads
        self.units = Units(tokens, diagnostics)
        self.findings = self.units.findings
        path = tokens.source.path.lower()
        self.language = next((name for ending, name in _LANGUAGES.items() if path.endswith(ending)), None)
        self.at = 0
        self.pous: list[ast.Pou] = []
        self.type_decls: list[ast.TypeDecl] = []
        self.globals: list[ast.VarBlock] = []
        self.configurations: list[ast.Configuration] = []
        self.lost_rungs: set[str] = set()

    def lost_label(self) -> bool:
        """Whether a jump leads to a rung that was left out."""
        targets = (i + 1 for i, kind in enumerate(self.types) if kind == ">>" and i + 1 < len(self.types))
        return bool(self.lost_rungs) and any(self.tokens.text(i).upper() in self.lost_rungs for i in targets)

    def read(self) -> None:
        types = self.types
        self.findings.readable()
        self.units.lost |= take_out(self.tokens, self.findings)
        if not types:
            self.findings.empty_file()
        while self.at < len(types):
            kind = types[self.at]
            if kind in POUS:
                self._pou()
            elif kind == "TYPE":
                self.type_decls += self._lines_until("END_TYPE", "type_line", "TYPE")
            elif kind in _SHARED:
                self.globals.append(self._section())
            elif kind == "CONFIGURATION":
                self._configuration()
            elif kind == "ACTION" and self.pous and not self.pous[-1].actions:
                self._late_actions()
            else:
                self._outside()

    def sections(self) -> tuple[ast.VarBlock, ...]:
        found = []
        self._seek(_SECTIONS)
        while self.at < len(self.types):
            found.append(self._section())
            self._seek(_SECTIONS)
        return tuple(found)

    # ---- helpers

    def _kind(self) -> str:
        """The type of the next token; ``""`` at the end."""
        return self.types[self.at] if self.at < len(self.types) else ""

    def _skip(self, stops: frozenset[str]) -> int:
        """Go on to the next token of ``stops``, at least one; where it began."""
        self.findings.enough(self.at)
        begin, self.at = self.at, self.at + 1
        self._seek(stops)
        return begin

    def _seek(self, stops: frozenset[str]) -> None:
        types, at = self.types, self.at
        while at < len(types) and types[at] not in stops:
            at += 1
        self.at = at

    def _found(self) -> str:
        return self.findings.shown(self.at) if self.at < len(self.types) else "the end of the file"

    def _outside(self) -> None:
        begin = self._skip(_STARTERS)
        if self.units.bad(begin, self.at):
            return
        word = cut(self.tokens.text(begin)).upper()
        near = similar(word, sorted(_STARTERS), 1, 0.75)
        if near and self.types[begin] == "NAME":
            help = f"did you mean `{near[0]}`?"
        elif self.pous:
            help = "remove it, or move it above the END of the program that it belongs to"
        else:
            help = "write `PROGRAM name` before it and END_PROGRAM at the end"
        self.findings.outside(begin, help)

    def _misspelt(self, end: str, first: int) -> bool:
        """Whether the last word before ``at`` was meant as ``end``; reports it."""
        last = self.at - 1
        if last <= first or self.types[last] != "NAME":
            return False
        word = cut(self.tokens.text(last)).upper()
        if not similar(word, [end], 1, 0.75):
            return False
        self.findings.wrong_end(last, end, first)
        return True

    def _missing(self, end: str, opening: int) -> None:
        """Report it, unless an open comment has swallowed it (that is told where it is)."""
        if self.at < len(self.types) or self.types[-1] != BAD or not (
                self.tokens.text(-1).startswith(("(*", "/*"))):
            self.findings.missing_end(end, opening, self.at, self._found())

    # ---- declarations

    def _section(self) -> ast.VarBlock:
        """``VAR ... END_VAR``; ``at`` is its first word."""
        first, kind = self.at, self._kind()
        while self._qualifier(self.at + 1):
            self.at += 1
        qualifiers = tuple(self.tokens.text(at).upper() for at in range(first + 1, self.at + 1))
        symbol = "config_line" if kind == "VAR_CONFIG" else "var_line"
        groups = self._lines_until("END_VAR", symbol, kind, first)
        variables = tuple(variable for group in groups for variable in group)
        return ast.VarBlock(kind, qualifiers, variables, self.tokens.span(first, self.at - 1))

    def _qualifier(self, at: int) -> bool:
        """Whether a token qualifies the section. PERSISTENT is no keyword: it stands before a name or
        END_VAR."""
        kinds = self.types[at : at + 2]
        if kinds[:1] != ["NAME"]:
            return bool(kinds) and kinds[0] in QUALIFIERS
        follows = kinds[1:] and (kinds[1] in ("NAME", "END_VAR") or kinds[1] in QUALIFIERS)
        return bool(follows) and self.tokens.text(at).upper() == "PERSISTENT"

    def _lines_until(self, end: str, symbol: str, word: str, opening: int | None = None) -> list:
        """The lines between the word at ``at`` and ``end``, which is taken too."""
        opening = self.at if opening is None else opening
        first = self.at + 1
        self._skip(_STOPS)
        stop, found = self.at, self._kind() == end
        if not found and self._misspelt(end, opening):
            stop, found = self.at - 1, True
        elif found:
            self.at += 1
        values = list(self.units.lines(symbol, first, stop))
        if not found:
            self._missing(end, opening)
        return values

    # ---- program organisation units

    def _pou(self) -> None:
        first = self.at
        kind = self._kind()
        self.at = self._head_end()
        head = self.units.parse("pou_head", first, self.at, "heading")
        if head is None:
            self._seek(_STOPS)
        sections: list[ast.VarBlock] = []
        while self._kind() in SECTIONS:
            sections.append(self._section())
        actions: tuple[sfc.Action, ...] = ()
        if self._is_chart():
            body = self._chart()
        else:
            if self.language is None:
                body = self._ladder(sections, kind, first)
            elif self.language == "IL" or is_list(self.tokens, self.at, len(self.types)):
                body = self._text_body()
            else:
                body = self._statements(f"END_{kind}")
            actions = self._actions()
        last = self._pou_end(f"END_{kind}", first)
        if head is not None:
            self.pous.append(ast.Pou(kind, head.name, head.title, head.result, tuple(sections), body,
                                     self.tokens.span(first, last), head.name_span, actions))

    def _is_chart(self) -> bool:
        """Actions alone are those of a POU without a body."""
        if self.language == "IL" or self._kind() not in charts.STARTS:
            return False
        if self._kind() != "ACTION":
            return True
        first = self.at
        self._seek(_POU_STOPS | _CHART_PARTS)
        found, self.at = self._kind() in _CHART_PARTS, first
        return found

    def _actions(self) -> tuple[sfc.Action, ...]:
        """The actions behind a body."""
        first = self.at
        if self._kind() != "ACTION":
            return ()
        self._seek(_POU_STOPS)
        actions, lost = charts.read_actions(self.units, first, self.at, self.language)
        self.lost_rungs |= lost
        return actions

    def _late_actions(self) -> None:
        """Actions behind the END of their POU, where some editors write them."""
        pou, actions = self.pous[-1], self._actions()
        span = pou.span.to(actions[-1].span) if actions else pou.span
        self.pous[-1] = replace(pou, actions=actions, span=span)

    def _head_end(self) -> int:
        """Behind ``PROGRAM name "title"`` or ``FUNCTION name : TYPE "title"``, as far as it goes."""
        types, at = self.types, self.at + 1
        if types[at : at + 1] == ["NAME"]:
            at += 1
        if self._kind() == "FUNCTION" and types[at : at + 1] == [":"]:
            at += 1
            while types[at : at + 1] == ["ARRAY"]:
                while at < len(types) and types[at] not in _STOPS and types[at] != "OF":
                    at += 1
                at += types[at : at + 1] == ["OF"]
            at += types[at : at + 1] == ["NAME"]
            if types[at : at + 1] in (["["], ["("]):
                closer = {"[": "]", "(": ")"}[types[at]]
                while at < len(types) and types[at] not in _STOPS and types[at] != closer:
                    at += 1
                at += types[at : at + 1] == [closer]
        return at + (types[at : at + 1] == ["TEXT"])

    def _text_body(self) -> ast.TextBody:
        start = self.tokens.ends[self.at - 1]
        self._seek(_BODY_STOPS)
        end = self.tokens.starts[self.at] if self.at < len(self.types) else len(self.tokens.source.text)
        return ast.TextBody("IL", Span(self.tokens.source, start, end))

    def _chart(self) -> sfc.SfcBody:
        first, start = self.at, self.tokens.ends[self.at - 1]
        self._seek(_POU_STOPS)
        to = self.tokens.starts[self.at] if self.at < len(self.types) else len(self.tokens.source.text)
        span = Span(self.tokens.source, start, to)
        chart, lost = charts.read_chart(self.units, first, self.at, span, self.language is None)
        self.lost_rungs |= lost
        return chart

    def _statements(self, end: str) -> statements.StatementBody:
        first, start = self.at, self.tokens.ends[self.at - 1]
        self._seek(_BODY_STOPS)
        stop = self.at
        if self._kind() != end and stop > first and self.types[stop - 1] == "NAME":
            if similar(cut(self.tokens.text(stop - 1)).upper(), [end], 1, 0.75):
                stop -= 1  # a misspelt END; _pou_end reports it
        to = self.tokens.starts[stop] if stop < len(self.types) else len(self.tokens.source.text)
        return read_body(self.units, first, stop, Span(self.tokens.source, start, to))

    def _ladder(self, sections: list[ast.VarBlock], kind: str, opening: int) -> ast.LadderBody:
        rungs: list[ast.Rung] = []
        start = self.tokens.ends[self.at - 1]
        while (word := self._kind()) and word not in _BODY_STOPS:
            if word == "RUNG":
                rung = self._rung(f"END_{kind}", opening)
                if rung is not None:
                    rungs.append(rung)
            elif word in SECTIONS:
                self.findings.late_declarations(self.at)
                sections.append(self._section())
            else:
                self._no_rung(f"END_{kind}")
        end = self.tokens.starts[self.at] if self.at < len(self.types) else self.tokens.ends[-1]
        return ast.LadderBody(tuple(rungs), Span(self.tokens.source, start, max(start, end)))

    def _rung(self, end: str, opening: int) -> ast.Rung | None:
        first = self._skip(_STOPS)
        stop = self.at
        if self._kind() != end and self.types[stop - 1] == "NAME" and self.types[stop - 2] != ">>":
            if similar(cut(self.tokens.text(stop - 1)).upper(), [end], 1, 0.75):
                self.at = stop = stop - 1  # a misspelt END; _pou_end reports it
        if self.heads is not None:
            span = self.tokens.span(first, stop - 1)
            head = self.heads(span.text)
            if head is not None:
                return head.rung(span)
        rung = self.units.parse("rung", first, stop, "rung")
        if rung is None and self.types[first + 1 : first + 2] == ["NAME"]:
            self.lost_rungs.add(self.tokens.text(first + 1).upper())
        return rung

    def _no_rung(self, end: str) -> None:
        """Something between declarations and rungs that is neither, or a stray END."""
        if self.types[self.at] == "NAME" and similar(
                cut(self.tokens.text(self.at)).upper(), [end], 1, 0.75):
            self.at += 1
            return
        begin = self._skip(_STOPS)
        if self.units.bad(begin, self.at):
            return
        word = cut(self.tokens.text(begin)).upper()
        near = similar(word, (*SECTIONS, "RUNG", end), 1, 0.7)
        if self.types[begin] == "{":
            self.findings.pragma(begin)
            return
        if near and near[0] in SECTIONS:
            self.units.lost = True
            self.at += self._kind() == "END_VAR"
        help = "a rung begins with RUNG; statements belong into a .st file"
        self.findings.unexpected(begin, f"RUNG or {end}", f"did you mean `{near[0]}`?" if near else help)

    def _pou_end(self, end: str, opening: int) -> int:
        """Take the END of a POU; the index of its last token."""
        if self._kind() == end:
            self.at += 1
        elif self._kind() in _POU_ENDS or self._kind() == "NAME":
            self.findings.wrong_end(self.at, end, opening)
            self.at += 1
            self.at += self._kind() == end
        elif not self._misspelt(end, opening):
            self._missing(end, opening)
        return self.at - 1

    # ---- configurations

    def _configuration(self) -> None:
        first = self.at
        self.at = min(first + 2, len(self.types))
        name = self.units.parse("configuration_head", first, self.at, "heading")
        blocks, resources, tasks, programs = [], [], [], []
        while (word := self._kind()) and word != "END_CONFIGURATION" and word not in _CONFIGURATION_STOPS:
            if word in _SHARED:
                blocks.append(self._section())
            elif word == "RESOURCE":
                if tasks or programs:
                    self.findings.unexpected(self.at, "TASK, PROGRAM or END_CONFIGURATION", _IN_RESOURCES)
                resources.append(self._resource())
            elif not resources and (word == "TASK" or word == "PROGRAM" and self._is_instance()):
                self._instance_line(tasks, programs)
            else:
                self._expected("RESOURCE or END_CONFIGURATION", _IN_CONFIGURATION, _IN_RESOURCES)
        self._close("END_CONFIGURATION", first)
        if tasks or programs:
            span = self.tokens.span(first, self.at - 1)
            resources.append(ast.Resource("", "master", (), tuple(tasks), tuple(programs), span))
        if name is not None:
            self.configurations.append(ast.Configuration(
                name, tuple(blocks), tuple(r for r in resources if r), self.tokens.span(first, self.at - 1)))

    def _resource(self) -> ast.Resource | None:
        first = self.at
        self.at = min(first + 4, len(self.types))
        head = self.units.parse("resource_head", first, self.at, "heading")
        blocks, tasks, programs = [], [], []
        while (word := self._kind()) and word not in ("END_RESOURCE", "END_CONFIGURATION", "RESOURCE"):
            if word == "VAR_GLOBAL":
                blocks.append(self._section())
            elif word in ("TASK", "PROGRAM"):
                self._instance_line(tasks, programs)
            else:
                self._expected("TASK, PROGRAM or END_RESOURCE", _IN_RESOURCE, "")
        self._close("END_RESOURCE", first)
        if head is None:
            return None
        return ast.Resource(*head, tuple(blocks), tuple(tasks), tuple(programs),
                            self.tokens.span(first, self.at - 1))

    def _is_instance(self) -> bool:
        """Whether PROGRAM begins an instance, and no POU behind a CONFIGURATION without an end."""
        return self.types[self.at + 1 : self.at + 3] in (["NAME", ":"], ["NAME", "WITH"])

    def _instance_line(self, tasks: list[ast.Task], programs: list[ast.ProgramInstance]) -> None:
        """``TASK ...;`` or ``PROGRAM name : pou;``."""
        word = self._kind()
        begin = self._skip(_LINE_STOPS)
        self.at += self._kind() == ";"
        symbol = "task_line" if word == "TASK" else "program_line"
        value = self.units.parse(symbol, begin, self.at, "declaration")
        if value is not None:
            (tasks if word == "TASK" else programs).append(value)

    def _expected(self, wanted: str, stops: frozenset[str], help: str) -> None:
        begin = self._skip(stops)
        if not self.units.bad(begin, self.at):
            self.findings.unexpected(begin, wanted, help or f"write {wanted} here")

    def _close(self, end: str, opening: int) -> None:
        if self._kind() == end:
            self.at += 1
        else:
            self._missing(end, opening)


_IN_RESOURCES = "tasks and programs stand in `RESOURCE name ON processor ... END_RESOURCE`"
_POU_ENDS = frozenset(f"END_{kind}" for kind in POUS)
_POU_STOPS = _POU_ENDS | _STARTERS
_BODY_STOPS = _POU_STOPS | {"ACTION"}
_CHART_PARTS = frozenset(charts.STARTS) - {"ACTION"}
_IN_CONFIGURATION = frozenset((*_SHARED, "TASK", "PROGRAM", "RESOURCE", "END_CONFIGURATION"))
_IN_RESOURCE = frozenset(("VAR_GLOBAL", "TASK", "PROGRAM", "RESOURCE", "END_RESOURCE", "END_CONFIGURATION"))
_LINE_STOPS = _IN_RESOURCE | {";"}
_CONFIGURATION_STOPS = frozenset(("CONFIGURATION", "TYPE", "FUNCTION", "FUNCTION_BLOCK"))
