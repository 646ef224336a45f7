"""The rungs of ``_programs.mixed`` as PLCopen TC6 XML, drawn as an editor draws them: a pair of rails for
each rung, and positions, sizes and bends of wires for everything."""

from __future__ import annotations

from collections.abc import Iterator

from _programs import Network, Rung, inputs_of, mixed

_WIDE, _HIGH, _STEP, _ROW = 21, 15, 80, 40
_HEAD = """<?xml version="1.0" encoding="utf-8"?>
<project xmlns="http://www.plcopen.org/xml/tc6_0201">
<fileHeader companyName="" productName="bench" productVersion="1" creationDateTime="2024-01-01T00:00:00"/>
<contentHeader name="bench"><coordinateInfo><fbd><scaling x="10" y="10"/></fbd><ld><scaling x="10" y="10"/></ld>
<sfc><scaling x="10" y="10"/></sfc></coordinateInfo></contentHeader>
<types><dataTypes/><pous><pou name="bench" pouType="program"><interface><localVars>
"""
_MIDDLE = "</localVars></interface><body><LD>\n"
_TAIL = """</LD></body></pou></pous></types>
<instances><configurations><configuration name="config"><resource name="main">
<task name="cycle" priority="0" interval="T#20ms"><pouInstance name="bench" typeName="bench"/></task>
</resource></configuration></configurations></instances>
</project>
"""

Place = tuple[str, int, int]
"""Where power comes from: the attributes of a connection, and the position of the end of its wire."""


def plcopen_rungs(count: int, seed: int = 1) -> str:
    """A project with one program of ``count`` rungs."""
    variables = [f'<variable name="x{n}" address="%IX{n // 8}.{n % 8}"><type><BOOL/></type></variable>\n'
                 for n in range(inputs_of(count))]
    variables += [f'<variable name="m{n}"><type><BOOL/></type></variable>\n' for n in range(count)]
    for letter, type_, first, step in (("t", "TON", 0, 10), ("c", "CTU", 5, 20)):
        variables += [f'<variable name="{letter}{n}"><type><derived name="{type_}"/></type></variable>\n'
                      for n in range(first, count, step)]
    drawing = _Drawing()
    for n, rung in enumerate(mixed(count, seed)):
        drawing.rung(n, rung)
    return "".join([_HEAD, *variables, _MIDDLE, *drawing.lines, _TAIL])


class _Drawing:
    def __init__(self) -> None:
        self.lines: list[str] = []
        self.count = 0
        self.y = 20

    def rung(self, n: int, rung: Rung) -> None:
        left = self._element("leftPowerRail", 10, self.y, 10, 4 * _ROW, "", out='formalParameter=""')
        ends, x, rows = self.network(rung.network, [left], 60, self.y)
        if rung.block is not None:
            ends, x = self._block(n, rung.block, ends, left, x), x + 2 * _STEP
        coil = self._element("coil", x, self.y, _WIDE, _HIGH, f"<variable>m{n}</variable>", ends,
                             more=' negated="false" storage="none"')
        self._element("rightPowerRail", x + _STEP, self.y, 10, 4 * _ROW, "", [coil], out=None)
        self.y += max(4, rows) * _ROW + 20

    def network(self, network: Network, sources: list[Place], x: int, y: int) -> tuple[list[Place], int, int]:
        """Draws from left to right; what its end is fed by, where it ends, how many rows it takes."""
        rows = 1
        for item in network:
            if isinstance(item, list):
                ends, widest, row = [], x, 0
                for branch in item:
                    end, right, more = self.network(branch, sources, x, y + row * _ROW)
                    ends += end
                    widest, row = max(widest, right), row + more
                sources, x, rows = ends, widest, max(rows, row)
            else:
                closed, name = item
                more = f' negated="{"true" if closed else "false"}" edge="none" storage="none"'
                sources = [self._element("contact", x, y, _WIDE, _HIGH, f"<variable>{name}</variable>",
                                         sources, more=more)]
                x += _STEP
        return sources, x, rows

    def _block(self, n: int, block: tuple, sources: list[Place], left: Place, x: int) -> list[Place]:
        type_, preset = block[:2]
        value = f"T#{preset}ms" if type_ == "TON" else str(preset)
        given = self._element("inVariable", x - _STEP, self.y + 2 * _ROW, 50, 20,
                              f"<expression>{value}</expression>", more=' negated="false"')
        pins = [("IN", sources), ("PT", [given])]
        if type_ == "CTU":
            reset, _, _ = self.network((block[2],), [left], x - 2 * _STEP, self.y + _ROW)
            pins = [("CU", sources), ("R", reset), ("PV", [given])]
        outputs = ("Q", "ET" if type_ == "TON" else "CV")
        inner = "".join([
            "<inputVariables>\n",
            *(f'<variable formalParameter="{pin}">{self._wires(feed, x, self.y + row * _ROW, row * _ROW)}'
              "</variable>\n" for row, (pin, feed) in enumerate(pins)),
            "</inputVariables><inOutVariables/><outputVariables>\n",
            *(f'<variable formalParameter="{pin}"><connectionPointOut><relPosition x="{_STEP}" '
              f'y="{row * _ROW}"/></connectionPointOut></variable>\n' for row, pin in enumerate(outputs)),
            "</outputVariables>"])
        instance = f"{'t' if type_ == 'TON' else 'c'}{n}"
        _, right, y = self._element("block", x, self.y, _STEP, len(pins) * _ROW, inner, out=None,
                                    more=f' typeName="{type_}" instanceName="{instance}"')
        return [(f'refLocalId="{self.count}" formalParameter="Q"', right, y)]

    def _element(self, tag: str, x: int, y: int, width: int, height: int, inner: str,
                 sources: list[Place] = (), out: str | None = "", more: str = "") -> Place:
        """``out``: attributes of its output, None for none (or when it is in ``inner``)."""
        self.count += 1
        given = (f"<connectionPointOut {out}><relPosition x=\"{width}\" y=\"8\"/></connectionPointOut>\n"
                 if out is not None else "")
        self.lines.append(
            f'<{tag} localId="{self.count}" width="{width}" height="{height}"{more}>\n<position x="{x}" y="{y}"/>\n'
            f"{self._wires(sources, x, y, 8)}{given}{inner}</{tag}>\n")
        return f'refLocalId="{self.count}"', x + width, y + 8

    @staticmethod
    def _wires(sources: list[Place], x: int, y: int, drop: int) -> str:
        """The input at the left of something at (x, y), ``drop`` below its upper edge."""
        if not sources:
            return ""
        drawn: Iterator[str] = (
            f'<connection {source}><position x="{x}" y="{y + drop}"/><position x="{right}" y="{at}"/></connection>\n'
            for source, right, at in sources)
        return f'<connectionPointIn><relPosition x="0" y="{drop}"/>\n{"".join(drawn)}</connectionPointIn>\n'
