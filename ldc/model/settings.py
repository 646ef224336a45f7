"""What a project may say outside its source text (``ldc.toml``) that the model needs."""

from __future__ import annotations

from collections.abc import Mapping

from ldc.records import field, record


@record
class TaskSetting:
    """A task of the manifest.

    ``interval``: nanoseconds, None runs it in every scan. ``programs``: names of PROGRAMs, each of
    which gets one instance of its own name. ``processor``: where the task runs.
    ``watchdog``: nanoseconds that an execution may take, None: no bound.
    """

    name: str
    interval: int | None = None
    priority: int = 0
    programs: tuple[str, ...] = ()
    processor: str = "master"
    watchdog: int | None = None


@record
class Settings:
    """``image_bytes``: size of each of the areas %I, %Q and %M. ``tasks``: used when the text has no
    CONFIGURATION. ``modules``: PROGRAMs in the order in which they run, those of one task one behind the
    other; a task without programs of its own runs all of them and no others. ``safe``: output address or
    variable path -> value that it takes after a fault. ``library``: the text is that of the standard
    library, which may use ``%NOW``, ``%FIRST_SCAN`` and the reserved names of the standard blocks."""

    image_bytes: int = 1024
    tasks: tuple[TaskSetting, ...] = ()
    modules: tuple[str, ...] = ()
    safe: Mapping[str, object] = field(default_factory=dict)
    library: bool = False
