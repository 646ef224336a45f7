"""Fixtures that every test shares: goldens, which a person reads in a review and one option renews."""

from __future__ import annotations

import difflib
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pauses
import pytest

TESTS = Path(__file__).resolve().parent
GOLDEN = TESTS / "golden"


if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a job that a script starts in the background
    signal.signal(signal.SIGINT, signal.default_int_handler)  # what tests start and interrupt inherits it


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--update-golden",
        action="store_true",
        default=False,
        help="write what the tests produce now into the golden files instead of comparing with them",
    )


def compare(path: Path, text: str, update: bool) -> None:
    """Fail with a unified diff unless the file at `path` holds `text`; with `update`, write it instead.

    A golden that does not exist fails: an expectation that nobody has read proves nothing.
    """
    shown = path.relative_to(TESTS.parent) if path.is_relative_to(TESTS.parent) else path
    if update:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(text.encode("utf-8"))
        return
    if not path.exists():
        pytest.fail(f"no golden {shown}: run pytest --update-golden, then read what it wrote", pytrace=False)
    expected = path.read_bytes().decode("utf-8")
    if expected == text:
        return
    difference = difflib.unified_diff(
        expected.splitlines(keepends=True), text.splitlines(keepends=True), str(shown), "produced now"
    )
    lines = [line if line.endswith("\n") else line + "\n\\ no newline at the end\n" for line in difference]
    pytest.fail(
        f"{shown} differs (if that is meant, run pytest --update-golden):\n{''.join(lines)}", pytrace=False
    )


class RealTime:
    """Tests in real time: one that failed in each of its tries is skipped if the computer paused in each."""

    def __init__(self) -> None:
        self.watchers: pauses.Watchers | None = None
        self.begun, self.lengths = 0.0, [0.0]

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        if item.get_closest_marker("real_time") is None:
            return
        self.watchers = self.watchers or pauses.Watchers()
        self.begun = time.monotonic()
        if item.execution_count == 1:
            self.lengths = []

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo) -> Iterator:
        report = yield
        if report.failed and call.when == "call" and item.get_closest_marker("real_time") is not None:
            self.lengths.append(self.watchers.longest(self.begun))
            if len(self.lengths) == pauses.TRIES and all(self.lengths):
                report.outcome = "skipped"
                told = ", ".join(f"{length * 1e3:.0f} ms" for length in self.lengths)
                report.longrepr = (str(item.path), 0, f"Skipped: the computer paused in each try: {told}")
        return report

    def pytest_sessionfinish(self) -> None:
        if self.watchers is not None:
            self.watchers.end()


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(RealTime())


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[[str, str], None]:
    """`golden(name, text)` compares `text` with the file tests/golden/<name>, byte for byte."""
    update = bool(request.config.getoption("--update-golden"))

    def check(name: str, text: str) -> None:
        compare(GOLDEN / name, text, update)

    return check


@pytest.fixture
def golden_at(request: pytest.FixtureRequest) -> Callable[[Path, str], None]:
    """`golden_at(path, text)`: the same for a file beside what it belongs to (tests/errors, samples)."""
    update = bool(request.config.getoption("--update-golden"))

    def check(path: Path, text: str) -> None:
        compare(path, text, update)

    return check
