"""Rows of a sparse matrix as they come: triplets wait for a while, then turn into CSR.

CSR takes half the space of triplets, and a few rows at a time sort in the processor's cache.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stlc.arrays import Floats, Ints

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

_WAITING = 1 << 20  # triplets


@dataclass(slots=True)
class Rows:
    """A growing CSR matrix; `count` rows so far, those that wait included."""

    count: int = 0
    _packed: int = 0
    _waiting: int = 0
    _triplets: list[tuple[Ints, Ints, Floats]] = field(default_factory=list)
    _starts: list[Ints] = field(default_factory=lambda: [np.zeros(1, np.int64)])
    _indices: NDArray[np.int32] = field(default_factory=lambda: np.empty(0, np.int32))
    _data: Floats = field(default_factory=lambda: np.empty(0))

    def add(self, rows: Ints, cols: Ints, values: Floats, count: int, columns: int) -> None:
        """Add `count` rows as triplets (k,), `rows` from 0; `columns` is how many there are."""
        self._triplets.append((rows + (self.count - self._packed), cols, values))
        self._waiting += len(values)
        self.count += count
        if self._waiting > _WAITING:
            self._pack(columns)

    def matrix(self, columns: int) -> csr_matrix:
        """All rows. Duplicates are summed, exact zeros dropped, indices sorted."""
        from scipy.sparse import csr_matrix

        self._pack(columns)
        most = max(len(self._data), self.count, columns)
        index = np.int32 if most <= np.iinfo(np.int32).max else np.int64
        starts = np.concatenate(self._starts).astype(index)
        indices = self._indices.astype(index, copy=False)
        return csr_matrix((self._data, indices, starts), shape=(self.count, columns))

    def _pack(self, columns: int) -> None:
        """Turn the triplets that wait into rows."""
        from scipy.sparse import coo_matrix

        empty = np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0)
        rows, cols, values = map(np.concatenate, zip(empty, *self._triplets, strict=True))
        if not values.all():
            used = values != 0
            rows, cols, values = rows[used], cols[used], values[used]
        shape = (self.count - self._packed, columns)
        part = coo_matrix((values, (rows, cols)), shape=shape).tocsr()
        part.sum_duplicates()
        part.eliminate_zeros()
        self._triplets, self._waiting, self._packed = [], 0, self.count
        self._append(part)

    def _append(self, part: csr_matrix) -> None:
        """Grow in place: the system moves pages, nothing is copied."""
        first, last = len(self._data), len(self._data) + part.nnz
        self._indices.resize(last, refcheck=False)
        self._data.resize(last, refcheck=False)
        self._indices[first:], self._data[first:] = part.indices, part.data
        self._starts.append(part.indptr[1:].astype(np.int64) + first)
