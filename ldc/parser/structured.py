"""The body of a POU in Structured Text: its words cut into statements, which are parsed one by one.

Keywords are reserved, so blocks are found without knowing what stands between them. A statement that is
wrong gives its findings and is left out; reading goes on behind its ``;`` or at the next keyword.
"""

from __future__ import annotations

from ldc.parser import beyond, lr, syntax
from ldc.parser import statements as st
from ldc.parser.findings import MAX_DEPTH, cut
from ldc.parser.lexer import SECTIONS
from ldc.parser.units import Units
from ldc.similar import similar
from ldc.source import Span

_BLOCKS = {
    "IF": ("ELSIF", "ELSE", "END_IF"), "CASE": ("ELSE", "END_CASE"), "FOR": ("END_FOR",),
    "WHILE": ("END_WHILE",), "REPEAT": ("UNTIL", "END_REPEAT"),
}
_CLOSING = frozenset(word for words in _BLOCKS.values() for word in words)
_LOOPS = ("FOR", "WHILE", "REPEAT")
_LEAVING = ("EXIT", "RETURN")
_HEADS = ("THEN", "DO", "OF")
_STARTS = frozenset((*_BLOCKS, *_LEAVING))
_STRUCTURE = _STARTS | _CLOSING | {*SECTIONS, "END_VAR", "RUNG"}
_NO_LABEL = _STRUCTURE | {*_HEADS, ";", ":=", "=>", "TO", "BY"}
_MEANT = (*_BLOCKS, *_LEAVING, *_CLOSING)
_OTHERS = {"ELSEIF": "ELSIF", "ELIF": "ELSIF", "ENDIF": "END_IF", "SWITCH": "CASE", "BREAK": "EXIT"}
_FOLLOW = ("NAME", "DIRECT", "NOT", "LITERAL", "INTEGER", ";")


def read_body(units: Units, first: int, end: int, span: Span) -> st.StatementBody:
    """The statements that the tokens ``first`` to ``end`` (exclusive) are."""
    return st.StatementBody(_Reader(units, first, end).all(), span)


class _Reader:
    """Goes through the tokens once; ``at`` is the next one. ``blocks``: the words that opened the blocks
    around it, the outermost first."""

    def __init__(self, units: Units, first: int, end: int) -> None:
        self.units, self.findings = units, units.findings
        self.tokens, self.types = units.tokens, units.types
        self.at, self.end = first, end
        self.blocks: list[str] = []

    def all(self) -> tuple[st.Statement, ...]:
        statements = list(self._list())
        while self.at < self.end:  # a word that closes nothing
            self._stray("nothing is open that it belongs to", "remove it, or write what it should close")
            statements += self._list()
        return tuple(statements)

    # ---- lists

    def _kind(self) -> str:
        """The type of the next token, "" at the end."""
        return self.types[self.at] if self.at < self.end else ""

    def _span(self, first: int) -> Span:
        """From a token to the last one that was read."""
        return self.tokens.span(first, max(first, self.at - 1))

    def _list(self) -> tuple[st.Statement, ...]:
        """Statements, up to a word or label that a block around them is waiting for."""
        found: list[st.Statement] = []
        while self.at < self.end:
            kind = self._keyword()
            if kind in _CLOSING:
                if not self.blocks or any(kind in _BLOCKS[word] for word in self.blocks):
                    break
                self._stray("no such block is open here", "remove it, or write what it should close")
                continue
            if "CASE" in self.blocks and self._label_end():
                break
            statement = self._statement(kind)
            if isinstance(statement, tuple):
                found += statement
            elif statement is not None:
                found.append(statement)
        return tuple(found)

    def _keyword(self) -> str:
        """The next token's type; a name that is a misspelt keyword is told and taken as that."""
        kind = self._kind()
        if kind != "NAME":
            return kind
        word = cut(self.tokens.text(self.at)).upper()
        following = self.types[self.at + 1] if self.at + 1 < self.end else ";"
        if following not in _FOLLOW or word == "CONTINUE" and following == ";":
            return kind
        meant = _OTHERS.get(word) or next(iter(similar(word, _MEANT, 1, 0.75)), None)
        if meant is None or (following == ";") != (meant.startswith("END_") or meant in _LEAVING):
            return kind
        self.findings.misspelt(self.at, meant)
        self.types[self.at] = meant
        return meant

    def _stray(self, label: str, help: str) -> None:
        self.findings.stray_word(self.at, label, help)
        self.at += 1
        self._skip(_STRUCTURE)
        self.at += self._kind() == ";"

    def _skip(self, stops: frozenset[str]) -> None:
        while self.at < self.end and self.types[self.at] not in stops and self.types[self.at] != ";":
            self.at += 1

    # ---- one statement

    def _statement(self, kind: str) -> st.Statement | tuple[st.Statement, ...] | None:
        self.findings.enough(self.at)
        self.units.statements += 1
        self.findings.countable(self.at, self.units.statements)
        if kind == ";":
            self.at += 1
            return st.Empty(self._span(self.at - 1))
        if kind in _BLOCKS:
            return self._block(kind)
        if kind in _LEAVING or kind == "NAME" and self._is_continue():
            return self._leave()
        if kind in SECTIONS:
            return self._section()
        if kind == "{":
            return self._pragma()
        if kind in _HEADS or kind in ("TO", "BY", "RUNG", "END_VAR", ":"):
            self._stray("no statement begins so", "statements are `x := value;`, `t(IN := a);`, IF, CASE, "
                        "FOR, WHILE, REPEAT, EXIT, CONTINUE and RETURN")
            return None
        return self._simple()

    def _pragma(self) -> None:
        """One that is not known to have no effect: all of it, or without an end the rest of the statement."""
        self.findings.pragma(self.at)
        depth = 0
        for at in range(self.at, self.end):
            depth += (self.types[at] == "{") - (self.types[at] == "}")
            if not depth:
                self.at = at + 1
                return
        self.at = next((at for at in range(self.at, self.end) if self.types[at] == ";"), self.at) + 1

    def _is_continue(self) -> bool:
        """CONTINUE is no keyword of the 2nd edition: it is known by standing alone."""
        following = self.types[self.at + 1] if self.at + 1 < self.end else ";"
        return self.tokens.text(self.at).upper() == "CONTINUE" and (following == ";" or following in _CLOSING)

    def _leave(self) -> st.Leave | None:
        word = self.types[self.at] if self.types[self.at] in _LEAVING else "CONTINUE"
        inside = word == "RETURN" or any(block in _LOOPS for block in self.blocks)
        if not inside:
            self.findings.outside_loop(self.at)
        self.at += 1
        span = self._span(self.at - 1)
        self._semicolon()
        return st.Leave(word, span) if inside else None

    def _section(self) -> None:
        self.findings.late_declarations(self.at)
        self.units.lost = True
        while self.at < self.end and self.types[self.at] != "END_VAR":
            self.at += 1
        self.at = min(self.at + 1, self.end)

    def _simple(self) -> st.Statement | tuple[st.Statement, ...] | None:
        first = self.at
        if beyond.tell_jump(self.tokens, first, self.findings):
            self.at += 2 + (self.types[first + 1] == "NAME")
            return None
        self._skip(_STRUCTURE | set(_HEADS))
        stop = self.at
        value = self.units.attempt("statement", first, stop, "statement")
        if not isinstance(value, lr.Failure):
            self._semicolon()
            return value
        index = value.index
        if ":=" in value.expected and index < stop and self.types[index] == "=":
            self.findings.equals_sign(index)
        elif index == stop and {":=", "("} <= value.expected:
            self.findings.no_statement(first, stop - 1)
        elif index < stop and index > first and "$END" in value.expected and self._begins(index):
            self.at = index
            self._semicolon()
            return self.units.attempt("statement", first, index, "statement")
        else:
            syntax.explain(value, self.findings, first, stop, "statement")
        self.at += self._kind() == ";"
        return None

    def _begins(self, index: int) -> bool:
        """Whether a token may begin a statement that stands in a line of its own."""
        text = self.tokens.source.text
        return self.types[index] in ("NAME", "DIRECT") and (
            "\n" in text[self.tokens.ends[index - 1] : self.tokens.starts[index]]
            or self.types[index + 1 : index + 2] == [":="])

    def _semicolon(self) -> None:
        if self._kind() == ";":
            self.at += 1
        else:
            self.findings.missing_semicolon(self.at - 1)

    # ---- blocks

    def _block(self, word: str) -> st.Statement | None:
        opening = self.at
        if len(self.blocks) == MAX_DEPTH:
            self.findings.too_deep(opening, "statements are")
            self.at = self.end
            return None
        self.blocks.append(word)
        self.at += 1
        return _READERS[word](self, opening)

    def _close(self, opening: int) -> None:
        """Takes the END of a block, the words before it that it has twice, and the semicolon."""
        word = self.blocks.pop()
        end = _BLOCKS[word][-1]
        while self._kind() in _BLOCKS[word] and self._kind() != end:
            kind = self._kind()
            self._stray(f"this {word} goes no further", f"{kind} stands at most once, before {end}"
                        if kind == "ELSE" else f"{kind} stands before ELSE")
            self.blocks.append(word)
            self._list()
            self.blocks.pop()
        if self._kind() == end:
            self.at += 1
            self.at += self._kind() == ";"  # many editors ask for none here
        else:
            self.findings.block_open(opening, end, self.at)

    def _expression(self, word: str, opening: int) -> object | None:
        """The expression up to ``word`` (THEN, DO, OF), which is taken too."""
        return self._head("single_expression", word, opening, "condition" if word != "OF" else "selector")

    def _head(self, symbol: str, word: str, opening: int, what: str) -> object | None:
        first = self.at
        self._skip(_STRUCTURE | set(_HEADS))
        stop, found = self.at, self._kind()
        value = self.units.attempt(symbol, first, stop, what)
        if isinstance(value, lr.Failure):
            if found != word and "$END" in value.expected and value.index > first:
                stop = self.at = value.index  # what follows is the first statement of the block
                self.findings.missing_word(opening, word, stop)
                return self.units.attempt(symbol, first, stop, what)
            syntax.explain(value, self.findings, first, stop, what)
            value = None
            self.at += found in (word, ";")
            return value
        if found == word:
            self.at += 1
        else:
            self.findings.missing_word(opening, word, self.at)
            self.at += found in _HEADS
        return value

    def _if(self, opening: int) -> st.If:
        arms: list[st.Arm] = []
        head = opening
        while True:
            condition = self._expression("THEN", head)
            span = self._span(head)
            arms.append(st.Arm(condition, self._list(), span))
            if self._kind() != "ELSIF":
                break
            head, self.at = self.at, self.at + 1
        otherwise = self._otherwise()
        self._close(opening)
        return st.If(tuple(arms), otherwise, self._span(opening))

    def _otherwise(self) -> st.Otherwise | None:
        if self._kind() != "ELSE":
            return None
        self.at += 1
        head = self._span(self.at - 1)
        return st.Otherwise(self._list(), head)

    def _case(self, opening: int) -> st.Case:
        selector = self._expression("OF", opening)
        head = self._span(opening)
        choices: list[st.Choice] = []
        if not self._label_end() and self._kind() not in ("ELSE", "END_CASE", ""):
            self.findings.no_label(self.at, opening)
            self._list()
        while stop := self._label_end():
            first, self.at = self.at, stop + 1
            labels = self.units.parse("case_labels", first, stop, "label")
            span = self._span(first)
            choices.append(st.Choice(tuple(labels or ()), self._list(), span))
        otherwise = self._otherwise()
        self._close(opening)
        return st.Case(selector, tuple(choices), otherwise, head, self._span(opening))

    def _label_end(self) -> int:
        """The index of the ``:`` behind labels that begin here; 0 when none do."""
        for index in range(self.at, self.end):
            kind = self.types[index]
            if kind == ":":
                return index if index > self.at else 0
            if kind in _NO_LABEL:
                return 0
        return 0

    def _for(self, opening: int) -> st.For:
        head = self._head("for_head", "DO", opening, "FOR")
        span = self._span(opening)
        body = self._list()
        self._close(opening)
        return st.For(head, body, span, self._span(opening))

    def _while(self, opening: int) -> st.While:
        condition = self._expression("DO", opening)
        span = self._span(opening)
        body = self._list()
        self._close(opening)
        return st.While(condition, body, span, self._span(opening))

    def _repeat(self, opening: int) -> st.Repeat:
        head = self._span(opening)
        body = self._list()
        first, condition = self.at, None
        if self._kind() == "UNTIL":
            self.at += 1
            start = self.at
            self._skip(_STRUCTURE)
            condition = self.units.parse("single_expression", start, self.at, "condition")
        elif self._kind() == "END_REPEAT":
            self.findings.missing_word(opening, "UNTIL", self.at)
        self._close(opening)
        last = max(opening, self.at - 1)
        return st.Repeat(body, condition, head, self.tokens.span(min(first, last), last), self._span(opening))


_READERS = {"IF": _Reader._if, "CASE": _Reader._case, "FOR": _Reader._for, "WHILE": _Reader._while,
            "REPEAT": _Reader._repeat}
