"""A POU's view of the model: what names mean in its body, and the typed elements of its rungs."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.diagnostics import Diagnostics
from ldc.expr import Expr, Place
from ldc.library import blocks
from ldc.model import (
    actions,
    chart_control,
    chart_names,
    charts,
    elements,
    expressions,
    ladder,
    ladder_blocks,
    paths,
    places,
    statements,
)
from ldc.model.pins import NetOf
from ldc.model.project import Model
from ldc.parser import ast, sfc
from ldc.parser.statements import StatementBody
from ldc.symbols import Signature, Variable
from ldc.types import Enum, Type


class Scope:
    """Types the expressions and elements of one POU; without a name only globals are visible.

    ``body``: another one than that of the POU, of an action or a transition.

    It is an ``Environment``. Every method reports what is wrong to the ``diagnostics`` that it is
    given and returns None then.
    """

    def __init__(self, model: Model, pou_name: str | None = None, body: sfc.Body | None = None) -> None:
        self.model = model
        self.pou = pou_name or ""
        self.image_bytes = model.image_bytes
        found = model.pous.get(pou_name.upper()) if pou_name else None
        self.kind = found.signature.kind if found is not None else ""
        self.library = found is not None and found.signature.standard
        self._globals = model.globals
        self._locals = found.variables if found is not None else {}
        self._edges = {e.input.name.upper(): e for e in found.edges} if found is not None else {}
        self._known: dict[str, tuple[Variable, bool]] = {}
        if self.kind == "FUNCTION" and found.signature.written:
            self._known[found.signature.written.upper()] = found.variables[pou_name.upper()], False
        whole = found.body if found is not None else None
        self.body = whole if body is None else body
        rungs = self.body.rungs if isinstance(self.body, ast.LadderBody) else ()
        self.statements = isinstance(self.body, StatementBody | sfc.SfcBody)
        self._chart = isinstance(whole, sfc.SfcBody)
        self.flags = frozenset(chart_names.flags(whole)) if self._chart else frozenset()
        self.taken: list[Place] = []
        self.labels = {rung.name.upper(): rung.name for rung in rungs if rung.name}

    def expression(self, node: ast.Expr, wanted: Type | None, diagnostics: Diagnostics) -> Expr | None:
        """The expression in the type that is asked for (None: its own), widening made explicit."""
        return expressions.expression(self, node, wanted, diagnostics)

    def place(self, node: ast.Expr, diagnostics: Diagnostics, write: bool = False) -> Place | None:
        """The place that is named; with ``write`` it must be one that this POU may write."""
        return places.place(self, node, diagnostics, write)

    def element(
        self, item: ast.Contact | ast.Coil | ast.Block | ast.Jump, net_of: NetOf, diagnostics: Diagnostics
    ) -> elements.Element | None:
        """The typed element. ``net_of`` gives the net of a pin's Branches or Junction; its attribute
        ``type_of``, if there is one, the type of that net as known from the left."""
        kind = type(item)
        if kind is ast.Contact:
            return ladder.contact(self, item, diagnostics)
        if kind is ast.Coil:
            return ladder.coil(self, item, diagnostics)
        if kind is ast.Block:
            return ladder_blocks.block(self, item, net_of, diagnostics)
        return ladder.jump(self.labels, item, diagnostics, self.silent_labels)

    def actions(self, diagnostics: Diagnostics) -> tuple[actions.Action, ...]:
        """The typed statements of a POU with a body in Structured Text."""
        return statements.body(self, self.body.statements, diagnostics)

    def chart(self, diagnostics: Diagnostics) -> tuple[chart_control.Part, ...]:
        """What the chart that is the body of the POU does, in the order of execution."""
        damaged = self.pou.upper() in self.model.damaged
        made = charts.chart(self, self.body, damaged, diagnostics)
        return () if diagnostics.has_errors else tuple(chart_control.parts(self, made, diagnostics))

    # ---- the environment --------------------------------------------------------------------------

    @property
    def silent_labels(self) -> bool:
        """Whether a rung may be missing because it was not understood."""
        return self.pou.upper() in self.model.damaged

    def variable(self, key: str) -> tuple[Variable, bool] | None:
        found = self._known.get(key)
        if found is None:
            variable = self._locals.get(key)
            if key in self._edges:
                found = self._edges[key].seen, False
            elif variable is not None:
                found = variable, variable.kind == "external"
            elif (variable := self._globals.get(key)) is not None:
                found = variable, True
            else:
                return None
            self._known[key] = found
        return found

    def path(self, first: str, second: str) -> tuple[Variable, bool] | str | None:
        if first == self.pou.upper():
            return self.variable(second) if second in self._locals else None
        program = self.model.programs.get(first)
        if program is None and first not in self.model.lists:
            return None
        if program is None:
            found = self._globals.get(second)
            return (found, True) if found is not None and paths.list_of(found) == first else None
        found = paths.reached(self.model, program, second)
        return paths.why_not(self.model, program, second) if found is None else (found, True)

    def reached(self, name: str) -> tuple[Variable, ...]:
        """The variables that paths from ``name`` may lead to, but for those that are known without."""
        program = self.model.programs.get(name)
        run = paths.run_of(self.model, program) if program is not None else None
        if run is None:
            return ()
        return tuple(v for v in self._globals.values() if v.name.upper().startswith(f"{run}.".upper()))

    def silent(self, key: str) -> bool:
        if self.model.incomplete or key in self.model.broken.get("", ()):
            return True
        own = self.model.broken.get(self.pou.upper(), ())
        # Parts of a chart declare variables too.
        return key in own or "*" in own or self._chart and self.silent_labels

    def silent_pin(self, pou: str, key: str) -> bool:
        broken = self.model.broken.get(pou, ())
        return key in broken or "*" in broken if key else bool(broken)

    def type_named(self, key: str) -> Type | None:
        return self.model.types.get(key)

    def enum_values(self, key: str) -> tuple[tuple[Enum, int], ...]:
        return self.model.enum_values.get(key, ())

    def signature(self, key: str) -> Signature | None:
        return self.model.signatures.get(key) or blocks.signature(key)

    def names(self) -> Iterable[str]:
        yield from (v.name for v in self._locals.values())
        yield from (v.name for v in self._globals.values())
        for key, choices in self.model.enum_values.items():
            yield next(name for name, _ in choices[0][0].values if name.upper() == key)

    def callables(self) -> Iterable[str]:
        yield from (s.name for s in self.model.signatures.values())
        yield from blocks.names()
