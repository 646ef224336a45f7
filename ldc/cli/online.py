"""`ldc online`: a change of a running program, from the side of those who make it (DESIGN section 7).

The compile runs here; the runtime receives the image, native code if it runs such, and the sources.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence

from ldc import pipeline
from ldc.cli import declared, link, modules, settled, shipped
from ldc.cli.compiling import compiled, locator, native_code
from ldc.cli.console import Failure, report, say
from ldc.cli.inputs import read
from ldc.cli.starting import resource_to_run, watched
from ldc.cli.system import together
from ldc.diagnostics import Invalid
from ldc.il import image as il_image
from ldc.il.coordination_image import pack
from ldc.manifest import Sources
from ldc.render import plural, visible
from runtime.layout import lay_out
from runtime.machine import base_tick
from runtime.online import checks, migrate, wire
from runtime.online.checks import Limits
from runtime.online.wire import Act, Answer, Changes, Pull, Report, Stage, State, Status
from runtime.symbols import Symbols
from runtime.values import milliseconds


def run(options: argparse.Namespace) -> int:
    """Raises Invalid with what the compiler or the runtime has against it."""
    if options.action == "insert":
        return _insert(options)
    if options.action in ("get", "set", "watch", "force", "unforce", "forces", "trace"):
        from ldc.cli import values  # compiles nothing

        return values.run(options)
    sources = read(options.sources)
    match options.action:
        case "stage":
            return _stage(options, sources)
        case "report" if options.before:
            return _offline(read([options.before]), sources)
        case "report":
            path = link.runtime_of(options, sources)
            answer = link.ask(path, Report())
            if answer.state.state == "staged":  # what runs is the program before
                _print_brought(sources, link.ask(path, Pull()), answer.sources or [])
            _print_changes(answer.changes)
        case "status":
            answer = link.ask(link.runtime_of(options, sources), Status())
            _print_state(answer.state, settled.options_of(answer.settings))
        case action:
            message = Act(action=action, owner=link.owner_of(options.sources),
                          limit_ns=getattr(options, "limit", None), force=getattr(options, "force", False))
            _print_state(link.ask(link.runtime_of(options, sources), message).state)
    return 0


def _stage(options: argparse.Namespace, sources: Sources) -> int:
    path = link.runtime_of(options, sources)
    running = link.ask(path, Pull())
    result = compiled(sources, previous=il_image.layout_of(running.image))
    texts, theirs = shipped.texts_of(sources), running.sources or []
    alike = result.image.digest == running.state.digest and pack(together(result)) == running.together
    same = alike and result.image.data == running.image and list(texts) == theirs
    message = None if same else _message(options, texts, running, result)
    report(settled.stays(sources.manifest, running.settings))
    if message is None:
        say("nothing to stage: this program runs")
        return 0
    try:
        answer = link.ask(path, message)
    except Invalid as error:
        raise Invalid(declared.placed(error.diagnostics, result), locator(result)) from error
    _print_brought(sources, running, texts)
    if alike:
        changed = ", ".join(path for path, _ in shipped.differences(texts, theirs))
        say(visible(f"the code is that of the program that runs; its sources have changed: {changed}"))
    _print_changes(answer.changes, kept=False)
    say(f"staged {answer.state.staged[:12]}; `ldc online test` lets it run")
    return 0


def _print_brought(sources: Sources, running: Answer, coming: Iterable[tuple[str, str]]) -> None:
    """A line for every setting that a program brings along. The project file is called as it is here."""
    if sources.manifest is None:
        return
    name = shipped.name_of(sources, sources.manifest.source)
    before, after = (dict(texts).get(name, "") for texts in (running.sources or [], coming))
    for key in settled.brought(before, after, running.settings):
        print(f"{'brought':<12}{visible(key)}")


def _message(options: argparse.Namespace, texts: shipped.Texts, running: Answer, result: pipeline.Compiled
             ) -> Stage:
    """The message that brings a program, whose symbols lie where they lie in the running one. Raises Invalid
    when what it is to show is not in it."""
    state = running.state
    shown: tuple[str, ...] = ()
    if state.resource < len(result.program.resources):  # else the runtime tells that it has none for it
        shown = watched(None, result.sources.manifest, Symbols(lay_out(result.program, state.resource)))
    message = Stage(image=result.image.data, sources=list(texts),
                    base=_base(options.expect, state), owner=link.owner_of(options.sources),
                    together=pack(together(result)), watch=list(shown))
    bindings = native_code(result)
    message.components = [wire.Part(b.unit, b.entry, b.library.read_bytes(), b.size,
                                    [(s.name, s.offset, s.written) for s in b.shared]) for b in bindings]
    if state.engine == "native":
        from ldc.cli import native  # loads cffi and jinja2

        made = native.artifact(result, state.resource, areas=state.areas, bindings=bindings)
        message.library = made.path.read_bytes()
        message.parts = [(name, list(firsts)) for name, firsts in made.plan.map]
        message.areas = dict(made.plan.block.areas)
    return message


def _base(expected: str | None, state: State) -> str:
    """The program that the change is for: the one that runs, or the one that is expected to."""
    return expected if expected and not state.digest.startswith(expected.lower()) else state.digest


def _insert(options: argparse.Namespace) -> int:
    """Puts a module into the list of the project and stages the result; the project file is as it was
    before when that cannot be."""
    sources = read(options.sources)
    if sources.manifest is None:
        raise Failure("modules are listed in an ldc.toml: name its folder")
    with modules.inserted(sources, options.module, options.after):
        return _stage(options, read(options.sources))


def _offline(before: Sources, sources: Sources) -> int:
    """What a change would do to a program that ran from its first scan."""
    old = compiled(before)
    new = compiled(sources, previous=old.image.layout)
    number = resource_to_run(old)
    if number >= len(new.program.resources):
        raise Failure("the new program has none for the processor that is run")
    running, changed = lay_out(old.program, number), lay_out(new.program, number)
    plan = migrate.plan(running, changed)
    limits = Limits(before.settings.image_bytes)
    manifest = before.manifest
    period = manifest.period if manifest and manifest.period else base_tick(running.resource.tasks)
    against = [*plan.refusals, *checks.tasks(running, changed, period),
               *checks.memory(new.program, changed, limits)]
    if against:
        raise Invalid(declared.placed(against, new), locator(new))
    _print_changes(Changes(list(plan.kept), list(plan.initialised), list(plan.dropped)))
    return 0


def _print_changes(changes: Changes, kept: bool = True) -> None:
    """A line for every symbol; ``kept``: also for those that go on as they are."""
    shown = changes.kept if kept else []
    for what, paths in (("initialised", changes.initialised), ("dropped", changes.dropped), ("kept", shown)):
        for path in paths:
            print(f"{what:<12}{visible(path)}")
    say(f"{plural(len(changes.kept), 'symbol')} kept, {len(changes.initialised)} initialised, "
        f"{len(changes.dropped)} dropped")


def _print_state(state: State, options: Sequence[str] = ()) -> None:
    print(f"program  {visible(state.name)}, {state.digest[:12]}, engine {state.engine}")
    print(f"settings {visible(', '.join((state.settings[:12], *options)))}")
    staged = f" {state.staged[:12]}, client {visible(state.client)}" if state.staged else ""
    print(f"state    {state.state}{staged}")
    if state.state == "testing":
        left = max(state.left_ns, 0) / 1e9
        print(f"         back to the program before in {left:.1f} s, unless committed")
    print(f"scans    {state.scans}, {milliseconds(state.now_ns)} ms")
    if state.waits:
        print(f"sequence {visible(state.waits)}")
    if state.last:
        print(f"last     {visible(state.last)}")
    if state.pause_ns:
        print(f"pause    {state.pause_ns / 1e6:.3f} ms, of the last swap")
    sys.stdout.flush()
    report(wire.diagnostic(found) for found in state.faults)
