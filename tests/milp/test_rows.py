"""Rows that are packed a few at a time make the same matrix as all triplets at once."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stlc.milp.rows
from stlc.milp.big_m import _largest_in_rows
from stlc.milp.builder import ModelBuilder
from stlc.milp.model import Model

COLUMNS = 5
ENTRY = st.tuples(
    st.integers(0, 2), st.integers(0, COLUMNS - 1), st.sampled_from([-2.0, 0.0, 1.0, 2.0])
)
Blocks = list[list[tuple[int, int, float]]]
BLOCKS = st.lists(st.lists(ENTRY, max_size=6), max_size=6)


def built(blocks: Blocks, waiting: int) -> Model:
    """Three rows a block."""
    builder = ModelBuilder()
    builder.binary("z", (2,))
    builder.add_columns("x", (COLUMNS - 2,), [-1, 0, 1], 3.0, cost=2.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stlc.milp.rows, "_WAITING", waiting)
        for entries in blocks:
            rows, cols, values = np.array(entries, float).reshape(-1, 3).T
            builder.add_rows("r", rows.astype(int), cols.astype(int), values, 0.0, 1.0, count=3)
        return builder.build()


def dense(blocks: Blocks) -> np.ndarray:
    matrix = np.zeros((3 * len(blocks), COLUMNS))
    for number, entries in enumerate(blocks):
        for row, column, value in entries:
            matrix[3 * number + row, column] += value
    return matrix


@given(BLOCKS, st.sampled_from([0, 3, 1000]))
def test_packed_rows_are_the_sums_of_their_triplets(blocks: Blocks, waiting: int) -> None:
    A = built(blocks, waiting).A
    assert np.array_equal(A.toarray(), dense(blocks))
    assert A.has_canonical_format
    assert A.data.all()
    assert A.indices.dtype == A.indptr.dtype == np.int32


def test_numbers_and_arrays_spread_over_columns() -> None:
    model = built([], 1000)
    assert model.A.shape == (0, COLUMNS)
    assert model.col_lower.tolist() == [0, 0, -1, 0, 1]
    assert model.col_upper.tolist() == [1, 1, 3, 3, 3]
    assert model.c.tolist() == [0, 0, 2, 2, 2]
    assert model.integrality.tolist() == [1, 1, 0, 0, 0]


@given(BLOCKS, st.integers(1, 8))
def test_slices_cover_all_rows_in_order(blocks: Blocks, most: int) -> None:
    model = built(blocks, 1000)
    row = entry = 0
    for rows, inside in model.row_slices(most):
        assert (rows.start, inside.start) == (row, entry)
        row, entry = rows.stop, inside.stop
        assert inside.stop == model.A.indptr[rows.stop]
        assert inside.stop - inside.start <= most or rows.stop - rows.start == 1
    assert (row, entry) == (model.rows, model.nonzeros)


@given(BLOCKS)
def test_a_big_m_is_the_largest_integer_coefficient_beside_continuous_ones(blocks: Blocks) -> None:
    matrix = dense(blocks)
    mixed = (matrix[:, 2:] != 0).any(axis=1)
    expected = np.where(mixed, np.abs(matrix[:, :2]).max(axis=1, initial=0.0), 0.0)
    assert np.array_equal(_largest_in_rows(built(blocks, 1000)), expected)
