"""Every diagnostic has one place that raises it, a page that explains it, and an example that shows it.

An example is `tests/errors/LDnnnn.ld`, checked by itself, or a folder `tests/errors/LDnnnn/` with several
files; the folder's file `command`, when it has one, holds the arguments of ldc (one line, run inside it), its
file `environment` variables (NAME=VALUE, one a line). Packages in the folder are found. Its file `runtime` holds
the arguments of an ldc that runs meanwhile, `before` commands that come first; `answer` is what a runtime of
another kind says.
`LDnnnn.txt` beside it is what the user then sees.
"""

from __future__ import annotations

import ast
import re
import shlex
from collections import defaultdict
from pathlib import Path

import pytest

from ldc.cli.main import main
from ldc.codes import codes, nearest, page
from online_runtime import runtime_of
from systems import REAL_TIME

ROOT = Path(__file__).resolve().parent.parent
ERRORS = ROOT / "tests" / "errors"
CODE = re.compile(r"LD\d{4}")


def internal(code: str) -> bool:
    """LD09xx means that ldc contradicts itself: no input is known that does it."""
    return code.startswith("LD09")


def raising_places() -> dict[str, list[str]]:
    places = defaultdict(list)
    for top in ("ldc", "runtime"):
        for path in sorted((ROOT / top).rglob("*.py")):
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
                if (
                    isinstance(node, ast.Constant)
                    and isinstance(node.value, str)
                    and CODE.fullmatch(node.value)
                ):
                    places[node.value].append(f"{path.relative_to(ROOT)}:{node.lineno}")
    return dict(places)


PLACES = raising_places()


def examples() -> dict[str, Path]:
    return {
        path.stem: path
        for path in sorted(ERRORS.iterdir())
        if CODE.fullmatch(path.stem) and path.suffix != ".txt"
    }


EXAMPLES = examples()


@pytest.mark.parametrize("code", sorted(PLACES))
def test_code_has_one_place_a_page_and_an_example(code: str) -> None:
    assert len(PLACES[code]) == 1, f"{code} is raised in several places: {', '.join(PLACES[code])}"
    assert code in codes(), f"{code} has no page ldc/pages/{code}.md"
    assert internal(code) or code in EXAMPLES, f"{code} has no example tests/errors/{code}.ld or {code}/"


@pytest.mark.parametrize("code", codes())
def test_page_belongs_to_a_code_and_can_be_read(code: str) -> None:
    text = page(code).text
    assert code in PLACES, f"ldc/pages/{code}.md explains what nothing raises"
    assert re.match(
        rf"# {code}: \S.*\n\n", text
    ), f"{code}.md must begin with `# {code}: title` and an empty line"
    assert text.count("```") % 2 == 0, f"{code}.md leaves a code block open"
    assert internal(code) or "```" in text, f"{code}.md shows no example"
    lines = text.rstrip("\n").split("\n")
    assert 8 <= len(lines) <= 40, f"{code}.md has {len(lines)} lines"
    assert max(map(len, lines)) <= 120, f"{code}.md has a line of more than 120 characters"


def _in_real_time(code: str) -> bool:
    runtime = EXAMPLES[code] / "runtime"
    return runtime.exists() and "--realtime" in runtime.read_text(encoding="utf-8")


@pytest.mark.parametrize("code", [pytest.param(code, marks=REAL_TIME if _in_real_time(code) else ())
                                  for code in sorted(EXAMPLES)])
def test_example_shows_what_the_user_sees(code: str, capsys, monkeypatch, golden_at) -> None:
    example = EXAMPLES[code]
    arguments = ["check", example.name]
    folder = ERRORS
    if example.is_dir():
        folder = example
        command = example / "command"
        arguments = shlex.split(command.read_text(encoding="utf-8")) if command.exists() else ["check", "."]
        monkeypatch.syspath_prepend(example)
        settings = example / "environment"
        for line in settings.read_text(encoding="utf-8").splitlines() if settings.exists() else ():
            monkeypatch.setenv(*line.split("=", 1))
    monkeypatch.chdir(folder)
    with runtime_of(folder, monkeypatch):
        if (folder / "before").exists():
            for line in (folder / "before").read_text(encoding="utf-8").splitlines():
                assert main(shlex.split(line)) == 0
            capsys.readouterr()
        status = main(arguments)
    shown = capsys.readouterr().err
    assert f"[{code}]" in shown, f"`ldc {shlex.join(arguments)}` in {folder} says:\n{shown}"
    assert status == (1 if "error[" in shown else 0)
    golden_at(ERRORS / f"{code}.txt", f"$ ldc {shlex.join(arguments)}\n{shown}")


def test_no_expectation_without_its_example() -> None:
    assert {path.stem for path in ERRORS.glob("*.txt")} <= set(EXAMPLES)
    assert set(EXAMPLES) <= set(PLACES), "an example for a code that nothing raises"


def test_a_code_with_a_slip_of_the_finger_is_found() -> None:
    code = codes()[0]
    assert page(code.lower()) == page(code)
    assert code in nearest(code.replace("0", "O", 1))
    assert code in nearest(code[2:])
