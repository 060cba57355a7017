"""Rigorous bounds of the posterior over closed cell pairs.

Cells are cut into s x s parts, s = 1, 2, 4, ... (only where the bounds are still loose) until
they are tight or the budget ends; over each pair of parts `stlc.radio.taylor` gives the mean
m + u S and the variance sigma_k^2 u^2 V as first-order expansions with rigorous remainders.
Sound for any s. The level mean - z sigma is expanded as a whole, with
    0 >= sqrt(v) - sqrt(v0) - (v - v0) / (2 sqrt(v0)) >= -(v - v0)^2 / (8 min(v)^(3/2)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError
from stlc.radio.gp import ChannelModel
from stlc.radio.kernel import KernelName
from stlc.radio.pairs import BLOCK_BYTES, PairField, predict_pair_mean, predict_pairs, prepare
from stlc.radio.pathloss import path_loss_mean
from stlc.radio.taylor import (
    Boxes,
    Ends,
    Expansion,
    distances,
    expand_gain,
    expand_path_loss,
    expand_rest,
    prepare_ends,
)

Array = NDArray[np.float64]
Interval = tuple[Array, Array]

SLACK = 1e-9
"""Added on both sides for rounding [dB, dB^2]."""

FINEST = 8
"""Most parts along an axis of a cell; its square towards a station."""


@dataclass(frozen=True, slots=True, eq=False)
class PairBounds:
    """Bounds over closed cell pairs, each an interval of (na, nb) arrays.

    mean [dBm]; sigma [dB] (fading included if asked for); level = mean - z sigma [dBm];
    gap [dB]: the largest distance between a bound of `level` and the values seen in its pair
    (an upper estimate of the slack); parts: how finely the loosest cells were cut.
    """

    mean: Interval
    sigma: Interval
    level: Interval
    gap: float
    parts: int


@dataclass(frozen=True, slots=True)
class _Ask:
    fading: bool
    z: float
    spread: bool


def pair_bounds(
    model: ChannelModel,
    a: Boxes,
    b: Boxes | None = None,
    *,
    fading: bool = True,
    z: float = 0.0,
    spread: bool = True,
    tolerance: float = 0.5,
    budget: float = 1e10,
) -> PairBounds:
    """Bounds for all pairs of boxes of `a` and `b` (b None: `a` with itself, half the work).

    spread=False leaves sigma at its prior bounds (z must be 0), which is much faster;
    tolerance [dB] on `level`; budget: most multiplications of one round (sub-pairs x M^2).
    Raises RadioError for `paper_min`, whose posterior variance obeys no such bound.
    """
    if model.kernel is not KernelName.SYMMETRISED:
        raise RadioError("kernel paper_min has no rigorous bounds: use bound = centre or mean")
    if z != 0.0 and not spread:
        raise RadioError("a level with z other than 0 needs the spread")
    field = prepare(model, a.centre.shape[1])
    other = a if b is None else b
    ask = _Ask(fading, z, spread)
    seen = _attained(model, a, other, ask)
    bounds = np.empty((6, len(a), len(other)))
    bounds[0::2], bounds[1::2] = -np.inf, np.inf
    loose = np.ones((len(a), len(other)), dtype=np.bool_)
    parts, last = 1, 1
    finest = FINEST if (other.half > 0).any() else FINEST**2
    while (
        loose.any()
        and parts <= finest
        and _work(field, a, other, loose, parts, b is None, spread) <= budget
    ):
        _refine(field, a, other, (bounds, *seen), loose, parts, b is None, ask)
        gap = np.maximum(seen[0] - bounds[4], bounds[5] - seen[1])
        loose = gap > tolerance
        parts, last = 2 * parts, parts
    if not np.isfinite(bounds).all():
        raise RadioError("the budget for channel bounds does not reach a single look at each pair")
    worst = float(gap.max(initial=0.0))
    pairs = [(bounds[k], bounds[k + 1]) for k in (0, 2, 4)]
    return PairBounds(pairs[0], pairs[1], pairs[2], worst, last)


def _attained(model: ChannelModel, a: Boxes, b: Boxes, ask: _Ask) -> tuple[Array, Array]:
    """Least and greatest level seen on a lattice of 3 points an axis in every box."""
    points_a, points_b = _lattice(a), _lattice(b)
    if ask.spread:
        mean, variance = predict_pairs(model, points_a, points_b, ask.fading)
        mean = mean - ask.z * np.sqrt(variance)
    else:
        mean = predict_pair_mean(model, points_a, points_b)
    level = mean.reshape(len(a), len(points_a) // len(a), len(b), len(points_b) // len(b))
    return _reduce(level, False), _reduce(level, True)


def _lattice(boxes: Boxes) -> Array:
    fine = Boxes(boxes.centre, 1.5 * boxes.half).subdivide(3)
    return fine.centre


def _work(
    field: PairField,
    a: Boxes,
    b: Boxes,
    loose: NDArray[np.bool_],
    parts: int,
    symmetric: bool,
    spread: bool,
) -> float:
    axes = int((a.half > 0).any(axis=0).sum() + (b.half > 0).any(axis=0).sum())
    pairs = float(loose.sum()) * float(parts) ** axes * (0.5 if symmetric else 1.0)
    return pairs * float(max(field.centres, 30)) ** (2 if spread else 1) * (1.0 if spread else 30.0)


def _refine(
    field: PairField,
    a: Boxes,
    b: Boxes,
    found: tuple[Array, Array, Array],
    loose: NDArray[np.bool_],
    parts: int,
    symmetric: bool,
    ask: _Ask,
) -> None:
    """Tighten bounds (6, na, nb) and the least and greatest level seen, in place where
    `loose`, with cells cut parts x parts."""
    bounds, seen_low, seen_high = found
    left = prepare_ends(field, a.subdivide(parts), False)
    right = prepare_ends(field, b.subdivide(parts), True)
    per_a, per_b = len(left.boxes) // len(a), len(right.boxes) // len(b)
    most = max(1, BLOCK_BYTES // (per_a * per_b * max(field.centres, 8) * 8))
    for row in range(len(a)):
        columns = np.flatnonzero(loose[row])
        columns = columns[columns >= row] if symmetric else columns
        mine = left.take(np.arange(row * per_a, (row + 1) * per_a))
        for start in range(0, len(columns), most):
            cells = columns[start : start + most]
            theirs = right.take((cells[:, None] * per_b + np.arange(per_b)).ravel())
            piece = _sub_bounds(field, mine, theirs, ask)
            shape = (1, per_a, len(cells), per_b)
            best = [_reduce(v.reshape(shape), k % 2 == 1)[0] for k, v in enumerate(piece[:6])]
            for k in range(6):
                keep = np.minimum if k % 2 else np.maximum
                _keep(bounds[k], row, cells, best[k], keep, symmetric)
            level = piece[6].reshape(shape)
            _keep(seen_low, row, cells, _reduce(level, False)[0], np.minimum, symmetric)
            _keep(seen_high, row, cells, _reduce(level, True)[0], np.maximum, symmetric)


def _keep(
    table: Array, row: int, cells: NDArray[np.intp], new: Array, rule: np.ufunc, symmetric: bool
) -> None:
    """Merge new values into one row (and its mirror) of a table."""
    table[row, cells] = rule(table[row, cells], new)
    if symmetric:
        table[cells, row] = table[row, cells]


def _reduce(values: Array, upper: bool) -> Array:
    reduced = values.max(axis=(1, 3)) if upper else values.min(axis=(1, 3))
    return np.asarray(reduced, dtype=np.float64)


def _sub_bounds(field: PairField, left: Ends, right: Ends, ask: _Ask) -> list[Array]:
    """Mean, sigma and level intervals (lower, upper, ...) over pairs of boxes, and the level
    at their centres."""
    model = field.model
    near, at, far = distances(left.boxes, right.boxes)
    ends = (far, near) if model.exponent >= 0 else (near, far)
    low, high = (path_loss_mean(d, model.l0, model.exponent, model.d0) for d in ends)
    extra, z = (model.fading if ask.fading else 0.0), ask.z
    if not field.centres:
        sigma = np.full_like(near, np.sqrt(model.shadowing + extra))
        centre = path_loss_mean(at, model.l0, model.exponent, model.d0) - z * sigma
        return [low, high, sigma, sigma, low - z * sigma, high - z * sigma, centre]
    overlap = [1.0 + np.exp(-((d / model.length) ** 2)) for d in (far, near, at)]
    scale = [1.0 / np.sqrt(g) for g in (overlap[1], overlap[0], overlap[2])]
    loss = expand_path_loss(model, left.boxes, right.boxes, near, at)
    gain = expand_gain(field, left, right)
    mean, drift = _mean_expansion(loss, gain, scale)
    crude = _product(gain.interval(), (scale[0], scale[1]))
    low = np.maximum(low + crude[0], mean.interval()[0] + drift[0]) - SLACK
    high = np.minimum(high + crude[1], mean.interval()[1] + drift[1]) + SLACK
    if not ask.spread:
        least = np.full_like(near, np.sqrt(extra))
        most = np.full_like(near, np.sqrt(model.shadowing + extra))
        return [low, high, least, most, low, high, mean.centre]
    rest = expand_rest(field, left, right, near, overlap)
    least, most = _variance(model.shadowing, rest.interval(), scale)
    least, most = least + extra, most + extra
    level = _level(model.shadowing, mean, drift, rest, scale, (least, most, extra), z)
    spread = np.maximum(model.shadowing * scale[2] ** 2 * rest.centre, 0.0) + extra
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
