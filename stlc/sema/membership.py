"""`in` and `outside`: agents and points against regions, signals against intervals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np

from stlc.ir.claims import Membership
from stlc.ir.nodes import And, Const, Linear, Motion, Node, Or, Swept, Timed
from stlc.places import Polytope, Sweep
from stlc.record import changed
from stlc.sema.compare import at_least_zero
from stlc.sema.faces import Plane
from stlc.sema.heights import EVERY, Levels, kept_from
from stlc.sema.members import point
from stlc.sema.name_errors import NotNegatable, WrongKind
from stlc.sema.report import Mistake
from stlc.sema.scalars import add, scale
from stlc.sema.scope import Scope, as_scalar
from stlc.sema.shape_errors import NoSwept
from stlc.sema.space_errors import NotInSpace
from stlc.sema.swept import parts_of, sweep_part
from stlc.sema.units import METRE
from stlc.sema.values import Env, Items, Place, Radio, Scalar, Value, describe
from stlc.source import Span
from stlc.syntax import ast

_FACE = 4
"""Evaluations that a face of a place takes as long as, its checks later on included: some 25 us."""


def membership(expr: ast.Membership, env: Env, scope: Scope) -> Node:
    """`subject in place` or `subject outside place`, `swept` or at the steps."""
    subject, place = scope.value(expr.subject, env), scope.value(expr.place, env)
    if expr.swept and not env.positive:
        raise Mistake(NotNegatable(span=expr.span))
    node = _relate(subject, place, expr, scope)
    return replace(node, span=expr.span)


def _relate(subject: Value, place: Value, expr: ast.Membership, scope: Scope) -> Node:
    """`subject in place` over all points and places of lists; built once for equal questions."""
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
        if known.member is not None:
            scope.asked[known.member] = (subject, place, expr)
    return known


def swept_membership(claim: Membership, scope: Scope) -> Node:
    """The `swept` form of a membership that the mission states at the steps."""
    subject, place, expr = scope.asked[claim]
    return _relate(subject, place, changed(expr, swept=True), scope)


def opposite(claim: Membership, scope: Scope) -> Node:
    """`outside` for an `in` that the mission states at the steps, and the other way round."""
    subject, place, expr = scope.asked[claim]
    relation = "outside" if expr.relation == "in" else "in"
    return _relate(subject, place, changed(expr, relation=relation), scope)


def _is_point(items: Items) -> bool:
    return len(items.items) in (2, 3) and all(isinstance(i, Scalar) for i in items.items)


def _against(subject: Value, place: Place, expr: ast.Membership, scope: Scope) -> Node:
    """One point or number pair against one place, with the claim that the verifier judges."""
    where = point(subject, expr.subject.span)
    if len(where) == 2 and place.heights is not None:
        problem = f"this point has no height, and {describe(place)} has"
        hint = f"write a third coordinate: `{expr.subject.span.text.rstrip(')')}, 0 m)`"
        raise Mistake(NotInSpace(span=expr.subject.span, problem=problem, hint=hint))
    sweeps, inside = _sweeps(place, expr), expr.relation == "in"
    levels = place.heights or EVERY
    if not inside and isinstance(subject, Radio):
        levels = kept_from(levels, subject.thing)
    node = keep(where, sweeps, inside, expr.swept, scope, expr.span, levels)
    if not expr.swept:
        who = subject.name if isinstance(subject, Radio) else _coordinates(where, expr.span)
        claim = None if who is None else Membership(inside, who, place.shape.name)
        return replace(node, member=claim)
    if isinstance(subject, Radio):
        motion = Motion.INSIDE if inside else Motion.OUTSIDE
        return replace(node, swept=Swept(motion, subject.name, place=place.shape.name))
    if len(sweeps) > 1:
        return node  # of what moves, claims speak of agents alone
    still = keep(where, sweeps, inside, False, scope, expr.span, levels)
    return replace(node, swept=Swept(Motion.CONDITION, condition=still))


def _coordinates(where: tuple[Scalar, ...], span: Span) -> tuple[Linear, ...] | None:
    """A point's coordinates as linear forms of signals; None where they are no such."""
    nodes = [at_least_zero(s, span, positive=True) for s in where]
    linear = tuple(node for node in nodes if isinstance(node, Linear))
    return linear if len(linear) == len(nodes) else None


def _sweeps(place: Place, expr: ast.Membership) -> tuple[Sweep, ...]:
    """Pieces to be in or out of at each step, and how they move to the next if that counts."""
    if expr.relation == "outside":
        still = tuple(Sweep(pieces) for pieces in place.barriers)
        return place.sweeps if expr.swept else still
    frames = place.frames
    if not expr.swept or len(frames) == 1:
        return tuple(Sweep(pieces) for pieces in frames)
    moves = [_whole_move(place, t) for t in range(len(frames))]
    if None in moves:
        problem = "the obstacle changes its shape from step to step"
        raise Mistake(NoSwept(span=expr.place.span, problem=problem))
    return tuple(Sweep(p, m or (0.0, 0.0)) for p, m in zip(frames, moves, strict=True))


def _whole_move(place: Place, step: int) -> tuple[float, float] | None:
    """How all pieces move from a step to the next, None if they don't move alike."""
    frames = place.frames
    if step == len(frames) - 1:
        return (0.0, 0.0)
    now, then = (np.vstack([p.vertices for p in frames[t]]) for t in (step, step + 1))
    if now.shape != then.shape or np.ptp(then - now, axis=0).max() > 1e-9:
        return None
    return float((then - now)[0, 0]), float((then - now)[0, 1])


def keep(
    where: tuple[Scalar, ...],
    sweeps: Sequence[Sweep],
    inside: bool,
    swept: bool,
    scope: Scope,
    span: Span,
    levels: Levels = EVERY,
) -> Node:
    """Be within one of the pieces, or out of all, at each step or (`swept`) until the next.

    Pieces lie between `levels` of height [m].
    """
    join = Or if inside else And
    plane = Plane.of(where, span)
    cases: list[Node] = []
    for stay in sweeps:
        if not swept:
            scope.spend(_FACE * sum(len(piece.offsets) for piece in stay.pieces), span)
        parts = tuple(
            half_spaces(
                where,
                piece,
                inside,
                span,
                _Motion(stay.move, scope) if swept else None,
                levels,
                plane,
            )
            for piece in stay.pieces
        )
        if not parts:
            cases.append(Const(True, span=span))
            continue
        cases.append(parts[0] if len(parts) == 1 else join(parts, span=span))
    return cases[0] if len(cases) == 1 else Timed(tuple(cases), span=span)


@dataclass(frozen=True, slots=True)
class _Motion:
    """A condition that holds until the next step, while what it speaks of moves [m]."""

    move: tuple[float, float]
    scope: Scope


def half_spaces(
    where: tuple[Scalar, ...],
    piece: Polytope,
    inside: bool,
    span: Span,
    motion: _Motion | None = None,
    levels: Levels = EVERY,
    plane: Plane | None = None,
) -> Node:
    """Inside: on the inner side of every face. Outside: on the outer side of some face.

    Faces are those of a prism over the piece, between `levels` where they are finite [m]. `plane`
    is what `where` is of the plane, if it is known already.
    """
    plane = plane or Plane.of(where, span)
    sign = 1.0 if inside else -1.0
    faces = [
        plane.at_least_zero(-sign * nx, -sign * ny, sign * offset)
        for (nx, ny), offset in zip(piece.normals.tolist(), piece.offsets.tolist(), strict=True)
    ]
    for end, up in zip(levels, (sign, -sign), strict=True):
        if isfinite(end):
            beyond = add(scale(where[2], up, METRE), Scalar(-up * end, unit=METRE), span)
            faces.append(at_least_zero(beyond, span, positive=True))
    join = And if inside else Or
    if motion is None:
        return join(tuple(faces), span=span)
    changes = [sign * float(normal @ motion.move) for normal in piece.normals]
    changes += [0.0] * (len(faces) - len(changes))
    return _until_next(join, faces, changes, motion.scope, span)


def _until_next(
    join: type[And] | type[Or],
    faces: Sequence[Node],
    changes: Sequence[float],
    scope: Scope,
    span: Span,
) -> Node:
    """Faces that grow by `changes` until the next step, joined anew in each part of it."""
    count = max(parts_of(face, scope, span) for face in faces)
    parts = []
    for k in range(count):
        swept = (
            sweep_part(face, (k, count), scope, span, change)
            for face, change in zip(faces, changes, strict=True)
        )
        parts.append(join(tuple(swept), span=span))
        scope.spend(_FACE * sum(len(face.children) for face in parts[-1].children), span)
    return parts[0] if count == 1 else And(tuple(parts), span=span)


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
