"""The C machine of P in every interleaving, access by access, with itself and with that of Python."""

from __future__ import annotations

from pathlib import Path

import native
import protocol_in_c as in_c
import pytest
from protocol_model import Limits, PythonReceives, PythonSends, explored, linked
from test_protocol_model import DELIVERED, OR_FAULT, TWO_OR_FAULT

from runtime.protocol.profile import U_STAR

pytestmark = native.needs_gcc


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return in_c.stepped(tmp_path_factory.mktemp("p"))


ONE_OR_FAULT = {((1,), False), ((1,), True), ((), True)}


@pytest.mark.parametrize(("limits", "transfers", "retries", "found"), [
    pytest.param(Limits(), 3, 2, DELIVERED, id="no disturbance"),
    pytest.param(Limits(late=True), 3, 2, OR_FAULT, id="late"),
    pytest.param(Limits(late=True, lose=1), 3, 1, OR_FAULT, id="an answer lost"),
    pytest.param(Limits(late=True, corrupt=1), 2, 0, TWO_OR_FAULT, id="a word corrupted"),
    pytest.param(Limits(late=True, corrupt=1), 1, 1, ONE_OR_FAULT, id="a word corrupted, sent again"),
    pytest.param(Limits(late=True, reset=2), 2, 0, TWO_OR_FAULT, id="two resets"),
])
@pytest.mark.parametrize("pair", ["C to Python", "Python to C", "C to C"])
def test_every_interleaving_with_c_delivers_once_or_ends_in_a_fault(
        library: Path, pair, limits, transfers, retries, found) -> None:
    """As ``test_protocol_model`` asks of Python."""
    steps, link = in_c.Steps(library, retries), linked(U_STAR, 4, retries)
    sends = in_c.Sends(steps) if pair.startswith("C") else PythonSends(link)
    receives = in_c.Receives(steps) if pair.endswith("C") else PythonReceives(link)
    result = explored(sends, receives, limits, transfers)
    print(f"{pair}: {result.states} states")
    assert (result.wrong, result.stuck, result.raised) == (frozenset(), 0, 0)
    assert result.ends == found


@pytest.mark.parametrize(("correct", "wrong", "said"), [
    pytest.param("if (again(r, e)) return 0;", "if (again(r, e)) { r->fresh = 1; return 0; }", "took (1, 1)",
                 id="nothing is known to have been taken"),
    pytest.param("if (!is(c, c->running) || is(c, c->begin)) return P_BUSY;",
                 "if (!is(c, c->running)) return P_BUSY;", "", id="the end of the data is not waited for"),
    pytest.param("        set(c, c->begin);\n", "        set(c, c->running);\n", "",
                 id="running before begin"),
])
def test_the_exploration_finds_what_is_wrong_in_c(tmp_path: Path, correct: str, wrong: str, said: str
                                                  ) -> None:
    """A step of C that reads too early refuses what is not complete, which costs an attempt: transfers that
    nothing disturbs end in a fault."""
    text = (in_c.ROOM / "p_handshake.c").read_text()
    assert text.count(correct) == 1
    (tmp_path / "p_handshake.c").write_text(text.replace(correct, wrong))
    steps = in_c.Steps(in_c.stepped(tmp_path), 1)
    result = explored(in_c.Sends(steps), in_c.Receives(steps), Limits(late=bool(said)), 2)
    if said:
        assert said in result.wrong
    else:
        assert any(fault for _, fault in result.ends) or result.wrong
