"""Every ladder instruction that is read, by its name: how many operands it takes, and who writes it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ldc.parser import ast
from ldc.parser.l5x import bits, compute, control, files, loops, process, tables, texts, timing
from ldc.parser.l5x.neutral import Instruction
from ldc.records import record

if TYPE_CHECKING:
    from ldc.parser.l5x.writer import Writer

Write = Callable[["Writer", Instruction], list[ast.Item]]


@record
class Row:
    """``least`` to ``most`` operands; ``most`` None: any number."""

    least: int
    most: int | None
    write: Write


TABLE: dict[str, Row] = {
    name: Row(least, most, write)
    for module in (bits, timing, compute, control, files, tables, loops, texts, process)
    for name, (least, most, write) in module.TABLE.items()
}
_HELP = {
    "MSG": "messages to other devices have no counterpart: give the tag that takes the answer its value",
    "GSV": "what it reads of the controller does not exist here: give the value by a tag",
    "SSV": "what it sets in the controller does not exist here: take the instruction away",
}


def write(writer: Writer, instruction: Instruction) -> list[ast.Item]:
    """The items of a rung that do what the instruction does; none when it is wrong, not read, or without
    effect."""
    name = instruction.name
    row = TABLE.get(name)
    if row is None:
        addon = writer.context.addons.get(name)
        if addon is not None:
            return addon.call(writer, instruction)
        writer.reading.unsupported(instruction.span, f"instruction {_spelled(instruction)}", _HELP.get(
            name, "write it with instructions that are read; docs/import-l5x.md lists them"))
        return []
    return written(writer, instruction, (row.least, row.most, row.write))


def written(writer: Writer, instruction: Instruction, row: tuple[int, int | None, Write]) -> list[ast.Item]:
    """What a row of a table makes of an instruction; none when it has not as many operands as it takes."""
    (least, most, write_), name = row, instruction.name
    given = len(instruction.operands)
    are = "is" if given == 1 else "are"
    if given < least or most is not None and given > most:
        wanted = f"{least}" if most == least else f"{least} to {most}" if most else f"at least {least}"
        writer.reading.malformed(instruction.span,
                                 f"{name} takes {wanted} operand{'s' if wanted != '1' else ''}, "
                                 f"{given} {are} given", help="check the instruction")
        return []
    return write_(writer, instruction)


def _spelled(instruction: Instruction) -> str:
    return instruction.span.text.partition("(")[0].strip()[:40]
