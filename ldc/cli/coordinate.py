"""Resolves what `ldc.toml` says of modules working together against the compiled program (SPEC 3, 4)."""

from __future__ import annotations

import json
import math
from pathlib import Path

from ldc import pipeline
from ldc.cli.coordinate_findings import Findings
from ldc.coordination import MessageSetting, PlantSetting, StepSetting, SubscriberSetting
from ldc.diagnostics import Diagnostics, Invalid
from ldc.durations import duration_text
from ldc.il.coordination import (
    SYSTEM_MESSAGES, Coordination, Full, Message, Module, Parameter, Plant, Sequence, Step, Subscriber,
    form, placed_messages, placed_modules, system_messages)
from ldc.il.program import Resource
from ldc.library.generic import kind, widens
from ldc.manifest import Manifest
from ldc.records import replace
from ldc.source import Span
from ldc.symbols import Variable
from ldc.types import BOOL, UDINT, Type, storage
from runtime import values
from runtime.layout import lay_out
from runtime.machine import base_tick
from runtime.master.frames import TooLong, frames
from runtime.symbols import Symbols, UnknownSymbol

MODULES = 256
USER_MESSAGES = 192


def coordination(result: pipeline.Compiled, diagnostics: Diagnostics | None = None) -> Coordination:
    """How the modules of a compiled project work together; all empty when it says nothing of it.

    What is wrong goes to ``diagnostics``. Raises Invalid when none are given.
    """
    manifest = result.sources.manifest
    if manifest is None or not manifest.coordination or result.program is None:
        return Coordination()
    found = Diagnostics() if diagnostics is None else diagnostics
    check = _Check(result, manifest, Findings(found))
    made = check.coordination()
    if check.findings.wrong:
        if diagnostics is None:
            raise Invalid(found)
        return Coordination()
    return made


class _Check:
    def __init__(self, result: pipeline.Compiled, manifest: Manifest, findings: Findings) -> None:
        self.manifest, self.findings, self.program = manifest, findings, result.program
        number, self.resource = self._resource()
        self.symbols = Symbols(lay_out(self.program, number))
        self.inputs: dict[int, dict[str, Variable]] = {}
        self.taken: dict[str, str] = {}

    def _resource(self) -> tuple[int, Resource]:
        """That of the master; else the first that has a program, as it is run alone."""
        masters = {name for name, role in self.manifest.processors.items() if role == "master"}
        rows = [(n, r) for n, r in enumerate(self.program.resources) if r.runs] or [
            (n, r) for n, r in enumerate(self.program.resources)]
        return next((row for row in rows if row[1].processor in masters), rows[0])

    def span(self, *path: str | int) -> Span | None:
        """Where the value of a key stands; of the nearest table that has a place when it has none."""
        for end in range(len(path), 0, -1):
            for part in (path[:end], tuple(key for key in path[:end] if isinstance(key, str))):
                if (found := self.manifest.value_span(*part)) is not None:
                    return found
        return None

    def coordination(self) -> Coordination:
        settings = self.manifest.coordination
        self.modules = self._modules()
        messages = self._messages(settings.messages)
        for key, what, path in (("estop", "the emergency stop", settings.estop),
                                ("reset", "what acknowledges faults", settings.reset)):
            if path:
                self._bool(("safety", key), what, path)
        plant = self._plant(settings.plant) if settings.plant else None
        return Coordination(self.modules, messages, self._sequence(), settings.estop, plant, settings.reset)

    # -- modules

    def _modules(self) -> tuple[Module, ...]:
        names = self.manifest.modules
        span = self.span("project", "modules")
        if len(names) > MODULES:
            self.findings.too_much(span, f"{len(names)} modules are too many", f"{MODULES} are possible",
                                   "let one PROGRAM do the work of several")
            return ()
        modules = []
        for index, name in enumerate(names):
            runs = [run for run in self.resource.runs if run.pou == name.upper()]
            if len(runs) == 1:
                modules.append(self._module(index, name, runs[0].name))
                continue
            label = f"the master runs it {len(runs)} times" if runs else "the master does not run it"
            self.findings.no_module(span, name, label, "tasks of the master run each module as one instance")
            modules.append(Module(index, name, None, None, ()))
        try:
            return placed_modules(tuple(modules))
        except Full as full:
            self.findings.too_much(span, "parameters of the modules take too much memory",
                                   f"full at `{names[full.number]}`: {full}",
                                   "let modules have fewer VAR_INPUTs")
            return tuple(modules)

    def _module(self, index: int, name: str, instance: str) -> Module:
        variables = self.program.unit(name).variables
        inputs = self.inputs[index] = {v.name.upper(): v for v in variables if v.kind == "input"}
        done = next((v for v in variables if v.kind == "output" and v.name.upper() == "DONE"), None)
        start = inputs.get("START")
        parameters = tuple(Parameter(v.name, f"{instance}.{v.name}", v.type, form(v.type), 0)
                           for v in inputs.values() if v is not start and form(v.type))
        return Module(index, name, _path(instance, start), _path(instance, done), parameters)

    def _known(self, key: tuple, name: str) -> Module | None:
        module = next((m for m in self.modules if m.name.upper() == name.upper()), None)
        if module is None:
            listed = ", ".join(self.manifest.modules) or "none"
            self.findings.no_module(self.span(*key, "module"), name, "not in `modules` of [project]",
                                    f"modules: {listed}")
        return module if module is not None and module.index in self.inputs else None

    def _started(self, key: tuple, module: Module) -> None:
        if module.start is None or module.done is None:
            pin = "start" if module.start is None else "done"
            self.findings.cannot_start(self.span(*key, "module"), module.name, f"it has no BOOL pin `{pin}`")

    def _bool(self, key: tuple, what: str, path: str) -> None:
        label = f"a value of {type_}" if (type_ := self._type(path)) else "there is no such variable"
        if type_ is None or storage(type_) != BOOL:
            self.findings.no_bool(self.span(*key), what, path, label,
                                  "name a variable as in `clamp.closed`, or a declared address as `%IX0.7`")

    def _type(self, path: str) -> Type | None:
        try:
            return self.symbols.find(path).type
        except UnknownSymbol:
            return None

    # -- the sequence

    def _sequence(self) -> Sequence | None:
        setting = self.manifest.coordination.sequence
        if setting is None:
            return None
        if setting.start:
            self._bool(("sequence", "start"), "the begin of the sequence", setting.start)
        if setting.steps is None:
            steps = tuple(Step(m.index, m.name) for m in self.modules if m.start and m.done)
        else:
            steps = tuple(step for one in setting.steps if (step := self._step(one)))
        if not steps and not self.findings.wrong:
            self.findings.no_steps(self.span("sequence"))
        sequence = Sequence(steps, setting.start, setting.repeat)
        if not self.findings.wrong:
            try:
                frames(sequence, 1)
            except TooLong as error:
                self.findings.too_much(self.span("sequence", "steps"), "the sequence is too long", str(error),
                                       "let a module do the work of several steps")
        return sequence

    def _step(self, setting: StepSetting) -> Step | None:
        module = self._known(setting.key, setting.module)
        if module is None:
            return None
        self._started(setting.key, module)
        for name, path in (("when", setting.when), ("until", setting.until)):
            if path:
                self._bool((*setting.key, name), f"`{name}` of a step", path)
        parameters = []
        for name, value in setting.parameters.items():
            span, parameter = self.span(*setting.key, "parameters", name), module.parameter(name)
            if parameter is None:
                listed = ", ".join(p.name for p in module.parameters) or "none"
                self.findings.bad_parameter(span, f"module `{module.name}` has no parameter `{name}`",
                                            "no VAR_INPUT that holds a number",
                                            f"parameters of `{module.name}`: {listed}")
                continue
            written = str(value).lower() if isinstance(value, bool) else str(value)  # as TOML has it
            try:
                if isinstance(value, float) and math.isnan(value):
                    raise ValueError("this is no number")
                made = values.parse(written, parameter.type)
            except ValueError as error:
                self.findings.bad_parameter(span, f"`{name}` of module `{module.name}` cannot be `{written}`",
                                            str(error), f"it is declared as {parameter.type}")
                continue
            parameters.append((parameter, made))
        return Step(module.index, module.name, tuple(parameters), setting.when, setting.until)

    # -- messages

    def _messages(self, settings: tuple[MessageSetting, ...]) -> tuple[Message, ...]:
        system = {message.name: message for message in system_messages()}
        users: list[Message] = []
        for setting in settings:
            message = self._message(setting, len(users))
            if message is None:
                continue
            if message.system:
                system[message.name] = replace(message, number=system[message.name].number)
            else:
                users.append(message)
        found = (*system.values(), *users)
        if len(users) > USER_MESSAGES:
            self.findings.too_much(self.span("messages", users[USER_MESSAGES].name),
                                   f"{len(users)} messages are too many",
                                   f"{USER_MESSAGES} of users are possible",
                                   "let several subscribers share a message")
            return found
        try:
            return placed_messages(found)
        except Full as full:
            self.findings.too_much(self.span("messages", found[full.number].name),
                                   "messages take too much memory", str(full),
                                   "give long queues a smaller `depth`")
            return found

    def _message(self, setting: MessageSetting, number: int) -> Message | None:
        key = ("messages", setting.name)
        known = setting.name in SYSTEM_MESSAGES
        if setting.kind == "system" and not known:
            self.findings.bad_message(self.span(*key, "class"), setting.name, "no message of the system",
                                      f"those of the system: {', '.join(SYSTEM_MESSAGES)}")
        elif setting.kind == "user" and setting.name.upper() in SYSTEM_MESSAGES:
            self.findings.bad_message(self.span(*key), setting.name, "a message of the system has this name",
                                      'write class = "system", or take another name')
        elif setting.kind == "system" and (setting.source or setting.data):
            self.findings.bad_message(self.span(*key, "from" if setting.source else "data"), setting.name,
                                      "it is raised by the runtime, with its own data",
                                      "leave `from` and `data` out")
        elif setting.kind == "user" and not setting.source:
            self.findings.bad_message(self.span(*key), setting.name, "nothing broadcasts it",
                                      'name what does: from = "clamp.closed"')
        else:
            return self._right(setting, number, key)
        return None

    def _right(self, setting: MessageSetting, number: int, key: tuple) -> Message:
        type_: Type | None = UDINT if setting.kind == "system" else None
        if setting.source:
            self._bool((*key, "from"), f"message `{setting.name}`", setting.source)
        if setting.data:
            type_ = self._type(setting.data)
            if type_ is None or not form(type_):
                label = "there is no such variable" if type_ is None else f"a value of {type_}"
                self.findings.bad_data(self.span(*key, "data"), f"`{setting.data}` cannot go with a message",
                                       label, "name one number, BOOL or time, as in `clamp.axis.position`")
        if not setting.to and setting.kind == "user":
            self.findings.unheard(self.span(*key), setting.name)
        subscribers = tuple(s for one in setting.to if (s := self._subscriber(setting, one, type_)))
        depth = setting.depth if setting.policy == "queue" else 1
        return Message(setting.name, setting.kind == "system", number, setting.source, setting.data,
                       form(type_) if type_ else None, setting.policy, depth, subscribers)

    def _subscriber(self, message: MessageSetting, setting: SubscriberSetting, type_: Type | None
                    ) -> Subscriber | None:
        module = self._known(setting.key, setting.module)
        if module is None:
            return None
        if setting.flag is None:
            self._started(setting.key, module)
        flag = self._flag(message, setting, module) if setting.flag else None
        data = self._data(message, setting, module, type_) if setting.data else None
        return Subscriber(module.index, flag, data)

    def _flag(self, message: MessageSetting, setting: SubscriberSetting, module: Module) -> str | None:
        key = (*setting.key, "flag")
        pin = module.parameter(setting.flag)
        if pin is None or storage(pin.type) != BOOL:
            self.findings.no_bool(self.span(*key), f"`flag` of message `{message.name}`", setting.flag,
                                  f"no VAR_INPUT of `{module.name}` that it can be",
                                  "declare a VAR_INPUT of type BOOL; to start the module leave `flag` out")
            return None
        if label := self._misses_scans(module):
            self.findings.misses_scans(self.span(*key), message.name, module.name, label)
        if (other := self.taken.setdefault(pin.path, message.name)) != message.name:
            self.findings.bad_message(self.span(*key), message.name, f"message `{other}` sets this flag too",
                                      "give each message a flag of its own: one would hide the other")
        return pin.path

    def _misses_scans(self, module: Module) -> str:
        """Why the module does not execute in every scan, or nothing. A flag is TRUE for one scan alone."""
        run = next(run for run in self.resource.runs if run.pou == module.name.upper())
        task = next(task for task in self.resource.tasks if task.name == run.task)
        period = self.manifest.period or base_tick(self.resource.tasks)
        if task.single is not None:
            return f"task `{task.name}` runs it at the edge of SINGLE"
        if task.interval and task.interval > period:
            interval, scan = duration_text(task.interval), duration_text(period)
            return f"task `{task.name}` runs it every {interval}, a scan is {scan}"
        return ""

    def _data(self, message: MessageSetting, setting: SubscriberSetting, module: Module, type_: Type | None
              ) -> str | None:
        span, pin = self.span(*setting.key, "data"), module.parameter(setting.data)
        if pin is None:
            self.findings.bad_data(span, f"module `{module.name}` has no `{setting.data}` for data",
                                   "no VAR_INPUT that holds a number",
                                   f"those it has: {', '.join(p.name for p in module.parameters) or 'none'}")
            return None
        reals = {type_ is not None and kind(type_) == "real", kind(pin.type) == "real"}
        if type_ is None or not widens(type_, pin.type) or len(reals) == 2:
            self.findings.bad_data(span, f"`{pin.path}` cannot take the data of message `{message.name}`",
                                   f"{pin.type}, and it brings {type_ or 'no data'}",
                                   "declare the VAR_INPUT with the type of the data")
        return pin.path

    # -- the plant

    def _plant(self, setting: PlantSetting) -> Plant:
        for key, name in (("file", setting.file), ("parameters", setting.parameters)):
            if name is not None and (label := _unusable(self.manifest.folder / name, key == "parameters")):
                self.findings.bad_plant(self.span("plant", key), name, label,
                                        "paths are relative to the folder of the project")
        folder = self.manifest.folder
        return Plant(str(folder / setting.file), setting.step_ns,
                     str(folder / setting.parameters) if setting.parameters else None, setting.seed)


def _path(instance: str, pin: Variable | None) -> str | None:
    return f"{instance}.{pin.name}" if pin is not None and storage(pin.type) == BOOL else None


def _unusable(path: Path, parameters: bool) -> str:
    """Why a file cannot be what it should, or nothing."""
    try:
        content = path.read_bytes()
        if parameters and not isinstance(json.loads(content), dict):
            return "no JSON object"
    except OSError as error:
        return (error.strerror or "cannot be read").lower()
    except (ValueError, RecursionError) as error:
        return f"no JSON: {error}" if isinstance(error, ValueError) else "brackets are nested too deeply"
    return ""
