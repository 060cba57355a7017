"""The robustness of counts and networks from that of their arguments, and weights of links.

Both are monotone in every argument, so that they carry ends of intervals to ends of intervals.
Composed networks go by weights that add up along a path: -log of a packet reception ratio, -log of
1 less an error rate, a cost as it is. A path meets the threshold where its weight is at most that
of the threshold.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from stlc.arrays import Floats
from stlc.ir.networks import Count, Ends, Network
from stlc.ir.nodes import Link, Quantity, Relation

_FAINT, _HEAVIEST = 1e-300, 1e9  # least quality, most cost: what never delivers, in finite numbers


def value(node: Count | Network, args: Sequence[float]) -> float:
    """Robustness of the node where its arguments have these."""
    if isinstance(node, Count):
        return _counted(node, args)
    if node.composed:
        return _composed(node, args)
    if node.cut:  # the dual, of negated arguments
        return -_widest(node, [-a for a in args])
    return _widest(node, args)


def _counted(node: Count, args: Sequence[float]) -> float:
    """The largest level that arguments of enough weight reach."""
    missing = node.least
    for value_, share in sorted(zip(args, node.shares, strict=True), reverse=True):
        missing -= share
        if missing <= 0:
            return value_
    raise AssertionError("a count asks for no more than there is")


def weights(link: Link, robustness: ArrayLike) -> Floats:
    """What a link whose predicate has this robustness adds to a path's weight."""
    return _weight(link.quantity, link.threshold + _side(link) * np.asarray(robustness))


def budget(link: Link, level: float) -> float:
    """The weight of a path whose end-to-end quality is off the threshold by just `level`."""
    return float(_weight(link.quantity, np.asarray(link.threshold + _side(link) * level)))


def attainable(link: Link, level: float) -> bool:
    """Whether a quality off the threshold by `level` is one that a path can have at all."""
    quality = link.threshold + _side(link) * level
    if link.quantity is Quantity.COST:
        return quality >= 0.0 or link.relation is Relation.AT_LEAST
    return quality <= 1.0 if link.relation is Relation.AT_LEAST else quality >= 0.0


def _side(link: Link) -> float:
    return 1.0 if link.relation is Relation.AT_LEAST else -1.0


def _weight(quantity: Quantity, quality: Floats) -> Floats:
    if quantity is Quantity.COST:
        return np.clip(quality, 0.0, _HEAVIEST)
    kept = quality if quantity is Quantity.PRR else 1.0 - quality
    return np.asarray(-np.log(np.clip(kept, _FAINT, 1.0)))


def _quality(quantity: Quantity, weight: float) -> float:
    if quantity is Quantity.COST:
        return weight
    kept = math.exp(-weight)
    return kept if quantity is Quantity.PRR else 1.0 - kept


def _composed(node: Network, args: Sequence[float]) -> float:
    """Excess of the best path's end-to-end quality over the threshold, negated for a cut."""
    links = node.links
    if not links:
        return math.inf if node.cut else -math.inf
    lightest = np.full(len(node.vertices), math.inf)
    lightest[0] = 0.0
    own = [float(weights(link, a)) for link, a in zip(links, args, strict=True)]
    for _ in range(_hops(node)):
        before = lightest.copy()
        for (a, b), weight in zip(node.ends, own, strict=True):
            lightest[b] = min(lightest[b], before[a] + weight)
            lightest[a] = min(lightest[a], before[b] + weight)
    link = links[0]
    return _side(link) * (_quality(link.quantity, float(lightest[1])) - link.threshold)


def _hops(node: Network) -> int:
    return len(node.vertices) - 1 if node.hops is None else node.hops


def _widest(node: Network, args: Sequence[float]) -> float:
    """The best worst edge of a spanning tree, or of a path within its hops."""
    if node.hops is None:
        return _spanning(len(node.vertices), node.ends, args)
    widest = [math.inf, *[-math.inf] * (len(node.vertices) - 1)]
    for _ in range(node.hops):
        before = list(widest)
        for (a, b), width in zip(node.ends, args, strict=True):
            widest[b] = max(widest[b], min(before[a], width))
            widest[a] = max(widest[a], min(before[b], width))
    return widest[1]


def _spanning(count: int, ends: Sequence[Ends], args: Sequence[float]) -> float:
    """Edges from the best on until all vertices hang together (Kruskal)."""
    group = list(range(count))
    left, worst = count - 1, math.inf
    for k in sorted(range(len(ends)), key=lambda k: -args[k]):
        a, b = (group[v] for v in ends[k])
        if left == 0:
            break
        if a != b:
            group = [a if g == b else g for g in group]
            left, worst = left - 1, args[k]
    return worst if left == 0 else -math.inf
