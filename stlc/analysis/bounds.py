"""Static bounds on the robustness of every sub-formula, from interval ranges.

    predicate   interval of its value over the ranges, divided by the scale of its unit
    and         [min of the lower ends, min of the upper ends]
    count, network    by their value where each argument has its lower, or its upper end
    or          [max of the lower ends, max of the upper ends]

and one sharper upper end: predicates mu and nu of one conjunction with opposite normals,
mu + nu = k for all x, have min(mu, nu) <= k / 2 (a region of width w is never satisfied by more
than w / 2, however far it is). Sound for every run within the ranges.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from stlc.analysis import networks
from stlc.analysis.ranges import Ranges
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import And, Const, Linear, Link, Node, Not, Or, Quantity, Role
from stlc.ir.rewrite import postorder

Interval = tuple[float, float]
LinkBounds = Callable[[Link | Not], Interval]
"""Interval of a link predicate's robustness."""


def unknown(node: Link | Not) -> Interval:
    """Link bounds of a mission whose tables are not at hand."""
    return -math.inf, math.inf


def value_range(predicate: Linear, ranges: Mapping[str, Ranges]) -> Interval:
    """Interval of constant + sum coefficient * signal over the ranges."""
    low = high = predicate.constant
    for signal, value in predicate.terms:
        r = ranges[signal.owner]
        at = (signal.shift, signal.index)
        if signal.role is Role.STATE:
            a, b = r.state_lower[at], r.state_upper[at]
        else:
            a, b = r.input_lower[at], r.input_upper[at]
        low += value * (a if value > 0 else b)
        high += value * (b if value > 0 else a)
    return float(low), float(high)


def static_bounds(
    roots: Sequence[Node],
    ranges: Mapping[str, Ranges],
    scales: Mapping[str, float] | None = None,
    links: LinkBounds = unknown,
    found: dict[Node, Interval] | None = None,
) -> dict[Node, Interval]:
    """Bounds of every node of unrolled formulas; robustness in units of `scales[unit]`.

    `found` are bounds over the same ranges, which those of the other nodes are added to."""
    found = {} if found is None else found
    for node in postorder(roots, found):
        found[node] = _bounds(node, found, ranges, scales or {}, links)
    return found


def _bounds(
    node: Node,
    found: Mapping[Node, Interval],
    ranges: Mapping[str, Ranges],
    scales: Mapping[str, float],
    links: LinkBounds,
) -> Interval:
    """Interval of a node's robustness from those of its children in `found`."""
    match node:
        case Const(value=value):
            return (math.inf, math.inf) if value else (-math.inf, -math.inf)
        case Linear():
            low, high = value_range(node, ranges)
            scale = scales.get(node.unit, 1.0)
            return low / scale, high / scale
        case And(args=args):
            highs = [found[a][1] for a in args]
            tops = [min(highs, default=math.inf), opposite_cap(args, scales)]
            return min((found[a][0] for a in args), default=math.inf), min(tops)
        case Or(args=args):
            ends = [found[a] for a in args]
            return (
                max((e[0] for e in ends), default=-math.inf),
                max((e[1] for e in ends), default=-math.inf),
            )
        case Count(args=args) | Network(args=args):
            low, high = (networks.value(node, [found[a][k] for a in args]) for k in (0, 1))
            return low, high
        case Link() | Not():
            low, high = links(node)
            scale = scales.get(unit_of(node), 1.0)
            return low / scale, high / scale
    raise TypeError(f"{type(node).__name__} after unrolling")


def opposite_cap(args: Sequence[Node], scales: Mapping[str, float]) -> float:
    """Least k / 2 over pairs of predicates mu, nu with mu + nu = k for all x."""
    predicates = [node for node in args if isinstance(node, Linear) and node.terms]
    heads = {node.terms[0] for node in predicates}
    if not any((signal, -value) in heads for signal, value in heads):
        return math.inf  # nearly all conjunctions: no two normals are opposite
    least: dict[tuple[object, ...], float] = {}
    for node in predicates:
        key = (node.terms, node.unit)
        least[key] = min(least.get(key, math.inf), node.constant)
    cap = math.inf
    for (terms, unit), constant in least.items():
        assert isinstance(terms, tuple)
        assert isinstance(unit, str)
        mirror = (tuple((signal, -value) for signal, value in terms), unit)
        if mirror in least:
            cap = min(cap, (constant + least[mirror]) / 2 / scales.get(unit, 1.0))
    return cap


def unit_of(node: Linear | Link | Not) -> str:
    """Unit of a predicate's robustness."""
    if isinstance(node, Linear):
        return node.unit
    link = node.arg if isinstance(node, Not) else node
    assert isinstance(link, Link)
    decibels = link.quantity in (Quantity.RSSI, Quantity.SNR)
    return "dB" if decibels or link.probability is not None else ""
