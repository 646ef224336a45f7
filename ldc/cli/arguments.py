"""The grammar of the command line (DESIGN section 8) and its help texts."""

from __future__ import annotations

import argparse
from typing import NoReturn

from ldc import __version__
from ldc.durations import parse_duration
from ldc.similar import similar

_FIRMWARE = ("cortex-m3", "cortex-m4", "cortex-m33")
_SRC = "a .ld, .st or .il file, one of another tool, an ldc.toml, or a folder with one"


def _unsized(prog: str) -> argparse.HelpFormatter:
    """What checks the grammar as it is made. To know how wide the terminal is takes modules that few need."""
    return argparse.RawDescriptionHelpFormatter(prog, width=80)


class _Parser(argparse.ArgumentParser):
    """Errors in two lines: what is wrong, and where to read on."""

    def __init__(self, **settings) -> None:
        super().__init__(allow_abbrev=False, formatter_class=_unsized, **settings)

    def format_help(self) -> str:
        self.formatter_class = argparse.RawDescriptionHelpFormatter
        return super().format_help()

    def error(self, message: str) -> NoReturn:
        message = message.replace("the following arguments are required:", "missing:")
        self.exit(2, f"{self.prog}: {message}\ntry: {self.prog} --help\n")

    def _check_value(self, action: argparse.Action, value: object) -> None:
        if action.choices is not None and value not in action.choices:
            names = [str(choice) for choice in action.choices]
            close = similar(str(value), names, 1)
            hint = f"did you mean `{close[0]}`?" if close else f"choose from: {', '.join(names)}"
            what = "command" if isinstance(action, argparse._SubParsersAction) else "choice"
            raise argparse.ArgumentError(None, f"unknown {what} `{value}`; {hint}")


def make_parser(first: str = "") -> argparse.ArgumentParser:
    """The parser of `ldc`. Each command is run by the module of its name beside this one. When ``first``, the
    first word of a command line, is a command, the parser knows no other: the grammars of all take as long as
    the compile of a small program."""
    parser = _Parser(
        prog="ldc",
        description="Ladder diagrams as text: checked, compiled to proved IEC 61131-3 IL, drawn and run.",
        epilog="start here:\n  ldc new blinker && ldc run blinker\n"
               "  ldc explain LD0301    what a message means",
    )
    parser.add_argument("--version", action="version", version=f"ldc {__version__}")
    commands = parser.add_subparsers(
        dest="command", metavar="COMMAND", title="commands", parser_class=_Parser
    )
    adders = (_new, _check, _compile, _build, _run, _fmt, _draw, _component, _import, _export, _online, _pull,
              _bench, _explain, _doctor)
    for add in [add for add in adders if add.__name__ == f"_{first}"] or adders:
        add(commands)
    return parser


def _command(commands, name: str, help: str, examples: str) -> argparse.ArgumentParser:
    return commands.add_parser(
        name, help=help, description=f"{help[:1].upper()}{help[1:]}.", epilog=f"examples:\n{examples}"
    )


def _sources(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("sources", nargs="+", metavar="SRC", help=_SRC)


def _new(commands) -> None:
    parser = _command(
        commands,
        "new",
        "make a project that compiles, runs and has a trace to compare with",
        "  ldc new conveyor\n  ldc run conveyor",
    )
    parser.add_argument("folder", metavar="DIR", help="the folder to make; it must be empty or not there yet")


def _check(commands) -> None:
    parser = _command(
        commands,
        "check",
        "check sources and prove their compiled form, write nothing",
        "  ldc check main.ld\n  ldc check . --format sarif > ldc.sarif     for a code scanner in CI",
    )
    _sources(parser)
    parser.add_argument(
        "--format",
        choices=("human", "json", "sarif"),
        default="human",
        help="human: on standard error (default); json, sarif: on standard output",
    )
    parser.add_argument("--no-verify", action="store_true", help="do not compare the IL with the drawing")


def _compile(commands) -> None:
    parser = _command(
        commands,
        "compile",
        "compile to IL, or show what a stage of the compiler makes",
        "  ldc compile main.ld                     IEC 61131-3 IL to standard output\n"
        "  ldc compile . --emit image -o line.img  an image for the runtime\n"
        "  ldc compile main.ld --emit graph -o main.dot && dot -Tsvg -O main.dot",
    )
    _sources(parser)
    parser.add_argument(
        "--emit",
        choices=("il", "st", "ast", "graph", "tree", "c", "image"),
        default="il",
        help="il: the program as text (default); st: as Structured Text; ast: what was read; graph: nets and "
        "elements of each rung; tree: its series-parallel form; c: the C of native code; image: bytes for "
        "the runtime",
    )
    parser.add_argument(
        "--format", choices=("text", "dot"), help="of --emit graph (dot also when OUT ends in .dot)"
    )
    parser.add_argument("-o", dest="output", metavar="OUT", help="write to this file, not to standard output")
    parser.add_argument(
        "--max-paren-depth",
        type=_depth,
        metavar="N",
        help="nest parentheses in IL at most N deep, the rest goes through temporaries (1 is read nearly "
        "everywhere, 0 means none at all)",
    )
    parser.add_argument("--no-verify", action="store_true", help="do not compare the IL with the drawing")
    parser.add_argument("--timings", action="store_true", help="show how long each stage took")


def _run(commands) -> None:
    parser = _command(
        commands,
        "run",
        "run a program, in virtual time or in real time",
        "  ldc run main.ld --scans 20\n"
        "  ldc run . --for 2s --period 10ms --watch motor,warm.Q\n"
        "  ldc run . --inputs inputs.csv --trace trace.csv",
    )
    _sources(parser)
    parser.add_argument(
        "--engine", choices=("vm", "native"), default="vm",
        help="vm: IL as Python functions (default); native: IL as C, compiled by gcc"
    )
    parser.add_argument("--target", choices=_FIRMWARE, help="run firmware for this processor, in QEMU")
    _board(parser)
    length = parser.add_mutually_exclusive_group()
    length.add_argument(
        "--scans", type=_natural, metavar="N", help="how many scans (default: as many as the inputs, or 100)"
    )
    length.add_argument(
        "--for", dest="duration", type=_duration, metavar="TIME",
        help="how long instead, 2s: of virtual time, or with --realtime of real time"
    )
    parser.add_argument("--period", type=_duration, metavar="TIME", help="time between two scans, 10ms")
    parser.add_argument(
        "--inputs", metavar="IN.csv", help="values to set: header `scan,a,b`, one row a change"
    )
    parser.add_argument(
        "--watch", metavar="A,B", help="variables to show (default: all located inputs and outputs)"
    )
    parser.add_argument(
        "--trace", metavar="OUT.csv", help="write the watched variables of every scan; - is stdout"
    )
    parser.add_argument(
        "--timing", metavar="OUT.csv", help="with [cost]: what tasks took of the virtual time; - is stdout"
    )
    parser.add_argument(
        "--events", metavar="OUT.csv",
        help="write what master and slaves do: C.START, A.EXEC, ...; - is stdout"
    )
    parser.add_argument(
        "--realtime", action="store_true",
        help="scans at their time, each slave in a process of its own; tells how late they were",
    )
    parser.add_argument(
        "--plot", metavar="OUT.svg",
        help="with --realtime: the lateness of each processor as a picture (.svg, .png)"
    )
    _beside(parser)
    parser.add_argument(
        "--online", action="store_true",
        help="scans at their time, and a socket by which `ldc online` changes the program; runs until Ctrl-C "
        "unless --scans or --for end it",
    )
    parser.add_argument("--no-wait", action="store_true", help="with --online: scans as fast as they go")
    parser.add_argument("--audit", metavar="FILE", help="with --online: the log of changes (JSON lines)")
    _socket(parser)
    parser.add_argument(
        "--sanitize", action="store_true",
        help="find what components in C and C++ write outside of their memory"
    )


def _beside(parser: argparse.ArgumentParser) -> None:
    """What goes on beside the scans of a run."""
    parser.add_argument("--retain", metavar="FILE", help="keep what is RETAIN in this file, over restarts")
    parser.add_argument("--retain-every", type=_duration, metavar="TIME", help="time between two saves (1s)")
    parser.add_argument(
        "--start", choices=("warm", "cold", "origin"),
        help="warm: with the values of the retain file (default); cold: with initial values; origin: the "
        "same, and the file is deleted",
    )
    parser.add_argument("--force", metavar="A=1,B=2",
                        help="hold these variables, whatever inputs and code say")
    parser.add_argument("--ring", metavar="OUT.csv", help="write the scans around an event: needs --trigger")
    _around(parser)


def _around(parser: argparse.ArgumentParser, required: bool = False) -> None:
    """What a trace ring keeps."""
    parser.add_argument(
        "--trigger", metavar="EVENT", required=required,
        help='"motor rises", "motor falls", or a comparison as in "level > 80.0"'
    )
    parser.add_argument("--before", type=_depth, metavar="N", help="rows before the event (100)")
    parser.add_argument("--after", type=_depth, metavar="N", help="rows after it (200)")


def _fmt(commands) -> None:
    parser = _command(
        commands,
        "fmt",
        "bring .ld sources into the one canonical form",
        "  ldc fmt .              rewrite what is not canonical\n  ldc fmt . --check      only tell, for CI",
    )
    _sources(parser)
    parser.add_argument(
        "--check", action="store_true", help="change nothing; status 1 when a file would change"
    )


def _draw(commands) -> None:
    parser = _command(
        commands,
        "draw",
        "draw rungs as text or as SVG",
        "  ldc draw main.ld\n  ldc draw main.ld --rung seal_in --svg seal_in.svg",
    )
    parser.add_argument("source", metavar="SRC", help=_SRC)
    parser.add_argument(
        "--rung", metavar="NAME", help="only this rung: its name, or its number in the program"
    )
    parser.add_argument("--svg", metavar="OUT.svg", help="write an SVG instead; - is standard output")


def _import(commands) -> None:
    parser = _command(
        commands,
        "import",
        "make a project of text files from a project of another tool",
        "  ldc import plc.xml -o plant\n  ldc import plc.xml -o plant --keep-going",
    )
    parser.add_argument("files", nargs="+", metavar="FILE", help="what the other tool wrote")
    parser.add_argument(
        "-o", dest="folder", metavar="DIR", required=True,
        help="the folder to make; it must be empty or not there yet",
    )
    parser.add_argument(
        "--keep-going", action="store_true", help="with errors in the file, write what could be read"
    )


def _build(commands) -> None:
    parser = _command(
        commands,
        "build",
        "compile to code of a processor",
        "  ldc build . --target host -o build    a shared object, its C, and where every variable lies\n"
        "  ldc build . --target cortex-m3        firmware: .elf, .bin, the map, and how much room it takes",
    )
    _sources(parser)
    parser.add_argument(
        "--target", choices=("host", *_FIRMWARE), required=True,
        help="host: this computer, by gcc; others: firmware, by arm-none-eabi-gcc"
    )
    _board(parser)
    parser.add_argument("-o", dest="folder", metavar="DIR", default="build",
                        help="the folder to write (build)")
    parser.add_argument("--sanitize", action="store_true",
                        help="let the code check itself (undefined behaviour)")


def _board(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--board", metavar="BOARD",
                        help="of firmware: a board of ldc, or a board file (.toml)")


def _export(commands) -> None:
    parser = _command(
        commands,
        "export",
        "write a project in the format of another tool",
        "  ldc export . --to plcopen -o plc.xml",
    )
    _sources(parser)
    parser.add_argument("--to", choices=("plcopen",), required=True, help="plcopen: PLCopen TC6 XML 2.01")
    parser.add_argument("-o", dest="output", metavar="OUT", help="write to this file, not to standard output")


def _bench(commands) -> None:
    parser = _command(
        commands,
        "bench",
        "measure the time of a scan: median of batches, per scan and per contact",
        "  ldc bench . --stimulus flip\n  ldc bench main.ld --json",
    )
    parser.add_argument("source", metavar="SRC", help=_SRC)
    parser.add_argument(
        "--engine", choices=("vm", "native"), default="vm",
        help="vm: IL as Python functions (default); native: IL as C, compiled by gcc"
    )
    parser.add_argument(
        "--stimulus",
        choices=("fixed", "flip", "random"),
        default="fixed",
        help="BOOL inputs before each scan: left as they are (default), one is inverted, all are set",
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")


def _socket(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--socket", metavar="PATH",
        help="of the runtime (default: LDC_SOCKET, else one named like the project)"
    )


def _online(commands) -> None:
    parser = _command(
        commands,
        "online",
        "change a program while `ldc run --online` runs it",
        "  ldc online stage . && ldc online test && ldc online commit\n"
        "  ldc online insert press --after feed    a further module in the sequence\n"
        "  ldc online report . --from old          what a change would do, without a runtime",
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True, parser_class=_Parser)

    def action(name: str, help: str) -> argparse.ArgumentParser:
        example = "insert press --after feed" if name == "insert" else name
        added = _command(actions, name, help, f"  ldc online {example}")
        if name == "insert":
            added.add_argument("module", metavar="MODULE", help="a PROGRAM, by its name")
            added.add_argument("--after", metavar="MODULE",
                               help="the module before it (default: the last one)")
        added.add_argument("sources", nargs="*", metavar="SRC", default=["."],
                           help=f"{_SRC} (default: this folder)")
        _socket(added)
        return added

    for name, help in (("stage", "compile and hand over, so that it can be tested"),
                       ("insert", "put a module into the list of the project, and stage the result")):
        action(name, help).add_argument("--expect", metavar="DIGEST", help="refuse when another program runs")
    report = action("report", "what becomes of each symbol")
    report.add_argument("--from", dest="before", metavar="SRC",
                        help="compare with these sources, not with a runtime")
    action("test", "let the staged program run, for a time").add_argument(
        "--for", dest="limit", type=_duration, metavar="TIME",
        help="the program before comes back then (60s)")
    action("untest", "let the program before run again")
    action("commit", "keep the program in test")
    action("cancel", "give up what is staged; a test ends").add_argument(
        "--force", action="store_true", help="whoever staged it")
    action("status", "what runs, what is staged")
    _values(actions)


def _values(actions) -> None:
    """The actions of `online` that deal with values."""

    def action(name: str, help: str, example: str) -> argparse.ArgumentParser:
        added = _command(actions, name, help, f"  ldc online {name}{example}")
        added.add_argument("--src", metavar="SRC", default=".",
                           help="the program that runs (default: this folder)")
        _socket(added)
        return added

    reading = action("get", "show values", " motor warm.ET")
    reading.add_argument("paths", nargs="+", metavar="PATH", help="a variable, as in `motor` or `warm.Q`")
    watching = action("watch", "show values again and again, until Ctrl-C", " motor,warm.ET --every 1s")
    watching.add_argument("names", metavar="A,B", help="variables")
    watching.add_argument("--every", type=_duration, metavar="TIME", help="time between two looks (100ms)")
    watching.add_argument("--for", dest="duration", type=_duration, metavar="TIME",
                          help="end after this time")
    for name, help in (("set", "give a variable a value, once"),
                       ("force", "hold a variable, whatever inputs and code say")):
        writing = action(name, help, " motor 1")
        writing.add_argument("path", metavar="PATH", help="a variable")
        writing.add_argument("value", metavar="VALUE", help="0, TRUE, 12, 1.5, T#20ms, ...")
    letting = action("unforce", "let a forced variable go", " motor")
    letting.add_argument("path", nargs="?", metavar="PATH", help="a variable")
    letting.add_argument("--all", action="store_true", help="all that are forced")
    action("forces", "what is forced", "")
    tracing = action("trace", "write the scans around an event",
                     ' --watch a,b --trigger "a rises" -o out.csv')
    tracing.add_argument("--watch", metavar="A,B", required=True, help="variables, the columns")
    _around(tracing, required=True)
    tracing.add_argument("-o", dest="output", metavar="OUT.csv",
                         help="write to this file, not to standard output")


def _pull(commands) -> None:
    parser = _command(
        commands, "pull", "get the sources of the running program",
        "  ldc pull -o running      write them\n  ldc pull --check         status 1 when those here differ",
    )
    parser.add_argument("sources", nargs="*", metavar="SRC", default=["."],
                        help=f"{_SRC} (default: this folder)")
    parser.add_argument("-o", dest="folder", metavar="DIR", default="pulled",
                        help="a new or empty folder (pulled)")
    parser.add_argument("--check", action="store_true", help="write nothing, compare")
    _socket(parser)


def _component(commands) -> None:
    parser = _command(
        commands,
        "component",
        "make, check and list components in IL, ST, C and C++",
        "  ldc component new ramp --language c\n  ldc component check\n  ldc component list",
    )
    actions = parser.add_subparsers(dest="action", metavar="ACTION", required=True, parser_class=_Parser)
    new = _command(actions, "new", "write a descriptor and a body that work",
                   "  ldc component new ramp -o parts")
    new.add_argument("name", metavar="NAME", help="of the component; ladders name it in capitals")
    new.add_argument("--language", choices=("c", "c++", "st", "il"), default="c",
                     help="of the body (default: c)")
    new.add_argument("-o", dest="folder", metavar="DIR", default=".", help="where (default: here)")
    what = ("a descriptor (.ldc.toml), a project, or sources with descriptors beside them "
            "(default: this folder)")
    check = _command(actions, "check", "compile every component, used or not",
                     "  ldc component check ramp.ldc.toml")
    check.add_argument("sources", nargs="*", metavar="SRC", help=what)
    listing = _command(actions, "list", "the components that a project may use", "  ldc component list")
    listing.add_argument("sources", nargs="*", metavar="SRC", help=what)
    header = _command(actions, "header", "the C header of a component, to test its body alone",
                      "  ldc component header ramp.ldc.toml -o ramp.h && gcc -c ramp.c")
    header.add_argument("source", metavar="SRC", help="a descriptor (.ldc.toml)")
    header.add_argument("-o", dest="output", metavar="OUT", help="write to this file, not to standard output")


def _explain(commands) -> None:
    parser = _command(commands, "explain", "explain a message by its code", "  ldc explain LD0301")
    parser.add_argument("code", metavar="CODE", help="as in error[LD0301]")


def _doctor(commands) -> None:
    _command(commands, "doctor", "show versions, and what is missing for what", "  ldc doctor")


def _natural(text: str) -> int:
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"`{text}` is not a whole number above 0")
    return value


def _depth(text: str) -> int:
    if text.isascii() and text.isdigit() and len(text) < 10:
        return int(text)
    raise argparse.ArgumentTypeError(f"`{text}` is not a whole number from 0")


def _duration(text: str) -> int:
    value = parse_duration(text)
    if not value:
        raise argparse.ArgumentTypeError(
            f"`{text}` is not a time above 0: write a number and a unit, 500us, 10ms, 2s"
        )
    return value
