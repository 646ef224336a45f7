"""Component descriptors, `NAME.ldc.toml`: LDC <Name, ID, PI, RI, PT, SF> as a file (SPEC 8, DESIGN 6).

[component]   name, id, version, text
[requires]    RI: power, inputs         (left power port, input data)
[provides]    PI: power, outputs        (right power port, output data)
[properties]  PT: parameters, state, size, comment
[function]    SF: text, formula, language, sources, entry, processor, period_us, wcet_us, compiler
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from msgspec import Meta, Struct

from ldc.components import findings
from ldc.diagnostics import Diagnostics
from ldc.parser import ast, parse_type
from ldc.parser.lexer import KEYWORDS
from ldc.records import field, record
from ldc.source import SourceFile, Span
from ldc.toml_spans import Entry
from ldc.toml_tables import Tables, parse_toml

SUFFIX = ".ldc.toml"
ENABLE, POWER, ERROR, TIME_STEP = "enable", "ENO", "error", "elapsed"
"""What a component has by itself: the pins of its power ports, the output that tells what went wrong (0:
nothing; SPEC 2.4 has the codes), and the variable with the time since the body ran last."""
_OWN = tuple(name.upper() for name in (ENABLE, POWER, ERROR, TIME_STEP))

Text = Annotated[str, Meta(min_length=1)]
Micros = Annotated[int, Meta(ge=1, le=3_600_000_000)]
Number = bool | int | float | str
Identifier = Annotated[str, Meta(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,62}\Z")]


class ComponentTable(Struct):
    name: Identifier = ""
    id: Annotated[str, Meta(pattern=r"^[A-Za-z0-9_]+([.-][A-Za-z0-9_]+)*\Z")] = ""
    version: str = "1.0"
    text: str = ""


class RequiresTable(Struct):
    power: bool = True
    inputs: list = []


class ProvidesTable(Struct):
    power: bool | Identifier = True
    outputs: list = []


class PropertiesTable(Struct):
    parameters: list = []
    state: list = []
    size: Annotated[tuple[int, ...], Meta(min_length=2, max_length=2)] = ()
    comment: str = ""


class CompilerTable(Struct):
    cflags: tuple[Text, ...] = ()
    standard: Text | None = None


class FunctionTable(Struct):
    text: str = ""
    formula: str = ""
    language: Literal["il", "st", "c", "c++"] | None = None
    sources: Annotated[tuple[Text, ...], Meta(min_length=1)] = ()
    entry: Identifier = ""
    processor: Annotated[str, Meta(pattern=r"^(master|slave[1-4]?)\Z")] = "master"
    period_us: Micros | None = None
    wcet_us: Micros | None = None
    compiler: dict = {}


class PinTable(Struct):
    name: Identifier = ""
    type: Text = ""
    unit: str = ""
    min: int | float | None = None
    max: int | float | None = None
    value: Number | None = None
    text: str = ""
    local: bool = False
    retain: bool = False


@record
class Pin:
    """One input, output, parameter or state variable. ``low``, ``high``: the range that an input or
    parameter must be in, in ``unit``. ``value`` is the text of its initial value, None for the type's own.
    ``local``: an input or output that is wired on the slave when that executes the component by itself;
    ``retain``: a variable of the state that survives a restart."""

    name: str
    type: ast.TypeExpr
    unit: str
    low: int | float | None
    high: int | float | None
    value: str | None
    text: str
    span: Span
    value_span: Span
    local: bool = False
    retain: bool = False


@record
class Component:
    """A descriptor, checked as far as it can be alone. ``sources`` are paths relative to ``folder``.

    ``requires_power``: it has a left power port; ``power``: the output whose value leaves at the right
    (ENO: enabled and no error), None without a right power port. ``size``: columns and rows of its
    drawing, () when they are computed. Times in microseconds; ``period_us``: how often a slave runs it,
    or the rate it is made for on the master.
    """

    source: SourceFile
    folder: Path
    name: str
    id: str
    version: str
    text: str
    requires_power: bool
    inputs: tuple[Pin, ...]
    power: str | None
    outputs: tuple[Pin, ...]
    parameters: tuple[Pin, ...]
    state: tuple[Pin, ...]
    size: tuple[int, ...]
    comment: str
    function: str
    formula: str
    language: str
    sources: tuple[str, ...]
    entry: str
    processor: str
    period_us: int | None
    wcet_us: int | None
    cflags: tuple[str, ...]
    standard: str | None
    spans: dict[tuple[str | int, ...], Entry] = field(repr=False)

    @property
    def native(self) -> bool:
        """Whether gcc compiles it (C and C++), not ldc (IL and ST)."""
        return self.language in ("c", "c++")

    def span(self, *path: str | int) -> Span:
        """Where a key stands, or the beginning of the file."""
        entry = self.spans.get(path)
        return entry.value if entry else Span(self.source, 0, 0)


def load(source: SourceFile, folder: Path, diagnostics: Diagnostics) -> Component | None:
    """The component that a descriptor tells, or None with findings when anything in it is wrong."""
    data = parse_toml(source, diagnostics)
    if data is None:
        return None
    before = len(diagnostics)
    tables = Tables(source, data, diagnostics, "the descriptor")
    tables.check_sections(("component", "requires", "provides", "properties", "function"))
    made = _component(source, folder, tables, diagnostics)
    return made if len(diagnostics) == before else None


def _component(source: SourceFile, folder: Path, tables: Tables, diagnostics: Diagnostics) -> Component:
    head = tables.table(("component",), ComponentTable)
    requires = tables.table(("requires",), RequiresTable)
    provides = tables.table(("provides",), ProvidesTable)
    properties = tables.table(("properties",), PropertiesTable)
    function = tables.table(("function",), FunctionTable)
    compiler = tables.table(("function", "compiler"), CompilerTable)
    pins = _Pins(source, tables, diagnostics)
    inputs, outputs = pins.read("requires", "inputs"), pins.read("provides", "outputs")
    parameters, state = pins.read("properties", "parameters"), pins.read("properties", "state")
    power = POWER if provides.power is True else provides.power or None
    _check_required(source, tables, head, function, diagnostics)
    _check_names(head, (*inputs, *parameters, *outputs, *state), source, tables, diagnostics)
    if isinstance(provides.power, str):
        _check_power(provides.power, outputs, tables)
    if function.processor == "master" or function.period_us is None:
        for pin in (*inputs, *outputs):
            if pin.local:
                findings.local_without_pace(diagnostics, pin.span, pin.name)
    return Component(
        source,
        folder,
        head.name,
        head.id,
        head.version,
        head.text,
        requires.power,
        inputs,
        power,
        outputs,
        parameters,
        state,
        properties.size,
        properties.comment,
        function.text,
        function.formula,
        function.language or "",
        function.sources,
        function.entry or head.name.lower(),
        function.processor,
        function.period_us,
        function.wcet_us,
        compiler.cflags,
        compiler.standard,
        tables.spans,
    )


class _Pins:
    def __init__(self, source: SourceFile, tables: Tables, diagnostics: Diagnostics) -> None:
        self.source, self.tables, self.diagnostics = source, tables, diagnostics

    def read(self, section: str, key: str) -> tuple[Pin, ...]:
        found = []
        for number, table in enumerate(self.tables.records((section, key), PinTable)):
            path = (section, key, number)
            pin = self._pin(path, table)
            if pin is not None:
                found.append(pin)
        return tuple(found)

    def _pin(self, path: tuple[str | int, ...], table: PinTable) -> Pin | None:
        item = self.tables.spans[path].value
        missing = [name for name in ("name", "type") if (*path, name) not in self.tables.spans]
        if missing:
            findings.missing_key(self.diagnostics, item, f"this item of [{path[0]}] {path[1]}", missing[0])
        if not table.name or not table.type:
            return None
        at = self.tables.spans[(*path, "type")].value
        type_ = parse_type(self.source, at.start + 1, at.end - 1, self.diagnostics)
        if type_ is None:
            return None
        if None not in (table.min, table.max) and table.min > table.max:
            self.tables.wrong(
                (*path, "max"),
                f"the range of `{table.name}` is empty: {table.min} to {table.max}",
                "min is the smaller one",
            )
        if table.local and path[0] == "properties":
            self.tables.wrong(
                (*path, "local"),
                f"`{table.name}` is no input or output",
                "only these can be wired on a slave",
            )
        if table.retain and path[1] != "state":
            self.tables.wrong(
                (*path, "retain"),
                f"`{table.name}` is a pin",
                "the state is retained; pins are when the instance is declared RETAIN",
            )
        place = self.tables.spans.get((*path, "value"))
        return Pin(
            table.name,
            type_,
            table.unit,
            table.min,
            table.max,
            _literal(table.value),
            table.text,
            self.tables.spans[(*path, "name")].value,
            place.value if place else item,
            table.local,
            table.retain,
        )


def _literal(value: Number | None) -> str | None:
    """An initial value as a literal of IEC 61131-3; texts are literals already (``T#5s``)."""
    if value is None or isinstance(value, str):
        return value
    return {True: "TRUE", False: "FALSE"}[value] if isinstance(value, bool) else repr(value)


def _check_required(
    source: SourceFile,
    tables: Tables,
    head: ComponentTable,
    function: FunctionTable,
    diagnostics: Diagnostics,
) -> None:
    for section, key, value in (
        ("component", "name", head.name),
        ("component", "id", head.id),
        ("function", "language", function.language),
        ("function", "sources", function.sources),
    ):
        if not value and (section, key) not in tables.spans:
            entry = tables.spans.get((section,))
            findings.missing_key(
                diagnostics, entry.value if entry else Span(source, 0, 0), f"[{section}]", key
            )


def _check_names(
    head: ComponentTable, pins: tuple[Pin, ...], source: SourceFile, tables: Tables, diagnostics: Diagnostics
) -> None:
    if head.name.upper() in KEYWORDS:
        tables.wrong(("component", "name"), f"`{head.name}` is a reserved word", "choose another name")
    seen: dict[str, Span] = {}
    for pin in pins:
        key = pin.name.upper()
        if key in KEYWORDS or key in _OWN or key.startswith("_LDC"):
            findings.reserved_pin(diagnostics, pin.span, pin.name)
        elif key in seen:
            findings.pin_twice(diagnostics, pin.span, pin.name, seen[key])
        seen.setdefault(key, pin.span)


def _check_power(name: str, outputs: tuple[Pin, ...], tables: Tables) -> None:
    pin = next((p for p in outputs if p.name.upper() == name.upper()), None)
    if pin is None:
        tables.wrong(
            ("provides", "power"), f"there is no output `{name}`", "name a BOOL output, or write true"
        )
    elif pin.local:
        tables.wrong(("provides", "power"), f"`{name}` is wired on the slave", "name a pin of the ladder")
    elif not (isinstance(pin.type, ast.NamedType) and pin.type.name.upper() == "BOOL"):
        tables.wrong(
            ("provides", "power"), f"power is BOOL, `{name}` is not", "name a BOOL output, or write true"
        )
