"""What other languages of controllers have and this one does not: objects and pointers, told by name.

Methods, properties and interfaces are taken out of a text before it is read, so that the rest is checked.
"""

from __future__ import annotations

from ldc.parser.findings import Findings
from ldc.parser.lexer import Tokens
from ldc.types import ELEMENTARY

_PARTS = {"METHOD": "END_METHOD", "PROPERTY": "END_PROPERTY", "INTERFACE": "END_INTERFACE"}
_MODIFIERS = frozenset(("ABSTRACT", "FINAL", "PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL"))
_RELATIONS = frozenset(("EXTENDS", "IMPLEMENTS"))
_SECTIONS = frozenset(("VAR_STAT", "VAR_INST"))
_TYPES = {"POINTER": "TO", "REFERENCE": "TO", "REF_TO": "NAME"}

_OPERATORS = {
    "==": "write `=` to compare", "!=": "write `<>` to compare", "&&": "write AND", "||": "write OR",
    "<<": "write `SHL(bits, 2)`", ">>": "write `SHR(bits, 2)`", "++": "write `a := a + 1`",
    "--": "write `a := a - 1`", "!": "write NOT", "%": "a remainder is `a MOD b`, an address `%IX0.0`",
    "?": "write `SEL(condition, else, then)`, or IF",
}
"""Operators of C, and what stands for them."""


def operator_help(text: str, at: int) -> str:
    """What stands for an operator of C of which a character is at an offset; empty when there is none."""
    near = (text[at : at + 2], text[max(at - 1, 0) : at + 1], text[at : at + 1])
    return next((_OPERATORS[part] for part in near if part in _OPERATORS), "")


def take_out(tokens: Tokens, findings: Findings) -> bool:
    """Tell and remove what is object-oriented, and sections of variables that instances share. Whether there
    was any: then names are unknown that the text declares."""
    text = tokens.source.text.upper()
    if not any(end in text for end in (*_PARTS.values(), *_RELATIONS, *_SECTIONS)):
        return False
    cuts: list[tuple[int, int]] = []
    at, types = 0, tokens.types
    while at < len(types):
        stop = _end(tokens, at) if types[at] == "NAME" else 0
        if stop:
            findings.beyond(at, tokens.text(at).upper())
            cuts.append((at, stop))
            at = stop
        elif types[at] == "FUNCTION_BLOCK":
            cuts += _heading(tokens, at + 1, findings)
            at += 1
        else:
            at += 1
    for first, stop in reversed(cuts):
        for column in (tokens.types, tokens.starts, tokens.ends):
            del column[first:stop]
    return bool(cuts)


def tell_types(tokens: Tokens, first: int, end: int, findings: Findings) -> int:
    """Report the first type among the tokens that is a pointer or a UNION. Where
    reading goes on behind the declaration, which ends at ``end`` or with its END_UNION; 0 when there is
    none."""
    types = tokens.types
    for at in range(first, end):
        word, following = tokens.text(at).upper() if types[at] == "NAME" else "", types[at + 1 : at + 2]
        if following == [_TYPES.get(word)]:
            findings.beyond(at, word)
            return end
        if word == "UNION" and following == ["NAME"]:
            findings.beyond(at, word)
            closed = next((n for n in range(at, len(types))
                           if types[n] == "NAME" and tokens.text(n).upper() == "END_UNION"), end - 1)
            return closed + 1 + (types[closed + 1 : closed + 2] == [";"])
    return 0


def tell_jump(tokens: Tokens, at: int, findings: Findings) -> bool:
    """Report a jump or the label of one, where a statement begins with it; whether it does."""
    following = tokens.types[at + 1 : at + 3]
    if tokens.types[at] != "NAME" or following != ["NAME", ";"] and following[:1] != [":"]:
        return False
    if following[0] == "NAME" and tokens.text(at).upper() != "JMP":
        return False
    if following == [":", "NAME"] and (tokens.types[at + 3 : at + 4] == [";"]
                                       or tokens.text(at + 2).upper() in ELEMENTARY):
        return False  # a declaration that stands too late
    findings.beyond(at, "JMP" if following[0] == "NAME" else ":")
    return True


def _end(tokens: Tokens, at: int) -> int:
    """Where a part that begins here ends; 0 when none begins."""
    word, types = tokens.text(at).upper(), tokens.types
    if word in _SECTIONS:
        stop = at + 1
        while stop < len(types) and types[stop] != "END_VAR":
            stop += 1
        return min(stop + 1, len(types))
    closing = _PARTS.get(word)
    if closing is None or types[at + 1 : at + 2] != ["NAME"]:
        return 0
    return next((n + 1 for n in range(at + 1, len(types))
                 if types[n] == "NAME" and tokens.text(n).upper() == closing), 0)


def _heading(tokens: Tokens, at: int, findings: Findings) -> list[tuple[int, int]]:
    """Words before the name of a function block, and what it says that it extends."""
    cuts, types = [], tokens.types
    first = at
    while types[at : at + 2] == ["NAME", "NAME"] and tokens.text(at).upper() in _MODIFIERS:
        at += 1
    if at > first:
        cuts.append((first, at))
    at += 1
    while at < len(types) and types[at] == "NAME" and tokens.text(at).upper() in _RELATIONS:
        findings.beyond(at, tokens.text(at).upper())
        first, at = at, at + 2
        while types[at : at + 2] in ([",", "NAME"], [".", "NAME"]):
            at += 2
        cuts.append((first, at))
    return cuts
