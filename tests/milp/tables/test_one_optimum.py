"""Every encoding finds the same optimum, and it is the one that enumeration finds."""

import numpy as np
import pytest
from support.links import DOUBLE, World, all_pairs, enumerated, optimum, square, tree

from stlc.milp.tables import ENCODINGS, add_link_cost, link_value
from stlc.radio.partition import grid

NAMES = list(ENCODINGS)
TWO = {"a": (0.5, 0.5), "b": (2.5, 0.5)}


def cost_of(world: World, name: str, table: np.ndarray, effort: float = 0.0) -> float | None:
    ctx = world.context()
    for pair in all_pairs(sorted(world.starts)):
        add_link_cost(ctx, world.channel, pair, table, range(1, world.steps + 1), 0.9, name)
    add_effort(ctx, effort)
    return optimum(ctx.builder.build())


def add_effort(ctx, weight: float) -> None:
    for name, inputs in ctx.inputs.items():
        size = ctx.builder.add_columns(f"size_{name}", (inputs.size,), cost=weight)
        for sign in (1.0, -1.0):
            pairs = np.stack([size, inputs.ravel()], axis=1)
            ctx.builder.add_dense_rows(f"abs_{name}", pairs, [1.0, sign], 0.0, np.inf)


def assert_all_match(world: World, names: list[str], table: np.ndarray) -> None:
    expected = 0.9 * enumerated(world, table)
    for name in names:
        assert cost_of(world, name, table) == pytest.approx(expected, abs=1e-6), name


@pytest.mark.parametrize("seed", range(3))
def test_single_integrators_match_enumeration(seed: int) -> None:
    world = World(TWO, square(3), steps=2)
    assert_all_match(world, NAMES, world.table(seed))


def test_double_integrators_match_enumeration() -> None:
    world = World(TWO, square(3), steps=3, dynamics=DOUBLE)
    assert_all_match(world, NAMES, world.table(11))


def test_one_optimum_with_effort_on_larger_grids() -> None:
    world = World({"a": (0.5, 0.5), "b": (4.5, 1.0)}, square(5, 5.0), 3, side=5.0, dynamics=DOUBLE)
    table = world.table(0)
    names = [n for n in NAMES if not n.startswith("literal")]
    found = [cost_of(world, name, table, effort=0.1) for name in names]
    assert found == pytest.approx([found[0]] * len(found), abs=1e-5)


def test_three_agents_share_their_cells() -> None:
    world = World({**TWO, "c": (0.5, 2.5)}, square(3), steps=2)
    table = world.table(4)
    names = [n for n in NAMES if not n.startswith("literal")]
    found = [cost_of(world, name, table, effort=0.3) for name in names]
    assert found == pytest.approx([found[0]] * len(found), abs=1e-5)


def test_uneven_grids_and_quadtrees_match_enumeration() -> None:
    names = [n for n in NAMES if not n.startswith("literal")]
    for partition in (grid([0, 0.7, 3], [0, 1.1, 1.6, 3]), tree()):
        world = World(TWO, partition, steps=2)
        assert_all_match(world, names, world.table(5))


@pytest.mark.parametrize("name", NAMES)
def test_a_station_takes_its_value_vector(name: str) -> None:
    world = World({"a": (1.5, 1.5)}, square(3), steps=2)
    vector = world.table(6, ends=1)
    ctx = world.context()
    add_link_cost(ctx, world.channel, ("base", "a"), vector, [2], 2.0, name)
    assert optimum(ctx.builder.build()) == pytest.approx(2.0 * vector.min(), abs=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_two_stations_are_a_constant(name: str) -> None:
    ctx = World({"a": (1.5, 1.5)}, square(3), steps=1).context()
    channel = ctx.mission.channels["radio"]
    add_link_cost(ctx, channel, ("base", "base"), 1.5, [1], 2.0, name)
    assert ctx.builder.build().offset == pytest.approx(3.0)


def test_a_negative_weight_rewards_cost() -> None:
    world = World(TWO, square(3), steps=2)
    table = world.table(8)
    expected = enumerated(world, -table)
    for name in NAMES:
        ctx = world.context()
        add_link_cost(ctx, world.channel, ("a", "b"), table, [1, 2], -1.0, name)
        assert optimum(ctx.builder.build()) == pytest.approx(expected, abs=1e-6), name


@pytest.mark.parametrize("name", NAMES)
def test_values_are_exact_from_both_sides(name: str) -> None:
    world = World(TWO, square(3), steps=1, u_max=3.0)
    table = world.table(9)
    rng = np.random.default_rng(1)
    for sign in (1.0, -1.0):
        ctx = world.context()
        value = link_value(ctx, world.channel, ("b", "a"), table, 1, name)
        ctx.builder.add_cost(value.cols, sign * value.values)
        model = ctx.builder.build()
        for _ in range(5):
            cells = rng.integers(0, 3, (2, 2))
            pinned = dict(zip(ctx.states["a"][1], cells[0] + 0.5, strict=True))
            pinned |= dict(zip(ctx.states["b"][1], cells[1] + 0.5, strict=True))
            a, b = (int(3 * c[0] + c[1]) for c in cells)
            found = optimum(model, pinned)
            assert found is not None
            assert sign * found + value.constant == pytest.approx(table[b, a], abs=1e-6)
