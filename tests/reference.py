"""The oracle: a slow interpreter that runs a project on its drawings, nothing compiled.

It does what ``ldc.graph.evaluate`` says on the graphs, with Python values: functions mean what the
library says, standard blocks are the models of ``models.py``, other blocks are run from their own
drawings, jumps go from rung to rung. Every engine must give the same values after every scan.

``ReferenceMachine(model, graphs).scan(now_ns)``; ``set`` and ``get`` take paths like ``main.warm.Q``,
``warm.Q`` (with one program), ``level``, ``many[2]``, ``%QX0.1``.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Mapping, Sequence
from typing import Any

from reference_domain import Concrete, Fault, Standard

from ldc.expr import Apply, Const, Expr, FieldStep, IndexStep, Load, Place
from ldc.graph.evaluate import evaluate
from ldc.graph.memory import memories
from ldc.graph.order import schedule
from ldc.graph.rung import RungGraph
from ldc.library import blocks, functions
from ldc.library.faults import DivisionByZero
from ldc.model.project import Model
from ldc.symbols import Location, Variable
from ldc.types import BOOL, Array, Instance, String, Struct, Type, default, storage


class Frame:
    """An instance: values by name in capitals; located and global ones lie elsewhere."""

    def __init__(self, machine: ReferenceMachine, pou: str, name: str) -> None:
        self.pou, self.name = pou, name
        self.hidden: dict[str, Any] = {}
        known = machine.model
        self.variables: Mapping[str, Variable] = known.pous[pou].variables if pou else known.globals
        self.values = {key: machine.fresh(v.type, v.initial) for key, v in self.variables.items()
                       if v.kind != "external" and v.location is None}
        for variable in self.variables.values():
            if variable.location is not None and variable.initial is not None:
                machine.write_image(variable.location, variable.type, variable.initial)


class ReferenceMachine:
    """``graphs``: the drawings of each POU by its name in capitals, in order."""

    def __init__(self, model: Model, graphs: Mapping[str, Sequence[RungGraph]]) -> None:
        self.model = model
        self.graphs = {name.upper(): tuple(rungs) for name, rungs in graphs.items()}
        self.now = 0
        self.first_scan = True
        self.image = {area: bytearray(model.image_bytes) for area in "IQM"}
        drawings = [graph for rungs in self.graphs.values() for graph in rungs]
        self._plans = {id(g): (turns := schedule(g), memories(g, turns)) for g in drawings}
        self.globals = Frame(self, "", "")
        self.tasks = [(task, [run for run in resource.runs if run.task == task.name])
                      for resource in model.resources for task in resource.tasks]
        self.tasks.sort(key=lambda pair: pair[0].priority)
        self.programs = {run.name.upper(): Frame(self, run.pou, run.name)
                         for _, runs in self.tasks for run in runs}
        self._due = {id(task): 0 for task, _ in self.tasks}

    def scan(self, now_ns: int) -> None:
        """One base tick at the time ``now_ns``."""
        self.now = now_ns
        for task, runs in self.tasks:
            assert task.single is None, "the oracle knows no SINGLE tasks"
            if task.interval is not None:
                if now_ns < self._due[id(task)]:
                    continue
                self._due[id(task)] += task.interval
            for run in runs:
                self.run(self.programs[run.name.upper()])
        self.first_scan = False

    def run(self, frame: Frame) -> None:
        rungs = self.graphs[frame.pou]
        labels = {g.name.upper(): n for n, g in enumerate(rungs) if g.name}
        at, jumps = 0, 0
        while at < len(rungs):
            graph = rungs[at]
            turns, hidden = self._plans[id(graph)]
            domain = Concrete(self, frame)
            evaluate(graph, turns, domain, hidden)
            at += 1
            if domain.taken:
                label = min(domain.taken)[1]
                jumps += 1
                if jumps > 10_000:
                    raise Fault("too many jumps")
                at = labels[label.upper()] if label else len(rungs)

    # -- values

    def fresh(self, type_: Type, initial: Any = None) -> Any:
        """A new value of a type: structures are dictionaries, arrays flat lists, instances frames."""
        match type_:
            case Instance(pou):
                made = Standard(pou) if blocks.signature(pou) is not None else Frame(self, pou.upper(), pou)
                for name, value in initial or ():
                    if isinstance(made, Standard):
                        made.given[name.upper()] = value
                    else:
                        made.values[name.upper()] = self.fresh(made.variables[name.upper()].type, value)
                return made
            case Struct(fields=fields):
                given = {name.upper(): value for name, value in initial or ()}
                return {key: self.fresh(f.type, given.get(key, f.initial))
                        for f in fields for key in (f.name.upper(),)}
            case Array(element=element):
                flat = default(type_) if initial is None else initial
                return [self.fresh(element, value if initial is not None else None) for value in flat]
        return default(type_) if initial is None else initial

    def value(self, frame: Frame, expr: Expr) -> Any:
        match expr:
            case Const(value):
                return value
            case Load(place):
                return self.load(frame, place)
            case Apply(op, args, type_, user=user):
                values = [self.value(frame, a) for a in args]
                if user:
                    return self.call(op, values)[0]
                try:
                    return functions.meaning(op, tuple(a.type for a in args), type_)(*values)
                except DivisionByZero as error:
                    raise Fault("division by zero") from error

    def call(self, name: str, values: Sequence[Any]) -> tuple[Any, Frame]:
        """A FUNCTION of the project: its result, and its variables as it left them."""
        frame = Frame(self, name.upper(), name)
        for parameter, value in zip(self.model.signatures[name.upper()].inputs, values, strict=True):
            frame.values[parameter.name.upper()] = value
        self.run(frame)
        return frame.values[name.upper()], frame

    def load(self, frame: Frame, place: Place) -> Any:
        value, steps = self._root(frame, place)
        for step in steps:
            value = self._into(frame, value, step)
        return value

    def store(self, frame: Frame, place: Place, value: Any) -> None:
        stored = storage(place.type)
        if isinstance(stored, String):
            value = value[: stored.length]
        if not place.steps:
            location = self._location(frame, place)
            if location is not None:
                self.write_image(location, place.type, value)
            else:
                (self.globals if place.is_global else frame).values[place.root.upper()] = value
            return
        *before, last = place.steps
        if not isinstance(last, FieldStep | IndexStep):
            word = Place(place.root, place.type, tuple(before), place.is_global)
            whole = self.load(frame, word)
            whole = whole | 1 << last.bit if value else whole & ~(1 << last.bit)
            self._store_whole(frame, word, whole)
            return
        owner, steps = self._root(frame, place)
        for step in steps[:-1]:
            owner = self._into(frame, owner, step)
        if isinstance(last, IndexStep):
            owner[self._index(frame, last)] = value
        elif isinstance(owner, Standard):
            owner.given[last.name.upper()] = value
        else:
            (owner if isinstance(owner, dict) else owner.values)[last.name.upper()] = value

    def _store_whole(self, frame: Frame, place: Place, value: int) -> None:
        location = None if place.steps else self._location(frame, place)
        if location is None:
            self.store(frame, place, value)
        else:
            self._bits(location, value)

    def _root(self, frame: Frame, place: Place) -> tuple[Any, tuple]:
        name = place.root.upper()
        if name == "%NOW":
            return self.now, ()
        if name == "%FIRST_SCAN":
            return self.first_scan, ()
        location = self._location(frame, place)
        if location is not None:
            type_ = place.type if not place.steps else None
            return self.read_image(location, type_), place.steps
        return (self.globals if place.is_global else frame).values[name], place.steps

    def _location(self, frame: Frame, place: Place) -> Location | None:
        name = place.root.upper()
        if name.startswith("%"):
            return Location.parse(name)
        variable = (self.globals if place.is_global else frame).variables.get(name)
        return variable.location if variable is not None else None

    def _into(self, frame: Frame, value: Any, step: Any) -> Any:
        if isinstance(step, FieldStep):
            return (value if isinstance(value, dict) else value.values)[step.name.upper()]
        if isinstance(step, IndexStep):
            return value[self._index(frame, step)]
        return bool(value >> step.bit & 1)

    def _index(self, frame: Frame, step: IndexStep) -> int:
        flat = 0
        for expr, (low, high) in zip(step.indexes, step.bounds, strict=True):
            index = self.value(frame, expr)
            if not low <= index <= high:
                raise Fault(f"index {index} is outside {low}..{high}")
            flat = flat * (high - low + 1) + index - low
        return flat

    # -- the process image: little-endian bytes

    def read_image(self, location: Location, type_: Type | None) -> Any:
        if location.size == "X":
            return bool(self.image[location.area][location.byte] >> location.bit & 1)
        raw = bytes(self.image[location.area][location.byte : location.byte + location.bits // 8])
        stored = storage(type_) if type_ is not None else None
        kind = getattr(stored, "kind", "bits")
        if kind == "real":
            return struct.unpack("<f" if stored.bits == 32 else "<d", raw)[0]
        return int.from_bytes(raw, "little", signed=kind in ("int", "time", "tod", "dt"))

    def write_image(self, location: Location, type_: Type, value: Any) -> None:
        stored = storage(type_)
        if getattr(stored, "kind", "") == "real":
            value = int.from_bytes(struct.pack("<f" if stored.bits == 32 else "<d", value), "little")
        self._bits(location, int(value))

    def _bits(self, location: Location, value: int) -> None:
        area = self.image[location.area]
        if location.size == "X":
            area[location.byte] = area[location.byte] & ~(1 << location.bit) | bool(value) << location.bit
        else:
            size = location.bits // 8
            raw = (value & (1 << 8 * size) - 1).to_bytes(size, "little")
            area[location.byte : location.byte + size] = raw

    # -- from outside

    def get(self, path: str) -> Any:
        frame, place = self._path(path)
        return self.load(frame, place)

    def set(self, path: str, value: Any) -> None:
        frame, place = self._path(path)
        self.store(frame, place, value)

    def _path(self, path: str) -> tuple[Frame, Place]:
        if path.startswith("%"):
            return self.globals, Place(path.upper(), BOOL, is_global=True)
        names = re.findall(r"\w+|\[[^\]]*\]", path)
        frame = self.programs.get(names[0].upper())
        if frame is not None and len(names) > 1:
            names = names[1:]
        elif names[0].upper() in self.globals.variables:
            frame = self.globals
        else:
            (frame,) = self.programs.values()
        root, *rest = names
        type_, steps = frame.variables[root.upper()].type, []
        for name in rest:
            if name.startswith("["):
                indexes = tuple(Const(int(i), BOOL) for i in name[1:-1].split(","))
                steps.append(IndexStep(indexes, type_.bounds))
                type_ = type_.element
            else:
                steps.append(FieldStep(name))
                type_ = self._member(type_, name)
        return frame, Place(root, type_, tuple(steps), frame is self.globals)

    def _member(self, type_: Type, name: str) -> Type:
        if isinstance(type_, Struct):
            return type_.field(name).type
        signature = blocks.signature(type_.pou)
        if signature is not None:
            return signature.pin(name).type
        return self.model.pous[type_.pou.upper()].variables[name.upper()].type
