"""The models of the conformance suite: small ones with known optima, and a hard one."""

from __future__ import annotations

import numpy as np

from stlc.milp.builder import ModelBuilder
from stlc.milp.model import Model

INF = float("inf")


def production() -> Model:
    """max 3x + 5y, x <= 4, 2y <= 12, 3x + 2y <= 18 (Hillier and Lieberman): 36 at (2, 6)."""
    b = ModelBuilder("production")
    x = b.add_columns("x", (2,), cost=[-3, -5])
    b.add_dense_rows("plant", x[None, [0, 0, 1]][:, :1], 1, -INF, 4)
    b.add_dense_rows("hall", x[None, 1:], 2, -INF, 12)
    b.add_dense_rows("line", x[None, :], [3, 2], -INF, 18)
    return b.build()


def knapsack(items: int = 12, rows: int = 3, seed: int = 1) -> Model:
    """A multi-dimensional knapsack; larger ones are hard enough for time limits."""
    rng = np.random.default_rng(seed)
    b = ModelBuilder("knapsack")
    take = b.binary("take", (items,), cost=-rng.integers(10, 99, items))
    weight = rng.integers(5, 60, (rows, items))
    cols = np.broadcast_to(take, weight.shape)
    b.add_dense_rows("capacity", cols, weight, -INF, weight.sum(axis=1) // 3)
    return b.build()


def best_knapsack() -> float:
    """By enumeration."""
    model = knapsack()
    points = (np.arange(1 << model.columns)[:, None] >> np.arange(model.columns)) & 1
    weights = model.A @ points.T
    fits = (weights <= model.row_upper[:, None]).all(axis=0)
    return float((points[fits] @ model.c).min())


def general_integers() -> Model:
    """min x + y, 3x + 5y >= 31, integers in [-3, 9]: 5 at (-3, 8)."""
    b = ModelBuilder("general")
    x = b.add_columns("x", (2,), -3, 9, integer=True, cost=1)
    b.add_dense_rows("cover", x[None, :], [3, 5], 31, INF)
    return b.build()


def negative_integers() -> Model:
    """min x, 2x >= -7, x an integer without bounds: -3."""
    b = ModelBuilder("negative")
    x = b.add_columns("x", (1,), -INF, INF, integer=True, cost=1)
    b.add_dense_rows("floor", x[None, :], 2, -7, INF)
    return b.build()


def free_columns() -> Model:
    """min |z - 4| + |w + 3| by free z = -1, w: 5 + 0."""
    b = ModelBuilder("free")
    z = b.add_columns("z", (2,), -INF, INF)
    t = b.add_columns("t", (2,), cost=1)
    target = np.array([4.0, -3.0])
    pair = np.stack([t, z], -1)
    b.add_dense_rows("above", pair, [1, -1], -target, INF)
    b.add_dense_rows("below", pair, [1, 1], target, INF)
    b.add_dense_rows("pin", z[None, :1], 1, -1, -1)
    return b.build()


def fixed_columns() -> Model:
    """Columns fixed by their bounds, integer and continuous: 2.5 + 3 + 1."""
    b = ModelBuilder("fixed")
    x = b.add_columns("x", (1,), 2.5, 2.5, cost=1)
    n = b.add_columns("n", (1,), 3, 3, integer=True, cost=1)
    y = b.add_columns("y", (1,), 0, 9, cost=1)
    b.add_dense_rows("row", np.concatenate([x, n, y])[None, :], [1, 1, 1], 6.5, INF)
    return b.build()


def equalities() -> Model:
    """x + y = 10, x - y = 3, integer slack: x = 6.5."""
    b = ModelBuilder("equalities")
    x = b.add_columns("x", (2,), cost=[1, 0])
    b.add_dense_rows("row", np.broadcast_to(x, (2, 2)), [[1, 1], [1, -1]], [10, 3], [10, 3])
    return b.build()


def ranges() -> Model:
    """-2 <= x - y <= 5 and 1 <= x + 2y <= 8: max x + y is 7 (x = 6, y = 1)."""
    b = ModelBuilder("ranges")
    x = b.add_columns("x", (2,), 0, 10, cost=-1)
    b.add_dense_rows("row", np.broadcast_to(x, (2, 2)), [[1, -1], [1, 2]], [-2, 1], [5, 8])
    return b.build()


def offset() -> Model:
    """The constant 100.25 belongs to objective and bound."""
    b = ModelBuilder("offset", offset=100.25)
    x = b.add_columns("x", (2,), 0, 5, integer=True, cost=[1, 2])
    b.add_dense_rows("row", x[None, :], [1, 1], 3, INF)
    return b.build()


def big_m() -> Model:
    """Outside a box: x <= 2 or x >= 7 by a binary and M = 20; nearest to 5 is 7 at cost 2."""
    b = ModelBuilder("disjunction")
    x = b.add_columns("x", (1,), -10, 10)
    side = b.binary("side", (1,))
    t = b.add_columns("t", (1,), cost=1)
    pair = np.concatenate([x, side])[None, :]
    b.add_dense_rows("left", pair, [1, -20], -INF, 2)
    b.add_dense_rows("right", pair, [1, -20], -13, INF)
    b.add_dense_rows("over", np.concatenate([t, x])[None, :], [1, -1], -5, INF)
    b.add_dense_rows("under", np.concatenate([t, x])[None, :], [1, 1], 5, INF)
    return b.build()


def duplicates() -> Model:
    """Entries given twice add up: 2x <= 8 by x + x."""
    b = ModelBuilder("duplicates")
    x = b.add_columns("x", (1,), cost=-1)
    b.add_rows("row", [0, 0], [x[0], x[0]], [1.0, 1.0], -INF, 8)
    return b.build()


def infeasible_lp() -> Model:
    """x1 + x2 >= 3 with x in [0, 1]^2: no point, and no integers either."""
    b = ModelBuilder("infeasible")
    x = b.add_columns("x", (2,), 0, 1, cost=1)
    b.add_dense_rows("row", x[None, :], [1, 1], 3, INF)
    return b.build()


def infeasible_mip() -> Model:
    """2x + 4y = 1 has rational points but no integer one."""
    b = ModelBuilder("parity")
    x = b.add_columns("x", (2,), -9, 9, integer=True, cost=1)
    b.add_dense_rows("row", x[None, :], [2, 4], 1, 1)
    return b.build()


def unbounded() -> Model:
    """min -x1 + x2 / 2 with x1 - x2 <= 5: the ray (1, 1) costs -1/2."""
    b = ModelBuilder("unbounded")
    x = b.add_columns("x", (2,), cost=[-1, 0.5])
    b.add_dense_rows("row", x[None, :], [1, -1], -INF, 5)
    return b.build()


def empty() -> Model:
    """Neither columns nor rows; the optimum is the offset, 2."""
    return ModelBuilder("empty", offset=2.0).build()


def rowless() -> Model:
    """Bounds alone, fractional ones for the integer: best at x = (-2.5, 4, any), n = -2."""
    b = ModelBuilder("rowless", offset=1.0)
    b.add_columns("x", (3,), -2.5, 4, cost=[1, -1, 0])
    b.add_columns("n", (1,), -2.5, 4, integer=True, cost=1)
    return b.build()


def unused() -> Model:
    """Columns in no row, an empty row, a free row."""
    b = ModelBuilder("unused")
    x = b.add_columns("x", (3,), 1, 4, cost=[1, -1, 0])
    b.add_rows("row", [0, 2], [x[0], x[0]], [1.0, 1.0], [2, -1, -INF], INF, count=3)
    return b.build()


def hard() -> Model:
    """A knapsack of 200 items and 30 rows: still open when a limit or a stop comes."""
    return knapsack(200, 30)
