"""Contract: what rungs mean (DESIGN section 3), from the user's side, on every way to execute a program."""

from __future__ import annotations

import pytest
from contract import codes, program, trace

DOUBLE = """FUNCTION Square : INT
VAR_INPUT x : INT; END_VAR
VAR_OUTPUT n : INT; big : BOOL; END_VAR
RUNG <MUL(IN1 := x, IN2 := x, OUT => Square)>
RUNG <ADD(IN1 := n, IN2 := 1, OUT => n)>
RUNG [x > 3] (big)
END_FUNCTION
"""
ADDER = """FUNCTION_BLOCK Adder
VAR_INPUT e : BOOL; END_VAR
VAR_IN_OUT io : INT; END_VAR
VAR_OUTPUT o : BOOL; END_VAR
RUNG [e] <ADD(IN1 := io, IN2 := 1, OUT => io)> (o)
END_FUNCTION_BLOCK
"""
LEAVER = """FUNCTION_BLOCK Leaver
VAR_INPUT e : BOOL; END_VAR
VAR_OUTPUT o : BOOL; n : INT; END_VAR
RUNG [e] { >>RETURN | (o) }
RUNG <ADD(IN1 := n, IN2 := 1, OUT => n)>
END_FUNCTION_BLOCK
"""

# what is promised: (rungs, variables, watched, inputs, rows); a fifth text stands before the program
RULES = {
    # rules 1 and 2: power, and the order of evaluation
    "a contact reads what a coil before it wrote, never again": (
        "RUNG [a] (b) [b] (c)\nRUNG [b] (d) (/b) [b] (e)", "a, b, c, d, e : BOOL;",
        "b c d e", "scan,a 0,1 1,0", ["0 1 1 0", "1 0 0 0"]),
    "paths in the order of the text": (
        "RUNG [a] (b); [b] (c); [c] (d)", "a, b, c, d : BOOL;", "b c d", "scan,a 0,1 1,0", ["1 1 1",
        "0 0 0"]),
    "what stands behind a junction waits until it is fed": (
        "RUNG @x (c); [b] (d); [a] (b) @x", "a, b, c, d : BOOL;",
        "b c d", "scan,a 0,1 1,0", ["1 1 0", "0 0 1"]),
    "a coil in a parallel branch does not change the power of the other": (
        "RUNG [a] { (/a) | [a] (b) | (c) }", "a, b, c : BOOL;", "a b c", "scan,a 0,1 1,0", ["0 0 1",
        "1 0 0"]),
    # rule 3: dead branches, expressions, jumps
    "a timer runs down without power": (
        "RUNG [a] [b] <t: TOF(PT := T#20ms)> (q)", "a, b, q : BOOL; t : TOF;",
        "q", "scan,a,b 0,1,1 1,0,1 4,0,0", ["1", "1", "1", "0", "0"]),
    "edges follow their operand in a dead branch": (
        "RUNG [en] { [P a] (q) | [N a] (z) }", "a, en, q, z : BOOL;",
        "q z", "scan,en,a 0,0,1 1,1,1 2,1,0 3,1,1", ["0 0", "0 0", "0 1", "1 0"]),
    "a coil without power writes FALSE": (
        "RUNG [a] { (q) | [b] (z) }", "a, b : BOOL; q, z : BOOL := TRUE;", "q z", "scan,b 0,1", ["0 0"]),
    "an expression without power is not evaluated, in branches too": (
        "RUNG [e] { [b <> 0] [a / b > 2] | { [/e] [a / b > 0] | [f] } } (q)",
        "a : INT := 9; b : INT; q, e, f : BOOL;",
        "q", "scan,b,e,f 0,0,1,0 1,3,1,0 2,0,0,1 3,0,1,1", ["0", "1", "0", "1"]),
    "an expression behind a negated contact or coil": (
        "RUNG [/z] [NOT (a / b > 1)] (/q)", "a : INT := 9; b : INT; q, z : BOOL;",
        "q", "scan,b,z 0,0,1 1,9,0 2,3,0", ["1", "0", "1"]),
    "an expression in the network of a pin": (
        "RUNG [e] <c: CTU(R := { [b <> 0] [a / b > 2] }, PV := 2)> (q)",
        "a : INT := 9; b : INT; q, e : BOOL; c : CTU;",
        "c.CV q", "scan,b,e 0,0,1 1,0,0 2,0,1 3,3,0", ["1 0", "1 0", "2 1", "0 0"]),
    "pins of a function without EN are not evaluated": (
        "RUNG [e] <SEL(G := { [b <> 0] [a / b > 2] }, IN0 := 5, IN1 := a / b, OUT => z)> (q)",
        "a : INT := 9; b, z : INT; q, e : BOOL;", "z q", "scan,b,e 0,0,0 1,3,1", ["0 0", "3 1"]),
    "a jump is taken after the rest of its rung": (
        "RUNG [a] { >>past | (q) }; [a] (w)\nRUNG (x)\nRUNG past (y)", "a, q, w, x, y : BOOL;",
        "q w x y", "scan,a 0,1 1,0", ["1 1 0 1", "0 0 1 1"]),
    "the power of a jump is that of its place": (
        "RUNG [a] @m >>past; @m (R a)\nRUNG (x)\nRUNG past (y)", "a, x, y : BOOL;",
        "a x y", "scan,a 0,1 1,0", ["0 0 1", "0 1 1"]),
    "of two jumps the first in the drawing": (
        "RUNG { [a] >>far | [b] >>near | (q) }\nRUNG (x)\nRUNG near (y)\nRUNG far (z)",
        "a, b, q, x, y, z : BOOL;",
        "x y z", "scan,a,b 0,1,1", ["0 0 1"]),
    "a backward jump is a loop": (
        "RUNG <MOVE(IN := 0, OUT => i)>\nRUNG top <ADD(IN1 := i, IN2 := 1, OUT => i)>\nRUNG [i < 10] >>TOP",
        "i : INT;",
        "i", "scan,i 0,5", ["10"]),
    "an endless loop is a fault and the outputs are safe": (
        "RUNG top (q)\nRUNG [a] >>top", "a : BOOL; q AT %QX0.0 : BOOL;",
        "q", "scan,a 0,0 1,1 2,0", ["1", "fault LD0803", "0", "0"]),
    "RETURN leaves a program": (
        "RUNG [a] >>RETURN\nRUNG (q)", "a, q : BOOL;", "q", "scan,a 0,1 1,0", ["0", "1"]),
    "RETURN leaves a function block": (
        "RUNG [a] <i: Leaver()> (q)", "a, q : BOOL; i : Leaver;",
        "q i.n", "scan,a 0,0 1,1 2,0", ["0 1", "1 1", "0 2"], LEAVER),
    # rule 4: edges and time
    "edge contacts and coils, the first scan": (
        "RUNG [P a] (p1)\nRUNG [N a] (n1)\nRUNG [a] (P p2)\nRUNG [a] (N n2)\nRUNG [/a] (N n3)",
        "a, p1, n1, p2, n2, n3 : BOOL;", "p1 n1 p2 n2 n3", "scan,a 0,1 1,1 2,0 3,0 4,1",
        ["1 0 1 0 0", "0 0 0 0 0", "0 1 0 1 0", "0 0 0 0 0", "1 0 1 0 1"]),
    "two edge contacts of one operand have a memory each": (
        "RUNG [P a] (q) [P a] (z)", "a, q, z : BOOL;", "q z", "scan,a 0,1 1,1", ["1 1", "0 0"]),
    "edges of bits and elements": (
        "RUNG [P x.3] (q)\nRUNG [N many[i]] (z)",
        "x : WORD; q, z : BOOL; many : ARRAY [0..1] OF BOOL; i : INT;",
        "q z", "scan,x,many[0],i 0,8,1,0 1,8,1,1 2,0,1,1 3,8,1,1", ["1 0", "0 1", "0 0", "1 0"]),
    "time stands still within an execution": (
        "RUNG top [a] <t: TON(PT := T#10ms)> (q)\nRUNG <ADD(IN1 := i, IN2 := 1, OUT => i)>\n"
        "RUNG [i < 100 * n] >>top",
        "a, q : BOOL; t : TON; i, n : INT;", "q t.ET", "scan,a,n 0,1,1 1,1,2", ["0 0", "1 10"]),
    # rule 5: loops through blocks
    "feedback counts with its power of the previous execution": (
        "RUNG [a] @x <t: TON(PT := T#0s)> @y (q); @y [b] @x", "a, b, q : BOOL; t : TON;",
        "q", "scan,a,b 0,1,1 1,0,1 2,0,0 3,0,1 4,0,0", ["1", "1", "1", "0", "0"]),
    "two loops side by side": (
        "RUNG [a] @x <t: TON(PT := T#0s)> @y (q); @y [b] @x; [c] @u <s1: TON(PT := T#0s)> @v (w); @v [d] @u",
        "a, b, c, d, q, w : BOOL; t, s1 : TON;", "q w",
        "scan,a,b,c,d 0,1,1,0,1 1,0,1,1,1 2,0,0,0,1 3,0,1,0,0",
        ["1 0", "1 1", "1 1", "0 1"]),
    "a value in a loop is 0 at first": (
        "RUNG [a] <c: CTU(PV := @v, CV => @v)> (q)", "a, q : BOOL; c : CTU;",
        "c.PV c.CV", "scan,a 0,1 1,0 2,1 3,1", ["0 1", "1 1", "1 2", "2 2"]),
    "an output that a pin of the same block reads is that of the last call": (
        "RUNG [a] <c: CTU(R := c.Q, PV := 2)> (q)", "a, q : BOOL; c : CTU;",
        "q c.CV", "scan,a 0,1 1,0 2,1 3,0 4,1", ["0 1", "0 1", "1 2", "0 0", "0 1"]),
    # EN and ENO
    "without EN nets are 0 and variables keep their values": (
        "RUNG [a] <ADD(IN1 := x, IN2 := 1, OUT => @v)> <ADD(IN1 := x, IN2 := 1, OUT => x)> (q);"
        " <MOVE(IN := @v, OUT => y)>",
        "a, q : BOOL; x : INT := 4; y : INT;", "q x y", "scan,a 0,1 1,0 2,1", ["1 5 5", "0 5 0", "1 6 6"]),
    "without EN a net of BOOL is FALSE": (
        "RUNG [a] <GT(IN1 := x, IN2 := y, OUT => @m)>; @m (q)", "a, q : BOOL; x : INT := 2; y : INT;",
        "q", "scan,a 0,1 1,0", ["1", "0"]),
    "ENO is written without EN, too": (
        "RUNG [a] <ADD(IN1 := 1, IN2 := 2, OUT => n, ENO => e)> (q)", "a, e, q : BOOL; n : INT;",
        "n e q", "scan,a 0,0 1,1 2,0", ["0 0 0", "3 1 1", "3 0 0"]),
    "DIV and MOD by zero give ENO = FALSE where it is drawn": (
        "RUNG [a] <DIV(IN1 := 7, IN2 := x, OUT => y)> (q)\n"
        "RUNG <MOD(IN1 := 7, IN2 := x, ENO => e, OUT => m)>",
        "a, q, e : BOOL; x, y, m : INT;", "q y e m", "scan,a,x 0,1,0 1,1,2 2,1,0 3,0,3",
        ["0 0 0 0", "1 3 1 1", "0 3 0 1", "0 3 1 1"]),
    "DIV of REAL and TIME by zero, too": (
        "RUNG <DIV(IN1 := 7.0, IN2 := x, OUT => y)> (q)\nRUNG <DIV(IN1 := T#1s, IN2 := n, OUT => t)> (w)",
        "x, y : REAL; n : INT; t : TIME; q, w : BOOL;", "y q t w", "scan,x,n 0,2,2 1,0,0 2,-0.0,4",
        ["3.5 1 500 1", "3.5 0 500 0", "3.5 0 250 1"]),
    "a division inside an argument stays a fault": (
        "RUNG <DIV(IN1 := 7 / x, IN2 := 2, OUT => y)> (q)", "x, y : INT; q : BOOL;",
        "y", "scan,x 0,2 1,0", ["1", "fault LD0801", "1"]),
    "a division inside a function stays a fault": (
        "RUNG [a] <Tenth(x := v, OUT => k)> (q)", "a, q : BOOL; v, k : INT;",
        "k q", "scan,a,v 0,0,0 1,1,2 2,1,0", ["0 0", "5 1", "fault LD0801", "5 1"],
        "FUNCTION Tenth : INT\nVAR_INPUT x : INT; END_VAR\n"
        "RUNG [10 / x >= 0] <MOVE(IN := 10 / x, OUT => Tenth)>\n"
        "END_FUNCTION\n"),
    # pins
    "power by other pins": (
        "RUNG [a] <c: CTUD(CU := b, PV := 2) in=CD out=QD> (q)", "a, b, q : BOOL; c : CTUD;",
        "q c.CV", "scan,a,b 0,0,0 1,1,0 2,0,1 3,0,0 4,0,1", ["1 0", "1 -1", "1 0", "1 0", "0 1"]),
    "a pin that is not wired keeps its value": (
        "RUNG [a] (t.IN)\nRUNG <t: TON(PT := T#10ms) in=_> (q)", "a, q : BOOL; t : TON;",
        "q", "scan,a 0,1 3,0", ["0", "1", "1", "0"]),
    "a function that is not wired runs": (
        "RUNG <ADD(IN1 := 1, IN2 := 2, OUT => y) in=_> (q)", "y : INT; q : BOOL;", "q y",
        "scan,y 0,9", ["1 3"]),
    "a function with power at a value pin": (
        "RUNG [a] <AND(EN := c, IN2 := b, ENO => z) in=IN1 out=OUT> (q)", "a, b, c, q, z : BOOL;",
        "q z", "scan,a,b,c 0,1,1,1 1,1,1,0 2,0,1,1", ["1 1", "0 0", "0 1"]),
    "networks at pins, and a junction within": (
        "RUNG [e] <c: CTU(R := { [z] | [y] @m }, PV := 2)> (q); @m (w)", "e, z, y, q, w : BOOL; c : CTU;",
        "q w c.CV", "scan,e,z,y 0,1,0,0 1,0,0,0 2,1,0,0 3,1,0,1", ["0 0 1", "0 0 1", "1 0 2", "0 1 0"]),
    "an output pin feeds a junction": (
        "RUNG [e] <c: CTUD(CD := { [z] }, PV := 1, QD => @m)> (q); @m [y] (w)",
        "e, z, y, q, w : BOOL; c : CTUD;",
        "q w c.CV", "scan,e,z,y 0,1,0,1 1,0,1,1", ["1 0 1", "0 1 0"]),
    "a value junction feeds many pins, whatever is drawn first": (
        "RUNG <t: TON(PT := @d) in=_>; <MUL(IN1 := @n, IN2 := @n, OUT => y)>;"
        " <ADD(IN1 := x, IN2 := 1, OUT => @n)>;"
        " <MOVE(IN := T#5ms, OUT => @d)>",
        "x : INT := 3; y : INT; t : TON;", "y t.PT", "scan,x 0,4", ["25 5"]),
    "outputs of a function": (
        "RUNG [a] <Square(x := v, n => k, big => @b, OUT => z)> (e); @b (w)",
        "a, e, w : BOOL; v, k, z : INT;",
        "z k w e", "scan,a,v 0,1,3 1,1,5 2,0,2", ["9 1 0 1", "25 1 1 1", "25 1 0 0"], DOUBLE),
    "power leaves a function by an output": (
        "RUNG [a] <Square(x := v, OUT => k) out=big> (e)", "a, e : BOOL; v, k : INT;",
        "k e", "scan,a,v 0,1,3 1,1,5 2,0,9", ["9 0", "25 1", "25 0"], DOUBLE),
    "a variable passes in and out of a block": (
        "RUNG [a] <f: Adder(io := v)>\nRUNG [a] <f: Adder(io := many[i])>",
        "a : BOOL; v : INT; f : Adder; many : ARRAY [0..2] OF INT; i : INT := 1;",
        "v many[0] many[1]", "scan,a,i 0,1,1 1,0,1 2,1,0", ["1 0 1", "1 0 1", "2 1 1"], ADDER),
    "instances in an array": (
        "RUNG [a] <t[1]: TON(PT := T#10ms)> (q)\nRUNG [a] <t[i]: TON(PT := T#10ms, ET => e)> (z)",
        "a, q, z : BOOL; t : ARRAY [0..3] OF TON; i : INT := 2; e : TIME;",
        "q z t[2].ET", "scan,a,i 0,1,2 1,1,2 2,1,5", ["0 0 0", "1 1 10", "fault LD0802", "1 1 10"]),
    # words of the language
    "names are the same in any case": (
        "Rung Go [A] (B)\nrung [b] >>GO2\nRUNG (C)\nRUNG go2 [a] @X <T1: ton(pt := t#0S)> @x2; @X2 (Q)",
        "a, b, c, q : BOOL; t1 : TON;", "B c q T1.q", "scan,A 0,1 1,0", ["1 0 1 1", "0 1 0 0"]),
    "P and N are names, too": (
        "RUNG [P] [/N] [P N] (q)\nRUNG [P] (w) (P x)", "P, N, q, w, x : BOOL;",
        "q w x", "scan,p,n 0,1,1 1,1,0 2,0,0", ["0 1 1", "0 1 0", "0 0 0"]),
    "a net tells its type wherever in the text it gets a value": (
        "RUNG <SUB(IN1 := @n, IN2 := 1, OUT => @m)>; <MUL(IN1 := @k, IN2 := 2, OUT => @n)>; "
        "<MOVE(IN := @m, OUT => d)>; <MOVE(IN := e, OUT => @k)>", "d, e : DINT;",
        "d", "scan,e 0,50000 1,-7", ["99999", "-15"]),
    "pins may be named R and S": (
        "RUNG [a] <k: Hold(R := b, S := { [c] })> (q)", "a, b, c, q : BOOL; k : Hold;",
        "q", "scan,a,b,c 0,1,0,1 1,1,1,1 2,1,0,0", ["1", "0", "0"],
        "FUNCTION_BLOCK Hold\nVAR_INPUT IN, R, S : BOOL; END_VAR\nVAR_OUTPUT Q : BOOL; END_VAR\n"
        "RUNG [IN] [S] [/R] (Q)\nEND_FUNCTION_BLOCK\n"),
}


@pytest.mark.parametrize("promise", RULES)
def test_rule(promise: str) -> None:
    rungs, variables, watch, inputs, rows, *before = RULES[promise]
    assert trace(program(rungs, variables, "".join(before)), watch, inputs) == rows


@pytest.mark.parametrize(("rungs", "code"), [
    ("RUNG [a] @x [b] @y (q); @y [c] @x", "LD0303"),
    ("RUNG <MOVE(IN := 1, OUT => @n)>; <MOVE(IN := 3, OUT => @n)>; <MOVE(IN := @n, OUT => i)>", "LD0312"),
    ("RUNG { } (q)", "LD0112"),
    ("RUNG { [a] | } (q)", "LD0112"),
    ("RUNG x [a] (q)\nRUNG X [b] (w)", "LD0314"),
    ("RUNG x [a] >>y", "LD0515"),
])
def test_what_cannot_be_drawn(rungs: str, code: str) -> None:
    assert codes(program(rungs, "a, b, c, q, w : BOOL; i : INT;")) == [code]
