"""Threshold literals against the definition, at points inside cells and on their borders."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from support.links import World, optimum, square, touching, tree

from stlc.milp.context import Context
from stlc.milp.tables import add_link_cost, link_literal
from stlc.milp.tables.cover import cover
from stlc.radio.partition import Partition, grid

TWO = {"a": (0.5, 0.5), "b": (2.5, 0.5)}


def highest(ctx: Context, column: int, points: dict[str, tuple[float, float]]) -> float:
    """The literal's largest value with the agents at these points at step 1."""
    pinned = {}
    for name, point in points.items():
        pinned |= dict(zip(ctx.states[name][1].tolist(), point, strict=True))
    ctx.builder.add_cost([column], -1.0)
    found = optimum(ctx.builder.build(), pinned)
    ctx.builder.add_cost([column], 1.0)
    assert found is not None
    return -found


def holds(partition: Partition, allowed: np.ndarray, *points: tuple[float, float]) -> bool:
    """Some touching cell (pair) is allowed."""
    return bool(allowed[np.ix_(*(touching(partition, p) for p in points))].any())


def points_to_try(seed: int) -> list[tuple[float, float]]:
    """Random points, one on a border and one on a corner."""
    rng = np.random.default_rng(seed)
    inside = [tuple(float(c) for c in rng.uniform(0.05, 2.95, 2)) for _ in range(3)]
    return [*inside, (1.0, 0.4), (2.0, 1.0)]


@pytest.mark.parametrize("partition", [square(3), grid([0, 1, 3], [0, 0.4, 1, 3]), tree()])
@pytest.mark.parametrize("share", [0.15, 0.5, 0.9])
@pytest.mark.parametrize("with_cost", [False, True])
def test_two_agents(partition: Partition, share: float, with_cost: bool) -> None:
    world = World(TWO, partition, steps=1, u_max=3.0)
    count = len(partition)
    allowed = np.random.default_rng(int(100 * share)).random((count, count)) < share
    ctx = world.context()
    if with_cost:
        add_link_cost(ctx, world.channel, ("a", "b"), world.table(1), [1], 1e-9)
    column = link_literal(ctx, world.channel, ("a", "b"), allowed, 1)
    for a, b in zip(points_to_try(1), points_to_try(2)[::-1], strict=True):
        expected = holds(partition, allowed, a, b)
        assert highest(ctx, column, {"a": a, "b": b}) == pytest.approx(float(expected), abs=1e-6)


@pytest.mark.parametrize("partition", [square(3), tree()])
def test_agent_and_station(partition: Partition) -> None:
    world = World({"a": (0.5, 0.5)}, partition, steps=1, u_max=3.0)
    allowed = np.random.default_rng(3).random(len(partition)) < 0.5
    ctx = world.context()
    column = link_literal(ctx, world.channel, ("a", "base"), allowed, 1)
    for point in points_to_try(4):
        expected = holds(partition, allowed, point)
        assert highest(ctx, column, {"a": point}) == pytest.approx(float(expected), abs=1e-6)


def test_swapped_pairs_share_columns() -> None:
    world = World(TWO, square(3), steps=1, u_max=3.0)
    allowed = np.random.default_rng(5).random((9, 9)) < 0.4
    ctx = world.context()
    column = link_literal(ctx, world.channel, ("a", "b"), allowed, 1)
    before = ctx.builder.columns
    assert link_literal(ctx, world.channel, ("b", "a"), allowed.T, 1) == column
    assert ctx.builder.columns == before


def test_nothing_allowed_and_everything_allowed() -> None:
    world = World(TWO, square(3), steps=1, u_max=3.0)
    here = {"a": (0.5, 0.5), "b": (0.5, 0.5)}
    for value in (False, True):
        ctx = world.context()
        allowed = np.full((9, 9), value)
        column = link_literal(ctx, world.channel, ("a", "b"), allowed, 1)
        assert highest(ctx, column, here) == float(value)


def test_two_stations_are_a_constant() -> None:
    for value in (False, True):
        ctx = World(TWO, square(3), steps=1).context()
        channel = ctx.mission.channels["radio"]
        column = link_literal(ctx, channel, ("base", "base"), value, 1)
        assert highest(ctx, column, {}) == float(value)


def test_a_scattered_set_falls_back_to_pair_columns() -> None:
    world = World(TWO, square(4), steps=1, u_max=3.0)
    chess = np.indices((4, 4, 4, 4)).sum(axis=0) % 2 == 1  # no box of it is larger than one pair
    allowed = chess.reshape(16, 16)
    ctx = world.context()
    column = link_literal(ctx, world.channel, ("a", "b"), allowed, 1)
    names = {b.name for b in ctx.builder.build().col_blocks}
    assert "pair_a_b_1" in names
    here, there = (0.3, 0.3), (0.3, 1.0)
    assert highest(ctx, column, {"a": here, "b": here}) == pytest.approx(0.0, abs=1e-6)
    assert highest(ctx, column, {"a": here, "b": there}) == pytest.approx(1.0, abs=1e-6)


@given(arrays(bool, st.tuples(*[st.integers(1, 4)] * 4)))
def test_covers_are_exact(allowed: np.ndarray) -> None:
    boxes = cover(allowed, allowed.size)
    assert boxes is not None
    union = np.zeros_like(allowed)
    for box in boxes:
        window = tuple(slice(a, b + 1) for a, b in zip(box[0::2], box[1::2], strict=True))
        assert allowed[window].all()
        union[window] = True
    assert np.array_equal(union, allowed)
    assert len(boxes) <= np.count_nonzero(allowed)


def test_a_band_needs_few_boxes() -> None:
    index = np.indices((8, 8, 8, 8))
    near = (np.abs(index[0] - index[2]) <= 2) & (np.abs(index[1] - index[3]) <= 2)
    boxes = cover(near, 400)
    assert boxes is not None
    assert len(boxes) < 60  # 36 would do (6 windows along each axis); the band has 1156 pairs
