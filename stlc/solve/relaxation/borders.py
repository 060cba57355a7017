"""Borders between cells as cells of their own.

An agent on a border lets every table take its own touching cell. On the grid whose odd cells along
an axis are the borders (cell c is 2 c, the border before it 2 c - 1; m cells make 2 m - 1) it has
one place again: a table's entry there is the least of those it may take.
"""

from __future__ import annotations

import numpy as np

from stlc.arrays import Bools, Floats


def with_borders(table: Floats, shape: tuple[int, int]) -> Floats:
    """A table over the cells (nx, ny) of one or two agents, borders as cells of their own."""
    out = table.reshape(shape * table.ndim)
    for axis in range(out.ndim):
        rows = np.moveaxis(out, axis, 0)
        made = np.empty((2 * len(rows) - 1, *rows.shape[1:]))
        made[::2], made[1::2] = rows, np.minimum(rows[:-1], rows[1:])
        out = np.moveaxis(made, 0, axis)
    count = (2 * shape[0] - 1) * (2 * shape[1] - 1)
    return np.ascontiguousarray(out).reshape((count,) * table.ndim)


def taken(alive: Bools, shape: tuple[int, int]) -> Bools:
    """Cell pairs (n, n) that a table may take where pairs of cells and borders are alive."""
    out = alive.reshape((2 * shape[0] - 1, 2 * shape[1] - 1) * 2)
    for axis in range(4):
        rows = np.moveaxis(out, axis, 0)
        cells = rows[::2].copy()
        cells[:-1] |= rows[1::2]
        cells[1:] |= rows[1::2]
        out = np.moveaxis(cells, 0, axis)
    count = shape[0] * shape[1]
    return np.ascontiguousarray(out).reshape(count, count)
