"""Statistics and the drawing of the report: means with their confidence, panels of points as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist, fmean, stdev

WIDTH, HEIGHT, LEFT, TOP, GAP = 440, 230, 72, 34, 34


@dataclass(frozen=True, slots=True)
class Spread:
    """Mean and standard deviation of some runs; ``half``: half of the 95 % interval of the mean."""

    mean: float
    sd: float
    half: float


def t_quantile(freedom: int) -> float:
    """97.5 % of Student's t, by the expansion of Cornish and Fisher around the normal quantile; within 0.001
    of the tables from 7 degrees of freedom on. Raises ValueError below."""
    if freedom < 7:
        raise ValueError("at least 8 runs are needed for an interval")
    z = NormalDist().inv_cdf(0.975)
    return (z + (z**3 + z) / (4 * freedom) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
            + (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / (384 * freedom**3))


def spread(values: Sequence[float]) -> Spread:
    """Of one figure from several seeds. Raises ValueError for fewer than 8."""
    sd = stdev(values)
    return Spread(fmean(values), sd, t_quantile(len(values) - 1) * sd / len(values) ** 0.5)


def panels(title: str, parts: Sequence[tuple[str, Sequence[float]]], limit: float, unit: str) -> str:
    """An SVG: one panel a metric, its errors over the cycles as points with the mean of their amounts.
    ``limit``: the axis goes from minus to plus that, in ``unit``."""
    rows = (len(parts) + 1) // 2
    width, height = 2 * (LEFT + WIDTH) + GAP, TOP + rows * (HEIGHT + 2 * GAP)
    out = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
           'font-family="sans-serif" font-size="12">',
           f'<rect width="{width}" height="{height}" fill="white"/>',
           f'<text x="{LEFT}" y="20" font-size="15">{title}</text>']
    for number, (name, values) in enumerate(parts):
        x, y = LEFT + (number % 2) * (WIDTH + LEFT), TOP + GAP + (number // 2) * (HEIGHT + 2 * GAP)
        out += _panel(x, y, f"({'abcdefgh'[number]}) {name}", values, limit, unit)
    return "\n".join([*out, "</svg>", ""])


def _panel(x: int, y: int, name: str, values: Sequence[float], limit: float, unit: str) -> list[str]:
    def at(value: float) -> float:
        return round(y + HEIGHT / 2 - max(-limit, min(limit, value)) / limit * HEIGHT / 2, 1)

    mean = fmean(abs(v) for v in values)
    out = [f'<rect x="{x}" y="{y}" width="{WIDTH}" height="{HEIGHT}" fill="none" stroke="#999"/>',
           f'<text x="{x}" y="{y - 8}">{name}: mean amount {mean:.3f} {unit}</text>',
           f'<text x="{x + WIDTH / 2}" y="{y + HEIGHT + 18}" text-anchor="middle">'
           f'cycle 1 to {len(values)}</text>']
    for part in (-1.0, -0.5, 0.0, 0.5, 1.0):
        level = at(part * limit)
        out.append(f'<line x1="{x}" x2="{x + WIDTH}" y1="{level}" y2="{level}" stroke="#ddd"/>')
        shown = f"{part * limit:+.2f}" + (f" {unit}" if part == 1.0 else "")
        out.append(f'<text x="{x - 6}" y="{level + 4}" text-anchor="end">{shown}</text>')
    for sign in (-1, 1):
        level = at(sign * mean)
        out.append(f'<line x1="{x}" x2="{x + WIDTH}" y1="{level}" y2="{level}" stroke="#c33" '
                   'stroke-dasharray="6 4"/>')
    step = WIDTH / (len(values) + 1)
    for n, value in enumerate(values):
        fill = "#27c" if abs(value) <= limit else "white"  # beyond the axis: an empty point at its end
        out.append(f'<circle cx="{x + step * (n + 1):.1f}" cy="{at(value)}" r="2.4" fill="{fill}" '
                   'stroke="#27c"/>')
    return out
