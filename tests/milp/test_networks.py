"""Rows of counts and networks, against search in the graph for every set of edges."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
import pytest

from stlc.analysis.networks import value
from stlc.arrays import Floats
from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import Const, Link, Quantity, Relation
from stlc.milp.builder import ModelBuilder
from stlc.milp.context import Affine
from stlc.milp.formulas.choice import RowBlock
from stlc.milp.formulas.networks import NetworkRows

ENDS = tuple(combinations(range(4), 2))


def _feasible(node: Count | Network, present: tuple[int, ...], z: int | None) -> bool:
    """Whether the rows have a point with these edges and this parent literal."""
    builder, rows = ModelBuilder(), RowBlock()
    w = [int(builder.add_columns("w", (1,), v, v, integer=True)[0]) for v in present]
    parent = None if z is None else int(builder.add_columns("z", (1,), z, z, integer=True)[0])
    writer = NetworkRows(builder, rows)
    if isinstance(node, Count):
        writer.count(node, w, parent)
    else:
        writer.network(node, w, parent)
    return _solvable(builder, rows)


def _solvable(builder: ModelBuilder, rows: RowBlock) -> bool:
    rows.flush(builder, "rows")
    status = get("highs").solve(builder.build(), SolveOptions(time_limit=20.0)).status
    assert status in (Status.OPTIMAL, Status.INFEASIBLE)
    return status is Status.OPTIMAL


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("hops", [None, 1, 2, 3])
def test_rows_hold_for_exactly_the_edges_that_do(hops: int | None, cut: bool) -> None:
    node = Network((Const(True),) * 6, ENDS, tuple("abcd"), hops, cut)
    for present in product((0, 1), repeat=6):
        holds = value(node, [2.0 * v - 1.0 for v in present]) > 0
        assert _feasible(node, present, None) is holds
        assert _feasible(node, present, 1) is holds
        assert _feasible(node, present, 0)


def test_counts_hold_for_enough_literals() -> None:
    node = Count((Const(True),) * 4, 3)
    for present in product((0, 1), repeat=4):
        assert _feasible(node, present, 1) is (sum(present) >= 3)
        assert _feasible(node, present, 0)


def test_counts_hold_for_literals_that_weigh_enough() -> None:
    node = Count((Const(True),) * 3, 4, (1, 3, 2))
    for present in product((0, 1), repeat=3):
        weighed = sum(w for w, there in zip(node.weights, present, strict=True) if there)
        assert _feasible(node, present, 1) is (weighed >= 4)
        assert _feasible(node, present, 0)


def _constant(weight: float) -> Affine:
    return Affine(np.empty(0, np.int64), np.empty(0), weight)


@pytest.mark.parametrize("cut", [False, True])
@pytest.mark.parametrize("hops", [2, 3])
def test_weights_along_a_path_add_up(hops: int, cut: bool) -> None:
    relation = Relation.AT_LEAST if cut else Relation.AT_MOST
    links = tuple(
        Link("radio", Quantity.COST, "abcd"[a], "abcd"[b], relation, 1.0, tight=True)
        for a, b in ENDS
    )
    node = Network(links, ENDS, tuple("abcd"), hops, cut, composed=True)
    rng = np.random.default_rng(hops)
    verdicts = set()
    for _ in range(40):
        weights: Floats = np.minimum(rng.uniform(0.2, 1.6, 6), 2.0)
        found = value(node, (1.0 if cut else -1.0) * (weights - 1.0))
        verdicts.add(found >= 0)
        for z in (None, 1, 0):
            builder, rows = ModelBuilder(), RowBlock()
            parent = None if z is None else int(builder.add_columns("z", (1,), z, z)[0])
            writer = NetworkRows(builder, rows)
            write = writer.unrelayed if cut else writer.relayed
            write(node, [_constant(float(v)) for v in weights], 1.0, 2.0, parent)
            assert _solvable(builder, rows) is (found >= 0 or z == 0)
    assert verdicts == {True, False}
