"""Abstract steps of one agent between two layers, as half-steps: along x first, then along y."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.relaxation.problem import Axis, Body, Singles
from stlc.solve.states.boxes import EPS, AxisGrid, feasible_pairs
from stlc.solve.states.layers import Layer

Reals = TypeVar("Reals", Floats, Singles)


@dataclass(frozen=True, slots=True, eq=False)
class Half:
    """Edges of a half-step: source and target state, and the axis edge that carries the weight."""

    sources: int
    targets: int
    source: Ints
    target: Ints
    edge: Ints


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """along_x, along_y: axis edges (source box, target box). first: layer -> (x', y, bit);
    second: (x', y, bit) -> next layer."""

    along_x: tuple[Ints, Ints]
    along_y: tuple[Ints, Ints]
    first: Half
    second: Half


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """A min-plus half-step in rounds, each with at most one edge a target."""

    targets: int
    rounds: tuple[tuple[Ints | None, Ints, Ints], ...]

    def apply(self, values: Reals, weights: Reals) -> Reals:
        """(targets, k): least of values[source] + weights[edge]; values (sources, k)."""
        out = np.full((self.targets, values.shape[1]), np.inf, values.dtype)
        for target, source, edge in self.rounds:
            found = np.take(values, source, axis=0)
            found += weights[edge][:, None]
            if target is None:
                np.minimum(out, found, out=out)
            else:
                out[target] = np.minimum(out[target], found)
        return out


def sweep(targets: int, target: Ints, source: Ints, edge: Ints) -> Sweep:
    """Sort edges into rounds by their rank among those of one target."""
    order = np.argsort(target, kind="stable")
    count = np.bincount(target, minlength=targets)
    rank = np.arange(len(target)) - (np.cumsum(count) - count)[target[order]]
    rounds = [order[rank == k] for k in range(int(count.max(initial=0)))]
    return Sweep(
        targets,
        tuple((None if len(o) == targets else target[o], source[o], edge[o]) for o in rounds),
    )


def both_ways(half: Half) -> tuple[Sweep, Sweep]:
    """Forward and backward sweeps."""
    return (
        sweep(half.targets, half.target, half.source, half.edge),
        sweep(half.sources, half.source, half.target, half.edge),
    )


def spread(first: Ints, count: Ints, who: Ints) -> tuple[Ints, Ints]:
    """For each member of `who` all entries of its run: (position in who, entry)."""
    runs = count[who]
    repeated = np.repeat(np.arange(len(who)), runs)
    offset = np.arange(int(runs.sum())) - np.repeat(np.cumsum(runs) - runs, runs)
    return repeated, first[who][repeated] + offset


def _match(sorted_keys: Ints, keys: Ints) -> tuple[Ints, Bools]:
    position = np.searchsorted(sorted_keys, keys)
    hit = position < len(sorted_keys)
    hit[hit] = sorted_keys[position[hit]] == keys[hit]
    return position, hit


def make_step(body: Body, t: int, a: Layer, b: Layer) -> Step:
    """All abstract steps from layer t to t + 1. A state whose choice is behind also follows one
    whose choice is ahead, where its boxes meet an alternative of step t + 1."""
    width = len(a.y.box)
    along_x, along_y = (_between(a.grid(d), b.grid(d), body.axes[d]) for d in (0, 1))
    count = np.bincount(along_x[0], minlength=len(a.x.box))
    from_a, edge_a = spread(np.cumsum(count) - count, count, a.ix)
    key_a = (along_x[1][edge_a] * width + a.iy[from_a]) * 2 + a.bit[from_a]
    order = np.argsort(along_y[1], kind="stable")
    count = np.bincount(along_y[1], minlength=len(b.y.box))
    to_b, edge_b = spread(np.cumsum(count) - count, count, b.iy)
    edge_b = order[edge_b]
    key_b = (b.ix[to_b] * width + along_y[0][edge_b]) * 2 + b.bit[to_b]
    turns = ((b.bit == 1) & _taken(body, t + 1, b))[to_b]
    key_b = np.concatenate([key_b, key_b[turns] - 1])
    to_b, edge_b = (np.concatenate([v, v[turns]]) for v in (to_b, edge_b))
    middle = np.intersect1d(key_a, key_b)
    at_a, hit_a = _match(middle, key_a)
    at_b, hit_b = _match(middle, key_b)
    return Step(
        along_x, along_y,
        Half(len(a), len(middle), from_a[hit_a], at_a[hit_a], edge_a[hit_a]),
        Half(len(middle), len(b), at_b[hit_b], to_b[hit_b], edge_b[hit_b]),
    )  # fmt: skip


def _between(a: AxisGrid, b: AxisGrid, axis: Axis) -> tuple[Ints, Ints]:
    """Steps along an axis; runs stay with the alternative that they take."""
    i, j = feasible_pairs(a.room, b.room, axis)
    same = (a.kind[i] == b.kind[j]) | (a.kind[i] < 0) | (b.kind[j] < 0)
    return i[same], j[same]


def _taken(body: Body, t: int, layer: Layer) -> Bools:
    """States whose boxes meet an alternative of step t."""
    found = np.zeros(len(layer), bool)
    for place in body.places:
        if place.step == t:
            found |= (
                _meets(layer.x, place.box[0])[layer.ix] & _meets(layer.y, place.box[1])[layer.iy]
            )
    return found


def _meets(grid: AxisGrid, span: Floats) -> Bools:
    return np.asarray((grid.box[:, 0] <= span[1] + EPS) & (grid.box[:, 1] >= span[0] - EPS))
