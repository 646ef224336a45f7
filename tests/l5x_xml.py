"""Small L5X exports for tests."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from xml.sax.saxutils import escape, quoteattr

ROOT = '<?xml version="1.0" encoding="UTF-8"?>\n<RSLogix5000Content TargetType="Controller">\n'


def tag(name: str, type_: str, dims: str = "", data: str = "", more: str = "") -> str:
    size = f' Dimensions="{dims}"' if dims else ""
    held = f'<Data Format="Decorated">{data}</Data>' if data else ""
    return f'<Tag Name="{name}" TagType="Base" DataType="{type_}"{size} {more}>{held}</Tag>\n'


def value(type_: str, number: object) -> str:
    return f'<DataValue DataType="{type_}" Value="{number}"/>'


def structure(type_: str, **members: object) -> str:
    parts = "".join(f'<DataValueMember Name="{name}" DataType="DINT" Value="{number}"/>'
                    for name, number in members.items())
    return f'<Structure DataType="{type_}">{parts}</Structure>'


def tags(text: str) -> str:
    """``BOOL a b; DINT x[4]`` as tags."""
    found = []
    for part in filter(None, (p.strip() for p in text.split(";"))):
        type_, *names = part.split()
        for name in names:
            plain, _, size = name.rstrip("]").partition("[")
            found.append(tag(plain, type_, size))
    return "".join(found)


def rll(name: str, rungs: Iterable[str], comments: Mapping[int, str] | None = None) -> str:
    comments = comments or {}
    drawn = "".join(
        f'<Rung Number="{n}" Type="N">{f"<Comment>{escape(comments[n])}</Comment>" if n in comments else ""}'
        f"<Text><![CDATA[{text}]]></Text></Rung>\n" for n, text in enumerate(rungs))
    return f"<Routine Name={quoteattr(name)} Type=\"RLL\"><RLLContent>\n{drawn}</RLLContent></Routine>\n"


def st(name: str, lines: Iterable[str]) -> str:
    body = "".join(f'<Line Number="{n}"><![CDATA[{line}]]></Line>\n' for n, line in enumerate(lines))
    return f'<Routine Name="{name}" Type="ST"><STContent>\n{body}</STContent></Routine>\n'


def program(name: str, routines: str, own: str = "", main: str = "Main") -> str:
    return (f'<Program Name="{name}" MainRoutineName="{main}"><Tags>{own}</Tags>'
            f"<Routines>{routines}</Routines></Program>\n")


def controller(programs: str, tags_: str = "", types: str = "", addons: str = "", more: str = "") -> str:
    return (f'{ROOT}<Controller Name="Plant">\n<DataTypes>{types}</DataTypes>\n'
            f"<AddOnInstructionDefinitions>{addons}</AddOnInstructionDefinitions>\n<Tags>{tags_}</Tags>\n"
            f"<Programs>{programs}</Programs>{more}</Controller>\n</RSLogix5000Content>\n")


def one(rungs: Iterable[str], declared: str, routines: str = "", **parts: str) -> str:
    """A program with one ladder routine. ``declared`` as for ``tags``, or tags in XML."""
    found = declared if declared.lstrip().startswith("<") or not declared else tags(declared)
    return controller(program("Main", rll("Main", rungs) + routines), found, **parts)


def addon(name: str, parameters: str, routines: str, local: str = "", more: str = "") -> str:
    own = ('<Parameter Name="EnableIn" DataType="BOOL" Usage="Input" Required="false"/>'
           '<Parameter Name="EnableOut" DataType="BOOL" Usage="Output" Required="false"/>')
    return (f'<AddOnInstructionDefinition Name="{name}" {more}><Parameters>{own}{parameters}</Parameters>'
            f"<LocalTags>{local}</LocalTags><Routines>{routines}</Routines></AddOnInstructionDefinition>\n")


def parameter(name: str, type_: str, usage: str, required: bool = True, dims: str = "") -> str:
    size = f' Dimensions="{dims}"' if dims else ""
    return (f'<Parameter Name="{name}" DataType="{type_}" Usage="{usage}" Required="{str(required).lower()}"'
            f"{size}/>")
