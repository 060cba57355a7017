"""What the concrete syntax means: names and operators, precedence, statements, units."""

from __future__ import annotations

import re

import pytest

from stlc.record import changed
from stlc.source import Source
from stlc.syntax import ast
from stlc.syntax.compare import same_syntax
from stlc.syntax.parse import ParseResult, parse


def read(text: str) -> ParseResult:
    return parse(Source("t.stl", text))


def statements(text: str) -> tuple[ast.Statement, ...]:
    result = read(text)
    assert result.ok, [str(d) for d in result.diagnostics]
    return result.file.statements


def codes(text: str) -> list[str]:
    return [d.code for d in read(text).diagnostics]


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("G[0,5] x > 0", "always[0, 5] (x > 0)"),
        ("G_[0,5] x > 0", "always[0, 5] x > 0"),
        ("G(x > 0)", "always (x > 0)"),
        ("globally x > 0", "always x > 0"),
        ("alw_[0, 5] x > 0", "always[0, 5] x > 0"),
        ("ev_[0:5] x > 0", "eventually[0, 5] x > 0"),
        ("[] x > 0", "always x > 0"),
        ("[]_[0,5] x > 0", "always[0, 5] x > 0"),
        ("<>[0,5] x > 0", "eventually[0, 5] x > 0"),
        ("F[0, inf] x > 0", "eventually[0, end] x > 0"),
        ("finally x > 0", "eventually x > 0"),
        ("X x > 0", "next x > 0"),
        ("(x > 0) U[0,5] (y > 0)", "(x > 0) until[0, 5] (y > 0)"),
        ("x > 0 until_[0,5] y > 0", "(x > 0) until[0, 5] (y > 0)"),
        ("x > 0 R y > 0", "x > 0 release y > 0"),
        ("!(x > 0) & y > 0", "(not (x > 0)) and (y > 0)"),
        ("~(x > 0) || y > 0", "(not (x > 0)) or (y > 0)"),
        ("x > 0 | y > 0", "x > 0 or y > 0"),
        ("x > 0 && y > 0", "x > 0 and y > 0"),
        ("x > 0 -> y > 0", "x > 0 implies y > 0"),
        ("x > 0 => y > 0", "x > 0 implies y > 0"),
        ("x > 0 <-> y > 0", "x > 0 iff y > 0"),
        ("□[0,5] x ≥ 0 ∧ ¬(y ≤ 1)", "(always[0, 5] x >= 0) and (not (y <= 1))"),
        # precedence, tightest first
        ("always x > 0 and y > 0", "(always (x > 0)) and (y > 0)"),
        ("not a in g", "not (a in g)"),
        ("not p until q", "(not p) until q"),
        ("p until q until r", "p until (q until r)"),
        ("p until q and r", "(p until q) and r"),
        ("p and q or r", "(p and q) or r"),
        ("p or q implies r", "(p or q) implies r"),
        ("p implies q implies r", "p implies (q implies r)"),
        ("p implies q iff r", "(p implies q) iff r"),
        ("a + b * c - d > 2 ^ -k", "((a + (b * c)) - d) > (2 ^ (-k))"),
        ("-a ^ 2 < 0", "(-(a ^ 2)) < 0"),
        ("a - b - c > 0", "((a - b) - c) > 0"),
        ("0 < x <= 3", "0 < x <= 3"),
        ("forall a in s: p and q", "forall a in s: (p and q)"),
        ("p and forall a in s: q or r", "p and (forall a in s: (q or r))"),
        # bars
        ("|x| > 0 | |y - z| > 1 || p", "abs_(x) > 0 or abs_(y - z) > 1 or p"),
        ("||x| - 1| <= 2", "abs_(abs_(x) - 1) <= 2"),
        # continuation
        ("p\n  and q\n  or\n r", "(p and q) or r"),
    ],
)
def test_a_formula_is_read_as(written: str, meant: str) -> None:
    left, right = statements(f"require: {written}")[0], statements(f"require: {meant}")[0]
    assert same_syntax(left, _absolute(right)), written


def _absolute(node: object) -> object:
    """`abs_(x)` stands for `|x|` in the expected texts."""
    if isinstance(node, tuple):
        return tuple(map(_absolute, node))
    if isinstance(node, ast.Call) and node.function.text == "abs_":
        return ast.Absolute(node.span, _absolute(node.args[0]))  # type: ignore[arg-type]
    if isinstance(node, ast.Expr | ast.Statement):
        names = type(node).record_fields
        return changed(node, **{name: _absolute(getattr(node, name)) for name in names})
    return node


@pytest.mark.parametrize(
    "name", ["G", "F", "U", "R", "X", "s", "H", "S", "O", "P", "x", "box", "step", "in", "m", "ev"]
)
@pytest.mark.parametrize(
    "template",
    [
        "{} > 3", "{} * 2 <= 1 and {} < 4", "3 < {}", "f({}, {})", "p or 1 - {} >= 0", "{} == {}",
        "always {} >= 0", "{} + {} > 1", "{}.vx > 1", "r.{} > 1", "always[0, 3] {} - 1 > 0",
    ],
)  # fmt: skip
def test_an_operators_word_can_be_a_signal(name: str, template: str) -> None:
    written = statements("require: " + template.replace("{}", name))[0]
    plain = statements("require: " + template.replace("{}", "zz"))[0]
    assert repr(written).count(f"text='{name}'") == repr(plain).count("text='zz'")


@pytest.mark.parametrize("name", ["box", "polygon", "moving", "hole", "x", "geojson", "linear"])
@pytest.mark.parametrize(
    "template",
    [
        "moving { @[1]: @; 2 * @[0] + @(1): box [0, 1] x [0, 1] } linear",
        "moving { @: polygon (@[1], 2) (3, @(1)) (@, @); |@[2]|: @ }",
        "polygon (@[1], @(1) + @[2]) (1, 2) hole (@(1, 2), 3)",
        "(@ + polygon (1, @[1])) + box [@[0], @(3)] x [@, 2]",
        "box [0, 1] x [0, 1] velocity (@[0], @(1))",
        "(@) x [@[0], @] + (@ + (polygon (@(1), 2) + box [1, 2] x [1, 2]))",
    ],
)
def test_a_word_of_shapes_can_be_a_name_within_them(name: str, template: str) -> None:
    """In the time of a frame, a point or a height, with an index or as a call."""

    def told(word: str) -> str:
        (statement,) = statements("obstacle o = " + template.replace("@", word))
        return re.sub(r"start=\d+, end=\d+", "", repr(statement))

    assert told(name).replace(f"'{name}'", "'zz'") == told("zz")


@pytest.mark.parametrize("keyword", ["signal", "param", "region", "agent", "let", "require"])
@pytest.mark.parametrize("name", ["G", "until", "in", "not", "margin", "step", "require"])
def test_everything_can_have_the_name_of_a_keyword(keyword: str, name: str) -> None:
    rest = {"signal": "", "agent": ": c", "region": "= box [0, 1] x [0, 1]", "require": ": p"}
    (statement,) = statements(f"{keyword} {name} {rest.get(keyword, '= 3')}")
    assert f"text='{name}'" in repr(statement)


@pytest.mark.parametrize(
    ("text", "digits", "unit"),
    [
        ("0.5 m", "0.5", "m"), ("10 dB^2", "10", "dB^2"), ("2 m/s", "2", "m/s"), ("5s", "5", "s"),
        ("250 ms", "250", "ms"), ("1 kg", "1", "kg"), ("70dBm", "70", "dBm"),
        ("1e-3", "1e-3", None),
        ("2 m/s^2", "2", "m/s^2"), (".5 rad", ".5", "rad"), ("5 min", "5", "min"),
        ("3 %", "3", "%"),
    ],
)  # fmt: skip
def test_units_belong_to_their_number(text: str, digits: str, unit: str | None) -> None:
    (statement,) = statements(f"param v = {text}")
    assert isinstance(statement, ast.Param)
    assert isinstance(statement.value, ast.Number)
    assert (statement.value.text, statement.value.unit) == (digits, unit)


def test_a_unit_does_not_reach_over_the_line_end() -> None:
    assert [type(s) for s in statements("horizon 20\nstep 1\n")] == [ast.Horizon, ast.Step]


def test_statements_end_at_keywords_and_semicolons() -> None:
    text = "param v = 2; param w = 3\nrequire a:\n  step > 3\n  and margin < 2\nmargin 0.1"
    kinds = [type(s) for s in statements(text)]
    assert kinds == [ast.Param, ast.Param, ast.Require, ast.Margin]


def test_several_mistakes_are_reported_together_and_the_rest_is_read() -> None:
    text = "region g box\nparam v = 2\nrequire a: x > > 1\nlet f = (x\nrequire b: y > 0\n"
    result = read(text)
    assert [d.code for d in result.diagnostics] == ["E0101", "E0101", "E0104"]
    assert [d.span.line for d in result.diagnostics if d.span] == [1, 3, 4]
    assert [type(s) for s in result.file.statements] == [ast.Param, ast.Require]


def test_a_misspelt_keyword_costs_nothing_but_its_message() -> None:
    result = read("step 1 s\nrequre a: x > 0\nstep 1 s\n")
    assert [d.code for d in result.diagnostics] == ["E0109"]
    assert [type(s) for s in result.file.statements] == [ast.Step, ast.Require, ast.Step]
    fix = result.diagnostics[0].fix
    assert fix is not None
    assert (fix.span.text, fix.replacement) == ("requre", "require")


def test_a_word_near_prefer_is_told_once() -> None:
    result = read("step 1 s\npreferclose weight 2: a > -32 dBm\nstep 2 s\n")
    assert [d.code for d in result.diagnostics] == ["E0109"]
    assert [type(s) for s in result.file.statements] == [ast.Step, ast.Prefer, ast.Step]


def test_very_many_alien_lines_end_with_one_remark() -> None:
    found = codes("requre a: x > 0\n" * 1000)
    assert found == ["E0109"] * 50 + ["E0114"]


@pytest.mark.parametrize(
    ("formula", "warned"),
    [
        ("always x > 0 and y > 0", True), ("(always x > 0) and y > 0", False),
        ("always x > 0 and always y > 0", False), ("always (x > 0 and y > 0)", False),
        ("p until q and r", True), ("p until (q and r)", False), ("(p until q) and r", False),
        ("not p until q", True), ("(not p) until q", False), ("not (p until q)", False),
        ("p implies q implies r", True), ("p implies (q implies r)", False),
        ("eventually p implies q", True), ("p and eventually q", False), ("p and q or r", False),
    ],
)  # fmt: skip
def test_unclear_mixes_are_warned_about_and_the_fix_keeps_the_meaning(
    formula: str, warned: bool
) -> None:
    text = f"require: {formula}"
    result = read(text)
    assert [d.code for d in result.diagnostics] == ["W0101"] * warned
    if warned:
        fix = result.diagnostics[0].fix
        assert fix is not None
        mended = text[: fix.span.start] + fix.replacement + text[fix.span.end :]
        assert codes(mended) == []
        assert same_syntax(statements(mended), result.file.statements)


def test_properties_of_a_block() -> None:
    (statement,) = statements(
        "channel c {\n path_loss L0 = -12 dBm, n = 3\n fading 10 dB^2, length 2 m; on\n"
        " states px, vx\n partition 10 x 20\n speed <= 2\n start (1, 1)\n A = [[1,\n 0]]\n}"
    )
    assert isinstance(statement, ast.ChannelDecl)
    shown = [(p.key.text, len(p.args), p.assigned) for p in statement.properties]
    assert shown == [
        ("path_loss", 0, False), ("L0", 1, True), ("n", 1, True), ("fading", 1, False),
        ("length", 1, False), ("on", 0, False), ("states", 2, False), ("partition", 2, False),
        ("speed", 1, False), ("start", 1, False), ("A", 1, True),
    ]  # fmt: skip


def test_every_node_has_the_span_of_its_text() -> None:
    (statement,) = statements("require a:  always[0, 5] (x + 1 > 2)  # why")
    assert isinstance(statement, ast.Require)
    assert statement.span.text == "require a:  always[0, 5] (x + 1 > 2)"
    assert isinstance(statement.formula, ast.Temporal)
    assert statement.formula.span.text == "always[0, 5] (x + 1 > 2)"
    assert statement.formula.arg.span.text == "x + 1 > 2"
