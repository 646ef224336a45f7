"""What was written: POUs, declarations and rungs as drawn, each with its span (DESIGN section 2).

Nothing here is typed or resolved; names keep the spelling of the source.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from ldc.records import record
from ldc.source import SourceFile, Span

if TYPE_CHECKING:
    from ldc.parser.sfc import Action
    from ldc.parser.statements import StatementBody

# ---- expressions ------------------------------------------------------------------------------


@record
class Literal:
    """A literal. ``type`` is the declared prefix in capitals (``INT`` of ``INT#5``, TIME for ``T#..``,
    BOOL for TRUE/FALSE), or None when the context decides (``5``, ``16#FF``, ``1.5``, ``'abc'``)."""

    value: bool | int | float | bytes | str
    type: str | None
    text: str
    span: Span


@record
class EnumLiteral:
    """``Colour#red``."""

    type: str
    name: str
    span: Span


@record
class Name:
    name: str
    span: Span


@record
class Direct:
    """A directly represented variable, ``%IX0.0``."""

    address: str
    span: Span


@record
class Member:
    """``base.name``; a decimal ``name`` is a bit of a bit string (``word.15``), one like ``%B1`` a larger
    part."""

    base: Expr
    name: str
    span: Span


@record
class Index:
    base: Expr
    indexes: tuple[Expr, ...]
    span: Span


@record
class Unary:
    """``op``: NOT or ``-`` (a sign on a number is part of the literal)."""

    op: str
    operand: Expr
    span: Span


@record
class Binary:
    """``op``: OR XOR AND = <> < > <= >= + - * / MOD ** (``&`` is read as AND)."""

    op: str
    left: Expr
    right: Expr
    span: Span


@record
class Argument:
    """Of a call in an expression: ``name`` is None when positional; ``output`` for ``=>``."""

    name: str | None
    value: Expr
    output: bool
    span: Span


@record
class Call:
    name: str
    arguments: tuple[Argument, ...]
    span: Span


Expr = Literal | EnumLiteral | Name | Direct | Member | Index | Unary | Binary | Call


@record
class Aggregate:
    """An initial value ``[1, 2, 3(0)]`` (items: (repeat, value)) or ``(a := 1, b := 2)`` (fields)."""

    items: tuple[tuple[int, Initial], ...]
    fields: tuple[tuple[str, Initial], ...]
    span: Span


Initial = Expr | Aggregate

# ---- types and declarations -------------------------------------------------------------------


@record
class NamedType:
    """An elementary type, a type of the project or a function block. ``length`` for STRING[n]."""

    name: str
    length: Expr | None
    span: Span


@record
class ArrayType:
    """``bounds``: least and greatest index of each dimension; None for ``*``, which a call decides."""

    bounds: tuple[tuple[Expr, Expr] | None, ...]
    element: TypeExpr
    span: Span


@record
class StructType:
    fields: tuple[VarDecl, ...]
    span: Span


@record
class EnumType:
    """``(red, amber := 5, green)``; ``base``: the integer type whose values these are, when it is written."""

    values: tuple[tuple[str, Expr | None], ...]
    span: Span
    base: str | None = None


@record
class SubrangeType:
    base: str
    low: Expr
    high: Expr
    span: Span


TypeExpr = NamedType | ArrayType | StructType | EnumType | SubrangeType


@record
class VarDecl:
    """One declared name. ``a, b : INT;`` gives two, which share ``group_span`` (the whole line).
    ``note``: what a foreign source says about it, one line. ``edge``: R_EDGE or F_EDGE, an input that is
    TRUE inside for one call only. ``path``: of a variable in an instance of a function block,
    to which VAR_CONFIG has given an address. ``name`` is an address where only that was declared."""

    name: str
    location: str | None
    type: TypeExpr
    initial: Initial | None
    span: Span
    group_span: Span
    note: str | None = None
    edge: str | None = None
    path: str | None = None

    @property
    def unnamed(self) -> bool:
        """Whether its address is all that it is called by, ``AT %MW6 : INT;``."""
        return self.name.startswith("%")


@record
class VarBlock:
    """``kind``: VAR VAR_INPUT VAR_OUTPUT VAR_IN_OUT VAR_TEMP VAR_EXTERNAL VAR_GLOBAL, or VAR_CONFIG, where
    names are paths of instances;
    ``qualifiers``: of RETAIN NON_RETAIN CONSTANT."""

    kind: str
    qualifiers: tuple[str, ...]
    variables: tuple[VarDecl, ...]
    span: Span


@record
class TypeDecl:
    """``note``: what a foreign source says about the type, one line."""

    name: str
    type: TypeExpr
    initial: Initial | None
    span: Span
    note: str | None = None


# ---- the ladder -------------------------------------------------------------------------------


@record
class Contact:
    """``modifier``: "" (open, or any BOOL expression), "/" closed, "P" rising, "N" falling."""

    modifier: str
    expr: Expr
    span: Span


@record
class Coil:
    """``modifier``: "" "/" "S" "R" "P" "N"."""

    modifier: str
    target: Expr
    span: Span


@record
class Junction:
    """``@name``: a net with a name."""

    name: str
    span: Span


@record
class Jump:
    """``>>label``, or the end of the POU when ``target`` is RETURN (any case)."""

    target: str
    span: Span


@record
class Pin:
    """``pin := value`` or (``output``) ``pin => target`` of a block; ``name`` None when positional."""

    name: str | None
    value: Expr | Branches | Junction
    output: bool
    span: Span


@record
class Block:
    """``<instance: TYPE(pins) in=PIN out=PIN>``; ``instance`` None for a function.

    ``power_in``/``power_out``: what was written after ``in=``/``out=`` (``_``: not wired), or None.
    """

    instance: Expr | None
    type: str
    pins: tuple[Pin, ...]
    power_in: str | None
    power_out: str | None
    span: Span


@record
class Path:
    items: tuple[Item, ...]
    span: Span


@record
class Branches:
    """``{ path | path }``."""

    paths: tuple[Path, ...]
    span: Span


Item = Contact | Coil | Block | Junction | Jump | Branches


@record
class Rung:
    """``name`` is a label and the identity that online change keeps; ``span`` is the whole rung."""

    name: str | None
    title: str | None
    paths: tuple[Path, ...]
    span: Span
    name_span: Span | None = None


@record
class LadderBody:
    """``unread``: rungs of a foreign drawing of which a part could not be read, each with the number of
    rungs before it; only good to be shown beside the finding that tells."""

    rungs: tuple[Rung, ...]
    span: Span
    unread: tuple[tuple[int, Rung], ...] = ()


@record
class TextBody:
    """The source text of a body in Instruction List, ``language`` "IL". ``names``: pairs of an address and of
    the variable that it stands for (ldc/model/unnamed.py)."""

    language: str
    span: Span
    names: tuple[tuple[str, str], ...] = ()


@record
class NativeBody:
    """The body of a component that gcc compiles: ``language`` "c" or "c++" (DESIGN section 6)."""

    language: str
    span: Span


@record
class Pou:
    """``kind``: PROGRAM FUNCTION_BLOCK FUNCTION. ``result`` is the type that a FUNCTION returns, if
    it returns something. The
    body is a ``statements.StatementBody`` in Structured Text, an ``sfc.SfcBody`` of a chart. ``actions``:
    further bodies with names, which are executed where they are called; those of a chart are in its
    body. ``written``: what the source calls it, where it has another name (VAR_CONFIG, LD0180)."""

    kind: str
    name: str
    title: str | None
    result: TypeExpr | None
    var_blocks: tuple[VarBlock, ...]
    body: LadderBody | TextBody | StatementBody | NativeBody
    span: Span
    name_span: Span
    actions: tuple[Action, ...] = ()
    written: str = ""


# ---- configuration ----------------------------------------------------------------------------


@record
class Task:
    """``TASK name (INTERVAL := .., PRIORITY := .., SINGLE := ..)``."""

    name: str
    interval: Expr | None
    single: Expr | None
    priority: Expr | None
    span: Span


@record
class ProgramInstance:
    """``PROGRAM name WITH task : pou;``; ``connections``: ``(x := g, y => h)`` behind it, which are made in
    every execution."""

    name: str
    task: str | None
    pou: str
    span: Span
    connections: tuple[Argument, ...] = ()


@record
class Resource:
    """``RESOURCE name ON processor``; a resource is a processor. ``name`` "": tasks and programs that stand
    in the CONFIGURATION itself."""

    name: str
    processor: str
    var_blocks: tuple[VarBlock, ...]
    tasks: tuple[Task, ...]
    programs: tuple[ProgramInstance, ...]
    span: Span


@record
class Configuration:
    name: str
    var_blocks: tuple[VarBlock, ...]
    resources: tuple[Resource, ...]
    span: Span


@record
class Comment:
    """``text`` with its delimiters, as written."""

    text: str
    span: Span


@record
class Remark:
    """What became of something in a foreign source, for the report of ``ldc import``. ``kind``: "mapped"
    (other means, same effect), "renamed", "added" or "left out"; ``into``: its name or form in the
    ladder language, or why it was left out."""

    kind: str
    what: str
    into: str
    span: Span


@record
class File:
    """One parsed source. What did not parse is left out (the diagnostics tell).

    ``remarks``: of a source in a foreign format, in its order. ``safe``: values that outputs take after a
    fault, by address or path, where a source says it. ``incomplete``: something that has a name was left out
    (a declaration, a heading, a rung that is jumped to), so that an unknown name elsewhere may be just a
    consequence.
    """

    source: SourceFile
    pous: tuple[Pou, ...]
    types: tuple[TypeDecl, ...]
    globals: tuple[VarBlock, ...]
    configurations: tuple[Configuration, ...]
    comments: tuple[Comment, ...]
    incomplete: bool = False
    remarks: tuple[Remark, ...] = ()
    safe: tuple[tuple[str, bool | int | float | str], ...] = ()

    def shared(self) -> Iterator[VarBlock]:
        """The sections outside of POUs."""
        yield from self.globals
        for configuration in self.configurations:
            yield from configuration.var_blocks
            for resource in configuration.resources:
                yield from resource.var_blocks


@record
class Project:
    files: tuple[File, ...]
