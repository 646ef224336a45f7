"""What the instructions of an LDmicro program share while they are read."""

from __future__ import annotations

from dataclasses import dataclass, field

from ldc.parser import ast
from ldc.parser.foreign import Names, Reading, stored
from ldc.parser.ldmicro.text import Leaf
from ldc.parser.ldmicro.variables import BITS, STRINGS, Variable, Variables, number
from ldc.source import Span

PACKAGE = "ldc.parser.ldmicro"


@dataclass(slots=True)
class Body:
    """A POU that is being read: the instances of blocks in it, by name, and the variables that it uses."""

    instances: dict[str, tuple[str, Span]] = field(default_factory=dict)
    used: dict[str, Variable] = field(default_factory=dict)


@dataclass(slots=True)
class Context:
    """``periods``: scans of a timer by the place of its line; ``labels``: the rung of each label;
    ``subprograms``: the function block of each; ``resets``: what RES puts into a counter; ``first``: where
    the rung that is being read begins."""

    reading: Reading
    names: Names
    variables: Variables
    periods: dict[int, int | None]
    resets: dict[str, str]
    labels: dict[str, str] = field(default_factory=dict)
    subprograms: dict[str, str] = field(default_factory=dict)
    body: Body = field(default_factory=Body)
    first: int = -1
    blocks: dict[str, ast.Pou] = field(default_factory=dict)

    def bit(self, foreign: str, leaf: Leaf) -> str:
        name = self.variables.bit(foreign, leaf.span)
        self.body.used[name] = self.variables.found[foreign]
        return name

    def integer(self, foreign: str, leaf: Leaf) -> Variable:
        found = self.variables.integer(foreign, leaf.span)
        self.body.used[found.name] = found
        return found

    def added(
        self, wanted: str, type_: str, leaf: Leaf, why: str, initial: str | None = None, key: str = ""
    ) -> str:
        """The name of a variable that the file has none for; the same one for the same ``key``."""
        found = self.variables.added(wanted, type_, leaf.span, why, initial, key or wanted)
        self.body.used[found.name] = found
        return found.name

    def instance(self, block: str, wanted: str, leaf: Leaf) -> str:
        """A new instance of a block in this POU."""
        name = self.names.fresh(wanted)
        self.body.instances[name] = (block, leaf.span)
        self.reading.remark("added", leaf.span.text, f"{name}, an instance of {block}", leaf.span)
        return name

    def supporting(self, file: str, /, **values: object) -> str:
        """The name of a block of ours, which is added to the file."""
        key = f"{file} {sorted(values.items())}"
        if key not in self.blocks:
            (self.blocks[key],) = stored(PACKAGE, file, **values)
        return self.blocks[key].name

    # ---- operands

    def operand_type(self, text: str, leaf: Leaf) -> str | None:
        """The type of an operand; None for a number, which has the type that it is used with."""
        return None if number(text) is not None else self.integer(text, leaf).type

    def operand(self, text: str, type_: str, leaf: Leaf) -> str:
        """An operand as an expression of a type."""
        value = number(text)
        if value is None:
            found = self.integer(text, leaf)
            return converted(found.name, found.type, type_)
        bits = BITS[type_]
        if not -(1 << bits - 1) <= value < 1 << bits:
            self.reading.malformed(leaf.span, f"{text} has no place in {bits} bits",
                                   help="use a smaller number, or a variable of more bytes")
        signed = (value + (1 << bits - 1)) % (1 << bits) - (1 << bits - 1)
        if signed != value:
            self.reading.remark("mapped", text, f"{signed}: numbers have a sign", leaf.span)
        return str(signed)

    def move(self, value: str, type_: str, target: Variable) -> str:
        """A MOVE of an expression of a type, made as wide as the target."""
        return f"<MOVE(IN := {converted(value, type_, target.type)}, OUT => {target.name})>"


def converted(value: str, type_: str, wanted: str) -> str:
    return value if type_ == wanted else f"{type_}_TO_{wanted}({value})"


def as_string(value: str, type_: str) -> str:
    """An integer as the bit string of its width."""
    return f"{type_}_TO_{STRINGS[type_]}({value})"


def as_integer(value: str, type_: str) -> str:
    return f"{STRINGS[type_]}_TO_{type_}({value})"


def bypass(chain: str) -> str:
    """Elements beside the power, which goes on unchanged."""
    return f"{{ {chain} | [TRUE] }}"

