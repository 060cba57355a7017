"""`delivered(a, base)[2, 8] >= 20 Mbit`: what a link carries over steps, by rates at its SNR.

With rates r_1 < r_2 < .. from the levels s_1 < s_2 < .. on, a step of length h carries

    h sum_k (r_k - r_{k-1}) [snr >= s_k],

and all these amounts are whole multiples of one amount q. So the comparison counts how many of the
predicates `snr >= s_k` hold over the steps, each as often as its amount is a multiple of q: it is a
`Count`, whose robustness is by how much the SNR of all steps could be lower [dB].
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import reduce
from math import gcd

from stlc.ir.networks import Count
from stlc.ir.nodes import Const, Link, Node, Not, Quantity, Relation
from stlc.sema import clock, link_calls
from stlc.sema.channel_errors import BadChannel, BadLink
from stlc.sema.compare import MIRRORED, Operator
from stlc.sema.name_errors import TooLarge, WrongKind
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope, as_scalar
from stlc.sema.time_errors import ReversedInterval
from stlc.sema.unit_errors import WrongUnit
from stlc.sema.units import BIT
from stlc.sema.values import Delivery, Env, Scalar, Value, describe
from stlc.source import Span
from stlc.syntax import ast

MOST_PARTS = 20_000
"""Predicates that one comparison may count, each as often as it weighs."""

_ROUND = 1e-9  # of the amount asked for: rates are decimal numbers, their products are not


def delivered(expr: ast.Call, args: tuple[Value, ...], scope: Scope) -> Value:
    """`delivered(a, b)`, a channel may be named third. Raises Mistake."""
    link = link_calls.quality_of(expr, args, Quantity.SNR, scope)
    channel = scope.channels[link.channel]
    if channel.budget is None or not channel.budget.rates:
        raise Mistake(
            BadChannel(
                span=expr.span, channel=channel.name, problem="`delivered` needs its rates",
                hint="add `rates (5 dB, 1 Mbit/s) (15 dB, 6 Mbit/s)`",
            )
        )  # fmt: skip
    return Delivery(link.channel, (link.sender, link.receiver))


def windowed(base: Delivery, expr: ast.Index, env: Env, scope: Scope) -> Delivery:
    """`delivered(a, b)[2, 8]`: over these steps."""
    if len(expr.indices) != 2 or base.window is not None:
        hint = "write `delivered(a, b)[2, 8]`"
        raise Mistake(BadLink(span=expr.span, problem="a window has two ends", hint=hint))
    start, end = (clock.steps(e, scope, env) for e in expr.indices)
    if end < start:
        raise Mistake(ReversedInterval(span=expr.span, start=start, end=end))
    return replace(base, window=(start, end))


def compare_delivery(
    left: Value, operator: Operator, right: Value, spans: tuple[Span, Span], scope: Scope
) -> Node:
    """An amount against a constant one; less is the negation of more. Raises Mistake."""
    if not isinstance(left, Delivery):
        left, operator, right, spans = right, MIRRORED[operator], left, (spans[1], spans[0])
    assert isinstance(left, Delivery)
    if operator in ("==", "!="):
        problem = "an amount is compared by `>=` or `<=` with a constant"
        raise Mistake(BadLink(span=spans[0], problem=problem))
    limit, whole = _amount(right, spans[1]), spans[0].to(spans[1])
    args, unit = _parts(left, whole, scope)
    share = limit / float(unit)
    slack = _ROUND * max(1.0, abs(share))
    if operator in (">", ">="):
        return _at_least(args, -int(-(share - slack) // 1), whole)
    return Not(_at_least(args, int((share + slack) // 1) + 1, whole), span=whole)


def _amount(value: Value, span: Span) -> float:
    """A constant amount [bit]."""
    if isinstance(value, Delivery):
        raise Mistake(WrongKind(span=span, expected="an amount", found=describe(value)))
    scalar: Scalar = as_scalar(value, span)
    if not scalar.is_constant:
        raise Mistake(WrongKind(span=span, expected="a constant amount", found=describe(value)))
    if scalar.unit not in (None, BIT):
        raise Mistake(WrongUnit(span=span, expected="an amount in bit", found=str(scalar.unit)))
    return scalar.constant


def _at_least(args: tuple[Node, ...], least: int, span: Span) -> Node:
    if least <= 0 or least > len(args):
        return Const(least <= 0, span=span)
    return Count(args, least, span=span)


def _parts(what: Delivery, span: Span, scope: Scope) -> tuple[tuple[Node, ...], Fraction]:
    """The predicates, each as often as it weighs, and the amount [bit] that each stands for."""
    budget = scope.channels[what.channel].budget
    assert budget is not None
    length = Fraction(scope.step).limit_denominator(10**6)
    rates = [Fraction(speed).limit_denominator(1000) for _, speed in budget.rates]
    amounts = [length * (b - a) for a, b in zip([Fraction(0), *rates], rates, strict=False)]
    unit = reduce(_common, amounts)
    first, last = _window(what, span, scope)
    count = int(sum(amounts) / unit) * (last - first + 1)
    if count > MOST_PARTS:
        size = f"{count:.3g} times the largest amount that all rates are multiples of"
        hint = "round the rates, or give a shorter window"
        raise Mistake(TooLarge(span=span, size=size, hint=hint))
    link = Link(what.channel, Quantity.SNR, *what.ends, Relation.AT_LEAST, 0.0, span=span)
    return tuple(
        part
        for step in range(first, last + 1)
        for (level, _), amount in zip(budget.rates, amounts, strict=True)
        for part in (replace(link, threshold=level, shift=step),) * int(amount / unit)
    ), unit


def _common(a: Fraction, b: Fraction) -> Fraction:
    """The largest amount that both are whole multiples of."""
    top = gcd(a.numerator * b.denominator, b.numerator * a.denominator)
    return Fraction(top, a.denominator * b.denominator)


def _window(what: Delivery, span: Span, scope: Scope) -> tuple[int, int]:
    if what.window is not None:
        return what.window
    if scope.given_horizon is None:
        problem = "nothing says over which steps"
        hint = "give a window, `delivered(a, b)[0, 8]`, or a `horizon`"
        raise Mistake(BadLink(span=span, problem=problem, hint=hint))
    return 0, scope.given_horizon
