#!/usr/bin/env python3
"""Writes docs/library.md from the tables of ldc.library; ``--check`` only compares (exit status 1)."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from ldc.library import blocks, conversion, functions, time  # noqa: E402
from ldc.library.generic import GENERIC, short_name  # noqa: E402
from ldc.library.table import Shape  # noqa: E402

PAGE = ROOT / "docs" / "library.md"
HEAD = """\
# Standard library

Made by `script/library-docs.py` from the tables of `ldc.library`; do not edit.

All functions and function blocks of IEC 61131-3 (2nd edition, tables 22 to 30 and 34 to 37). What
happens at the edges (overflow, rounding, positions outside a string, times) is told in
[semantics.md](semantics.md).

A function is called in an expression (`MAX(a, b)`, `MAX(IN1 := a, IN2 := b)`) or drawn as a block
(`<MAX(IN1 := a, IN2 := b, OUT => c)>`), then with EN, ENO and the result at OUT. `...` after the last
pin: the function takes more of the kind. Arguments are widened to the smallest type that takes them all.
Numerical, bit string, selection and comparison functions have typed names as well: `ADD_DINT(a, b)` is ADD in DINT.
"""
GROUP_TITLES = {
    "22": "Type conversion", "23": "Numeric functions", "24": "Arithmetic", "25": "Bit shift",
    "26": "Bitwise", "27": "Selection", "28": "Comparison", "29": "Character strings", "30": "Time",
}
KINDS = {
    "int": "SINT INT DINT LINT", "uint": "USINT UINT UDINT ULINT", "real": "REAL LREAL", "bool": "BOOL",
    "bits": "BYTE WORD DWORD LWORD", "time": "TIME", "date": "DATE", "tod": "TIME_OF_DAY",
    "dt": "DATE_AND_TIME", "string": "STRING WSTRING", "enum": "enumerations",
    "aggregate": "arrays and structures",
}
TERMS = {
    "SR": "Q1 is set by S1 and reset by R; S1 wins.",
    "RS": "Q1 is set by S and reset by R1; R1 wins.",
    "R_TRIG": "Q is TRUE for one execution when CLK rises; a CLK that is TRUE in the first one counts.",
    "F_TRIG": "Q is TRUE for one execution when CLK falls; there is no edge in the first one.",
    "CTU": "Counts rising CU up to the greatest value of its type; R resets and wins; Q: CV >= PV.",
    "CTD": "Counts rising CD down to the least value of its type; LD loads PV and wins; Q: CV <= 0.",
    "CTUD": "Both; R wins over LD, LD over counting; both edges at once change nothing. QU: CV >= PV, "
            "QD: CV <= 0.",
    "TP": "Pulse: Q for PT from a rising IN; ready again when IN was FALSE at or after the end.",
    "TON": "On delay: Q when IN has been TRUE for PT.",
    "TOF": "Off delay: Q with IN, and for PT after it fell.",
}


def table(head: str, rows: list[str]) -> str:
    columns = head.count("|") - 1
    return "\n".join([head, "|" + "---|" * columns, *rows]) + "\n"


def result_words(row: functions.Function, shape: Shape) -> str:
    if shape.result == "sum":
        return "string of all lengths together"
    if shape.result != "same":
        return shape.result
    shared = [n for n, kind in zip(row.names, shape.inputs, strict=True) if kind in GENERIC]
    return f"as {shared[0]}" if len(shared) == 1 else "common type"


def function_row(row: functions.Function) -> str:
    pins = []
    for shape in row.shapes:
        kinds = [kind.removeprefix("own ") for kind in shape.inputs]
        one = ", ".join(f"{n}: {k}" for n, k in zip(row.names, kinds, strict=True))
        more = " ..." if shape.extends else ""
        pins.append(f"{one}{more} → {result_words(row, shape)}")
    return f"| `{row.name}` | {'<br>'.join(pins)} | {row.mnemonic or '-'} | {row.note or '-'} |"


def generics() -> str:
    rows = [f"| {name} | {' '.join(words for kind, words in KINDS.items() if kind in kinds)} |"
            for name, kinds in GENERIC.items()]
    return "## Generic types\n\n" + table("| name | stands for |", rows)


def widening() -> str:
    rows = []
    for source in conversion.TYPES:
        targets = [t.name for t in conversion.TYPES if t != source and functions.widens(source, t)]
        if targets:
            rows.append(f"| {source.name} | {' '.join(targets)} |")
    text = ("## Implicit conversions\n\nOnly these happen unasked, and none of them loses anything. "
            "A subrange counts as its base type; a string is cut when it is stored in a shorter one.\n\n")
    return text + table("| from | to |", rows)


def conversions() -> str:
    rows = []
    for source in conversion.TYPES:
        targets = [short_name(t) for t in conversion.TYPES if conversion.exists(source, t)]
        rows.append(f"| `{short_name(source)}_TO_` | {' '.join(targets)} |")
    text = ("## Type conversion (table 22)\n\nThe name is that of the row and one of the targets: "
            "`INT_TO_REAL`. `DATE_AND_TIME` and `TIME_OF_DAY` are understood for DT and TOD. `TO_INT(x)` and so on "
            "(3rd edition) choose the row by the type of `x`, which may be an enumeration. The pin is IN.\n\n")
    text += table("| from | to |", rows)
    truncations = ", ".join(f"`{row.name}`" for row in conversion.TRUNCATIONS)
    bcd = ", ".join(f"`{row.name}`" for row in conversion.BCD)
    enumerations = ", ".join(f"`{row.name}`" for row in conversion.ENUMERATIONS)
    return (f"{text}\nThe number of an enumeration value (not in the standard): {enumerations}.\n"
            f"\nFraction cut off; saturates, NaN gives 0: {truncations}.\n\n"
            f"Binary coded decimals: {bcd}.\n")


def groups() -> str:
    parts = []
    for number, title in GROUP_TITLES.items():
        rows = [function_row(r) for r in functions.TABLE.values() if r.group.startswith(number)
                and not r.internal]
        if number == "22":
            parts.append(conversions())
        else:
            parts.append(f"## {title} (table {number})\n\n"
                         + table("| function | pins → result | IL operator | meaning |", rows))
    aliases = ", ".join(f"`{a}` is `{n}`" for a, n in time.ALIASES.items())
    return "\n".join(parts) + f"\n{aliases} (3rd edition).\n"


def block_rows() -> str:
    rows = []
    for name, words in TERMS.items():
        pins = blocks.signature(name)
        inputs = ", ".join(f"{p.name}: {p.type}" for p in pins.inputs)
        outputs = ", ".join(f"{p.name}: {p.type}" for p in pins.outputs)
        rows.append(f"| `{name}` | {inputs} | {outputs} | {words} |")
    others = ", ".join(f"`{name}`" for name in blocks.names() if name not in TERMS)
    text = ("## Function blocks (tables 34 to 37)\n\nEach is one text in IL (`ldc/library/blocks/`) that "
            "every engine compiles. Power enters at the first input and leaves at the first output unless "
            "the drawing says otherwise.\n\n")
    return (text + table("| block | inputs | outputs | meaning |", rows)
            + f"\nThe counters also count in other types; the name tells that of PV and CV: {others}.\n")


def page() -> str:
    return "\n".join([HEAD, generics(), widening(), groups(), block_rows()])


def main(arguments: list[str]) -> int:
    text = page()
    if arguments == ["--check"]:
        return 0 if PAGE.is_file() and PAGE.read_text(encoding="utf-8") == text else 1
    if arguments:
        print("usage: library-docs.py [--check]", file=sys.stderr)
        return 2
    PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
