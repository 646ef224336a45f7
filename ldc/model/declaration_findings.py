"""The findings about declarations, LD02xx: one function raises each code."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.diagnostics import Diagnostics, Label
from ldc.source import Span


def head(span: Span) -> Span:
    """The first line of what a span covers: the head of a POU or type is enough to show it."""
    end = span.source.text.find("\n", span.start, span.end)
    return span if end < 0 else Span(span.source, span.start, end)


def duplicate(diagnostics: Diagnostics, span: Span | None, name: str, what: str, first: Span | None) -> None:
    secondary = (Label(head(first), "first declared here"),) if first else ()
    diagnostics.error("LD0201", f"{what} `{name}` is declared twice", head(span) if span else None,
                      "declared again here", secondary=secondary,
                      help="rename one of the two; upper and lower case are the same")


def reserved_prefix(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.error("LD0202", f"`{name}` begins with `_ldc_`", span, "this prefix belongs to the compiler",
                      help="choose another name")


def reserved_name(diagnostics: Diagnostics, span: Span, name: str, why: str) -> None:
    diagnostics.error("LD0203", f"`{name}` is already {why}", span, "this name is taken",
                      help="choose another name")


def shadowing_name(diagnostics: Diagnostics, span: Span, name: str, why: str) -> None:
    diagnostics.warning("LD0204", f"variable `{name}` has the name of {why}", span, "is allowed here",
                        help="rename it when the program is to be read by other IEC 61131-3 tools: "
                             "most of them refuse it")


def own_standard(diagnostics: Diagnostics, span: Span, name: str, what: str, made: str) -> None:
    diagnostics.warning("LD0180", f"`{name}` takes the place of {what}", span,
                        f"is meant wherever the project says it, and called `{made}` in what is compiled",
                        help="give it a name of its own when the program is to be read by other IEC 61131-3 "
                             "tools: "
                             "some of them refuse it")


def unknown_type(diagnostics: Diagnostics, span: Span, name: str, help: str) -> None:
    diagnostics.error("LD0205", f"there is no type or function block `{name}`", span, "unknown type",
                      help=help or "declare it in TYPE ... END_TYPE or as a FUNCTION_BLOCK")


def recursive_type(diagnostics: Diagnostics, span: Span, names: Iterable[str]) -> None:
    cycle = " -> ".join(names)
    diagnostics.error("LD0206", f"type contains itself: {cycle}", head(span), "leads back to itself",
                      help="take the type out of itself; a list of elements is an ARRAY")


def not_constant(diagnostics: Diagnostics, span: Span, what: str, label: str = "", help: str = "") -> None:
    diagnostics.error("LD0207", f"{what} must be constant", span, label or "known only at run time",
                      help=help or "use literals, enumeration values and VAR CONSTANT variables only")


def bad_bounds(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str = "") -> None:
    diagnostics.error("LD0208", message, span, label, help=help)


def too_large(diagnostics: Diagnostics, span: Span, count: int, most: int) -> None:
    shown = f"{count:,}" if count < 10**12 else "so many"
    _too_large(diagnostics, span, f"a type of {shown} elements is too large",
               f"at most {most:,} are possible",
               "make the array smaller or divide it")


def too_much_data(diagnostics: Diagnostics, span: Span | None, name: str, most: int) -> None:
    """A variable with which all data of a POU become too large."""
    _too_large(diagnostics, span, f"with `{name}` there are more than {most:,} values here",
               "counted with all that is in it", "make arrays smaller, or use fewer instances in one another")


def _too_large(diagnostics: Diagnostics, span: Span | None, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0209", message, span, label, help=help)


def bad_initial(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str = "") -> None:
    diagnostics.error("LD0210", message, span, label, help=help)


def bad_address(diagnostics: Diagnostics, span: Span, address: str, label: str, help: str) -> None:
    diagnostics.error("LD0211", f"`{address}` is no address of this controller", span, label, help=help)


def wrong_width(diagnostics: Diagnostics, span: Span, address: str, bits: int, type_: str, help: str) -> None:
    diagnostics.error("LD0212", f"`{address}` does not fit the type {type_}", span,
                      f"{bits} bit{'s' if bits > 1 else ''}", help=help)


def location_not_allowed(diagnostics: Diagnostics, span: Span, name: str, where: str) -> None:
    diagnostics.error("LD0213", f"`{name}` may not have an address in {where}", span,
                      "AT is not possible here",
                      help="declare it with AT in a PROGRAM or in VAR_GLOBAL and pass it in by a pin")


def no_bounds(diagnostics: Diagnostics, span: Span) -> None:
    """ARRAY [*] where no call gives an array."""
    diagnostics.error("LD0242", "this array has no bounds", span, "no call decides them here",
                      help="write the bounds, `ARRAY [0..9] OF ...`; `*` stands in parameters of a "
                           "FUNCTION, and in "
                           "VAR_IN_OUT and VAR_INPUT of a FUNCTION_BLOCK")


def other_bounds(diagnostics: Diagnostics, span: Span, instance: str, first: Span) -> None:
    """An instance whose calls give arrays of several shapes."""
    diagnostics.error("LD0243", f"`{instance}` is called with arrays of other bounds", span,
                      "other bounds here",
                      secondary=[Label(first, "called first here")],
                      help="an instance keeps arrays of one size: declare an instance for each")


def no_place(diagnostics: Diagnostics, span: Span, path: str, address: str, type_: str) -> None:
    """An address that was left open for VAR_CONFIG, and that nobody completes."""
    diagnostics.warning("LD0238", f"nobody gives `{path}` its address", span,
                        f"AT {address} is open; the variable is in memory",
                        help="elements of arrays are alike and get none: declare instances with names of "
                             "their own"
                        if "[" in path
                        else f"write `VAR_CONFIG {path} AT %{address[1]}... : {type_}; END_VAR`")


def bad_configured(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    """A line of VAR_CONFIG that fits no instance."""
    diagnostics.error("LD0239", message, span, label, help=help)


def overlapping_outputs(
    diagnostics: Diagnostics, span: Span, name: str, address: str, other: str, first: Span | None
) -> None:
    secondary = (Label(first, f"`{other}` is here"),) if first else ()
    diagnostics.warning("LD0214", f"outputs `{name}` and `{other}` share bits of the output image", span,
                        f"{address} overlaps", secondary=secondary,
                        help="give each output its own address, or use one variable for both")


def bad_external(
    diagnostics: Diagnostics, span: Span, message: str, label: str, first: Span | None, help: str
) -> None:
    secondary = (Label(first, "the global variable"),) if first else ()
    diagnostics.error("LD0215", message, span, label, secondary=secondary, help=help)


def recursion(diagnostics: Diagnostics, span: Span, names: list[str], calls: Iterable[Label]) -> None:
    diagnostics.error("LD0216", f"POUs call each other in a circle: {' -> '.join(names)}", head(span),
                      f"`{names[0]}` needs itself", secondary=calls,
                      help="IEC 61131-3 forbids recursion; write a loop in ST, or take the call out")


def not_allowed_here(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0217", message, span, label, help=help)


def cannot_be_lent(diagnostics: Diagnostics, span: Span, name: str, why: str) -> None:
    """A pin for instances that are bound to where they are declared."""
    diagnostics.error("LD0245", f"instances at `{name}` cannot be handed over", span, why,
                      help="call the instance where it is declared, and hand over its outputs")


def bad_edge(diagnostics: Diagnostics, span: Span, name: str, word: str, where: str) -> None:
    diagnostics.error("LD0236", f"`{name}` cannot have {word}", span, where,
                      help="an edge is that of a BOOL in VAR_INPUT of a FUNCTION_BLOCK; elsewhere use an "
                      "instance of R_TRIG or F_TRIG")


def program_as_type(diagnostics: Diagnostics, span: Span, name: str, kind: str) -> None:
    diagnostics.error("LD0218", f"{kind} `{name}` is no type", span,
                      "a type or a function block is needed here",
                      help="make it a FUNCTION_BLOCK" if kind == "PROGRAM"
                      else "a FUNCTION is called, it has no instances")


def several_configurations(diagnostics: Diagnostics, span: Span, name: str, first: Span) -> None:
    diagnostics.error("LD0219", f"a second CONFIGURATION `{name}`", head(span),
                      "a project has one configuration", secondary=(Label(head(first), "the first one"),),
                      help="put its resources into the first one, or leave one file out")


def unknown_in_configuration(
    diagnostics: Diagnostics, span: Span | None, what: str, name: str, help: str
) -> None:
    diagnostics.error("LD0220", f"there is no {what} `{name}`", span, f"unknown {what}", help=help)


def called_program(diagnostics: Diagnostics, span: Span | None, name: str) -> None:
    """A task of ldc.toml runs a PROGRAM that others call."""
    bad_task(diagnostics, span, f"`{name}` is called by other POUs, and runs where it is called",
             "run by a task",
             "leave it out of the tasks; a CONFIGURATION in the text may run it besides")


def bad_task(diagnostics: Diagnostics, span: Span | None, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0221", message, span, label, help=help)


def circular_constant(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.error("LD0222", f"the declaration of `{name}` needs `{name}` itself", span,
                      "goes in a circle", help="give it a value that does not depend on itself")


def never_run(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.warning("LD0223", f"no task runs PROGRAM `{name}`", head(span), "is never executed",
                        help="add an instance of it to the CONFIGURATION, or it to a task or the modules in "
                             "ldc.toml")


def bad_safe_value(diagnostics: Diagnostics, path: str, help: str) -> None:
    diagnostics.error("LD0224", f"safe value of `{path}`: there is no such output or variable", help=help)


def nested_too_deep(diagnostics: Diagnostics, span: Span, what: str, most: int) -> None:
    diagnostics.error("LD0225", f"{what} is nested too deep", head(span), f"more than {most} levels",
                      help="make the chain of declarations shorter, or declare what is used before its use")
