"""The one canonical form of a file (``ldc fmt``).

Parsing the result gives the same tree, formatting it again the same text. Comments keep their place:
above a line, behind it, or between two elements of a rung.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from itertools import groupby

from ldc.parser import ast, layout, unparse
from ldc.parser.comments import Comments, comment_text, trailing_text
from ldc.parser.format_charts import ChartPrinter
from ldc.parser.format_statements import StatementPrinter
from ldc.parser.lexer import lex
from ldc.parser.listing import listed
from ldc.parser.literals import quoted
from ldc.parser.sfc import SfcBody, parts_of
from ldc.parser.statements import StatementBody

INDENT = unparse.INDENT
_WIDEST_NAME, _WIDEST_LINE = 24, 60


def format_file(file: ast.File) -> str:
    """Canonical text of a file that was parsed without errors (what was left out would be lost)."""
    return _Printer(file).file()


class _Printer:
    """Collects lines. ``last`` is the offset in the source behind what was printed last; ``opened`` tells
    that it was an opening line, below which no blank line stands; ``beside`` are the lines (number, columns)
    behind which comments stand that ``_align`` brings into one column."""

    def __init__(self, source_file: ast.File) -> None:
        self.tree, self.text = source_file, source_file.source.text
        self.tokens = lex(source_file.source)
        bodies = [body.span for pou in source_file.pous for body in parts_of(pou)
                  if isinstance(body, ast.TextBody)]
        free = (c for c in source_file.comments
                if not any(b.start <= c.span.start < b.end for b in bodies))
        self.comments = Comments(self.text, free)
        self.lines: list[str] = []
        self.last, self.opened = 0, True
        self.beside: list[tuple[int, int]] = []

    def file(self) -> str:
        tree = self.tree
        parts = _ordered(tree.pous, tree.types, tree.globals, tree.configurations)
        for is_type, group in groupby(parts, key=lambda p: isinstance(p, ast.TypeDecl)):
            if is_type:
                self._types(list(group))
                continue
            for part in group:
                self.blank()
                self.above(part.span.start, "")
                if isinstance(part, ast.Pou):
                    self._pou(part)
                elif isinstance(part, ast.VarBlock):
                    self._section(part, "")
                else:
                    self._configuration(part)
        rest = self.comments.before(len(self.text) + 1)
        if rest:
            self.blank()
            self.own_lines(rest, "")
        return "\n".join(self.lines) + "\n" if self.lines else ""

    # ---- lines and comments

    def blank(self) -> None:
        if self.lines and self.lines[-1]:
            self.lines.append("")

    def own_lines(self, comments: Sequence[ast.Comment], indent: str) -> None:
        for comment in comments:
            self._keep_blank(comment.span.start)
            self.lines.append(indent + comment_text(comment))
            self.last = comment.span.end

    def _keep_blank(self, start: int) -> None:
        """A blank line where the source has one, but none below an opening line."""
        if self.text.count("\n", self.last, start) > 1 and not self.opened:
            self.blank()
        self.opened = False

    def above(self, start: int, indent: str) -> None:
        """Comments that stand before ``start``, on lines of their own."""
        self.own_lines(self.comments.before(start), indent)
        self._keep_blank(start)

    def line(self, text: str, end: int, opens: bool = False) -> None:
        """A line for what ends at ``end`` in the source, with the comments in it and behind it."""
        beside = self.comments.same_line(end)
        if beside:
            self.beside.append((len(self.lines), len(text)))
        self.lines.append(text + trailing_text(beside))
        self._printed(end, beside)
        self.opened = opens

    def _printed(self, end: int, beside: Sequence[ast.Comment]) -> None:
        self.last = max(end, beside[-1].span.end) if beside else end

    def _token(self, word: str, start: int, step: int) -> int:
        """The index of the next token ``word`` from an offset, forward (1) or backward (-1)."""
        index = self._index(start)
        while self.tokens.types[index] != word:
            index += step
        return index

    def _align(self, first: int) -> None:
        """Bring the comments behind the lines from ``first`` on into one column, but for very long lines."""
        mine = [(line, width) for line, width in self.beside if line >= first and width <= _WIDEST_LINE]
        column = max((width for _, width in mine), default=0)
        for line, width in mine:
            text = self.lines[line]
            self.lines[line] = text[:width].ljust(column) + text[width:]
        self.beside.clear()

    def _index(self, start: int) -> int:
        """The index of the token that begins at an offset."""
        return bisect_left(self.tokens.starts, start)

    # ---- declarations

    def _section(self, block: ast.VarBlock, indent: str) -> None:
        head = " ".join((block.kind, *block.qualifiers))
        first = self._token(block.kind, block.span.start, 1) + len(block.qualifiers)
        self.line(indent + head, self.tokens.ends[first], opens=True)
        top = len(self.lines)
        self._declarations(block.variables, indent + INDENT)
        self._align(top)
        self.close("END_VAR", block.span.end, indent, indent + INDENT)

    def _declarations(self, variables: Sequence[ast.VarDecl], indent: str) -> None:
        """A line for each group of names, with the types in one column."""
        groups = [list(group) for _, group in groupby(variables, key=lambda v: v.group_span)]
        names = [", ".join(v.name for v in group if not v.unnamed) for group in groups]
        width = max((len(n) for n in names if len(n) <= _WIDEST_NAME), default=0)
        for (declared, *_), text in zip(groups, names, strict=True):
            span = declared.group_span
            place = f"AT {declared.location} : " if declared.location else ": "
            self.above(span.start, indent)
            head = f"{text.ljust(width)}  {place}" if text else place
            self._declaration(indent + head, declared, span.end, indent)

    def close(self, word: str, end: int, indent: str, inner: str) -> None:
        self.own_lines(self.comments.before(end - len(word)), inner)
        self.line(indent + word, end)

    def _declaration(self, head: str, declared: ast.VarDecl | ast.TypeDecl, end: int, indent: str) -> None:
        """``name : type := initial;``, with a line for each field of a STRUCT."""
        ranges, kind = "", declared.type
        while isinstance(kind, ast.ArrayType):
            ranges, kind = f"{ranges}ARRAY [{unparse.bounds_text(kind)}] OF ", kind.element
        if not isinstance(kind, ast.StructType):
            self.line(f"{head}{unparse.declared_text(declared)};", end)
            return
        word = self._token("STRUCT", kind.span.start, 1)
        self.line(f"{head}{ranges}STRUCT", self.tokens.ends[word], opens=True)
        self._declarations(kind.fields, indent + INDENT)
        self.own_lines(self.comments.before(kind.span.end - len("END_STRUCT")), indent + INDENT)
        initial = "" if declared.initial is None else f" := {unparse.initial_text(declared.initial)}"
        self.line(f"{indent}END_STRUCT{initial};", end)

    def _types(self, types: list[ast.TypeDecl]) -> None:
        """Neighbouring types share one TYPE block."""
        first = self._token("TYPE", types[0].span.start, -1)
        self.blank()
        self.above(self.tokens.starts[first], "")
        self.line("TYPE", self.tokens.ends[first], opens=True)
        for declared in types:
            self.above(declared.span.start, INDENT)
            top = len(self.lines)
            self._declaration(f"{INDENT}{declared.name} : ", declared, declared.span.end, INDENT)
            self._align(top)
        start = self.tokens.starts[self._token("END_TYPE", types[-1].span.start, 1)]
        self.close("END_TYPE", start + len("END_TYPE"), "", INDENT)

    # ---- program organisation units

    def _pou(self, pou: ast.Pou) -> None:
        self.line(heading(pou), self._head_end(pou))
        for block in pou.var_blocks:
            self.opened = True
            self.above(block.span.start, "")
            self._section(block, "")
        if isinstance(pou.body, StatementBody):
            self.blank()
            self.opened = True
            StatementPrinter(self).list(pou.body.statements, INDENT)
        elif isinstance(pou.body, ast.TextBody):
            self.listing(pou.body)
        elif isinstance(pou.body, SfcBody):
            ChartPrinter(self).chart(pou.body)
        else:
            for rung in pou.body.rungs:
                self.blank()
                self.rung(rung, "")
        ChartPrinter(self).actions(pou.actions)
        word = f"END_{pou.kind}"
        below = self.comments.before(pou.span.end - len(word))
        if below:
            inside = isinstance(pou.body, StatementBody) and not pou.actions
            if not inside:
                self.blank()
            self.own_lines(below, INDENT if inside else "")
        self.line(word, pou.span.end)

    def _head_end(self, pou: ast.Pou) -> int:
        """The offset behind the name, type and title of a POU."""
        index = self._index(pou.name_span.start)
        if pou.result is not None:
            while self.tokens.ends[index] < pou.result.span.end:
                index += 1
        return self.tokens.ends[index + (pou.title is not None)]

    def listing(self, body: ast.TextBody) -> None:
        """As written; only blank lines around it and space at the ends of lines are dropped."""
        first, *rest = (line.rstrip() for line in listed(body).split("\n"))
        first = first.strip()
        if first.startswith(("(*", "//")):
            self.lines[-1] += "  " + first
        elif first:
            rest.insert(0, INDENT + first)
        while rest and not rest[0]:
            rest.pop(0)
        while rest and not rest[-1]:
            rest.pop()
        if rest:
            self.lines += ["", *rest] if self.lines[-1] == "END_VAR" else rest
        self.last = body.span.end

    def token_end(self, word: str, start: int) -> int:
        """The offset behind the next token ``word`` from one that begins at ``start``."""
        return self.tokens.ends[self._token(word, start, 1)]

    def rung(self, rung: ast.Rung, indent: str) -> None:
        inner = indent + INDENT
        self.above(rung.span.start, indent)
        first = rung.paths[0].items[0].span.start
        beside = trailing_text(self._beside_head(rung.span.start, first))
        self.lines.append(indent + unparse.rung_head(rung) + beside)
        for number, path in enumerate(rung.paths, 1):
            last = number == len(rung.paths)
            lead = layout.comment_atoms(self.comments.before(path.span.start), self.comments, first=True)
            writer = layout.Writer()
            writer.start(inner)
            layout.fill([*lead, *layout.atoms(path, self.comments)], writer, len(inner), len(inner))
            beside = self.comments.before(rung.span.end) if last else []
            end = rung.span.end if last else path.span.end
            beside += self.comments.same_line(end)
            self.lines += writer.finish(("" if last else ";") + trailing_text(beside))
        self._printed(rung.span.end, beside)
        self.opened = False

    def _beside_head(self, start: int, limit: int) -> list[ast.Comment]:
        """The comments in the line of a rung's name, before its first element."""
        taken: list[ast.Comment] = []
        end = self.text.find("\n", start)
        line_end = end if end >= 0 else len(self.text)
        while found := self.comments.before(min(line_end, limit)):
            taken += found
            end = self.text.find("\n", taken[-1].span.end)
            line_end = end if end >= 0 else len(self.text)
        return taken

    # ---- configurations

    def _configuration(self, configuration: ast.Configuration) -> None:
        start = self._index(configuration.span.start)
        self.line(f"CONFIGURATION {configuration.name}", self.tokens.ends[start + 1], opens=True)
        own = [r for r in configuration.resources if not r.name]
        lines = ((*r.tasks, *r.programs) for r in own)
        for part in _ordered(configuration.var_blocks, (r for r in configuration.resources if r.name),
                             *lines):
            self.above(part.span.start, INDENT)
            if isinstance(part, ast.Resource):
                self._resource(part)
            else:
                self._in_resource(part, INDENT)
        self.close("END_CONFIGURATION", configuration.span.end, "", INDENT)

    def _resource(self, resource: ast.Resource) -> None:
        start = self._index(resource.span.start)
        inner = INDENT * 2
        head = f"{INDENT}RESOURCE {resource.name} ON {resource.processor}"
        self.line(head, self.tokens.ends[start + 3], opens=True)
        for part in _ordered(resource.var_blocks, resource.tasks, resource.programs):
            self.above(part.span.start, inner)
            self._in_resource(part, inner)
        self.close("END_RESOURCE", resource.span.end, INDENT, inner)

    def _in_resource(self, part: ast.VarBlock | ast.Task | ast.ProgramInstance, indent: str) -> None:
        if isinstance(part, ast.VarBlock):
            self._section(part, indent)
        else:
            text = task_text(part) if isinstance(part, ast.Task) else program_text(part)
            self.line(indent + text, part.span.end)


def _ordered(*groups: Iterable) -> list:
    return sorted((part for group in groups for part in group), key=lambda part: part.span.start)


def heading(pou: ast.Pou) -> str:
    """``FUNCTION name : TYPE "title"``."""
    result = "" if pou.result is None else f" : {unparse.type_text(pou.result)}"
    title = "" if pou.title is None else f" {quoted(pou.title)}"
    return f"{pou.kind} {pou.name}{result}{title}"


def program_text(program: ast.ProgramInstance) -> str:
    task = "" if program.task is None else f" WITH {program.task}"
    made = f"({', '.join(map(unparse.argument_text, program.connections))})" if program.connections else ""
    return f"PROGRAM {program.name}{task} : {program.pou}{made};"


def task_text(task: ast.Task) -> str:
    given = (("SINGLE", task.single), ("INTERVAL", task.interval), ("PRIORITY", task.priority))
    settings = ", ".join(f"{name} := {unparse.expr_text(e)}" for name, e in given if e is not None)
    return f"TASK {task.name} ({settings});"
