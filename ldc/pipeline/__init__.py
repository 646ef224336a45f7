"""Runs the stages in order: sources, AST, model, graphs, trees, IL, image (DESIGN section 1).

A rung is the unit of work: built, checked, reduced, lowered and proved on its own.
"""

from __future__ import annotations

from ldc.pipeline.compile import compile_paths, compile_project
from ldc.pipeline.results import Compiled, Options, RungBuild

__all__ = ["Compiled", "Options", "RungBuild", "compile_paths", "compile_project"]
