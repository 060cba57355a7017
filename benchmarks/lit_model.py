"""A synthetic model of the size of the paper's own table encoding.

75,000 columns (73,000 binary), 292,000 rows, 950,000 nonzeros, with the shape of a compiled
mission: few distinct coefficients, short rows, big-M rows, one-hot rows, continuous trajectories.
"""

from __future__ import annotations

import numpy as np

from stlc.milp.builder import ModelBuilder
from stlc.milp.model import Model

STEPS, CELLS = 8, 95  # 8 steps, 95 x 95 = 9,025 cell pairs a step


def lit_model(seed: int = 0) -> Model:
    """The model; the same for the same seed."""
    rng = np.random.default_rng(seed)
    b = ModelBuilder("lit", offset=1.25)
    pair = b.binary("pair", (STEPS, CELLS, CELLS), cost=rng.uniform(0, 20, (1, CELLS, CELLS)))
    cell = b.binary("cell", (2, STEPS, CELLS))
    motion = b.add_columns("x", (2, STEPS, 81), -10.0, 10.0)
    flat = pair.reshape(STEPS, -1)
    left = np.repeat(cell[0], CELLS, axis=1)
    right = np.tile(cell[1], (1, CELLS))
    b.add_dense_rows("left", np.stack([flat, left], -1).reshape(-1, 2), [1, -1], -np.inf, 0)
    b.add_dense_rows("right", np.stack([flat, right], -1).reshape(-1, 2), [1, -1], -np.inf, 0)
    both = np.stack([flat, left, right], -1).reshape(-1, 3)
    b.add_dense_rows("both", both, [1, -1, -1], -1, np.inf)
    b.add_dense_rows("one_pair", flat, 1.0, 1, 1)
    b.add_dense_rows("one_cell", cell.reshape(-1, CELLS), 1.0, 1, 1)
    _big_m(b, rng, motion, flat)
    return b.build()


def _big_m(b: ModelBuilder, rng: np.random.Generator, motion: np.ndarray, flat: np.ndarray) -> None:
    steps, agents = np.arange(STEPS)[:, None], np.arange(flat.shape[1])[None, :] % 2
    x = motion[agents, steps, rng.integers(0, 40, flat.shape)]
    y = motion[agents, steps, rng.integers(41, 81, flat.shape)]
    cols = np.stack([x, y, flat, np.roll(flat, 1, axis=1), np.roll(flat, 2, axis=1)], -1)
    size = cols.reshape(-1, 5)
    values = np.array([1.0, -0.7071067811865476, 19.3, 0.1, 0.3])
    b.add_dense_rows("near", size, values, -np.inf, np.round(rng.uniform(20, 30, len(size)), 1))
