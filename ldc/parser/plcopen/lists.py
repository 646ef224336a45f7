"""Qualified names of global variables: `GVL.start`, where GVL is the name of a list in the file.

Lists of global variables have no names in IEC 61131-3. A variable keeps its own name, and what refers to it
loses the prefix; when something else in the file is called the same, the variable is `GVL_start`. Both are as
long as what was written, so that every place in the text stays where it is.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

from ldc.parser import ast
from ldc.parser.plcopen.document import Node
from ldc.patterns import Pattern
from ldc.records import replace
from ldc.source import SourceFile, Span

_NAMED = Pattern(r"<(?:[\w.-]+:)?globalVars\s[^>]*\bname\s*=")
_NAME = Pattern(r"[A-Za-z_]\w*\Z", re.ASCII)


class Lists:
    """The named lists of a project. ``renamed``: (list, variable), in capitals, to the name it gets;
    ``begin``: where in the text a list begins, to its name."""

    def __init__(self, root: Node) -> None:
        declared = Counter(node.get("name").strip().upper() for node in root.descendants("interface")
                           for section in node.children if section.tag != "externalVars"
                           for node in section.all("variable"))
        self.variables: dict[str, dict[str, tuple[str, str]]] = {}
        self.begin: dict[int, str] = {}
        for node in root.descendants("globalVars"):
            own = [child.get("name").strip() for child in node.all("variable")]
            declared.update(name.upper() for name in own)
            list_ = node.get("name").strip()
            if _NAME.match(list_):
                self.begin[node.start] = list_
                known = self.variables.setdefault(list_.upper(), {})
                known.update((name.upper(), (list_, name)) for name in own)
        self.variables = {key: own for key, own in self.variables.items() if key not in declared}
        self.renamed = {(key, name): "_".join(written) for key, own in self.variables.items()
                        for name, written in own.items() if declared[name] > 1}

    def named(self, block: ast.VarBlock, remarks: list[ast.Remark]) -> ast.VarBlock:
        """A list with the names that its variables get."""
        list_ = self.begin.get(block.span.start, "")
        variables = []
        for variable in block.variables:
            name = self.renamed.get((list_.upper(), variable.name.upper()), variable.name)
            if name != variable.name:
                remarks.append(ast.Remark("renamed", f"{list_}.{variable.name}", name, variable.span))
            variables.append(replace(variable, name=name))
        return replace(block, variables=tuple(variables))

    def remarks(self, source: SourceFile) -> Iterator[ast.Remark]:
        """What became of the names of the lists, for the report of an import."""
        begin = {list_: start for start, list_ in reversed(self.begin.items())}
        for list_, start in reversed(begin.items()):
            own = self.variables.get(list_.upper(), {})
            if any((list_.upper(), name) not in self.renamed for name in own):
                yield ast.Remark("mapped", f"{list_}.name", "the name alone", Span(source, start, start + 1))

    def unqualified(self, source: SourceFile) -> SourceFile:
        """The text with qualified names made plain; the source itself when there are none."""
        if not self.variables:
            return source
        names = "|".join(sorted(map(re.escape, self.variables), key=len, reverse=True))
        qualified = re.compile(rf"(?<![\w.#%])({names})\.([A-Za-z_]\w*)", re.ASCII | re.IGNORECASE)
        text = qualified.sub(self._plain, source.text)
        return source if text == source.text else SourceFile(source.path, text)

    def _plain(self, found: re.Match[str]) -> str:
        key = found[1].upper(), found[2].upper()
        if key[1] not in self.variables[key[0]]:
            return found[0]
        if key in self.renamed:
            return f"{found[1]}_{found[2]}"
        return " " * (len(found[1]) + 1) + found[2]


def are_named(source: SourceFile) -> bool:
    """Whether a list of global variables has a name; cheap."""
    return "globalVars" in source.text and _NAMED.search(source.text) is not None
