"""Imports run one way (ADR 0001): an arrow that runs back fails here, with the line that draws it."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from plcopen_xml import coil, contact, ladder, rail

ROOT = Path(__file__).resolve().parent.parent

BASE = {"ldc", "ldc.beside", "ldc.collector", "ldc.patterns", "ldc.records", "ldc.source", "ldc.diagnostics", "ldc.types", "ldc.expr",
        "ldc.symbols", "ldc.free_names", "ldc.similar",
        "ldc.unfinished"}
FILES = {"ldc.durations", "ldc.codes", "ldc.render", "ldc.reading", "ldc.toml_spans", "ldc.toml_tables"}
COMPILER = ["ldc.library", "ldc.parser", "ldc.model", "ldc.graph", "ldc.il", "ldc.components", "ldc.backends"]

MAY_IMPORT: dict[str, set[str]] = {
    "ldc": set(),
    "ldc.beside": set(),
    "ldc.collector": set(),
    "ldc.patterns": set(),
    "ldc.records": set(),
    "ldc.source": {"ldc.records"},
    "ldc.types": {"ldc.records"},
    "ldc.diagnostics": {"ldc.records", "ldc.source"},
    "ldc.expr": {"ldc.records", "ldc.source", "ldc.types"},
    "ldc.symbols": {"ldc.patterns", "ldc.records", "ldc.source", "ldc.types"},
    "ldc.durations": {"ldc.patterns"},
    "ldc.free_names": set(),
    "ldc.similar": set(),
    "ldc.unfinished": set(),
    "ldc.codes": {"ldc.patterns", "ldc.records", "ldc.similar"},
    "ldc.render": BASE,
    "ldc.reports": BASE | {"ldc.codes"},
    "ldc.reading": BASE,
    "ldc.toml_spans": BASE,
    "ldc.toml_tables": BASE | {"ldc.toml_spans"},
    **{package: BASE | set(COMPILER[:index]) for index, package in enumerate(COMPILER)},
    "ldc.components": BASE | FILES | set(COMPILER[:5]),
    "ldc.backends": BASE | FILES | {"ldc.library", "ldc.il", "ldc.components"},
    "ldc.coordination": BASE | FILES,
    "ldc.manifest": BASE | FILES | {"ldc.parser", "ldc.model", "ldc.components", "ldc.coordination"},
    "ldc.pipeline": BASE | FILES | set(COMPILER) | {"ldc.manifest"},
    "ldc.draw": BASE | {"ldc.library", "ldc.parser"},
    "ldc.export": BASE | {"ldc.durations", "ldc.library", "ldc.parser", "ldc.model", "ldc.graph", "ldc.draw"},
    "ldc.cli": BASE
    | FILES
    | set(COMPILER)
    | {"ldc.coordination", "ldc.manifest", "ldc.pipeline", "ldc.draw", "ldc.export", "ldc.render", "ldc.reports", "runtime"},
    "runtime": BASE | {"ldc.library", "ldc.il"},
}
INSIDE_RUNTIME = {
    "runtime.protocol": {"ldc.records", "ldc.il.areas"},
    "runtime.processors": {"ldc.records", "runtime.protocol", "runtime.units"},
}
"""What parts of the runtime that run without a machine may import beside themselves."""
RUNTIME_NEVER_LOADS = ("ldc.parser", "ldc.model", "ldc.graph", "ldc.cli", "ldc.pipeline")


def modules() -> dict[str, Path]:
    found = {}
    for top in ("ldc", "runtime"):
        for path in sorted((ROOT / top).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


MODULES = modules()


def package(module: str) -> str:
    """The row of the table for a module: `ldc.il` for `ldc.il.lower`, `runtime` for `runtime.vm`."""
    parts = module.split(".")
    return parts[0] if parts[0] == "runtime" else ".".join(parts[:2])


@cache
def imports(module: str, at_start: bool = False) -> frozenset[tuple[str, int]]:
    """Our modules that a module imports, with the line; `at_start`: only those that loading it loads."""
    tree = ast.parse(MODULES[module].read_text(encoding="utf-8"))
    later = set()
    if at_start:
        for node in ast.walk(tree):
            checked = isinstance(node, ast.If) and ast.unparse(node.test) in (
                "TYPE_CHECKING",
                "typing.TYPE_CHECKING",
            )
            if checked or isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                later |= {id(inner) for inner in ast.walk(node)}
    found = set()
    for node in ast.walk(tree):
        if id(node) in later:
            continue
        if isinstance(node, ast.Import):
            found |= {(alias.name, node.lineno) for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = module.split(".")
                is_package = MODULES[module].name == "__init__.py"
                parts = parts[: len(parts) - node.level + is_package]
                base = ".".join([*parts, base] if base else parts)
            inner = {f"{base}.{alias.name}" for alias in node.names} & MODULES.keys()
            names = inner if len(inner) == len(node.names) else inner | {base}
            found |= {(name, node.lineno) for name in names}
    return frozenset((name, line) for name, line in found if name.split(".")[0] in ("ldc", "runtime"))


@pytest.mark.parametrize("module", sorted(MODULES))
def test_imports_run_one_way(module: str) -> None:
    own = package(module)
    assert (
        own in MAY_IMPORT
    ), f"{module} is in no layer: give it a row in tests/test_layers.py and ARCHITECTURE.md"
    back = [
        f"{MODULES[module].relative_to(ROOT)}:{line} imports {name}"
        for name, line in sorted(imports(module), key=lambda item: item[1])
        if package(name) not in MAY_IMPORT[own] | {own}
    ]
    assert not back, "\n".join(back)


@pytest.mark.parametrize("part", INSIDE_RUNTIME)
def test_transfers_and_states_need_no_machine(part: str) -> None:
    """The protocol is for any two processors that share memory, whatever runs on them."""
    allowed = INSIDE_RUNTIME[part] | {part}
    back = [
        f"{MODULES[module].relative_to(ROOT)}:{line} imports {name}"
        for module in MODULES
        if f"{module}.".startswith(f"{part}.")
        for name, line in imports(module)
        if not any(f"{name}.".startswith(f"{package}.") for package in allowed)
    ]
    assert not back, "\n".join(back)


def test_loading_the_runtime_loads_no_compiler() -> None:
    """The runtime runs where nothing is compiled: what it imports may not draw the compiler in either."""
    todo, came_from = [m for m in MODULES if package(m) == "runtime"], {}
    while todo:
        module = todo.pop()
        for name, line in imports(module, at_start=True):
            parents = [".".join(name.split(".")[:n]) for n in range(1, name.count(".") + 2)]
            for loaded in parents:
                if loaded in MODULES and loaded not in came_from:
                    came_from[loaded] = f"{MODULES[module].relative_to(ROOT)}:{line}"
                    todo.append(loaded)
    drawn = [f"{place} loads {m}" for m, place in came_from.items() if m.startswith(RUNTIME_NEVER_LOADS)]
    assert not drawn, "\n".join(sorted(drawn))


def test_no_module_reaches_for_a_private_name_of_another_package() -> None:
    reached = []
    for module, path in MODULES.items():
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module and package(node.module) != package(module):
                reached += [
                    f"{path.relative_to(ROOT)}:{node.lineno} takes {node.module}.{alias.name}"
                    for alias in node.names
                    if alias.name.startswith("_") and not alias.name.startswith("__")
                ]
    assert not reached, "\n".join(reached)


def test_a_compile_loads_nothing_slow_that_it_does_not_need(tmp_path: Path) -> None:
    """Start-up is most of a small compile. Each of these took some thousandths of a second of it."""
    (tmp_path / "plc.xml").write_text(ladder("a b : BOOL", rail(), contact(2, "a"), coil(3, "b", 2)))
    slow = ("dataclasses", "difflib", "inspect", "shutil", "threading", "ldc.parser.melsec.lines", "jinja2", "lark")
    code = ("import sys; from ldc.cli.main import main; "
            "status = main(['compile', 'plc.xml', '-o', 'plc.il', '--no-verify']); "
            f"print(status, *[name for name in {slow} if name in sys.modules])")
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True,
                          check=True, env={**os.environ, "PYTHONPATH": str(ROOT)})
    assert done.stdout.split() == ["0"], done.stdout + done.stderr
