"""What runs where and when: CONFIGURATION of the text, else tasks of ldc.toml, else one task for all."""

from __future__ import annotations

from collections.abc import Iterable

from ldc.diagnostics import Diagnostics
from ldc.model import declaration_findings as findings
from ldc.model import places
from ldc.model.initial import integer, scalar
from ldc.model.environment import Environment
from ldc.model.names import PREFIX, suggest
from ldc.model.project import Model, Resource, Run, Task
from ldc.model.settings import Settings, TaskSetting
from ldc.parser import ast
from ldc.records import replace
from ldc.source import Span
from ldc.symbols import Location
from ldc.types import BOOL, TIME, storage

MAIN, PROCESSOR = "main", "master"
MOST_PRIORITY = 65_535


class Configurator:
    """Fills ``Model.resources``. Instance names are one space of names together with the globals, since
    both begin the paths of variables (DESIGN section 8)."""

    def __init__(self, model: Model, env: Environment, settings: Settings, diagnostics: Diagnostics) -> None:
        self.model, self.env, self.settings, self.diagnostics = model, env, settings, diagnostics
        self._programs = {k: p for k, p in model.pous.items() if p.signature.kind == "PROGRAM"}
        self._instances: dict[str, Span | None] = {}

    def configured(self, configurations: list[ast.Configuration]) -> Model:
        """The model with its resources."""
        if configurations:
            resources = self._from_text(configurations)
        elif self.settings.tasks:
            resources = self._from_settings(self.settings.tasks)
        else:
            runs = tuple(self._instance(name, MAIN) for name in self._sequence())
            resources = (Resource(MAIN, PROCESSOR, (Task(MAIN, None, 0, None),), runs),)
        model = replace(self.model, resources=resources)
        running = {run.pou for resource in resources for run in resource.runs}
        for key, pou in self._programs.items():
            if key not in running and not self.diagnostics.has_errors:
                findings.never_run(self.diagnostics, pou.span, pou.name)
        self._check_safe(model)
        return model

    # ---- CONFIGURATION ------------------------------------------------------------------------------

    def _from_text(self, configurations: list[ast.Configuration]) -> tuple[Resource, ...]:
        for other in configurations[1:]:
            findings.several_configurations(self.diagnostics, other.span, other.name, configurations[0].span)
        found: dict[str, Resource] = {}
        first: dict[str, Span] = {}
        for node in configurations[0].resources:
            key = node.name.upper()
            if key in first:
                findings.duplicate(self.diagnostics, node.span, node.name, "RESOURCE", first[key])
                continue
            first[key] = node.span
            found[key] = self._resource(node)
        return tuple(found.values())

    def _resource(self, node: ast.Resource) -> Resource:
        tasks: dict[str, Task] = {}
        named: dict[str, Span] = {}
        for written in node.tasks:
            key = written.name.upper()
            if key in named:
                findings.duplicate(self.diagnostics, written.span, written.name, "TASK", named[key])
                continue
            named[key] = written.span
            if key.startswith(PREFIX):
                findings.reserved_prefix(self.diagnostics, written.span, written.name)
            task = self._task(written)
            if task is not None:
                tasks[key] = task
        runs = []
        for written in node.programs:
            run = self._run(written, tasks, named)
            if run is not None:
                runs.append(run)
        if any(run.task == "" for run in runs):
            # Without a task a program runs in every scan, after all others (IEC 61131-3 2.7.2).
            name = MAIN if MAIN.upper() not in named else "_ldc_main"
            tasks[name.upper()] = Task(name, None, MOST_PRIORITY, None)
            runs = [run if run.task else replace(run, task=name) for run in runs]
        return Resource(node.name or MAIN, node.processor, tuple(tasks.values()), tuple(runs))

    def _task(self, node: ast.Task) -> Task | None:
        interval, priority = None, 0
        if node.interval is not None:
            found = scalar(self.env, node.interval, TIME, self.diagnostics, "INTERVAL")
            if found is None:
                return None
            if found.value <= 0:
                findings.bad_task(self.diagnostics, node.interval.span,
                                  f"task `{node.name}` has an interval of no length",
                                  "must be greater than zero", "write for example `INTERVAL := T#10ms`")
                return None
            interval = found.value
        if node.priority is not None:
            found = integer(self.env, node.priority, self.diagnostics, "PRIORITY")
            if found is None:
                return None
            if not 0 <= found <= MOST_PRIORITY:
                findings.bad_task(self.diagnostics, node.priority.span,
                                  f"task `{node.name}` has the priority {found}",
                                  f"0 to {MOST_PRIORITY} is possible", "0 is the most urgent")
                return None
            priority = found
        if node.single is not None and not self._single(node, interval):
            return None
        return Task(node.name, interval, priority, node.single, node.span)

    def _single(self, node: ast.Task, interval: int | None) -> bool:
        if interval is not None:
            findings.bad_task(self.diagnostics, node.single.span,
                              f"task `{node.name}` has SINGLE and INTERVAL", "a second trigger",
                              "keep one of the two")
            return False
        place = places.place(self.env, node.single, self.diagnostics)
        if place is not None and storage(place.type) != BOOL:
            findings.bad_task(self.diagnostics, node.single.span,
                              f"SINGLE of task `{node.name}` needs a BOOL", f"this is {place.type}",
                              "name a global BOOL variable or an address")
            return False
        return place is not None

    def _run(self, node: ast.ProgramInstance, tasks: dict[str, Task], named: dict[str, Span]) -> Run | None:
        if not self._program_known(node.pou, node.span):
            return None
        task = ""
        if node.task is not None:
            key = node.task.upper()
            if key not in named:
                findings.unknown_in_configuration(
                    self.diagnostics, node.span, "task", node.task,
                    suggest(node.task, [t.name for t in tasks.values()]) or "declare it: `TASK name (...);`")
                return None
            if key not in tasks:
                return None
            task = tasks[key].name
        if not self._claim(node.name, node.span):
            return None
        return Run(node.name, node.pou.upper(), task)

    def _program_known(self, name: str, span: Span | None) -> bool:
        key = name.upper()
        if key in self._programs:
            return True
        pou = self.model.pous.get(key)
        if any(p.signature.written.upper() == key and p.signature.kind == "FUNCTION_BLOCK"
               and key in self.model.globals
               for p in self.model.pous.values()):
            findings.called_program(self.diagnostics, span, name)
            return False
        if pou is not None:
            help = f"`{pou.name}` is a {pou.signature.kind}; only a PROGRAM runs by a task"
        else:
            help = suggest(name, [p.name for p in self._programs.values()]) or "declare it as a PROGRAM"
        if pou is not None or not self.model.incomplete:
            findings.unknown_in_configuration(self.diagnostics, span, "PROGRAM", name, help)
        return False

    def _claim(self, name: str, span: Span | None) -> bool:
        key = name.upper()
        taken = self.model.globals.get(key)
        if key in self._instances or taken is not None:
            first = taken.span if taken is not None else self._instances[key]
            findings.duplicate(self.diagnostics, span, name, "program instance", first)
            return False
        self._instances[key] = span
        if key.startswith(PREFIX) and span is not None:
            findings.reserved_prefix(self.diagnostics, span, name)
        return True

    # ---- ldc.toml ---------------------------------------------------------------------------------

    def _sequence(self) -> list[str]:
        """The PROGRAMs that run when no task names its own: the modules of the project in their order, else
        all."""
        if self.settings.modules:
            return [name for name in self.settings.modules if self._program_known(name, None)]
        return [p.name for p in self._programs.values()]

    def _in_sequence(self, names: Iterable[str]) -> list[str]:
        """Programs of one task; the modules among them in the order of the project, before the others."""
        places = {name.upper(): number for number, name in enumerate(self.settings.modules)}
        return sorted(names, key=lambda name: places.get(name.upper(), len(places)))

    def _instance(self, name: str, task: str) -> Run:
        return Run(self._programs[name.upper()].name, name.upper(), task)

    def _from_settings(self, tasks: Iterable[TaskSetting]) -> tuple[Resource, ...]:
        tasks = list(tasks)
        everything = len(tasks) == 1 and not tasks[0].programs
        resources: dict[str, Resource] = {}
        for setting in tasks:
            wanted = self._sequence() if everything else self._in_sequence(setting.programs)
            if not 0 <= setting.priority <= MOST_PRIORITY:
                findings.bad_task(self.diagnostics, None,
                                  f"task `{setting.name}` has the priority {setting.priority}", "",
                                  f"0 (the most urgent) to {MOST_PRIORITY} is possible")
                continue
            if setting.interval is not None and setting.interval <= 0:
                findings.bad_task(self.diagnostics, None,
                                  f"task `{setting.name}` has an interval of no length", "",
                                  "write for example `interval = \"10ms\"`")
                continue
            old = resources.get(setting.processor, Resource(setting.processor, setting.processor, (), ()))
            runs = tuple(self._instance(name, setting.name) for name in wanted
                         if self._program_known(name, None) and self._claim(name, None))
            task = Task(setting.name, setting.interval, setting.priority, None)
            resources[setting.processor] = replace(old, tasks=(*old.tasks, task), runs=(*old.runs, *runs))
        return tuple(resources.values())

    def _check_safe(self, model: Model) -> None:
        runs = {run.name.upper(): run.pou for resource in model.resources for run in resource.runs}
        for path in model.safe:
            if not self._exists(path, runs) and not model.incomplete:
                findings.bad_safe_value(self.diagnostics, path, "name an output address (%QX0.0), "
                                        "a global variable or instance.variable")

    def _exists(self, path: str, runs: dict[str, str]) -> bool:
        if path.startswith("%"):
            location = Location.parse(path)
            return location is not None and location.area == "Q"
        root, _, rest = path.partition(".")
        key = root.partition("[")[0].upper()
        if key in self.model.globals:
            return True
        if rest and key in runs:
            inner = rest.partition(".")[0].partition("[")[0].upper()
            return inner in self.model.pous[runs[key]].variables
        return len(runs) == 1 and key in self.model.pous[next(iter(runs.values()))].variables
