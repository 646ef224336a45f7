"""The findings about blocks, calls and pins, LD05xx, and doubled coils: one function raises each code."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.diagnostics import Diagnostics, Label
from ldc.source import Span


def unknown_callee(diagnostics: Diagnostics, span: Span, name: str, help: str) -> None:
    diagnostics.error("LD0501", f"there is no function or function block `{name}`", span, "unknown",
                      help=help)


def block_of_unknown_type(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.note("LD0158", f"a block of the unknown type `{name}` is not compiled", span, "drawn here",
                     help="its declaration is told as an error: the type is in none of the files")


def bits_kept(diagnostics: Diagnostics, span: Span, function: str) -> None:
    source, _, target = function.partition("_TO_")
    number = "UDINT" if "DWORD" in function else "ULINT"
    diagnostics.note("LD0170", f"{function} keeps the bits", span, "the pattern, not the number",
                     help=f"for the number write {number}_TO_{target}({source}_TO_{number}(x))")


def wrong_kind(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0502", message, span, label, help=help)


def not_writable(
    diagnostics: Diagnostics, span: Span, name: str, why: str, help: str, declared: Span | None
) -> None:
    secondary = (Label(declared, "declared here"),) if declared else ()
    diagnostics.error("LD0503", f"`{name}` cannot be written", span, why, secondary=secondary, help=help)


def own_input(diagnostics: Diagnostics, span: Span, name: str, declared: Span | None) -> None:
    secondary = (Label(declared, "declared here"),) if declared else ()
    diagnostics.warning("LD0161", f"the input `{name}` is written inside of its POU", span,
                        "lasts until a call gives it again", secondary=secondary,
                        help="make it VAR_IN_OUT, or copy it to a variable of its own")


def instance_mismatch(
    diagnostics: Diagnostics, span: Span, instance: str, declared: str, written: str, first: Span | None,
    help: str,
) -> None:
    secondary = (Label(first, f"declared as {declared}"),) if first else ()
    diagnostics.error("LD0504", f"`{instance}` is {declared}, not {written}", span,
                      f"`{written}` is written here", secondary=secondary, help=help)


def unknown_pin(diagnostics: Diagnostics, span: Span, block: str, pin: str, help: str) -> None:
    diagnostics.error("LD0505", f"`{block}` has no pin `{pin}`", span, "unknown pin", help=help)


def pin_twice(
    diagnostics: Diagnostics, span: Span, pin: str, label: str, first: Span | None, help: str
) -> None:
    secondary = (Label(first, "first given here"),) if first else ()
    diagnostics.error("LD0506", f"pin `{pin}` is fed twice", span, label, secondary=secondary, help=help)


def pin_missing(diagnostics: Diagnostics, span: Span, block: str, pins: Iterable[str], help: str) -> None:
    names = ", ".join(f"`{pin}`" for pin in pins)
    diagnostics.error("LD0507", f"`{block}` needs {names}", span, "not given", help=help)


def left_out(diagnostics: Diagnostics, span: Span, function: str, pins: Iterable[str]) -> None:
    names = ", ".join(f"`{pin}`" for pin in pins)
    diagnostics.warning("LD0171", f"`{function}` is called without {names}", span,
                        "the default of the type is taken",
                        help="give a value, or declare an initial one")


def wrong_direction(diagnostics: Diagnostics, span: Span, pin: str, is_output: bool) -> None:
    if is_output:
        what, label, help = "an output", "written as an input", f"write `{pin} => variable`"
    else:
        what, label, help = "an input", "written as an output", f"write `{pin} := value`"
    diagnostics.error("LD0508", f"pin `{pin}` is {what}", span, label, help=help)


def too_many(diagnostics: Diagnostics, span: Span, block: str, most: int) -> None:
    values = "1 value" if most == 1 else f"{most} values"
    diagnostics.error("LD0509", f"`{block}` takes {values} without a name", span, "one too many",
                      help="leave it out, or name its pin")


def bad_power_pin(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0510", message, span, label, help=help)


def bad_in_out(diagnostics: Diagnostics, span: Span, pin: str, label: str, help: str,
               changed: bool = True) -> None:
    """``changed``: False for an input that takes an instance, to read it."""
    what = "is VAR_IN_OUT" if changed else "takes an instance"
    diagnostics.error("LD0511", f"pin `{pin}` {what} and needs a variable of its own type", span,
                      label, help=help)


def only_read(diagnostics: Diagnostics, span: Span, name: str, why: str, help: str) -> None:
    """An instance that is called or changed where it can only be read."""
    diagnostics.error("LD0244", f"`{name}` can only be read here", span, why, help=help)


def mixed_arguments(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.error("LD0512", f"call of `{name}` mixes values with and without names", span,
                      "this one has no name", help="name all inputs, or none")


def network_on_value_pin(diagnostics: Diagnostics, span: Span, pin: str, type_: str) -> None:
    diagnostics.error("LD0513", f"pin `{pin}` is {type_}, a ladder network gives a BOOL", span, "a network",
                      help="feed it with a variable, an expression or a junction that carries a value")


def outputs_in_expression(diagnostics: Diagnostics, span: Span, message: str, label: str) -> None:
    diagnostics.error("LD0514", message, span, label,
                      help="write the call as a block of the rung, or as a statement of its own")


def unknown_label(diagnostics: Diagnostics, span: Span, label: str, help: str) -> None:
    diagnostics.error("LD0515", f"no rung is named `{label}`", span, "unknown label",
                      help=help or "give the rung to jump to a name: `RUNG name`")


def no_memory(diagnostics: Diagnostics, span: Span, pou: str, what: str) -> None:
    diagnostics.error("LD0516", f"FUNCTION `{pou}` cannot hold {what}", span,
                      "needs memory between two calls",
                      help="make it a FUNCTION_BLOCK: a FUNCTION has no memory")


def not_reached(diagnostics: Diagnostics, span: Span, path: str, why: str) -> None:
    diagnostics.error("LD0520", f"`{path}` cannot be reached", span, why,
                      help="a path leads to a variable of a program that runs once; declare what several "
                      "programs use in VAR_GLOBAL")


def action_calls_itself(diagnostics: Diagnostics, span: Span | None, names: list[str]) -> None:
    diagnostics.error("LD0518", f"action `{names[0]}` calls itself: {' -> '.join(names)}", span,
                      "called here while it is executed", help="repeat with FOR or WHILE instead")


def actions_too_large(diagnostics: Diagnostics, span: Span | None, most: int) -> None:
    diagnostics.error("LD0519", f"the actions of this POU take more than {most:,} instructions", span,
                      "this call is too many", help="an action is put in where it is called: make one that "
                      "is called from many places a FUNCTION_BLOCK")


def duplicate_coil(diagnostics: Diagnostics, span: Span, place: str, first: Span, coils: int) -> None:
    count = "more than one coil" if coils == 2 else f"{coils} coils"
    diagnostics.warning("LD0310", f"`{place}` is written by {count}", span, "written again here",
                        secondary=(Label(first, "first written here"),),
                        help="the last coil wins: join the conditions in one rung, or use (S ..) and (R ..)")
