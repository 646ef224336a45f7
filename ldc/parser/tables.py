"""LALR(1) tables of ladder.lark: made by lark, kept in the user's cache folder as JSON.

Making them takes lark about half a second, reading them a few milliseconds. The file is named after a
digest of the grammar, so it is never stale; where nothing can be written, the tables are made anew each
time.
"""

from __future__ import annotations

import hashlib
import os
from contextlib import suppress
from functools import cache
from pathlib import Path

import msgspec

from ldc import unfinished
from ldc.records import entity

_FORMAT = "2"
STARTS = ("rung", "single_expression", "single_type", "single_initial", "statement", "for_head",
          "case_labels", "var_line", "config_line", "type_line", "pou_head", "configuration_head",
          "resource_head", "task_line", "program_line", "step_head", "action_head", "association",
          "transition")
END = "$END"


@entity
class Tables:
    """``actions[state][symbol]``: a state to go to (>= 0), or ``-1 - rule`` to reduce.

    ``rules[n]`` is (children, symbol made, name of the action; empty: its one child is passed on).
    Terminals are named as in the grammar, quoted ones by their text; ``terminals`` are all of them.
    """

    actions: tuple[dict[str, int], ...]
    rules: tuple[tuple[int, str, str], ...]
    starts: dict[str, int]
    ends: dict[str, int]
    terminals: frozenset[str]


@cache
def tables() -> Tables:
    """The tables, from the cache when they are there."""
    grammar = Path(__file__).with_name("ladder.lark").read_text(encoding="utf-8")
    digest = hashlib.sha256("\0".join((_FORMAT, *STARTS, grammar)).encode()).hexdigest()[:24]
    path = cache_folder() / f"grammar-{digest}.json"
    try:
        return _decode(msgspec.json.decode(path.read_bytes()))
    except (OSError, ValueError, LookupError, TypeError):
        made = _make(grammar)
    store(path, msgspec.json.encode(made).decode())
    return _decode(made)


def cache_folder() -> Path:
    """Where this user's caches are kept: ``$XDG_CACHE_HOME/ldc`` or ``~/.cache/ldc``."""
    base = os.environ.get("XDG_CACHE_HOME", "")
    return Path(base if os.path.isabs(base) else os.path.expanduser("~/.cache")) / "ldc"


def store(path: Path, text: str) -> None:
    """Writes a file of a cache whole or not at all; a cache that cannot be written is no error."""
    with suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        with unfinished.file_in(path.parent, 0o600) as file:
            file.write(text.encode("utf-8"))
            unfinished.named(file, path)


def _decode(data: dict) -> Tables:
    rules = tuple((size, symbol, action) for size, symbol, action in data["rules"])
    rows = tuple(data["actions"])
    _shorten(rows, rules)
    return Tables(rows, rules, data["starts"], data["ends"], frozenset(data["terminals"]))


def _shorten(rows: tuple[dict[str, int], ...], rules: tuple[tuple[int, str, str], ...]) -> None:
    """Where all that can follow a symbol is passing it on as another, go where the other leads.

    An error is then found after a few more reductions, but still before the wrong token is shifted.
    """
    only: dict[int, str] = {}
    for state, row in enumerate(rows):
        actions = set(row.values())
        if len(actions) == 1 and (action := actions.pop()) < 0 and not rules[-1 - action][2]:
            only[state] = rules[-1 - action][1]
    for row in rows:
        for symbol, target in row.items():
            while target in only and only[target] in row:
                target = row[only[target]]
            row[symbol] = target


def _make(grammar: str) -> dict:
    """Let lark analyse the grammar, and bring its tables into a plain form."""
    from lark import Lark
    from lark.lexer import Lexer, PatternStr
    from lark.parsers.lalr_analysis import Shift

    class NoLexer(Lexer):
        """lark must not build scanners for terminals that lexer.py makes."""

        def __init__(self, conf) -> None:
            pass

        def lex(self, lexer_state, parser_state):
            return iter(())

    parser = Lark(grammar, parser="lalr", lexer=NoLexer, start=list(STARTS), keep_all_tokens=True)
    shown = {t.name: t.pattern.value for t in parser.terminals if isinstance(t.pattern, PatternStr)}
    table = parser.parser.parser._parse_table
    numbers, rules, actions = {}, [], []
    for state in range(len(table.states)):
        row = {}
        for symbol, (action, argument) in table.states[state].items():
            if action is not Shift:
                if argument not in numbers:
                    numbers[argument] = len(rules)
                    passes = argument.options.expand1 and len(argument.expansion) == 1 and not argument.alias
                    name = "" if passes else str(argument.alias or argument.origin.name)
                    rules.append((len(argument.expansion), str(argument.origin.name), name))
                argument = -1 - numbers[argument]
            row[shown.get(symbol, str(symbol))] = argument
        actions.append(row)
    names = {t.name for t in parser.terminals} | {END}
    used = {symbol for row in table.states.values() for symbol in row} & (names | set(_declared(grammar)))
    return {"actions": actions, "rules": rules, "starts": dict(table.start_states),
            "ends": dict(table.end_states), "terminals": sorted(shown.get(n, n) for n in used)}


def _declared(grammar: str) -> list[str]:
    return next(line for line in grammar.splitlines() if line.startswith("%declare")).split()[1:]
