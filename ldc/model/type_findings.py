"""The findings about the types of expressions, LD04xx: one function raises each code."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics
from ldc.library import functions
from ldc.source import Span
from ldc.types import BOOL, Array, Elementary, Enum, Instance, String, Struct, Subrange, Type, storage


def not_bool(diagnostics: Diagnostics, span: Span, what: str, type_: Type, help: str) -> None:
    diagnostics.error("LD0401", f"{what} needs a BOOL", span, f"this is {described(type_)}", help=help)


def does_not_fit(diagnostics: Diagnostics, span: Span, text: str, type_: Type) -> None:
    diagnostics.error("LD0402", f"{text} does not fit the type {type_}", span, _holds(type_),
                      help="choose a smaller value or a larger type")


def _holds(type_: Type) -> str:
    match type_:
        case Elementary(kind="int" | "uint" | "bits" | "bool"):
            low, high = type_.range
            return f"{type_} goes from {low} to {high}"
        case String():
            return f"{type_} holds {type_.length} characters"
        case Subrange():
            return f"{type_} goes from {type_.low} to {type_.high}"
    return f"too large for {type_}"


def mismatch(diagnostics: Diagnostics, span: Span, wanted: Type, got: Type, what: str = "") -> None:
    message = f"{what or 'this place'} needs {described(wanted)}, not {described(got)}"
    _mismatch(diagnostics, span, message, got, _literal_help(span, wanted) or conversion_help(got, wanted))


def not_storable(diagnostics: Diagnostics, span: Span, pin: str, given: Type, target: Type) -> None:
    help = conversion_help(given, target)
    _mismatch(diagnostics, span, f"output `{pin}` gives {described(given)}, not {described(target)}", target,
              f"take it into a variable of type {given}" + (f", then {help}" if help else ""))


def _mismatch(diagnostics: Diagnostics, span: Span, message: str, there: Type, help: str) -> None:
    diagnostics.error("LD0403", message, span, f"this is {described(there)}", help=help)


def _literal_help(span: Span, wanted: Type) -> str:
    """How to write the value where a literal stands."""
    wanted = storage(wanted)
    if isinstance(wanted, Elementary) and wanted.kind == "time" and span.text.isdecimal():
        return f"a time has a unit, for example `T#{span.text}ms`"
    if isinstance(wanted, String) and wanted.name == "STRING" and span.text.startswith('"'):
        return "a STRING stands in single quotes, `'text'`"
    return ""


def conversion_help(got: Type, wanted: Type) -> str:
    """Names the function that makes the one type from the other, when there is one."""
    if isinstance(got, Array) and not isinstance(wanted, Array):
        return "take one element of it, `array[index]`"
    got, wanted = storage(got), storage(wanted)
    if isinstance(got, Elementary | String) and isinstance(wanted, Elementary | String):
        if wanted == BOOL:
            return "compare it, for example with `<> 0`"
        name = functions.conversion(got, wanted)
        if functions.is_function(name):
            return f"convert it by `{name}(...)`"
    return ""


def short_circuit(diagnostics: Diagnostics, span: Span, name: str) -> None:
    how = "behind each other, `[a] [b]`" if name == "AND_THEN" else "into branches"
    diagnostics.error("LD0517", f"{name} stands in Structured Text only", span, "used outside of statements",
                      help=f"a contact is evaluated where power reaches it: draw the two {how}; or write "
                      f"{name.partition('_')[0]}, which evaluates both")


def described(type_: Type) -> str:
    """The type in words."""
    match type_:
        case Instance():
            return f"an instance of {type_}"
        case Array():
            return "an " + str(type_)
        case Struct():
            return f"a structure {type_}"
        case Enum():
            return f"a value of {type_}" if type_.name else f"a value of the enumeration {type_}"
    return str(type_)


def unknown_name(diagnostics: Diagnostics, span: Span, name: str, help: str) -> None:
    diagnostics.error("LD0404", f"there is no variable `{name}` here", span, "unknown name",
                      help=help or "declare it in a VAR block")


def not_a_value(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str = "") -> None:
    diagnostics.error("LD0405", message, span, label, help=help)


def unknown_member(diagnostics: Diagnostics, span: Span, type_: Type, name: str, help: str) -> None:
    diagnostics.error("LD0406", f"{described(type_)} has no member `{name}`", span, "unknown member",
                      help=help)


def bad_index(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str = "") -> None:
    diagnostics.error("LD0407", message, span, label, help=help)


def out_of_bounds(diagnostics: Diagnostics, span: Span, value: int, low: int, high: int) -> None:
    diagnostics.error("LD0408", f"index {value} is outside of the array", span,
                      f"the array goes from {low} to {high}", help="choose an index within the bounds")


def bad_bit(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str = "") -> None:
    diagnostics.error("LD0409", message, span, label, help=help)


def no_such_operation(diagnostics: Diagnostics, span: Span, reason: str, help: str = "") -> None:
    diagnostics.error("LD0410", reason, span, "these types do not go together", help=help)


def division_by_zero(diagnostics: Diagnostics, span: Span) -> None:
    diagnostics.error("LD0411", "division by zero", span, "is always zero",
                      help="divide by something else, or test the divisor before")


def bad_enum_value(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0412", message, span, label, help=help)


def modifier_on_expression(diagnostics: Diagnostics, span: Span, modifier: str, text: str) -> None:
    if modifier == "/":
        message, help = "a closed contact needs a variable", f"write `[NOT ({text})]`"
    else:
        message = "an edge contact needs a variable"
        help = f"put `{text}` into a BOOL variable by a coil and write `[{modifier} variable]`"
    diagnostics.error("LD0413", message, span, "this is an expression", help=help)


def unknown_type_prefix(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.error("LD0414", f"there is no enumeration `{name}`", span, "unknown type",
                      help=f"declare it, `TYPE {name} : (value, value); END_TYPE`, or correct the name")


def enumerated(diagnostics: Diagnostics, span: Span, type_: Type, wanted: Type) -> None:
    """A value of an enumeration is taken for a number, or the other way round."""
    back = isinstance(wanted, Enum)
    diagnostics.warning("LD0241", f"{described(type_)} counts as {described(wanted)} here", span, "converted",
                        help="IEC 61131-3 has no such conversion, other editors make it: "
                             + ("name one of its values" if back else f"`TO_{wanted}(...)` says it"))


def counted(diagnostics: Diagnostics, span: Span, type_: Type, number: Type) -> None:
    """A bit string is taken for a number, or the other way round."""
    diagnostics.warning("LD0240", f"{type_} counts as {number} here", span, "converted",
                        help="IEC 61131-3 has no such conversion, other editors make it: "
                             f"`{type_}_TO_{number}(...)` says it")
