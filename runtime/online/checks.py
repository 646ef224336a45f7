"""What a running program cannot become: other tasks, more memory than there is (DESIGN section 7)."""

from __future__ import annotations

from ldc.diagnostics import Diagnostic
from ldc.il.homes import end_of
from ldc.il.layout import lay_out
from ldc.il.program import Program, Task
from ldc.records import record
from runtime.layout import Layout
from runtime.online import findings
from runtime.values import milliseconds


@record
class Limits:
    """Bytes that a program may use: of each area I, Q and M, and of its data."""

    image_bytes: int = 1024
    data_bytes: int = 64 << 20


def tasks(old: Layout, new: Layout, period_ns: int) -> list[Diagnostic]:
    """LD0821 for every task that runs and is not there, or another one, in the new program, and for further
    ones that scans every ``period_ns`` cannot execute in time."""
    found, known = [], {task.name.upper(): task for task in new.resource.tasks}
    for task in old.resource.tasks:
        now = known.get(task.name.upper())
        if now is None:
            found.append(findings.task_changed(task.name, "is not there any more"))
        elif _timing(now) != _timing(task):
            found.append(findings.task_changed(task.name, "has another interval, priority or SINGLE"))
    running = {task.name.upper() for task in old.resource.tasks}
    for name, task in known.items():
        if name not in running and task.interval and task.interval % period_ns:
            interval, period = milliseconds(task.interval), milliseconds(period_ns)
            what = f"is due every {interval} ms, and scans come every {period} ms"
            found.append(findings.task_changed(task.name, what))
    return found


def _timing(task: Task) -> tuple:
    return task.interval, task.priority, str(task.single).upper()


def memory(program: Program, layout: Layout, limits: Limits) -> list[Diagnostic]:
    """LD0822 for every area that the program needs more of than there is."""
    needed = dict.fromkeys("IQM", 0)
    for root in layout.roots():
        at = root.variable.location
        if at is not None:
            needed[at.area] = max(needed[at.area], (end_of(at, root.variable.type) + 7) // 8)
    sizes = [(area, size, limits.image_bytes) for area, size in needed.items()]
    sizes.append(("D", lay_out(program).size, limits.data_bytes))
    return [findings.area_full(area, size, most) for area, size, most in sizes if size > most]
