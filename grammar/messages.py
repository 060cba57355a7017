"""Malformed samples and what to say about them.

A sample is parsed when a mistake of the same kind has to be explained: where the parser gets stuck
on the sample (its state and the terminal it can't use) is where the message applies. So a message
follows the grammar wherever it moves, and a test finds samples that have become valid. With
`any_token` the message applies to every terminal that the state can't use.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class Message:
    """What is said where one of the samples gets stuck; `{found}` is the text found there."""

    samples: tuple[str, ...]
    what: str
    place: str
    advice: str
    any_token: bool = False


MESSAGES: Final[tuple[Message, ...]] = (
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
    # --- declarations ---
    Message(
        ("region = box [0, 1] x [0, 1]", "obstacle = box [0, 1] x [0, 1]", "param = 3", "let = 3",
         "agent : cart", "channel { n 2 }", "dynamics = unicycle", "agent 3 : c",
         "region 3 = g", "signal 3", "param 3 = 2", "dynamics { A = 1 }", "region", "obstacle",
         "param", "let", "agent", "station", "channel", "dynamics", "signal"),
        "a name is missing",
        "expected a name after the keyword",
        "names start with a letter, followed by letters, digits and `_`",
        any_token=True,
    ),
    Message(
        ("region g box [0, 1] x [0, 1]", "obstacle o polygon (1, 2)", "param v 2", "let f x > 0",
         "let f(a) a in g", "region g", "obstacle g", "param v", "let f", "let f(a)",
         "region g : box [0, 1] x [0, 1]", "param v : 2", "let f : x > 0"),
        "`=` is missing",
        "expected `=` after the name",
        "write `keyword name = value`",
        any_token=True,
    ),
    Message(
        ("param v =", "let f =", "let f(a) ="),
        "a value is missing",
        "expected a value after this",
        "write what the name stands for",
    ),
    Message(
        ("let f(1) = x", "let f(a b) = x", "let f() = x", "let f(a, ) = x", "let f(a > 2) = x"),
        "a parameter list holds names separated by commas",
        "expected a name, `,` or `)`",
        "write `let near(a, b) = distance(a, b) <= 2 m`",
        any_token=True,
    ),
    Message(
        ("region g =", "obstacle o =", "workspace", "workspace = box [0, 1] x [0, 1]",
         "region g = [0, 1] x [0, 1]", "region g = (1, 2) (2, 3)", "region g = 3",
         "obstacle o = [0, 1]", "workspace [0, 1] x [0, 1]", "workspace (0, 0) (1, 0)",
         "region g = box [0, 1] x [0, 1] +"),
        "a shape is missing",
        "expected a shape here",
        "shapes are `box [x0, x1] x [y0, y1]`, `polygon (x, y) (x, y) (x, y)`, "
        '`geojson "file"`, `moving { .. }`, the name of a region, and sums of them',
        any_token=True,
    ),
    Message(
        ("region g = box [0, 1]", "region g = box [0, 1] [0, 1]", "region g = box [0, 1] * [0, 1]",
         "region g = box [0, 1] by [0, 1]", "region g = box [0, 1], [0, 1]"),
        "a box needs `x` between its two sides",
        "expected `x`",
        "write `box [x0, x1] x [y0, y1]`",
        any_token=True,
    ),
    Message(
        ("region g = box [0] x [0, 1]",
         "region g = box [0..1] x [0, 1]", "region g = box [0, 1, 2] x [0, 1]"),
        "each side of a box is `[from, to]`",
        "expected `,` or `]`",
        "write `box [x0, x1] x [y0, y1]`",
        any_token=True,
    ),
    Message(
        ("region g = box [0, ] x [0, 1]", "region g = box [, 1] x [0, 1]",
         "region g = box [0, 1] x [0, ]", "region g = box [0, 1] x [, 1]"),
        "a side of a box has two ends",
        "expected a number here",
        "write `box [x0, x1] x [y0, y1]`",
    ),
    Message(
        ("minimize x, y", "maximize x, y"),
        "costs are added up",
        "expected `+`",
        "write `minimize effort + 0.1 * link_cost(radio)`, or two statements",
    ),
    Message(
        ("region g = polygon (1) (2, 3)", "region g = polygon (1 2) (2, 3)"),
        "a corner has two coordinates",
        "expected `,`",
        "write `polygon (x, y) (x, y) (x, y)`",
        any_token=True,
    ),
    Message(
        ("region g = polygon (1, 2), (2, 3)", "region g = goal1 3", "region g = goal1 goal2",
         "workspace box [0, 1] x [0, 1] x [0, 1]"),
        "unexpected `{found}` after a shape",
        "the shape is complete before this",
        "corners follow each other without commas; shapes are joined by `+`; there are two axes",
        any_token=True,
    ),
    Message(
        ("region g = box [0, 1] x [0, 1] inflate 2", "workspace box [0, 1] x [0, 1] inflate 2"),
        "only obstacles are inflated",
        "not possible here",
        "declare the larger shape, or an `obstacle`",
    ),
    Message(
        ("agent r1", "agent r1 { start (1, 1) }", "agent r1 = cart", "agent r1 cart"),
        "an agent needs its dynamics",
        "expected `:` and the name of the dynamics",
        "write `agent r1 : cart { start (1, 1) }`",
        any_token=True,
    ),
    Message(
        ("agent r1 : { start (1, 1) }", "agent r1 :"),
        "an agent needs its dynamics",
        "expected the name of the dynamics",
        "write `agent r1 : cart { start (1, 1) }`, with `dynamics cart = double_integrator`",
        any_token=True,
    ),
    Message(
        ("agent r[4] : cart", "agent r[1, 4] : cart", "agent r[1:4] : cart"),
        "a family of agents is counted from..to",
        "expected `..`",
        "write `agent r[1..4] : cart { .. }`",
        any_token=True,
    ),
    Message(
        ("station base (5, 0)", "station base", "station base = (5, 0)", "station base : (5, 0)"),
        "`at` is missing",
        "expected `at` and a position",
        "write `station base at (5, 0)`",
        any_token=True,
    ),
    Message(
        ("dynamics cart", "dynamics cart : double_integrator", "dynamics cart unicycle"),
        "dynamics need a kind or matrices",
        "expected `=` or `{`",
        "write `dynamics cart = double_integrator` or `dynamics cart { A = [[..]]; B = [[..]] }`",
        any_token=True,
    ),
    Message(
        ("dynamics cart =", "dynamics cart = 3", "dynamics cart = { A = 1 }"),
        "the kind of dynamics is missing",
        "expected a kind of dynamics",
        "for example `double_integrator` or `single_integrator`",
        any_token=True,
    ),
    Message(
        ("channel radio", "channel radio = rician", "channel radio : wifi"),
        "a channel needs its properties",
        "expected `{`",
        "write `channel radio { path_loss .. }`",
        any_token=True,
    ),
    Message(
        ("import lib.stl", "import", "import lib"),
        "a file name stands in quotes",
        "expected a string",
        'write `import "lib.stl"`',
        any_token=True,
    ),
    Message(
        ("signal x m", "signal x = 3", "signal x : m", "signal x []"),
        "a unit stands in square brackets",
        "expected `,` or `[unit]`",
        "write `signal speed [m/s]`",
        any_token=True,
    ),
    Message(
        ("step", "horizon", "margin", "minimize", "maximize", "station b at"),
        "a value is missing",
        "expected a value after this",
        "for example `step 1 s`, `horizon 20`, `minimize effort`",
    ),
    Message(
        ("step = 1 s", "horizon = 3", "margin : 2", "minimize : x", "minimize = x", "maximize : x",
         "step : 1 s"),
        "unexpected `{found}` after the keyword",
        "expected a value here",
        "the value follows the keyword directly: `step 1 s`, `minimize effort`",
    ),
    # --- blocks ---
    Message(
        ("agent r : c { 3 }", "agent r : c { (1, 2) }", "channel c { = 3 }",
         "agent r : c { a 1; 2 }"),
        "a property starts with its name",
        "expected the name of a property",
        "write `name value`, one on each line or separated by `;`, and pairs as `(1, 2)`",
        any_token=True,
    ),
    Message(
        ("channel c { n = }", "channel c { n = ; m = 2 }"),
        "a property without its value",
        "expected a value after `=`",
        "write `name = value`",
    ),
    Message(
        ("channel c { n : 3 }", "agent r : c { start : (1, 1) }"),
        "properties have no `:`",
        "unexpected here",
        "write `name value` or `name = value`",
    ),
)  # fmt: skip
