"""Which axis boxes to halve: those that runs near the least value cross at points far apart.

A run may leave a box elsewhere than it enters it, at the price of the box's slopes, which are such
that runs slip as far forward as back (see `team_ascent`). Halves have slopes of their own, so they
help most where the points at which the box is entered and left are spread the widest.
"""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.solve.bounders.axis_edges import AxisEdges
from stlc.solve.bounders.team_ascent import TeamAscent
from stlc.solve.states.halved import halved
from stlc.solve.states.layers import Layer, restrict
from stlc.solve.states.tubes import Tubes


def spreads(ascent: TeamAscent, z: Floats, heat: float) -> list[Floats]:
    """For every agent (boxes, 2): how far apart, on the average of all runs of its pairs, the
    points are at which boxes are entered and left, along the position and the rate."""
    out = [np.zeros_like(moves.slopes) for moves in ascent.moves]
    for part, found in ascent.softened(z, heat):
        for end, n in enumerate(part.pair):
            out[n] += _spread(ascent.moves[n], found.flows[end], found.at[end])
    return out


def _spread(edges: AxisEdges, flow: Floats, at: Floats) -> Floats:
    """Of one pair's runs; nothing in boxes that have no slopes."""
    count, (entry, leave) = len(edges.slopes), edges.points(at)
    box, share = np.concatenate([edges.enters, edges.leaves]), np.concatenate([flow, flow])
    total = np.maximum(np.bincount(box, share, minlength=count), np.finfo(float).tiny)
    columns = []
    for parts in zip(entry, leave, strict=True):
        point = np.concatenate(parts)
        mean = np.bincount(box, share * point, minlength=count) / total
        columns.append(np.bincount(box, share * np.abs(point - mean[box]), minlength=count))
    return np.where(edges.loose[:, None], np.stack(columns, axis=1), 0.0)


def widest(found: list[Floats], share: float) -> float:
    """The least spread of the boxes that make up this share of all spread."""
    size = np.sort(np.concatenate([f.max(1) for f in found]))[::-1]
    summed = np.cumsum(size)
    return float(size[min(int(np.searchsorted(summed, share * summed[-1])), len(size) - 1)])


def halved_rows(
    ascent: TeamAscent, rows: list[list[Layer]], found: list[Floats], least: float,
    tubes: list[Tubes], taken: tuple[tuple[int, ...], ...],
) -> list[list[Layer]]:  # fmt: skip
    """The layers `rows` of all agents, boxes of at least this spread halved."""
    problem, out = ascent.agreement.problem, []
    for n, moves in enumerate(ascent.moves):
        ways = np.where(found[n].max(1) >= least, found[n].argmax(1), -1)
        row = [_same(rows[n][0])]
        for t, layer in enumerate(rows[n][1:], start=1):
            own: tuple[Ints, Ints] = (ways[moves.boxes[0, t, 0]], ways[moves.boxes[0, t, 1]])
            row.append(halved(layer, own, problem.bodies[n], tubes[n], taken[n], t))
        out.append(row)
    return out


def _same(layer: Layer) -> Layer:
    return restrict(layer, np.ones(len(layer), bool))
