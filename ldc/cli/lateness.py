"""How late processors were woken, as text and as a picture (docs/realtime.md)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from importlib.util import find_spec
from pathlib import Path

from ldc.cli.console import Failure, UsageError
from ldc.cli.output import replacing, write_file
from ldc.records import record
from runtime.realtime.lateness import Figures
from runtime.values import milliseconds

_BAR = 40
_WIDTH, _LEFT, _TOP, _ROW, _HEIGHT, _LABEL = 640, 48, 42, 30, 110, 44
"""Of the picture in SVG: its width, margins of a diagram, the room below it for texts, the height of its
bars, the width of a label."""


@record
class Processor:
    """``period_ns``: of what it does; ``figures``: lateness of its periods."""

    name: str
    period_ns: int
    figures: Figures


def told(processors: Sequence[Processor]) -> list[str]:
    """A table, and bars for each: how many periods began how late."""
    lines = [f"{'':10}{'period ms':>10}{'periods':>9}{'missed':>8}{'p50 us':>9}{'p99 us':>9}{'max us':>9}"]
    for p in processors:
        f = p.figures
        late = "".join(f"{_us(ns):>9}" for ns in (f.quantile(0.5), f.quantile(0.99), f.most_ns))
        lines.append(f"{p.name:10}{milliseconds(p.period_ns):>10}{f.count:>9}{f.missed:>8}{late}")
    for p in processors:
        lines.append(f"{p.name}: lateness in us")
        most = max((count for _, _, count in p.figures.rows()), default=1)
        for low, high, count in p.figures.rows():
            bar = "#" * -(-_BAR * count // most)
            lines.append(f"{_us(low):>9} .. {_us(high):<7} {bar:{_BAR}} {count}")
    return lines


def _us(ns: int) -> str:
    return f"{ns / 1000:.3g}" if ns < 10_000 else f"{ns / 1000:.0f}"


def check(target: str) -> None:
    """Before the run: whether a picture can be made. Raises UsageError, Failure."""
    kind = Path(target).suffix.lower()
    if kind not in (".svg", ".png"):
        raise UsageError(f"--plot writes .svg or .png, not `{target}`")
    if kind == ".png" and find_spec("matplotlib") is None:
        raise Failure("--plot needs matplotlib for PNG: pip install 'ldc[plot]', or name a file .svg")


def draw(target: str, processors: Sequence[Processor]) -> None:
    """Writes the picture that `check` has found possible."""
    if Path(target).suffix.lower() == ".svg":
        write_file(Path(target), svg(processors).encode())
    else:
        _png(Path(target), processors)


def svg(processors: Sequence[Processor]) -> str:
    """A diagram for each processor, below each other."""
    parts, at = [], 0
    for p in processors:
        rows = p.figures.rows()
        most = max((count for _, _, count in rows), default=1)
        step = (_WIDTH - 2 * _LEFT) / max(len(rows), 1)
        told_each = -int(-_LABEL // step)
        base = at + _TOP + _HEIGHT
        parts.append(f'<text x="{_LEFT}" y="{at + 20}" class="title">{escape(_title(p))}</text>')
        for n, (low, high, count) in enumerate(rows):
            # The few that are very late are what matters: heights are logarithms.
            height = _HEIGHT * math.log2(2 * count) / math.log2(2 * most) if count else 0.0
            x = _LEFT + n * step
            parts.append(f'<rect x="{x + 1:.1f}" y="{base - height:.1f}" width="{step - 2:.1f}" '
                         f'height="{height:.1f}"><title>{_us(low)} .. {_us(high)} us: {count}</title></rect>')
            if count:
                parts.append(f'<text x="{x + step / 2:.1f}" y="{base - height - 3:.1f}" class="count">'
                             f"{count}</text>")
            if (len(rows) - 1 - n) % told_each == 0:
                parts.append(f'<text x="{x + step:.1f}" y="{base + 14}">{_us(high)}</text>')
        parts.append(f'<path d="M{_LEFT} {base}H{_WIDTH - _LEFT}"/>')
        parts.append(f'<text x="{_WIDTH - _LEFT + 28}" y="{base + 14}">us</text>')
        at = base + _ROW
    style = ("text{font:11px sans-serif;text-anchor:middle}.title{font-size:12px;text-anchor:start}"
             ".count{font-size:9px}rect{fill:#4878a8}path{stroke:#333}")
    return (f'<svg xmlns="http://www.w3.org/2000/svg" width="{_WIDTH}" height="{at}" '
            f'viewBox="0 0 {_WIDTH} {at}"><style>{style}</style><rect width="100%" height="100%" '
            f'style="fill:#fff"/>\n' + "\n".join(parts) + "\n</svg>\n")


def _title(p: Processor) -> str:
    f = p.figures
    return (f"{p.name}, {milliseconds(p.period_ns)} ms: {f.count} periods, {f.missed} missed, lateness "
            f"p50 {_us(f.quantile(0.5))} us, p99 {_us(f.quantile(0.99))} us, max {_us(f.most_ns)} us")


def _png(target: Path, processors: Sequence[Processor]) -> None:
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 2.2 * len(processors)), layout="constrained")
    FigureCanvasAgg(figure)
    for axes, p in zip(figure.subplots(len(processors), squeeze=False)[:, 0], processors, strict=True):
        rows = p.figures.rows()
        axes.bar(range(len(rows)), [count for _, _, count in rows], width=0.9)
        axes.set_xticks([n + 0.5 for n in range(len(rows))], [_us(high) for _, high, _ in rows], fontsize=7)
        axes.set_yscale("log")  # as in `svg`
        axes.set_ylim(bottom=0.5)
        axes.set_title(_title(p), fontsize=8)
        axes.set_xlabel("lateness, us")
        axes.set_ylabel("periods")
    with replacing(target) as file:
        figure.savefig(file, format="png", dpi=120)
