"""Sizes, reach, sharing, the choice of `auto`, and what is refused."""

from importlib.metadata import EntryPoint

import numpy as np
import pytest
from support.links import World, optimum, square, touching, tree

from stlc.errors import UsageError
from stlc.milp.builder import ModelBuilder
from stlc.milp.tables import (
    ENCODINGS,
    TableError,
    add_link_cost,
    choose,
    link_literal,
    link_value,
    registry,
)
from stlc.milp.tables.boxes import join_boxes
from stlc.milp.tables.cells import Place
from stlc.milp.tables.lifted import lifting
from stlc.milp.tables.link import ends_of
from stlc.milp.tables.simplex import ordered
from stlc.milp.tables.spans import spans_of
from stlc.radio.partition import Partition, grid, uniform_grid

TWO = {"a": (0.5, 0.5), "b": (4.5, 2.0)}
WORLD = World(TWO, uniform_grid((0, 5), (0, 5), 5, 5), steps=3, side=5.0)


@pytest.mark.parametrize("name", list(ENCODINGS))
@pytest.mark.parametrize("step", [1, 3])
@pytest.mark.parametrize("pair", [("a", "b"), ("a", "base"), ("base", "base")])
def test_sizes_are_the_formulas(name: str, step: int, pair: tuple[str, str]) -> None:
    ctx = WORLD.context()
    empty = WORLD.context().builder.build()
    link = ends_of(ctx, WORLD.partition, pair).at(step)
    add_link_cost(ctx, WORLD.channel, pair, WORLD.table(0, len(link.ends)), [step], 1.0, name)
    model = ctx.builder.build()
    literal = name.startswith("literal")
    shapes = [(5, 5) if literal else p.reach(ctx).shape for p in link.places]
    size = ENCODINGS[name].size(shapes)
    assert model.columns - empty.columns == size.columns
    assert model.rows - empty.rows == size.rows
    binaries = [b for b in model.col_blocks[len(empty.col_blocks) :] if b.name[:2] not in _NUMBERS]
    counted = sum(int(model.integrality[b.start : b.start + b.size].sum()) for b in binaries)
    assert counted == size.binaries


_NUMBERS = ("a_", "b_", "r_")  # the literal encoding's general integers


def test_literal_has_the_papers_size() -> None:
    world = World(TWO, uniform_grid((0, 5), (0, 5), 10, 10), steps=8, side=5.0)
    size = ENCODINGS["literal"].size([(10, 10), (10, 10)])
    assert (size.binaries * 8, size.rows * 8) == (80_000, 320_088)
    ctx = world.context()
    before = ctx.builder.rows
    add_link_cost(ctx, world.channel, ("a", "b"), world.table(0), range(1, 9), 1.0, "literal")
    assert ctx.builder.rows - before == 320_088


def test_only_cells_in_reach_enter() -> None:
    ctx = WORLD.context()
    spans = spans_of(WORLD.partition)
    region = Place(spans, "a", 1).reach(ctx)
    assert region.cells.tolist() == [0, 1, 5, 6]  # within 1 m of (0.5, 0.5)
    assert [e.tolist() for e in region.edges] == [[0, 1, 1.5], [0, 1, 1.5]]
    corner = Place(spans, "b", 0).reach(ctx)
    assert corner.cells.tolist() == touching(WORLD.partition, (4.5, 2.0)).tolist() == [21, 22]


def test_borders_belong_to_both_cells() -> None:
    world = World(TWO, WORLD.partition, steps=1, side=5.0, u_max=5.0)
    table = world.table(3)
    for name in ENCODINGS:
        ctx = world.context()
        add_link_cost(ctx, world.channel, ("a", "b"), table, [1], 1.0, name)
        points = (1.0, 2.0), (3.5, 4.0)
        pinned = {}
        for agent, point in zip("ab", points, strict=True):
            pinned |= dict(zip(ctx.states[agent][1].tolist(), point, strict=True))
        cells = [touching(world.partition, p) for p in points]
        assert [len(c) for c in cells] == [4, 2]
        expected = table[np.ix_(*cells)].min()
        found = optimum(ctx.builder.build(), pinned)
        assert found == pytest.approx(expected, abs=1e-6), name


def test_pairs_costs_and_predicates_stand_on_one_set_of_binaries() -> None:
    world = World({**TWO, "c": (2.5, 2.5)}, WORLD.partition, steps=2, side=5.0)
    ctx = world.context()
    for pair in (("a", "b"), ("b", "c"), ("c", "a")):
        add_link_cost(ctx, world.channel, pair, world.table(0), [2], 1.0, "unary")
        link_literal(ctx, world.channel, pair, world.table(1) < 2, 2)
        link_value(ctx, world.channel, pair, world.table(2), 2, "unary")
    names = [b.name for b in ctx.builder.build().col_blocks]
    assert sorted(n for n in names if "beyond" in n) == sorted(
        f"{axis}_beyond_{agent}_2" for agent in "abc" for axis in "xy"
    )
    assert sum(n.startswith("pair_") for n in names) == 6  # of costs and of values
    # Each agent is seen by two costs, two values and two literals: the first needs no choice.
    assert sum(n.startswith("x_beside_a") for n in names) == 5


def test_one_table_an_agent_and_step_needs_no_second_choice() -> None:
    ctx = WORLD.context()
    add_link_cost(ctx, WORLD.channel, ("a", "b"), WORLD.table(0), [1, 2, 3], 1.0)
    link_literal(ctx, WORLD.channel, ("a", "b"), WORLD.table(1) < 9, 2)  # always true
    names = [b.name for b in ctx.builder.build().col_blocks]
    assert not [n for n in names if "border" in n or "beside" in n]


def test_quadtree_cells_become_index_boxes() -> None:
    spans = spans_of(tree())
    assert [len(e) for e in spans.edges] == [4, 4]
    area = (spans.spans[:, 1] - spans.spans[:, 0] + 1) * (spans.spans[:, 3] - spans.spans[:, 2] + 1)
    assert sorted(area.tolist()) == [1, 1, 1, 1, 1, 2, 2] or area.sum() == 9


def test_lifting_coefficients_are_the_minima() -> None:
    costs = np.random.default_rng(0).random((4, 6))
    alpha = lifting(costs)
    for i in range(4):
        for k in range(4):
            assert alpha[i, k] == min(costs[k] - costs[i])


@pytest.mark.parametrize("count", [3, 60])
def test_boxes_keep_weight_only_around_the_point(count: int) -> None:
    """Few boxes are written out row by row, many by differences with slacks."""
    rng = np.random.default_rng(count)
    low = rng.integers(0, 9, (count, 2))
    boxes = np.stack([low, np.minimum(low + (count == 3) * 5, 8)], axis=2)
    builder = ModelBuilder()
    axes = [ordered(builder, name, 9) for name in "xy"]
    cols = builder.add_columns("y", (count,), 0.0, 1.0, cost=-1.0)
    builder.add_dense_rows("one", cols, 1.0, 0.0, 1.0)
    join_boxes(builder, "box", cols, boxes.reshape(count, 4), axes)
    model = builder.build()
    assert any("slack" in b.name for b in model.col_blocks) == (count == 60)
    assert model.rows <= 2 * 7 + 1 + 2 * 16
    inside = 0
    for point in rng.integers(0, 9, (20, 2)):
        pinned = {
            int(col): float(k < point[axis])
            for axis, binaries in enumerate(axes)
            for k, col in enumerate(binaries)
        }
        held = ((boxes[:, :, 0] <= point) & (point <= boxes[:, :, 1])).all(axis=1).any()
        inside += held
        assert optimum(model, pinned) == pytest.approx(-float(held), abs=1e-6)
    assert 0 < inside < 20


def test_auto_explains_its_choice(monkeypatch: pytest.MonkeyPatch) -> None:
    ctx = WORLD.context()
    links = [ends_of(ctx, WORLD.partition, ("a", "b")).at(t) for t in (1, 2)]
    choice = choose(ctx, links)
    assert (choice.encoding.name, choice.reason) == ("unary", "167 cell pairs in reach")
    # (2 x 2) (2 x 4) at step 1, (3 x 3) (3 x 5) at step 2: borders count in both cells
    monkeypatch.setattr(registry, "MOST_PAIRS", 10)
    assert choose(ctx, links).encoding.name == "lifted"
    station = [ends_of(ctx, WORLD.partition, ("a", "base")).at(1)]
    assert "one end moves" in choose(ctx, station).reason


def test_other_packages_offer_encodings(monkeypatch: pytest.MonkeyPatch) -> None:
    entry = EntryPoint("mine", "stlc.milp.tables.hull:Hull", registry.ENTRY_POINTS)
    monkeypatch.setattr(registry, "entry_points", lambda group: [entry])
    assert registry.encoding_named("mine") is entry.load()
    with pytest.raises(UsageError, match=r"'nonesuch'; known: auto, unary, .*, mine"):
        registry.encoding_named("nonesuch")


@pytest.mark.parametrize(
    ("pair", "table", "message"),
    [
        (("a", "b"), np.zeros((25, 24)), "has shape"),
        (("a", "base"), np.zeros((25, 25)), "has shape"),
        (("a", "b"), np.full((25, 25), np.inf), "finite"),
        (("a", "a"), np.zeros((25, 25)), "two different radios"),
    ],
)
def test_tables_that_do_not_fit(pair: tuple[str, str], table: np.ndarray, message: str) -> None:
    with pytest.raises(TableError, match=message):
        add_link_cost(WORLD.context(), WORLD.channel, pair, table, [1], 1.0)


def test_an_agent_outside_the_partition() -> None:
    far = World(TWO, grid([3.5, 4, 5], [0, 5]), steps=1, side=5.0)
    with pytest.raises(TableError, match="a cannot be inside the channel's partition at step 1"):
        add_link_cost(far.context(), far.channel, ("a", "b"), np.zeros((2, 2)), [1], 1.0)


@pytest.mark.parametrize("partition", [grid([0, 1, 5], [0, 5]), Partition(square(2).boxes[:3])])
def test_literal_needs_a_uniform_grid(partition: Partition) -> None:
    world = World(TWO, partition, steps=1, side=5.0)
    table = np.zeros((len(partition),) * 2)
    with pytest.raises(TableError, match="needs a uniform grid"):
        add_link_cost(world.context(), world.channel, ("a", "b"), table, [1], 1.0, "literal")
