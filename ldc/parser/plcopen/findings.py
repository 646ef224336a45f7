"""What is wrong with a PLCopen XML file, LD014x: one function raises each code."""

from __future__ import annotations

from ldc.diagnostics import Diagnostics, Label
from ldc.source import Span


def not_well_formed(diagnostics: Diagnostics, span: Span, problem: str, opened: Span | None) -> None:
    secondary = (Label(opened, "in this element"),) if opened else ()
    diagnostics.error("LD0140", f"this is no well-formed XML: {problem}", span, "reading stops here",
                      secondary=secondary, help="is the file complete? export it again")


def document_type(diagnostics: Diagnostics, span: Span) -> None:
    diagnostics.error("LD0141", "a document type is not read", span, "declared here",
                      help="PLCopen files have none: take the <!DOCTYPE ...> and its entities away")


def too_large(diagnostics: Diagnostics, span: Span, limit: int, what: str) -> None:
    diagnostics.error("LD0142", f"the XML has more than {limit:,} {what}", span, "reading stops here",
                      help="export fewer POUs at a time")


_OF_OTHERS = {
    "TcPlcObject": ("a source file of TwinCAT", "export the POUs in TwinCAT: Export PLCopenXML"),
    "ExportFile": ("an export of CODESYS in a format of its own", "export it again: Project, Export PLCopenXML"),
    "FEFExchangeFile": ("an exchange file of Control Expert", "it has no export as TC6: export the program as text"),
    "FBType": ("a block of IEC 61499", "export the algorithms as Structured Text"),
}
"""XML of other tools, by the name of its first element: what it is, and how the program comes from there."""


def no_project(diagnostics: Diagnostics, span: Span, tag: str) -> None:
    what, help = _OF_OTHERS.get(tag, (f"begins with <{tag[:40]}>", "export the program as PLCopen XML (TC6)"))
    label = "not <project>"
    if tag == "project":
        what, label = "holds no POU, type or variable", "nothing in it"
    elif tag in _OF_OTHERS:
        what = f"is {what}"
    diagnostics.error("LD0143", f"this is no PLCopen project: it {what}", span, label, help=help)


def malformed(diagnostics: Diagnostics, span: Span, message: str, help: str = "") -> None:
    diagnostics.error("LD0144", message, span, "in this element", help=help or "export the file again")


def unsupported(diagnostics: Diagnostics, span: Span, message: str, label: str, help: str) -> None:
    diagnostics.error("LD0145", message, span, label, help=help)


def no_such_element(diagnostics: Diagnostics, span: Span, where: str, target: str) -> None:
    diagnostics.error("LD0146", f"{where} is connected to {target}, which does not exist", span,
                      "the wire leads here",
                      help="draw the wire again in the editor that the file comes from")


def open_pin(diagnostics: Diagnostics, span: Span, where: str, pin: str, what: str) -> None:
    diagnostics.warning("LD0148", f"{where} has nothing at its input {pin}, which {what}", span, "open input",
                        help="a function has no memory: connect the input in the drawing")


def loose(diagnostics: Diagnostics, span: Span, where: str, why: str) -> None:
    diagnostics.warning("LD0147", f"{where} {why} and is left out", span, "not part of a rung",
                        help="connect it, or delete it from the drawing")


def written_input(diagnostics: Diagnostics, span: Span, name: str, address: str) -> None:
    diagnostics.warning("LD0149", f"`{name}` is the input {address}, and the program writes it", span,
                        "loses its address",
                        help="it keeps what is written; give it an address in %Q or %M, or none")


def moved(diagnostics: Diagnostics, span: Span, name: str, address: str, to: str) -> None:
    diagnostics.warning("LD0155", f"`{name}` at {address} would lie on narrower variables here", span,
                        f"is at {to} instead",
                        help="bits and words are apart where the file comes from; connect the signal there")


def converted(diagnostics: Diagnostics, span: Span, source: str, target: str) -> None:
    diagnostics.warning("LD0156", f"a value of type {source} becomes {target} without a conversion", span,
                        f"this is {source}",
                        help=f"other editors convert it by themselves; write {source}_TO_{target}")


def nothing_runs(diagnostics: Diagnostics, span: Span, programs: int, task: str | None) -> None:
    where = f"in the task `{task}`" if task is not None else "without a task"
    whose = "the program" if programs == 1 else f"the {programs} programs"
    diagnostics.warning("LD0157", f"no resource of this file runs a program: {whose} of it will run {where}",
                        span, "without instances of programs",
                        help="give the programs instances in the editor that the file comes from")


def fed_later(diagnostics: Diagnostics, span: Span, where: str, source: str) -> None:
    diagnostics.warning("LD0159", f"{where} is executed before {source}, which feeds it", span,
                        "is executed behind it here", help="turn the two around in the order of execution; to read "
                        "the value of the scan before, store it in a variable")


def chart_flag(diagnostics: Diagnostics, span: Span, name: str) -> None:
    diagnostics.warning("LD0160", f"`{name}` does not control or watch the chart", span,
                        "an ordinary variable here",
                        help="say in the chart what it does there: a transition back to the initial step, a condition")
