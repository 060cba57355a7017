"""Fixes exclusive choices that have become free: one alternative asks for nothing any more.

Literals z of a choice add up to 1 and cost nothing. If with z_k = 1 and the others 0 every row
that holds one of them is satisfied wherever the other columns are within their bounds, then any
feasible point stays feasible, at the same cost, when the choice is set so; z can be fixed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.compile import Compiled
from stlc.milp.model import Model

_SLACK = 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Literals `columns` (k,) of one choice, the `rows` they stand in and `own` (rows, k), their
    coefficients there; `part` (rows, l) holds those of the `others` (l,)."""

    columns: Ints
    rows: Ints
    others: Ints
    part: Any
    own: Floats


def groups_of(compiled: Compiled, csc: Any) -> tuple[Group, ...]:
    """Exclusive choices without cost; csc: the model's matrix by columns."""
    model = compiled.model
    columns = [own for one in compiled.layout.encoded for _, own in one.whole_choices()]
    return tuple(_group(model, csc, c) for c in columns if not model.c[c].any())


def _group(model: Model, csc: Any, columns: Ints) -> Group:
    own = csc[:, columns]
    rows = np.unique(own.indices).astype(np.int64)
    part = model.A[rows]
    others = np.setdiff1d(part.indices, columns).astype(np.int64)
    return Group(columns, rows, others, part[:, others], own.tocsr()[rows].toarray())


def fix_free_choices(model: Model, groups: Sequence[Group], lower: Floats, upper: Floats) -> None:
    """Fix free choices by drawing in the bounds."""
    for group in groups:
        if (upper[group.columns] > 0).sum() < 2 or lower[group.columns].any():
            continue
        k = _free(model, group, lower, upper)
        if k is not None:
            upper[group.columns] = 0.0
            lower[group.columns[k]] = upper[group.columns[k]] = 1.0


def _free(model: Model, group: Group, lower: Floats, upper: Floats) -> int | None:
    """An alternative that satisfies all rows of the group by itself."""
    low, high = lower[group.others], upper[group.others]
    up, down = group.part.maximum(0), group.part.minimum(0)
    with np.errstate(invalid="ignore"):
        least, most = up @ low + down @ high, up @ high + down @ low
    fine = least[:, None] + group.own >= model.row_lower[group.rows][:, None] - _SLACK
    fine &= most[:, None] + group.own <= model.row_upper[group.rows][:, None] + _SLACK
    open_ = fine.all(0) & (upper[group.columns] > 0)
    return int(np.argmax(open_)) if open_.any() else None
