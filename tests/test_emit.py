"""Expressions to IL: few instructions, bounded nesting, same value (DESIGN section 3 rule 7, section 4)."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from ldc.expr import Apply, Const, IndexStep, Load, Place
from ldc.il.assignments import Operands
from ldc.il.emit import Emitter
from ldc.il.symbolic import Memory
from ldc.il.values import conjunction, disjunction, negation
from ldc.il.verify import execute
from ldc.types import BOOL, DINT, INT, TIME


def var(name: str) -> Load:
    return Load(Place(name, BOOL))


def listing(code) -> list[str]:
    lines = []
    for instr in code:
        text = instr.op + (f" {instr.name}" if instr.name else "")
        for operand in (instr.operand, *instr.args):
            if operand is not None:
                text += f" {operand if isinstance(operand, Place) else operand.value}"
        lines.append(text)
    return lines


def emitted(expr, target=Place("q", BOOL), **options):
    emitter = Emitter("r", **options)
    emitter.value(expr)
    emitter.store(target)
    return emitter.finish()


leaves = st.sampled_from("abcdef").map(var)
networks = st.recursive(
    st.one_of(leaves, leaves.map(negation)),
    lambda inner: st.one_of(st.lists(inner, min_size=2, max_size=4).map(conjunction),
                            st.lists(inner, min_size=2, max_size=4).map(disjunction)),
    max_leaves=20)


def flattened(expr):
    """Series in series is one series: the form that reduction hands over."""
    if not isinstance(expr, Apply) or expr.op == "NOT":
        return expr
    args = []
    for arg in map(flattened, expr.args):
        args.extend(arg.args if isinstance(arg, Apply) and arg.op == expr.op else (arg,))
    return Apply(expr.op, tuple(args), BOOL)


def minimum(expr) -> int:
    """Leaves plus, per operator, one for each composite operand but the first; plus the store."""
    def count(node) -> int:
        if not isinstance(node, Apply) or node.op == "NOT":
            return 1
        composite = sum(isinstance(a, Apply) and a.op != "NOT" for a in node.args)
        return sum(map(count, node.args)) + max(0, composite - 1)
    return count(expr) + 1


def negations(expr) -> int:
    if not isinstance(expr, Apply):
        return 0
    return 1 if expr.op == "NOT" else sum(map(negations, expr.args))


@given(networks.map(flattened))
def test_instruction_count_is_the_known_minimum(expr):
    count = len(emitted(expr))
    if negations(expr) == 0:
        assert count == minimum(expr)
    else:  # an operand in parentheses that begins with a closed contact may cost a load of its own
        assert minimum(expr) <= count <= minimum(expr) + negations(expr)


@given(networks, st.sampled_from([None, 0, 1, 2]))
def test_code_computes_the_expression_at_any_nesting_limit(expr, limit):
    operands = Operands()
    reference = Memory(operands)
    expected = operands.boolean(reference.value(expr))
    memory = Memory(operands)
    code = emitted(expr, max_paren_depth=limit)
    execute(code, memory)
    assert memory.read(Place("q", BOOL)) == expected
    depth = deepest = 0
    for instr in code:
        depth += instr.op.endswith("(") - (instr.op == ")")
        deepest = max(deepest, depth)
    assert depth == 0 and (limit is None or deepest <= limit)


def test_seal_in():
    expr = conjunction([disjunction([var("start"), var("motor")]), negation(var("stop"))])
    assert listing(emitted(expr, Place("motor", BOOL))) == ["LD start", "OR motor", "ANDN stop", "ST motor"]


def test_all_negated_operand_needs_no_load():
    expr = conjunction([var("a"), disjunction([var("b"), var("c")]),
                        disjunction([negation(var("d")), negation(var("e"))])])
    assert listing(emitted(expr)) == ["LD b", "OR c", "AND a", "ANDN( d", "AND e", ")", "ST q"]


def test_arithmetic_keeps_its_order_and_nests_the_right_side():
    i, j, k = (Load(Place(n, INT)) for n in "ijk")
    expr = Apply("GT", (Apply("SUB", (i, Apply("MUL", (j, k), INT)), INT), Const(5, INT)), BOOL)
    assert listing(emitted(expr)) == ["LD i", "SUB( j", "MUL k", ")", "GT 5", "ST q"]


def test_function_arguments_after_the_first_are_computed_before():
    i, j = (Load(Place(n, INT)) for n in "ij")
    expr = Apply("LIMIT", (Const(0, INT), Apply("ADD", (i, j), INT), Const(10, INT)), INT)
    assert listing(emitted(expr, Place("k", INT))) == [
        "LD i", "ADD j", "ST _ldc_int_1", "LD 0", "FN LIMIT _ldc_int_1 10", "ST k"]


def test_a_computed_index_goes_through_a_temporary():
    i = Load(Place("i", DINT))
    cell = Place("a", BOOL, (IndexStep((Apply("ADD", (i, Const(1, DINT)), DINT),), ((0, 9),)),))
    assert listing(emitted(Load(cell))) == ["LD i", "ADD 1", "ST _ldc_dint_1", "LD a[_ldc_dint_1]", "ST q"]


def test_time_times_number_is_the_typed_function():
    expr = Apply("MUL", (Load(Place("t", TIME)), Const(3, INT)), TIME)
    assert listing(emitted(expr, Place("u", TIME))) == ["LD t", "FN MULTIME 3", "ST u"]


def test_chained_comparison_compares_neighbours():
    i, j, k = (Load(Place(n, INT)) for n in "ijk")
    code = listing(emitted(Apply("GT", (i, j, k), BOOL)))
    assert code == ["LD i", "GT j", "AND( j", "GT k", ")", "ST q"]


def test_a_chain_of_ten_thousand_contacts_is_linear():
    code = emitted(conjunction([var(f"x{n}") for n in range(10_000)]))
    assert len(code) == 10_001
