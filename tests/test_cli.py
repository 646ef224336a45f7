"""The commands as people use them: results, exit statuses, what goes where."""

from __future__ import annotations

import json
import os
import pty
import re
import signal
import stat
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ldc import __version__
from ldc.cli import crash, main as main_module
from ldc.cli.console import Failure
from ldc.cli.main import main
from ldc.codes import codes

MOTOR = """\
PROGRAM main
VAR
    start  AT %IX0.0 : BOOL;
    stop   AT %IX0.1 : BOOL;
    motor  AT %QX0.0 : BOOL;
    warm   : TON;
    ready  : BOOL;
END_VAR

RUNG seal_in "Start/stop with seal-in"
    { [start] | [motor] } [/stop] (motor)

RUNG
    [motor] <warm: TON(PT := T#20ms)> (ready)
END_PROGRAM
"""
DIVISION = """\
PROGRAM main
VAR
    divisor AT %IW0 : INT;
    motor   AT %QX0.0 : BOOL;
    alive   AT %QX0.1 : BOOL;
END_VAR

RUNG
    [100 / divisor > 2] (motor)

RUNG
    [TRUE] (alive)
END_PROGRAM
"""
COMMANDS = ("new", "check", "compile", "build", "run", "fmt", "draw", "bench", "explain", "doctor")


@pytest.fixture
def ldc(tmp_path: Path, monkeypatch, capsys):
    """Runs a command in a fresh folder that has `main.ld`; status, standard output, standard error."""
    monkeypatch.chdir(tmp_path)
    Path("main.ld").write_text(MOTOR)

    def run(*arguments: str) -> tuple[int, str, str]:
        status = main(arguments)
        captured = capsys.readouterr()
        return status, captured.out, captured.err

    return run


def process(*arguments: str, **settings) -> subprocess.Popen:
    return subprocess.Popen(
        [sys.executable, "-m", "ldc.cli", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **settings,
    )


# ---- the command line itself


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_a_help_text_with_examples(ldc, command: str) -> None:
    status, out, err = ldc(command, "--help")
    assert (status, err) == (0, "")
    assert "examples:\n  ldc " in out
    assert max(map(len, out.splitlines())) <= 110


def test_help_names_every_command_and_version_is_told(ldc) -> None:
    status, out, _ = ldc("--help")
    assert status == 0
    assert all(re.search(rf"^    {command} ", out, re.MULTILINE) for command in COMMANDS)
    assert ldc("--version") == (0, f"ldc {__version__}\n", "")
    status, out, err = ldc()
    assert (status, out) == (2, "") and err.startswith("usage: ldc")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["chekc", "main.ld"], "did you mean `check`?"),
        (["offline"], "unknown command `offline`"),
        (["check"], "missing: SRC"),
        (["check", "main.ld", "--fromat", "json"], "unrecognized arguments: --fromat json"),
        (["check", "main.ld", "--format", "jsno"], "did you mean `json`?"),
        (["compile", "main.ld", "--emit", "sh"], "unknown choice `sh`"),
        (["compile", "main.ld", "--format", "dot"], "--format is for --emit graph"),
        (["compile", "main.ld", "--max-paren-depth", "-1"], "not a whole number from 0"),
        (["run", "main.ld", "--for", "20"], "write a number and a unit"),
        (["run", "main.ld", "--scans", "0"], "not a whole number above 0"),
        (["run", "main.ld", "--scans", "5", "--for", "2s"], "not allowed with argument"),
        (["run", "main.ld", "--engine", "nativ"], "did you mean `native`?"),
        (["run", "main.ld", "--watch", "motro"], "did you mean `motor`?"),
        (["draw", "main.ld", "--rung", "seal-in"], "did you mean `seal_in`?"),
        (["explain", "LD0009"], "no page `LD0009`"),
    ],
)
def test_a_wrong_command_line_ends_with_2_and_says_what_is_wrong(
    ldc, arguments: list[str], said: str
) -> None:
    status, out, err = ldc(*arguments)
    assert (status, out) == (2, "")
    assert said in err
    assert err.startswith("ldc") and len(err.splitlines()) <= 2


# ---- check, explain, doctor


def test_check_says_what_it_did_and_writes_nothing(ldc, tmp_path: Path) -> None:
    status, out, err = ldc("check", "main.ld")
    assert (status, out) == (0, "")
    assert err == "checked 1 file, 2 rungs (2 proved): no errors\n"
    assert [p.name for p in tmp_path.iterdir()] == ["main.ld"]


def test_check_of_a_wrong_source(ldc) -> None:
    Path("main.ld").write_text(MOTOR.replace("(motor)", "(mtor)"))
    status, out, err = ldc("check", "main.ld")
    assert (status, out) == (1, "")
    assert re.search(r"^error\[LD\d{4}\]: .*\n +--> main.ld:11:36\n", err)
    assert "{ [start] | [motor] } [/stop] (mtor)" in err
    assert err.endswith("1 error\n")


def test_check_tells_a_proof_from_a_test(ldc) -> None:
    names = [f"v{n}" for n in range(20)]
    rung = "RUNG\n    " + " ".join(f"[{name}]" for name in names[1:]) + " (v0)\n"
    Path("main.ld").write_text(
        f"PROGRAM main\nVAR\n    {', '.join(names)} : BOOL;\nEND_VAR\n{rung}RUNG [v1] (v2)\nEND_PROGRAM\n"
    )
    assert ldc("check", "main.ld")[2].endswith("checked 1 file, 2 rungs (1 proved, 1 tested): no errors\n")
    assert ldc("check", "main.ld", "--no-verify")[2].endswith("checked 1 file, 2 rungs: no errors\n")


@pytest.mark.parametrize("form", ["json", "sarif"])
def test_check_for_machines_puts_the_findings_on_standard_output(ldc, form: str) -> None:
    assert ldc("check", "main.ld", "--format", form)[0] == 0
    Path("main.ld").write_text(MOTOR.replace("(motor)", "(mtor)"))
    status, out, err = ldc("check", "main.ld", "--format", form)
    assert (status, err) == (1, "")
    found = json.loads(out)
    if form == "json":
        assert [item["primary"]["line"] for item in found] == [11]
    else:
        assert len(found["runs"][0]["results"]) == 1
    assert ldc("check", "gone.ld", "--format", form)[0] == 1


@pytest.mark.parametrize(
    "text",
    [
        "",
        "\0",
        "RUNG",
        "PROGRAM",
        "PROGRAM main\nEND_PROGRAM",
        "{" * 500,
        "(*",
        "'",
        "é" * 99,
        "PROGRAM main\nRUNG\n" + "{ " * 200 + "[a]" + " }" * 200 + "\nEND_PROGRAM",
    ],
)
@pytest.mark.parametrize("extension", ["ld", "st", "il"])
def test_no_source_however_broken_is_an_internal_fault(ldc, text: str, extension: str) -> None:
    path = f"x.{extension}"
    Path(path).write_text(text)
    for arguments in (
        ["check", path],
        ["compile", path, "--emit", "ast"],
        ["run", path],
        ["draw", path],
        ["fmt", path],
    ):
        status, _, err = ldc(*arguments)
        assert status in (0, 1), err
        assert "Traceback" not in err


def test_explain_prints_the_page(ldc) -> None:
    status, out, _ = ldc("explain", "ld0601")
    assert status == 0 and out.startswith("# LD0601: ")
    assert ldc("explain", "[LD0601]")[1] == out
    assert ldc("explain", "LD061")[2].startswith("ldc explain: no page `LD061`; near it: LD06")
    assert "LD0601" in codes()


def test_doctor_names_versions_and_what_to_install(ldc, monkeypatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    status, out, _ = ldc("doctor")
    assert status == 0
    assert f"ldc {__version__}" in out and re.search(r"ok  lark +\d", out)
    assert "apt-get install gcc-arm-none-eabi" in out


# ---- compile


def test_compile_prints_il(ldc) -> None:
    status, out, err = ldc("compile", "main.ld")
    assert (status, err) == (0, "")
    assert "PROGRAM main" in out and "LD" in out and "END_PROGRAM" in out


def test_what_compile_emits_can_be_compiled_again(ldc) -> None:
    first = ldc("compile", "main.ld")[1]
    Path("again.il").write_text(first)
    assert ldc("compile", "again.il") == (0, first, "")


@pytest.mark.parametrize("emit", ["il", "ast", "graph", "tree"])
def test_each_stage_prints_the_same_every_time_to_stdout_and_to_a_file(ldc, emit: str) -> None:
    out = ldc("compile", "main.ld", "--emit", emit)[1]
    assert ldc("compile", "main.ld", "--emit", emit, "-o", "out.txt") == (0, "", "")
    assert Path("out.txt").read_text() == out != ""
    assert ldc("compile", "main.ld", "--emit", emit, "-o", "-")[1] == out


def test_the_ast_does_not_depend_on_the_layout_of_the_text(ldc) -> None:
    before = ldc("compile", "main.ld", "--emit", "ast")[1]
    Path("main.ld").write_text(MOTOR.replace("    ", " ").replace(") (", ")\n("))
    assert ldc("compile", "main.ld", "--emit", "ast")[1] == before


def test_graphs_for_graphviz(ldc) -> None:
    dot = ldc("compile", "main.ld", "--emit", "graph", "--format", "dot")[1]
    assert len(re.findall(r"^digraph ", dot, re.MULTILINE)) == 2
    assert ldc("compile", "main.ld", "--emit", "graph", "-o", "x.dot")[0] == 0
    assert Path("x.dot").read_text() == dot


def test_images_are_the_same_bytes_every_time(ldc) -> None:
    for name in ("a.img", "b.img"):
        assert ldc("compile", "main.ld", "--emit", "image", "-o", name)[0] == 0
    assert Path("a.img").read_bytes() == Path("b.img").read_bytes() != b""


def test_timings_go_to_standard_error(ldc) -> None:
    status, out, err = ldc("compile", "main.ld", "--timings")
    assert status == 0 and "parse" not in out
    assert re.search(r"^parse +\d+\.\d ms", err, re.MULTILINE)


def test_output_files_are_replaced_in_one_step_and_keep_their_permissions(ldc, tmp_path: Path) -> None:
    Path("out.il").write_text("old")
    os.chmod("out.il", 0o640)
    assert ldc("compile", "main.ld", "-o", "out.il")[0] == 0
    assert stat.S_IMODE(Path("out.il").stat().st_mode) == 0o640
    status, _, err = ldc("compile", "main.ld", "-o", "no/where.il")
    assert status == 1 and "cannot write" in err
    assert sorted(p.name for p in tmp_path.iterdir()) == ["main.ld", "out.il"]
    assert ldc("compile", "main.ld", "-o", "/dev/null")[0] == 0
    assert stat.S_ISCHR(os.stat("/dev/null").st_mode)


# ---- run


def test_run_says_what_changed(ldc) -> None:
    Path("in.csv").write_text("scan,start\n1,1\n3,0\n6,\n")
    status, out, err = ldc("run", "main.ld", "--inputs", "in.csv", "--watch", "motor,warm.ET,ready")
    assert status == 0
    assert out.splitlines() == [
        "scan     0         0 ms  motor=0  warm.ET=0  ready=0",
        "scan     1        10 ms  motor=1",
        "scan     2        20 ms  warm.ET=10",
        "scan     3        30 ms  warm.ET=20  ready=1",
    ]
    assert err == "7 scans, 70 ms of virtual time\n"


def test_trace_has_one_row_a_scan(ldc) -> None:
    Path("in.csv").write_text("scan,start\n1,TRUE\n2,0\n")
    arguments = ["run", "main.ld", "--inputs", "in.csv", "--period", "500us", "--scans", "4"]
    assert ldc(*arguments, "--trace", "out.csv")[0] == 0
    assert Path("out.csv").read_bytes() == (
        b"scan,t_ms,start,stop,motor\n0,0,0,0,0\n1,0.5,1,0,1\n2,1,0,0,1\n3,1.5,0,0,1\n"
    )
    status, out, _ = ldc(*arguments, "--trace", "-")
    assert out.encode() == Path("out.csv").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "scans"),
    [
        ([], 100),
        (["--scans", "7"], 7),
        (["--for", "2s"], 200),
        (["--for", "25ms"], 3),
        (["--for", "1s", "--period", "250ms"], 4),
    ],
)
def test_how_long_a_run_is(ldc, arguments: list[str], scans: int) -> None:
    _, out, _ = ldc("run", "main.ld", *arguments, "--trace", "-")
    assert len(out.splitlines()) == scans + 1


def test_a_fault_is_shown_where_it_happened_and_the_trace_goes_on(ldc) -> None:
    Path("main.ld").write_text(DIVISION)
    Path("in.csv").write_text("scan,divisor\n0,5\n2,0\n")
    status, out, err = ldc(
        "run", "main.ld", "--inputs", "in.csv", "--scans", "4", "--trace", "-", "--watch", "motor,alive"
    )
    assert status == 1
    assert out.splitlines()[1:] == ["0,0,1,1", "1,10,1,1", "2,20,0,0", "3,30,0,0"]
    assert "error[LD0801]" in err and "--> main.ld:9:" in err and "in scan 2" in err


def test_an_interrupted_or_impossible_trace_leaves_no_file(ldc, tmp_path: Path) -> None:
    assert ldc("run", "main.ld", "--trace", "no/out.csv")[0] == 1
    assert ldc("run", "main.ld", "--inputs", "gone.csv")[0] == 1
    assert [p.name for p in tmp_path.iterdir()] == ["main.ld"]


def test_a_terminal_without_unicode_shows_drawings_in_ascii(tmp_path: Path) -> None:
    (tmp_path / "main.ld").write_text(MOTOR.replace("Start/stop", "Stänge →"))
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "ldc.cli", "draw", "main.ld", "--rung", "seal_in"]
    drawing = subprocess.Popen(
        command, cwd=tmp_path, stdout=theirs, env=os.environ | {"PYTHONIOENCODING": "latin-1"}
    )
    os.close(theirs)
    shown = b""
    while part := read_or_end(ours):
        shown += part
    os.close(ours)
    assert drawing.wait() == 0
    lines = shown.decode("latin-1").split("\r\n")
    assert lines[0] == "1  seal_in  Stänge > with seal-in"
    assert any(line.startswith("|--| |---+--|/|---") for line in lines), lines


def read_or_end(terminal: int) -> bytes:
    """What a terminal shows next; nothing when its last writer is gone."""
    try:
        return os.read(terminal, 65536)
    except OSError:
        return b""


def test_results_are_utf_8_whatever_the_terminal_speaks(tmp_path: Path) -> None:
    (tmp_path / "main.ld").write_text(MOTOR.replace("Start/stop", "Stänge"), encoding="utf-8")
    command = [sys.executable, "-m", "ldc.cli", "compile", "main.ld"]
    made = subprocess.run(
        command, cwd=tmp_path, capture_output=True, env=os.environ | {"PYTHONIOENCODING": "latin-1"}
    )
    assert "Stänge" in made.stdout.decode("utf-8")


def test_a_new_project_is_there_whole_or_not_at_all(ldc, monkeypatch) -> None:
    from ldc.cli import new

    write, room = new.write_file, iter([True, True, False])

    def full(path: Path, data: bytes) -> None:
        if not next(room):
            raise Failure(f"cannot write `{path}`: No space left on device")
        write(path, data)

    monkeypatch.setattr(new, "write_file", full)
    assert ldc("new", "plant") == (1, "", "ldc new: cannot write `plant/inputs.csv`: No space left on device\n")
    assert not Path("plant").exists()
    monkeypatch.setattr(new, "write_file", write)
    assert ldc("new", "Übergabe 2")[2] == "made the project `Ubergabe_2` in Übergabe 2\n"
    assert ldc("new", "") == (2, "", "ldc new: DIR is empty: name a folder\n")


@pytest.mark.parametrize("command", [
    ("check",), ("compile",), ("compile", "--emit", "c"), ("run", "--scans", "1"),
    ("run", "--scans", "1", "--events", "-"), ("check", "--format", "sarif"),
    ("run", "--online", "--no-wait", "--scans", "1", "--socket", "s", "--audit", "log"),
])
def test_names_of_files_that_are_no_utf_8(ldc, command: tuple[str, ...]) -> None:
    """Archives of other systems bring them."""
    folder = os.fsdecode(b"\xfcber")
    os.mkdir(folder)
    Path(folder, "ldc.toml").write_text("")
    Path(folder, os.fsdecode(b"st\xe4nder.ld")).write_text(MOTOR)
    for source in (folder, os.path.join(folder, os.fsdecode(b"st\xe4nder.ld"))):
        status, out, err = ldc(command[0], source, *command[1:])
        assert status == 0, err


@pytest.mark.parametrize(("options", "said"), [
    (("--trace", "-", "--events", "-"), "--trace and --events are both standard output"),
    (("--events", "out.csv", "--trace", "./out.csv"), "--trace and --events are both the file `out.csv`"),
    (("--inputs", "in.csv", "--trace", "in.csv"), "--inputs and --trace are both the file `in.csv`"),
    (("--board", "mine.toml"), "--board is for firmware"),
    (("--target", "cortex-m3", "--events", "out.csv"), "--events is for a run on this computer"),
])
def test_options_of_a_run_that_mean_nothing_together(ldc, options: tuple[str, ...], said: str) -> None:
    Path("in.csv").write_text("scan,start\n1,1\n")
    status, out, err = ldc("run", "main.ld", *options)
    assert (status, out) == (2, "") and said in err
    assert Path("in.csv").read_text() == "scan,start\n1,1\n" and not Path("out.csv").exists()


@pytest.mark.parametrize("options", [
    ("--realtime", "--plot", "no/late.svg"), ("--ring", "no/ring.csv", "--trigger", "motor rises"),
])
def test_what_is_written_at_the_end_is_known_to_be_impossible_before(ldc, options: tuple[str, ...]) -> None:
    status, out, err = ldc("run", "main.ld", "--scans", "5", *options)
    assert (status, out) == (1, "") and re.fullmatch(r"ldc run: cannot write `no/[^`]+`: No such file.*\n", err)


def test_a_result_on_standard_output_is_there_alone(ldc) -> None:
    events = ldc("run", "main.ld", "--scans", "2", "--events", "-")[1]
    rows = ["t_ms,processor,unit,index,detail", "0,master,C.LOGIC,0,", "10,master,C.LOGIC,0,"]
    assert events.splitlines() == rows
    Path("in.csv").write_text("scan,start\n1,1\n")
    ring = ("--ring", "-", "--trigger", "motor rises", "--before", "1", "--after", "0", "--watch", "motor")
    out = ldc("run", "main.ld", "--inputs", "in.csv", "--scans", "4", *ring)[1]
    assert out == "scan,t_ms,motor\n0,0,0\n1,10,1\n"


def test_the_project_says_what_the_command_line_does_not(ldc) -> None:
    Path("ldc.toml").write_text('[run]\nperiod = "1ms"\nwatch = ["motor"]\ninputs = "in.csv"\n')
    Path("in.csv").write_text("scan,start\n1,1\n")
    assert ldc("run", ".", "--trace", "-")[1] == "scan,t_ms,motor\n0,0,0\n1,1,1\n"
    out = ldc("run", ".", "--trace", "-", "--period", "2ms", "--watch", "start", "--scans", "2")[1]
    assert out == "scan,t_ms,start\n0,0,0\n1,2,1\n"


def test_a_project_without_a_program_has_nothing_to_run(ldc) -> None:
    Path("main.ld").write_text("FUNCTION_BLOCK b\nVAR_INPUT\n    x : BOOL;\nEND_VAR\nEND_FUNCTION_BLOCK\n")
    status, _, err = ldc("run", "main.ld")
    assert status == 1 and "no PROGRAM to run" in err


# ---- new, fmt, draw, bench


def test_a_new_project_is_in_form_compiles_and_gives_its_expected_trace(ldc) -> None:
    assert ldc("new", "my plant")[0] == 0
    assert ldc("fmt", "my plant", "--check")[0] == 0
    assert ldc("check", "my plant")[2] == "checked 1 file, 2 rungs (2 proved): no errors\n"
    assert ldc("run", "my plant", "--trace", "-")[1] == Path("my plant/expected.csv").read_text()
    assert 'name = "my_plant"' in Path("my plant/ldc.toml").read_text()
    status, _, err = ldc("new", "my plant")
    assert status == 2 and "not an empty folder" in err
    assert ldc("new", "main.ld")[0] == 2
    assert ldc("new", "main.ld/below")[0] == 1


def test_fmt_changes_what_is_not_canonical_and_nothing_else(ldc) -> None:
    assert ldc("fmt", "main.ld")[0] == 0
    canonical = Path("main.ld").read_bytes()
    Path("ugly.ld").write_bytes(b"\xef\xbb\xbf" + canonical.replace(b"\n", b"\r\n"))
    Path("broken.ld").write_text("PROGRAM main RUNG [a (b)")
    assert ldc("fmt", "main.ld", "ugly.ld", "--check") == (
        1,
        "",
        "would reformat ugly.ld\n1 file of 2 would change\n",
    )
    status, out, err = ldc("fmt", "main.ld", "ugly.ld", "broken.ld")
    assert (status, out) == (1, "")
    assert err.startswith("reformatted ugly.ld\nerror[LD01")
    assert Path("ugly.ld").read_bytes() == canonical
    assert Path("broken.ld").read_text() == "PROGRAM main RUNG [a (b)"


def test_draw(ldc) -> None:
    status, out, _ = ldc("draw", "main.ld")
    assert status == 0
    assert (
        out.startswith("PROGRAM  main\n\n1  seal_in  Start/stop with seal-in\n")
        and "─┤ ├─" in out
        and "T#20ms" in out
    )
    one = ldc("draw", "main.ld", "--rung", "SEAL_IN")[1]
    assert (
        one == ldc("draw", "main.ld", "--rung", "1")[1] == ldc("draw", "main.ld", "--rung", "main.seal_in")[1]
    )
    assert one.startswith("1  seal_in  Start/stop with seal-in\n")
    assert ldc("draw", "main.ld", "--svg", "out.svg")[:2] == (0, "")
    assert Path("out.svg").read_text().startswith("<svg ")
    assert ldc("draw", "main.ld", "--svg", "-")[1] == Path("out.svg").read_text()


def test_bench_prints_what_machines_read(ldc) -> None:
    status, out, _ = ldc("bench", "main.ld", "--json", "--stimulus", "flip")
    found = json.loads(out)
    assert status == 0
    assert found.keys() == {"engine", "scans", "contacts", "ns_per_scan", "ns_per_contact", "spread", "state"}
    assert found["contacts"] == 4 and found["engine"] == "vm"
    assert found["ns_per_contact"] * 4 == pytest.approx(found["ns_per_scan"])
    assert json.loads(ldc("bench", "main.ld", "--json", "--stimulus", "flip")[1])["state"] == found["state"]


# ---- how it ends


def test_a_bug_becomes_a_report_and_one_line(ldc, monkeypatch) -> None:
    def broken(options):
        raise RuntimeError("two\nlines \x1b[31m")

    monkeypatch.setattr("ldc.cli.doctor.run", broken)
    status, out, err = ldc("doctor")
    assert (status, out) == (3, "")
    assert re.fullmatch(
        r"ldc: internal fault \(RuntimeError: two lines .*\); this is a bug in ldc, please report it "
        r"with (ldc-bug-[\w-]+\.txt)\n",
        err,
    )
    (report,) = Path(".").glob("ldc-bug-*.txt")
    text = report.read_text()
    assert all(
        part in text for part in (f"ldc {__version__}", "command: ldc doctor", "Traceback", "in broken")
    )


def test_a_bug_is_reported_when_the_folder_cannot_be_written(ldc, monkeypatch, tmp_path: Path) -> None:
    monkeypatch.setattr(crash, "Path", lambda text: tmp_path / "no" / "where" if text == "." else Path(text))
    monkeypatch.setattr(crash.tempfile, "gettempdir", lambda: str(tmp_path))
    assert crash.write_dump(ValueError("x"), ["check"]).parent == tmp_path


def test_the_result_of_a_failed_self_check_is_a_bug(ldc, monkeypatch) -> None:
    from ldc.il.verify import Verdict

    monkeypatch.setattr(
        "ldc.pipeline.rungs.verify", lambda *a, **k: Verdict("wrong", 1, "il", "motor", (("start", True),))
    )
    status, _, err = ldc("check", "main.ld")
    assert status == 3 and "error[LD0901]" in err and "ldc: internal fault" in err
    assert "start = TRUE" in next(Path(".").glob("ldc-bug-*.txt")).read_text()


@pytest.mark.parametrize("closed", [">&-", "2>&-"])
def test_a_stream_that_is_closed_gets_nothing(tmp_path: Path, closed: str) -> None:
    (tmp_path / "main.ld").write_text(MOTOR)
    command = f'"{sys.executable}" -m ldc.cli run main.ld --scans 2 --trace out.csv {closed}'
    ended = subprocess.run(["sh", "-c", command], cwd=tmp_path, capture_output=True, text=True)
    assert ended.returncode == 0 and "Traceback" not in ended.stderr, ended.stderr
    assert (tmp_path / "out.csv").read_text().startswith("scan,t_ms,") and len(list(tmp_path.iterdir())) == 2


def test_a_folder_is_no_retain_file(ldc) -> None:
    Path("main.ld").write_text(MOTOR)
    status, _, err = ldc("run", "main.ld", "--scans", "1", "--retain", ".")
    assert status == 1 and "error[LD0854]" in err and "Is a directory" in err


def test_interrupt_ends_quietly_with_130(ldc, monkeypatch) -> None:
    def interrupted(options):
        raise KeyboardInterrupt

    monkeypatch.setattr("ldc.cli.doctor.run", interrupted)
    assert ldc("doctor") == (130, "", "")


@pytest.mark.parametrize("module", ["argparse", "platform"])
def test_an_interrupt_while_modules_are_loaded_shows_no_traceback(tmp_path: Path, module: str) -> None:
    """argparse is what the command line needs first from Python, platform is needed by one command."""
    (tmp_path / f"{module}.py").write_text("import os, signal\nos.kill(os.getpid(), signal.SIGINT)\n")
    paths = os.pathsep.join([str(tmp_path), str(Path(__file__).parent.parent)])
    command = [sys.executable, "-m", "ldc.cli", "doctor"]
    ended = subprocess.run(command, capture_output=True, env=os.environ | {"PYTHONPATH": paths})
    assert (ended.returncode, ended.stderr) == (-signal.SIGINT, b"")


def test_an_interrupt_while_a_class_is_made_is_one_too(ldc, monkeypatch) -> None:
    class Late:
        def __set_name__(self, owner, name):
            raise KeyboardInterrupt

    monkeypatch.setattr("ldc.cli.doctor.run", lambda options: type("Made", (), {"field": Late()}))
    assert ldc("doctor") == (130, "", "")


def test_a_real_interrupt_leaves_no_trace_file_behind(tmp_path: Path) -> None:
    (tmp_path / "main.ld").write_text(MOTOR)
    running = process("run", "main.ld", "--scans", "100000000", "--trace", "out.csv", cwd=tmp_path)
    deadline = time.monotonic() + 30
    while not list(tmp_path.glob(".ldc-*")) and time.monotonic() < deadline:
        time.sleep(0.02)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=30)
    assert (running.returncode, out, err) == (130, "", "")
    assert [p.name for p in tmp_path.iterdir()] == ["main.ld"]


def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "main.ld").write_text(MOTOR)
    running = process("run", "main.ld", "--scans", "1000000", "--trace", "-", cwd=tmp_path)
    assert running.stdout.readline() == "scan,t_ms,start,stop,motor\n"
    running.stdout.close()
    assert running.stderr.read() == ""
    assert running.wait(timeout=30) == main_module.BROKEN_PIPE
    running.stderr.close()


def test_no_color_in_a_pipe(tmp_path: Path) -> None:
    (tmp_path / "main.ld").write_text(MOTOR.replace("(motor)", "(mtor)"))
    running = process("check", "main.ld", cwd=tmp_path)
    _, err = running.communicate(timeout=30)
    assert "error[" in err and "\x1b" not in err
