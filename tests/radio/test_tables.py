import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stlc.radio.cover import cover_pairs
from stlc.radio.errors import RadioError
from stlc.radio.partition import Partition, grid, quadtree, split_cells, uniform_grid
from stlc.radio.table import make_table

CELLS = uniform_grid((0.0, 10.0), (0.0, 5.0), 10, 5)


def test_cells_are_numbered_along_columns_of_constant_x():
    assert CELLS.shape == (10, 5)
    for x, y in ((0.5, 0.5), (3.2, 4.9), (9.9, 0.1)):
        assert CELLS.cells_at((x, y)).tolist() == [5 * int(x) + int(y)]


def test_borders_belong_to_every_touching_cell():
    assert CELLS.cells_at((1.0, 0.5)).tolist() == [0, 5]
    assert CELLS.cells_at((1.0 + 9e-7, 1.0)).tolist() == [0, 1, 5, 6]
    assert CELLS.cells_at((1.0 + 2e-6, 0.5)).tolist() == [5]
    assert CELLS.cells_at((10.0, 5.0)).tolist() == [49]
    assert CELLS.cells_at((10.1, 5.0)).tolist() == []


def test_clip_cuts_cells_and_refuses_nothing_left():
    cut = CELLS.clip((0.5, 1.0), (2.25, 9.0))
    assert cut.edges is not None
    np.testing.assert_allclose(cut.edges[0], [0.5, 1.0, 2.0, 2.25])
    np.testing.assert_allclose(cut.edges[1], [1.0, 2.0, 3.0, 4.0, 5.0])
    with pytest.raises(RadioError, match="do not overlap"):
        CELLS.clip((20.0, 0.0), (30.0, 5.0))
    with pytest.raises(RadioError, match="strictly increasing"):
        grid([0.0, 0.0, 1.0], [0.0, 1.0])


def test_quadtree_refines_where_it_scores_and_keeps_the_area():
    def near_origin(partition: Partition):
        size = (partition.high - partition.low)[:, 0]
        return np.where(np.linalg.norm(partition.low, axis=1) < 1.0, size, 0.0)

    tree = quadtree(uniform_grid((0, 8), (0, 8), 2, 2), near_origin, 0.6, 60)
    area = (tree.high - tree.low).prod(axis=1)
    assert area.sum() == pytest.approx(64.0)
    assert area[tree.cells_at((0.1, 0.1))[0]] == pytest.approx(0.25)
    fine, owner = tree.common_grid()
    assert (owner >= 0).all()
    inside = fine.centres
    assert (inside > tree.low[owner]).all()
    assert (inside < tree.high[owner]).all()


def test_splitting_respects_the_limit_of_cells():
    tree = quadtree(uniform_grid((0, 8), (0, 8), 2, 2), lambda p: np.ones(len(p)), 0.0, 30)
    assert len(tree) <= 30
    assert len(split_cells(CELLS, np.array([0, 7]))) == len(CELLS) + 6


def test_symmetric_tables_are_stored_once():
    rng = np.random.default_rng(0)
    values = rng.normal(size=(50, 50))
    values = values + values.T
    table = make_table(values, CELLS, CELLS, "1")
    assert table.symmetric
    assert table.stored.shape == (50 * 51 // 2,)
    np.testing.assert_array_equal(table.matrix(), values)
    assert table.at(7, 31) == table.at(31, 7) == values[7, 31]
    assert not make_table(rng.normal(size=(50, 50)), CELLS, CELLS, "1").symmetric


def test_a_border_takes_the_best_touching_cell():
    values = np.arange(50.0)
    table = make_table(values, CELLS, None, "1")
    assert table.at_points(np.array([1.0, 1.0])) == 0.0
    assert table.at_points(np.array([1.0, 1.0]), largest=True) == 6.0
    with pytest.raises(RadioError, match="outside"):
        table.at_points(np.array([-1.0, 1.0]))
    with pytest.raises(RadioError, match="shape"):
        make_table(values[:-1], CELLS, None, "1")
    with pytest.raises(RadioError, match="not finite"):
        make_table(np.full(50, np.inf), CELLS, None, "1")


@given(
    seed=st.integers(0, 100_000),
    shape_a=st.tuples(st.integers(1, 5), st.integers(1, 4)),
    shape_b=st.none() | st.tuples(st.integers(1, 4), st.integers(1, 5)),
    share=st.floats(0.0, 1.0),
)
def test_cover_is_exactly_the_allowed_set(seed, shape_a, shape_b, share):
    count = int(np.prod(shape_a)), 1 if shape_b is None else int(np.prod(shape_b))
    allowed = np.random.default_rng(seed).uniform(size=count) < share
    full = np.zeros(shape_a if shape_b is None else (*shape_a, *shape_b), dtype=bool)
    boxes = cover_pairs(allowed, shape_a, shape_b)
    for box in boxes:
        full[box.slices] = True
    np.testing.assert_array_equal(full.reshape(count), allowed)
    assert len(boxes) <= allowed.sum()


def test_a_box_is_covered_by_one_box():
    allowed = np.zeros((6, 6, 6, 6), dtype=bool)
    allowed[1:4, :, 2:5, 3:] = True
    (box,) = cover_pairs(allowed.reshape(36, 36), (6, 6), (6, 6))
    assert box.intervals == ((1, 3), (0, 5), (2, 4), (3, 5))
