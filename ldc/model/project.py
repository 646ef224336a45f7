"""The resolved project: types made, names known, calls checked; bodies still as drawn."""

from __future__ import annotations

from ldc.model.edges import Edge
from ldc.parser import ast
from ldc.parser.sfc import Action, SfcBody
from ldc.parser.statements import StatementBody
from ldc.records import field, record
from ldc.source import Span
from ldc.symbols import Signature, Variable
from ldc.types import Enum, Type


@record
class Pou:
    """A POU with its typed variables by name in capitals (pins first, in declared order).

    The result of a FUNCTION is also a local variable with the function's name. ``edges``: what the body reads
    of inputs with R_EDGE or F_EDGE. ``actions``: what the body may call beside it.
    """

    signature: Signature
    title: str | None
    variables: dict[str, Variable]
    body: ast.LadderBody | ast.TextBody | StatementBody | SfcBody
    span: Span
    edges: tuple[Edge, ...] = ()
    actions: tuple[Action, ...] = ()

    @property
    def name(self) -> str:
        return self.signature.name


@record
class Task:
    name: str
    interval: int | None
    priority: int
    single: ast.Expr | None
    span: Span | None = None


@record
class Run:
    name: str
    pou: str
    task: str


@record
class Resource:
    name: str
    processor: str
    tasks: tuple[Task, ...]
    runs: tuple[Run, ...]


@record
class Model:
    """Everything that a rung may refer to. Dictionaries are keyed by names in capitals.

    ``signatures`` holds the POUs of the project and the standard function blocks that it uses;
    standard functions are looked up in ``ldc.library``. ``order`` lists the POUs of the project
    (capitals), callees first. ``Run.pou`` is in capitals. ``enum_values``: every enumeration that has
    a value of that name, with its number. ``programs``: the PROGRAMs by all their names,
    ``lists``: names of the lists of globals (``ldc.model.paths``).

    For silence about what was reported already: ``broken`` are names whose declaration failed, by POU
    ("" for globals, types and POUs), ``*`` among them when a declaration was not even understood;
    ``incomplete``: something outside of the POUs was not; ``damaged``: POUs that lost rungs.
    """

    pous: dict[str, Pou]
    types: dict[str, Type]
    globals: dict[str, Variable]
    signatures: dict[str, Signature]
    resources: tuple[Resource, ...]
    order: tuple[str, ...]
    safe: dict[str, object] = field(default_factory=dict)
    image_bytes: int = 1024
    enum_values: dict[str, tuple[tuple[Enum, int], ...]] = field(default_factory=dict)
    broken: dict[str, frozenset[str]] = field(default_factory=dict)
    incomplete: bool = False
    damaged: frozenset[str] = frozenset()
    programs: dict[str, str] = field(default_factory=dict)
    lists: frozenset[str] = frozenset()
