"""On a border every table takes its own touching cell, in every encoding."""

import numpy as np
import pytest
from support.links import World, optimum, square, touching, tree

from stlc.milp.tables import ENCODINGS, add_link_cost, link_literal, link_value
from stlc.radio.partition import Partition

STARTS = {"a": (1.5, 1.5), "b": (0.5, 1.5), "c": (2.5, 1.5)}
POINTS = {"a": (1.0, 2.0), "b": (1.0, 0.5), "c": (2.2, 2.0)}  # a corner, a border, a border
USES = [("a", "b"), ("b", "a"), ("c", "a"), ("a", "base"), ("a", "b")]


def best(world: World, table: np.ndarray, pair: tuple[str, str]) -> float:
    """Least entry among the touching cells, straight from the definition."""
    cells = [touching(world.partition, POINTS[n]) for n in pair if n in POINTS]
    return float(table[np.ix_(*cells)].min())


def placed(ctx, literals=()) -> dict[int, float]:
    found = {column: 1.0 for column in literals}
    for name, point in POINTS.items():
        found |= dict(zip(ctx.states[name][1].tolist(), point, strict=True))
    return found


@pytest.mark.parametrize("name", list(ENCODINGS))
@pytest.mark.parametrize("seed", range(3))
def test_every_cost_takes_its_own_cheapest_cell(name: str, seed: int) -> None:
    world = World(STARTS, square(3), steps=1)
    ctx, expected = world.context(), 0.0
    for number, pair in enumerate(USES):
        table = world.table(10 * seed + number, 1 if "base" in pair else 2)
        add_link_cost(ctx, world.channel, pair, table, [1], 1.0, name)
        expected += best(world, table, pair)
    assert optimum(ctx.builder.build(), placed(ctx)) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("name", list(ENCODINGS))
def test_every_value_takes_its_own_best_cell(name: str) -> None:
    world = World(STARTS, square(3), steps=1)
    ctx, expected = world.context(), 0.0
    for number, pair in enumerate(USES[:3]):
        table = world.table(number)
        value = link_value(ctx, world.channel, pair, table, 1, name)
        ctx.builder.add_cost(value.cols, -value.values)
        expected += best(world, -table, pair) + value.constant
    assert optimum(ctx.builder.build(), placed(ctx)) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("partition", [square(3), tree()])
@pytest.mark.parametrize("seed", range(6))
def test_every_predicate_takes_its_own_best_cell(partition: Partition, seed: int) -> None:
    world = World(STARTS, partition, steps=1)
    ctx, literals, expected = world.context(), [], []
    add_link_cost(ctx, world.channel, ("a", "b"), world.table(99), [1], 1e-6)
    for number, pair in enumerate(USES):
        table = world.table(10 * seed + number, 1 if "base" in pair else 2)
        level = float(np.quantile(table, 0.3))
        literals.append(link_literal(ctx, world.channel, pair, table <= level, 1))
        expected.append(best(world, table, pair) <= level)
    wanted = [z for z, holds in zip(literals, expected, strict=True) if holds]
    assert optimum(ctx.builder.build(), placed(ctx, wanted)) is not None
    for z, holds in zip(literals, expected, strict=True):
        assert holds or optimum(ctx.builder.build(), placed(ctx, [z])) is None


def test_within_a_cell_there_is_no_choice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(POINTS, "a", (1.1, 1.9))
    monkeypatch.setitem(POINTS, "b", (0.9, 0.5))
    monkeypatch.setitem(POINTS, "c", (2.2, 1.9))
    for name in ENCODINGS:
        test_every_cost_takes_its_own_cheapest_cell(name, 1)
