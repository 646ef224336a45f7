"""The types of a project: TYPE declarations and type expressions become ``ldc.types`` values."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.library import blocks
from ldc.model import declaration_findings as findings
from ldc.model.environment import Environment
from ldc.model.initial import initial_value, integer, scalar
from ldc.model.names import PREFIX, suggest
from ldc.parser import ast
from ldc.records import record, replace
from ldc.source import Span
from ldc.types import (
    DATE,
    DINT,
    DT,
    ELEMENTARY,
    TIME,
    TOD,
    Array,
    Elementary,
    Enum,
    Field,
    Instance,
    String,
    Struct,
    Subrange,
    Type,
    Value,
    default,
    storage,
)

_LONG = {"LTIME": TIME, "LDATE": DATE, "LTOD": TOD, "LTIME_OF_DAY": TOD, "LDT": DT, "LDATE_AND_TIME": DT}
"""Of the 3rd edition. Ours count nanoseconds in 64 bits (days of a DATE) anyway."""
LARGEST = 1_000_000
LONGEST_STRING = 32_767
DEEPEST = 30


@record
class Known:
    """A type with the initial value that its declaration gives it (None: that of the type itself),
    the number of its scalars and how deep it nests."""

    type: Type
    initial: Value | None = None
    size: int = 1
    depth: int = 0


class TypeTable:
    """Types by name, built when they are first needed.

    ``pou_kinds`` tells the kinds and spellings of the project's POUs by name in capitals. ``broken`` and
    ``unknown``: types whose declaration failed, and those that have none (both were told).
    """

    def __init__(
        self, declarations: dict[str, ast.TypeDecl], pou_kinds: dict[str, tuple[str, str]],
        diagnostics: Diagnostics,
    ) -> None:
        self._declarations = declarations
        self._pou_kinds = pou_kinds
        self._diagnostics = diagnostics
        self._known: dict[str, Known | None] = {}
        self._building: list[str] = []
        self.enum_values: dict[str, list[tuple[Enum, int]]] = {}
        self.broken: set[str] = set()
        self.unknown: set[str] = set()

    def named(self, env: Environment, key: str) -> Known | None:
        """A declared type by its name in capitals; None when there is none or it is wrong."""
        if key in self._known:
            return self._known[key]
        declaration = self._declarations.get(key)
        if declaration is None:
            return None
        if key in self._building:
            cycle = [*self._building[self._building.index(key):], key]
            first = self._declarations[cycle[0]]
            names = [self._declarations[k].name for k in cycle]
            findings.recursive_type(self._diagnostics, first.span, names)
            self.broken.update(cycle)
            return None
        self._building.append(key)
        try:
            found = self._declared(env, declaration)
        finally:
            self._building.pop()
        if key in self.broken:
            found = None
        if found is None:
            self.broken.add(key)
        self._known[key] = found
        return found

    def types(self) -> dict[str, Type]:
        """All declared types that are right, in the order in which they were completed."""
        return {key: known.type for key, known in self._known.items() if known is not None}

    def _declared(self, env: Environment, node: ast.TypeDecl) -> Known | None:
        if len(self._building) > DEEPEST:
            findings.nested_too_deep(self._diagnostics, node.span, f"type `{node.name}`", DEEPEST)
            return None
        known = self.of(env, node.type, node.name)
        if known is None or node.initial is None:
            return known
        value = initial_value(env, node.initial, known.type, self._diagnostics)
        if value is None:
            return None
        if isinstance(known.type, Enum) and isinstance(node.type, ast.EnumType):
            changed = replace(known.type, initial=value)
            self._publish(known.type, changed)
            return Known(changed)
        return Known(known.type, value, known.size, known.depth)

    def of(self, env: Environment, node: ast.TypeExpr, name: str = "") -> Known | None:
        """The type that is written; ``name`` is the name that a TYPE declaration gives it."""
        match node:
            case ast.NamedType():
                return self._reference(env, node)
            case ast.ArrayType():
                return self._array(env, node)
            case ast.StructType() if not name:
                findings.not_allowed_here(self._diagnostics, node.span, "a structure without a name",
                                          "declared here",
                                          "declare it as `TYPE name : STRUCT ... END_STRUCT; END_TYPE`")
                return None
            case ast.StructType():
                return self._struct(env, node, name)
            case ast.EnumType():
                return self._enum(env, node, name)
            case ast.SubrangeType():
                return self._subrange(env, node, name)

    def _reference(self, env: Environment, node: ast.NamedType) -> Known | None:
        key = node.name.upper()
        elementary = ELEMENTARY.get(key)
        if elementary is None and key not in self._declarations:
            elementary = _LONG.get(key)
        if isinstance(elementary, String):
            return self._string(env, node, elementary)
        if node.length is not None:
            findings.bad_bounds(self._diagnostics, node.span, f"{node.name} has no length",
                                "only strings have", "write STRING[n] or WSTRING[n]")
            return None
        if elementary is not None:
            return Known(elementary)
        if key in self._declarations:
            return self.named(env, key)
        kind, spelling = self._pou_kinds.get(key, ("", ""))
        if kind == "FUNCTION_BLOCK" or not kind and blocks.signature(key) is not None:
            return Known(Instance(spelling.upper() or key))
        if kind:
            findings.program_as_type(self._diagnostics, node.span, spelling, kind)
        elif not env.silent(key):
            self.unknown.add(key)
            names = [d.name for d in self._declarations.values()]
            names += [name for pou, name in self._pou_kinds.values() if pou == "FUNCTION_BLOCK"]
            findings.unknown_type(self._diagnostics, node.span, node.name,
                                  suggest(node.name, [*names, *ELEMENTARY, *blocks.names()]))
        return None

    def _string(self, env: Environment, node: ast.NamedType, type_: String) -> Known | None:
        if node.length is None:
            return Known(type_)
        length = integer(env, node.length, self._diagnostics, "the length of a string")
        if length is None:
            return None
        if not 1 <= length <= LONGEST_STRING:
            findings.bad_bounds(self._diagnostics, node.length.span,
                                f"a string cannot have the length {length}",
                                f"1 to {LONGEST_STRING} is possible",
                                "choose another length")
            return None
        return Known(String(type_.name, length))

    def _array(self, env: Environment, node: ast.ArrayType) -> Known | None:
        dimensions = []
        inner: ast.TypeExpr = node
        while isinstance(inner, ast.ArrayType):
            dimensions.append(inner)
            inner = inner.element
        if len(dimensions) > DEEPEST:
            findings.nested_too_deep(self._diagnostics, node.span, "this array of arrays", DEEPEST)
            return None
        known = self.of(env, inner)
        for array in dimensions:
            if None in array.bounds:
                findings.no_bounds(self._diagnostics, array.span)
                return None
        for array in reversed(dimensions):
            bounds = tuple(self._bounds(env, *pair) for pair in array.bounds)
            if known is None or None in bounds:
                return None
            type_ = Array(bounds, known.type)
            size = known.size * type_.count
            if size > LARGEST:
                findings.too_large(self._diagnostics, array.span, size, LARGEST)
                return None
            initial = None if known.initial is None else (known.initial,) * type_.count
            known = Known(type_, initial, size, known.depth + 1)
        return known

    def _bounds(self, env: Environment, low: ast.Expr, high: ast.Expr) -> tuple[int, int] | None:
        least = integer(env, low, self._diagnostics, "the bound of an array")
        greatest = integer(env, high, self._diagnostics, "the bound of an array")
        if least is None or greatest is None:
            return None
        span = low.span.to(high.span)
        if least > greatest:
            findings.bad_bounds(self._diagnostics, span, f"bounds {least}..{greatest} hold nothing",
                                "the lower bound is greater", "write the lower bound first")
            return None
        if not (DINT.range[0] <= least and greatest <= DINT.range[1]):
            findings.bad_bounds(self._diagnostics, span, f"bounds {least}..{greatest} are too large",
                                "an index is a DINT", "choose smaller bounds")
            return None
        return least, greatest

    def _struct(self, env: Environment, node: ast.StructType, name: str) -> Known | None:
        fields: list[Field] = []
        first: dict[str, Span] = {}
        failed, size, depth = False, 0, 0
        for field in node.fields:
            key = field.name.upper()
            if key in first:
                findings.duplicate(self._diagnostics, field.span, field.name, "member", first[key])
                failed = True
                continue
            first[key] = field.span
            if key.startswith(PREFIX):
                findings.reserved_prefix(self._diagnostics, field.span, field.name)
            if field.location is not None:
                findings.location_not_allowed(self._diagnostics, field.span, field.name, "a structure")
            known = self.of(env, field.type)
            initial = known.initial if known is not None else None
            if known is not None and field.initial is not None:
                initial = initial_value(env, field.initial, known.type, self._diagnostics)
                failed |= initial is None
            failed |= known is None
            if known is not None:
                size, depth = size + known.size, max(depth, known.depth + 1)
                fields.append(Field(field.name, known.type, initial))
        if size > LARGEST:
            findings.too_large(self._diagnostics, node.span, size, LARGEST)
            return None
        if depth > DEEPEST:
            findings.nested_too_deep(self._diagnostics, node.span, f"structure `{name}`", DEEPEST)
            return None
        return None if failed else Known(Struct(name, tuple(fields)), None, size, depth)

    def _enum(self, env: Environment, node: ast.EnumType, name: str) -> Known | None:
        values: list[tuple[str, int]] = []
        seen: set[str] = set()
        following = 0
        for value, written in node.values:
            if value.upper() in seen:
                findings.duplicate(self._diagnostics, node.span, value, "enumeration value", None)
                return None
            seen.add(value.upper())
            if value.upper().startswith(PREFIX):
                findings.reserved_prefix(self._diagnostics, node.span, value)
            if written is not None:
                found = scalar(env, written, DINT, self._diagnostics, "an enumeration value")
                if found is None:
                    return None
                following = found.value
            elif following > DINT.range[1]:
                findings.bad_bounds(self._diagnostics, node.span, f"enumeration value `{value}` is too large",
                                    "values are DINT", "choose smaller numbers")
                return None
            values.append((value, following))
            following += 1
        base = self._base(env, node, values)
        if base is None and node.base is not None:
            return None
        type_ = Enum(name, tuple(values), values[0][1], base)
        self._publish(None, type_)
        return Known(type_)

    def _base(self, env: Environment, node: ast.EnumType, values: list[tuple[str, int]]) -> Elementary | None:
        """The type that is written beside the values, which has to hold them all."""
        if node.base is None:
            return None
        known = self._reference(env, ast.NamedType(node.base, None, node.span))
        if known is None:
            return None
        base = storage(known.type)
        if not isinstance(base, Elementary) or base.kind not in ("int", "uint", "bits"):
            findings.bad_bounds(self._diagnostics, node.span,
                                f"an enumeration of {known.type} is not possible",
                                "only integers and bit strings have such", "take an integer type")
            return None
        least, greatest = base.range
        for name, number in values:
            if not least <= number <= greatest:
                findings.bad_bounds(self._diagnostics, node.span,
                                    f"`{name}` is {number}, which {base} does not hold",
                                    f"{base} has {least} to {greatest}",
                                    "choose another number or a larger type")
                return None
        return base

    def _publish(self, old: Enum | None, new: Enum) -> None:
        """Make the values of an enumeration known by their bare names."""
        for name, number in new.values:
            choices = self.enum_values.setdefault(name.upper(), [])
            if old is not None:
                choices[:] = [c for c in choices if c[0] != old]
            if (new, number) not in choices:
                choices.append((new, number))

    def _subrange(self, env: Environment, node: ast.SubrangeType, name: str) -> Known | None:
        key = node.base.upper()
        base: Type | None = ELEMENTARY.get(key)
        if base is None:
            known = self._reference(env, ast.NamedType(node.base, None, node.span))
            if known is None:
                return None
            base = known.type
        if not isinstance(base, Elementary) or base.kind not in ("int", "uint"):
            findings.bad_bounds(self._diagnostics, node.span, f"a range of {base} is not possible",
                                "only integers have ranges", "take an integer type")
            return None
        low = scalar(env, node.low, base, self._diagnostics, "the bound of a range")
        high = scalar(env, node.high, base, self._diagnostics, "the bound of a range")
        if low is None or high is None:
            return None
        if low.value > high.value:
            findings.bad_bounds(self._diagnostics, node.low.span.to(node.high.span),
                                f"range {low.value}..{high.value} holds nothing",
                                "the lower bound is greater", "write the lower bound first")
            return None
        return Known(Subrange(name, base, low.value, high.value))


def complete(known: Known) -> Value:
    """The initial value of a variable that is declared without one."""
    return default(known.type) if known.initial is None else known.initial

