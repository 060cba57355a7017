"""`P(always[2, 6] rssi(a, b) >= -70 dBm) >= 0.9`: one probability of several packets together.

Boole's inequality: the chance that any of n events fails is at most the sum of their chances. The
risk 1 - p is shared equally among the packets that have to get through at once, so that

    and, always       every part holds with its own share of the risk
    or, eventually    one alternative holds with the share of the whole

each packet's condition being P(link) >= 1 - (1 - p) / n (risk allocation; Blackmore and Ono,
Convex chance constrained predictive control without sampling, 2009). That is sufficient whatever
the packets have to do with each other, and never necessary: it stays a bound from one side.
"""

from __future__ import annotations

from dataclasses import replace

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
    count = packets(node)
    if count == 0:
        raise _unfit(node, "a formula without links")
    return _shared(node, 1.0 - (1.0 - probability) / count)


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
