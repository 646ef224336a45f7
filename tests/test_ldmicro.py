"""Files of LDmicro: what each instruction does, scan by scan, and what is told about the others."""

from __future__ import annotations

from pathlib import Path

import pytest
from foreign_files import broken, compiled, drawn, machine, remarks, run, said
from hypothesis import given, settings
from hypothesis import strategies as st

from ldc.diagnostics import Diagnostics
from ldc.parser import parse_file
from ldc.pipeline import compile_paths
from ldc.source import SourceFile

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "corpus" / "ldmicro"
PATH = "plant.ld"


def project(*rungs: str, version: str = "0.2", head: str = "CYCLE=10000 us at Timer1, YPlcCycleDuty:0",
            sizes: str = "") -> str:
    """A project; each rung holds instructions that are separated by ``;``."""
    lines = [f"LDmicro{version}", "MICRO=Atmel AVR ATmega328 28-PDIP", head]
    if sizes:
        lines += ["VAR LIST", *(f"    {line}" for line in sizes.split(",")), "END"]
    lines += ["IO LIST", "    Xa at 14 0 0", "END", "PROGRAM"]
    for number, rung in enumerate(rungs, 1):
        lines += [f"RUNG {number}", *(f"  {part.strip()}" for part in rung.split(";")), "END"]
    return "\n".join(lines) + "\n"


def trace(rungs: str | tuple[str, ...], states: str, watch: str, **more: str) -> str:
    """What one variable is after each scan, Xa being as told."""
    rungs = (rungs,) if isinstance(rungs, str) else rungs
    return " ".join(run(project(*rungs, **more), PATH, [{"Xa": int(s)} for s in states], watch))


# ---- digits, displays, buses, registers

@pytest.mark.parametrize(("rung", "given_", "expected"), [
    ("BIN2BCD a b", 1234, 0x1234), ("BCD2BIN a b", 0x1234, 1234), ("BIN2BCD n b", 59, 0x59),
    ("BCD2BIN a n", 0x59, 59), ("OPPOSITE a b", 0x0003, 0xC000 - 0x10000),
    ("OPPOSITE n n", 0x03, 0xC0 - 0x100),
    ("7SEGMENTS a b C", 4, 0x66), ("7SEGMENTS a b A", 4, 0x99), ("7SEGMENTS a b C", 20, 0xE6),
    ("7SEGMENTS a b C", ord("7"), 0x07), ("7SEGMENTS a b C", ord("*"), 0), ("7SEGMENTS a b C", 200, 0),
    ("BUS a b 0 5 7 2 1 3 4 6", 0b101, 0b1001000), ("BUS n #PORTD 7 6 5 4 3 2 1 0", -3, -3),
])
def test_digits_and_bits(rung: str, given_: int, expected: int) -> None:
    target, source = rung.split()[1:3]
    found = run(project(rung, sizes="1 bytes n,1 bytes #PORTD"), PATH, [{source.strip("#"): given_}],
                target.strip("#"))
    assert found == [str(expected)]


def test_what_lies_on_buses_is_a_variable() -> None:
    rungs = ("CONTACTS Xa 0; I2C_WR I2C1 7 - Master 0x68 2 MSB 100000;"
             "I2C_RD I2C1 - sec Master 0x68 2 MSB 100000",
             "SPI SPI1 sec b Master 0 8 MSB 100000; MOVE #PORTB b; COIL Ya 0 0 0 0")
    rows = [{"Xa": 0, "SPI1_in": 5}, {"Xa": 1}, {"Xa": 0}]
    assert run(project(*rungs), PATH, rows, "sec I2C1_68h_2 SPI1_out b PORTB Ya") == [
        "0 0 0 5 5 1", "7 7 7 5 5 1", "7 7 7 5 5 1"]
    told = [r for r in remarks(compiled(project(*rungs), PATH)) if r[1] == "#PORTB"]
    assert told == [("mapped", "#PORTB", "a variable PORTB: the pins of a port are variables of their own, "
                     "which do not follow it"), ("renamed", "#PORTB", "PORTB")]


# ---- contacts, coils, one-shots


@pytest.mark.parametrize(("rung", "inputs", "wanted"), [
    ("CONTACTS Xa 0 0;COIL Yq 0 0 0 0", "0110", "0 1 1 0"),
    ("CONTACTS Xa 1 0;COIL Yq 0 0 0 0", "0110", "1 0 0 1"),
    ("CONTACTS Xa 0;COIL Yq 1 0 0", "0110", "1 0 0 1"),
    ("CONTACTS Xa 0 0;COIL Yq 0 1 0 0", "0110", "0 1 1 1"),
    ("CONTACTS Xa 1 0;COIL Yq 0 0 1 0", "0110", "0 0 0 0"),
    ("CONTACTS Xa 0 0;COIL Yq 0 0 0 1", "01100110", "0 1 1 1 1 0 0 0"),
    ("CONTACTS Xa 0 0;OSR;COIL Yq 0 0 0 0", "110110", "1 0 0 1 0 0"),
    ("CONTACTS Xa 0 0;OSF;COIL Yq 0 0 0 0", "001100", "0 0 0 0 1 0"),
    ("CONTACTS Xa 0 0;OSL;COIL Yq 0 0 0 0", "0011001", "0 0 1 1 0 1 1"),
    ("CONTACTS Xa 0 0;OSC;COIL Yq 0 0 0 0", "0111101", "0 1 0 1 0 0 1"),
    ("CONTACTS Xa 0 0;OPEN;COIL Yq 0 0 0 0", "01", "0 0"),
    ("CONTACTS Xa 0 0;SHORT;COIL Yq 0 0 0 0", "01", "0 1"),
])
def test_bits(rung: str, inputs: str, wanted: str) -> None:
    assert trace(rung, inputs, "Yq") == wanted


def test_power_goes_through_coils_and_around_computations() -> None:
    rung = ("CONTACTS Xa 0 0;COIL Rone 0 0 0 0;MOVE n 5;PARALLEL;CONTACTS Rnever 0 0;SHL m n 1;END;"
            "COIL Ytwo 0 0 0 0")
    assert trace(rung, "10", "Rone n m Ytwo") == "1 5 10 0 0 5 10 0"
    ended = "CONTACTS Xa 0 0;PARALLEL;MOVE n 5;CONTACTS Rnever 0 0;END;COIL Ytwo 0 0 0 0"
    assert trace(ended, "01", "Ytwo") == "0 1"


def test_series_and_parallels_nest() -> None:
    rung = ("PARALLEL;CONTACTS Xa 0 0;SERIES;CONTACTS Xb 0 0;PARALLEL;CONTACTS Xc 0 0;CONTACTS Xd 1 0;END;"
            "END;END;COIL Yq 0 0 0 0")
    text = project(rung)
    for bits in range(16):
        a, b, c, d = (bits >> n & 1 for n in range(4))
        wanted = a or b and (c or not d)
        assert run(text, PATH, [{"Xa": a, "Xb": b, "Xc": c, "Xd": d}], "Yq") == [str(int(wanted))]


# ---- timers: they count scans


@pytest.mark.parametrize(("timer", "inputs", "wanted"), [
    ("TON Td 30000 0", "0111110", "0 0 0 0 1 1 0"),
    ("TON Td 30000 -1", "0111110", "0 0 0 1 1 1 0"),
    ("TON Td 30000 0", "1101111", "0 0 0 0 0 0 1"),
    ("TOF Td 30000 0", "0011000000", "0 0 1 1 1 1 1 0 0 0"),
    ("RTO Td 30000 0", "1010100", "0 0 0 0 0 1 1"),
    ("RTL Td 30000 0", "0101011", "0 0 0 0 0 1 1"),
    ("TCY Td 20000 0", "1111111110", "0 0 1 1 1 0 0 0 1 0"),
    ("THI Td 30000 0", "0100000", "0 1 1 1 0 0 0"),
    ("THI Td 20000 0", "01111101", "0 1 1 0 0 0 0 1"),
    ("TLO Td 20000 0", "0110111101", "0 1 1 0 0 1 1 1 0 0"),
])
def test_timers(timer: str, inputs: str, wanted: str) -> None:
    assert trace(f"CONTACTS Xa 0 0;{timer};COIL Yq 0 0 0 0", inputs, "Yq") == wanted


def test_old_timers_are_a_scan_shorter() -> None:
    rung = "CONTACTS Xa 0;TON Td 30000;COIL Yq 0 0 0"
    assert trace(rung, "11111", "Yq", version="0.1") == "0 0 1 1 1"
    assert trace(rung, "11111", "Yq") == "0 0 0 1 1"


def test_the_count_of_a_timer_is_a_variable() -> None:
    rungs = (
        "CONTACTS Xa 0 0;RTO Td 30000 0;COIL Yq 0 0 0 0",
        "EQU Td 2;MOVE seen Td",
        "CONTACTS Xr 0 0;RES Td",
    )
    rows = [{"Xa": 1}] * 4 + [{"Xr": 1}]
    assert run(project(*rungs), PATH, rows, "Td Yq seen") == ["1 0 0", "2 0 2", "3 0 2", "3 1 2", "0 1 2"]


def test_a_delay_may_be_a_variable() -> None:
    rungs = ("MOVE limit 2", "CONTACTS Xa 0 0;TON Td limit 0;COIL Yq 0 0 0 0")
    assert trace(rungs, "1111", "Yq") == "0 0 1 1"


def test_a_long_delay_has_a_wide_count() -> None:
    text = project("CONTACTS Xa 0 0;TON Td 1000000000 0;COIL Yq 0 0 0 0")
    running = machine(text, PATH)
    running.set("Xa", True)
    running.set("Td", 99_999)
    running.scan()
    assert (running.get("Td"), running.get("Yq")) == (100_000, False)
    running.scan()
    assert running.get("Yq")


# ---- counters


@pytest.mark.parametrize(("counter", "inputs", "wanted"), [
    ("CTU Cn 2 0", "01011010", "0 1 0 1 0 1 1 1"),
    ("CTU Cn 2 0 \\", "01011010", None),
    ("CTD Cn -2 0", "010101", "1 1 1 1 1 0"),
])
def test_counters_that_stop(counter: str, inputs: str, wanted: str | None) -> None:
    counts = {
        "CTU Cn 2 0": "0 1 1 2 2 2 2 2",
        "CTU Cn 2 0 \\": "0 0 1 1 1 2 2 2",
        "CTD Cn -2 0": "0 -1 -1 -2 -2 -2",
    }
    rung = f"CONTACTS Xa 0 0;{counter};COIL Yq 0 0 0 0"
    assert trace(rung, inputs, "Cn") == counts[counter]
    power = [int(c) >= 2 if counter.startswith("CTU") else int(c) > -2 for c in counts[counter].split()]
    assert trace(rung, inputs, "Yq") == " ".join(str(int(p)) for p in power)


@pytest.mark.parametrize(("counter", "inputs", "counts", "power"), [
    ("CTC Cn 2 0", "1010101", "1 1 2 2 0 0 1", "0 0 0 0 1 0 0"),
    ("CTC Cn 2 1", "1010101", "2 2 1 1 2 2 1", "0 0 1 0 0 0 1"),
    ("CTC Cn 2 0 -", "11111", "1 2 0 1 2", "0 0 1 0 0"),
    ("CTC Cn 1 0 o", "0010", "1 0 0 1", "0 1 0 0"),
    ("CTR Cn -2 0", "1010101", "-1 -1 -2 -2 0 0 -1", "0 0 0 0 1 0 0"),
    ("CTR Cn -1 0 \\", "101010", "0 -1 -1 0 0 -1", "0 0 0 1 0 0"),
])
def test_counters_in_a_circle(counter: str, inputs: str, counts: str, power: str) -> None:
    rung = f"CONTACTS Xa 0 0;{counter};COIL Yq 0 0 0 0"
    assert trace(rung, inputs, "Cn") == counts
    assert trace(rung, inputs, "Yq") == power


def test_reset_gives_a_counter_its_first_value() -> None:
    rungs = ("CONTACTS Xa 0 0;CTU Cn 9 5", "CONTACTS Xr 0 0;RES Cn")
    assert run(project(*rungs), PATH, [{"Xa": 1}, {"Xa": 0}, {"Xr": 1}], "Cn") == ["6", "6", "5"]
    assert compiled(project("CONTACTS Xa 0 0;CTU Cn 9 5"), PATH).program is not None


def test_the_first_value_may_be_a_variable() -> None:
    assert trace(("MOVE base 7", "CONTACTS Xa 0 0;CTU Cn 9 base"), "0101", "Cn") == "7 8 8 9"


# ---- arithmetic


@pytest.mark.parametrize(
    ("instruction", "wanted"),
    [
        ("ADD r n 3", 10),
        ("SUB r n 9", -2),
        ("MUL r n -3", -21),
        ("DIV r n -2", -3),
        ("MOD r n 4", 3),
        ("NEG r n", -7),
        ("AND r n 0b101", 5),
        ("OR r n 0x10", 23),
        ("XOR r n 0o3", 4),
        ("NOT r n", -8),
        ("SHL r n 2", 28),
        ("SHR r n 1", 3),
        ("SHR r m 1", -3),
        ("SR0 r m 1", 32765),
        ("ROL r m 4", -65),
        ("ROR r n 1", -32765),
        ("SWAP r n", 1792),
        ("MOVE r 'A'", 65),
        ("MOVE r '\\n'", 10),
        ("MOVE r 0xffff", -1),
        ("SET_BIT r 4", 16),
        ("ADD r 32767 1", -32768),
    ],
)
def test_arithmetic(instruction: str, wanted: int) -> None:
    rungs = ("MOVE n 7", "MOVE m -5", f"CONTACTS Xa 0 0;{instruction}")
    assert trace(rungs, "01", "r") == f"0 {wanted}"


@pytest.mark.parametrize(("comparison", "wanted"), [
    ("EQU n 7", 1), ("NEQ n 7", 0), ("GRT n m", 1), ("GEQ n 7", 1), ("LES n m", 0), ("LEQ -5 m", 1),
    ("IF_BIT_SET n 2", 1), ("IF_BIT_CLEAR n 3", 1), ("IF_BIT_SET n 3", 0), ("EQU small -1", 0),
])
def test_comparisons(comparison: str, wanted: int) -> None:
    rungs = ("MOVE n 7", "MOVE m -5", f"CONTACTS Xa 0 0;{comparison};COIL Yq 0 0 0 0")
    assert trace(rungs, "01", "Yq", sizes="1 bytes small") == f"0 {wanted}"


def test_widths() -> None:
    sizes = "1 bytes small,2 bytes middle,4 bytes long"
    rungs = (
        "MOVE long 100000",
        "MOVE middle 300",
        "ADD small middle 1",
        "MUL long long middle",
        "MOVE middle long",
        "SUB long small 200",
    )
    text = project(*rungs, sizes=sizes)
    assert run(text, PATH, [{}], "small middle long") == ["45 -15488 -155"]
    (mapped,) = [
        r for r in remarks(compiled(project("MOVE n 1", sizes="3 bytes n"), PATH)) if r[0] == "mapped"
    ]
    assert mapped[1] == "n"


def test_division_by_zero_leaves_the_target() -> None:
    assert run(project("MOVE r 5", "DIV r r none"), PATH, [{}], "r") == ["5"]


def test_shift_register_and_tables() -> None:
    rungs = ("ADD reg0 reg0 1", "CONTACTS Xa 0 0;SHIFT_REGISTER reg 3")
    rows = [{"Xa": n % 2} for n in range(6)]
    assert run(project(*rungs), PATH, rows, "reg0 reg1 reg2")[-1] == "6 6 4"
    table = "LOOK_UP_TABLE r i 3 0 10 20 -30 levels"
    assert [run(project(table), PATH, [{"i": i, "r": 1}], "r")[0] for i in (0, 2, 3, -1)] == [
        "10",
        "-30",
        "1",
        "1",
    ]
    linear = "PIECEWISE_LINEAR y x 4 0 2 5 10 10 50 100 100 curve"
    values = [run(project(linear), PATH, [{"x": x, "y": 7}], "y")[0] for x in (0, 5, 10, 55, 100, 101, 2, -5)]
    assert values == ["2", "10", "50", "75", "100", "7", "5", "-6"]


# ---- the order of rungs


def test_master_relay() -> None:
    rungs = ("CONTACTS Xa 0 0;MASTER_RELAY", "ADD inside inside 1", "MASTER_RELAY", "ADD outside outside 1")
    assert trace(rungs, "0110", "inside outside") == "0 1 1 2 2 3 2 4"


def test_jumps_and_labels() -> None:
    rungs = (
        "COMMENT the loop",
        "MOVE i 0",
        "LABEL again",
        "ADD i i 1",
        "LES i 5;GOTO again",
        "CONTACTS Xa 0 0;GOTO 8",
        "ADD n n 1",
        "ADD m m 1",
        "CONTACTS Xa 0 0;RETURN",
        "ADD k k 1",
    )
    assert trace(rungs, "01", "i n m k") == "5 1 1 1 5 1 2 1"


def test_a_jump_to_the_end() -> None:
    assert trace(("CONTACTS Xa 0 0;GOTO last", "ADD n n 1", "LABEL last"), "0101", "n") == "1 1 2 2"


def test_a_jump_to_a_rung_that_does_nothing() -> None:
    rungs = ("CONTACTS Xa 0 0;GOTO there", "ADD n n 1", "LABEL there;SHORT", "ADD m m 1")
    assert trace(rungs, "01", "n m") == "1 1 1 2"


def test_subprograms() -> None:
    rungs = (
        "CONTACTS Xa 0 0;GOSUB twice",
        "GOSUB twice",
        "SUBPROG twice",
        "ADD n n 1",
        "OSR;ADD first first 1",
        "ENDSUB twice",
        "ADD m m 1",
    )
    assert trace(rungs, "01", "n m first") == "1 1 1 3 2 1"


def test_elements_behind_a_jump_are_told() -> None:
    rung = "PARALLEL;SERIES;CONTACTS Xa 0 0;GOTO 2;END;ADD n n 1;END"
    assert said(compiled(project(rung, "ADD n n 1"), PATH)) == [
        "LD0151 LDmicro: ADD behind a jump in the same rung is not supported"]


# ---- peripherals are variables


def test_converter_and_pwm() -> None:
    rungs = (
        "CONTACTS Xa 0 0;READ_ADC Av 0",
        "DIV duty Av 10",
        "SET_PWM duty 1000 Pled 0-100%",
        "CONTACTS Xr 0 0;RES Pled",
    )
    rows = [{"Av_input": 500}, {"Xa": 1}, {"Av_input": 700, "Xa": 0}, {"Xr": 1}]
    assert run(project(*rungs), PATH, rows, "Av Pled_duty") == ["0 0", "500 50", "500 50", "500 0"]


def test_persistent_variables_are_retained() -> None:
    result = compiled(project("PERSIST saved", "ADD saved saved 1"), PATH)
    (section,) = [
        b for p in result.project.files[0].pous for b in p.var_blocks if b.qualifiers == ("RETAIN",)
    ]
    assert [v.name for v in section.variables] == ["saved"]
    assert said(compiled(project("CONTACTS Xa 0 0;PERSIST saved"), PATH)) == [
        "LD0151 LDmicro: PERSIST behind a condition is not supported"]


def test_serial_port() -> None:
    rungs = ("UART_RECV got;COIL Rnew 0 0 0 0", "CONTACTS Rnew 0 0;UART_SEND got;COIL Rbusy 0 0 0 0")
    rows = [{}, {"uart_in": 65, "uart_received": 1}, {"uart_busy": 1}]
    watch = "got uart_received uart_sent uart_out Rbusy"
    assert run(project(*rungs), PATH, rows, watch) == ["0 0 0 0 0", "65 0 1 65 0", "65 0 0 65 1"]


def sent(text: str, scans: int, busy: tuple[int, ...] = (), **values: int) -> str:
    running, found = machine(text, PATH), ""
    for name, value in values.items():
        running.set(name, value)
    for scan in range(scans):
        running.set("uart_busy", scan in busy)
        running.scan()
        found += chr(running.get("uart_out")) if running.get("uart_sent") else "."
    return found


def codes(text: str) -> str:
    return " ".join(map(str, (len(text), *text.encode("ascii"))))


@pytest.mark.parametrize(
    ("pattern", "value", "wanted"),
    [
        ("T\\3\\r\\n", 35, "T 35\r\n...."),
        ("T\\3!", 0, "T  0!....."),
        ("\\-3!", -35, "- 35!....."),
        ("\\-2!", 35, " 35!......"),
        ("\\3!", 735, "735!......"),
        ("\\3!", 705, "705!......"),
        ("\\x41\\\\", None, "A\\........"),
    ],
)
def test_formatted_strings(pattern: str, value: int | None, wanted: str) -> None:
    rung = f"FORMATTED_STRING {'n' if value is not None else '(none)'} {codes(pattern)};COIL Ysending 0 0 0 0"
    assert sent(project(rung), 10, **({} if value is None else {"n": value})) == wanted


def test_formatted_strings_wait_and_tell_that_they_send() -> None:
    text = project(f"CONTACTS Xa 0 0;FORMATTED_STRING (none) {codes('Hi!')};COIL Ysending 0 0 0 0")
    assert sent(text, 7, busy=(1, 2), Xa=1) == "H..i!.."
    assert run(text, PATH, [{"Xa": 1}] * 4 + [{"Xa": 0}, {"Xa": 1}], "Ysending") == [
        "1",
        "1",
        "0",
        "0",
        "0",
        "1",
    ]


# ---- the file


def test_names_comments_and_the_task() -> None:
    text = project(
        "COMMENT Two lines\\r\\nof comment", "CONTACTS Xa 0 0;COIL Rif__ 0 0 0 0", "COMMENT by nobody"
    )
    result = compiled(text, PATH)
    assert said(result) == []
    assert ("renamed", "Rif__", "Rif") in remarks(result)
    file = result.project.files[0]
    assert file.pous[-1].body.rungs[0].title == "Two lines of comment" and file.pous[-1].title == "by nobody"
    assert [v.note for v in file.pous[-1].var_blocks[0].variables] == ["pin 14", None]
    assert machine(text, PATH).period_ns == 10_000_000
    assert drawn(text, PATH, "plant") == ['RUNG "Two lines of comment" [Xa] (Rif)']


def test_names_differ_by_case() -> None:
    assert trace(("CONTACTS Xa 0 0;MOVE level 1", "MOVE Level 2"), "1", "level Level_2") == "1 2"


@pytest.mark.parametrize(("rung", "message"), [
    ("SPI_WR SPI1 a - Master 0 8 MSB 100000", "LD0151 LDmicro: the instruction SPI_WR is not supported"),
    ("I2C_RD I2C1 - a Master b 0 MSB 100000",
     "LD0151 LDmicro: I2C_RD at an address that a variable holds is not supported"),
    ("BUS a b 0 1 2 3 4 5 6 16", "LD0150 LDmicro: BUS needs eight bits of a, 0 to 15"),
    ("7SEGMENTS a b X", "LD0150 LDmicro: the common pin of a display is C or A, not `X`"),
    ("STEPPER s 1 1 1 1 Yq", "LD0151 LDmicro: the instruction STEPPER is not supported"),
    ("MOVE #PORTB[2] 1", "LD0151 LDmicro: `#PORTB[2]` as a variable is not supported"),
    ("CONTACTS ROverflowFlagV 0 0;COIL Yq 0 0 0 0",
     "LD0151 LDmicro: the overflow flag `ROverflowFlagV` is not supported"),
    ("MOVE n", "LD0150 LDmicro: MOVE has 1 of 2 operands"),
    ("MOVE n 70000", "LD0150 LDmicro: 70000 has no place in 16 bits"),
    ("GOTO nowhere", "LD0150 LDmicro: there is no LABEL `nowhere` in this (sub)program"),
    ("TON Td 5000 0;COIL Yq 0 0 0 0", "LD0150 LDmicro: TON of 5000 us lasts 0 scans"),
    ("COIL Xa 0 0 0 0;MOVE Xa 1", "LD0150 LDmicro: `Xa` is a bit in one place and a number in another"),
    ("PLACEHOLDER", "LD0150 LDmicro: PLACEHOLDER stands where it has no meaning"),
    ("CONTACTS Xa 0 0;CLRWDT;COIL Yq 0 0 0 0", "LD0152 LDmicro: CLRWDT is left out"),
    ("PARALLEL;CONTACTS Xa 0 0;COIL Yq 0 0 0 0;END", "LD0152 LDmicro: CONTACTS Xa 0 0 is left out"),
    (";".join(["PARALLEL", "SERIES"] * 30), "LD0153 LDmicro: more than 40 groups inside of each other"),
])
def test_what_is_told(rung: str, message: str) -> None:
    assert said(compiled(project(rung), PATH)) == [message]


def test_a_code_page_is_read(tmp_path: Path) -> None:
    path = tmp_path / "old.ld"
    path.write_bytes(project("COMMENT R\xe9glage", "CONTACTS Xa 0 0;COIL Yq 0 0 0 0").encode("latin-1"))
    result = compile_paths([str(path)])
    assert result.program is not None
    assert result.project.files[0].pous[-1].body.rungs[0].title == "R\xe9glage"


# ---- circuits at random against a small interpreter


LEAF = st.sampled_from(
    (
        "CONTACTS Xa 0 0",
        "CONTACTS Xb 1 0",
        "CONTACTS Rc 0 0",
        "COIL Rc 0 0 0 0",
        "COIL Rd 0 1 0 0",
        "COIL Rd 0 0 1 0",
        "OSR",
        "OSF",
        "OPEN",
        "SHORT",
        "CONTACTS Rd 0 0",
    )
)
CIRCUIT = st.recursive(LEAF, lambda inner: st.one_of(
    st.lists(inner, min_size=1, max_size=3).map(lambda parts: ("PARALLEL", parts)),
    st.lists(inner, min_size=1, max_size=3).map(lambda parts: ("SERIES", parts))), max_leaves=8)


def lines(part) -> str:
    if isinstance(part, str):
        return part
    return ";".join((part[0], *map(lines, part[1]), "END"))


class Interpreter:
    """Power through a circuit as the manual of LDmicro tells it, memories by the way to an element."""

    def __init__(self) -> None:
        self.bits = dict.fromkeys(("Xa", "Xb", "Rc", "Rd"), False)
        self.before: dict[tuple, bool] = {}

    def power(self, part, power: bool, way: tuple) -> bool:
        if isinstance(part, tuple):
            if part[0] == "PARALLEL":
                after = [self.power(inner, power, (*way, n)) for n, inner in enumerate(part[1])]
                return any(after) if not self._ends(part) else power
            for n, inner in enumerate(part[1]):
                power = self.power(inner, power, (*way, n))
            return power
        word, *args = part.split()
        if word == "CONTACTS":
            return power and self.bits[args[0]] != (args[1] == "1")
        if word == "COIL":
            if args[1:] == ["0", "0", "0", "0"] or power:
                self.bits[args[0]] = power if args[2:4] == ["0", "0"] else args[2] == "1"
            return power
        if word in ("OSR", "OSF"):
            before, self.before[way] = self.before.get(way, False), power
            return power and not before if word == "OSR" else before and not power
        return power and word == "SHORT"

    def _ends(self, part) -> bool:
        return part.startswith("COIL") if isinstance(part, str) else any(map(self._ends, part[1]))


@settings(max_examples=40, deadline=None)
@given(
    st.lists(CIRCUIT, min_size=1, max_size=2),
    st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=6),
)
def test_random_circuits(circuits: list, inputs: list[tuple[bool, bool]]) -> None:
    rungs = [lines(("SERIES", [circuit, "COIL Rc 0 0 0 0"])) for circuit in circuits]
    running = machine(
        project(*rungs, "CONTACTS Xa 0 0;CONTACTS Xb 0 0;CONTACTS Rd 0 0;COIL Rd 0 1 0 0"), PATH
    )
    other = Interpreter()
    for a, b in inputs:
        running.set("Xa", a)
        running.set("Xb", b)
        running.scan()
        other.bits |= {"Xa": a, "Xb": b}
        for n, circuit in enumerate(circuits):
            other.bits["Rc"] = other.power(circuit, True, (n,))
        assert (running.get("Rc"), running.get("Rd")) == (other.bits["Rc"], other.bits["Rd"])


# ---- broken files, files of others


EXAMPLE = project(
    "COMMENT start",
    "CONTACTS Xa 0 0;PARALLEL;TON Td 30000 0;SERIES;CTU Cn 5 0;OSR;END;END;COIL Yq 0 0 0 0",
    "LOOK_UP_TABLE r i 3 0 10 20 -30 levels",
    "FORMATTED_STRING n 4 92 51 13 10",
    "CONTACTS Xa 0 0;GOTO 7",
    "SUBPROG s",
    "ADD n n 1",
    "ENDSUB s",
    "GOSUB s",
    sizes="1 bytes n,2 bytes r",
)


@pytest.mark.parametrize("end", range(0, len(EXAMPLE), 7))
def test_a_file_that_ends_too_early(end: int) -> None:
    parse_file(SourceFile(PATH, EXAMPLE[:end]), Diagnostics())


@settings(max_examples=60, deadline=None)
@given(broken(EXAMPLE))
def test_broken_files_give_findings(text: str) -> None:
    result = compiled(text, PATH)
    assert result.program is not None or said(result)


def test_files_of_others() -> None:
    files = sorted(FOLDER.rglob("*.ld"))
    if not files:
        pytest.skip(f"no collection in {FOLDER.name}")
    results = {path.stem: compile_paths([str(path)]) for path in files}
    assert sum(result.program is not None for result in results.values()) >= 8
    for name, result in results.items():
        bus = [d for d in result.diagnostics if d.code == "LD0151"]
        assert (result.program is None) == bool(bus), name
