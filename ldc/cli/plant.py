"""The plant of a project, `[plant]` in ldc.toml: a Python file with a class `Plant`, run on this computer.

What is wrong in it is told at its line, as what is wrong in any source; its own traceback is not shown.
"""

from __future__ import annotations

import json
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from types import ModuleType, TracebackType
from typing import NoReturn

from ldc.cli.patience import Endless, Patience
from ldc.diagnostics import Diagnostics, Invalid
from ldc.il.coordination import Plant as Setting
from ldc.reading import read_source
from ldc.source import Span
from runtime.field import Field, UnknownPoint
from runtime.values import milliseconds

_MODULE = "ldc_plant"


class Plant:
    """The plant of a project. ``step`` raises Invalid when it fails or does not end (LD0842, LD0846). Raises
    Invalid when the file is no Python, has no class `Plant`, or that cannot be made (LD0840, LD0841,
    LD0843)."""

    def __init__(self, setting: Setting, field: Field) -> None:
        diagnostics = Diagnostics()
        self._path = Path(setting.file)
        self._source = read_source(self._path, self._path.as_posix(), diagnostics)
        if self._source is None:
            raise Invalid(diagnostics)
        made = self._guarded("cannot be loaded", self._load)
        kind = getattr(made, "Plant", None)
        if not isinstance(kind, type) or not callable(getattr(kind, "step", None)):
            diagnostics.error("LD0841",
                              f"the plant `{self._source.path}` has no class `Plant` with a method `step`",
                              self._source.line_span(1),
                              help="class Plant: def __init__(self, field, parameters, seed), "
                              "def step(self, now_ns, dt_ns)")
            raise Invalid(diagnostics)
        parameters = {}
        if setting.parameters is not None:
            parameters = json.loads(Path(setting.parameters).read_bytes())
        self._plant = self._guarded("cannot be made", lambda: kind(field, parameters, setting.seed))
        self._step: Callable[[int, int], object] = self._plant.step
        self._patience = Patience()
        self.silences = self._silences if hasattr(self._plant, "silent") else None

    def connect(self, field: Field) -> None:
        """Another program has taken over: the plant may find further points. Not every plant asks."""
        connect = getattr(self._plant, "connect", None)
        if connect is not None:
            self._guarded("cannot be made", lambda: connect(field))

    def _silences(self, slave: int) -> bool:
        """Whether the plant has taken the power from a slave."""
        return bool(self._guarded("cannot tell which slaves are silent", lambda: slave in self._plant.silent))

    def step(self, now_ns: int, dt_ns: int) -> None:
        """One step of the simulation."""
        self._patience.begin()
        try:
            self._step(now_ns, dt_ns)
        except Endless as error:
            diagnostics = Diagnostics()
            diagnostics.error("LD0846", f"the plant `{self._source.path}` does not come back from its step "
                              f"at {milliseconds(now_ns)} ms", self._span(error),
                              "was here when it was ended",
                              help="bound every loop and wait for nothing: a step has the time of its period")
            raise Invalid(diagnostics) from None
        except (Exception, SystemExit) as error:
            self._fails(error, f"fails at {milliseconds(now_ns)} ms")
        finally:
            self._patience.end()

    def _load(self) -> ModuleType:
        module = ModuleType(_MODULE)
        module.__file__ = str(self._path)
        sys.modules[_MODULE] = module  # dataclasses look there
        if (folder := str(self._path.parent)) not in sys.path:
            sys.path.insert(0, folder)
        exec(compile(self._source.text, str(self._path), "exec"), module.__dict__)
        return module

    def _guarded(self, what: str, work: Callable[[], object]) -> object:
        try:
            return work()
        except (Exception, SystemExit) as error:
            self._fails(error, what)

    def _fails(self, error: BaseException, what: str) -> NoReturn:
        diagnostics = Diagnostics()
        span = self._span(error)
        if isinstance(error, UnknownPoint):
            diagnostics.error("LD0843", f"the plant asks for what is not there: {error}", span,
                              "asked for here",
                              help="points are the local pins of algorithms, as `clamp.axis.speed_out`, and "
                              "located inputs and outputs of the master")
        else:
            said = "".join(traceback.format_exception_only(error)).strip().splitlines()[-1]
            diagnostics.error("LD0840" if what.startswith("cannot") else "LD0842",
                              f"the plant `{self._source.path}` {what}: {said}", span, "raised here",
                              help="the plant is a program in Python that runs beside the controller")
        raise Invalid(diagnostics) from None

    def _span(self, error: BaseException) -> Span:
        line = _line(error.__traceback__, str(self._path))
        if isinstance(error, SyntaxError) and error.filename == str(self._path):
            line = error.lineno or 1
        return self._source.line_span(line)


def _line(trace: TracebackType | None, path: str) -> int:
    """The innermost line of the plant's own file that an exception went through."""
    found = 1
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == path:
            found = trace.tb_lineno
        trace = trace.tb_next
    return found
