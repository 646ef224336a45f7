"""Which pin of a block gets what: power, pins by name and by position, defaults (DESIGN section 2)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ldc.diagnostics import Diagnostics
from ldc.expr import Const, Place
from ldc.model import call_findings as findings
from ldc.model import calls
from ldc.model.elements import Block, PinIn, PinOut
from ldc.model.environment import Environment
from ldc.model.names import suggest
from ldc.model.pins import NetOf, pin_in, pin_in_out, pin_out
from ldc.model.values import Value
from ldc.parser import ast
from ldc.symbols import ACTION, Parameter, Signature
from ldc.types import BOOL, storage

EN, ENO = Parameter("EN", BOOL), Parameter("ENO", BOOL)
NOT_WIRED = "_"


class Wiring:
    """The pins of one block. ``values``: values at pins that are typed already, by identity of the pin."""

    def __init__(
        self, env: Environment, node: ast.Block, signature: Signature, net_of: NetOf,
        diagnostics: Diagnostics, values: Mapping[int, Value] | None = None,
    ) -> None:
        self.env, self.node, self.signature = env, node, signature
        self.net_of, self.diagnostics, self.values = net_of, diagnostics, values or {}
        self.is_function = signature.kind in ("FUNCTION", ACTION)
        self.inputs, self.outputs, self.in_outs = signature.inputs, signature.outputs, signature.in_outs
        if self.is_function:
            self.inputs = (EN, *self.inputs)
            result = () if signature.result is None else (Parameter("OUT", signature.result),)
            self.outputs = (ENO, *result, *self.outputs)
        self.failed = False

    def function(self) -> Block | None:
        """A function: EN and ENO carry the power unless chosen otherwise, every other input is needed."""
        power_in = self._power(self.node.power_in, self.inputs, "in", EN)
        power_out = self._power(self.node.power_out, self.outputs, "out", ENO)
        if self.failed:
            return None
        given = self._given(power_in)
        if given is None:
            return None
        unset: list[PinIn] = []
        missing, bare = [], []
        named = calls.by_name(self.env, self.node.pins)
        for parameter in self.signature.inputs:
            if parameter.name in given or parameter is power_in:
                continue
            value = calls.default_argument(parameter, named)
            if value is None:
                missing.append(parameter.name)
            else:
                if parameter.initial is None:
                    bare.append(parameter.name)
                unset.append(PinIn(parameter.name, parameter.type, value, self.node.span))
        missing += [p.name for p in self.in_outs if p.name not in given]
        if bare and not missing:
            findings.left_out(self.diagnostics, self.node.span, self.signature.name, bare)
        if missing:
            findings.pin_missing(self.diagnostics, self.node.span, self.signature.name, missing,
                                 "give a value to every input that has no initial value")
            return None
        return self._block(None, given, unset, power_in, power_out)

    def function_block(self, instance: Place) -> Block | None:
        """A function block: power goes by the first BOOL input and output unless chosen otherwise."""
        power_in = self._power(self.node.power_in, self.inputs, "in", None)
        power_out = self._power(self.node.power_out, self.outputs, "out", None)
        if self.failed:
            return None
        given = self._given(power_in)
        if given is None:
            return None
        missing = [p.name for p in self.in_outs if p.name not in given]
        if missing:
            findings.pin_missing(self.diagnostics, self.node.span, self.signature.name, missing,
                                 "a VAR_IN_OUT pin needs a variable: write `pin := variable`")
            return None
        return self._block(instance, given, [], power_in, power_out)

    def _power(
        self, chosen: str | None, pins: Iterable[Parameter], word: str, usual: Parameter | None
    ) -> Parameter | None:
        """The pin that the power goes by; None: not wired. Sets ``failed`` after an error."""
        if chosen == NOT_WIRED:
            return None
        side = "input" if word == "in" else "output"
        name = self.signature.name
        bools = [p for p in pins if storage(p.type) == BOOL]
        if chosen is None:
            usual = usual or next(iter(bools), None)
            if usual is None:
                self.failed = True
                if not self.env.silent_pin(name.upper(), ""):
                    findings.bad_power_pin(
                        self.diagnostics, self.node.span, f"`{name}` has no BOOL {side} for the power",
                        "the power cannot " + ("enter" if word == "in" else "leave"),
                        f"write `{word}=_` before the `>` to leave the power unconnected")
            return usual
        key = self._key(chosen)
        found = next((p for p in pins if p.name.upper() == key), None)
        if found is not None and storage(found.type) == BOOL:
            return found
        self.failed = True
        if found is None and self.env.silent_pin(name.upper(), key):
            return None
        choices = ", ".join(f"`{word}={p.name}`" for p in bools)
        findings.bad_power_pin(
            self.diagnostics, self.node.span, f"power cannot use the pin `{chosen}` of `{name}`",
            f"there is no such {side}" if found is None else f"`{found.name}` is {found.type}, not BOOL",
            f"write {choices} or `{word}=_`" if choices else f"write `{word}=_`")
        return None

    def _given(self, power_in: Parameter | None) -> dict[str, ast.Pin] | None:
        """The pins as written, by the declared name of the pin."""
        given: dict[str, ast.Pin] = {}
        values = self.signature.positional if self.env.statements else self.signature.inputs
        by_position = iter([p for p in values if p is not power_in])
        taken = 0
        for pin in self.node.pins:
            if pin.name is None:
                parameter = next(by_position, None)
                if parameter is None:
                    findings.too_many(self.diagnostics, pin.span, self.signature.name, taken)
                    self.failed = True
                    continue
                taken += 1
            else:
                parameter = self._named(pin)
                if parameter is None:
                    self.failed = True
                    continue
            name = parameter.name
            if parameter is power_in:
                findings.pin_twice(self.diagnostics, pin.span, name, "the power of the rung feeds it already",
                                   None, self._power_help(name))
                self.failed = True
            elif name in given:
                findings.pin_twice(self.diagnostics, pin.span, name, "given again here", given[name].span,
                                   "give it once")
                self.failed = True
            else:
                given[name] = pin
        return None if self.failed else given

    def _power_help(self, pin: str) -> str:
        others = [p.name for p in self.inputs if storage(p.type) == BOOL and p.name != pin]
        return "leave it out, or let the power enter elsewhere: " + " or ".join(
            f"`in={name}`" for name in (*others, NOT_WIRED))

    def _key(self, name: str) -> str:
        """The declared name of a pin, in capitals, for each name that it has."""
        known = self.signature.pin(name)
        return (name if known is None else known.name).upper()

    def _named(self, pin: ast.Pin) -> Parameter | None:
        key = self._key(pin.name)
        for group, is_output in ((self.inputs, False), (self.outputs, True), (self.in_outs, False)):
            for parameter in group:
                if parameter.name.upper() == key:
                    if is_output == pin.output:
                        return parameter
                    if group is self.in_outs:
                        findings.bad_in_out(self.diagnostics, pin.span, parameter.name, "written with `=>`",
                                            f"write `{parameter.name} := variable`: it is copied in and out")
                    else:
                        findings.wrong_direction(self.diagnostics, pin.span, parameter.name, is_output)
                    return None
        if not self.env.silent_pin(self.signature.name.upper(), key):
            names = [p.name for p in (*self.inputs, *self.outputs, *self.in_outs)]
            findings.unknown_pin(self.diagnostics, pin.span, self.signature.name, pin.name,
                                 suggest(pin.name, names) or calls.pins_help(names))
        return None

    def _block(
        self, instance: Place | None, given: dict[str, ast.Pin], unset: list[PinIn],
        power_in: Parameter | None, power_out: Parameter | None,
    ) -> Block | None:
        """The pins in declared order; an in_out pin is read before the call and written after it. Of a function
        block they are written before its outputs are taken, those with computed indexes first: the element that
        was given is written, though the call changes the index."""
        inputs: dict[str, PinIn | None] = {pin.pin: pin for pin in unset}
        outputs: list[PinOut | None] = []
        copied: list[PinOut | None] = []
        for parameter in self.inputs:
            if (pin := given.get(parameter.name)) is not None:
                inputs[parameter.name] = pin_in(self.env, pin, parameter, self.net_of, self.diagnostics,
                                                self.values.get(id(pin)))
        for parameter in self.outputs:
            if (pin := given.get(parameter.name)) is not None:
                outputs.append(pin_out(self.env, pin, parameter, self.net_of, self.diagnostics))
        for parameter in self.in_outs:
            both = pin_in_out(self.env, given[parameter.name], parameter, self.diagnostics)
            inputs[parameter.name], copy = both or (None, None)
            copied.append(copy)
        if None in inputs.values() or None in outputs or None in copied:
            return None
        copied.sort(key=lambda pin: instance is not None and all(
            isinstance(index, Const) for index in pin.target.indexes()))
        outputs = outputs + copied if instance is None else copied + outputs
        ordered = tuple(inputs[p.name] for p in (*self.inputs, *self.in_outs) if p.name in inputs)
        return Block(self.signature.name.upper(), self.signature, instance, ordered, tuple(outputs),
                     power_in.name if power_in is not None else None,
                     power_out.name if power_out is not None else None, self.node.span)
