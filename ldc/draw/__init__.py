"""Rungs as pictures: Unicode text and SVG from the same layout."""

from ldc.draw.charts import chart_text, ladders_of
from ldc.draw.labels import BlockPins, notes_of, pins_from, standard_pins
from ldc.draw.locate import Locator
from ldc.draw.svg import pou_svg, project_svg, rung_svg
from ldc.draw.unicode import pou_text, rung_text

__all__ = [
    "BlockPins", "Locator", "chart_text", "ladders_of", "notes_of", "pins_from", "pou_svg", "pou_text",
    "project_svg", "rung_svg", "rung_text", "standard_pins",
]
