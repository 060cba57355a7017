"""Printing and parsing are inverse to each other, whatever the tree."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from stlc.source import Source, Span
from stlc.syntax import ast
from stlc.syntax.compare import same_syntax
from stlc.syntax.parse import parse
from stlc.syntax.print_expr import show
from stlc.syntax.print_property import show_property
from stlc.syntax.print_shape import show_shape
from stlc.syntax.printer import format_file

HERE = Span(Source("", ""), 0, 0)
NAMES = [
    *("a", "goal", "r1", "s", "m", "x", "box", "step", "margin", "require", "end", "hole", "on"),
    *("G", "F", "U", "R", "X", "H", "ev", "in", "or"),
    *("always", "until", "and", "not", "sum", "swept", "next"),
]


def ident(text: str) -> ast.Ident:
    return ast.Ident(text, HERE)


class Trees:
    """Random trees; hypothesis gives the seed and the size, which it makes smaller on failure."""

    def __init__(self, seed: int, size: int) -> None:
        self.random = Random(seed)
        self.budget = size

    def some(self, make: Callable[[], Any], least: int, most: int) -> tuple[Any, ...]:
        return tuple(make() for _ in range(self.random.randint(least, most)))

    def ident(self) -> ast.Ident:
        return ident(self.random.choice(NAMES))

    def number(self) -> ast.Number:
        text = self.random.choice(["0", "1", "2.5", ".5", "1e-3", "10", "3E+2"])
        unit = self.random.choice([None, None, "m", "s", "dB^2", "m/s", "dBm", "%"])
        return ast.Number(HERE, float(text), text, unit)

    def string(self) -> ast.String:
        return ast.String(HERE, "".join(self.some(lambda: self.random.choice('ab "\\/.é'), 0, 4)))

    def atom(self) -> ast.Expr:
        return self.random.choice([
            self.number,
            lambda: ast.Name(HERE, self.random.choice(NAMES)),
            lambda: ast.Bool(HERE, self.random.random() < 0.5),
            self.string,
        ])()  # fmt: skip

    def interval(self) -> ast.Interval | None:
        if self.random.random() < 0.5:
            return None
        end = self.number() if self.random.random() < 0.7 else None
        return ast.Interval(self.number(), end, HERE)

    def range_or_expr(self) -> ast.Expr:
        if self.random.random() < 0.3:
            return ast.Range(HERE, self.expr(), self.expr())
        return self.expr()

    def expr(self) -> ast.Expr:
        self.budget -= 1
        if self.budget <= 0:
            return self.atom()
        choices = [self.atom, self.value, self.arithmetic, self.predicate, *[self.formula] * 2]
        node: ast.Expr = self.random.choice(choices)()
        return node

    def value(self) -> ast.Expr:
        e, some = self.expr, self.some
        return self.random.choice([
            lambda: ast.Attribute(HERE, e(), self.ident()),
            lambda: ast.Index(HERE, e(), some(self.range_or_expr, 1, 2)),
            lambda: ast.Call(HERE, ident("f"), some(e, 0, 3)),
            lambda: ast.Call(HERE, ident("G"), some(e, 2, 3)),  # `G(a)` is always
            lambda: ast.Tuple(HERE, some(e, 2, 3)),
            lambda: ast.List(HERE, some(e, 1, 3)),
            lambda: ast.Absolute(HERE, e()),
        ])()  # fmt: skip

    def arithmetic(self) -> ast.Expr:
        operator: Any = self.random.choice("+-*/^")
        if self.random.random() < 0.2:
            return ast.Negate(HERE, self.expr())
        return ast.Arithmetic(HERE, operator, self.expr(), self.expr())

    def predicate(self) -> ast.Expr:
        e = self.expr
        operators: Any = self.some(
            lambda: self.random.choice(["<", "<=", ">", ">=", "==", "!="]), 1, 2
        )
        return self.random.choice([
            lambda: ast.Comparison(HERE, tuple(e() for _ in range(len(operators) + 1)), operators),
            lambda: ast.Membership(HERE, e(), "in", e()),
            lambda: ast.Membership(HERE, e(), "outside", e(), self.random.random() < 0.5),
            lambda: ast.Swept(HERE, e()),
        ])()  # fmt: skip

    def formula(self) -> ast.Expr:
        e, pick = self.expr, self.random.choice
        kind: Any = pick(["forall", "exists", "sum"])
        unary: Any = pick(["always", "eventually", "next"])
        pair: Any = pick(["until", "release"])
        chain: Any = pick(["and", "or"])
        arrow: Any = pick(["implies", "iff"])
        return pick([
            lambda: ast.Not(HERE, e()),
            lambda: ast.Logical(HERE, chain, self.some(e, 2, 3)),
            lambda: ast.Logical(HERE, arrow, self.some(e, 2, 2)),
            lambda: ast.Temporal(HERE, unary, self.interval(), e()),
            lambda: ast.TemporalPair(HERE, pair, self.interval(), e(), e()),
            lambda: ast.Quantifier(
                HERE, kind, self.some(self.ident, 1, 2), self.range_or_expr(), e()
            ),
        ])()  # fmt: skip

    def pair(self) -> Any:
        return self.expr(), self.expr()

    def ring(self) -> Any:
        return self.some(lambda: ast.Tuple(HERE, self.pair()), 1, 3)

    def shape(self) -> ast.Shape:
        self.budget -= 2
        plain = [
            lambda: ast.Box(HERE, self.pair(), self.pair()),
            lambda: ast.PolygonShape(HERE, self.ring(), self.some(self.ring, 0, 2)),
            lambda: ast.GeoJson(HERE, self.string(), None),
            lambda: ast.GeoJson(HERE, self.string(), self.string()),
            lambda: ast.NamedShape(HERE, self.ident()),
        ]
        nested = [
            lambda: ast.Union(HERE, self.some(self.shape, 2, 3)),
            lambda: ast.Prism(HERE, self.shape(), self.pair()),
            lambda: ast.Moving(HERE, self.some(lambda: (self.expr(), self.shape()), 1, 2)),
        ]
        shape: ast.Shape = self.random.choice(plain + nested if self.budget > 0 else plain)()
        return shape

    def property(self) -> ast.Property:
        if self.random.random() < 0.3:
            return ast.Property(self.ident(), (self.expr(),), True, HERE)
        if self.random.random() < 0.3:
            return self.chain()
        return ast.Property(self.ident(), self.some(self.expr, 0, 3), False, HERE)

    def chain(self) -> ast.Property:
        """`-most <= vx <= 1`, `|vx| <= most`, and words behind them."""
        pick = self.random.choice
        name = ast.Name(HERE, pick(["vx", "level", "u", "s", "m"]))
        limit = pick([self.number(), ast.Negate(HERE, ast.Name(HERE, "most"))])
        end = pick([self.number(), ast.Name(HERE, "most")])
        size = pick([ast.Absolute(HERE, name), ast.Absolute(HERE, ast.Index(HERE, name, (end,)))])
        operands = pick([(limit, name, end), (limit, name), (size, end), (limit, size, end)])
        less = ("<=",) * (len(operands) - 1)
        words = pick([(), (ast.Name(HERE, "polygon"), self.number())])
        comparison = ast.Comparison(HERE, operands, less)
        return ast.Property(ident(name.text), (comparison, *words), False, HERE)

    def block(self) -> tuple[ast.Property, ...]:
        return self.some(self.property, 0, 3)

    def text(self) -> str:
        """A statement with comments and blanks at random places."""
        pick = self.random.choice
        rows = [show_property(item) for item in self.block()]
        body = pick([
            lambda: f"require:  {show(self.expr())}",
            lambda: f"require G margin 2 :\n {show(self.expr())}",
            lambda: f"obstacle o ={show_shape(self.shape())} inflate  {show(self.expr())}",
            lambda: 'signal a,b  [m/s]  from  "d.csv"',
            lambda: 'signal from, b from "d.csv"',
            lambda: f"wall w= {show_shape(self.shape())}  loss {show(self.expr())}",
            lambda: "wall w = line " + " ".join(f"({k}, {2 * k})" for k in range(3)),
            lambda: "agent a:c {" + ";\n ".join(rows) + "}",
            lambda: "agent a[1..3]:c {" + ";".join(rows) + "}",
            lambda: "  # of\n  ".join(["channel c {#in", *rows, "#end\n}"]),
            lambda: f"let f(a, b) = #why\n {show(self.expr())}",
            lambda: "// alone",
            lambda: pick(["", "\n\n", "\t"]),
        ])()  # fmt: skip
        return body + pick(["", "  # note", "//x", "\n\n\n", " ;"])


SEEDS = st.integers(0, 2**32)
SIZES = st.integers(1, 30)


def only(text: str) -> ast.Statement:
    result = parse(Source("t.stl", text))
    assert result.ok, (text, [str(d) for d in result.diagnostics])
    assert len(result.file.statements) == 1, text
    return result.file.statements[0]


@given(SEEDS, SIZES)
def test_an_expression_is_read_back_as_it_was(seed: int, size: int) -> None:
    expression = Trees(seed, size).expr()
    statement = only(f"require: {show(expression)}")
    assert isinstance(statement, ast.Require)
    assert same_syntax(statement.formula, expression), show(expression)


@given(SEEDS, SIZES)
@example(5145, 7)  # regions called X and until, between two heights: operators elsewhere
@example(349, 7)
def test_a_shape_is_read_back_as_it_was(seed: int, size: int) -> None:
    shape = Trees(seed, size).shape()
    statement = only(f"region g = {show_shape(shape)}")
    assert isinstance(statement, ast.RegionDecl)
    assert same_syntax(statement.shape, shape), show_shape(shape)


@given(SEEDS, SIZES)
def test_a_block_is_read_back_as_it_was(seed: int, size: int) -> None:
    items = Trees(seed, size).block()
    text = "\n  ".join(["channel c {", *map(show_property, items)]) + "\n}"
    statement = only(text)
    assert isinstance(statement, ast.ChannelDecl)
    assert same_syntax(statement.properties, items), text


@given(SEEDS, SIZES)
def test_formatting_keeps_meaning_and_comments_and_is_idempotent(seed: int, size: int) -> None:
    trees = Trees(seed, size)
    text = "\n".join(trees.some(trees.text, 0, 4))
    before = parse(Source("t.stl", text))
    assert before.ok, (text, [str(d) for d in before.diagnostics])
    once = format_file(before.file)
    after = parse(Source("t.stl", once))
    assert same_syntax(before.file.statements, after.file.statements), once
    assert len(before.file.comments) == len(after.file.comments)
    assert format_file(after.file) == once
    assert not [d for d in after.diagnostics if d.code == "W0101"]


@pytest.mark.parametrize(
    "text",
    [
        "(a + b) * c - d",
        "(a + b)^2 + c - d",
        "a - (b + c) - d",
        "((a - b) / c + d) * e",
        "a * b^2 * c",
    ],
)
def test_chains_keep_their_brackets(text):
    source = Source("x", f"require r: {text} >= 1\n")
    assert format_file(parse(source).file) == f"require r: {text} >= 1\n"


def test_the_last_step_stays_one() -> None:
    from stlc.api import loads

    text = (
        "agent a : single_integrator { start (1, 1); control |u| <= 1 }\nhorizon 4\n"
        "require: always[end] a.x >= 1\n"
    )
    out = format_file(parse(Source("m.stl", text)).file)
    assert "always[end] a.x" in out
    assert loads(out).requirements[0].formula == loads(text).requirements[0].formula
