"""Grows a Model block by block, rows as numpy arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stlc.arrays import Floats, Ints
from stlc.milp.model import Block, Model, Origin
from stlc.milp.rows import Rows


@dataclass(slots=True)
class ModelBuilder:
    """Collects columns and rows; `build` freezes them. Origins nest with `origin`."""

    name: str = "mission"
    offset: float = 0.0
    origin: Origin = field(default_factory=lambda: Origin("mission"))
    _columns: int = 0
    _rows: Rows = field(default_factory=Rows)
    _col_parts: list[tuple[Floats, Floats, Floats, NDArray[np.uint8]]] = field(default_factory=list)
    _row_parts: list[tuple[Floats, Floats]] = field(default_factory=list)
    _col_blocks: list[Block] = field(default_factory=list)
    _row_blocks: list[Block] = field(default_factory=list)
    _costs: list[tuple[Ints, Floats]] = field(default_factory=list)
    _used: dict[str, int] = field(default_factory=dict)
    _sum: tuple[int, float] | None = None  # where costs begin that are to become a row; the offset

    @property
    def columns(self) -> int:
        """Number of columns so far."""
        return self._columns

    @property
    def rows(self) -> int:
        """Number of rows so far."""
        return self._rows.count

    def add_columns(
        self,
        name: str,
        shape: Sequence[int],
        lower: ArrayLike = 0.0,
        upper: ArrayLike = np.inf,
        *,
        integer: bool = False,
        cost: ArrayLike = 0.0,
    ) -> Ints:
        """Add prod(shape) columns; bounds and costs broadcast. Returns indices of that shape."""
        shape = tuple(shape)
        block = Block(self._unique(name), self._columns, shape, self.origin)
        size = block.size
        spread = [_spread(v, shape, size) for v in (cost, lower, upper)]
        kind = np.broadcast_to(np.uint8(integer), (size,))
        self._col_parts.append((spread[0], spread[1], spread[2], kind))
        self._col_blocks.append(block)
        self._columns += size
        return np.arange(block.start, block.start + size).reshape(shape)

    def binary(self, name: str, shape: Sequence[int], *, cost: ArrayLike = 0.0) -> Ints:
        """Add 0-1 columns."""
        return self.add_columns(name, shape, 0.0, 1.0, integer=True, cost=cost)

    def add_rows(
        self,
        name: str,
        rows: ArrayLike,
        cols: ArrayLike,
        values: ArrayLike,
        lower: ArrayLike,
        upper: ArrayLike,
        count: int | None = None,
    ) -> Ints:
        """Add rows given as triplets; `rows` count from 0 within this block.

        `rows`, `cols`, `values` broadcast together; `lower`, `upper` broadcast to (count,).
        Duplicate (row, col) entries add up. Returns the row indices (count,).
        """
        r, c, v = np.broadcast_arrays(
            np.asarray(rows), np.asarray(cols), np.asarray(values, dtype=float)
        )
        size = int(r.max()) + 1 if count is None else count
        block = Block(self._unique(name), self.rows, (size,), self.origin)
        self._rows.add(r.ravel(), c.ravel(), v.ravel(), size, self._columns)
        bounds = [np.broadcast_to(np.asarray(b, dtype=float), (size,)) for b in (lower, upper)]
        self._row_parts.append((bounds[0], bounds[1]))
        self._row_blocks.append(block)
        return np.arange(block.start, block.start + size)

    def add_dense_rows(
        self, name: str, cols: ArrayLike, values: ArrayLike, lower: ArrayLike, upper: ArrayLike
    ) -> Ints:
        """Add rows with k entries each: cols and values broadcast to (count, k)."""
        c, v = np.broadcast_arrays(
            np.atleast_2d(cols), np.atleast_2d(np.asarray(values, dtype=float))
        )
        rows = np.broadcast_to(np.arange(len(c))[:, None], c.shape)
        return self.add_rows(name, rows, c, v, lower, upper, count=len(c))

    def add_cost(self, cols: ArrayLike, cost: ArrayLike) -> None:
        """Add to the objective coefficients of existing columns (accumulates)."""
        c, v = np.broadcast_arrays(np.asarray(cols), np.asarray(cost, dtype=float))
        self._costs.append((c.ravel(), v.ravel()))

    def begin_sum(self) -> None:
        """What is added to existing columns' costs from now on is a row's, not the objective's."""
        self._sum = len(self._costs), self.offset

    def end_sum(self, name: str, upper: float) -> None:
        """Add the row: what was gathered since `begin_sum`, constants included, is <= `upper`."""
        assert self._sum is not None
        (first, before), self._sum = self._sum, None
        gathered, self._costs = self._costs[first:], self._costs[:first]
        constant, self.offset = self.offset - before, before
        cols = np.concatenate([np.empty(0, np.int64), *(c for c, _ in gathered)])
        values = np.concatenate([np.empty(0), *(v for _, v in gathered)])
        zeros = np.zeros(len(cols), np.int64)
        self.add_rows(name, zeros, cols, values, -np.inf, upper - constant, count=1)

    def build(self) -> Model:
        """Freeze. Duplicates are summed, exact zeros dropped, indices sorted."""
        matrix = self._rows.matrix(self._columns)
        cost, lower, upper, integrality = self._stack_columns()
        row_lower = np.concatenate([np.empty(0), *(p[0] for p in self._row_parts)])
        row_upper = np.concatenate([np.empty(0), *(p[1] for p in self._row_parts)])
        return Model(
            cost, self.offset, matrix, row_lower, row_upper, lower, upper, integrality,
            tuple(self._col_blocks), tuple(self._row_blocks), self.name,
        )  # fmt: skip

    def _stack_columns(self) -> tuple[Floats, Floats, Floats, NDArray[np.uint8]]:
        parts = self._col_parts
        cost = np.concatenate([np.empty(0), *(p[0] for p in parts)])
        lower = np.concatenate([np.empty(0), *(p[1] for p in parts)])
        upper = np.concatenate([np.empty(0), *(p[2] for p in parts)])
        integrality = np.concatenate([np.empty(0, np.uint8), *(p[3] for p in parts)])
        for cols, values in self._costs:
            np.add.at(cost, cols, values)
        return cost, lower, upper, integrality

    def _unique(self, name: str) -> str:
        count = self._used.get(name, 0)
        self._used[name] = count + 1
        return name if count == 0 else f"{name}__{count}"


def _spread(value: ArrayLike, shape: tuple[int, ...], size: int) -> Floats:
    """A value for each of `size` members; a number takes no space."""
    array = np.asarray(value, dtype=float)
    if array.ndim == 0:
        return np.broadcast_to(array, (size,))
    return np.broadcast_to(array, shape).ravel()
