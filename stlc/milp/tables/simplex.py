"""Exactly one of m: three ways to say it with columns.

Every encoding speaks of indicators s_0 .. s_{m-1} >= 0 with sum 1 that are 0 or 1 at integer
points. They differ in the columns behind them:

ordered   m - 1 binaries b_0 >= b_1 >= ... ("unary", "incremental"); s_i = b_{i-1} - b_i with
          b_{-1} = 1 and b_{m-1} = 0. Columns m - 1, rows max(0, m - 2). Branching on b_i splits
          the axis in two, which is what makes it strong (Dantzig 1960, Yildiz & Vielma 2013).
one-hot   m binaries s_i, one row sum s = 1.
gray      m continuous s_i, one row sum s = 1, and B = ceil(log2 m) binaries y with rows
          sum_i s_i bit_l(gray(i)) = y_l (Vielma & Nemhauser 2011). Rows 1 + B, columns m + B.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.milp.builder import ModelBuilder


class Kind(Enum):
    """Which columns stand behind the indicators."""

    ORDERED = "ordered"
    ONE_HOT = "one-hot"
    GRAY = "gray"


@dataclass(frozen=True, slots=True, eq=False)
class Simplex:
    """s_i = constant_i + sum_k values[i, k] * x[cols[i, k]], for i = 0 .. m-1."""

    cols: Ints  # (m, w)
    values: Floats  # (m, w)
    constant: Floats  # (m,)

    def __len__(self) -> int:
        return len(self.constant)

    def weighted(self, weights: Floats) -> tuple[Ints, Floats, float]:
        """sum_i weights_i s_i as columns, coefficients and a constant."""
        values = (self.values * weights[:, None]).ravel()
        return self.cols.ravel(), values, float(weights @ self.constant)


def of_columns(cols: Ints) -> Simplex:
    """Indicators that are columns themselves."""
    return Simplex(cols[:, None], np.ones((len(cols), 1)), np.zeros(len(cols)))


def of_ordered(cols: Ints) -> Simplex:
    """Indicators from ordered binaries (m - 1,): their differences."""
    size = len(cols) + 1
    pairs = np.zeros((size, 2), np.int64)
    values = np.zeros((size, 2))
    pairs[1:, 0], values[1:, 0] = cols, 1.0
    pairs[:-1, 1], values[:-1, 1] = cols, -1.0
    constant = np.zeros(size)
    constant[0] = 1.0
    return Simplex(pairs, values, constant)


def ordered(builder: ModelBuilder, name: str, size: int) -> Ints:
    """Binaries b (size - 1,) with b_k >= b_{k+1}: b_k = 1 says "beyond choice k"."""
    if size == 1:
        return np.empty(0, np.int64)
    cols = builder.binary(name, (size - 1,))
    if size > 2:
        pairs = np.stack([cols[:-1], cols[1:]], axis=1)
        builder.add_dense_rows(f"{name}_order", pairs, [1.0, -1.0], 0.0, np.inf)
    return cols


def one_hot(builder: ModelBuilder, name: str, size: int) -> Simplex:
    """Binaries with sum 1."""
    cols = builder.binary(name, (size,))
    builder.add_dense_rows(f"{name}_one", cols, 1.0, 1.0, 1.0)
    return of_columns(cols)


def gray(builder: ModelBuilder, name: str, size: int) -> Simplex:
    """Continuous indicators with sum 1, tied to ceil(log2 size) binaries by a Gray code."""
    cols = builder.add_columns(name, (size,), 0.0, 1.0)
    builder.add_dense_rows(f"{name}_one", cols, 1.0, 1.0, 1.0)
    bits = bits_for(size)
    if bits:
        code = np.arange(size) ^ (np.arange(size) >> 1)
        which, choice = np.nonzero((code[None, :] >> np.arange(bits)[:, None]) & 1)
        digits = builder.binary(f"{name}_bit", (bits,))
        rows = np.concatenate([which, np.arange(bits)])
        values = np.concatenate([np.ones(len(which)), -np.ones(bits)])
        entries = np.concatenate([cols[choice], digits])
        builder.add_rows(f"{name}_code", rows, entries, values, 0.0, 0.0, count=bits)
    return of_columns(cols)


def bits_for(size: int) -> int:
    """ceil(log2 size): binaries of a code for `size` choices."""
    return max(size - 1, 0).bit_length()


def join(builder: ModelBuilder, name: str, labels: Ints, cols: Ints, simplex: Simplex) -> None:
    """Rows: the columns with label i add up to s_i, for every i. labels and cols are (N,)."""
    size, width = simplex.cols.shape
    # Older columns first: rows in order of their columns need no sorting.
    rows = np.concatenate([np.repeat(np.arange(size), width), labels])
    entries = np.concatenate([simplex.cols.ravel(), cols])
    values = np.concatenate([-simplex.values.ravel(), np.ones(len(cols))])
    builder.add_rows(name, rows, entries, values, simplex.constant, simplex.constant, count=size)
