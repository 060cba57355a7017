"""Rigorous bounds of the posterior over closed cell pairs.

Mean = m + u S. Over a pair of (sub)boxes of centre y0, half widths h, r^2 = |h|^2:
  * m and u are monotone in the distance, whose interval is exact;
  * S(y) lies in S(y0) +- sum_i |dS/dy_i| h_i + remainder. The Hessian of one kernel term
    rho (r r'/l^4 - I/l^2) lies between -rho/l^2 and t rho/l^2, t = |y - c|^2/l^2, so the
    remainder is summed by the sign of each weight with the largest rho and t rho in the box.
Variance = sigma_k^2 u^2 V, V = <phi, (I - P) phi>, 0 <= P <= I, with phi the features of the
unnormalised symmetric kernel: V'' is at least -2 |phi| |phi''| and at most
2 |phi'|^2 + 2 |phi| |phi''|, where |phi|^2 = g, |phi'|^2 <= (1 + min(1, (1+t) e^(-t/2)))/l^2,
|phi''|^2 <= (3 + min(3, (3 + 6t + t^2) e^(-t/2)))/l^4, t = 2 |a - b|^2/l^2.
Cells are cut into s x s parts, s = 1, 2, 4, ... until the bounds are tight or the budget ends.
Sound for any s; derived here, after Jones and Dixon's and the usual Taylor-form interval bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError
from stlc.radio.gp import ChannelModel
from stlc.radio.kernel import KernelName
from stlc.radio.pairs import BLOCK_BYTES, PairField, predict_pairs, prepare, swap_halves
from stlc.radio.pathloss import path_loss_mean

Array = NDArray[np.float64]
Interval = tuple[Array, Array]

SLACK = 1e-9
"""Added on both sides for rounding [dB, dB^2]."""


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """n closed boxes: centres (n, D) and half widths (n, D) >= 0 [m]; a point has width 0."""

    centre: Array
    half: Array

    def __len__(self) -> int:
        return len(self.centre)

    def subdivide(self, parts: int) -> Boxes:
        """Each box cut into `parts` along every axis of positive width, box-major."""
        axes = [k for k in range(self.centre.shape[1]) if (self.half[:, k] > 0).any()]
        count = parts ** len(axes)
        centre = np.repeat(self.centre, count, axis=0)
        half = np.repeat(self.half, count, axis=0)
        offsets = (2.0 * np.arange(parts) + 1.0) / parts - 1.0
        shifts = np.meshgrid(*[offsets] * len(axes), indexing="ij")
        for axis, shift in zip(axes, shifts, strict=True):
            centre[:, axis] += np.tile(shift.ravel(), len(self)) * half[:, axis]
            half[:, axis] /= parts
        return Boxes(centre, half)


@dataclass(frozen=True, slots=True, eq=False)
class PairBounds:
    """Bounds over closed cell pairs, each an interval of (na, nb) arrays.

    mean [dBm]; sigma [dB] (fading included if asked for); level = mean - z sigma [dBm];
    gap [dB]: the largest distance between a bound of `level` and the values seen on a lattice
    of each pair (an upper estimate of the slack); parts: how finely the loosest cells were cut.
    """

    mean: Interval
    sigma: Interval
    level: Interval
    gap: float
    parts: int


def pair_bounds(
    model: ChannelModel,
    a: Boxes,
    b: Boxes | None = None,
    *,
    fading: bool = True,
    z: float = 0.0,
    tolerance: float = 0.25,
    budget: float = 3e10,
) -> PairBounds:
    """Bounds for all pairs of boxes of `a` and `b` (b None: `a` with itself, half the work).

    tolerance [dB] on `level`; budget: most multiplications of one round (sub-pairs x M^2).
    Raises RadioError for `paper_min`, whose posterior variance obeys no such bound.
    """
    if model.kernel is not KernelName.SYMMETRISED:
        raise RadioError("kernel paper_min has no rigorous bounds: use bound = centre or mean")
    field = prepare(model, a.centre.shape[1])
    other = a if b is None else b
    seen = _attained(model, a, other, fading, z)
    bounds = np.empty((6, len(a), len(other)))
    bounds[0::2], bounds[1::2] = -np.inf, np.inf
    loose = np.ones((len(a), len(other)), dtype=np.bool_)
    parts, last = 1, 1
    while loose.any() and _work(field, a, other, loose, parts, b is None) <= budget:
        _refine(field, a, other, bounds, loose, parts, b is None, (fading, z))
        gap = np.maximum(seen[0] - bounds[4], bounds[5] - seen[1])
        loose = gap > tolerance
        parts, last = 2 * parts, parts
    if not np.isfinite(bounds).all():
        raise RadioError("the budget for channel bounds does not reach a single look at each pair")
    worst = float(gap.max(initial=0.0))
    pairs = [(bounds[k], bounds[k + 1]) for k in (0, 2, 4)]
    return PairBounds(pairs[0], pairs[1], pairs[2], worst, last)


def _attained(
    model: ChannelModel, a: Boxes, b: Boxes, fading: bool, z: float
) -> tuple[Array, Array]:
    """Least and greatest level seen on a lattice of 3 points an axis in every box."""
    points_a, points_b = _lattice(a), _lattice(b)
    mean, variance = predict_pairs(model, points_a, points_b, fading)
    level = (mean - z * np.sqrt(variance)).reshape(
        len(a), len(points_a) // len(a), len(b), len(points_b) // len(b)
    )
    return _reduce(level, False), _reduce(level, True)


def _lattice(boxes: Boxes) -> Array:
    fine = Boxes(boxes.centre, 1.5 * boxes.half).subdivide(3)
    return fine.centre


def _work(
    field: PairField, a: Boxes, b: Boxes, loose: NDArray[np.bool_], parts: int, symmetric: bool
) -> float:
    axes = int((a.half > 0).any(axis=0).sum() + (b.half > 0).any(axis=0).sum())
    pairs = float(loose.sum()) * float(parts) ** axes * (0.5 if symmetric else 1.0)
    return pairs * max(field.centres, 30) ** 2


def _refine(
    field: PairField,
    a: Boxes,
    b: Boxes,
    bounds: Array,
    loose: NDArray[np.bool_],
    parts: int,
    symmetric: bool,
    ask: tuple[bool, float],
) -> None:
    """Tighten `bounds` (6, na, nb) in place where `loose`, with cells cut parts x parts."""
    left = _prepare_ends(field, a.subdivide(parts), False)
    right = _prepare_ends(field, b.subdivide(parts), True)
    per_a, per_b = len(left.boxes) // len(a), len(right.boxes) // len(b)
    most = max(1, BLOCK_BYTES // (per_a * per_b * max(field.centres, 8) * 8))
    for row in range(len(a)):
        columns = np.flatnonzero(loose[row])
        columns = columns[columns >= row] if symmetric else columns
        mine = left.take(np.arange(row * per_a, (row + 1) * per_a))
        for start in range(0, len(columns), most):
            cells = columns[start : start + most]
            theirs = right.take((cells[:, None] * per_b + np.arange(per_b)).ravel())
            piece = _sub_bounds(field, mine, theirs, *ask)
            for k, values in enumerate(piece):
                best = _reduce(values.reshape(1, per_a, len(cells), per_b), k % 2 == 1)[0]
                keep = np.minimum if k % 2 else np.maximum
                bounds[k, row, cells] = keep(bounds[k, row, cells], best)
                if symmetric:
                    bounds[k, cells, row] = bounds[k, row, cells]


def _reduce(values: Array, upper: bool) -> Array:
    reduced = values.max(axis=(1, 3)) if upper else values.min(axis=(1, 3))
    return np.asarray(reduced, dtype=np.float64)


@dataclass(frozen=True, slots=True, eq=False)
class _Ends:
    """Boxes of one end and, for each, E at its centre, the largest E, the largest t E."""

    boxes: Boxes
    factors: Array
    top: Array
    bend: Array

    def take(self, rows: NDArray[np.intp]) -> _Ends:
        boxes = Boxes(self.boxes.centre[rows], self.boxes.half[rows])
        return _Ends(boxes, self.factors[rows], self.top[rows], self.bend[rows])


def _prepare_ends(field: PairField, boxes: Boxes, other: bool) -> _Ends:
    arrays = [field.factors(boxes.centre), *_box_factors(field, boxes)]
    if other:
        arrays = [swap_halves(f) for f in arrays]
    return _Ends(boxes, arrays[0], arrays[1], arrays[2])


def _sub_bounds(field: PairField, left: _Ends, right: _Ends, fading: bool, z: float) -> list[Array]:
    """Mean, sigma and level intervals (lower, upper, ...) over pairs of boxes."""
    model, a, b = field.model, left.boxes, right.boxes
    near, at, far = _distances(a, b)
    ends = (far, near) if model.exponent >= 0 else (near, far)
    low, high = (path_loss_mean(d, model.l0, model.exponent, model.d0) for d in ends)
    extra = model.fading if fading else 0.0
    if not field.centres:
        sigma = np.full_like(near, np.sqrt(model.shadowing + extra))
        return [low, high, sigma, sigma, low - z * sigma, high - z * sigma]
    overlap = [1.0 + np.exp(-((d / model.length) ** 2)) for d in (far, near, at)]
    scale = (1.0 / np.sqrt(overlap[1]), 1.0 / np.sqrt(overlap[0]))
    gain = _gain_bounds(field, left, right)
    low = low + np.minimum(gain[0] * scale[0], gain[0] * scale[1]) - SLACK
    high = high + np.maximum(gain[1] * scale[0], gain[1] * scale[1]) + SLACK
    rest = _rest_bounds(field, left, right, near, overlap)
    least, most = (np.sqrt(v + extra) for v in _variance(model.shadowing, rest, scale))
    weak, strong = (most, least) if z >= 0 else (least, most)
    return [low, high, least, most, low - z * weak, high - z * strong]


def _variance(
    shadowing: float, rest: tuple[Array, Array], scale: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Least and greatest posterior variance from the intervals of V and of u."""
    low = np.maximum(shadowing * rest[0] * scale[0] ** 2 - SLACK, 0.0)
    high = np.clip(shadowing * rest[1] * scale[1] ** 2 + SLACK, 0.0, shadowing + SLACK)
    return np.minimum(low, high), high


def _distances(a: Boxes, b: Boxes) -> tuple[Array, Array, Array]:
    """Least, centre and greatest distance (na, nb) [m] of two closed boxes."""
    shape = (len(a), len(b))
    near, at, far = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for axis in range(a.centre.shape[1]):
        gap = np.abs(a.centre[:, axis, None] - b.centre[None, :, axis])
        reach = a.half[:, axis, None] + b.half[None, :, axis]
        near += np.maximum(gap - reach, 0.0) ** 2
        at += gap**2
        far += (gap + reach) ** 2
    return np.sqrt(near), np.sqrt(at), np.sqrt(far)


def _box_factors(field: PairField, boxes: Boxes) -> tuple[Array, Array]:
    """Largest E and largest t E, t = |p - x|^2/l^2, over each box: (n, 2 M) each."""
    both = np.vstack([field.sender, field.receiver])
    near, far = np.zeros((len(boxes), len(both))), np.zeros((len(boxes), len(both)))
    for axis in range(both.shape[1]):
        gap = np.abs(boxes.centre[:, axis, None] - both[None, :, axis])
        near += np.maximum(gap - boxes.half[:, axis, None], 0.0) ** 2
        far += (gap + boxes.half[:, axis, None]) ** 2
    near, far = near / field.model.length**2, far / field.model.length**2
    peak = np.clip(2.0, near, far)
    return np.exp(-near / 2.0), peak * np.exp(-peak / 2.0)


def _gain_bounds(field: PairField, left: _Ends, right: _Ends) -> tuple[Array, Array]:
    """Lower and upper bound of S over pairs of boxes."""
    a, b, fa, fb = left.boxes, right.boxes, left.factors, right.factors
    weight = np.tile(field.mean_weight, 2)
    centre = (fa * weight) @ fb.T
    both = np.vstack([field.sender, field.receiver])
    crossed = np.vstack([field.receiver, field.sender])
    spread = np.zeros_like(centre)
    for axis in range(both.shape[1]):
        if (a.half[:, axis] > 0).any():
            slope = fa * (a.centre[:, axis, None] - both[None, :, axis])
            spread += np.abs((slope * weight) @ fb.T) * a.half[:, axis, None]
        if (b.half[:, axis] > 0).any():
            slope = fb * (b.centre[:, axis, None] - crossed[None, :, axis])
            spread += np.abs((fa * weight) @ slope.T) * b.half[None, :, axis]
    spread /= field.model.length**2
    low, high = _gain_remainder(field, left, right, weight)
    return centre - spread - low, centre + spread + high


def _gain_remainder(
    field: PairField, left: _Ends, right: _Ends, weight: Array
) -> tuple[Array, Array]:
    """How far S may fall below and rise above its linear bounds."""
    a, b = left.boxes, right.boxes
    top_a, bend_a, top_b, bend_b = left.top, left.bend, right.top, right.bend
    plus, minus = np.maximum(weight, 0.0), np.maximum(-weight, 0.0)
    reach = (a.half**2).sum(1)[:, None] + (b.half**2).sum(1)[None, :]
    reach = reach / (2.0 * field.model.length**2)
    low = (top_a * plus + bend_a * minus) @ top_b.T + (top_a * minus) @ bend_b.T
    high = (top_a * minus + bend_a * plus) @ top_b.T + (top_a * plus) @ bend_b.T
    return reach * low, reach * high


def _rest_bounds(
    field: PairField, left: _Ends, right: _Ends, near: Array, overlap: list[Array]
) -> tuple[Array, Array]:
    """Lower and upper bound of V = g - |root w|^2 over pairs of boxes."""
    a, b = left.boxes, right.boxes
    explained, slopes_a, slopes_b = _explained_slopes(field, left, right)
    length2 = field.model.length**2
    centre = overlap[2] - explained
    pull = (overlap[2] - 1.0) * (-2.0 / length2)
    spread = np.zeros_like(centre)
    for axis in range(a.centre.shape[1]):
        step = pull * (a.centre[:, axis, None] - b.centre[None, :, axis])
        spread += np.abs(step - slopes_a[axis]) * a.half[:, axis, None]
        spread += np.abs(-step - slopes_b[axis]) * b.half[None, :, axis]
    reach = 0.5 * ((a.half**2).sum(1)[:, None] + (b.half**2).sum(1)[None, :])
    t = 2.0 * near**2 / length2
    decay = np.exp(-t / 2.0)
    first = (1.0 + np.where(t > 1.0, np.minimum((1.0 + t) * decay, 1.0), 1.0)) / length2
    fourth = np.where(t > 2.2, np.minimum((3.0 + 6.0 * t + t**2) * decay, 3.0), 3.0)
    bend = 2.0 * np.sqrt(overlap[1]) * np.sqrt(3.0 + fourth) / length2
    low = np.maximum(centre - spread - reach * bend, 0.0)
    return low, centre + spread + reach * (2.0 * first + bend)


def _explained_slopes(
    field: PairField, left: _Ends, right: _Ends
) -> tuple[Array, list[Array], list[Array]]:
    """|root w|^2 at the centres and its derivatives along each axis of both ends."""
    a, b, fa, fb = left.boxes, right.boxes, left.factors, right.factors
    half, axes = field.centres, a.centre.shape[1]
    shape = (len(a), len(b))
    direct = (fa[:, None, :half] * fb[None, :, :half]).reshape(-1, half)
    crossed = (fa[:, None, half:] * fb[None, :, half:]).reshape(-1, half)
    reduced = (direct + crossed) @ field.root.T
    total = np.einsum("ij,ij->i", reduced, reduced).reshape(shape)
    pull = reduced @ field.root
    one, two = pull * direct, pull * crossed
    ends = np.column_stack([np.ones(half), field.sender, field.receiver])
    sums, cross = (one @ ends).reshape(*shape, -1), (two @ ends).reshape(*shape, -1)
    scale = -2.0 / field.model.length**2
    slopes_a, slopes_b = [], []
    for axis in range(axes):
        s, r = 1 + axis, 1 + axes + axis
        both = sums[..., 0] + cross[..., 0]
        at_a, at_b = a.centre[:, axis, None], b.centre[None, :, axis]
        slopes_a.append(scale * (at_a * both - sums[..., s] - cross[..., r]))
        slopes_b.append(scale * (at_b * both - sums[..., r] - cross[..., s]))
    return total, slopes_a, slopes_b
