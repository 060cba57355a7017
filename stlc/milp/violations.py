"""How far a point is from satisfying a Model, in extended precision."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.arrays import Floats, Ints
from stlc.milp.model import Model
from stlc.violation import Violations


def violations(model: Model, x: Floats) -> Violations:
    """Largest violations of rows, bounds and integrality at x (n,), all absolute."""
    activity, size = _activity(model, x)
    rows = _outside(activity, model.row_lower, model.row_upper)
    out = np.flatnonzero((x < model.col_lower) | (x > model.col_upper))
    wide = x[out].astype(np.longdouble)
    bounds = _outside(wide, model.col_lower[out], model.col_upper[out])
    broken = np.flatnonzero((model.integrality == 1) & (x != np.round(x)))
    whole = np.abs(x[broken].astype(np.longdouble) - np.round(x[broken]))
    return Violations(
        _largest(rows),
        _largest(bounds),
        _largest(whole),
        _largest(rows / (1 + size)),
        _largest(bounds / (1 + np.abs(wide))),
        _row_name(model, rows),
        _column_name(model, out, bounds),
        _column_name(model, broken, whole),
    )


def exact_objective(model: Model, x: Floats) -> float:
    """c'x + offset, summed in extended precision, rounded once."""
    used = np.flatnonzero(x)
    products = model.c[used].astype(np.longdouble) * x[used]
    return float(products.sum() + np.longdouble(model.offset))


_Wide = NDArray[Any]


def _activity(model: Model, x: Floats) -> tuple[_Wide, _Wide]:
    """A x, and the sum of |a_ij x_j| of each row; terms of columns at 0 are passed over."""
    A, used = model.A, x != 0
    activity, size = np.zeros((2, model.rows), dtype=np.longdouble)
    for rows, inside in model.row_slices():
        columns = A.indices[inside]
        which = np.flatnonzero(used[columns])
        terms = A.data[inside][which].astype(np.longdouble) * x[columns[which]]
        starts = np.searchsorted(which, A.indptr[rows.start : rows.stop + 1] - inside.start)
        activity[rows] = _row_sums(starts, terms)
        size[rows] = _row_sums(starts, np.abs(terms))
    return activity, size


def _row_sums(starts: NDArray[Any], terms: _Wide) -> _Wide:
    sums = np.zeros(len(starts) - 1, dtype=np.longdouble)
    filled = np.flatnonzero(np.diff(starts))
    if len(filled):
        sums[filled] = np.add.reduceat(terms, starts[filled])
    return sums


def _outside(value: _Wide, lower: Floats, upper: Floats) -> _Wide:
    below: _Wide = np.maximum(lower - value, value - upper)
    return np.maximum(below, 0.0)


def _largest(values: _Wide) -> float:
    return float(values.max()) if len(values) else 0.0


def _column_name(model: Model, columns: Ints, values: _Wide) -> str | None:
    """Name of the column with the largest value; `columns` (k,) are those of `values` (k,)."""
    return model.col_name(int(columns[values.argmax()])) if len(values) else None


def _row_name(model: Model, values: _Wide) -> str | None:
    if not len(values) or not values.any():
        return None
    row = int(values.argmax())
    block = model.row_block(row)
    origin = block.origin.label if block.origin.span is None else str(block.origin.span)
    return f"{block.member(row - block.start)} ({origin})"
