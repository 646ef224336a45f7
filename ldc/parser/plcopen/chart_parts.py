"""The parts of a chart that are no wires: steps with their actions, the bodies of actions and transitions."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence, Set
from itertools import accumulate

from ldc.diagnostics import Diagnostics
from ldc.free_names import free_name
from ldc.parser import ast, sfc
from ldc.parser import statements as st
from ldc.parser.lexer import lex
from ldc.parser.plcopen import bodies, findings, texts
from ldc.parser.plcopen.document import Node
from ldc.parser.plcopen.structured import statements
from ldc.parser.reader import parse_expression
from ldc.records import replace
from ldc.source import Span

# Attributes of steps in one vendor's exports: the POU's action that is executed while the step is active,
# when it begins, when it ends; and whether the element is left out.
_STEP_ACTIONS = {"700a583f-b4d4-43e4-8c14-629c7cd3bec8": "N", "a6b08bd8-b696-47e3-9cbf-7408b61c9ff8": "P1",
                 "a2621e18-7de3-4ea6-ae6d-89e9e0b7befd": "P0"}
_EXCLUDED = "01580b27-6378-448b-8ecb-0e4b795b58d6"


class Parts:
    """``drawn(node, name, holder)`` reads a body in LD or FBD, ``nested`` a chart likewise. ``inline``:
    actions without a name of their own, which are known when the steps were read."""

    def __init__(self, pou: Node, body: Node, steps: Mapping[str, Node], where: str,
                 drawn: Callable[[Node, str, Node], ast.LadderBody],
                 nested: Callable[[Node, str, Node], st.StatementBody], diagnostics: Diagnostics) -> None:
        self.pou, self.body, self.where, self.diagnostics = pou, body, where, diagnostics
        self.drawn, self.nested = drawn, nested
        self._steps = steps
        self.inline: list[sfc.Action] = []
        declared = (node for node in pou.descendants("variable"))
        self._taken = {node.get("name").strip().upper() for node in (*declared, *steps.values(), pou)}
        self._conditions = {node.get("name").strip().upper(): node
                            for holder in pou.all("transitions") for node in holder.all("transition")}
        self._used = self._taken | self._conditions.keys()
        self._names: dict[str, str] = {}
        self._quiet: set[str] = set()
        self._actions = {node.get("name").strip().upper(): node
                         for holder in pou.all("actions") for node in holder.all("action")}
        for key, node in self._actions.items():
            self._names[key] = self.fresh(texts.label(node.get("name"), "action"))

    def _unsupported(self, span: Span, message: str, label: str, help: str) -> None:
        findings.unsupported(self.diagnostics, span, f"{self.where}: {message}", label, help)

    def _malformed(self, span: Span, message: str, help: str) -> None:
        findings.malformed(self.diagnostics, span, f"{self.where}: {message}", help)

    def fresh(self, wanted: str) -> str:
        """A name that nothing in the POU has."""
        name = free_name(wanted, self._used)
        self._take(name)
        return name

    def _take(self, name: str) -> None:
        self._taken.add(name.upper())
        self._used.add(name.upper())

    # ---- bodies

    def _body(self, holder: Node, name: str, action: bool = True) -> sfc.Body | None:
        """The first body that says something; empty when none does. Not of an ``action``: of a condition."""
        for node in bodies.languages(holder):
            if node.tag == "ST":
                return statements(node.body, self.diagnostics)
            if node.tag == "IL":
                return ast.TextBody("IL", node.body)
            if node.tag in bodies.GRAPHICAL:
                return self.drawn(node, name, holder)
            if node.tag == "SFC" and action:
                return self.nested(node, name, holder)
            if node.tag == "SFC":
                self._unsupported(node.span, f"the condition {name} is a chart", "an SFC",
                                  "write it as an expression")
                return None
        return ast.LadderBody((), Span(holder.span.source, holder.stop, holder.stop))

    def actions(self, elsewhere: Set[str]) -> tuple[sfc.Action, ...]:
        """The actions of the POU, in their order, without those ``elsewhere``: which only charts inside of
        actions name, in capitals."""
        for node in self._steps.values():
            for qualifier, name, _ in self._vendor(node):
                if qualifier == "N":
                    self._quiet.add(name.upper())
        named = {ref.get("name").strip().upper() for block in self.body.all("actionBlock")
                 for ref in block.descendants("reference")}
        for key in self._quiet & named:
            self._quiet.discard(key)
            span = self._actions[key].span if key in self._actions else self.body.span
            self._unsupported(span, f"`{key}` is the action of a step by itself and in an action block",
                              "one of two", "only the second is executed once more at its end: make it two")
        made = []
        for key, node in self._actions.items():
            if key in elsewhere:
                continue
            holder, name = node.find("body"), self._names[key]
            body = self._body(holder, name) if holder is not None else None
            if body is not None:
                body = self._without_last(body, name, node.span) if key in self._quiet else body
                made.append(sfc.Action(name, body, node.whole, node.attribute("name")))
        return tuple(made)

    def _without_last(self, body: sfc.Body, name: str, span: Span) -> sfc.Body:
        """A body that does nothing in its final execution: ``RETURN`` unless ``action.Q``."""
        on = ast.Member(ast.Name(name, span), "Q", span)
        if isinstance(body, st.StatementBody):
            arm = st.Arm(ast.Unary("NOT", on, span), (st.Leave("RETURN", span),), span)
            leaves = st.If((arm,), None, span)
            return replace(body, statements=(leaves, *body.statements))
        if isinstance(body, ast.LadderBody):
            path = ast.Path((ast.Contact("/", on, span), ast.Jump("RETURN", span)), span)
            return replace(body, rungs=(ast.Rung(None, None, (path,), span), *body.rungs))
        self._unsupported(span, f"the action `{name}` of a step is Instruction List", "in IL",
                          "write it in Structured Text or as a ladder")
        return body

    # ---- steps

    def steps(self, always: Sequence[str] = ()) -> tuple[sfc.Step, ...]:
        """The steps with their actions. ``always``: actions that are executed from the initial steps on."""
        found: dict[str, list[sfc.Association]] = {id_: [] for id_ in self._steps}
        for id_, node in self._steps.items():
            if node.flag("initialStep"):
                found[id_] += [sfc.Association(ast.Name(name, node.span), "S", None, (), node.span)
                               for name in always]
        for id_, node in self._steps.items():
            for qualifier, name, span in self._vendor(node):
                action = ast.Name(self._names.get(name.upper(), name), span)
                found[id_].append(sfc.Association(action, qualifier, None, (), span))
        for block in self.body.all("actionBlock"):
            wires = [wire for point in block.all("connectionPointIn") for wire in point.all("connection")]
            owners = [id_ for wire in wires if (id_ := wire.get("refLocalId").strip()) in found]
            if not owners:
                self._malformed(block.span, "an action block is at no step", "connect it to its step")
            for node in block.all("action"):
                association = self._association(node, self._steps[owners[0]]) if owners else None
                for id_ in owners if association is not None else ():
                    found[id_].append(association)
        made = []
        for id_, node in self._steps.items():
            name = texts.name(node, self.diagnostics)
            if name is not None:
                made.append(sfc.Step(name, node.flag("initialStep"), tuple(found[id_]), node.whole,
                                     node.attribute("name")))
        return tuple(made)

    def _vendor(self, step: Node) -> Iterator[tuple[str, str, Span]]:
        """What one vendor's exports say of a step beside the format: qualifier, action, place."""
        for data in step.all("addData"):
            for node in data.descendants("attribute"):
                text = node.content.text
                if node.get("guid") in _STEP_ACTIONS and text:
                    yield _STEP_ACTIONS[node.get("guid")], text, node.content
                elif node.get("guid") == _EXCLUDED and text.upper() == "TRUE":
                    self._unsupported(step.span, "a step is excluded", "left out",
                                      "delete it in the editor that the file comes from")

    def _association(self, node: Node, step: Node) -> sfc.Association | None:
        qualifier = node.get("qualifier").strip().upper() or "N"
        if qualifier not in sfc.QUALIFIERS:
            self._unsupported(node.span, f"the qualifier {qualifier[:20]} of an action",
                              "not of the standard", f"use one of {', '.join(sfc.QUALIFIERS)}")
            return None
        time = None
        if qualifier in sfc.TIMED:
            time = self._time(node)
            if time is None:
                self._malformed(node.span, f"an action with {qualifier} has no duration",
                                "write a time, for example T#2s, beside the qualifier")
                return None
        action = self._action(node, step)
        indicator = node.attribute("indicator")
        named = bool(node.get("indicator").strip())
        indicators = tuple(filter(None, (texts.expression(indicator, self.diagnostics),))) if named else ()
        return None if action is None else sfc.Association(action, qualifier, time, indicators, node.span)

    def _time(self, node: Node) -> ast.Expr | None:
        found = texts.duration(node, "duration", self.diagnostics)
        if found is None and node.get("duration").strip():
            return ast.Literal(0, "TIME", "T#0s", node.attribute("duration"))
        return found

    def _action(self, node: Node, step: Node) -> ast.Expr | None:
        reference, inline = node.find("reference"), node.find("inline")
        if reference is not None:
            key = reference.get("name").strip().upper()
            if key in self._names:
                return ast.Name(self._names[key], reference.attribute("name"))
            return texts.expression(reference.attribute("name"), self.diagnostics)
        if inline is None:
            self._malformed(node.span, "an action block names no action", "name an action or a variable")
            return None
        name = self.fresh(f"{texts.label(step.get('name'), 'step')}_action")
        body = self._body(inline, name)
        if body is None:
            return None
        self.inline.append(sfc.Action(name, body, inline.whole, inline.span))
        return ast.Name(name, inline.span)

    # ---- conditions that are no drawings

    def condition(self, node: Node, condition: Node | None, number: int
                  ) -> tuple[ast.Expr | sfc.Body | None, str | None]:
        """A condition given by name or as a body, and the name of the transition when that is a body."""
        reference = condition.find("reference") if condition is not None else None
        inline = condition.find("inline") if condition is not None else None
        if reference is None and inline is None:
            self._malformed(node.span, "a transition has no condition", "give it one, or TRUE")
            return None, None
        if inline is not None:
            unnamed = free_name(f"transition_{number}", self._used)
            name, holder = texts.label(inline.get("name"), unnamed), inline
        else:
            name = reference.get("name").strip()
            known = self._conditions.get(name.upper())
            holder = known.find("body") if known is not None else None
            if holder is None:
                found = texts.expression(reference.attribute("name"), self.diagnostics)
                return _maybe_not(found, condition), None
        text = _one_expression(holder, self._taken)
        if text is not None:
            found = parse_expression(text.source, text.start, text.end, self.diagnostics)
            return _maybe_not(found, condition), None
        body = self._body(holder, name, action=False)
        return (None, None) if body is None else self._named(body, name, condition)

    def _named(self, body: sfc.Body, name: str, condition: Node) -> tuple[sfc.Body | None, str]:
        """A body that sets the variable with the name of the transition."""
        if condition.flag("negated"):
            self._unsupported(condition.span, f"the condition {name} is negated", "negated",
                              "negate it inside of its body")
        if name.upper() in self._taken:
            self._unsupported(condition.span, f"the condition {name} with a body is used twice, or has the "
                              "name of a variable", "used here",
                              "write it as one expression, or copy it under another name")
            return None, name
        self._take(name)
        return body, name


def _one_expression(holder: Node, instances: Container[str]) -> Span | None:
    """A body in Structured Text that is one expression, without the ``:=`` and ``;`` around it. A call of one
    of the ``instances`` (in capitals) is a statement."""
    node = holder.find("ST")
    if node is None:
        return None
    tokens = lex(node.body.source, node.body.start, node.body.end, statements=True)
    types = tokens.types
    first = int(types[:1] == [":="])
    end = len(types) - (types[-1:] == [";"])
    if first >= end or types[first] == "RETURN" or ";" in types[first:end]:
        return None
    depths = accumulate((kind == "(") - (kind == ")") for kind in types[first:end])
    if any(kind == ":=" and not depth for kind, depth in zip(types[first:end], depths)):
        return None
    called = types[first : first + 2] == ["NAME", "("] and types[end - 1] == ")"
    if called and not first and tokens.text(first).upper() in instances:
        return None
    return tokens.span(first, end - 1)


def _maybe_not(expr: ast.Expr | None, condition: Node) -> ast.Expr | None:
    return texts.negated(expr) if expr is not None and condition.flag("negated") else expr
