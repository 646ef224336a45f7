"""What the tests of the virtual machine say of IL holds for native code as well: the same tests, other machine.

Beside them: what only native code can get wrong, parts and chunks of large bodies.
"""

from __future__ import annotations

import native
import pytest
import test_components
import test_in_out
import test_library_vm
import test_vm_code
import test_vm_faults
import test_vm_machine
from il_build import Array, Instance, program, simple, unit, var

from ldc.backends.c.parts import CHUNK_MOST, LONGEST
from ldc.types import BOOL, BYTE, DINT, INT, STRING, ULINT, WORD
from runtime.vm.machine import Machine as VirtualMachine

pytestmark = native.needs_gcc
SAME = (test_vm_code, test_vm_faults, test_vm_machine, test_library_vm, test_in_out, test_components)
# Two step, which native code does not; the last is told by the loader of the virtual machine.
LEFT_OUT = ("test_stepping_gives_the_same", "test_stepping_calls_native_code_like_the_scan",
            "test_native_code_that_nobody_built_is_told")

for module in SAME:
    for name, function in vars(module).items():
        if name.startswith("test_") and callable(function) and name not in LEFT_OUT:
            globals()[f"{name}__{module.__name__}"] = function


@pytest.fixture(autouse=True)
def natively(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in SAME:
        monkeypatch.setattr(module, "Machine", native.machine)


def alike(source, stimuli) -> None:
    """Both engines hold the same in every variable after every scan."""
    machines = VirtualMachine(source), native.machine(source)
    for values in stimuli:
        for machine in machines:
            for path, value in values.items():
                machine.set(path, value)
            machine.scan()
        seen = [{path: repr(machine.get(path)) for path, _ in machine.paths()} for machine in machines]
        assert seen[0] == seen[1]
        told = [[(f.code, f.message, f.place, f.calls) for f in machine.faults] for machine in machines]
        assert told[0] == told[1]


def test_jumps_between_parts() -> None:
    """Forward, backward, into the middle of a rung, and past the end, over functions of ``LONGEST`` rungs."""
    rungs = [(f"r{n}", f"LD n; ADD {n}:INT; ST n") for n in range(5 * LONGEST)]
    rungs[3] = ("r3", "LD skip; JMPC far; LD n; ADD 1:INT; ST n")
    rungs[130] = ("r130", "LD n; ADD 2:INT; LABEL far; LD n; ADD 7:INT; ST n")
    rungs[150] = ("r150", "LD turns; ADD 1:INT; ST turns; LT 3:INT; AND back; JMPC early")
    rungs[10] = ("r10", "LD n; XOR 5:INT; ST n".replace("XOR", "ADD"), "early")
    rungs[190] = ("r190", "LD leave; RETC; LD out; JMPC last; LD n; MUL 3:INT; ST n")
    rungs[-1] = ("r199", "LD n; ADD 100:INT; ST n", "last")
    names = [var("n", INT), var("turns", INT)] + [var(b) for b in ("skip", "back", "leave", "out")]
    off = dict.fromkeys(("skip", "back", "leave", "out"), 0) | {"turns": 0}
    alike(simple(names, *rungs), [off | {name: 1} for name in ("skip", "back", "leave", "out")] + [off])


def test_a_temporary_of_the_whole_body_keeps_its_value_from_part_to_part() -> None:
    rungs = ["LD x; ADD 1:INT; ST t"] + ["LD n; ADD 1:INT; ST n"] * (3 * LONGEST) + ["LD t; ADD t; ST y"]
    names = [var("x", INT), var("n", INT), var("y", INT), var("t", INT, kind="temp", initial=9)]
    alike(simple(names, *rungs), [{"x": 4}, {"x": -3}])
    late = ["LD t; ST y", "LD x; ST t"]  # read before it is written: its initial value, each time
    alike(simple(names, *late), [{"x": 4}, {"x": -3}])


def test_faults_far_inside_tell_rung_and_calls() -> None:
    inner = unit("FUNCTION", "RATIO", [var("a", INT, kind="input"), var("b", INT, kind="input")],
                 *["LD a; ST a"] * (2 * LONGEST), ("deep", "LD a; DIV b; ST RATIO"), result=INT)
    block = unit("FUNCTION_BLOCK", "HOLDS", [var("n", INT, kind="input"), var("r", INT, kind="output")],
                 ("calls", "LD 12; FN RATIO:INT n; ST r"), units=(inner,))
    main = unit("PROGRAM", "main", [var("h", Instance("HOLDS")), var("d", INT)],
                *["LD d; ST d"] * (2 * LONGEST), ("outer", "LD d; ST h.n; CAL h"), units=(inner, block))
    alike(program(inner, block, main), [{"d": 3}, {"d": 0}, {"d": 2}])




def test_bits_words_and_arrays_that_overlap_in_the_image() -> None:
    names = [var("w", WORD, "%MW0"), var("b", BYTE, "%MB1"), var("x", BOOL, "%MX1.2"),
             var("bits", Array(((0, 9),), BOOL), "%MX0.3"), var("copy", Array(((0, 9),), BOOL)), var("i", INT),
             var("q", BOOL, "%MX5.0"), var("many", Array(((1, 3),), INT), "%MW4"), var("d", DINT)]
    rungs = ["LD x; STN x", "LD w; ST w", "LD bits[i]; ST q", "LD i; ADD 1:INT; ST i", "LD q; STN bits[i]",
             "LD bits; ST copy", "LD copy[2]; ST copy[3]", "LD copy; ST bits", "LD TRUE; S bits[4]; R bits[0]",
             "LD w.15; ST w.0", "LD TRUE; S w.7; R w.9", "LD many[i]; ADD 5:INT; ST many[2]", "LD q; S bits[i]"]
    alike(simple(names, *rungs), [{"w": 0x1234}, {"i": 2, "w": 0xFFFF}, {"x": 1, "b": 7, "i": 1}, {"i": 8}])


def test_an_index_of_64_bits_is_told_as_it_is() -> None:
    names = [var("a", Array(((1, 3),), INT)), var("u", ULINT), var("r", INT)]
    alike(simple(names, "LD a[u]; ST r"), [{"u": 2}, {"u": 2**64 - 1}])


def test_strings_are_cut_and_compared_alike() -> None:
    names = [var("a", STRING), var("b", type(STRING)("STRING", 3)), var("q"), var("n", INT)]
    rungs = ["LD a; ST b; ST a", "LD a; FN CONCAT:STRING b; ST a", "LD a; GT b; ST q", "LD a; FN LEN:INT; ST n"]
    alike(simple(names, *rungs), [{"a": "abcdef"}, {"a": ""}, {"b": "zz"}, {}, {}])


def test_no_file_has_more_rungs_than_promised() -> None:
    source = simple([var("n", INT)], *["LD n; ADD 1:INT; ST n"] * 1500)
    code = native.built(source)
    assert max(b - a for a, b in zip(code.map[-1][1], code.map[-1][1][1:])) <= LONGEST <= CHUNK_MOST == 200
    alike(source, [{}, {}])
