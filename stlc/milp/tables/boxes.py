"""Ties columns to index boxes over ordered binaries.

Columns y_k >= 0 with sum y <= 1 stand for boxes k, products of the intervals first_k .. last_k on
each axis. For every axis with ordered binaries b and every i that is the interval before some
box's first one, or some box's last:

    sum {y_k : first_k > i} <= b_i          sum {y_k : last_k <= i} <= 1 - b_i

At integer b only boxes that contain the point keep y > 0. Rows for other i are implied by the
order of b, so their number is at most twice that of the binaries, whatever the number of boxes.

Written out, a column stands in as many rows as there are bounds on its side. When that is much,
slacks t_i >= 0 make differences of neighbouring rows instead (i < i' the next one):

    sum {y_k : first_k = i + 1} = (b_i - t_i) - (b_i' - t_i')

and alike for the other family: the same relaxation, each column once an axis and family.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.arrays import Ints
from stlc.milp.builder import ModelBuilder


def join_boxes(
    builder: ModelBuilder, name: str, cols: Ints, boxes: Ints, axes: Sequence[Ints]
) -> None:
    """Add the rows. cols (K,); boxes (K, 2 d): first and last of each axis; axes: d times b."""
    for axis, binaries in enumerate(axes):
        first, last = boxes[:, 2 * axis], boxes[:, 2 * axis + 1]
        starting = first > 0
        if starting.any():
            # Counted from the far end both families grow with the rank.
            starts, rank = np.unique(-first[starting], return_inverse=True)
            _family(builder, f"{name}_from", cols[starting], rank, binaries[-starts - 1], 1.0)
        ending = last < len(binaries)
        if ending.any():
            ends, rank = np.unique(last[ending], return_inverse=True)
            _family(builder, f"{name}_to", cols[ending], rank, binaries[ends], -1.0)


def _family(
    builder: ModelBuilder, name: str, cols: Ints, rank: Ints, binaries: Ints, sign: float
) -> None:
    """sum {y_k : rank_k <= r} <= b_r (sign 1) or 1 - b_r (sign -1), r = 0 .. R-1."""
    count = len(binaries)
    every = np.arange(count)
    written = int((count - rank).sum())
    if written <= len(cols) + 4 * count:
        rows, members = np.nonzero(rank[None, :] <= every[:, None])
        builder.add_rows(
            name,
            np.concatenate([rows, every]),
            np.concatenate([cols[members], binaries]),
            np.concatenate([np.ones(len(rows)), np.full(count, -sign)]),
            -np.inf,
            float(sign < 0),
            count=count,
        )
        return
    slack = builder.add_columns(f"{name}_slack", (count,), 0.0, 1.0)
    right = np.zeros(count)
    right[0] = float(sign < 0)
    builder.add_rows(
        name,
        np.concatenate([rank, every, every, every[1:], every[1:]]),
        np.concatenate([cols, binaries, slack, binaries[:-1], slack[:-1]]),
        np.repeat([1.0, -sign, 1.0, sign, -1.0], [len(cols), count, count, count - 1, count - 1]),
        right,
        right,
        count=count,
    )
