"""Texts of a drawing: their width, how they are shortened, and what is known about blocks' pins."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from ldc.library import blocks, functions
from ldc.parser import ast
from ldc.records import record
from ldc.symbols import Signature
from ldc.types import BOOL

ELLIPSIS = "…"


def text_width(text: str) -> int:
    """Columns that ``text`` takes in a fixed-width font: wide characters two, combining ones none."""
    if text.isascii():
        return len(text)
    return sum(
        0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text
    )


def shorten(text: str, limit: int) -> str:
    """``text`` cut to ``limit`` columns (at least 1), with an ellipsis when something was cut."""
    if text_width(text) <= limit:
        return text
    room, kept = limit - 1, []
    for char in text:
        room -= text_width(char)
        if room < 0:
            break
        kept.append(char)
    return "".join(kept).rstrip() + ELLIPSIS


def fold(text: str, limit: int, most: int = 8) -> tuple[str, ...]:
    """``text`` broken at blanks into lines of at most ``limit`` columns and at most ``most`` lines."""
    lines: list[str] = []
    for word in text.split(" "):
        if lines and text_width(lines[-1]) + 1 + text_width(word) <= limit:
            lines[-1] += " " + word
        elif len(lines) == most:
            lines[-1] = shorten(lines[-1] + " " + word, limit - 1).rstrip(ELLIPSIS) + ELLIPSIS
            break
        else:
            lines.append(shorten(word, limit))
    return tuple(lines)


@record
class BlockPins:
    """The pins of a block in declared order and those that the power takes unless chosen otherwise."""

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    power_in: str | None
    power_out: str | None


def pins_of_signature(signature: Signature) -> BlockPins:
    """A function is powered through EN and ENO, a function block through its first BOOL pins."""
    inputs = tuple(p.name for p in (*signature.inputs, *signature.in_outs))
    if signature.kind == "FUNCTION":
        results = ("OUT",) if signature.result is not None else ()
        outputs = (*results, *(p.name for p in signature.outputs))
        return BlockPins(("EN", *inputs), ("ENO", *outputs), "EN", "ENO")
    outputs = tuple(p.name for p in signature.outputs)
    power_in = next((p.name for p in signature.inputs if p.type == BOOL), None)
    power_out = next((p.name for p in signature.outputs if p.type == BOOL), None)
    return BlockPins(inputs, outputs, power_in, power_out)


def pins_from(signatures: Mapping[str, Signature]) -> Callable[[ast.Block], BlockPins | None]:
    """``pins_of`` for the POUs of a model (keys in capitals); those of the library are always known."""

    actions = {action.upper() for signature in signatures.values() for action in signature.actions}

    def pins_of(block: ast.Block) -> BlockPins | None:
        if block.type.upper() in actions:
            return BlockPins(("EN",), ("ENO",), "EN", "ENO")
        signature = signatures.get(block.type.upper()) or blocks.signature(block.type)
        if signature is not None:
            return pins_of_signature(signature)
        if block.instance is not None or not functions.is_function(block.type):
            return None
        return BlockPins(("EN", *_function_inputs(block)), ("ENO", "OUT"), "EN", "ENO")

    return pins_of


def _function_inputs(block: ast.Block) -> tuple[str, ...]:
    """As many pins as are given, but none that the function cannot have."""
    row = functions.lookup(block.type)
    given = sum(not pin.output and (pin.name or "").upper() != "EN" for pin in block.pins)
    if row is None:
        return functions.pins(block.type, given) or ()
    return row.pins(max(given, row.least) if row.extensible else len(row.names))


standard_pins = pins_from({})


def notes_of(pou: ast.Pou, comments: Iterable[ast.Comment] = ()) -> dict[str, tuple[str, ...]]:
    """What to write under an operand, by name in capitals: its address, and the comment that follows its
    declaration on the same line, or what a foreign source says about it."""
    by_line: dict[tuple[int, int], str] = {}
    for comment in comments:
        line, _ = comment.span.position
        by_line.setdefault((id(comment.span.source), line), comment_text(comment.text))
    notes = {}
    for block in pou.var_blocks:
        for decl in block.variables:
            last, _ = decl.span.source.position(max(decl.group_span.end - 1, 0))
            about = (decl.location, decl.note or by_line.get((id(decl.span.source), last)))
            if any(about):
                notes[decl.name.upper()] = tuple(text for text in about if text)
    return notes


def comment_text(text: str) -> str:
    """A comment without its delimiters, on one line."""
    body = text[2:-2] if text.startswith(("(*", "/*")) else text[2:]
    return " ".join(body.split())


@dataclass(frozen=True, slots=True)
class Options:
    """What a drawing shall show.

    ``width``: columns that a picture may take. ``notes``: texts under operands, by name in capitals.
    ``mark``: a style per span; the smallest drawn element that holds the span gets it.
    ``power``: whether power leaves an element (or one of its pins: second argument), None if unknown.
    ``carets``: a line of carets under marked elements, for pictures without colour.
    """

    width: int = 100
    pins_of: Callable[[ast.Block], BlockPins | None] = standard_pins
    notes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    mark: Mapping[object, str] = field(default_factory=dict)
    power: Callable[[ast.Item, str | None], bool | None] | None = None
    carets: bool = False
