"""Better potentials for the pairs of states that are alive: ascent on a smoothed least value.

The least value of all abstract runs is concave in the slopes of the potentials and has corners.
Its soft minimum -heat log sum exp(-value / heat) has none, and its derivative by the slopes of a
box is how much further on, over all runs, the box is entered than it is left. L-BFGS does the
rest. With slopes of its own in every box this is the dual of a shortest path through convex sets
(Marcucci, Umenberger, Parrilo and Tedrake 2024), kept apart along each axis.
"""

from __future__ import annotations

import numpy as np

from stlc.solve.links.arcs import Arcs
from stlc.solve.links.boxes import cheapest, edge_min
from stlc.solve.links.problem import Floats

_MEMORY = 8  # steps that L-BFGS remembers
_LEAST = 1e-300


def ascend(arcs: Arcs, heat: float, rounds: int) -> None:
    """Improve the slopes of `arcs` by at most `rounds` steps; the least value does not fall.

    heat: in the unit of the cost; a small part of what the least value may still rise.
    """
    from scipy.optimize import minimize

    def fun(z: Floats) -> tuple[float, Floats]:
        value, slips = smoothed(arcs, z.reshape(-1, 2), heat)
        return -value, -slips.ravel()

    least, slopes = arcs.through()[0], arcs.slopes
    with np.errstate(all="ignore"):
        found = minimize(
            fun, slopes.ravel(), jac=True, method="L-BFGS-B",
            options={"maxiter": rounds, "maxcor": _MEMORY},
        )  # fmt: skip
    if np.isfinite(found.x).all():
        arcs.slopes = found.x.reshape(-1, 2)
    if not arcs.through()[0] >= least:
        arcs.slopes = slopes


def smoothed(arcs: Arcs, slopes: Floats, heat: float) -> tuple[float, Floats]:
    """Soft minimum over all abstract runs, and its derivative by the slopes (boxes, 2)."""
    value, at = cheapest(arcs.edges, *arcs.ends(slopes))
    lowest, weights = _weights(arcs, value, heat)
    ahead, scales, logs = _forward(arcs, weights, heat)
    total = float(ahead[-1].sum())
    flow, _ = _flow(arcs, weights, ahead, scales)
    return lowest - heat * (np.log(total) + logs), _slips(arcs, flow, at)


def shares(arcs: Arcs, heat: float) -> list[Floats]:
    """For every stop the share of runs through each of its pairs, weighed by exp(-value / heat)."""
    value = edge_min(arcs.edges, *arcs.ends(arcs.slopes))
    _, weights = _weights(arcs, value, heat)
    ahead, scales, _ = _forward(arcs, weights, heat)
    return _flow(arcs, weights, ahead, scales)[1]


def _weights(arcs: Arcs, value: Floats, heat: float) -> tuple[float, Floats]:
    """exp(-value / heat), scaled to 1 at most in every half-step; the sum of what was taken off."""
    lowest = np.minimum.reduceat(value, arcs.parts)
    sizes = np.diff(arcs.parts, append=len(value))
    return float(lowest.sum()), np.exp((np.repeat(lowest, sizes) - value) / heat)


def _forward(
    arcs: Arcs, weights: Floats, heat: float
) -> tuple[list[Floats], list[Floats | float], float]:
    """Sums over the runs to each node of all lists, what each list was scaled by, and the
    logarithm of all that scaling."""
    ahead, scales, logs = [np.ones(1)], list[Floats | float](), 0.0
    for q, hop in enumerate(arcs.hops):
        f = np.add.reduceat((ahead[-1][hop.source] * weights[hop.edge])[hop.order], hop.first)
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


def _slips(arcs: Arcs, flow: Floats, at: Floats) -> Floats:
    """By how much runs enter each box elsewhere than they leave it: (boxes, 2)."""
    p, v, w = at.T
    blend, count = arcs.edges.blend, len(arcs.slopes)
    entry = (p + (1 - blend) * v + blend * w, w)
    columns = [
        np.bincount(arcs.enters, flow * into, minlength=count)
        - np.bincount(arcs.leaves, flow * leave, minlength=count)
        for into, leave in zip(entry, (p, v), strict=True)
    ]
    return np.where(arcs.loose[:, None], np.stack(columns, axis=1), 0.0)
