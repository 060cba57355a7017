"""Formulas: comparisons, logic, time and quantifiers, as IR nodes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import replace

from stlc.diagnostics import Diagnostic, Fix
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Iff,
    Implies,
    Node,
    Not,
    Or,
    Release,
    Until,
)
from stlc.record import changed
from stlc.sema import clock, link_calls, networks
from stlc.sema.between import between_steps
from stlc.sema.compare import Operator, at_least_zero, compare, is_condition, is_integer
from stlc.sema.deliveries import compare_delivery
from stlc.sema.membership import membership
from stlc.sema.name_errors import NotNegatable, WrongKind
from stlc.sema.quantifiers import instances
from stlc.sema.report import Mistake, Reported
from stlc.sema.scalars import absolute, add
from stlc.sema.scope import Scope, as_scalar
from stlc.sema.signals import ByTheClock, timed
from stlc.sema.space_errors import NotInSpace
from stlc.sema.unit_errors import LevelAgainstRatio
from stlc.sema.values import (
    Chance,
    Delivery,
    Env,
    Items,
    Place,
    Radio,
    Scalar,
    Separation,
    Tally,
    Value,
)
from stlc.sema.warnings import EmptyInequality
from stlc.source import Span
from stlc.syntax import ast

_PIECE = 4  # evaluations that take as long as one linear piece of a comparison


def formula(expr: ast.Expr, env: Env, scope: Scope) -> Node:
    """The formula that an expression of logical form means."""
    match expr:
        case ast.Comparison():
            return comparison(expr, env, scope)
        case ast.Membership():
            return membership(expr, env, scope)
        case ast.Swept():
            if not env.positive:
                raise Mistake(NotNegatable(span=expr.span))
            return between_steps(scope.formula(expr.arg, env), scope, expr.span)
        case ast.Not():
            return Not(scope.formula(expr.arg, flipped(env)), span=expr.span)
        case ast.Logical():
            return logical(expr, env, scope)
        case ast.Temporal():
            return temporal(expr, env, scope)
        case ast.TemporalPair():
            start, end = clock.interval(expr.interval, scope, env)
            kind = Until if expr.operator == "until" else Release
            left, right = gather((expr.left, expr.right), env, scope)
            return kind(left, right, start, end, span=expr.span)
        case ast.Quantifier():
            return quantifier(expr, env, scope)
    raise Mistake(WrongKind(span=expr.span, expected="a formula", found="something else"))


def flipped(env: Env) -> Env:
    """The same names under a negation."""
    return replace(env, positive=not env.positive)


def gather(
    exprs: Iterable[ast.Expr],
    env: Env,
    scope: Scope,
    meaning: Callable[[ast.Expr, Env, Scope], Node] | None = None,
) -> tuple[Node, ...]:
    """Each formula; the mistakes of all are reported before going on."""
    meaning = meaning or (lambda expr, env, scope: scope.formula(expr, env))
    nodes: list[Node] = []
    failed = False
    for expr in exprs:
        try:
            nodes.append(meaning(expr, env, scope))
        except Mistake as mistake:
            scope.report.add(mistake.diagnostic)
            failed = True
        except Reported:
            failed = True
    if failed:
        raise Reported
    return tuple(nodes)


def logical(expr: ast.Logical, env: Env, scope: Scope) -> Node:
    """and, or, implies, iff."""
    match expr.operator:
        case "and":
            return And(gather(expr.args, env, scope), span=expr.span)
        case "or":
            return Or(gather(expr.args, env, scope), span=expr.span)
        case "implies":
            left = gather(expr.args[:1], flipped(env), scope)
            right = gather(expr.args[1:], env, scope)
            return Implies(left[0], right[0], span=expr.span)
        case "iff":
            return iff(expr, env, scope)


def iff(expr: ast.Logical, env: Env, scope: Scope) -> Node:
    """Both directions; spelt out when the two polarities differ (a distance is involved)."""
    left, right = gather(expr.args, env, scope, _side)
    under_left, under_right = gather(expr.args, flipped(env), scope, _side)
    if (left, right) == (under_left, under_right):
        return Iff(left, right, span=expr.span)
    there = Implies(under_left, right, span=expr.span)
    back = Implies(under_right, left, span=expr.span)
    return And((there, back), span=expr.span)


def _side(expr: ast.Expr, env: Env, scope: Scope) -> Node:
    """A side of an `iff`, kept for each polarity: both are asked for by each `iff` around it."""
    key = ("side", id(expr), tuple(env.bound.items()), env.positive, env.margin)
    known = scope.known(key)
    if isinstance(known, Node):
        return known
    with scope.expanded(key):
        node = scope.memo[key] = scope.formula(expr, env)
    return node


def temporal(expr: ast.Temporal, env: Env, scope: Scope) -> Node:
    """always, eventually, next."""
    if expr.operator == "next":
        start = clock.interval(expr.interval, scope, env)[0] if expr.interval else 1
        return Always(scope.formula(expr.arg, env), start, start, span=expr.span)
    kind = Always if expr.operator == "always" else Eventually
    if clock.is_last(expr.interval, env, scope):
        body = Always(scope.formula(expr.arg, env), 0, None, span=expr.span)
        return Eventually(body, 0, None, span=expr.span)
    try:
        start, end = clock.interval(expr.interval, scope, env)
    except Mistake as mistake:
        scope.report.add(mistake.diagnostic)
        scope.formula(expr.arg, env)
        raise Reported from None
    return kind(scope.formula(expr.arg, env), start, end, span=expr.span)


def quantifier(expr: ast.Quantifier, env: Env, scope: Scope) -> Node:
    """forall: a conjunction; exists: a disjunction over the domain."""
    parts = [scope.formula(expr.body, inner) for inner in instances(expr, env, scope)]
    if len(parts) == 1:
        return parts[0]
    kind = And if expr.kind == "forall" else Or
    return kind(tuple(parts), span=expr.span)


# --- comparisons -------------------------------------------------------------------------------


def comparison(expr: ast.Comparison, env: Env, scope: Scope) -> Node:
    """One comparison, or a chain of which all must hold; known signals change it from step to
    step."""
    try:
        return _comparison(expr, env, scope)
    except ByTheClock:
        return timed(expr.span, env, scope, lambda at: _comparison(expr, at, scope))


def _comparison(expr: ast.Comparison, env: Env, scope: Scope) -> Node:
    values = [scope.value(e, env) for e in expr.operands]
    nodes = []
    for k, operator in enumerate(expr.operators):
        spans = (expr.operands[k].span, expr.operands[k + 1].span)
        span = expr.span if len(expr.operators) == 1 else spans[0].to(spans[1])
        nodes.append(_compare(values[k], operator, values[k + 1], spans, span, env, scope))
    return nodes[0] if len(nodes) == 1 else And(tuple(nodes), span=expr.span)


def _compare(
    left: Value,
    operator: Operator,
    right: Value,
    spans: tuple[Span, Span],
    span: Span,
    env: Env,
    scope: Scope,
) -> Node:
    """One comparison; places compare by identity, numbers once min and max are unfolded."""
    if isinstance(left, Chance) or isinstance(right, Chance):
        return link_calls.compare_chance(left, operator, right, spans, env.positive)
    if isinstance(left, Tally) or isinstance(right, Tally):
        return networks.compare_count(left, operator, right, spans, scope)
    if isinstance(left, Delivery) or isinstance(right, Delivery):
        return compare_delivery(left, operator, right, spans, scope)
    if isinstance(left, Separation) and isinstance(right, Items):
        return per_axis(left, operator, right, span, env)
    if isinstance(left, Radio | Place) and isinstance(right, Radio | Place):
        return _same_thing(left, operator, right, span)
    a, b = as_scalar(left, spans[0]), as_scalar(right, spans[1])
    if operator == "!=":
        return unequal(a, b, span, env, scope)
    try:
        node = compare(a, operator, b, span, env.positive)
        scope.work += _PIECE * len(node.children)
        return node
    except Mistake as mistake:
        raise Mistake(_level_advice(mistake.diagnostic, spans)) from None


def _level_advice(diagnostic: Diagnostic, spans: tuple[Span, Span]) -> Diagnostic:
    """`rssi(a, b) >= -70 dB`: say that dBm is meant."""
    if not isinstance(diagnostic, LevelAgainstRatio):
        return diagnostic
    for place in spans:
        text = place.text.strip()
        if text.endswith("dB"):
            hint = f"did you mean `{text}m`?"
            return changed(diagnostic, hint=hint, fix=Fix(place, f"{text}m"))
    return diagnostic


def per_axis(left: Separation, operator: Operator, right: Items, span: Span, env: Env) -> Node:
    """`separation(a, b) >= (dx, dy)`: far apart along some axis; `<=`: close along all."""
    if len(right.items) == 2 < len(left.axes):
        raise Mistake(
            NotInSpace(
                span=span,
                problem="a separation in space has three axes",
                hint="write a distance for each: `separation(a, b) >= (1 m, 1 m, 2 m)`",
            )
        )
    if len(right.items) != len(left.axes) or operator in ("==", "!="):
        raise Mistake(
            WrongKind(span=span, expected="one distance, or one for each axis", found="this")
        )
    limits = [as_scalar(v, span) for v in right.items]
    parts = tuple(
        compare(absolute(axis, span), operator, limit, span, env.positive)
        for axis, limit in zip(left.axes, limits, strict=True)
    )
    return Or(parts, span=span) if operator in (">", ">=") else And(parts, span=span)


def _same_thing(left: Radio | Place, operator: Operator, right: Radio | Place, span: Span) -> Node:
    """`a != b` between things that quantifiers range over."""
    if operator not in ("==", "!="):
        raise Mistake(WrongKind(span=span, expected="numbers", found="two things"))
    return Const((left == right) == (operator == "=="), span=span)


def unequal(left: Scalar, right: Scalar, span: Span, env: Env, scope: Scope) -> Node:
    """|a - b| >= 1 for integers; otherwise |a - b| >= 0, which needs a margin to mean something."""
    if is_condition(left, right):
        return compare(left, "!=", right, span, env.positive)
    difference = add(left, right, span, sign=-1.0)
    integer = frozenset(n for n, a in scope.agents.items() if a.integer_inputs)
    if is_integer(difference, integer):
        apart = add(absolute(difference, span), Scalar(1.0), span, sign=-1.0)
        return at_least_zero(apart, span, env.positive)
    if env.margin <= 0.0:
        scope.report.add(EmptyInequality(span=span))
    return compare(left, "!=", right, span, env.positive)
