"""Bounds of agents: `control |u| <= 1`, `speed <= 2 polygon 8`, `px in [0, 10]`."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, pi
from typing import Literal

import numpy as np

from stlc.dynamics import Dynamics
from stlc.mission import Array, NormBound, PolygonKind
from stlc.sema import props
from stlc.sema.members import unit_of
from stlc.sema.name_errors import WrongKind
from stlc.sema.report import Mistake
from stlc.sema.scope import EMPTY, Scope, as_scalar, wrong_unit
from stlc.sema.shape_errors import EmptyBound
from stlc.sema.units import NEWTON, Unit
from stlc.sema.values import Env, Items
from stlc.sema.warnings import OuterPolygon
from stlc.source import Span
from stlc.syntax import ast

DEFAULT_SIDES = 16
MOST_SIDES = 360

Kind = Literal["state", "input"]
ALIASES = {"u": "input", "control": "input", "input": "input", "state": "state"}
SPEED_NAMES = ("v", "velocity", "speed")
PLACE_NAMES = ("p", "position")


@dataclass(frozen=True, slots=True)
class Target:
    """What is bounded: indices of states or inputs."""

    kind: Kind
    indices: tuple[int, ...]
    magnitude: bool  # written |..|, or a norm by name: both signs are meant


@dataclass(slots=True)
class Bounds:
    """Bounds that grow tighter with every property."""

    dynamics: Dynamics
    mass: float
    env: Env = EMPTY  # what the limits may use: the number of a family's member
    state_lower: Array = field(init=False)
    state_upper: Array = field(init=False)
    input_lower: Array = field(init=False)
    input_upper: Array = field(init=False)
    state_norms: list[NormBound] = field(default_factory=list)
    input_norms: list[NormBound] = field(default_factory=list)

    def __post_init__(self) -> None:
        n, m = self.dynamics.B.shape
        self.state_lower, self.state_upper = np.full(n, -np.inf), np.full(n, np.inf)
        self.input_lower, self.input_upper = np.full(m, -np.inf), np.full(m, np.inf)

    def tighten(self, target: Target, low: float, high: float, span: Span) -> None:
        """Intersect with [low, high]. Raises Mistake when nothing is left."""
        state = target.kind == "state"
        lower = self.state_lower if state else self.input_lower
        upper = self.state_upper if state else self.input_upper
        at = list(target.indices)
        least, most = np.maximum(lower[at], low), np.minimum(upper[at], high)
        if (least > most).any():
            k = int(np.argmax(least > most))
            raise Mistake(EmptyBound(span=span, problem=f"from {least[k]:g} to {most[k]:g}"))
        lower[at], upper[at] = least, most


def apply(item: ast.Property, bounds: Bounds, scope: Scope) -> None:
    """Add the bound that a property states. Raises Mistake."""
    usage = usage_of(item.key.text)
    if not item.args:
        raise props.bad(item, "needs a bound", usage)
    first, words = item.args[0], item.args[1:]
    if isinstance(first, ast.Membership):
        _interval(item, first, bounds, scope)
    elif isinstance(first, ast.Comparison):
        _comparison(item, first, words, bounds, scope)
    elif not words:
        _limit(item, first, bounds, scope)
    else:
        raise props.bad(item, "is not a bound", usage)


def usage_of(key: str) -> str:
    """An example of the bound."""
    return {"control": "control |u| <= 1", "speed": "speed <= 2", "state": "state |v| <= 2"}.get(
        key, f"{key} in [0, 10]"
    )


def _limit(item: ast.Property, expr: ast.Expr, bounds: Bounds, scope: Scope) -> None:
    """`speed 2` means `speed <= 2`."""
    key = item.key.text
    if key not in ("control", "speed"):
        raise props.bad(item, "is not a bound", usage_of(key))
    name = ast.Name(item.key.span, key)
    _comparison(item, ast.Comparison(item.span, (name, expr), ("<=",)), (), bounds, scope)


def _interval(item: ast.Property, expr: ast.Membership, bounds: Bounds, scope: Scope) -> None:
    target = _target(expr.subject, bounds.dynamics)
    value = scope.value(expr.place, bounds.env)
    if target is None or not isinstance(value, Items) or len(value.items) != 2:
        raise props.bad(item, "is not a bound", usage_of(item.key.text))
    ends = [as_scalar(v, expr.place.span) for v in value.items]
    low, high = (_converted(s.constant, s.unit, target, bounds, expr.place.span) for s in ends)
    bounds.tighten(target, low, high, expr.span)


def _comparison(
    item: ast.Property,
    expr: ast.Comparison,
    words: tuple[ast.Expr, ...],
    bounds: Bounds,
    scope: Scope,
) -> None:
    """A chain such as `-1 <= u <= 2`: exactly one operand is bounded. Of `speed <= speed`, with a
    parameter of that name, the first."""
    targets = [_target(e, bounds.dynamics) for e in expr.operands]
    where = [k for k, t in enumerate(targets) if t is not None]
    if len(where) > 1:
        where = [k for k in where if not _is_parameter(expr.operands[k], scope)] or where[:1]
    if item.key.text == "speed" and not where:
        raise props.bad(item, "needs dynamics that name their velocity", "velocity vx vy")
    if len(where) != 1 or any(o in ("==", "!=") for o in expr.operators):
        raise props.bad(item, "must compare one state or input with constants", usage_of("state"))
    target = targets[where[0]]
    assert target is not None
    low, high = -np.inf, np.inf
    for k, operator in enumerate(expr.operators):
        other = expr.operands[k if k != where[0] else k + 1]
        scalar = scope.constant(other, bounds.env)
        limit = _converted(scalar.constant, scalar.unit, target, bounds, other.span)
        if (k >= where[0]) == (operator in ("<", "<=")):
            high = min(high, limit)
        else:
            low = max(low, limit)
    _add(item, expr, target, (low, high), words, bounds, scope)


def _is_parameter(expr: ast.Expr, scope: Scope) -> bool:
    name = expr.text if isinstance(expr, ast.Name) else ""
    return isinstance(scope.declarations.get(name), ast.Param)


def _add(
    item: ast.Property,
    expr: ast.Comparison,
    target: Target,
    ends: tuple[float, float],
    words: tuple[ast.Expr, ...],
    bounds: Bounds,
    scope: Scope,
) -> None:
    """Draws `bounds` in to [low, high], in SI units; speeds and lengths of vectors become norms."""
    low, high = ends
    if target.magnitude:
        if high < 0:
            hint = "a magnitude is never negative"
            raise Mistake(EmptyBound(span=expr.span, problem=f"at most {high:g}", hint=hint))
        if high == np.inf or low > 0:
            raise props.bad(item, "of a magnitude needs an upper limit", usage_of("speed"))
        low = -high
    bounded = next(e for e in expr.operands if _target(e, bounds.dynamics) is not None)
    named_speed = isinstance(bounded, ast.Name) and bounded.text in SPEED_NAMES
    if words or named_speed:
        _norm(item, target, high, words, bounds, scope)
    else:
        bounds.tighten(target, low, high, expr.span)


def _norm(
    item: ast.Property,
    target: Target,
    limit: float,
    words: tuple[ast.Expr, ...],
    bounds: Bounds,
    scope: Scope,
) -> None:
    """A Euclidean norm, as a polygon."""
    if len(target.indices) not in (2, 3) or not np.isfinite(limit):
        problem = "of a polygon needs two components, or three"
        raise props.bad(item, problem, "speed <= 2 polygon 16")
    sides, kind = _polygon(item, words, scope)
    if kind is PolygonKind.OUTER and len(target.indices) == 3:
        raise props.bad(item, "`outer` is of two components", "speed <= 2 polygon 16")
    if kind is PolygonKind.OUTER:
        excess = 100.0 * (1.0 / cos(pi / sides) - 1.0)
        scope.report.add(OuterPolygon(span=item.span, excess=excess, sides=sides))
    bound = NormBound(target.indices, limit, sides, kind, item.span)
    (bounds.state_norms if target.kind == "state" else bounds.input_norms).append(bound)


def _polygon(
    item: ast.Property, words: tuple[ast.Expr, ...], scope: Scope
) -> tuple[int, PolygonKind]:
    """Number of sides and kind of a norm's polygon from the words behind a bound."""
    sides, kind = DEFAULT_SIDES, PolygonKind.INSCRIBED
    rest = list(words)
    while rest:
        head = rest.pop(0)
        text = head.text if isinstance(head, ast.Name) else None
        if text == "polygon" and rest:
            sides = scope.whole(rest.pop(0))
        elif text in ("outer", "inscribed"):
            kind = PolygonKind(text)
        else:
            raise props.bad(item, "has an unknown word", "speed <= 2 polygon 16", head.span)
    if not 3 <= sides <= MOST_SIDES:
        raise props.bad(item, f"can't have {sides} sides", "speed <= 2 polygon 16")
    return sides, kind


def _target(expr: ast.Expr, dynamics: Dynamics) -> Target | None:
    """What an operand names, or None for a constant."""
    if isinstance(expr, ast.Absolute):
        inner = _target(expr.arg, dynamics)
        return None if inner is None else Target(inner.kind, inner.indices, True)
    if isinstance(expr, ast.Index) and len(expr.indices) == 1:
        inner = _target(expr.base, dynamics)
        number = expr.indices[0]
        if inner is None or not isinstance(number, ast.Number):
            return None
        at = int(number.value)
        if not 0 <= at < len(inner.indices):
            expected = f"an index below {len(inner.indices)}"
            raise Mistake(WrongKind(span=number.span, expected=expected, found=number.text))
        return Target(inner.kind, (inner.indices[at],), False)
    return _named(expr.text, dynamics) if isinstance(expr, ast.Name) else None


def _named(text: str, dynamics: Dynamics) -> Target | None:
    """What a name bounds: one state or input, a speed, a place, all inputs or states; else None."""
    if text in dynamics.states:
        return Target("state", (dynamics.states.index(text),), False)
    if text in dynamics.inputs:
        return Target("input", (dynamics.inputs.index(text),), False)
    if text in SPEED_NAMES and dynamics.velocity is not None:
        return Target("state", dynamics.velocity, text == "speed")
    moved = "single_integrator" in dynamics.name or dynamics.robot is not None
    if text == "speed" and moved and dynamics.velocity is None:
        return Target("input", tuple(range(len(dynamics.inputs))), True)
    if text in PLACE_NAMES and dynamics.position is not None:
        return Target("state", tuple(int(np.argmax(r)) for r in dynamics.axes), False)
    match ALIASES.get(text):
        case "input":
            return Target("input", tuple(range(len(dynamics.inputs))), text == "control")
        case "state":
            return Target("state", tuple(range(len(dynamics.states))), False)
    return None


def _converted(
    value: float, unit: Unit | None, target: Target, bounds: Bounds, span: Span
) -> float:
    """A limit in the unit of what it limits; a force is divided by the mass."""
    dynamics = bounds.dynamics
    units = dynamics.state_units if target.kind == "state" else dynamics.input_units
    expected = unit_of(units[target.indices[0]])
    if unit is None or expected is None or unit == expected:
        return value
    if unit == NEWTON and target.kind == "input":
        return value / bounds.mass
    raise Mistake(wrong_unit(span, expected, unit))
