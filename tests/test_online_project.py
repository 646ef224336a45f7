"""What of `ldc.toml` a change brings along while the program runs, and what it cannot (docs/online.md)."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

import native
from ldc.cli import link, settled, shipped
from ldc.cli.console import Failure
from ldc.cli.main import main
from ldc.diagnostics import Diagnostics
from ldc.manifest import find_sources
from online_runtime import running, wait_until
from runtime.online.wire import Get
from systems import REAL_TIME

SAMPLE = Path(__file__).resolve().parents[1] / "samples" / "injection_machine"
ENGINES = [("--no-wait",), pytest.param(("--no-wait", "--engine", "native"), marks=native.needs_gcc)]
REALTIME = pytest.param(("--realtime",), marks=REAL_TIME)

PROJECT = '[project]\nname = "plant"\nmodules = ["beat", "counts"]\n'
MESSAGE = '[messages.beats]\nfrom = "beat.now"\nto = [{ module = "counts", flag = "heard" }]\n'
TEXT = """PROGRAM beat
VAR
    turn : TON;
    now  : BOOL;
END_VAR

RUNG
    [/now] <turn: TON(PT := T#30ms)> (now)
END_PROGRAM

PROGRAM counts
VAR_INPUT
    heard : BOOL;
END_VAR
VAR
    all : CTU;
END_VAR

RUNG
    [heard] <all: CTU(PV := 1000)>
END_PROGRAM
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "ldc.toml").write_text(PROJECT)
    (tmp_path / "main.ld").write_text(TEXT)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@contextmanager
def begun(monkeypatch: pytest.MonkeyPatch, *arguments: str) -> Iterator[subprocess.Popen]:
    with running(["run", ".", "--online", *arguments], monkeypatch) as process:
        yield process


def done(*actions: str) -> None:
    for action in actions:
        assert main(["online", *action.split()]) == 0


def value(path: str) -> str:
    return link.ask(link.socket_path(None, ""), Get(paths=[path])).values[0].value


@pytest.mark.parametrize("way", [*ENGINES, REALTIME], ids=" ".join)
def test_messages_come_to_a_program_that_was_started_without_any(folder, monkeypatch, capsys, way) -> None:
    with begun(monkeypatch, *way):
        (folder / "ldc.toml").write_text(PROJECT + MESSAGE)
        done("stage")
        assert re.search(r"^brought +\[messages\.beats\]$", capsys.readouterr().out, re.M)
        done("test --for 3600s")
        wait_until(lambda: int(value("counts.all.CV")) > 2)
        done("untest")
        before = value("counts.all.CV")
        wait_until(lambda: value("beat.now") == "1")
        wait_until(lambda: value("beat.now") == "0")
        assert value("counts.all.CV") == before, "the program before knows of no message"


@pytest.mark.parametrize("way", ENGINES, ids=" ".join)
def test_the_ejector_brings_its_message_along(tmp_path, monkeypatch, way) -> None:
    """What stands in ldc.toml when the module is inserted comes with it, in one step."""
    folder = tmp_path / "machine"
    shutil.copytree(SAMPLE, folder, ignore=shutil.ignore_patterns("__pycache__"))
    whole = (folder / "ldc.toml").read_text()
    message = re.search(r"\[messages\.part\].*?\n\n", whole, re.S)[0]
    without = whole.replace('"ejector", ', "").replace('    { module = "ejector" },\n', "").replace(message, "")
    (folder / "ldc.toml").write_text(without.replace('"ejector.start", "ejector.part", ', "").replace(
        ' "ejector.axis.position",', ""))
    (folder / "ejector.ld").rename(tmp_path / "ejector.ld")
    (folder / "inputs.csv").write_text("scan,auto_switch,guard,motor_ok\n0,1,1,1\n")
    monkeypatch.chdir(folder)
    with begun(monkeypatch, *way):
        wait_until(lambda: value("control.automatic") == "1")
        (tmp_path / "ejector.ld").rename(folder / "ejector.ld")
        with (folder / "ldc.toml").open("a") as file:
            file.write(f"\n{message}")
        done("insert ejector --after clamp", "test --for 3600s", "commit")
        wait_until(lambda: int(value("control.parts.CV")) > 0, 30)


def test_what_is_watched_changes_with_the_program(folder, monkeypatch) -> None:
    shown = folder / "out.txt"
    (folder / "ldc.toml").write_text(PROJECT + '[run]\nwatch = ["beat.now"]\n')
    with shown.open("w") as stream:
        popen = subprocess.Popen
        monkeypatch.setattr(subprocess, "Popen", lambda *a, **k: popen(*a, **{**k, "stdout": stream}))
        with begun(monkeypatch):
            (folder / "ldc.toml").write_text(PROJECT + MESSAGE + '[run]\nwatch = ["beat.now", "counts.all.CV"]\n')
            done("stage", "test --for 3600s")
            wait_until(lambda: int(value("counts.all.CV")) > 1)
            done("untest", "cancel")
    said = shown.read_text()
    assert said.index("beat.now=0") < said.index("counts.all.CV=0") < said.index("counts.all.CV=1")
    assert "counts.all.CV" not in said[said.rindex("\n", 0, -1):]


def test_what_cannot_be_watched_is_refused_where_it_stands(folder, monkeypatch, capsys) -> None:
    with begun(monkeypatch):
        (folder / "ldc.toml").write_text(PROJECT + '[run]\nwatch = ["beat.gone"]\n')
        assert main(["online", "stage"]) == 1
        assert "LD0620" in capsys.readouterr().err


@pytest.mark.parametrize(("arguments", "more", "brought", "stays"), [
    ((), '[run]\nperiod = "20ms"\n', [], ["[run] period"]),
    ((), '[run]\nwatch = ["beat.now"]\n', ["[run] watch"], []),
    (("--watch", "beat.now"), '[run]\nwatch = ["beat.now"]\n', [], ["[run] watch"]),
    ((), '[run]\nretain = "kept"\nretain_every = "2s"\n[memory]\nimage_bytes = 2048\n', [],
     ["[run] retain", "[run] retain_every", "[memory] image_bytes"]),
    ((), '[plant]\nfile = "plant.py"\n[cost]\ninstruction = "1us"\n', [], ["[plant] file", "[cost]"]),
    ((), '[safety]\nestop = "%MX0.0"\n[run]\nperiod = "20ms"\n', ["[safety] estop"], ["[run] period"]),
])
def test_what_a_change_of_settings_does_is_told(folder, monkeypatch, capsys, arguments, more, brought, stays) -> None:
    """Nothing is silently left out: it is brought, or it stays, and pull knows the text that was staged."""
    (folder / "plant.py").write_text("class Plant:\n    pass\n")
    (folder / "main.ld").write_text(TEXT.replace("now  :", "now AT %MX0.0 :"))
    with begun(monkeypatch, *arguments):
        (folder / "ldc.toml").write_text(PROJECT + more)
        done("stage")
        out, err = capsys.readouterr()
        assert re.findall(r"^warning\[LD0863\]: (.*) stays as", err, re.M) == stays
        assert re.findall(r"^brought +(.*)$", out, re.M) == brought
        done("report")
        assert re.findall(r"^brought +(.*)$", capsys.readouterr().out, re.M) == brought
        done("test --for 3600s", "commit")
        assert main(["pull", "--check"]) == (1 if stays else 0), "what stays is not what is here"
        err = capsys.readouterr().err
        assert re.findall(r"^error\[LD0866\]: (.*) is not what", err, re.M) == stays and "LD0830" not in err
        assert main(["online", "stage"]) == 0
        err = capsys.readouterr().err
        assert "nothing to stage" in err and err.count("LD0863") == len(stays), "it is told until the next start"


def test_sources_that_change_nothing_of_the_code_are_staged_too(folder, monkeypatch, capsys) -> None:
    with begun(monkeypatch):
        (folder / "main.ld").write_text(TEXT + "(* the end *)\n")
        assert main(["pull", "--check"]) == 1
        done("stage", "test --for 3600s", "commit")
        assert "its sources have changed: main.ld" in capsys.readouterr().err
        assert main(["pull", "--check"]) == 0


def settings(capsys) -> str:
    capsys.readouterr()
    done("status")
    return re.search(r"^settings (\w{12})(.*)$", capsys.readouterr().out, re.M)[1]


def test_settings_have_a_digest_of_their_own(folder, monkeypatch, capsys) -> None:
    """A message changes no code: the program is the same, what it is told is not; nor is it what was before."""
    with begun(monkeypatch):
        before = settings(capsys)
        (folder / "ldc.toml").write_text(PROJECT + MESSAGE)
        done("stage")
        assert settings(capsys) == before
        done("test --for 3600s")
        during = settings(capsys)
        assert during != before
        done("untest")
        assert settings(capsys) == before
        done("test --for 3600s", "commit")
        assert settings(capsys) == during
        lines = map(json.loads, (link.state_folder() / "s.audit.jsonl").read_text().splitlines())
        assert [line["settings"][:12] for line in lines if line["action"] in ("testing", "untested")] == [
            during, before, during]


def test_options_of_the_command_line_are_no_drift_when_they_say_the_same(folder, monkeypatch, capsys) -> None:
    text = PROJECT + '[run]\nperiod = "0.02s"\nretain = "kept"\nretain_every = "1500ms"\n'
    (folder / "ldc.toml").write_text(text)
    with begun(monkeypatch, "--period", "20ms", "--retain", "kept", "--retain-every", "3s"):
        done("status")
        assert re.search(r"^settings \w+, --period 20ms, --retain kept, --retain-every 3s$",
                         capsys.readouterr().out, re.M)
        assert main(["pull", "--check"]) == 1
        err = capsys.readouterr().err
        assert err.count("error[") == 1 and "`--retain-every 3s`" in err
        (folder / "ldc.toml").write_text(text.replace("1500ms", "3s"))
        done("stage", "test --for 3600s", "commit")
        assert main(["pull", "--check"]) == 0, "what differs was overridden, and is now what runs"


def test_a_file_that_a_setting_names_counts_with_its_contents(folder) -> None:
    (folder / "plant.py").write_text("class Plant:\n    pass\n")
    (folder / "ldc.toml").write_text(PROJECT + '[plant]\nfile = "plant.py"\n')
    manifest = find_sources([folder], Diagnostics()).manifest
    begin = settled.fixed(manifest)
    assert settled.stays(manifest, begin) == []
    (folder / "plant.py").write_text("class Plant:\n    heavy = True\n")
    told, = settled.stays(manifest, begin)
    assert (told.code, told.primary.text) == ("LD0863", "the file has other contents now")
    (folder / "plant.py").unlink()
    assert len(settled.stays(manifest, begin)) == 1


def test_sources_from_above_the_project_are_pulled_beside_it(tmp_path, monkeypatch, capsys) -> None:
    for name in ("plant", "shared"):
        (tmp_path / name).mkdir()
    (tmp_path / "plant" / "ldc.toml").write_text(PROJECT.replace("modules", 'sources = ["../shared/*.ld"]\nmodules'))
    (tmp_path / "shared" / "main.ld").write_text(TEXT)
    monkeypatch.chdir(tmp_path / "plant")
    with begun(monkeypatch):
        assert main(["pull", "-o", "running"]) == 0
        assert "in running/project" in capsys.readouterr().err
        assert main(["pull", "--check"]) == 0
        assert main(["check", "running/project"]) == 0
        assert main(["pull", "running/project", "--check"]) == 0


@pytest.mark.parametrize("path", ["/etc/passwd", "a/../../b", "..", "../" * 9 + "x", "a\0b", ""])
def test_no_path_of_a_runtime_leads_out_of_the_folder(tmp_path, path: str) -> None:
    with pytest.raises(Failure):
        shipped.write([("ldc.toml", ""), (path, "bad")], tmp_path / "new")
    with pytest.raises(Failure):
        shipped.write([("../project/ldc.toml", ""), ("ldc.toml", "")], tmp_path / "new")
    assert list(tmp_path.iterdir()) == []
