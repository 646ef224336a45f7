"""From a failed parse to words: what was expected, what is there, and what was probably meant."""

from __future__ import annotations

from ldc.diagnostics import Label
from ldc.parser.beyond import operator_help
from ldc.parser.findings import Findings, cut
from ldc.parser.lexer import KEYWORDS, OPENING, SECTIONS
from ldc.parser.lr import Failure
from ldc.parser.tables import END
from ldc.similar import similar

_OPERATORS = {"BINOP", "WORDOP", "=", "<", ">", "/", "-", "+"}
_OPERAND = {"NAME", "INTEGER", "LITERAL", "NOT", "("}
_ELEMENT = {"[", "(", "<", "@", ">>", "{"}
_FIRST = (")", "]", "}", ">", ";", ":", ",", "|")
_GROUPS = (
    (_OPERAND, "an expression", {*_OPERATORS, "DIRECT", "NUMBER", "STRING", "TEXT", "MODIFIER", "@", "{"}),
    ({"NAME", "ARRAY", "STRUCT"}, "a type", {"("}),
    ({"NAME", "WORDOP"}, "a function or an instance", {"DIRECT", "NOT"}),
    ({"NAME", "DIRECT"}, "a variable", {"/", "MODIFIER"}),
    (_OPERATORS, "an operator", {".", "[", "("}),
    (_ELEMENT, "an element", set()),
)
_NAMES = {
    "NAME": "a name", "DIRECT": "an address", "INTEGER": "a number", "NUMBER": "a number", "TEXT": "a text",
    "LITERAL": "a literal", "STRING": "a string", "MODIFIER": "a modifier", END: "the end",
    "BINOP": "an operator", "WORDOP": "an operator",
}
_STRUCTURE = ("RUNG", "PROGRAM", "FUNCTION", "FUNCTION_BLOCK", "TYPE", "CONFIGURATION", "RESOURCE", "TASK",
              "END_PROGRAM", "END_FUNCTION", "END_FUNCTION_BLOCK", "END_TYPE", "END_VAR", "END_CONFIGURATION",
              "END_RESOURCE", *SECTIONS)
_WORDS = ("AND", "OR", "XOR", "MOD", "NOT", "AT", "OF", "ARRAY", "STRUCT", "END_STRUCT", "WITH", "ON")


def explain(failure: Failure, findings: Findings, first: int, end: int, what: str) -> None:
    """Report the failure of the unit ``first`` to ``end``; ``what`` names it (``rung``, ``declaration``)."""
    tokens, index, expected = findings.tokens, failure.index, failure.expected
    types = tokens.types
    if index > first and types[index - 1] == ".":
        expected = expected - {"DIRECT"}  # `.%X3`, which few write
    kind = types[index] if index < end else END
    found = f"the end of the {what}" if kind == END and (what == "rung" or index == len(types)) else (
        findings.shown(index))
    span = findings.behind(index - 1) if kind == END and index else tokens.point(index)
    open_brackets = _open(types, first, index)
    opening = open_brackets[-1] if open_brackets else None
    closer = OPENING[types[opening]] if opening is not None else ""
    if kind in ("|", "}", ";", END) and index > first and types[index - 1] in ("{", "|") and closer == "}":
        findings.empty(index, opening)
    elif what == "rung" and set(types[first:index]) <= {"RUNG", "NAME", "TEXT"} and kind in (END, ";"):
        findings.empty_rung(first, index)
    elif kind in (")", "]", "}") and kind != closer and kind not in _closers(types, open_brackets):
        findings.stray_bracket(index, opening)
    elif closer and kind != closer and (kind in (END, ";", ")", "]", "}") or (
            closer in expected and kind in _ELEMENT | {"|"})):
        findings.open_bracket(opening, closer, span, found)
    elif kind in (":", ",") and types[first:index] == ["AT"]:
        findings.reserved(first)
    elif "NAME" in expected and KEYWORDS.get(kind) == kind and kind not in ("NOT", "_", "STRUCT"):
        findings.reserved(index)
    else:
        after = f" after {findings.shown(index - 1)}" if index > first else ""
        wanted = _list(expected)
        meant = _meant(tokens.text(index), expected) if kind == "NAME" else ""
        help = f"did you mean `{meant}`?" if meant else _help(findings, kind, index, closer, wanted, what)
        secondary = (Label(tokens.point(opening), "opened here"),) if closer in expected else ()
        label = f"the {what} ends here" if kind == END else _NAMES.get(
            kind, "a reserved word" if kind in KEYWORDS else found)
        findings.syntax(span, f"expected {wanted}{after}, found {found}", label, help, secondary)


def _closers(types: list[str], open_brackets: list[int]) -> set[str]:
    return {OPENING[types[at]] for at in open_brackets}


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
    word = cut(word).upper()
    here = [w for w in _WORDS if KEYWORDS[w] in expected]
    near = similar(word, _STRUCTURE, 1, 0.75)
    return next(iter(near or similar(word, here, 1, 0.65)), "")


def _list(expected: frozenset[str]) -> str:
    """``a, b or c``: what could stand here, the most telling first, never more than four."""
    rest = set(expected)
    first = [symbol for symbol in _FIRST if symbol in rest and not (symbol == ">" and "BINOP" in rest)]
    said = [f"`{symbol}`" for symbol in first]
    rest.difference_update(first)
    for group, name, implied in _GROUPS:
        if rest >= group:
            said.append(name)
            rest -= group | implied
    if ";" in expected:
        rest -= {"R_EDGE", "F_EDGE"}  # rare, and only behind some types
    if said:
        rest -= {".", "[", "(", END} if ":" not in expected else {END}
    for symbol in sorted(rest):
        text = _NAMES.get(symbol, symbol if symbol.isalpha() else f"`{symbol}`")
        if text not in said:
            said.append(text)
    said = said[:4]
    if not said:
        return "the end"
    return said[0] if len(said) == 1 else f"{', '.join(said[:-1])} or {said[-1]}"


def _help(findings: Findings, kind: str, index: int, closer: str, wanted: str, what: str) -> str:
    """Advice for what people often write."""
    tokens = findings.tokens
    text, at = tokens.source.text, tokens.starts[index] if kind != END else len(tokens.source.text)
    if text.startswith("/*", at):
        return "comments are written `(* ... *)` or `// ...`"
    if text.startswith("*)", at):
        return "no comment is open here"
    if what == "rung" and kind in ("BINOP", "WORDOP") and closer == ")":
        return "a coil writes one variable; put an expression into a contact, `[a AND b]`"
    if what == "rung" and kind == "NAME" and not closer and "element" in wanted:
        return "contacts stand in `[ ]`, coils in `( )`, blocks in `< >`; statements belong into a .st file"
    if what == "rung" and kind == "|" and not closer:
        return "branches stand in braces: `{ [a] | [b] }`"
    if what == "declaration" and "`;`" in wanted and kind in ("NAME", END):
        return "end the declaration with `;`"
    if what == "declaration" and kind == "..":
        return "an array is `ARRAY [1..n] OF type`, a subrange `INT (0..n)`"
    if what == "declaration" and kind == "=":
        return "an initial value is given with `:=`"
    if kind == ":=" and (what == "condition" or closer == "]"):
        return "`:=` assigns; write `=` to compare"
    if meant := operator_help(text, at) if kind in _OPERATORS | {"|", ">>"} and what != "rung" else "":
        return meant
    if what == "statement" and text[at : at + 2] in ("+=", "-=", "*=", "/="):
        return f"write the variable on both sides: `a := a {text[at]} b`"
    return f"write {wanted} here"
