"""From a failed parse to words: what was expected, what is there, and what was probably meant."""

from __future__ import annotations

import difflib

from ldc.diagnostics import Label
from ldc.parser.findings import Findings, cut
from ldc.parser.lexer import KEYWORDS, OPENING, SECTIONS
from ldc.parser.lr import Failure
from ldc.parser.tables import END

_OPERATORS = {"BINOP", "=", "<", ">", "/", "-", "+"}
_OPERAND = {"NAME", "INTEGER", "LITERAL", "NOT", "("}
_ELEMENT = {"[", "(", "<", "@", ">>", "{"}
_NAMES = {
    "NAME": "a name", "DIRECT": "an address", "INTEGER": "a number", "NUMBER": "a number", "TEXT": "a text",
    "LITERAL": "a literal", "STRING": "a string", "MOD": "a modifier", END: "the end",
}
_STRUCTURE = ("RUNG", "PROGRAM", "FUNCTION", "FUNCTION_BLOCK", "TYPE", "CONFIGURATION", "RESOURCE", "TASK",
              "END_PROGRAM", "END_FUNCTION", "END_FUNCTION_BLOCK", "END_TYPE", "END_VAR", "END_CONFIGURATION",
              "END_RESOURCE", *SECTIONS)
_WORDS = ("AND", "OR", "XOR", "MOD", "NOT", "AT", "OF", "ARRAY", "STRUCT", "END_STRUCT", "WITH", "ON")


def explain(failure: Failure, findings: Findings, first: int, end: int, what: str) -> None:
    """Report the failure of the unit ``first`` to ``end``; ``what`` names it (``rung``, ``declaration``)."""
    tokens, index, expected = findings.tokens, failure.index, failure.expected
    types = tokens.types
    open_brackets = _open(types, first, index)
    opening = open_brackets[-1] if open_brackets else None
    kind = types[index] if index < end else END
    if kind in OPENING.values() and (opening is None or OPENING[types[opening]] != kind):
        findings.stray_bracket(index, opening)
        return
    if kind in ("|", "}") and opening is not None and types[opening] == "{" and types[index - 1] in ("{", "|"):
        findings.empty(index, opening)
        return
    if what == "rung" and set(types[first:index]) <= {"RUNG", "NAME", "TEXT"} and (kind == END or kind == ";"):
        findings.empty_rung(first, index)
        return
    found = f"the end of the {what}" if kind == END else findings.shown(index)
    if opening is not None and (kind == END or kind == ";"):
        findings.open_bracket(opening, OPENING[types[opening]], index, found)
        return
    if "NAME" in expected and KEYWORDS.get(kind) == kind and kind not in ("NOT", "_") and kind != "STRUCT":
        findings.reserved(index)
        return
    meant = _meant(tokens.text(index), expected) if kind == "NAME" else ""
    after = f" after {findings.shown(index - 1)}" if index > first else ""
    wanted = _list(expected, opening is not None and types[opening])
    help = f"did you mean `{meant}`?" if meant else _help(kind, types, index, opening, wanted, what)
    if kind == "/" and tokens.source.text.startswith("/*", tokens.starts[index]):
        help = "comments are written `(* ... *)` or `// ...`"
    label = f"found {found}" if kind == END else ""
    secondary = ()
    if opening is not None and OPENING[types[opening]] in expected:
        secondary = (Label(tokens.point(opening), "opened here"),)
    findings.syntax(index, f"expected {wanted}{after}, found {found}", label or f"not {wanted}", help, secondary)


def _open(types: list[str], first: int, index: int) -> list[int]:
    """The brackets that are open at a token."""
    stack = []
    for at in range(first, index):
        if types[at] in OPENING:
            stack.append(at)
        elif types[at] in (")", "]", "}") and stack:
            stack.pop()
    return stack


def _meant(word: str, expected: frozenset[str]) -> str:
    """A keyword that looks much like the word, if it is one that could stand here or begin a section."""
    near = difflib.get_close_matches(cut(word).upper(), (*_STRUCTURE, *_WORDS), 1, 0.75)
    if near and (near[0] in _STRUCTURE or KEYWORDS[near[0]] in expected):
        return near[0]
    return ""


def _list(expected: frozenset[str], opening: str | bool) -> str:
    """``a, b or c``: what could stand here, the most telling first, never more than four."""
    rest = set(expected)
    said: list[str] = []
    closers = [c for c in (")", "]", "}", ">") if c in rest and not (c == ">" and "BINOP" in rest)]
    said += [f"`{c}`" for c in closers]
    rest -= {*closers}
    if rest >= _OPERAND:
        said.append("an expression")
        rest -= {*_OPERAND, *_OPERATORS, "DIRECT", "NUMBER", "STRING", "TEXT", "MOD"}
        if "ARRAY" not in expected:
            rest -= {"@", "{"}
    elif {"NAME", "DIRECT"} <= rest:
        said.append("a variable")
        rest -= {"NAME", "DIRECT", "/", "MOD"}
    if rest >= _OPERATORS:
        said.append("an operator")
        rest -= {*_OPERATORS, ".", "["}
    if rest >= _ELEMENT:
        said.append("an element")
        rest -= _ELEMENT
    if END in rest and len(rest) > 1:
        rest.discard(END)
    if said:
        rest -= {".", "["}
    for symbol in sorted(rest, key=lambda s: (s not in (";", ":", ":=", "|", ","), s)):
        text = _NAMES.get(symbol, symbol if symbol.isalpha() else f"`{symbol}`")
        if text not in said:
            said.append(text)
    said = said[:4]
    return said[0] if len(said) == 1 else f"{', '.join(said[:-1])} or {said[-1]}"


def _help(kind: str, types: list[str], index: int, opening: int | None, wanted: str, what: str) -> str:
    """Advice for what people often write."""
    before = types[index - 1] if index else ""
    if kind == "BINOP" and opening is not None and types[opening] == "(" and what == "rung":
        return "a coil writes one variable; put an expression into a contact, `[a AND b]`"
    if kind == "NAME" and what == "rung" and opening is None:
        return "contacts stand in `[ ]`, coils in `( )`, blocks in `< >`; statements belong into a .st file"
    if what == "declaration" and kind == "NAME" and "`;`" in wanted:
        return "end the declaration with `;`"
    if what == "declaration" and before == "NAME" and kind == "=":
        return "an initial value is given with `:=`"
    return f"write {wanted} here"
