"""Makes expression nodes: one function for each production of the grammar."""

from __future__ import annotations

import math
from typing import Any

from stlc.diagnostics import Diagnostic
from stlc.source import Source, Span
from stlc.syntax import ast
from stlc.syntax.errors import SyntaxMistake
from stlc.syntax.mixes import Mixes
from stlc.syntax.past import PAST_WORDS, past_operator
from stlc.syntax.tokens import Token, split_number

Children = list[Any]
_OPERATORS = {"≤": "<=", "≥": ">=", "≠": "!="}


class ExprBuilder:
    """Builders of expressions over one source.

    `mixes.warnings` and `mistakes` hold what was noticed on the way.

    Every method takes the characters [start, end) of the production and its children.
    """

    def __init__(self, source: Source) -> None:
        self.source = source
        self.mixes = Mixes(source)
        self.mistakes: list[Diagnostic] = []

    def span(self, start: int, end: int) -> Span:
        """Span of this source."""
        return Span(self.source, start, end)

    def ident(self, token: Token) -> ast.Ident:
        """The name of a token."""
        return ast.Ident(token.text, self.span(token.start, token.end))

    # --- atoms -------------------------------------------------------------------------------

    def number(self, start: int, end: int, c: Children) -> ast.Expr:
        digits, unit = split_number(c[0].text)
        return ast.Number(self.span(start, end), float(digits), digits, unit)

    def string(self, start: int, end: int, c: Children) -> ast.String:
        return self.text(c[0])

    def text(self, token: Token) -> ast.String:
        """The string of a token; `\\"` and `\\\\` are the only escapes."""
        inner = token.text[1:-1].replace('\\"', '"').replace("\\\\", "\\")
        return ast.String(self.span(token.start, token.end), inner)

    def true(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Bool(self.span(start, end), True)

    def false(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Bool(self.span(start, end), False)

    def name(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Name(self.span(start, end), c[0].text)

    def call(self, start: int, end: int, c: Children) -> ast.Expr:
        args = tuple(arg for arg in c[1:] if arg is not None)
        function = self.ident(c[0])
        if function.text in PAST_WORDS:
            self.mistakes.append(past_operator(function.span))
        return ast.Call(self.span(start, end), function, args)

    def count_over(self, start: int, end: int, c: Children) -> ast.Expr:
        word, members, body = c
        span = self.span(start, end)
        names = _variables(members)
        if word.text != "count" or names is None:
            self.mistakes.append(
                SyntaxMistake(
                    span=members.span,
                    what="only `count` takes members and, behind a colon, a formula",
                    place="expected `count(NAME in DOMAIN: ..)`",
                    advice="for example `count(b in agents: rssi(a, b) >= -70 dBm) >= 2`",
                )
            )
            return ast.Call(span, self.ident(word), (members, body))
        return ast.Quantifier(span, "count", names, members.place, body)

    def group(self, start: int, end: int, c: Children) -> ast.Expr:
        self.mixes.in_parentheses(c[0])
        node: ast.Expr = c[0]
        return node

    def absolute(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Absolute(self.span(start, end), c[0])

    def tuple_of(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Tuple(self.span(start, end), tuple(c))

    def list_of(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.List(self.span(start, end), tuple(c))

    def attribute(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Attribute(self.span(start, end), c[0], self.ident(c[1]))

    def index(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Index(self.span(start, end), c[0], tuple(c[1:]))

    def range_of(self, start: int, end: int, c: Children) -> ast.Range:
        return ast.Range(self.span(start, end), c[0], c[1])

    # --- arithmetic --------------------------------------------------------------------------

    def _arithmetic(self, op: Any, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Arithmetic(self.span(start, end), op, c[0], c[1])

    def add(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._arithmetic("+", start, end, c)

    def subtract(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._arithmetic("-", start, end, c)

    def multiply(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._arithmetic("*", start, end, c)

    def divide(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._arithmetic("/", start, end, c)

    def power(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._arithmetic("^", start, end, c)

    def negate(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Negate(self.span(start, end), c[0])

    def plus(self, start: int, end: int, c: Children) -> ast.Expr:
        node: ast.Expr = c[0]
        return node

    # --- predicates --------------------------------------------------------------------------

    def compare_op(self, start: int, end: int, c: Children) -> str:
        text: str = c[0].text
        return _OPERATORS.get(text, text)

    def comparison_tail(self, start: int, end: int, c: Children) -> Children:
        return [*c]

    def compared(self, start: int, end: int, c: Children) -> ast.Comparison:
        first, tail = c
        return ast.Comparison(self.span(start, end), (first, *tail[1::2]), tuple(tail[::2]))

    def inside(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Membership(self.span(start, end), c[0], "in", c[1], c[2] is not None)

    def outside(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Membership(self.span(start, end), c[0], "outside", c[1], c[2] is not None)

    def swept(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Swept(self.span(start, end), c[0])

    # --- formulas ----------------------------------------------------------------------------

    def not_(self, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Not(self.span(start, end), c[0])

    def _temporal(self, op: Any, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Temporal(self.span(start, end), op, c[0], c[1])

    def always(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._temporal("always", start, end, c)

    def eventually(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._temporal("eventually", start, end, c)

    def next_(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._temporal("next", start, end, c)

    def _pair(self, op: Any, start: int, end: int, c: Children) -> ast.Expr:
        node = ast.TemporalPair(self.span(start, end), op, c[1], c[0], c[2])
        self.mixes.look_at_pair(node)
        return node

    def until_pair(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._pair("until", start, end, c)

    def release_pair(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._pair("release", start, end, c)

    def interval(self, start: int, end: int, c: Children) -> ast.Interval:
        return ast.Interval(c[0], _open_end(c[1]), self.span(start, end))

    def interval_point(self, start: int, end: int, c: Children) -> ast.Interval:
        return ast.Interval(c[0], c[0], self.span(start, end))

    def _logical(self, op: Any, start: int, end: int, c: Children) -> ast.Expr:
        node = ast.Logical(self.span(start, end), op, tuple(c))
        self.mixes.look_at_logical(node)
        return node

    def and_chain(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._logical("and", start, end, c)

    def or_chain(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._logical("or", start, end, c)

    def implies_pair(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._logical("implies", start, end, c)

    def iff_pair(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._logical("iff", start, end, c)

    # --- quantifiers -------------------------------------------------------------------------

    def variables(self, start: int, end: int, c: Children) -> tuple[ast.Ident, ...]:
        return tuple(self.ident(token) for token in c)

    def _quantifier(self, kind: Any, start: int, end: int, c: Children) -> ast.Expr:
        return ast.Quantifier(self.span(start, end), kind, *c)

    def forall(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._quantifier("forall", start, end, c)

    def exists(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._quantifier("exists", start, end, c)

    def sum_over(self, start: int, end: int, c: Children) -> ast.Expr:
        return self._quantifier("sum", start, end, c)


def _variables(members: ast.Expr) -> tuple[ast.Ident, ...] | None:
    """The names before `in`, None where these aren't names and a domain."""
    if not isinstance(members, ast.Membership) or members.relation != "in" or members.swept:
        return None
    subject = members.subject
    names = subject.items if isinstance(subject, ast.Tuple) else (subject,)
    found = [ast.Ident(n.text, n.span) for n in names if isinstance(n, ast.Name)]
    return tuple(found) if len(found) == len(names) else None


def _open_end(end: ast.Expr) -> ast.Expr | None:
    """`inf` and `end` mean no end."""
    if isinstance(end, ast.Name) and end.text in ("inf", "end"):
        return None
    if isinstance(end, ast.Number) and math.isinf(end.value):
        return None
    return end
