"""The IL around the body of a component: time since the last call, checks of the inputs, power out.

elapsed := time since the previous execution, 0 at the first
error := 6 when an input is no number, 7 when one is out of its range (codes of SPEC 2.4), else 0
if error is 0, the body runs, which may set it
ENO := enable AND error = 0

An algorithm, which a slave executes by itself, has a proxy in the program: the same checks, and then what the
slave has told last instead of the body (SPEC 9.3).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from ldc.components import findings
from ldc.components.descriptor import ENABLE, ERROR, POWER, TIME_STEP, Component, Pin
from ldc.diagnostics import Diagnostics
from ldc.expr import Const, Place
from ldc.il.placement import FED_ERROR, transfer_type
from ldc.il.program import External, Instr, Pace, RungCode, Unit
from ldc.model.project import Pou
from ldc.records import replace
from ldc.symbols import Variable
from ldc.types import BOOL, TIME, UINT, Elementary, storage

NOT_A_NUMBER, OUT_OF_RANGE = 6, 7
_LAST, _NOW, _END = "_ldc_last", "%NOW", "_ldc_end"
_RETURNS = {"RET": "JMP", "RETC": "JMPC", "RETCN": "JMPCN"}


def native(component: Component, pou: Pou, digest: str) -> Unit:
    """The unit of a C or C++ component; ``pou`` is its function block, typed."""
    external = External(
        component.id,
        component.entry,
        component.language,
        digest,
        component.processor,
        None if component.period_us is None else component.period_us * 1000,
    )
    code = (RungCode("native", (Instr("EXT", _place(pou, TIME_STEP), TIME),)),)
    unit = Unit(
        "FUNCTION_BLOCK",
        component.name,
        with_local_pins(component, tuple(pou.variables.values())),
        code,
        title=pou.title,
        external=external,
    )
    return wrapped(component, pou, unit)


def wrapped(component: Component, pou: Pou, unit: Unit) -> Unit:
    """A unit that holds the body alone as the whole component. A RETURN of the body ends the body only."""
    last = Variable(_LAST, TIME, "hidden", initial=-1)
    variables = with_local_pins(component, unit.variables)
    body = tuple(replace(r, code=tuple(_inner(i) for i in r.code)) for r in unit.rungs)
    rungs = (
        RungCode("time", tuple(_time(pou))),
        RungCode("check", tuple(_check(component, pou))),
        *body,
        RungCode("power", tuple(_power(component, pou)), label=_END),
    )
    return replace(unit, variables=(*variables, last), rungs=rungs)


def with_local_pins(component: Component, variables: tuple[Variable, ...]) -> tuple[Variable, ...]:
    """The variables of a unit, local pins as the inputs and outputs that they are, in the order of the
    descriptor: the same for every way to execute the component."""
    kinds = {p.name.upper(): "input" for p in component.inputs if p.local}
    kinds |= {p.name.upper(): "output" for p in component.outputs if p.local}
    if not kinds:
        return variables
    pins = (*component.inputs, *component.parameters, *component.outputs)
    order = {p.name.upper(): n for n, p in enumerate(pins, 1)}
    order |= {ENABLE.upper(): 0, ERROR.upper(): len(pins) + 1}
    if component.power is not None:
        order[component.power.upper()] = len(component.inputs) + len(component.parameters) + 0.5
    found = [replace(v, kind=kinds.get(v.name.upper(), v.kind)) for v in variables]
    rank = {"input": 0, "output": 1}

    def place(v: Variable) -> tuple[int, float]:
        return (rank[v.kind], order[v.name.upper()]) if v.kind in rank else (2, 0)

    return tuple(sorted(found, key=place))


def proxy(component: Component, pou: Pou, slave: int, diagnostics: Diagnostics) -> Unit | None:
    """What the ladder calls in place of a component that ``slave`` executes by itself; None with findings
    when a pin cannot be sent. Outputs and ``FED_ERROR`` are written between scans by what the slave feeds
    back."""
    good = True
    pins = (*component.inputs, *component.outputs, *component.parameters)
    for variable in (v for v in pou.variables.values() if v.name.upper() in {p.name.upper() for p in pins}):
        if transfer_type(variable.type) is None:
            findings.no_transfer(diagnostics, variable.span, variable.name, str(variable.type))
            good = False
    if not good:
        return None
    fed, error = Variable(FED_ERROR, UINT, "hidden"), _place(pou, ERROR)
    take = (Instr("LD", Place(FED_ERROR, UINT), UINT), Instr("ST", error, UINT))
    rungs = (
        RungCode("check", tuple(_check(component, pou, with_local=False))),
        RungCode("fed", take),
        RungCode("power", tuple(_power(component, pou)), label=_END),
    )
    ranges = tuple((p.name, p.low, p.high) for p in pins if (p.low, p.high) != (None, None))
    variables = tuple(v for v in pou.variables.values() if v.kind in ("input", "output"))
    pace = Pace(slave, component.period_us * 1000, ranges)
    return Unit("FUNCTION_BLOCK", component.name, (*variables, fed), rungs, title=pou.title, pace=pace)


def check_memory(component: Component, unit: Unit, slave: int, diagnostics: Diagnostics) -> None:
    """Tells what the body of an algorithm names of the memory of the master."""
    for instr in (i for rung in unit.rungs for i in rung.code):
        for place in (instr.operand, *instr.args, *(at for _, at in instr.outputs)):
            if isinstance(place, Place) and place.is_global and place.root != _NOW:
                at = place.span or instr.span or component.span("function", "sources")
                findings.memory_of_master(diagnostics, at, place.root, component.name, slave)


def _inner(instr: Instr) -> Instr:
    return replace(instr, op=_RETURNS[instr.op], name=_END) if instr.op in _RETURNS else instr


def _place(pou: Pou, name: str) -> Place:
    variable = pou.variables[name.upper()]
    return Place(variable.name, variable.type)


def _time(pou: Pou) -> list[Instr]:
    now, last, dt = Place(_NOW, TIME, is_global=True), Place(_LAST, TIME), _place(pou, TIME_STEP)
    zero = Const(0, TIME)
    return [
        Instr("LD", now, TIME),
        Instr("SUB", last, TIME),
        Instr("ST", dt, TIME),
        Instr("LD", last, TIME),
        Instr("LT", zero, TIME),
        Instr("JMPCN", name="later"),
        Instr("LD", zero, TIME),
        Instr("ST", dt, TIME),
        Instr("LABEL", name="later"),
        Instr("LD", now, TIME),
        Instr("ST", last, TIME),
    ]


def _check(component: Component, pou: Pou, with_local: bool = True) -> list[Instr]:
    """One condition for what is right of an input; which code it gets is asked when it is not."""
    error = _place(pou, ERROR)
    code = [*_tell(0, error)]
    for pin in (*component.inputs, *component.parameters):
        place, good = _place(pou, pin.name), f"good_{len(code)}"
        right = [] if pin.local and not with_local else list(_right(pin, place))
        if not right:
            continue
        code += [Instr("LD", place, place.type), right[0]]
        for test in right[1:]:
            code += [Instr("AND(", place), test, Instr(")")]
        code.append(Instr("JMPC", name=good))
        bounded, real = right[0].op != "EQ", storage(place.type).kind == "real"
        if bounded:
            code += _tell(OUT_OF_RANGE, error)
        if bounded and real:
            code += [Instr("LD", place, place.type), Instr("NE", place, place.type),
                     Instr("JMPCN", name=good)]
        if real:
            code += _tell(NOT_A_NUMBER, error)
        code.append(Instr("LABEL", name=good))
    return [*code, Instr("LD", error, UINT), Instr("EQ", Const(0, UINT), UINT), Instr("JMPCN", name=_END)]


def _tell(number: int, error: Place) -> tuple[Instr, Instr]:
    return Instr("LD", Const(number, UINT), UINT), Instr("ST", error, UINT)


def _right(pin: Pin, place: Place) -> Iterator[Instr]:
    """Comparisons that are TRUE for a value as it should be; none is for what is no number."""
    type_ = storage(place.type)
    if not isinstance(type_, Elementary) or type_.kind not in ("int", "uint", "real"):
        return
    if pin.low is not None:
        yield Instr("GE", _bound(pin.low, type_, math.ceil), type_)
    if pin.high is not None:
        yield Instr("LE", _bound(pin.high, type_, math.floor), type_)
    if type_.kind == "real" and pin.low is pin.high is None:
        yield Instr("EQ", place, type_)


def _bound(value: int | float, type_: Elementary, inwards: Callable[[float], int]) -> Const:
    """The bound as a value of the type; of an integer the nearest one that is allowed."""
    if type_.kind == "real":
        return Const(float(value), type_)
    low, high = type_.range
    return Const(min(max(inwards(value), low), high), type_)


def _power(component: Component, pou: Pou) -> list[Instr]:
    if component.power != POWER:
        return []
    error = _place(pou, ERROR)
    code = [Instr("LD", error, UINT), Instr("EQ", Const(0, UINT), UINT)]
    if component.requires_power:
        code.append(Instr("AND", _place(pou, ENABLE), BOOL))
    return [*code, Instr("ST", _place(pou, POWER), BOOL)]
