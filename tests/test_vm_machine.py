"""The scan cycle: inputs, tasks, time, symbol paths, process image, checksum."""

from __future__ import annotations

import hashlib

import pytest
from il_build import program, simple, unit, var

from ldc.expr import Place
from ldc.il.program import Run, Task
from ldc.types import (
    BOOL,
    BYTE,
    DINT,
    DWORD,
    INT,
    REAL,
    TIME,
    USINT,
    WORD,
    Array,
    Enum,
    Field,
    Instance,
    String,
    Struct,
    Subrange,
)
from runtime.symbols import UnknownSymbol
from runtime.vm.machine import Machine

MS = 1_000_000


def test_inputs_are_latched_at_the_start_of_a_scan() -> None:
    names = [var("start", at="%IX0.0"), var("n", INT, at="%IW4"), var("motor", at="%QX0.0"), var("m", INT)]
    machine = Machine(simple(names, "LD start; ST motor; LD n; ST m"))
    machine.set("start", 1), machine.set("%IW4", "-3")
    assert machine.get("start") is False and machine.get("n") == 0
    machine.scan()
    assert machine.get("START") is True and machine.get("%QX0.0") is True and machine.get("m") == -3
    assert machine.outputs() == {"main.motor": True}


def test_variables_at_one_address_are_one_variable() -> None:
    names = [var("a", at="%QX0.1"), var("b", at="%QX0.1"), var("q")]
    machine = Machine(simple(names, "LDN a; ST a; LD b; ST q"))
    machine.scan()
    assert machine.get("b") is True and machine.get("q") is True


def test_addresses_of_different_width_overlap_bit_by_bit() -> None:
    names = [
        var("x", at="%IX1.3"),
        var("whole", BYTE, at="%IB1"),
        var("w", INT, at="%QW0"),
        var("bits", WORD, at="%QW0"),
        var("top", at="%QX1.7"),
        var("low", USINT, at="%QB0"),
        var("q"),
        var("r", REAL, at="%MD1"),
        var("raw", DWORD, at="%MD1"),
        var("d", DINT, at="%MD2", initial=-2),
        var("half", WORD, at="%MW5"),
    ]
    rungs = (
        "LD x; ST q; LD -2; ST w",
        "LD 1.5:REAL; ST r",
        "LD FALSE; R top; LD x; R top; LD TRUE; ST bits.8",
    )
    machine = Machine(simple(names, *rungs))
    assert machine.get("half") == 0xFFFF
    machine.set("whole", 8)
    machine.scan()
    assert [machine.get(n) for n in ("q", "x", "whole")] == [True, True, 8]
    assert machine.get("raw") == 0x3FC00000 and machine.get("low") == 0xFE
    assert machine.get("bits") == 0x7FFE and machine.get("w") == 0x7FFE and machine.get("top") is False
    machine.set("x", 0)
    assert machine.get("whole") == 8
    machine.scan()
    assert machine.get("whole") == 0


def test_a_located_array_overlaps_its_bits() -> None:
    names = [
        var("row", Array(((1, 3),), INT), at="%MW0"),
        var("b", at="%MX3.0"),
        var("i", INT, initial=2),
        var("copy", Array(((1, 3),), INT)),
        var("q", INT),
    ]
    machine = Machine(
        simple(
            names,
            "LD TRUE; ST b; LD row[i]; ST q; ST row[3]; LD row; ST copy; LD 5; ST copy[1]; LD copy; ST row",
        )
    )
    machine.scan()
    assert [machine.get(n) for n in ("q", "row[1]", "row[2]", "row[3]", "copy[2]")] == [256, 5, 256, 256, 256]


def test_direct_addresses_need_no_declaration() -> None:
    machine = Machine(simple([var("q")], "LD %IX3.0; ST %QX0.5; ST q"))
    machine.set("%IX3.0", True)
    machine.scan()
    assert machine.get("%qx0.5") is True
    with pytest.raises(UnknownSymbol):
        machine.get("%IX7.0")


def clocked(name: str, *locals_) -> object:
    return unit(
        "PROGRAM",
        name,
        [var("n", INT), var("at", TIME), var("first", INT), *locals_],
        "LD n; ADD 1; ST n; LD %NOW; ST at; LD %FIRST_SCAN; JMPCN no; LD first; ADD 1; ST first; LABEL no",
    )


def test_time_begins_at_zero_and_goes_by_the_period() -> None:
    machine = Machine(program(clocked("main")), period_ns=20 * MS)
    seen = []
    for _ in range(3):
        machine.scan()
        seen.append((machine.get("at"), machine.get("first"), machine.now_ns, machine.scans))
    assert seen == [(0, 1, 20 * MS, 1), (20 * MS, 1, 40 * MS, 2), (40 * MS, 1, 60 * MS, 3)]


def test_tasks_run_by_interval_and_the_tick_is_their_common_divisor() -> None:
    tasks = (Task("slow", 30 * MS, 1), Task("fast", 20 * MS, 0), Task("always", None, 5))
    runs = (Run("s", "main", "slow"), Run("f", "main", "FAST"), Run("a", "main", "always"))
    machine = Machine(program(clocked("main"), tasks=tasks, runs=runs))
    assert machine.period_ns == 10 * MS
    for _ in range(7):
        machine.scan()
    assert [machine.get(f"{n}.n") for n in "sfa"] == [3, 4, 7]
    assert machine.get("s.at") == 60 * MS
    late = Machine(program(clocked("main"), tasks=tasks, runs=runs), period_ns=45 * MS)
    for _ in range(4):
        late.scan()
    assert [late.get(f"{n}.n") for n in "sfa"] == [4, 4, 4]


def test_tasks_go_by_priority_then_interval_then_declaration() -> None:
    log = var("log", INT, kind="global")

    def logger(name: str, digit: int):
        return unit(
            "PROGRAM",
            name,
            [var("log", INT, kind="external")],
            f"LD log; MUL 10; ADD {digit}; ST log",
            globals_=[log],
        )

    units = [logger(f"p{i}", i) for i in range(1, 6)]
    tasks = (
        Task("t1", 20 * MS, 1),
        Task("t2", None, 1),
        Task("t3", None, 0),
        Task("t4", 10 * MS, 1),
        Task("t5", 10 * MS, 9),
    )
    runs = tuple(Run(f"r{i}", f"p{i}", f"t{i}") for i in range(1, 6))
    machine = Machine(program(*units, globals_=[log], tasks=tasks, runs=runs))
    machine.scan()
    assert machine.get("log") == 32415


def test_a_single_task_runs_at_the_rising_edge() -> None:
    go = var("go", kind="global")
    tasks = (
        Task("event", None, 0, Place("go", go.type, is_global=True)),
        Task("both", 20 * MS, 1, Place("go", go.type, is_global=True)),
    )
    machine = Machine(
        program(
            clocked("main"),
            globals_=[go],
            tasks=tasks,
            runs=(Run("e", "main", "event"), Run("b", "main", "both")),
        ),
        period_ns=10 * MS,
    )
    seen = []
    for value in (0, 1, 1, 1, 0, 0, 0, 1, 0):
        machine.set("go", value)
        machine.scan()
        seen.append((machine.get("e.n"), machine.get("b.n")))
    assert seen == [(0, 1), (1, 2), (1, 2), (1, 2), (1, 3), (1, 3), (1, 4), (2, 5), (2, 6)]


COLOUR = Enum("colour", (("red", 0), ("amber", 5), ("green", 6)))


def test_symbol_paths() -> None:
    block = unit(
        "FUNCTION_BLOCK",
        "ramp",
        [
            var("IN", kind="input"),
            var("Q", kind="output"),
            var("_ldc_m", kind="hidden"),
            var("tmp", kind="temp"),
        ],
    )
    shape = Struct("shape", (Field("size", Array(((1, 2),), REAL)), Field("colour", COLOUR)))
    main = unit(
        "PROGRAM",
        "main",
        [
            var("warm", Instance("RAMP")),
            var("s", shape),
            var("m", Array(((0, 1), (1, 2)), INT)),
            var("w", WORD),
            var("name", String("STRING", 4)),
            var("sub", Subrange("", INT, 1, 9)),
            var("level", INT, kind="external"),
        ],
        units=[block],
    )
    machine = Machine(program(block, main, globals_=[var("level", INT, kind="global", initial=4)]))
    assert [p for p, _ in machine.paths()] == [
        "level",
        "main.warm.IN",
        "main.warm.Q",
        "main.s.size[1]",
        "main.s.size[2]",
        "main.s.colour",
        "main.m[0,1]",
        "main.m[0,2]",
        "main.m[1,1]",
        "main.m[1,2]",
        "main.w",
        "main.name",
        "main.sub",
    ]
    machine.set("WARM.q", "TRUE"), machine.set("main.S.Size[2]", "1.5"), machine.set("s.colour", "Green")
    machine.set("m[1,1]", "16#F"), machine.set("name", "Grüße"), machine.set("level", 5), machine.set(
        "sub", 3
    )
    got = [
        machine.get(p)
        for p in ("Main.Warm.Q", "s.size[2]", "s.colour", "m[1, 1]", "name", "LEVEL", "main.sub")
    ]
    assert got == [True, 1.5, 6, 15, "Grüß", 5, 3]
    assert machine.get("warm._ldc_m") is False


@pytest.mark.parametrize(
    "path, message",
    [
        ("wram.Q", "did you mean `warm`"),
        ("warm.X", "ramp has no `X`"),
        ("warm", "name one value in it"),
        ("m[5]", "takes 2"),
        ("a[9]", "9 is outside 0..1"),
        ("w.16", "no such part"),
        ("a.b", "has no"),
        ("", "no name"),
        ("a[", "no name"),
        ("%QX0.0", "nothing at"),
        ("warm.tmp", "has no `tmp`"),
        ("a..b", "no name"),
        ("other.warm", "no variable"),
    ],
)
def test_unknown_symbols_say_why(path: str, message: str) -> None:
    block = unit("FUNCTION_BLOCK", "ramp", [var("Q", kind="output"), var("tmp", kind="temp")])
    main = unit(
        "PROGRAM",
        "main",
        [
            var("warm", Instance("ramp")),
            var("w", WORD),
            var("m", Array(((0, 1), (1, 2)), INT)),
            var("a", Array(((0, 1),), INT)),
        ],
    )
    with pytest.raises(UnknownSymbol, match=message.replace("`", ".")):
        Machine(program(block, main)).get(path)


@pytest.mark.parametrize("value", [2, "maybe", 1.5, None, -1])
def test_values_that_do_not_fit_are_refused(value) -> None:
    with pytest.raises(ValueError):
        Machine(simple([var("a")])).set("a", value)


def test_the_checksum_tells_states_apart_and_nothing_else() -> None:
    def machine(order: str) -> Machine:
        return Machine(
            simple(
                [var(n, INT) for n in order] + [var("r", REAL), var("_ldc_e", kind="hidden")],
                "LD a; ADD 1; ST a",
            )
        )

    one, two = machine("ab"), machine("BA")
    assert one.checksum() == two.checksum()
    one.scan()
    assert one.checksum() != two.checksum()
    two.scan()
    assert one.checksum() == two.checksum()
    two.set("_ldc_e", 1)
    assert one.checksum() != two.checksum()
    two_int_one_real_one_bool = bytes(2 + 2 + 4 + 1)
    assert machine("ab").checksum() == hashlib.sha256(two_int_one_real_one_bool).hexdigest()[:16]


def test_a_reader_gives_members_and_cells_in_their_order_after_a_state_was_put_back_too() -> None:
    pair = Struct("PAIR", (Field("n", INT), Field("on", BOOL)))
    machine = Machine(simple([var("p", pair), var("m", INT)], "LD p.n; ST m"))
    read = machine.reader(machine.find(("p.n", "m", "p.on")))
    machine.set("p.n", 3), machine.set("p.on", True)
    kept = machine.checkpoint()
    machine.scan()
    assert read() == (3, 3, True) and machine.reader(())() == ()
    machine.restore(kept)
    assert read() == (3, 0, True)
    assert machine.reader(machine.find(("p.n",)))() == (3,)
