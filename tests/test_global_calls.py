"""Function blocks that call each other through global instances: every engine has the callee first."""

from __future__ import annotations

from pathlib import Path

from everywhere import checked, compiled, trace

BLOCKS = """FUNCTION_BLOCK outer
VAR_INPUT n : INT; END_VAR
VAR_EXTERNAL counter : inner; END_VAR
    counter(step_size := n);
END_FUNCTION_BLOCK
FUNCTION_BLOCK inner
VAR_INPUT step_size : INT; END_VAR
VAR_OUTPUT total : INT; END_VAR
EXTERNALS
    total := total + step_size;
    BODY
END_FUNCTION_BLOCK
PROGRAM main
VAR first : outer; END_VAR
VAR_EXTERNAL counter : inner; END_VAR
VAR seen AT %QW0 : INT; END_VAR
    first(n := 3);
    seen := counter.total;
END_PROGRAM
CONFIGURATION plant
VAR_GLOBAL counter : inner; second : outer; END_VAR
RESOURCE r ON cpu
TASK t(INTERVAL := T#10ms, PRIORITY := 1);
PROGRAM p WITH t : main;
END_RESOURCE
END_CONFIGURATION
"""


def test_a_block_is_called_through_a_global_before_it_is_declared(tmp_path: Path) -> None:
    text = BLOCKS.replace("EXTERNALS", "").replace("BODY", "")
    assert [unit.name for unit in compiled(text, "main.st").program.units] == ["inner", "outer", "main"]
    assert trace(tmp_path, text, "main.st", [{}] * 3, ["seen"]) == [(3,), (6,), (9,)]


def test_a_circle_through_globals_is_told_and_reading_an_output_is_none() -> None:
    reading = BLOCKS.replace("EXTERNALS", "VAR_EXTERNAL second : outer; END_VAR")
    compiled(reading.replace("BODY", "total := total + second.n;"), "main.st")
    circle = checked(reading.replace("BODY", "second(n := 1);"), "main.st")
    assert [d.code for d in circle.diagnostics] == ["LD0216"]


def test_an_array_of_instances_is_called_by_its_elements() -> None:
    text = BLOCKS.replace("EXTERNALS", "VAR_EXTERNAL row : ARRAY [0..1] OF outer; END_VAR")
    text = text.replace("BODY", "row[1](n := 1);").replace("second : outer", "row : ARRAY [0..1] OF outer")
    assert [d.code for d in checked(text, "main.st").diagnostics] == ["LD0216"]


def test_lists_call_without_brackets() -> None:
    text = "".join(f"FUNCTION_BLOCK {name}\nVAR_EXTERNAL {held} : {type}; END_VAR\nCAL {held}\nEND_FUNCTION_BLOCK\n"
                   for name, held, type in (("ping", "b", "pong"), ("pong", "a", "ping")))
    text += BLOCKS[BLOCKS.index("CONFIGURATION"):].replace("counter : inner; second : outer", "a : ping; b : pong")
    program = "PROGRAM main\nVAR_EXTERNAL a : ping; END_VAR\nCAL a\nEND_PROGRAM\n"
    assert [d.code for d in checked(program + text, "main.il").diagnostics] == ["LD0216"]
