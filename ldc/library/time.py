"""Functions of time data types (IEC 61131-3, 2nd edition, table 30). All count nanoseconds."""

from __future__ import annotations

from ldc.library.numeric import ADD, DIV, MUL, SUB
from ldc.library.table import Function, Shape
from ldc.library.values import DAY
from ldc.types import DT

GROUP = "30 time"


def _pair(name: str, left: str, right: str, result: str, meaning, note: str = "") -> Function:
    return Function(name, ("IN1", "IN2"), (Shape((left, right), result),), meaning, GROUP, note)


def _concat(types, result):
    mask = DT.range[1]
    return lambda date, time: (date * DAY + time) & mask


FUNCTIONS = (
    _pair("ADD_TIME", "TIME", "TIME", "TIME", ADD),
    _pair("ADD_TOD_TIME", "TOD", "TIME", "TOD", ADD, "goes round at midnight"),
    _pair("ADD_DT_TIME", "DT", "TIME", "DT", ADD),
    _pair("SUB_TIME", "TIME", "TIME", "TIME", SUB),
    _pair("SUB_DATE_DATE", "DATE", "DATE", "TIME", SUB),
    _pair("SUB_TOD_TIME", "TOD", "TIME", "TOD", SUB, "goes round at midnight"),
    _pair("SUB_TOD_TOD", "TOD", "TOD", "TIME", SUB),
    _pair("SUB_DT_TIME", "DT", "TIME", "DT", SUB),
    _pair("SUB_DT_DT", "DT", "DT", "TIME", SUB),
    _pair("MULTIME", "TIME", "own ANY_NUM", "TIME", MUL,
          "by an integer exact (it wraps), by a REAL rounded half to even to the nanosecond; also MUL_TIME"),
    _pair("DIVTIME", "TIME", "own ANY_NUM", "TIME", DIV,
          "by an integer cut toward zero, by a REAL rounded half to even; a fault when IN2 is 0; also "
          "DIV_TIME"),
    _pair("CONCAT_DATE_TOD", "DATE", "TOD", "DT", _concat),
)
# Names of the 3rd edition.
ALIASES = {"MUL_TIME": "MULTIME", "DIV_TIME": "DIVTIME"}
