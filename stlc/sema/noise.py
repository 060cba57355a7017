"""`start_noise` and `control_noise`: what a run may be off by, for `stlc simulate`."""

from __future__ import annotations

import numpy as np

from stlc.dynamics import Dynamics
from stlc.mission import Array
from stlc.sema import props
from stlc.sema.members import unit_of
from stlc.sema.scope import Scope
from stlc.sema.units import METRE, Unit
from stlc.sema.values import Env, Scalar
from stlc.syntax import ast


def of_start(item: ast.Property | None, base: Dynamics, env: Env, scope: Scope) -> Array | None:
    """Standard deviations (n,) of the start: of the whole state, of a position, the rest being
    exact, or one number for each coordinate of the position. Raises Mistake."""
    if item is None:
        return None
    usage = "start_noise 0.1 m" if base.position is not None else "start_noise (0.1, 0.1)"
    axes = _axes(base)
    given = _given(item, usage, [unit_of(u) for u in base.state_units], axes, env, scope)
    if len(given) == len(base.states):
        return given
    full = np.zeros(len(base.states))
    full[axes] = given
    return full


def of_inputs(item: ast.Property | None, base: Dynamics, env: Env, scope: Scope) -> Array | None:
    """Standard deviations (m,) of each step's inputs: one number for all, or one for each.
    Raises Mistake."""
    if item is None:
        return None
    units = [unit_of(u) for u in base.input_units]
    return _given(item, "control_noise 0.1", units, list(range(len(units))), env, scope)


def _axes(base: Dynamics) -> list[int]:
    """States that are coordinates of the position."""
    return [int(np.argmax(row)) for row in base.axes]


def _given(
    item: ast.Property, usage: str, units: list[Unit | None], one: list[int], env: Env, scope: Scope
) -> Array:
    """The numbers of a property: one for each of `units`, or one for each of the entries `one`,
    which a single number stands for. Raises Mistake."""
    return size_of(item, props.only(item, usage), units, one, env, scope, usage)


def size_of(
    item: ast.Property,
    expr: ast.Expr,
    units: list[Unit | None],
    one: list[int],
    env: Env,
    scope: Scope,
    usage: str,
) -> Array:
    """The numbers of an expression, none below 0, as `_given`. Raises Mistake."""
    value = scope.value(expr, env)
    if isinstance(value, Scalar) and one:
        width = units[one[0]] if len({units[k] for k in one}) == 1 else None
        size = np.full(len(one), props.numbers(expr, scope, [width], env)[0])
    else:
        count = len(getattr(value, "items", ()))
        short = count == len(one) < len(units)
        size = props.numbers(expr, scope, [METRE] * count if short else units, env)
    if (size < 0).any():
        raise props.bad(item, "is not below 0", usage)
    return size
