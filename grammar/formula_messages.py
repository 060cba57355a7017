"""Messages on mistakes within formulas: operators, intervals, quantifiers, calls and lists."""

from __future__ import annotations

from typing import Final

from stlc.grammar.message import Message

FORMULAS: Final[tuple[Message, ...]] = (
    # --- requirements and formulas ---
    Message(
        ("require reach always x > 0", "require reach eventually[0, 5] x > 0",
         "require reach next x > 0", "require reach not x > 0", "require reach x > 0",
         "require reach forall a in agents: a in g", "require reach 3",
         "require reach = always x > 0"),
        "`:` is missing after the requirement's name",
        "expected `:` before this",
        "write `require name: formula`, or `require: formula` without a name",
    ),
    Message(
        ("require", "require a:", "require a margin 1:"),
        "a requirement without a formula",
        "expected a formula after this",
        "write `require name: formula`, for example `require reach: eventually r1 in goal`",
    ),
    Message(
        ("require a: always", "require a: eventually", "require a: not", "require a: next",
         "require a: always[0, 5]", "require a: x until[0, 3]"),
        "an operator without a formula",
        "expected a formula after this",
        "write the formula that the operator applies to, for example `always x >= 0`",
    ),
    Message(
        ("require a: always and x > 0", "require a: not and x > 0", "require a: always :"),
        "an operator without a formula",
        "expected a formula before this",
        "write the formula that the operator applies to, for example `always x >= 0`",
        any_token=True,
    ),
    Message(
        ("require a: and x > 1", "let f = or x > 1", "require a: implies x > 1",
         "require a: until x > 1", "require a: in goal", "require a: always[0, 5] in(r, goal)"),
        "`{found}` without a left side",
        "expected a formula before this",
        "`{found}` stands between two operands",
    ),
    Message(
        ("require a: x > 1 and", "require a: x > 1 or", "require a: x > 1 implies",
         "require a: x > 1 iff", "require a: x > 1 until"),
        "an operator without a right side",
        "expected a formula after this",
        "write the second formula",
    ),
    Message(
        ("require a: x > 1 and and y > 1", "require a: x > 1 or or y > 1", "require a: x > 1 iff :",
         "require a: x > 1 implies or y > 1", "require a: x > 1 until and y > 1"),
        "unexpected `{found}` where a formula is due",
        "expected a formula here",
        "an operator needs a formula on each side",
        any_token=True,
    ),
    Message(
        ("require a: x >", "require a: x >= 1 <", "require a: x +", "require a: x *",
         "require a: -",
         "require a: x /", "require a: x ^", "require a: x -"),
        "an operator without a right side",
        "expected a value after this",
        "write a number, a name or an expression after the operator",
    ),
    Message(
        ("require a: x > > 1", "require a: x + * 1", "require a: x * / 2", "require a: x - :",
         "require a: x / : 3"),
        "unexpected `{found}` where a value is due",
        "expected a value here",
        "write a number, a name or an expression after the operator",
        any_token=True,
    ),
    Message(
        ("require a: x <> 3", "require a: abs(x) <> 3"),
        "`<>` is the operator `eventually`",
        "not a comparison",
        "for unequal write `!=`",
    ),
    Message(
        ("require a: x > 0 y > 0", "require a: x > 0 always y > 0", "require a: x > 0 not y > 0",
         "require a: x in g forall a in b: c"),
        "two formulas side by side",
        "expected an operator before this",
        "join them with `and`, `or`, `implies` or `until`",
    ),
    Message(
        ("require a: x in", "require a: x outside"),
        "a region is missing",
        "expected the name of a region after this",
        "write `agent in region` or `agent outside obstacle`",
    ),
    Message(
        ("require a: |x - y < 1", "require a: |x", "require a: |x| + |y"),
        "`|` is never closed",
        "the statement ends within an absolute value",
        "close it with `|`, or write `abs(x)`; for `or` write the word",
    ),
    Message(
        ("require a: { x > 0 }", "require a: x > 0 { y > 0 }", "let a = { x }"),
        "braces don't group formulas",
        "expected parentheses",
        "group with `(` and `)`; braces hold the properties of agents, dynamics and channels",
    ),
    Message(
        ("require a: swept x in g", "require a: forall a in b: swept a outside g"),
        "`swept` stands last",
        "expected a formula",
        "write `r1 outside pillar swept`",
    ),
    # --- intervals ---
    Message(
        ("require a: always[] x > 0", "require a: always[0,] x > 0", "require a: always[,5] x > 0",
         "require a: always[:5] x > 0", "require a: always[0:] x > 0"),
        "an interval needs two ends",
        "expected a time here",
        "write `[0, 5]` in steps, `[0, 5 s]` in time, or `[0, end]`",
        any_token=True,
    ),
    Message(
        ("require a: always[0 5] x > 0", "require a: always[0; 5] x > 0",
         "require a: always[0..5] x > 0"),
        "the ends of an interval are separated by a comma",
        "expected `,`",
        "write `[0, 5]`",
    ),
    Message(
        ("require a: always[0, 5, 6] x > 0",),
        "an interval has two ends",
        "expected `]`",
        "write `[0, 5]`",
        any_token=True,
    ),
    # --- quantifiers ---
    Message(
        ("require a: forall agents: a in g", "require a: exists agents: a in g",
         "require a: forall a agents: a in g", "require a: forall a: a in g"),
        "`in` is missing",
        "expected `in` and a set",
        "write `forall a in agents: formula`",
    ),
    Message(
        ("require a: forall a, b in agents: a in g", "require a: exists a, b in agents: a in g"),
        "several variables stand in parentheses",
        "expected `in`",
        "write `forall (a, b) in pairs: formula`",
    ),
    Message(
        ("require a: forall a in agents a in g", "require a: exists a in agents always a in g",
         "require a: forall a in agents", "require a: forall a in [g, h] a in g",
         "require a: forall a in agents not x > 0", "require a: forall i in 1..4 x > 0"),
        "`:` is missing after the set",
        "expected `:` after the set",
        "write `forall a in agents: formula`",
    ),
    # --- calls and lists ---
    Message(
        ("require a: f(x y)", "require a: f(x 3)", "require a: (x, y z) > 1", "let m = [1 2]",
         "let m = [1, 2 3]", "let m = [[1, 2] [3, 4]]", "require a: f(x; y)", "let m = [1; 2]"),
        "a comma is missing",
        "expected `,` before this",
        "separate values with commas",
    ),
    Message(
        ("require a: f(x,)", "let m = [1, 2, ]", "require a: f(,)", "require a: (1, ) > 0"),
        "a value is missing",
        "expected a value here",
        "remove the comma, or write a value",
    ),
    Message(
        ("require a: ()", "require a: x > ()"),
        "empty parentheses",
        "expected a formula or a value here",
        "remove them, or write what they should hold",
    ),
)  # fmt: skip
