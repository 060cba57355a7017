"""Bounds over parts of cell pairs, from expansions of mean and variance with their remainders."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.pairs import PairField
from stlc.radio.pathloss import path_loss_mean
from stlc.radio.taylor import (
    Ends,
    Expansion,
    distances,
    expand_gain,
    expand_path_loss,
    expand_rest,
)

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Interval = tuple[Array, Array]

SLACK = 1e-9
"""Added on both sides for rounding [dB, dB^2]."""

DECIDED = 2.0
"""Slack [dB] left to a bound that lies beyond the levels that matter, as its cell does."""


@dataclass(frozen=True, slots=True)
class Ask:
    """What is wanted: sigma with fading, of mean - z sigma, `spread` or not; how tight."""

    fading: bool
    z: float
    spread: bool
    tolerance: float
    focus: tuple[float, float]

    def loose(self, bound: Array, seen: Array, sign: float) -> NDArray[np.bool_]:
        """Where a lower (sign 1) or upper (-1) bound (K,) of the level is too far beyond the
        values seen in its cell (K,)."""
        below = (bound < self.focus[0]) & (seen < self.focus[0])
        above = (bound >= self.focus[1]) & (seen >= self.focus[1])
        allowed = np.where(below | above, max(DECIDED, self.tolerance), self.tolerance)
        return np.asarray(sign * (seen - bound) > allowed, dtype=np.bool_)


def sub_bounds(field: PairField, left: Ends, right: Ends, ask: Ask) -> list[Array]:
    """Mean, sigma and level intervals (lower, upper, ...) over pairs of boxes, and the level
    at their centres."""
    found = _without_walls(field, left, right, ask)
    walls = field.model.walls
    if walls is None:
        return found
    ends = [(box.centre - box.half, box.centre + box.half) for box in (left.boxes, right.boxes)]
    least, most = walls.bounds(*ends)
    at = walls.between(left.boxes.centre, right.boxes.centre)
    low, high, *sigma, level_low, level_high, centre = found
    return [low - most, high - least, *sigma, level_low - most, level_high - least, centre - at]


def _without_walls(field: PairField, left: Ends, right: Ends, ask: Ask) -> list[Array]:
    """`sub_bounds` of what walls leave as it is."""
    model = field.model
    near, at, far = distances(left.boxes, right.boxes)
    ends = (far, near) if model.exponent >= 0 else (near, far)
    low, high = (path_loss_mean(d, model.l0, model.exponent, model.d0) for d in ends)
    extra, z = model.own_variance(ask.fading), ask.z
    if not field.centres:
        sigma = np.full_like(near, np.sqrt(model.shadowing + extra))
        centre = path_loss_mean(at, model.l0, model.exponent, model.d0) - z * sigma
        low, high = low - SLACK, high + SLACK
        return [low, high, sigma, sigma, low - z * sigma, high - z * sigma, centre]
    overlap = [1.0 + np.exp(-((d / model.length) ** 2)) for d in (far, near, at)]
    scale = [1.0 / np.sqrt(g) for g in (overlap[1], overlap[0], overlap[2])]
    loss = expand_path_loss(model, left.boxes, right.boxes, near, at)
    gain = expand_gain(field, left, right, near)
    mean, drift = _mean_expansion(loss, gain, scale)
    crude = _product(gain.interval(), (scale[0], scale[1]))
    low = np.maximum(low + crude[0], mean.interval()[0] + drift[0]) - SLACK
    high = np.minimum(high + crude[1], mean.interval()[1] + drift[1]) + SLACK
    if not ask.spread:
        least = np.full_like(near, np.sqrt(extra))
        most = np.full_like(near, np.sqrt(model.shadowing + extra))
        return [low, high, least, most, low, high, mean.centre]
    rest = expand_rest(field, left, right, near, overlap)
    return _with_spread(model.shadowing, (low, high), mean, drift, rest, scale, extra, z)


def _with_spread(
    shadowing: float,
    ends: Interval,
    mean: Expansion,
    drift: Interval,
    rest: Expansion,
    scale: list[Array],
    extra: float,
    z: float,
) -> list[Array]:
    """What `sub_bounds` returns, for the level mean - z sigma.

    `ends` holds the mean; the level has its bound and the one that knows how mean and sigma vary
    together, whichever is tighter. `extra` is a single sample's own variance [dB^2].
    """
    low, high = ends
    least, most = _variance(shadowing, rest.interval(), scale)
    least, most = least + extra, most + extra
    level = _level(shadowing, mean, drift, rest, scale, (least, most, extra), z)
    spread = np.maximum(shadowing * scale[2] ** 2 * rest.centre, 0.0) + extra
    sigma_low, sigma_high = np.sqrt(least), np.sqrt(most)
    weak, strong = (sigma_high, sigma_low) if z >= 0 else (sigma_low, sigma_high)
    return [
        low,
        high,
        sigma_low,
        sigma_high,
        np.maximum(low - z * weak, level[0] - SLACK),
        np.minimum(high - z * strong, level[1] + SLACK),
        mean.centre - z * np.sqrt(spread),
    ]


def _product(a: Interval, b: Interval) -> Interval:
    """Interval product, b >= 0."""
    low = np.minimum(a[0] * b[0], a[0] * b[1])
    return low, np.maximum(a[1] * b[0], a[1] * b[1])


def _mean_expansion(
    loss: Expansion, gain: Expansion, scale: list[Array]
) -> tuple[Expansion, Interval]:
    """m + u0 S expanded, and the interval of (u - u0) S."""
    joint = loss.plus(gain.times(scale[2]))
    low, high = gain.interval()
    size = np.maximum(np.abs(low), np.abs(high))
    drift = np.maximum(scale[1] - scale[2], scale[2] - scale[0]) * size
    return joint, (-drift, drift)


def _level(
    shadowing: float,
    mean: Expansion,
    drift: Interval,
    rest: Expansion,
    scale: list[Array],
    spread: tuple[Array, Array, float],
    z: float,
) -> Interval:
    """Interval of mean - z sqrt(v), from one joint expansion."""
    least, most, extra = spread
    factor = shadowing * scale[2] ** 2
    v0 = np.maximum(factor * rest.centre, 0.0) + extra
    root = np.sqrt(np.maximum(v0, 1e-12))
    joint = mean.plus(rest.times(-z * factor / (2.0 * root)))
    top = np.maximum(rest.interval()[1], 0.0)
    squares = np.maximum(scale[1] ** 2 - scale[2] ** 2, scale[2] ** 2 - scale[0] ** 2)
    slip = abs(z) * shadowing * squares * top / (2.0 * root)
    bend = abs(z) * np.maximum(most - v0, v0 - least) ** 2 / (8.0 * np.maximum(least, 1e-9) ** 1.5)
    bend = np.where(np.minimum(least, v0) > 1e-6, bend, np.inf)
    base = -z * root + z * factor * rest.centre / (2.0 * root)
    low, high = joint.interval()
    # sqrt lies below its tangent: the curvature raises mean - z sqrt(v) for z > 0
    up, down = (bend, 0.0) if z >= 0 else (0.0, bend)
    return low + base + drift[0] - slip - down, high + base + drift[1] + slip + up


def _variance(shadowing: float, rest: Interval, scale: list[Array]) -> Interval:
    """Least and greatest posterior variance from the intervals of V and of u."""
    low = np.maximum(shadowing * np.maximum(rest[0], 0.0) * scale[0] ** 2 - SLACK, 0.0)
    high = np.clip(shadowing * rest[1] * scale[1] ** 2 + SLACK, 0.0, shadowing + SLACK)
    return np.minimum(low, high), high
