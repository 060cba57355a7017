"""Better potentials for the pairs of states that are alive: ascent on a smoothed least value.

The least value of all abstract runs is concave in the slopes of the potentials and has corners.
Its soft minimum -heat log sum exp(-value / heat) has none, and its derivative by the slopes of a
box is how much further on, over all runs, the box is entered than it is left. L-BFGS does the
rest. With slopes of its own in every box this is the dual of a shortest path through convex sets
(Marcucci, Umenberger, Parrilo and Tedrake 2024), kept apart along each axis.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from stlc.arrays import Floats
from stlc.solve.bounders.arcs import Arcs
from stlc.solve.bounders.axis_edges import AxisEdges

_MEMORY = 8  # steps that L-BFGS remembers
_TRIES = 5  # of a line search
_ENOUGH = 1e-4  # of the rise that the derivative promises
_LEAST = 1e-300


def ascend(arcs: Arcs, heat: float, rounds: int) -> None:
    """Improve the slopes of `arcs` by at most `rounds` steps; the least value does not fall.

    heat: in the unit of the cost; a small part of what the least value may still rise.
    """
    least, slopes = arcs.through()[0], arcs.slopes
    with np.errstate(all="ignore"):
        found = climbed(lambda z: smoothed(arcs, z, heat), slopes, heat, rounds)
    if np.isfinite(found).all():
        arcs.slopes = found
    if not arcs.through()[0] >= least:
        arcs.slopes = slopes


def climbed(
    fun: Callable[[Floats], tuple[float, Floats]], z: Floats, lead: float, rounds: int
) -> Floats:
    """L-BFGS (Nocedal and Wright 2006, algorithm 7.5) with backtracking, towards the maximum of a
    concave function. The first step is meant to rise by `lead`.

    Of our own: every evaluation counts, and importing SciPy's costs as much as thirty of them.
    """
    value, slope = fun(z)
    past: list[tuple[Floats, Floats]] = []
    for _ in range(rounds):
        way = _direction(slope, past, lead)
        rise, length = _dot(slope, way), 1.0
        for _ in range(_TRIES):
            ahead, there = fun(z + length * way)
            if ahead >= value + _ENOUGH * length * rise:
                break
            top = 0.5 * length * rise / (rise - (ahead - value) / length)
            length = min(max(top, 0.1 * length), 0.5 * length)
        else:
            return z
        past = [*past[1 - _MEMORY :], (length * way, slope - there)]
        z, value, slope = z + length * way, ahead, there
    return z


def _direction(slope: Floats, past: list[tuple[Floats, Floats]], lead: float) -> Floats:
    """The inverse of the curvature along `past` steps and changes of slope, times the slope."""
    if not past:
        return np.multiply(slope, lead / _dot(slope, slope))
    way, shares = slope, list[float]()
    for step, change in reversed(past):
        shares.append(_dot(step, way) / _dot(step, change))
        way = way - shares[-1] * change
    step, change = past[-1]
    way = way * (_dot(step, change) / _dot(change, change))
    for (step, change), share in zip(past, reversed(shares), strict=True):
        way = way + step * (share - _dot(change, way) / _dot(step, change))
    return way


def _dot(a: Floats, b: Floats) -> float:
    return float(np.vdot(a, b))


def smoothed(arcs: Arcs, slopes: Floats, heat: float) -> tuple[float, Floats]:
    """Soft minimum over all abstract runs, and its derivative by the slopes (boxes, 2)."""
    return softened(arcs, slopes, heat)[:2]


def softened(arcs: Arcs, slopes: Floats, heat: float) -> tuple[float, Floats, list[Floats]]:
    """`smoothed`, and for every stop the share of runs through each of its pairs."""
    value, at = arcs.corners.cheapest(*arcs.ends(slopes))
    lowest, weights = weights_of(arcs, value, heat)
    ahead, scales, logs = _forward(arcs, weights, heat)
    total = float(ahead[-1].sum())
    flow, shares = _flow(arcs, weights, ahead, scales)
    return lowest - heat * (np.log(total) + logs), arcs.slips(flow, at), shares


def shares(arcs: Arcs, heat: float) -> list[Floats]:
    """For every stop the share of runs through each of its pairs, weighed by exp(-value / heat)."""
    value = arcs.corners.least(*arcs.ends(arcs.slopes))[0]
    _, weights = weights_of(arcs, value, heat)
    ahead, scales, _ = _forward(arcs, weights, heat)
    return _flow(arcs, weights, ahead, scales)[1]


def weights_of(edges: AxisEdges, value: Floats, heat: float) -> tuple[float, Floats]:
    """exp(-value / heat), scaled to 1 at most in every half-step; the sum of what was taken off."""
    lowest = np.minimum.reduceat(value, edges.parts)
    sizes = np.diff(edges.parts, append=len(value))
    return float(lowest.sum()), np.exp((np.repeat(lowest, sizes) - value) / heat)


def _forward(
    arcs: Arcs, weights: Floats, heat: float
) -> tuple[list[Floats], list[Floats | float], float]:
    """Sums over the runs to each node of all lists, what each list was scaled by, and the
    logarithm of all that scaling."""
    ahead, scales, logs = [np.ones(1)], list[Floats | float](), 0.0
    for q, hop in enumerate(arcs.hops):
        f = np.bincount(hop.target, ahead[-1][hop.source] * weights[hop.edge]).astype(np.float64)
        scale: Floats | float = 1.0
        if q % 4 == 3:
            cost = arcs.stops[(q + 1) // 4].cost
            low = float(cost.min())
            scale = np.exp((low - cost) / heat)
            logs -= low / heat
        top = max(float((f * scale).max()), _LEAST)
        scale, logs = scale / top, logs + float(np.log(top))
        ahead.append(f * scale)
        scales.append(scale)
    return ahead, scales, logs


def _flow(
    arcs: Arcs, weights: Floats, ahead: list[Floats], scales: list[Floats | float]
) -> tuple[Floats, list[Floats]]:
    """Share of the runs along each axis edge, and through each pair of every stop."""
    flow, g, found = np.zeros(len(weights)), np.ones(len(ahead[-1])), [ahead[-1]]
    for q in range(len(arcs.hops) - 1, -1, -1):
        hop = arcs.hops[q]
        along = (g * scales[q])[hop.target] * weights[hop.edge]
        taken = along * ahead[q][hop.source]
        flow += np.bincount(hop.edge, taken / taken.sum(), minlength=len(flow))
        g = np.add.reduceat(along, hop.begin)
        g /= g.max()
        if q % 4 == 0:
            found.append(ahead[q] * g)
    return flow, [f / f.sum() for f in found[::-1]]
