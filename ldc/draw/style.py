"""The colours and fonts of SVG drawings, for light and dark screens."""

from __future__ import annotations

FONT = (
    "ui-monospace,SFMono-Regular,'Cascadia Mono','JetBrains Mono','DejaVu Sans Mono',Menlo,Consolas,"
    "'Liberation Mono',monospace"
)

SHAPES = f"""
.ldc text{{font:13px {FONT};white-space:pre}}
.ldc path{{fill:none;stroke-width:2}}
.ldc .ldc-rail{{stroke-width:4}}
.ldc .ldc-rule{{stroke-width:1}}
.ldc .ldc-box{{stroke-width:2}}
.ldc .ldc-back{{fill:none;stroke:none}}
.ldc .ldc-dot,.ldc .ldc-arrow{{stroke:none}}
.ldc .ldc-symbol text{{font-size:12px;font-weight:700}}
.ldc .ldc-type,.ldc .ldc-rung,.ldc .ldc-number,.ldc .ldc-pou,.ldc .ldc-jump{{font-weight:700}}
.ldc .ldc-note,.ldc .ldc-next{{font-size:11px}}
.ldc .ldc-comment{{font-style:italic}}
"""

LIGHT = {
    "paper": "#ffffff", "ink": "#1b2733", "wire": "#44525f", "soft": "#5b6875", "faint": "#7d8a97",
    "block": "#f2f5f8", "expression": "#fdf8e8", "rule": "#c6d0da", "tag": "#7a2bbf", "jump": "#0b5cad",
    "on": "#0a8f3c", "on_fill": "#dff5e6", "error": "#c81e1e", "error_fill": "#fde4e4",
    "warning": "#a15c00", "warning_fill": "#fdf0d5", "note": "#0b5cad", "note_fill": "#e0eefc",
}
DARK = {
    "paper": "#12181f", "ink": "#e6edf3", "wire": "#9aa8b6", "soft": "#aab6c2", "faint": "#8794a1",
    "block": "#1c2530", "expression": "#2a2617", "rule": "#3a4754", "tag": "#c99cf2", "jump": "#6cb2f7",
    "on": "#3ddc7c", "on_fill": "#12351f", "error": "#ff7b72", "error_fill": "#48191b",
    "warning": "#f0b449", "warning_fill": "#3d2e0c", "note": "#6cb2f7", "note_fill": "#132c47",
}

_COLOURS = """
.ldc-paper{fill:@paper}
.ldc text{fill:@ink}
.ldc path,.ldc .ldc-local{stroke:@wire}
.ldc .ldc-rail,.ldc .ldc-symbol path{stroke:@ink}
.ldc .ldc-dot,.ldc .ldc-arrow{fill:@wire}
.ldc .ldc-box{fill:@block;stroke:@ink}
.ldc .ldc-expression{fill:@expression}
.ldc .ldc-rule{stroke:@rule}
.ldc .ldc-number,.ldc .ldc-kind,.ldc .ldc-note,.ldc .ldc-comment,.ldc .ldc-next{fill:@faint}
.ldc .ldc-title,.ldc .ldc-about,.ldc .ldc-pin{fill:@soft}
.ldc .ldc-tag{fill:@tag}
.ldc .ldc-jump{fill:@jump}
.ldc path.ldc-on,.ldc .ldc-symbol.ldc-on path,.ldc rect.ldc-on{stroke:@on}
.ldc .ldc-dot.ldc-on,.ldc .ldc-arrow.ldc-on,.ldc .ldc-symbol.ldc-on text,
.ldc text.ldc-operand.ldc-on{fill:@on}
.ldc .ldc-symbol.ldc-on .ldc-back{fill:@on_fill}
"""
_MARK = """
.ldc .ldc-mark-% path,.ldc rect.ldc-mark-%{stroke:@%}
.ldc text.ldc-mark-%,.ldc .ldc-mark-% text{fill:@%}
.ldc .ldc-mark-% .ldc-back,.ldc rect.ldc-mark-%{fill:@%_fill}
"""


def _theme(colours: dict[str, str]) -> str:
    text = _COLOURS + "".join(_MARK.replace("%", mark) for mark in ("error", "warning", "note"))
    for name in sorted(colours, key=len, reverse=True):
        text = text.replace("@" + name, colours[name])
    return text


CSS = f"{SHAPES}{_theme(LIGHT)}@media (prefers-color-scheme:dark){{{_theme(DARK)}}}\n"
