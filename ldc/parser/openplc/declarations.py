"""Declarations in JSON as the words of declarations in IEC 61131-3, each with its place in the JSON."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.parser import ast
from ldc.parser.foreign import Reading
from ldc.parser.lexer import Tokens, lex
from ldc.parser.openplc.values import JsonText, Value
from ldc.records import replace
from ldc.source import Span

_KINDS = {"program": "PROGRAM", "function": "FUNCTION", "function-block": "FUNCTION_BLOCK"}
_SECTIONS = {"input": "VAR_INPUT", "output": "VAR_OUTPUT", "inOut": "VAR_IN_OUT", "external": "VAR_EXTERNAL",
             "temp": "VAR_TEMP", "local": "VAR"}


class Declarations:
    """Collects the words. ``notes``: what is said about a variable, by where its name stands."""

    def __init__(self, reading: Reading, text: JsonText) -> None:
        self.reading, self.text = reading, text
        self.tokens = Tokens(text.plain, [], [], [], [])
        self.notes: dict[int, str] = {}

    def noted(self, section: ast.VarBlock) -> ast.VarBlock:
        """A section with what is said about its variables."""
        return replace(section, variables=tuple(
            replace(v, note=self.notes.get(v.span.start)) for v in section.variables))

    # ---- words

    def _word(self, kind: str, at: int) -> None:
        """A word of the standard that the JSON does not have."""
        self.tokens.types.append(kind)
        self.tokens.starts.append(at)
        self.tokens.ends.append(at)

    def _text(self, value: Value | None) -> bool:
        """The words in a string; False when there are none."""
        if value is None or not isinstance(value.data, str) or not value.data.strip():
            return False
        more = lex(self.text.plain, value.start + 1, value.end - 1)
        self.tokens.types.extend(more.types)
        self.tokens.starts.extend(more.starts)
        self.tokens.ends.extend(more.ends)
        return bool(more.types)

    def _name(self, holder: Value, what: str) -> bool:
        if self._text(holder.get("name")):
            return True
        self.reading.malformed(self._begin(holder), f"{what} has no name")
        return False

    def _begin(self, value: Value) -> Span:
        return Span(self.reading.source, value.start, value.start + 1)

    # ---- declarations

    def pou(self, kind: str, data: Value) -> int | None:
        """Heading and variables; where its name stands, None when it cannot be declared."""
        word = _KINDS.get(kind)
        if word is None:
            self.reading.malformed(self._begin(data), f"`{kind[:40]}` is no kind of POU")
            return None
        self._word(word, data.start)
        if not self._name(data, "a POU"):
            del self.tokens.types[-1], self.tokens.starts[-1], self.tokens.ends[-1]
            return None
        at = self.tokens.starts[-1]
        if word == "FUNCTION":
            self._word(":", self.tokens.ends[-1])
            self._text(data.get("returnType"))
        variables = data.items("variables")
        first = 0
        for index in range(1, len(variables) + 1):
            section = self._section_of(variables[first])
            if index == len(variables) or self._section_of(variables[index]) != section:
                self.section(section, variables[first:index])
                first = index
        self._word(f"END_{word}", data.end)
        return at

    def _section_of(self, variable: Value) -> str:
        return _SECTIONS.get(variable.text("class"), "VAR")

    def section(self, kind: str, variables: Iterable[Value]) -> None:
        """``VAR ... END_VAR``; nothing when there are no variables."""
        variables = list(variables)
        if variables:
            self._word(kind, variables[0].start)
            for variable in variables:
                self._variable(variable)
            self._word("END_VAR", variables[-1].end)

    def _variable(self, variable: Value) -> None:
        if not self._name(variable, "a variable"):
            return
        note = " ".join(variable.text("documentation").split())
        if note:
            self.notes[self.tokens.starts[-1]] = note
        if variable.text("location").strip():
            self._word("AT", self.tokens.ends[-1])
            self._text(variable.get("location"))
        self._word(":", self.tokens.ends[-1])
        self._type(variable.get("type"), variable)
        self._initial(variable.get("initialValue"), variable)

    def _initial(self, value: Value | None, holder: Value) -> None:
        value = (value.get("simpleValue", "value") or value) if value is not None else None
        if value is not None and isinstance(value.data, str) and value.data.strip():
            self._word(":=", value.start)
            self._text(value)
        self._word(";", holder.end)

    def _type(self, type_: Value | None, holder: Value) -> None:
        if type_ is None:
            return
        data = type_.get("data") if type_.text("definition") == "array" else None
        if data is not None:
            self._array(data, type_)
        elif not self._text(type_.get("value")):
            self.reading.malformed(self.text.content(holder.get("name") or type_), "a variable has no type")

    def _array(self, data: Value, holder: Value) -> None:
        self._word("ARRAY", holder.start)
        self._word("[", holder.start)
        for index, dimension in enumerate(data.items("dimensions")):
            if index:
                self._word(",", dimension.start)
            self._text(dimension.get("dimension"))
        self._word("]", holder.end)
        self._word("OF", holder.end)
        self._type(data.get("baseType"), holder)

    # ---- data types

    def types(self, types: Iterable[Value]) -> None:
        """``TYPE ... END_TYPE``; nothing when there are no types."""
        types = list(types)
        if types:
            self._word("TYPE", types[0].start)
            for type_ in types:
                self._data_type(type_)
            self._word("END_TYPE", types[-1].end)

    def _data_type(self, type_: Value) -> None:
        kind = type_.text("derivation")
        if kind not in ("array", "enumerated", "structure"):
            self.reading.malformed(self._begin(type_), f"`{kind[:40]}` is no kind of data type")
            return
        if not self._name(type_, "a data type"):
            return
        self._word(":", self.tokens.ends[-1])
        if kind == "array":
            self._array(type_, type_)
        elif kind == "enumerated":
            self._word("(", type_.start)
            for index, value in enumerate(type_.items("values")):
                if index:
                    self._word(",", value.start)
                self._text(value.get("description"))
            self._word(")", type_.end)
        else:
            self._word("STRUCT", type_.start)
            for field in type_.items("variable"):
                self._variable(field)
            self._word("END_STRUCT", type_.end)
        self._initial(type_.get("initialValue"), type_)
