"""The actions of the rules for declarations, headers and configurations (see builder.py)."""

from __future__ import annotations

from ldc.parser import ast
from ldc.parser.builder import Builder, Values
from ldc.parser.unparse import expr_text
from ldc.records import record
from ldc.source import Span


@record
class PouHead:
    """``PROGRAM name "title"``, ``FUNCTION name : TYPE "title"``."""

    kind: str
    name: str
    title: str | None
    result: ast.TypeExpr | None
    name_span: Span


class FileBuilder(Builder):
    """All actions: those of the ladder, and these."""

    # ---- variables and types

    def variables(self, values: Values) -> list[ast.VarDecl]:
        names, _, kind = values[:3]
        initial = values[4] if len(values) == 6 else None
        group = self.span(names[0], values[-1])
        return [ast.VarDecl(self.declared(n), None, kind, initial, self.span(n, n), group) for n in names]

    def edges(self, values: Values) -> list[ast.VarDecl]:
        names, _, kind, edge, last = values
        type_, group = self.named_type([kind]), self.span(names[0], last)
        return [ast.VarDecl(self.declared(n), None, type_, None, self.span(n, n), group, None,
                            self.types[edge])
                for n in names]

    def located(self, values: Values) -> list[ast.VarDecl]:
        name, _, address, _, kind = values[:5]
        initial = values[6] if len(values) == 8 else None
        group = self.span(name, values[-1])
        location = self.word(address).upper()
        return [ast.VarDecl(self.declared(name), location, kind, initial, self.span(name, name), group)]

    def unnamed(self, values: Values) -> list[ast.VarDecl]:
        """``AT %MW6 : INT;``: a variable that is called by its address."""
        word, address, _, kind = values[:4]
        initial = values[5] if len(values) == 7 else None
        location = self.word(address).upper()
        return [ast.VarDecl(location, location, kind, initial, self.span(address, address),
                            self.span(word, values[-1]))]

    def configured(self, values: Values) -> list[ast.VarDecl]:
        """A line of VAR_CONFIG; the name is a path."""
        return self._configured(values[0], None, values[2], values)

    def configured_at(self, values: Values) -> list[ast.VarDecl]:
        return self._configured(values[0], self.word(values[2]).upper(), values[4], values)

    def _configured(self, path: ast.Expr, location: str | None, type_: ast.TypeExpr, values: Values
                    ) -> list[ast.VarDecl]:
        initial = values[-2] if values[-2] is not type_ else None
        group = Span(self.source, path.span.start, self.span(values[-1], values[-1]).end)
        return [ast.VarDecl(expr_text(path), location, type_, initial, path.span, group)]

    def named_type(self, values: Values) -> ast.NamedType:
        return ast.NamedType(self.word(values[0]), None, self.span(values[0], values[0]))

    def sized_type(self, values: Values) -> ast.NamedType:
        name, _, length, close = values
        if self.word(name).upper() not in ("STRING", "WSTRING"):
            self.findings.length_of(name)
            return self.named_type([name])
        return ast.NamedType(self.word(name), length, self.span(name, close))

    def subrange_type(self, values: Values) -> ast.SubrangeType:
        name, _, low, _, high, close = values
        return ast.SubrangeType(self.word(name), low, high, self.span(name, close))

    def array_type(self, values: Values) -> ast.ArrayType:
        word, _, ranges, _, _, element = values
        return ast.ArrayType(tuple(ranges), element, Span(self.source, self.starts[word], element.span.end))

    def range(self, values: Values) -> tuple[ast.Expr, ast.Expr]:
        return values[0], values[2]

    def open_range(self, values: Values) -> None:
        """``*``: bounds that a call decides."""
        if self.word(values[0]) != "*":
            self.findings.no_range(values[0])

    def structure(self, values: Values) -> ast.StructType:
        fields = tuple(field for group in values[1] for field in group)
        return ast.StructType(fields, self.span(values[0], values[2]))

    def passed(self, values: Values) -> ast.StructType:
        return values[0]

    def enum_type(self, values: Values) -> ast.EnumType:
        base = self.word(values[3]) if len(values) == 4 else None
        return ast.EnumType(tuple(values[1]), self.span(values[0], values[-1]), base)

    def named_values_type(self, values: Values) -> ast.EnumType:
        """``INT (red := 1, green)``, the form of the 3rd edition."""
        return ast.EnumType(tuple(values[2]), self.span(values[0], values[3]), self.word(values[0]))

    def named_first(self, values: Values) -> list[tuple[str, ast.Expr | None]]:
        return [(self.declared(values[0]), values[2])]

    def named_two(self, values: Values) -> list[tuple[str, ast.Expr | None]]:
        return [(self.declared(values[0]), None), values[2]]

    def enum_value(self, values: Values) -> tuple[str, ast.Expr | None]:
        return self.declared(values[0]), values[2] if len(values) == 3 else None

    def type_line(self, values: Values) -> ast.TypeDecl:
        initial = values[4] if len(values) == 6 else None
        name = values[0]
        span = self.span(name, values[-1]) if len(values) > 3 else Span(
            self.source, self.starts[name], values[2].span.end)
        return ast.TypeDecl(self.declared(name), values[2], initial, span)

    # ---- initial values

    def array_initial(self, values: Values) -> ast.Aggregate:
        return ast.Aggregate(tuple(values[1]), (), self.span(values[0], values[2]))

    def struct_initial(self, values: Values) -> ast.Aggregate:
        return ast.Aggregate((), tuple(values[1]), self.span(values[0], values[2]))

    def bare_one(self, values: Values) -> ast.Aggregate:
        """``3(0)``: an array without brackets."""
        return self.bare([values[0], None, []])

    def bare(self, values: Values) -> ast.Aggregate:
        first, _, others = values
        items = (first, *others)
        return ast.Aggregate(items, (), first[1].span.to(items[-1][1].span))

    def element(self, values: Values) -> tuple[int, ast.Initial]:
        return 1, values[0]

    def repeated(self, values: Values) -> tuple[int, ast.Initial]:
        return self.number(values[:1]).value, values[2]

    def member_initial(self, values: Values) -> tuple[str, ast.Initial]:
        return self.word(values[0]), values[2]

    # ---- program organisation units and configurations

    def pou_head(self, values: Values) -> PouHead:
        title = self.title(values[2]) if len(values) == 3 else None
        return self._pou_head(values[0], values[1], title, None)

    def function_head(self, values: Values) -> PouHead:
        title = self.title(values[4]) if len(values) == 5 else None
        result = values[3]
        if isinstance(result, ast.NamedType) and result.name.upper() == "VOID":
            result = None
        return self._pou_head(values[0], values[1], title, result)

    def _pou_head(self, kind: int, name: int, title: str | None, result) -> PouHead:
        return PouHead(self.types[kind], self.declared(name), title, result, self.span(name, name))

    def configuration_head(self, values: Values) -> str:
        return self.declared(values[1])

    def resource_head(self, values: Values) -> tuple[str, str]:
        return self.declared(values[1]), self.word(values[3])

    def task(self, values: Values) -> ast.Task:
        word, name, _, settings, *_, last = values
        given: dict[str, ast.Expr] = {}
        for index, value in settings:
            key = self.word(index).upper()
            if key not in ("INTERVAL", "SINGLE", "PRIORITY") or key in given:
                self.findings.task_setting(index, key in given)
            given[key] = value
        interval, single, priority = map(given.get, ("INTERVAL", "SINGLE", "PRIORITY"))
        return ast.Task(self.declared(name), interval, single, priority, self.span(word, last))

    def task_value(self, values: Values) -> tuple[int, ast.Expr]:
        return values[0], values[2]

    def program_instance(self, values: Values) -> ast.ProgramInstance:
        head, _, pou = values[:3]
        task = self.word(head[3]) if len(head) == 4 else None
        connections = tuple(values[4]) if len(values) > 4 else ()
        return ast.ProgramInstance(self.declared(head[1]), task, self.word(pou),
                                   self.span(head[0], values[-1]),
                                   connections)

    def program_head(self, values: Values) -> Values:
        return values
