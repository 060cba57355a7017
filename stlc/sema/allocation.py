"""`P(always[2, 6] rssi(a, b) >= -70 dBm) >= 0.9`: one probability of several packets together.

Boole's inequality: the chance that any of n events fails is at most the sum of their chances, so
that it is enough to give each packet a share of the risk R = 1 - p (risk allocation; Blackmore and
Ono, Convex chance constrained predictive control without sampling, 2009). Which share, the plan
chooses: in units of R / 4n a packet may take m_1 = 1, m_2 = 4 (an equal share), m_3 (two packets
take much, the others little) or m_4 (one does),

    every packet               P(link) >= 1 - m_4 R / 4n
    weighted count             sum over packets and k < 4 of
                               (m_{k+1} - m_k) [P(link) >= 1 - m_k R / 4n]  >=  n m_4 - 4n

since sum m <= 4n. Of `or` and `eventually` one alternative has to hold with all of the risk. Where
alternatives stand within a conjunction, and where there are very many packets, shares are equal.
All this is sufficient whatever the packets have to do with each other, and never necessary: it
stays a bound from one side.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

from stlc.ir.networks import Count
from stlc.ir.nodes import (
    Always,
    And,
    Const,
    Eventually,
    Linear,
    Link,
    Node,
    Not,
    Or,
    Quantity,
    Relation,
)
from stlc.sema.channel_errors import BadLink
from stlc.sema.report import Mistake

MOST = 60
"""Packets that are given shares one by one: each takes up to four link tables."""

_APART = 1.5  # shares that differ by less tell little apart

_FLIPPED = {Relation.AT_LEAST: Relation.AT_MOST, Relation.AT_MOST: Relation.AT_LEAST}


def packets(node: Node) -> int:
    """How many packets have to get through at once, at most. Mistake for what has no such number:
    open windows, until, implications, chances within chances, conditions between the steps."""
    if node.swept is not None:
        raise _unfit(node, "what is `swept`")
    match node:
        case Link(probability=None, quantity=quantity) if quantity is not Quantity.COST:
            return 1
        case Not(arg=Link(probability=None, quantity=quantity)) if quantity is not Quantity.COST:
            return 1
        case Linear() | Const():
            return 0
        case And(args=args):
            return sum(packets(arg) for arg in args)
        case Or(args=args):
            return max((packets(arg) for arg in args), default=0)
        case Always(arg=arg, start=start, end=int(end)):
            return (end - start + 1) * packets(arg)
        case Eventually(arg=arg, end=int()):
            return packets(arg)
        case Always() | Eventually():
            raise _unfit(node, "a window without end")
    raise _unfit(node, "this")


def _unfit(node: Node, what: str) -> Mistake:
    return Mistake(
        BadLink(
            span=node.span,
            problem=f"{what} has no place within `P(..)`",
            hint="link comparisons joined by `and`, `or`, `always[a, b]`, `eventually[a, b]` have",
        )
    )


def allocated(node: Node, probability: float) -> Node:
    """A formula that is sufficient for P(node) >= probability. Mistake as `packets`, or for a
    formula without links."""
    if packets(node) == 0:
        raise _unfit(node, "a formula without links")
    return _within(node, 1.0 - probability)


def _within(node: Node, risk: float) -> Node:
    """A formula that is sufficient for the node to fail with that risk at most."""
    count = packets(node)
    if count == 0:
        return node
    match node:
        case Or(args=args):
            return replace(node, args=tuple(_within(arg, risk) for arg in args))
        case Eventually(arg=arg):
            return replace(node, arg=_within(arg, risk))
    if count == 1 or count > MOST or not _is_plain(node):
        return _shared(node, 1.0 - risk / count)
    return _chosen(node, count, risk)


def _is_plain(node: Node) -> bool:
    """Whether all parts have to hold together, none of them in place of another."""
    match node:
        case And(args=args):
            return all(_is_plain(arg) for arg in args)
        case Always(arg=arg):
            return _is_plain(arg)
        case _:
            return not isinstance(node, Or | Eventually)


def _chosen(node: Node, count: int, risk: float) -> Node:
    """Every packet with a share of the risk that the plan chooses."""
    unit, levels = risk / (4 * count), _levels(count)
    most = levels[-1]
    steps = [(high - low, low) for low, high in pairwise(levels)]
    found = [
        (part, weight)
        for weight, low in steps
        for part in _apart(_shared(node, 1.0 - low * unit), 0)
    ]
    parts, weights = zip(*found, strict=True)
    shares = Count(parts, count * most - 4 * count, weights, span=node.span)
    return And((_shared(node, 1.0 - most * unit), shares), span=node.span)


def _levels(count: int) -> tuple[int, ...]:
    """The shares that a packet may take, in fourths of an equal one; those that are nearly alike
    once."""
    found = [1, 4]
    for much in ((3 * count + 2) // 2, 3 * count + 1):
        if much >= _APART * found[-1]:
            found.append(much)
    return tuple(found)


def _apart(node: Node, step: int) -> Iterator[Node]:
    """The links of a plain formula, each at its own step from now."""
    match node:
        case Link():
            yield Always(node, step, step, span=node.span) if step else node
        case And(args=args):
            for arg in args:
                yield from _apart(arg, step)
        case Always(arg=arg, start=start, end=int(end)):
            for later in range(start, end + 1):
                yield from _apart(arg, step + later)


def _shared(node: Node, each: float) -> Node:
    """Every link predicate as a chance of its own."""
    match node:
        case Link():
            return replace(node, probability=each, factor=1.0)
        case Not(arg=Link() as link):
            turned = _FLIPPED[link.relation]
            return replace(link, relation=turned, probability=each, factor=1.0, span=node.span)
        case And(args=args) | Or(args=args):
            return replace(node, args=tuple(_shared(arg, each) for arg in args))
        case Always(arg=arg) | Eventually(arg=arg):
            return replace(node, arg=_shared(arg, each))
        case _:
            return node
