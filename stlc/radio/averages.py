"""E[curve(mu + sigma xi)] of a monotone link curve, xi standard normal, and rigorous bounds of it.

A curve c from dBm to a rate is the distribution of a threshold: with its derivative c',

    E[c(mu + sigma xi)] = c(-inf) + integral c'(r) Phi((mu - r) / sigma) dr

The integrand is analytic and vanishes at both ends, so the trapezoidal rule converges faster than
any power of its step (Trefethen & Weideman, SIAM Review 2014); c' is taken once for each curve.
The step is halved until two rules agree. Phi((mu - r) / sigma) falls as sigma grows where r < mu
and rises where r > mu: taken at its worst sigma for each r, it gives bounds over an interval.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache
from math import erfc, pi, sqrt

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Curve = Callable[[Array], Array]
Interval = tuple[Array, Array]

ERROR = 1e-7
"""What an average may be off by, and what bounds are widened by."""

AGREE = 1e-8
"""Two rules that differ by less are both good."""

SMALL = 1.0 / 16.0
"""Below this sigma [dB] Gauss-Hermite is exact: the steepest cliffs bend within half a decibel."""

HERMITE_NODES = 12

COARSEST, FINEST = 1.0, 1.0 / 64.0
"""Steps [dB] between which a rule is sought."""

LEVELS = (-400.0, 300.0)
"""Where curves are looked at [dBm]; they are flat beyond, around any noise floor of a radio."""

BLOCK = 2_000_000
"""Numbers held at once."""

FEW = 100_000
"""Numbers of which Phi is taken one by one, in 8 ms: to import scipy.special takes 70."""

DENSE = 4
"""With one sigma, a table over mu replaces the sum where it needs this many times fewer points."""


@dataclass(frozen=True, slots=True, eq=False)
class Rule:
    """c(r) = base + sum of weights (K,) at nodes r (K,) [dBm] that lie below r, `step` apart."""

    base: float
    nodes: Array
    weights: Array
    step: float


def average(curve: Curve, mean: Array, sigma: Array) -> Array:
    """E[curve(mu + sigma xi)] within ERROR; mean [dBm] and sigma [dB] broadcast.

    `curve` is monotone in dBm with values in [0, 1].
    """
    mean, sigma = np.broadcast_arrays(np.asarray(mean, float), np.asarray(sigma, float))
    flat = _average(curve, mean.ravel(), sigma.ravel())
    return np.asarray(np.clip(flat, 0.0, 1.0).reshape(mean.shape), dtype=np.float64)


def average_bounds(curve: Curve, mean: Interval, sigma: Interval, decreasing: bool) -> Interval:
    """Bounds of `average` for mu and sigma anywhere in intervals (lower, upper), rigorous.

    `curve` as for `average`, falling if `decreasing`, else rising.
    """
    parts = np.broadcast_arrays(*(np.asarray(x, float) for x in (*mean, *sigma)))
    low, high, least, most = (x.ravel() for x in parts)
    if np.array_equal(least, most):
        ends = _average(curve, low, least), _average(curve, high, least)
        found = ends[::-1] if decreasing else ends
    else:
        ends = (high, low) if decreasing else (low, high)
        found = (
            _extreme(curve, ends[0], (least, most), rise=False),
            _extreme(curve, ends[1], (least, most), rise=True),
        )
    shape = parts[0].shape
    below = np.maximum(found[0] - ERROR, 0.0).reshape(shape)
    above = np.minimum(found[1] + ERROR, 1.0).reshape(shape)
    return below, above


def _average(curve: Curve, mean: Array, sigma: Array) -> Array:
    """`average` of flat arrays."""
    out = np.empty_like(mean)
    small = sigma < SMALL
    out[small] = _narrow(curve, mean[small], sigma[small])
    for octave, some in _octaves(sigma, ~small):
        rule = _rule(curve, octave)
        out[some] = _sum(rule, mean[some], sigma[some])
    return out


def _octaves(sigma: Array, wanted: NDArray[np.bool_]) -> Iterator[tuple[int, NDArray[np.intp]]]:
    """k and the places with 2^k <= sigma < 2^(k+1)."""
    places = np.flatnonzero(wanted)
    power = np.floor(np.log2(sigma[places])).astype(np.int64)
    for k in np.unique(power):
        yield int(k), places[power == k]


def _narrow(curve: Curve, mean: Array, sigma: Array) -> Array:
    """Gauss-Hermite, for a sigma within which the curve is a polynomial."""
    nodes, weights = np.polynomial.hermite.hermgauss(HERMITE_NODES)
    total = np.zeros_like(mean)
    for node, weight in zip(nodes, weights / weights.sum(), strict=True):
        total += weight * curve(mean + sqrt(2.0) * node * sigma)
    return total


def _sum(rule: Rule, mean: Array, sigma: Array) -> Array:
    """The rule at means and sigmas (N,)."""
    if len(mean) and np.ptp(sigma) == 0.0:
        return _alike(rule, mean, float(sigma[0]))
    return _direct(rule, mean, sigma)


def _alike(rule: Rule, mean: Array, sigma: Array | float) -> Array:
    """One sigma for all: a cubic spline over mu, sixteen knots a sigma, where there are many.

    Its error is below h^4 / 384 max|phi'''| / sigma^4 < 6e-8 for a curve of height 1.
    """
    low, high = float(mean.min()), float(mean.max())
    count = int((high - low) / (float(sigma) / 16.0)) + 8
    if len(mean) < DENSE * count or high - low < 1e-6:  # knots would coincide
        return _direct(rule, mean, np.full_like(mean, sigma))
    from scipy.interpolate import CubicSpline

    knots = np.linspace(low, high, count)
    spline = CubicSpline(knots, _direct(rule, knots, np.full_like(knots, sigma)))
    return np.asarray(spline(mean), dtype=np.float64)


def _direct(rule: Rule, mean: Array, sigma: Array) -> Array:
    """The rule at means and sigmas (N,), every node at each."""
    out = np.empty_like(mean)
    for some in _blocks(len(mean), len(rule.nodes)):
        gap = (mean[some, None] - rule.nodes) / sigma[some, None]
        out[some] = rule.base + _below(gap) @ rule.weights
    return out


def _below(x: Array) -> Array:
    """Phi of each number (..)."""
    if x.size <= FEW and "scipy.special" not in sys.modules:
        tails = np.frompyfunc(erfc, 1, 1)(x / -sqrt(2.0))
        return 0.5 * np.asarray(tails, dtype=np.float64)
    from scipy.special import ndtr

    return np.asarray(ndtr(x), dtype=np.float64)


def _extreme(curve: Curve, mean: Array, sigma: Interval, rise: bool) -> Array:
    """The average with, for each threshold r, the sigma that makes it pass least (or, `rise`,
    most) often; sigma (lower, upper)."""
    least, most = (np.maximum(side, SMALL) for side in sigma)
    out = np.empty_like(mean)
    for octave, some in _octaves(least, np.ones(len(mean), bool)):
        rule = _rule(curve, octave)
        out[some] = _outermost(rule, mean[some], (least[some], most[some]), rise)
        # What a sigma below SMALL may move, at most: E|xi| / 2 of it times the slope.
        out[some] += _away(rule, rise) * (sigma[0][some] < SMALL) * SMALL / sqrt(2.0 * pi)
    return out


def _outermost(rule: Rule, mean: Array, sigma: Interval, rise: bool) -> Array:
    """The rule with the worst sigma for each node.

    Phi((mu - r) / sigma) is then kinked at r = mu by the difference of the slopes, which the
    trapezoidal rule misses by at most step^2 / 8 of the kink times c'.
    """
    from scipy.special import ndtr

    falling = bool(rule.weights.sum() < 0)
    least, most = sigma
    out = np.empty_like(mean)
    for some in _blocks(len(mean), len(rule.nodes)):
        gap = mean[some, None] - rule.nodes
        wide = (gap < 0) if rise != falling else (gap > 0)
        gap /= np.where(wide, most[some, None], least[some, None])
        out[some] = rule.base + ndtr(gap) @ rule.weights
    kink = (1.0 / least - 1.0 / most) / sqrt(2.0 * pi)
    return np.asarray(out + _away(rule, rise) * rule.step**2 / 8.0 * kink)


def _away(rule: Rule, rise: bool) -> float:
    """The steepest slope, and a quarter for what lies between nodes, signed outwards."""
    steepest = 1.25 * float(np.abs(rule.weights).max(initial=0.0)) / rule.step
    return steepest if rise else -steepest


def _blocks(rows: int, width: int) -> Iterator[slice]:
    step = max(1, BLOCK // max(width, 1))
    return (slice(k, min(k + step, rows)) for k in range(0, rows, step))


@lru_cache(maxsize=64)
def _rule(curve: Curve, octave: int) -> Rule:
    """The coarsest rule that is good for sigma >= 2^octave: half that step changes nothing."""
    sigma = 2.0**octave
    step = min(sigma / 2.0, COARSEST)
    rule = _trapezoid(curve, step)
    while step > FINEST:
        finer = _trapezoid(curve, step / 2.0)
        if _differ(rule, finer, sigma) < AGREE:
            return rule
        rule, step = finer, step / 2.0
    return rule


def _differ(rule: Rule, finer: Rule, sigma: float) -> float:
    nodes = finer.nodes if len(finer.nodes) else np.zeros(1)
    mean = np.arange(nodes[0] - 4 * sigma, nodes[-1] + 4 * sigma, sigma / 3.0)
    spread = np.full_like(mean, sigma)
    return float(np.abs(_direct(rule, mean, spread) - _direct(finer, mean, spread)).max())


def _trapezoid(curve: Curve, step: float) -> Rule:
    """Weights step c'(r) on a lattice, where they are not lost in rounding."""
    nodes = np.arange(LEVELS[0], LEVELS[1], step)
    weights = step * _slope(curve, nodes)
    used = np.flatnonzero(np.abs(weights) > 1e-13)
    kept = slice(used[0], used[-1] + 1) if len(used) else slice(0)
    base = float(curve(np.array([LEVELS[0]]))[0])
    return Rule(base, nodes[kept], weights[kept], step)


def _slope(curve: Curve, at: Array) -> Array:
    """c' by central differences of eighth order, 1/64 dB apart."""
    delta = 1.0 / 64.0
    total = np.zeros_like(at)
    for k, weight in enumerate((4 / 5, -1 / 5, 4 / 105, -1 / 280), start=1):
        total += weight * (curve(at + k * delta) - curve(at - k * delta))
    return total / delta
