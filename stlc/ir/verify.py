"""Checks a program's invariants after every pass; a broken one is our own bug.

Stages grow stricter: ANY is what semantic analysis hands over, NNF has negation at chance links
only, BOUNDED has no open interval, STEPS has no temporal operator left (every predicate carries
its absolute step as a shift).
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

from stlc.ir.networks import Count, Network
from stlc.ir.nodes import (
    Always,
    Eventually,
    Iff,
    Implies,
    Linear,
    Link,
    Node,
    Not,
    Release,
    Timed,
    Until,
)
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import postorder


class Stage(IntEnum):
    """What earlier passes have established."""

    ANY = 0
    NNF = 1
    BOUNDED = 2
    STEPS = 3


class BrokenProgram(AssertionError):
    """A pass broke an invariant."""


def verify(
    requirements: Sequence[Requirement],
    horizon: int,
    stage: Stage,
    where: str,
    sound: set[Node] | None = None,
) -> int:
    """The number of distinct nodes.

    `sound` are nodes that hold at this stage, which the others are added to. Raises BrokenProgram
    naming the pass `where` if an invariant of `stage` does not hold.
    """
    sound, count = set() if sound is None else sound, 0
    for node in postorder(r.formula for r in requirements):
        count += 1
        fault = "" if node in sound else _fault(node, horizon, stage)
        if fault:
            raise BrokenProgram(f"after {where}: {fault}")
        sound.add(node)
    return count


def _fault(node: Node, horizon: int, stage: Stage) -> str:
    """What is wrong with this node alone at `stage`, or nothing."""
    match node:
        case Linear():
            return _linear_fault(node, horizon)
        case Link(shift=shift):
            return "" if 0 <= shift <= horizon else f"link shift {shift} outside the horizon"
        case Always() | Eventually() | Until() | Release():
            return _temporal_fault(node, stage)
        case Timed(cases=cases):
            if not cases:
                return "timed without a case"
            return "timed after unrolling" if stage >= Stage.STEPS else ""
        case Not(arg=arg):
            bare = isinstance(arg, Link) and arg.probability is not None
            return "" if bare or stage < Stage.NNF else "negation of a formula after nnf"
        case Count():
            return _count_fault(node)
        case Network():
            return _network_fault(node)
        case Implies() | Iff():
            return "" if stage < Stage.NNF else f"{type(node).__name__} after nnf"
    return ""


def _count_fault(node: Count) -> str:
    if node.weights and (len(node.weights) != len(node.args) or min(node.weights) < 1):
        return "a count with other weights than one of at least 1 for each argument"
    most = sum(node.shares)
    return "" if 1 <= node.least <= most else f"a count of {node.least} of {most}"


def _network_fault(node: Network) -> str:
    if len(node.ends) != len(node.args):
        return "a network with ends for other edges than it has"
    if any(not 0 <= a < b < len(node.vertices) for a, b in node.ends):
        return "an edge between vertices that a network doesn't have"
    if node.composed and not all(isinstance(a, Link) and a.tight for a in node.args):
        return "a composed network over anything but tight links"
    return ""


def _linear_fault(node: Linear, horizon: int) -> str:
    keys = [signal.key for signal, _ in node.terms]
    if keys != sorted(set(keys)):
        return "terms of a predicate are not sorted or not distinct"
    if any(value == 0 for _, value in node.terms):
        return "a zero coefficient"
    if any(not 0 <= signal.shift <= horizon for signal, _ in node.terms):
        return "a signal outside the horizon"
    return ""


def _temporal_fault(node: Always | Eventually | Until | Release, stage: Stage) -> str:
    if stage >= Stage.STEPS:
        return f"{type(node).__name__} after unrolling"
    if node.end is None:
        return "an open interval after horizon" if stage >= Stage.BOUNDED else ""
    return "" if 0 <= node.start <= node.end else f"interval [{node.start},{node.end}]"
