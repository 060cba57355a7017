"""Rigorous bounds of the posterior over closed cell pairs.

Branch and bound: cells are cut into s x s parts, s = 1, 2, 4, ..., but only the parts that
keep the bound of their cell loose are cut again, until all are tight or the budget ends; over
each pair of parts `stlc.radio.taylor` gives the mean m + u S and the variance sigma_k^2 u^2 V
as first-order expansions with rigorous remainders.
Sound for any s. The level mean - z sigma is expanded as a whole, with
    0 >= sqrt(v) - sqrt(v0) - (v - v0) / (2 sqrt(v0)) >= -(v - v0)^2 / (8 min(v)^(3/2)).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import RadioError
from stlc.radio.fixed_end import prepare_from
from stlc.radio.gp import ChannelModel
from stlc.radio.kernel import KernelName
from stlc.radio.pairs import BLOCK_BYTES, PairField, prepare
from stlc.radio.sub_bounds import Ask, sub_bounds
from stlc.radio.taylor import (
    Boxes,
    Ends,
    prepare_ends,
)
from stlc.radio.threads import single_thread

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Interval = tuple[Array, Array]

FINEST = 8
"""Most parts along an axis of a cell; its square towards a station, as many parts in space."""

EVERYWHERE = (-np.inf, np.inf)
"""A focus on all levels."""


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
    focus: tuple[float, float] = EVERYWHERE,
) -> PairBounds:
    """Bounds for all pairs of boxes of `a` and `b` (b None: `a` with itself, half the work).

    spread=False leaves sigma at its prior bounds (z must be 0), which is much faster;
    tolerance [dB] on `level`; budget: multiplications (pairs of parts x M^2) to spend after
    the first look, on the loosest pairs first; focus [dBm]: levels that matter, a bound that
    lies beyond them as its cell does may be looser (DECIDED).
    Raises RadioError for a kernel other than `symmetrised`: the expansions are of that one.
    """
    if model.kernel is not KernelName.SYMMETRISED:
        raise RadioError(
            f"kernel {model.kernel.value} has no rigorous bounds: use bound = centre or mean"
        )
    if z != 0.0 and not spread:
        raise RadioError("a level with z other than 0 needs the spread")
    swapped = b is not None and len(b) < len(a)  # rows are walked one by one: few, long rows
    ends = (a, a) if b is None else (b, a) if swapped else (a, b)
    ask = Ask(fading, z, spread, tolerance, focus)
    with single_thread():
        search = _Search(_field(model, ends[0]), ask, len(ends[0]), len(ends[1]), b is None)
        last = search.run(ends[0], ends[1], budget)
    bounds = search.bounds.swapaxes(1, 2) if swapped else search.bounds
    gap = float(search.gap().max(initial=0.0))
    pairs = [(bounds[k], bounds[k + 1]) for k in (0, 2, 4)]
    return PairBounds(pairs[0], pairs[1], pairs[2], gap, last)


def _field(model: ChannelModel, first: Boxes) -> PairField:
    """The field of a channel, from a place where first ends are one."""
    if len(first) == 1 and not first.half.any():
        return prepare_from(model, first.centre[0])
    return prepare(model, first.centre.shape[1])


class _Search:
    """Branch and bound over pairs of parts; only parts that keep a bound loose are cut."""

    def __init__(self, field: PairField, ask: Ask, rows: int, columns: int, same: bool) -> None:
        self.field, self.ask, self.same = field, ask, same
        self.bounds = np.empty((6, rows, columns))
        self.bounds[0::2], self.bounds[1::2] = -np.inf, np.inf
        self.settled = np.empty_like(self.bounds)
        self.settled[0::2], self.settled[1::2] = np.inf, -np.inf
        self.seen = np.stack([np.full((rows, columns), v) for v in (np.inf, -np.inf)])

    def gap(self) -> Array:
        """Slack (rows, columns) [dB] left between the bounds of the level and values seen."""
        return np.asarray(np.maximum(self.seen[0] - self.bounds[4], self.bounds[5] - self.seen[1]))

    def run(self, left: Boxes, right: Boxes, budget: float) -> int:
        """Refine until tight, or the budget or the finest cut is reached; returns the cut."""
        axes = [int((end.half > 0).any(axis=0).sum()) for end in (left, right)]
        finest = FINEST if min(axes) else min(FINEST**2, round(FINEST ** (4 / max(*axes, 1))))
        cost = self._cost()
        rows, columns = np.indices(self.bounds.shape[1:]).reshape(2, -1)
        active = np.stack([rows, columns])[:, columns >= rows if self.same else slice(None)]
        parts = 1
        while True:
            active = self._look(left, right, active, (parts ** axes[0], parts ** axes[1]))
            split = 2 ** (axes[0] + axes[1])
            active = self._afford(active, parts, axes, budget / (cost * split))
            budget -= cost * split * active.shape[1]
            if not active.shape[1] or 2 * parts > finest:
                return parts
            left, right, parts = left.subdivide(2), right.subdivide(2), 2 * parts
            active = _children(active, 2 ** axes[0], 2 ** axes[1])

    def _cost(self) -> float:
        centres = max(self.field.centres, 30)
        return float(centres) ** 2 if self.ask.spread else 30.0 * centres

    def _afford(self, active: Ints, parts: int, axes: list[int], most: float) -> Ints:
        """The active pairs of the loosest cells, at most `most` of them.

        Cells are refined as a whole or not at all, for a part left out would keep its bound.
        """
        if active.shape[1] <= most:
            return active
        cell = self._cells(active, (parts ** axes[0], parts ** axes[1]))
        count = np.bincount(cell, minlength=self.bounds[0].size)
        order = np.argsort(-self.gap().ravel(), kind="stable")
        kept = np.zeros(len(order), dtype=np.bool_)
        kept[order[np.cumsum(count[order]) <= most]] = True
        return np.asarray(active[:, kept[cell]])

    def _cells(self, active: Ints, per: tuple[int, int]) -> Ints:
        columns = self.bounds.shape[2]
        return np.asarray((active[0] // per[0]) * columns + active[1] // per[1])

    def _look(self, left: Boxes, right: Boxes, active: Ints, per: tuple[int, int]) -> Ints:
        """Bound all active pairs of parts; returns those that still keep a cell loose."""
        used = [np.unique(side) for side in active]
        ends = [
            prepare_ends(self.field, box.take(rows), other)
            for box, rows, other in zip((left, right), used, (False, True), strict=True)
        ]
        places = np.searchsorted(used[1], active[1])
        row_cells = active[0] // per[0]
        kept = [np.zeros((2, 0), dtype=np.intp)]
        for cells in np.split(np.arange(active.shape[1]), np.flatnonzero(np.diff(row_cells)) + 1):
            rows = np.searchsorted(used[0], active[0, cells])
            values = self._row(ends[0], ends[1], rows, places[cells])
            columns = active[1, cells] // per[1]
            kept.append(active[:, cells[self._merge(int(row_cells[cells[0]]), columns, values)]])
        return np.hstack(kept)

    def _row(self, left: Ends, right: Ends, rows: Ints, places: Ints) -> Array:
        """Bounds and centre level (7, K) of pairs (rows, places), grouped by equal rows."""
        most = max(1, BLOCK_BYTES // (max(self.field.centres, 8) * 8))
        breaks = np.flatnonzero(np.diff(rows)) + 1
        out = np.empty((7, len(rows)))
        for group in np.split(np.arange(len(rows)), breaks):
            mine = left.take(rows[group[:1]])
            for start in range(0, len(group), most):
                some = group[start : start + most]
                theirs = right.take(places[some])
                out[:, some] = np.vstack(sub_bounds(self.field, mine, theirs, self.ask))
        return out

    def _merge(self, row: int, columns: Ints, values: Array) -> NDArray[np.bool_]:
        """Fold parts into the bounds of one row's cells; which of them are not settled."""
        np.minimum.at(self.seen[0, row], columns, values[6])
        np.maximum.at(self.seen[1, row], columns, values[6])
        low, high = self.seen[:, row, columns]
        loose = self.ask.loose(values[4], low, 1.0) | self.ask.loose(values[5], high, -1.0)
        touched = np.unique(columns)
        for k in range(6):
            fold, keep = (np.maximum, np.minimum) if k % 2 else (np.minimum, np.maximum)
            whole = self.settled[k, row].copy()
            fold.at(whole, columns, values[k])
            fold.at(self.settled[k, row], columns[~loose], values[k][~loose])
            self.bounds[k, row, touched] = keep(self.bounds[k, row, touched], whole[touched])
        if self.same:
            self.bounds[:, :, row], self.seen[:, :, row] = self.bounds[:, row], self.seen[:, row]
        return np.asarray(loose, dtype=np.bool_)


def _children(active: Ints, first: int, second: int) -> Ints:
    """Pairs of the parts of each pair, box-major, in the order of the first ends."""
    one = (active[0][:, None] * first + np.arange(first)).repeat(second, axis=1).ravel()
    two = active[1][:, None] * second + np.arange(second)
    two = np.tile(two, (1, first)).ravel()
    order = np.lexsort((two, one))
    return np.stack([one[order], two[order]])
