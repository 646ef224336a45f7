"""Everything that the parser can find wrong: one method per code (LD01xx), and how tokens are named.

Messages name what stands there; help says what to do. Long tokens are cut: a line may have megabytes.
"""

from __future__ import annotations

from ldc.diagnostics import Diagnostics, Label
from ldc.parser.lexer import MAX_WORD, MOST_TOKENS, Tokens
from ldc.parser.literals import Malformed
from ldc.source import Span

_CUT = 40
MAX_DEPTH, MAX_OPERATORS, MAX_FINDINGS = 100, 1_000, 1_000
MAX_STATEMENTS = 300_000
"""Of a file; each takes some 4 KB until it is IL."""


def cut(text: str) -> str:
    """What is shown of a token."""
    return text if len(text) <= _CUT else text[: _CUT - 3] + "..."


BEYOND = "LD0237"
"""The code of what other languages have; a POU with such loses names."""
_FUNCTIONS = "make it a FUNCTION, or an action or a FUNCTION_BLOCK of its own"
_POINTERS = "pass the variable by VAR_IN_OUT, or name it"
_JUMPS = "take a loop with EXIT or CONTINUE, IF, or RETURN; rungs jump with `>>name`"
_BEYOND = {
    "METHOD": ("methods are", _FUNCTIONS), "PROPERTY": ("properties are", "make it a variable, or an output"),
    "INTERFACE": ("interfaces are", "leave it out; name the function block that is meant"),
    "EXTENDS": ("function blocks that extend others are",
                "declare an instance of the other one as a variable"),
    "IMPLEMENTS": ("interfaces are", "leave it out; name the function block that is meant"),
    "VAR_STAT": ("variables that all instances share are", "declare them in VAR_GLOBAL"),
    "VAR_INST": ("variables of methods are", "declare them in VAR"),
    "UNION": ("a UNION is", "use a STRUCT, and convert"),
    "POINTER": ("pointers are", _POINTERS), "REFERENCE": ("references are", _POINTERS),
    "REF_TO": ("references are", _POINTERS), "^": ("pointers are", _POINTERS),
    "^ value": ("powers written with `^` are", "write `base ** exponent`, or `EXPT(base, exponent)`"),
    "JMP": ("jumps in statements are", _JUMPS), ":": ("labels of jumps in statements are", _JUMPS),
}


class TooMany(Exception):
    """So much is wrong that reading on helps nobody."""


class Findings:
    """Adds to the bag; the only place where codes LD01xx are written."""

    def __init__(self, tokens: Tokens, diagnostics: Diagnostics) -> None:
        self.tokens, self.diagnostics = tokens, diagnostics
        self._most = len(diagnostics) + MAX_FINDINGS

    def shown(self, index: int) -> str:
        return f"`{cut(self.tokens.text(index))}`"

    def _at(self, code: str, message: str, index: int, label: str = "", help: str = "", secondary=()) -> None:
        self.diagnostics.error(code, message, self.tokens.point(index), label, secondary=secondary, help=help)

    def beyond(self, index: int, word: str) -> None:
        """Something of another language, which this one does not have."""
        what, help = _BEYOND[word]
        self.diagnostics.error(BEYOND, f"{what} not supported", self.tokens.point(index),
                               "this is not read", help=help)

    def enough(self, index: int) -> None:
        """Raises TooMany, and tells it, when the file is too wrong to read on at this token."""
        if len(self.diagnostics) > self._most:
            self._too_long("the file", MAX_FINDINGS, "errors", self.tokens.point(index),
                           "from here on it is not read", "mend the first of them, then check again")
            raise TooMany

    # ---- the text itself

    def behind(self, index: int) -> Span:
        """The place behind a token, where something is missing."""
        end = self.tokens.ends[index]
        return Span(self.tokens.source, end, end)

    def syntax(self, span: Span, message: str, label: str, help: str, secondary=()) -> None:
        self.diagnostics.error("LD0101", message, span, label, secondary=secondary, help=help)

    def unexpected(self, index: int, wanted: str, help: str) -> None:
        """A token where something else has to begin."""
        found = self.shown(index)
        self.syntax(self.tokens.point(index), f"expected {wanted}, found {found}", f"not {wanted}", help)

    def character(self, span: Span, meant: str = "") -> None:
        """A character that no token has; control characters are shown by their code. ``meant``: what to write
        for it."""
        first = span.text[0]
        shown = f"`{first}`" if first.isprintable() else f"U+{ord(first):04X}"
        if ord(first) > 127 and first.isprintable():
            what, help = "is not used in this language", "names have letters a to z, digits and underscores"
            if first in "‘’“”„«»":
                help = "write straight quotes, ' or \""
        elif first.isprintable():
            what, help = "is not used in this language", meant or "remove it, or put it into a comment"
        else:
            what, help = "is a control character", "is the file text? remove the character"
        label = f"{shown} stands here"
        self.diagnostics.error("LD0102", f"the character {shown} {what}", span, label, help=help)

    def open_comment(self, start: int) -> None:
        span = Span(self.tokens.source, start, start + 2)
        closing = "*/" if span.text == "/*" else "*)"
        label, help = "it begins here, and goes on to the end", f"close it with `{closing}`"
        self.diagnostics.error("LD0103", "the comment is not closed", span, label, help=help)

    def open_string(self, span: Span) -> None:
        quote = span.text[0]
        head = Span(span.source, span.start, min(span.end, span.start + _CUT))
        self.diagnostics.error("LD0104", "the string is not closed in its line", head, "it begins here",
                               help=f"close it with `{quote}`; a line break in a string is written `$N`")

    def literal(self, span: Span, problem: Malformed) -> None:
        """No literal, or one whose value no type can hold."""
        text = cut(span.text)
        if problem.range:
            self.diagnostics.error("LD0106", str(problem), span, f"`{text}`", help=problem.help)
        elif text[0] in "'\"" or "'" in text or '"' in text:
            self.diagnostics.error("LD0107", str(problem), span, "in this string", help=problem.help)
        else:
            self.diagnostics.error("LD0105", str(problem), span, f"`{text}`", help=problem.help)

    # ---- brackets and sizes

    def open_bracket(self, opening: int, closer: str, span: Span, found: str) -> None:
        """The bracket at ``opening`` lacks its ``closer`` at ``span``."""
        self.diagnostics.error(
            "LD0108", f"{self.shown(opening)} is not closed", span, f"`{closer}` is missing before {found}",
            secondary=(Label(self.tokens.point(opening), "opened here"),), help=(
                "write `[a OR b]`, or branches in braces, `{ [a] | [b] }`" if closer == "]" and found == "`|`"
                else f"add `{closer}`"))

    def stray_bracket(self, index: int, opening: int | None) -> None:
        secondary: tuple[Label, ...] = ()
        label, help = "nothing is open here", "remove it, or write the opening bracket"
        if opening is not None:
            secondary = (Label(self.tokens.point(opening), "the bracket that is open"),)
            label = f"this does not close {self.shown(opening)}"
            help = "close the brackets in the order of opening"
        self._at("LD0109", f"{self.shown(index)} closes nothing", index, label, help, secondary)

    def too_deep(self, index: int, what: str) -> None:
        self._at("LD0110", f"{what} nested more than {MAX_DEPTH} levels deep", index,
                 f"this one is level {MAX_DEPTH + 1}", "take parts out: into variables, rungs or functions")

    def too_long(self, index: int, what: str, limit: int, of: str) -> None:
        self._too_long(what, limit, of, self.tokens.point(index), f"number {limit + 1:,} stands here",
                       "split it")

    def readable(self) -> None:
        """Raises TooMany, and tells it, when there are more tokens than a file may have."""
        if len(self.tokens.types) > MOST_TOKENS:
            self._endless(MOST_TOKENS, MOST_TOKENS, "symbols")

    def countable(self, index: int, statements: int) -> None:
        """Raises TooMany, and tells it, when a file has too many statements; this is the last one."""
        if statements > MAX_STATEMENTS:
            self._endless(index, MAX_STATEMENTS, "statements")

    def _endless(self, index: int, limit: int, of: str) -> None:
        self._too_long("the file", limit, of, self.tokens.point(index), "from here on it is not read",
                       "split it")
        raise TooMany

    def long_word(self, index: int) -> None:
        """A name, an address or a literal that has no end; only its beginning is shown."""
        start = self.tokens.starts[index]
        self._too_long("the name", MAX_WORD, "characters", Span(self.tokens.source, start, start + 1),
                       f"{self.shown(index)} begins here", "give it a shorter name")

    def _too_long(self, what: str, limit: int, of: str, span: Span, label: str, help: str) -> None:
        self.diagnostics.error("LD0111", f"{what} has more than {limit:,} {of}", span, label, help=help)

    def empty(self, index: int, opening: int) -> None:
        """A branch without an element."""
        self._at("LD0112", "a branch is empty", index, "an element was expected before this",
                 "draw a contact, or a wire with `[TRUE]`, or remove the branch",
                 (Label(self.tokens.point(opening), "the branches begin here"),))

    def empty_rung(self, rung: int, index: int) -> None:
        self.diagnostics.error("LD0113", "the rung has no elements", self.tokens.point(rung), "this rung",
                               help="draw a path, for example `[a] (q)`, or remove the rung")

    # ---- the file

    def empty_file(self) -> None:
        source = self.tokens.source
        self.diagnostics.error("LD0114", "there is nothing in this file", Span(source, 0, 0),
                               "only space and comments", help="begin with `PROGRAM name`")

    def outside(self, index: int, help: str) -> None:
        self._at("LD0115", f"{self.shown(index)} stands outside of any program", index,
                 "here begin only PROGRAM, FUNCTION_BLOCK, FUNCTION, TYPE, VAR_GLOBAL, CONFIGURATION", help)

    def reserved(self, index: int) -> None:
        word = self.tokens.text(index)
        self._at("LD0116", f"`{word}` is a reserved word", index, "a name was expected here",
                 f"choose another name, for example `{word}_1`")

    def pragma(self, index: int) -> None:
        self._at("LD0118", "this pragma is not understood", index, "a `{` begins it",
                 "remove it, or put it into a comment; what an editor only shows, `{attribute ...}` and "
                 "`{region ...}`, may stand in .st files; code in C is written as a component")

    def missing_end(self, end: str, opening: int, index: int, found: str) -> None:
        """``opening`` began what ``end`` should close before the token ``index``."""
        self._at("LD0119", f"{end} is missing", index, f"expected before {found}", f"add {end}",
                 (Label(self.tokens.point(opening), f"{self.shown(opening)} begins here"),))

    def wrong_end(self, index: int, end: str, opening: int) -> None:
        self._at("LD0120", f"{self.shown(index)} stands where {end} was expected", index, f"not {end}",
                 f"write {end}", (Label(self.tokens.point(opening), "this is what ends here"),))

    def late_declarations(self, index: int) -> None:
        self._at("LD0121", "declarations stand before the body", index, "this block comes after code",
                 "move the block up, above the body")

    # ---- details

    def wrong_modifier(self, index: int) -> None:
        self._at("LD0122", f"a contact has no modifier {self.shown(index)}", index, "S and R are for coils",
                 "contacts are `[x]`, `[/x]`, `[P x]` and `[N x]`")

    def power_pin(self, index: int, twice: bool) -> None:
        label = "given twice" if twice else "neither `in` nor `out`"
        self._at("LD0123", "only `in=PIN` and `out=PIN` stand behind the pins of a block", index, label,
                 "each of them at most once; other pins go into the parentheses")

    def no_range(self, index: int) -> None:
        self.syntax(self.tokens.point(index), f"expected the bounds of an array, found {self.shown(index)}",
                    "no bounds",
                    "write `0..9`, or `*` in a parameter that takes arrays of any size")

    def length_of(self, index: int) -> None:
        self._at("LD0124", f"{self.shown(index)} has no length", index, "only STRING and WSTRING have one",
                 "an array is `ARRAY [1..n] OF type`, a subrange `INT (0..n)`")

    def task_setting(self, index: int, twice: bool) -> None:
        label = "given twice" if twice else "not a setting of a task"
        self._at("LD0125", "a task has INTERVAL, SINGLE and PRIORITY, each once", index, label,
                 "write for example `TASK fast (INTERVAL := T#10ms, PRIORITY := 1);`")

    # ---- statements

    def block_open(self, opening: int, end: str, index: int) -> None:
        """The block that ``opening`` began has no ``end`` before the token ``index``."""
        tokens = self.tokens
        there = tokens.point(index) if index < len(tokens.types) else self.behind(index - 1)
        self._at("LD0130", f"{self.shown(opening)} is not closed", opening, f"this has no {end}",
                 f"write `{end};` where it ends",
                 (Label(there, f"{end} was expected before this at the latest"),))

    def stray_word(self, index: int, label: str, help: str) -> None:
        self._at("LD0131", f"{self.shown(index)} does not belong here", index, label, help)

    def misspelt(self, index: int, meant: str) -> None:
        self.syntax(self.tokens.point(index), f"expected a statement, found {self.shown(index)}",
                    "no statement begins so", f"did you mean `{meant}`?")

    def missing_semicolon(self, index: int) -> None:
        self.diagnostics.error("LD0132", f"`;` is missing behind {self.shown(index)}", self.behind(index),
                               "the statement ends here", help="end every statement with `;`")

    def no_latch(self, index: int) -> None:
        self._no_statement(self.tokens.point(index), f"{self.shown(index)} before `=` means nothing here",
                           "only S and R do", "write `:=` to assign, `S=` to set, `R=` to reset")

    def part_of(self, index: int) -> None:
        self.syntax(self.tokens.point(index), f"{self.shown(index)} is no part of a value that can be named",
                    "not one of `.%X3`, `.%B1`, `.%W1`, `.%D1`",
                    "write the size X, B, W, D or L and the number of the part, from 0")

    def equals_sign(self, index: int) -> None:
        self._no_statement(self.tokens.point(index), "`=` compares, it does not assign", "not `:=`",
                           "write `:=` to assign")

    def no_statement(self, first: int, last: int) -> None:
        span = self.tokens.span(first, last)
        self._no_statement(span, f"`{cut(span.text)}` alone is no statement", "nothing is done with it",
                           "assign it, `x := value;`, or call it, `name();`")

    def _no_statement(self, span: Span, message: str, label: str, help: str) -> None:
        self.diagnostics.error("LD0133", message, span, label, help=help)

    def outside_loop(self, index: int) -> None:
        self._at("LD0134", f"{self.shown(index)} stands outside of a loop", index,
                 "no FOR, WHILE or REPEAT around it", "remove it; RETURN leaves the whole POU")

    def no_label(self, index: int, opening: int) -> None:
        self._at("LD0135", "a CASE begins with a label", index, "this belongs to no value",
                 "write the value before it, `1:` or `1, 3..5:`",
                 (Label(self.tokens.point(opening), "this CASE"),))

    def missing_word(self, opening: int, word: str, index: int) -> None:
        found = self.shown(index) if index < len(self.tokens.types) else "the end of the file"
        owner = Label(self.tokens.point(opening), f"belongs to this {self.tokens.text(opening)}")
        self.diagnostics.error("LD0136", f"{word} is missing", self.behind(index - 1),
                               f"{word} was expected before {found}", secondary=(owner,),
                               help=f"write {word} here")

    # ---- sequential function charts

    def no_qualifier(self, span: Span) -> None:
        self.diagnostics.error("LD0137", f"`{cut(span.text)}` is no qualifier of an action", span,
                               "N, S, R, P, P0, P1, L, D, SD, DS or SL",
                               help="write for example `motor(N);` or `motor(D, T#2s);`; behind it a time "
                               "and indicators may stand, without names")

    def time_of_action(self, span: Span, qualifier: str, missing: bool) -> None:
        if missing:
            message, help = f"the qualifier {qualifier} needs a time", f"write `({qualifier}, T#2s)`"
        else:
            message = f"the qualifier {qualifier} has no time"
            help = "take the time away; L, D, SD, DS and SL have one"
        label = "no time behind it" if missing else "a literal"
        self.diagnostics.error("LD0138", message, span, label, help=help)

    def outside_of_chart(self, index: int, meant: str) -> None:
        help = f"did you mean `{meant}`?" if meant else (
            "statements and rungs stand in `ACTION name: ... END_ACTION`, a step names the action")
        self._chart(index, f"{self.shown(index)} stands outside of the steps and actions of the chart",
                    "a chart has steps, transitions and actions", help)

    def transition_without_name(self, index: int) -> None:
        self._chart(index, "a transition with a body needs a name", "no name behind this",
                    "write `TRANSITION name FROM ...`; the body sets the BOOL variable `name`")

    def no_priority(self, index: int) -> None:
        self._chart(index, f"a transition has no setting {self.shown(index)}", "only PRIORITY",
                    "write `(PRIORITY := 1)`; the transition with the least number goes first")

    def _chart(self, index: int, message: str, label: str, help: str) -> None:
        self._at("LD0139", message, index, label, help)
