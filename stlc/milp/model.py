"""The mixed-integer linear program: one frozen object for every backend and writer.

    minimise    c'x + offset
    subject to  row_lower <= A x <= row_upper,  col_lower <= x <= col_upper,
                x_j integer where integrality_j = 1

Every column and row belongs to a block (name, shape) and has an origin: the span it came from.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stlc.arrays import Floats
from stlc.source import Span

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


@dataclass(frozen=True, slots=True)
class Origin:
    """Why a block exists: a requirement's or declaration's name, and its place in the file."""

    label: str
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Block:
    """Consecutive columns (or rows) `start .. start + prod(shape) - 1`, in C order."""

    name: str
    start: int
    shape: tuple[int, ...]
    origin: Origin

    @property
    def size(self) -> int:
        """Number of members."""
        return int(np.prod(self.shape, dtype=np.int64))

    def member(self, number: int) -> str:
        """Name of one member: `name_i_j`, letters, digits and `_` only."""
        place = np.unravel_index(number, self.shape) if self.shape else ()
        return "_".join([self.name, *(str(int(i)) for i in place)])


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """A MILP in arrays. n columns, m rows; `A` is CSR (m, n) with sorted indices, no duplicates."""

    c: Floats  # (n,)
    offset: float
    A: csr_matrix
    row_lower: Floats  # (m,)
    row_upper: Floats
    col_lower: Floats  # (n,)
    col_upper: Floats
    integrality: NDArray[np.uint8]  # (n,) 1: integer
    col_blocks: tuple[Block, ...]
    row_blocks: tuple[Block, ...]
    name: str = "mission"

    @property
    def columns(self) -> int:
        """Number of columns."""
        return len(self.c)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(self.row_lower)

    @property
    def binaries(self) -> int:
        """Number of integer columns whose bounds lie in [0, 1]."""
        within = (self.col_lower >= 0) & (self.col_upper <= 1)
        return int(np.count_nonzero(within & (self.integrality == 1)))

    @property
    def nonzeros(self) -> int:
        """Number of stored coefficients of A."""
        return int(self.A.nnz)

    def col_name(self, column: int) -> str:
        """Name of one column."""
        starts = [b.start for b in self.col_blocks]
        block = self.col_blocks[bisect_right(starts, column) - 1]
        return block.member(column - block.start)

    def row_block(self, row: int) -> Block:
        """The block a row belongs to."""
        starts = [b.start for b in self.row_blocks]
        return self.row_blocks[bisect_right(starts, row) - 1]

    def row_slices(self, nonzeros: int = 1 << 20) -> Iterator[tuple[slice, slice]]:
        """Consecutive rows, and where their coefficients are in `A.data`: few rows at a time.

        Each slice holds `nonzeros` coefficients at most, or is one row.
        """
        starts, first = self.A.indptr, 0
        while first < self.rows:
            fitting = int(np.searchsorted(starts, starts[first] + nonzeros, side="right")) - 1
            last = max(fitting, first + 1)
            yield slice(first, last), slice(int(starts[first]), int(starts[last]))
            first = last

    def objective(self, x: Floats) -> float:
        """c'x + offset at x (n,)."""
        return float(self.c @ x) + self.offset
