"""Counts and networks against their definitions: all spanning trees, all paths."""

from __future__ import annotations

from itertools import combinations, pairwise, permutations
from math import prod

import numpy as np
import pytest

from stlc.analysis.networks import value
from stlc.ir.networks import Count, Network, counted
from stlc.ir.nodes import Const, Link, Node, Quantity, Relation
from stlc.passes.nnf import _normalise
from stlc.verify import networks

VERTICES = ("a", "b", "c", "d", "e")


def _edges(count: int) -> tuple[tuple[int, int], ...]:
    return tuple(combinations(range(count), 2))


def _joins(count: int, edges: tuple[tuple[int, int], ...]) -> bool:
    group = list(range(count))
    for a, b in edges:
        group = [group[a] if g == group[b] else g for g in group]
    return len(set(group)) == 1


def _spanning(count: int, width: dict[tuple[int, int], float]) -> float:
    trees = (t for t in combinations(width, count - 1) if _joins(count, t))
    return max(min(width[e] for e in tree) for tree in trees)


def _paths(count: int, hops: int) -> list[tuple[tuple[int, int], ...]]:
    found = []
    for length in range(hops):
        for middle in permutations(range(2, count), length):
            stops = (0, *middle, 1)
            found.append(tuple((min(p), max(p)) for p in pairwise(stops)))
    return found


@pytest.mark.parametrize("count", [2, 3, 4, 5])
def test_what_joins_all_is_a_best_spanning_tree(count: int) -> None:
    rng = np.random.default_rng(count)
    ends = _edges(count)
    widths = rng.normal(size=(len(ends), 20))
    node = Network((Const(True),) * len(ends), ends, VERTICES[:count])
    found = networks.network(node, list(widths))
    for k in range(20):
        expected = _spanning(count, dict(zip(ends, widths[:, k], strict=True)))
        assert found[k] == expected
        assert value(node, widths[:, k]) == expected


@pytest.mark.parametrize("hops", [1, 2, 3, 4])
def test_a_route_is_a_best_path_within_its_hops(hops: int) -> None:
    rng = np.random.default_rng(hops)
    ends = _edges(5)
    widths = rng.normal(size=(len(ends), 20))
    node = Network((Const(True),) * len(ends), ends, VERTICES, hops)
    found = networks.network(node, list(widths))
    for k in range(20):
        width = dict(zip(ends, widths[:, k], strict=True))
        expected = max(min(width[e] for e in path) for path in _paths(5, hops))
        assert found[k] == expected
        assert value(node, widths[:, k]) == expected


def _links(
    quantity: Quantity, relation: Relation, threshold: float, count: int
) -> tuple[Link, ...]:
    return tuple(
        Link("radio", quantity, VERTICES[a], VERTICES[b], relation, threshold, tight=True)
        for a, b in _edges(count)
    )


@pytest.mark.parametrize("hops", [1, 2, 3])
@pytest.mark.parametrize(
    ("quantity", "relation", "threshold"),
    [
        (Quantity.PRR, Relation.AT_LEAST, 0.8),
        (Quantity.BER, Relation.AT_MOST, 0.1),
        (Quantity.COST, Relation.AT_MOST, 1.5),
    ],
)
def test_end_to_end_quality_is_that_of_the_best_path(
    hops: int, quantity: Quantity, relation: Relation, threshold: float
) -> None:
    rng = np.random.default_rng(7)
    ends = _edges(4)
    quality = rng.uniform(0.3, 1.0, size=(len(ends), 20))
    node = Network(
        _links(quantity, relation, threshold, 4), ends, VERTICES[:4], hops, composed=True
    )
    sign = 1.0 if relation is Relation.AT_LEAST else -1.0
    found = networks.network(node, list(sign * (quality - threshold)))
    for k in range(20):
        of = dict(zip(ends, quality[:, k], strict=True))
        ways = [[of[e] for e in path] for path in _paths(4, hops)]
        match quantity:
            case Quantity.PRR:
                expected = max(map(prod, ways)) - threshold
            case Quantity.BER:
                expected = threshold - min(1.0 - prod(1.0 - b for b in way) for way in ways)
            case _:
                expected = threshold - min(map(sum, ways))
        assert found[k] == pytest.approx(expected)
        assert value(node, sign * (quality[:, k] - threshold)) == pytest.approx(expected)


def test_a_count_is_the_kth_largest() -> None:
    values = np.random.default_rng(1).normal(size=(6, 20))
    for least in range(1, 7):
        node = Count((Const(True),) * 6, least)
        expected = np.sort(values, axis=0)[::-1][least - 1]
        assert np.array_equal(networks.counted(node, list(values)), expected)
        assert [value(node, v) for v in values.T] == list(expected)


def test_weights_count_arguments_several_times() -> None:
    values = np.random.default_rng(2).normal(size=(4, 20))
    weights = (2, 1, 3, 1)
    for least in range(1, 8):
        node = Count((Const(True),) * 4, least, weights)
        copies = np.repeat(values, weights, axis=0)
        expected = np.sort(copies, axis=0)[::-1][least - 1]
        assert np.array_equal(networks.counted(node, list(values)), expected)
        assert [value(node, v) for v in values.T] == list(expected)
        dual = _under_not(node)
        assert isinstance(dual, Count)
        assert np.array_equal(networks.counted(dual, list(-values)), -expected)


def test_known_arguments_of_a_weighted_count_count() -> None:
    open_ = _links(Quantity.PRR, Relation.AT_LEAST, 0.7, 3)[:2]
    node = Count((Const(True), open_[0], Const(False), open_[1]), 5, (3, 2, 4, 1))
    assert counted(node) == Count(open_, 2, (2, 1))
    assert counted(Count((Const(True), open_[0]), 3, (3, 1))) == Const(True)
    assert counted(Count((Const(False), open_[0]), 3, (3, 1))) == Const(False)


def _under_not(node: Node) -> Node:
    from stlc.ir.nodes import Not

    return _normalise(Not(node), {})


@pytest.mark.parametrize("hops", [None, 1, 2, 3])
@pytest.mark.parametrize("composed", [False, True])
def test_negation_moved_inward_negates_the_robustness(hops: int | None, composed: bool) -> None:
    if composed and hops is None:
        return
    rng = np.random.default_rng(3)
    ends = _edges(4)
    links = _links(Quantity.PRR, Relation.AT_LEAST, 0.7, 4)
    node = Network(links, ends, VERTICES[:4], hops, composed=composed)
    dual = _under_not(node)
    assert isinstance(dual, Network)
    assert dual.cut
    assert _under_not(dual) == node
    values = rng.uniform(-0.4, 0.3, size=(len(ends), 20))
    there, back = networks.network(node, list(values)), networks.network(dual, list(-values))
    assert back == pytest.approx(-there)
    assert [value(dual, -v) for v in values.T] == pytest.approx(list(-there))
    count = Count(links, 2)
    negated = _under_not(count)
    assert isinstance(negated, Count)
    assert np.array_equal(
        networks.counted(negated, list(-values)), -networks.counted(count, list(values))
    )
