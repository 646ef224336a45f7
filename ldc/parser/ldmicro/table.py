"""The instructions of LDmicro: how many operands each needs, what writes it, and how it treats power."""

from __future__ import annotations

from collections.abc import Callable

from ldc.parser.ldmicro import arithmetic as numbers
from ldc.parser.ldmicro import instructions as steps
from ldc.parser.ldmicro import peripherals
from ldc.parser.ldmicro.context import Context
from ldc.parser.ldmicro.text import Leaf

Handler = Callable[[Context, Leaf], str]
_CALCULATIONS = ("ADD", "SUB", "MUL", "DIV", "MOD")
TIMERS = ("TON", "TOF", "RTO", "RTL", "TCY", "THI", "TLO")
COUNTERS = ("CTU", "CTD", "CTC", "CTR")
HANDLERS: dict[str, tuple[int, Handler]] = {
    "CONTACTS": (2, steps.contacts), "COIL": (4, steps.coil),
    **dict.fromkeys(("EQU", "NEQ", "GRT", "GEQ", "LES", "LEQ"), (2, steps.comparison)),
    **dict.fromkeys(("IF_BIT_SET", "IF_BIT_CLEAR"), (2, steps.bit_test)),
    "SHORT": (0, steps.nothing), "LABEL": (1, steps.nothing), "COMMENT": (0, steps.nothing),
    "OPEN": (0, steps.opened), "CLRWDT": (0, steps.watchdog),
    "OSR": (0, steps.rising), **dict.fromkeys(("OSF", "OSL", "OSC"), (0, steps.one_shot)),
    **dict.fromkeys(TIMERS, (2, steps.timer)), "TIME2COUNT": (2, steps.time_to_count),
    **dict.fromkeys(COUNTERS, (2, steps.counter)), "RES": (1, steps.reset),
    "MASTER_RELAY": (0, steps.master_relay), "GOTO": (1, steps.goto), "RETURN": (0, steps.leave),
    "GOSUB": (1, steps.gosub),
    "MOVE": (2, numbers.move), **dict.fromkeys(_CALCULATIONS, (3, numbers.calculation)),
    "NEG": (2, numbers.negation), "NOT": (2, numbers.bitwise),
    **dict.fromkeys(("AND", "OR", "XOR"), (3, numbers.bitwise)),
    **dict.fromkeys(("SHL", "SR0", "ROL", "ROR"), (3, numbers.shift)), "SHR": (3, numbers.shift_right),
    "BIN2BCD": (2, numbers.decimal), "BCD2BIN": (2, numbers.decimal), "OPPOSITE": (2, numbers.opposite),
    "BUS": (10, numbers.bus), "7SEGMENTS": (3, numbers.segments),
    "SWAP": (2, numbers.swap), **dict.fromkeys(("SET_BIT", "CLEAR_BIT"), (2, numbers.one_bit)),
    "SHIFT_REGISTER": (2, numbers.shift_register), "LOOK_UP_TABLE": (4, numbers.look_up),
    "PIECEWISE_LINEAR": (3, numbers.piecewise),
    "READ_ADC": (1, peripherals.read_adc), "SET_PWM": (2, peripherals.set_pwm),
    "I2C_RD": (6, peripherals.i2c), "I2C_WR": (6, peripherals.i2c), "SPI": (3, peripherals.spi),
    "PERSIST": (1, peripherals.persist), "UART_RECV": (1, peripherals.uart_receive),
    "UART_SEND": (1, peripherals.uart_send), "UART_RECV_AVAIL": (0, peripherals.uart_available),
    **dict.fromkeys(("UART_SEND_READY", "UART_SEND_BUSY", "UART_UDRE"), (0, peripherals.uart_ready)),
    "FORMATTED_STRING": (1, peripherals.formatted_string),
}
END_OF_RUNG = frozenset("""
    ADD SUB MUL DIV MOD COIL RES READ_ADC SET_PWM MASTER_RELAY CLRWDT GOTO GOSUB RETURN SHIFT_REGISTER
    LOOK_UP_TABLE PIECEWISE_LINEAR PERSIST MOVE""".split())
"""Behind a PARALLEL with one of these, power is what it was before."""
STAY_SAME = END_OF_RUNG | frozenset(
    "SET_BIT CLEAR_BIT SHL SHR SR0 ROL ROR AND OR XOR NOT NEG SWAP BIN2BCD BCD2BIN OPPOSITE BUS "
    "7SEGMENTS".split())
"""They only compute: as a branch they give no power."""
LEAVING = ("GOTO", "RETURN")
HARMLESS = frozenset((*LEAVING, *"""
    CONTACTS EQU NEQ GRT GEQ LES LEQ IF_BIT_SET IF_BIT_CLEAR SHORT OPEN COMMENT""".split()))
"""What may stand behind a jump in its rung: it does nothing but pass power."""
