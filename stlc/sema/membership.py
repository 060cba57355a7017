"""`in` and `outside`: agents and points against regions, signals against intervals."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from stlc.ir.nodes import And, Motion, Node, Or, Swept, Timed
from stlc.mission import Polytope
from stlc.sema.compare import at_least_zero
from stlc.sema.members import point
from stlc.sema.name_errors import NotNegatable, WrongKind
from stlc.sema.report import Mistake
from stlc.sema.scalars import add, scale
from stlc.sema.scope import Scope, as_scalar
from stlc.sema.swept import sweep
from stlc.sema.units import METRE
from stlc.sema.values import Env, Items, Place, Radio, Scalar, Value, describe
from stlc.source import Span
from stlc.syntax import ast


def membership(expr: ast.Membership, env: Env, scope: Scope) -> Node:
    """`subject in place` or `subject outside place`, `swept` or at the steps."""
    subject, place = scope.value(expr.subject, env), scope.value(expr.place, env)
    if expr.swept and not env.positive:
        raise Mistake(NotNegatable(span=expr.span))
    node = _relate(subject, place, expr, scope)
    return replace(node, span=expr.span)


def _relate(subject: Value, place: Value, expr: ast.Membership, scope: Scope) -> Node:
    if isinstance(subject, Items) and not _is_point(subject):
        return And(tuple(_relate(s, place, expr, scope) for s in subject.items))
    if isinstance(subject, Scalar):
        return _in_interval(subject, place, expr)
    if isinstance(place, Items):
        join = Or if expr.relation == "in" else And
        return join(tuple(_relate(subject, p, expr, scope) for p in place.items))
    if not isinstance(place, Place):
        expected = "a region or an obstacle"
        raise Mistake(WrongKind(span=expr.place.span, expected=expected, found=describe(place)))
    key = ("member", subject, id(place.shape), expr.relation, expr.swept)
    known = scope.memo.get(key)
    if known is None:
        known = scope.memo[key] = _against(subject, place, expr, scope)
    return known


def _is_point(items: Items) -> bool:
    return len(items.items) == 2 and all(isinstance(i, Scalar) for i in items.items)


def _against(subject: Value, place: Place, expr: ast.Membership, scope: Scope) -> Node:
    where = point(subject, expr.subject.span)
    relate: Callable[[Polytope], Node] = lambda piece: half_planes(  # noqa: E731
        where, piece, expr.relation == "in", expr.span
    )
    join = Or if expr.relation == "in" else And
    cases = tuple(_pieces(frame, relate, join, expr.span) for frame in place.frames)
    node = cases[0] if len(cases) == 1 else Timed(cases, span=expr.span)
    if not expr.swept:
        return node
    return replace(sweep(node, scope, expr.span), swept=_claim(subject, place, expr))


def _claim(subject: Value, place: Place, expr: ast.Membership) -> Swept | None:
    """What the condition says of an agent's motion, for the verifier; None for other subjects."""
    if not isinstance(subject, Radio):
        return None
    motion = Motion.INSIDE if expr.relation == "in" else Motion.OUTSIDE
    return Swept(motion, subject.name, place=place.shape.name)


def _pieces(
    frame: tuple[Polytope, ...],
    relate: Callable[[Polytope], Node],
    join: type[And] | type[Or],
    span: Span,
) -> Node:
    nodes = tuple(relate(piece) for piece in frame)
    return nodes[0] if len(nodes) == 1 else join(nodes, span=span)


def half_planes(where: tuple[Scalar, Scalar], piece: Polytope, inside: bool, span: Span) -> Node:
    """Inside: on the inner side of every face. Outside: on the outer side of some face."""
    sign = 1.0 if inside else -1.0
    faces = []
    for (nx, ny), offset in zip(piece.normals, piece.offsets, strict=True):
        depth = add(
            scale(where[0], -sign * float(nx), METRE),
            scale(where[1], -sign * float(ny), METRE),
            span,
        )
        depth = add(depth, Scalar(sign * float(offset), unit=METRE), span)
        faces.append(at_least_zero(depth, span, positive=True))
    return And(tuple(faces), span=span) if inside else Or(tuple(faces), span=span)


def _in_interval(subject: Scalar, place: Value, expr: ast.Membership) -> Node:
    """`r1.vx in [0, 2]`."""
    if not isinstance(place, Items) or len(place.items) != 2:
        expected = "an interval `[low, high]`"
        raise Mistake(WrongKind(span=expr.place.span, expected=expected, found=describe(place)))
    low, high = (as_scalar(v, expr.place.span) for v in place.items)
    inside = expr.relation == "in"
    above = add(subject, low, expr.span, sign=-1.0)
    below = add(high, subject, expr.span, sign=-1.0)
    if inside:
        parts = tuple(at_least_zero(s, expr.span, True) for s in (above, below))
        return And(parts, span=expr.span)
    parts = tuple(at_least_zero(scale(s, -1.0, s.unit), expr.span, True) for s in (above, below))
    return Or(parts, span=expr.span)
