"""Formulas over a whole network: how many hold, which links join the radios.

* `Count(args, k)`: at least k of the arguments; rho is their k-th largest. With `weights`,
  arguments that weigh at least k together; rho is the largest that so many reach.
* `Network(args, ends, vertices, hops)`: a graph without directions whose edge e, between the
  vertices `ends[e]`, is there where `args[e]` holds. Without `hops` it joins all vertices: rho is
  the bottleneck of a maximum spanning tree. With `hops` it leads from vertex 0 to vertex 1 over at
  most so many edges: rho is the best such path's worst edge.
* the same, `composed`: the arguments are links with one quality and threshold, and what is
  compared with the threshold is the best path's end-to-end quality: packet reception ratios
  multiply, the chances of no bit error too, costs add up.
* `cut`: the dual, where `args[e]` says that edge e is *not* there: rho(cut of f) = -rho(network of
  not f), so that negation moves to the arguments as it does through `and`.

All but `composed` are made of min and max alone, hence hold at a level exactly where they do with
the arguments that hold at that level.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from stlc.ir.nodes import Const, Link, Node, Quantity

Ends = tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False)
class Count(Node):
    """At least `least` of the arguments, 1 <= least <= len(args); or arguments whose `weights`, of
    at least 1 each, add up to `least`."""

    args: tuple[Node, ...]
    least: int
    weights: tuple[int, ...] = ()

    @property
    def key(self) -> tuple[object, ...]:
        """The arguments, how many of them, and what they weigh."""
        return (*self.args, self.least, self.weights)

    @property
    def shares(self) -> tuple[int, ...]:
        """What each argument counts."""
        return self.weights or (1,) * len(self.args)

    @property
    def children(self) -> tuple[Node, ...]:
        """The arguments."""
        return self.args


@dataclass(frozen=True, slots=True, eq=False)
class Network(Node):
    """A graph that joins its vertices, or vertex 0 with vertex 1; see the module."""

    args: tuple[Node, ...]
    ends: tuple[Ends, ...]
    vertices: tuple[str, ...]
    hops: int | None = None
    cut: bool = False
    composed: bool = False

    @property
    def key(self) -> tuple[object, ...]:
        """The edges, and all that says what is asked of them."""
        return (*self.args, self.ends, self.vertices, self.hops, self.cut, self.composed)

    @property
    def children(self) -> tuple[Node, ...]:
        """What each edge depends on."""
        return self.args

    @property
    def links(self) -> tuple[Link, ...]:
        """The arguments of a composed network, which are links."""
        assert all(isinstance(arg, Link) for arg in self.args)
        return tuple(arg for arg in self.args if isinstance(arg, Link))


COMPOSABLE = frozenset({Quantity.PRR, Quantity.BER, Quantity.BER_AT_MEAN, Quantity.COST})
"""Qualities that have an end-to-end value over several hops."""


def negated_count(node: Count, negated: Sequence[Node]) -> Count:
    """Of n arguments fewer than k hold where n - k + 1 of their negations do."""
    return replace(node, args=tuple(negated), least=sum(node.shares) - node.least + 1)


def negated_network(node: Network, negated: Sequence[Node]) -> Network:
    """The dual over the negated arguments."""
    return replace(node, args=tuple(negated), cut=not node.cut)


def uncomposed(node: Network) -> Node:
    """What a composed network asks of its links at least, each by itself.

    Every link of a path that is good enough is, so that what stands in the links' place may be
    anything they imply. That no path is good enough says nothing of single links.
    """
    return Const(True, span=node.span) if node.cut else replace(node, composed=False)


def counted(node: Count) -> Node:
    """A count without arguments that are known; a constant where that decides it."""
    known = dict(zip(range(len(node.args)), node.args, strict=True))
    open_ = [k for k, a in known.items() if not isinstance(a, Const)]
    shares = node.shares
    least = node.least - sum(shares[k] for k, a in known.items() if a == Const(True))
    if least <= 0:
        return Const(True, span=node.span)
    if least > sum(shares[k] for k in open_):
        return Const(False, span=node.span)
    if len(open_) == len(node.args):
        return node
    weights = tuple(shares[k] for k in open_) if node.weights else ()
    return replace(node, args=tuple(known[k] for k in open_), least=least, weights=weights)
