"""What can be wrong with components, LD10xx: one function raises each code."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics, Label
from ldc.source import Span


def missing_key(diagnostics: Diagnostics, span: Span, where: str, key: str) -> None:
    diagnostics.error(
        "LD1001",
        f"{where} has no `{key}`",
        span,
        "it is missing here",
        help=f"write {key} = ...; `ldc component new` shows a whole descriptor",
    )


def pin_twice(diagnostics: Diagnostics, span: Span, name: str, first: Span) -> None:
    diagnostics.error(
        "LD1002",
        f"`{name}` is there twice",
        span,
        "a second one",
        secondary=(Label(first, "the first one"),),
        help="inputs, outputs, parameters and state share one set of names, in any case of the letters",
    )


def reserved_pin(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.error(
        "LD1003",
        f"a pin cannot be called `{name}`",
        span,
        "a reserved name",
        help="enable, ENO, error and elapsed are names that every component has by itself",
    )


def no_body(diagnostics: Diagnostics, span: Span, name: str, count: int) -> None:
    what = "have none" if not count else f"have {count}"
    diagnostics.error(
        "LD1004",
        f"the sources of component {name} {what} of its bodies",
        span,
        "named here",
        help=f"one of them holds FUNCTION_BLOCK {name} ... END_FUNCTION_BLOCK with its VARs and its body",
    )


def pins_in_body(diagnostics: Diagnostics, span: Span, kind: str, name: str) -> None:
    diagnostics.error(
        "LD1005",
        f"the pins of component {name} are those of its descriptor",
        span,
        f"{kind} declares others",
        help="keep VAR and VAR_TEMP here; inputs, outputs and parameters stand in the .ldc.toml file",
    )


def twice(diagnostics: Diagnostics, span: Span, what: str, first: Span) -> None:
    diagnostics.error(
        "LD1006",
        f"two components have the {what}",
        span,
        "the second one",
        secondary=(Label(first, "the first one"),),
        help="rename one of them",
    )


def no_source(diagnostics: Diagnostics, span: Span, name: str, source: str, why: str) -> None:
    diagnostics.error(
        "LD1007",
        f"component {name} has no source `{source}`",
        span,
        why,
        help="sources are named relative to the folder of the descriptor and lie inside of it",
    )


def no_c_type(diagnostics: Diagnostics, span: Span, pin: str, type_: str) -> None:
    diagnostics.error(
        "LD1008",
        f"pin `{pin}` has a type that C does not get: {type_}",
        span,
        "of this type",
        help="pins of C and C++ components are BOOL, integers, bit strings, REAL, LREAL, TIME, "
        "STRING and arrays of these",
    )


def broken_package(diagnostics: Diagnostics, name: str, value: str, why: str) -> None:
    diagnostics.warning(
        "LD1009",
        f"the components of `{name}` cannot be found",
        None,
        help=f"its entry point names the package {value}: {why}; install it again",
    )


def no_tool(diagnostics: Diagnostics, command: str, purpose: str, package: str, variable: str) -> None:
    diagnostics.error(
        "LD1010",
        f"`{command}` is not installed: it {purpose}",
        None,
        help=f"apt-get install {package}, or set {variable} to another one",
    )


def compiler(diagnostics: Diagnostics, span: Span, message: str, warning: bool) -> None:
    report = diagnostics.warning if warning else diagnostics.error
    report(
        "LD1011",
        f"C compiler: {message}",
        span,
        "here",
        help="see docs/components.md for what a component may use",
    )


def c_syntax(diagnostics: Diagnostics, span: Span, message: str) -> None:
    diagnostics.error(
        "LD1012",
        f"this C cannot be read: {message}",
        span,
        "reading stops here",
        help="components are C11 without extensions of one compiler",
    )


def static_data(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.error(
        "LD1013",
        f"`{name}` would keep its value outside of the component's state",
        span,
        "static data",
        help="declare it under state in the descriptor, or make it const",
    )


def raw_address(diagnostics: Diagnostics, span: Span, text: str) -> None:
    diagnostics.error(
        "LD1014",
        f"the number {text} is used as an address",
        span,
        "a raw address",
        help="name the memory by its symbol: PLC_M(flag), PLC_D(position), LCD(speed)",
    )


def unknown_symbol(
    diagnostics: Diagnostics, span: Span, macro: str, name: str, close: list[str], processor: str
) -> None:
    help = (
        f"did you mean {' or '.join(f'`{c}`' for c in close)}?"
        if close
        else (f"{macro} reaches the global variables of the project that {processor} has")
    )
    diagnostics.error(
        "LD1015", f"{processor} has no `{name}` for {macro}", span, "not in its address map", help=help
    )


def wrong_macro(diagnostics: Diagnostics, span: Span, macro: str) -> None:
    _misused(
        diagnostics,
        span,
        f"{macro} takes the name of one symbol",
        "used differently here",
        f"write {macro}(name)",
    )


def address_of(diagnostics: Diagnostics, span: Span, name: str) -> None:
    _misused(
        diagnostics,
        span,
        f"the address of `{name}` cannot be taken",
        "a bit has none",
        "copy it into a variable",
    )


def _misused(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD1016", message, span, label, help=help)


def no_write(
    diagnostics: Diagnostics, span: Span, name: str, area: str, processor: str, writers: str
) -> None:
    _not_owned(
        diagnostics,
        span,
        f"{processor} may not write `{name}`",
        f"area {area} is written by {writers}",
        "every word of memory has one writer: give the value back as an output of the component",
    )


def no_access(
    diagnostics: Diagnostics, span: Span, name: str, area: str, processor: str, readers: str
) -> None:
    _not_owned(
        diagnostics,
        span,
        f"{processor} cannot reach `{name}`",
        f"area {area} belongs to {readers}",
        "make it an input of the component: then it is sent to the processor",
    )


def _not_owned(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD1017", message, span, label, help=help)


def no_entry(diagnostics: Diagnostics, span: Span, entry: str, component: str) -> None:
    diagnostics.error(
        "LD1018",
        f"component {component} has no function `{entry}`",
        span,
        "named here",
        help=f"define void {entry}(const {entry}_in *in, {entry}_out *out, {entry}_state *state, "
        "uint32_t dt_us)",
    )


def cannot_write(diagnostics: Diagnostics, path: str, why: str) -> None:
    diagnostics.error(
        "LD1019",
        f"cannot write into `{path}`: {why}",
        None,
        help="compiled components are kept there; XDG_CACHE_HOME names another folder",
    )


def no_transfer(diagnostics: Diagnostics, span: Span, pin: str, type_: str) -> None:
    diagnostics.error(
        "LD1020",
        f"pin `{pin}` of an algorithm has a type that is not sent between processors: {type_}",
        span,
        "of this type",
        help="BOOL, REAL, LREAL (as REAL), integers and bit strings of up to 32 bits are sent; without "
        "period_us the component is called, and all types are possible",
    )


def local_without_pace(diagnostics: Diagnostics, span: Span, pin: str) -> None:
    diagnostics.error(
        "LD1021",
        f"pin `{pin}` is local, and no slave executes this component by itself",
        span,
        "wired on a slave",
        help="give [function] a processor (slave, slave1 to slave4) and a period_us, or leave `local` out",
    )


def no_slot(diagnostics: Diagnostics, span: Span, name: str, path: str, slave: int, slots: int) -> None:
    diagnostics.error(
        "LD1022",
        f"slave{slave} has no room for the algorithm `{path}`",
        span,
        f"{name} takes {128 * slots} bytes in each direction",
        help="a slave has 32 slots and 4096 bytes: execute some instances on another one, or give "
        "components fewer pins",
    )


def no_such_slave(diagnostics: Diagnostics, span: Span, name: str, processor: str, slaves: str) -> None:
    diagnostics.note(
        "LD1023",
        f"component {name} is called by the master: the project has no {processor}",
        span,
        "made for this processor",
        help=f"its slaves are {slaves}; [processors] in ldc.toml names them",
    )


def called_here(diagnostics: Diagnostics, span: Span, name: str, target: str) -> None:
    diagnostics.note(
        "LD1024",
        f"component {name} is called in every scan on {target}",
        span,
        "its own pace",
        help="algorithms at their own pace run on this computer; firmware calls components and waits for "
        "them",
    )


def memory_of_master(
    diagnostics: Diagnostics, span: Span, name: str, component: str, slave: int
) -> None:
    diagnostics.error(
        "LD1025",
        f"slave{slave} has no `{name}`: it belongs to the master",
        span,
        f"named by {component}, which this slave executes by itself",
        help="make it a pin of the component",
    )
