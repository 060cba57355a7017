"""Formulas of other tools as text of the language here, with the same robustness."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.dialects.errors import DialectSyntax, DialectUnsupported, ImportFailure
from stlc.dialects.numbers import PRODUCT, SUM, Numbers
from stlc.dialects.scope import Kind, Scope
from stlc.dialects.times import Times
from stlc.dialects.tree import (
    COMPARISONS,
    Binary,
    Bool,
    Chain,
    Expr,
    Interval,
    Name,
    Not,
    Pair,
    Temporal,
    children,
)

LOOSE, COMPARED, TIGHT = 1, 2, 3
EQUAL_WITHIN = "2e-6"
"""Twice the tolerance of satisfaction: the least that keeps equal and unequal values apart."""


@dataclass(frozen=True, slots=True)
class Text:
    """A formula's text and how tight it binds."""

    text: str
    level: int = LOOSE

    def at(self, level: int) -> str:
        """The text, in parentheses if it binds less tight than `level`."""
        return self.text if self.level >= level else f"({self.text})"


class Formulas:
    """Writes the formulas of a file."""

    def __init__(self, scope: Scope, times: Times) -> None:
        self.scope, self.times = scope, times
        self._equal_within: str | None = None

    @property
    def equal_within(self) -> str | None:
        """Name of the parameter that parts equal from unequal values, if one is needed."""
        return self._equal_within

    def text(self, expr: Expr, at: int) -> Text:
        """The formula `expr` of definition `at`. Raises ImportFailure."""
        match expr:
            case Bool(value=truth):
                return Text("true" if truth else "false", TIGHT)
            case Name(text=name) if self.scope.kind(name, at) is Kind.FORMULA:
                return Text(self.scope.emitted[self.scope.visible[at][name]], TIGHT)
            case Not(arg=arg):
                return Text(f"not {self.text(arg, at).at(TIGHT)}")
            case Chain(operator=operator, args=args):
                return Text(f" {operator} ".join(self.text(a, at).at(COMPARED) for a in args))
            case Binary(operator=operator) if operator in COMPARISONS:
                return self._comparison(expr, at)
            case Binary(operator="implies", left=left, right=right):
                texts = [self.text(x, at).at(COMPARED) for x in (left, right)]
                return Text(" implies ".join(texts))
            case Binary(operator="iff" | "xor"):
                return self._likeness(expr, at)
            case Temporal():
                return self._temporal(expr, at)
            case Pair():
                return self._pair(expr, at)
        return self._sign(expr, at)

    def _sign(self, expr: Expr, at: int) -> Text:
        """A number as a formula: it holds where the number isn't negative."""
        number = Numbers(self.scope, self.times, at).number(expr)
        named = isinstance(expr, Name)
        if not named and not self.scope.dialect.formulas_are_numbers:
            problem = "a number where a formula is needed"
            raise ImportFailure(
                DialectSyntax(span=expr.span, problem=problem, place="compare it with something")
            )
        return Text(f"{number.at(SUM)} >= 0", COMPARED)

    def _comparison(self, expr: Binary, at: int) -> Text:
        numbers = Numbers(self.scope, self.times, at)
        left, right = numbers.number(expr.left), numbers.number(expr.right)
        if expr.operator in ("==", "!=") and self.scope.dialect.discrete_equality:
            within = self._equal_within or self.scope.names.pick("equal_within")
            self._equal_within = within
            difference = left.text if right.text == "0" else f"{left.text} - {right.at(PRODUCT)}"
            relation = "<=" if expr.operator == "==" else ">="
            return Text(f"abs({difference}) {relation} {within}", COMPARED)
        return Text(f"{left.text} {expr.operator} {right.text}", COMPARED)

    def _likeness(self, expr: Binary, at: int) -> Text:
        """rtamt's iff and xor: -|p - q| and |p - q| of the robustness values."""
        if any(_is_temporal(x) for x in (expr.left, expr.right)):
            what = f"rtamt's `{expr.operator}` of temporal formulas"
            advice = (
                "rtamt measures |p - q| of the robustness values, which is no formula; write "
                "`(p -> q) and (q -> p)` if the logical meaning is meant"
            )
            raise ImportFailure(DialectUnsupported(span=expr.span, what=what, advice=advice))
        numbers = Numbers(self.scope, self.times, at)
        left, right = numbers.number(expr.left), numbers.number(expr.right)
        relation = "==" if expr.operator == "iff" else "!="
        return Text(f"{left.text} {relation} {right.text}", COMPARED)

    def _temporal(self, expr: Temporal, at: int) -> Text:
        interval = self.times.interval(expr.interval)
        return Text(f"{expr.operator}{interval} {self.text(expr.arg, at).at(TIGHT)}")

    # --- until, release, unless ------------------------------------------------------------

    def _pair(self, expr: Pair, at: int) -> Text:
        left = self.text(expr.left, at).at(TIGHT)
        right = self.text(expr.right, at).at(TIGHT)
        if expr.operator == "unless":
            return self._unless(expr, left, right)
        return self._until(expr.operator, left, expr.interval, right)

    def _unless(self, expr: Pair, left: str, right: str) -> Text:
        """left up to the end of the window, or until right: rtamt's definition."""
        within = ""
        if expr.interval is not None and expr.interval.end is not None:
            self.times.window(expr.interval)
            within = f"[0 s, {self.times.text(expr.interval.end, 0)}]"
        until = self._until("until", left, expr.interval, right)
        return Text(f"(always{within} {left}) or {until.at(COMPARED)}")

    def _until(self, operator: str, left: str, interval: Interval | None, right: str) -> Text:
        """With an open end, the left side lasts one step less than here.

        The window from 0 on: p until q = (p or q) until q, for the first q ends it. From a >= 1 on:
        p until[a, b] q = p until[a-1, b-1] next q. Both hold for robustness too, since they hold
        for the sets where it exceeds any level. Release is the dual.
        """
        window = (0, None) if interval is None else self.times.window(interval)
        if self.scope.dialect.open_until and window[0] > 0:
            return Text(f"{left} {operator}{self.times.interval(interval, 1)} (next {right})")
        if self.scope.dialect.open_until:
            left = f"({left} {'or' if operator == 'until' else 'and'} {right})"
        return Text(f"{left} {operator}{self.times.interval(interval)} {right}")


def _is_temporal(expr: Expr) -> bool:
    here = isinstance(expr, Pair) or (isinstance(expr, Temporal) and expr.operator != "next")
    return here or any(_is_temporal(child) for child in children(expr))
