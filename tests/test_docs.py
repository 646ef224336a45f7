"""What the documents say is there, is there."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import msgspec
import pytest
from documents import findings, programs, replay

from ldc import manifest
from ldc.cli.arguments import make_parser
from ldc.cli.main import main
from ldc.components.toolchain import ARM_GCC, QEMU_ARM, find
from ldc.parser import parse_file
from ldc.parser.format import format_file
from ldc.source import SourceFile

ROOT = Path(__file__).resolve().parent.parent
DOCUMENTS = [ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CHANGELOG.md")] + sorted(
    (ROOT / "docs").rglob("*.md")
)


def exists(document: Path, name: str) -> bool:
    return any((folder / name).exists() for folder in (document.parent, ROOT, ROOT / "ldc"))


def prose(document: Path) -> str:
    return re.sub(r"^```.*?^```$", "", document.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)


def anchors(document: Path) -> set[str]:
    """What a heading can be linked by: its words in small letters with hyphens."""
    headings = re.findall(r"^#+ (.*)$", prose(document), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    for link in re.findall(r"\]\(([^)]+)\)", prose(document)):
        if link.startswith("http"):
            continue
        name, _, anchor = link.partition("#")
        target = document.parent / name if name else document
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


def test_every_page_is_in_the_index() -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    pages = {path.name for path in (ROOT / "docs").glob("*.md")} - {"README.md"}
    assert [page for page in sorted(pages) if f"]({page})" not in index] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_examples_compile_and_are_in_canonical_form(document: Path, tmp_path: Path) -> None:
    for block, program in programs(document.read_text(encoding="utf-8")):
        place = f"{document.name}:{block.line}"
        assert findings(program, tmp_path / "main.ld") == block.codes, place
        if not block.codes and program == block.text:
            file = parse_file(SourceFile("main.ld", program), manifest.Diagnostics())
            assert format_file(file) == program, place


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_consoles_show_what_the_commands_print(document: Path, tmp_path: Path, monkeypatch, golden_at) -> None:
    missing = [tool.command for tool in (ARM_GCC, QEMU_ARM) if find(tool) is None]
    if missing and document.name == "firmware.md":
        pytest.skip(f"{', '.join(missing)} not installed: script/bootstrap --with-arm")
    shutil.copytree(ROOT / "samples", tmp_path / "samples")
    monkeypatch.chdir(tmp_path)
    golden_at(document, replay(document.read_text(encoding="utf-8")))


def test_the_files_that_the_architecture_names_exist() -> None:
    document = ROOT / "ARCHITECTURE.md"
    named = set(
        re.findall(r"`((?:ldc|runtime|tests|docs|script)/[\w./-]*\w)`", document.read_text(encoding="utf-8"))
    )
    assert len(named) > 30
    assert [name for name in sorted(named) if not exists(document, name) and "LDnnnn" not in name] == []
    for package, files in re.findall(
        r"^\| `(ldc/\w+|runtime)` \|[^|]*\|([^|]*)\|$", document.read_text(), re.MULTILINE
    ):
        for name in re.findall(r"`([\w/]+\.(?:py|lark))`", files):
            assert (ROOT / package / name).exists(), f"{package}: no {name}"


def test_every_package_has_a_row_in_the_architecture() -> None:
    text = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    packages = [path.parent.name for path in (ROOT / "ldc").glob("*/__init__.py")]
    assert [name for name in packages if f"`ldc/{name}`" not in text] == []


def test_the_picture_of_the_readme_is_the_rung_of_its_first_program(tmp_path: Path, monkeypatch, golden_at) -> None:
    block, program = next(programs((ROOT / "README.md").read_text(encoding="utf-8")))
    monkeypatch.chdir(tmp_path)
    Path(block.file).write_text(program, encoding="utf-8")
    assert main(["draw", block.file, "--rung", "seal_in", "--svg", "rung.svg"]) == 0
    golden_at(ROOT / "docs" / "rung.svg", Path("rung.svg").read_text(encoding="utf-8"))


def test_the_example_of_the_manifest_is_one_and_every_key_is_described(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "manifest.md").read_text(encoding="utf-8")
    for table in (manifest.ProjectTable, manifest.TaskTable, manifest.MemoryTable, manifest.RunTable,
                  manifest.CostTable):
        for field in msgspec.structs.fields(table):
            assert f"`{field.name}`" in text
    (example,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    found = manifest.Diagnostics()
    source = manifest.SourceFile("ldc.toml", example)
    assert manifest.load_manifest(source, tmp_path, found) is not None and not len(found)


def test_every_option_is_in_the_description_of_the_command_line() -> None:
    text = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    (commands,) = [a.choices for a in make_parser()._actions if isinstance(a.choices, dict)]
    for name, parser in commands.items():
        line = " ".join(line for line in text.splitlines() if line.startswith(f"    ldc {name} "))
        for action in parser._actions:
            option = max(action.option_strings, key=len, default="")
            assert option in line or option == "--help", f"ldc {name}: {option}"
            for choice in action.choices or ():
                assert choice in line, f"ldc {name} {option}: {choice}"
