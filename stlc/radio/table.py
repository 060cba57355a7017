"""Link tables: one number for each pair of cells (or each cell, towards a station).

`centre` evaluates between the centres (the paper), `mean` integrates over both cells by
Gauss-Legendre quadrature (a cell with itself too: the clamped distance keeps it finite),
`worst` bounds the closed cell pair rigorously (`stlc.radio.bounds`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from stlc.radio.bounds import EVERYWHERE, PairBounds, pair_bounds
from stlc.radio.costs import CostName, cost_interval, link_cost
from stlc.radio.errors import RadioError
from stlc.radio.gp import ChannelModel
from stlc.radio.link_budget import LinkBudget, check_fading
from stlc.radio.link_ends import LinkEnds
from stlc.radio.pairs import predict_pairs, row_blocks
from stlc.radio.partition import Partition
from stlc.radio.taylor import Boxes

Array = NDArray[np.float64]
BoundName = Literal["centre", "mean", "worst"]

QUADRATURE = 2
QUADRATURE_NEAR = 5

SPREAD_COSTS = (
    CostName.INV_SNR,
    CostName.ETX,
    CostName.NEG_LOG_PRR,
    CostName.OUTAGE,
    CostName.ENERGY,
)


@dataclass(frozen=True, slots=True, eq=False)
class LinkTable:
    """Values for cell pairs.

    stored     (na, nb), or the upper triangle by rows (n (n + 1) / 2,) of a symmetric table
    first      cells of one end
    second     cells of the other end; None for a station (nb = 1)
    symmetric  both ends share one partition and value(i, j) = value(j, i)
    unit       of the values
    notes      remarks to show: clamped values, warnings of the cost
    """

    stored: Array
    first: Partition
    second: Partition | None
    symmetric: bool
    unit: str
    notes: tuple[str, ...] = ()

    @property
    def shape(self) -> tuple[int, int]:
        """(na, nb)."""
        return len(self.first), 1 if self.second is None else len(self.second)

    def matrix(self) -> Array:
        """All values (na, nb)."""
        if not self.symmetric:
            return self.stored
        count = len(self.first)
        full = np.empty((count, count))
        upper = np.triu_indices(count)
        full[upper] = self.stored
        full.T[upper] = self.stored
        return full

    def at(self, i: int, j: int = 0) -> float:
        """The value of cells i and j."""
        if not self.symmetric:
            return float(self.stored[i, j])
        low, high = min(i, j), max(i, j)
        return float(self.stored[low * len(self.first) - low * (low - 1) // 2 + high - low])

    def at_points(self, a: Array, b: Array | None = None, largest: bool = False) -> float:
        """The least (or largest) value among the cells that touch the points (D,) [m].

        Raises RadioError for a point outside the partition.
        """
        rows = self.first.cells_at(a)
        columns = np.zeros(1, dtype=np.intp)
        if self.second is not None:
            if b is None:
                raise RadioError("this table is between two moving ends: give both points")
            columns = self.second.cells_at(b)
        if not (len(rows) and len(columns)):
            raise RadioError("a point lies outside the partition of the channel")
        values = [self.at(int(i), int(j)) for i in rows for j in columns]
        return max(values) if largest else min(values)


def make_table(
    values: Array,
    first: Partition,
    second: Partition | None,
    unit: str,
    notes: tuple[str, ...] = (),
) -> LinkTable:
    """A table from values (na, nb), stored once when it is symmetric.

    Raises RadioError when the shape does not fit the partitions or a value is not finite.
    """
    expected = (len(first), 1 if second is None else len(second))
    values = np.asarray(values, dtype=np.float64)
    if values.shape == (len(first),) and second is None:
        values = values[:, None]
    if values.shape != expected:
        raise RadioError(f"the table has shape {values.shape}; the cells need {expected}")
    if not np.isfinite(values).all():
        raise RadioError("the table holds values that are not finite")
    if second is first and np.array_equal(values, values.T):
        return LinkTable(values[np.triu_indices(len(first))], first, second, True, unit, notes)
    return LinkTable(values, first, second, False, unit, notes)


def cost_table(
    model: ChannelModel, ends: LinkEnds, cost: CostName, budget: LinkBudget, bound: BoundName
) -> LinkTable:
    """Table of a link cost (fading included); `worst` is the highest cost in each cell pair.

    Raises RadioError when the budget lacks what the cost needs, or fading would count twice.
    """
    if cost in (CostName.ETX, CostName.NEG_LOG_PRR, CostName.ENERGY):
        check_fading(budget.modulation, model.fading)
    if bound == "worst":
        found = bound_ends(model, ends, 0.0, cost in SPREAD_COSTS)
        high = cost_interval(cost, found.mean, found.sigma, budget)
        return make_table(high.values, ends.first, ends.second_cells, cost.value, high.notes)
    notes: set[str] = set()

    def evaluate(mean: Array, sigma: Array) -> Array:
        """Costs at mean and sigma [dB]; what is to be said of them is noted."""
        got = link_cost(cost, mean, sigma, budget)
        notes.update(got.notes)
        return got.values

    values = tabulate(model, ends, evaluate, bound)
    return make_table(values, ends.first, ends.second_cells, cost.value, tuple(sorted(notes)))


def bound_ends(
    model: ChannelModel,
    ends: LinkEnds,
    z: float,
    spread: bool = True,
    focus: tuple[float, float] = EVERYWHERE,
) -> PairBounds:
    """Rigorous bounds of mean, sigma (fading included) and mean - z sigma over the cells.

    spread=False: sigma is not needed, its bounds may be wide (much faster). focus: see
    `pair_bounds`, in levels before calibration.
    """
    first, second = ends.boxes()
    other = None if ends.symmetric else second
    model = replace(model, deviation=model.deviation + model.offset_variance(ends.receiver))
    found = pair_bounds(model, first, other, z=z, spread=spread, focus=focus)
    shift = model.offset(ends.receiver)
    mean = found.mean[0] + shift, found.mean[1] + shift
    level = found.level[0] + shift, found.level[1] + shift
    return PairBounds(mean, found.sigma, level, found.gap, found.parts)


def tabulate(
    model: ChannelModel,
    ends: LinkEnds,
    evaluate: Callable[[Array, Array], Array],
    bound: Literal["centre", "mean"],
) -> Array:
    """`evaluate(mean, sigma)` for each cell pair (na, nb): at the centres, or averaged."""
    first, second = ends.boxes()
    if bound == "centre":
        return _evaluate_pairs(model, first.centre, second.centre, ends, evaluate)
    values = _quadrature(model, first, second, ends, evaluate, QUADRATURE)
    rows, columns = _near_pairs(first, second)
    for i in np.unique(rows):
        near = columns[rows == i]
        one = Boxes(first.centre[i : i + 1], first.half[i : i + 1])
        many = Boxes(second.centre[near], second.half[near])
        values[i, near] = _quadrature(model, one, many, ends, evaluate, QUADRATURE_NEAR)[0]
    return (values + values.T) / 2.0 if ends.symmetric else values


def _evaluate_pairs(
    model: ChannelModel,
    a: Array,
    b: Array,
    ends: LinkEnds,
    evaluate: Callable[[Array, Array], Array],
) -> Array:
    """A function of mean and sigma for each pair of points of a and b, (len(a), len(b)); the mean
    of both directions where ends are alike."""
    mean, variance = predict_pairs(model, a, b, True, ends.receiver)
    values = evaluate(mean, np.sqrt(variance))
    same = ends.symmetric and a.shape == b.shape
    return (values + values.T) / 2.0 if same else values


def _quadrature(
    model: ChannelModel,
    a: Boxes,
    b: Boxes,
    ends: LinkEnds,
    evaluate: Callable[[Array, Array], Array],
    order: int,
) -> Array:
    """Tensor Gauss-Legendre averages over pairs of boxes (na, nb)."""
    points_a, weight_a = _nodes(a, order)
    points_b, weight_b = _nodes(b, order)
    out = np.empty((len(a), len(b)))
    per_a = len(weight_a)
    for rows in row_blocks(len(a), per_a * len(points_b) * 64):
        part = points_a[rows.start * per_a : rows.stop * per_a]
        mean, variance = predict_pairs(model, part, points_b, True, ends.receiver)
        values = evaluate(mean, np.sqrt(variance))
        cube = values.reshape(rows.stop - rows.start, per_a, len(b), len(weight_b))
        out[rows] = np.einsum("ipjq,p,q->ij", cube, weight_a, weight_b)
    return out


def _nodes(boxes: Boxes, order: int) -> tuple[Array, Array]:
    """Points (n k, D), box-major, and weights (k,) that sum to one."""
    node, weight = np.polynomial.legendre.leggauss(order)
    axes = [k for k in range(boxes.centre.shape[1]) if (boxes.half[:, k] > 0).any()]
    mesh = np.meshgrid(*[node] * len(axes), indexing="ij") if axes else []
    weights = np.ones(1)
    for _ in axes:
        weights = np.multiply.outer(weights, weight / 2.0).ravel()
    points = np.repeat(boxes.centre, len(weights), axis=0)
    half = np.repeat(boxes.half, len(weights), axis=0)
    for axis, shift in zip(axes, mesh, strict=True):
        points[:, axis] += np.tile(shift.ravel(), len(boxes)) * half[:, axis]
    return points, weights


def _near_pairs(a: Boxes, b: Boxes) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Cell pairs so close that the path loss bends within them."""
    gap = np.zeros((len(a), len(b)))
    for axis in range(a.centre.shape[1]):
        apart = np.abs(a.centre[:, axis, None] - b.centre[None, :, axis])
        reach = a.half[:, axis, None] + b.half[None, :, axis]
        gap = np.maximum(gap, apart - 1.01 * reach)
    rows, columns = np.nonzero(gap <= 0.0)
    return rows, columns
