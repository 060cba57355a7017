"""Counts and networks on sampled runs, by search in the graph, step by step.

What joins all vertices is found by growing a tree from vertex 0 over the best edge at hand (Prim),
what leads from vertex 0 to vertex 1 by relaxing all edges once a hop (Bellman and Ford).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from stlc.ir.networks import Count, Ends, Network
from stlc.ir.nodes import Quantity, Relation
from stlc.verify.trace import Array


def counted(node: Count, args: Sequence[Array]) -> Array:
    """The `least`-th largest of the arguments at each step, each counted as often as it weighs."""
    parts = np.stack(np.broadcast_arrays(*args))
    order = np.argsort(-parts, axis=0, kind="stable")
    weighed = np.asarray(node.shares)[order].cumsum(axis=0)
    enough = (weighed >= node.least).argmax(axis=0)
    found = np.take_along_axis(np.take_along_axis(parts, order, axis=0), enough[None], axis=0)
    return np.asarray(found[0])


def network(node: Network, args: Sequence[Array]) -> Array:
    """Robustness of a network from that of its arguments."""
    parts = np.stack(np.broadcast_arrays(*args))
    if node.composed:
        return _end_to_end(node, parts)
    edges = -parts if node.cut else parts
    if node.hops is None:
        width = _tree(len(node.vertices), node.ends, edges)
    else:
        width = _path(len(node.vertices), node.ends, edges, node.hops)
    return -width if node.cut else width


def _tree(count: int, ends: Sequence[Ends], edges: Array) -> Array:
    """The worst edge of a best spanning tree, at each step."""
    shape = edges.shape[1:]
    inside = np.zeros((count, *shape), bool)
    inside[0] = True
    worst = np.full(shape, np.inf)
    for _ in range(count - 1):
        leaving = np.stack([inside[a] != inside[b] for a, b in ends])
        widths = np.where(leaving, edges, -np.inf)
        best = widths.argmax(axis=0)
        worst = np.minimum(worst, np.take_along_axis(widths, best[None], axis=0)[0])
        for k, (a, b) in enumerate(ends):
            taken = (best == k) & leaving[k]
            inside[a] |= taken
            inside[b] |= taken
    return worst


def _path(count: int, ends: Sequence[Ends], edges: Array, hops: int) -> Array:
    """The worst edge of a best path from vertex 0 to vertex 1, at each step."""
    width = np.full((count, *edges.shape[1:]), -np.inf)
    width[0] = np.inf
    for _ in range(min(hops, count - 1)):
        reached = width.copy()
        for (a, b), edge in zip(ends, edges, strict=True):
            reached[b] = np.maximum(reached[b], np.minimum(width[a], edge))
            reached[a] = np.maximum(reached[a], np.minimum(width[b], edge))
        width = reached
    return np.asarray(width[1])


def _end_to_end(node: Network, parts: Array) -> Array:
    """Excess over the threshold of the best path's quality (negated for a cut), at each step."""
    link = node.links[0]
    at_least = link.relation is Relation.AT_LEAST
    qualities = link.threshold + parts if at_least else link.threshold - parts
    costs = link.quantity is Quantity.COST
    lost = costs or link.quantity is not Quantity.PRR
    delivered = qualities if costs or not lost else 1.0 - qualities
    best = _relayed(node, delivered, costs=costs)
    quality = best if costs or not lost else 1.0 - best
    return np.asarray(quality - link.threshold if at_least else link.threshold - quality)


def _relayed(node: Network, edges: Array, *, costs: bool) -> Array:
    """The least sum of costs, or the largest product of shares delivered, along a path."""
    start, nothing = (0.0, np.inf) if costs else (1.0, 0.0)
    join, better = (np.add, np.minimum) if costs else (np.multiply, np.maximum)
    best = np.full((len(node.vertices), *edges.shape[1:]), nothing)
    best[0] = start
    hops = len(node.vertices) - 1
    for _ in range(hops if node.hops is None else min(node.hops, hops)):
        reached = best.copy()
        for (a, b), edge in zip(node.ends, edges, strict=True):
            reached[b] = better(reached[b], join(best[a], edge))
            reached[a] = better(reached[a], join(best[b], edge))
        best = reached
    return np.asarray(best[1])
