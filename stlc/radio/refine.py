"""Quadtree scores: where a table varies, and where a threshold passes."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from stlc.radio.bounds import pair_bounds
from stlc.radio.gp import ChannelModel
from stlc.radio.link_ends import LinkEnds
from stlc.radio.partition import Partition

Array = NDArray[np.float64]

LOOK = 1e8
"""Multiplications spent on one look at a partition: scores need no tight bounds."""


def variation_score(
    model: ChannelModel, second: Array | None = None, threshold: float | None = None
) -> Callable[[Partition], Array]:
    """Score for `stlc.radio.partition.quadtree`: range [dB] of the posterior mean over a cell.

    second     the other end: points (k, 2) [m], such as stations; None: the cells' own centres
    threshold  [dBm]: cells on which the mean stays on one side of it score 0
    """

    def score(partition: Partition) -> Array:
        """For each cell, the greatest spread of the mean [dB] over its links, those that straddle
        the threshold alone where there is one."""
        cells, _ = LinkEnds(partition).boxes()
        points = partition.centres if second is None else np.atleast_2d(second)
        ends = type(cells)(points, np.zeros_like(points))
        found = pair_bounds(model, cells, ends, tolerance=0.5, budget=LOOK)
        low, high = found.mean
        spread = high - low
        if threshold is not None:
            spread = np.where((low < threshold) & (high > threshold), spread, 0.0)
        return np.asarray(spread.max(axis=1), dtype=np.float64)

    return score
