"""Predicates that the ranges decide.

At a requirement of margin m whose robustness is never asked to exceed c (the static upper bound of
the objective's robustness columns, or m where there are none), over ranges in which mu lies in
[low, high]:

    mu >= 0  =  true    where low >= c            mu >= 0  =  false   where high < m
    f        =  false   where the static upper bound of f is below m

Predicates asserted outright narrow the ranges of their signals first, and so on to a fixed number
of rounds: what must hold cuts the reach sets, which decides more predicates.

Needs: unroll. Guarantees: the runs with robustness >= m are the same, and on them min(robustness,
c) is the same; raises Unreachable where a requirement cannot reach its margin.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stlc.analysis.bounds import Interval, static_bounds, unit_of
from stlc.analysis.goals import Level, level_of
from stlc.analysis.reach import reach
from stlc.analysis.unreachable import refuse
from stlc.ir.networks import Count, Network
from stlc.ir.nodes import And, Const, Linear, Link, Node, Not, Or
from stlc.ir.requirement import Requirement
from stlc.ir.rewrite import postorder, with_children
from stlc.ir.verify import Stage
from stlc.passes.base import Decided, Pass, Program
from stlc.passes.fold import fold

_ROUNDS = 3
_TOLERANCE = 1e-6  # a satisfied formula may miss its margin by this much


def run(program: Program) -> Program:
    """Decide predicates and narrow the ranges, in turns."""
    program = _decide(program)  # before narrowing: one requirement alone is the clearer error
    for _ in range(_ROUNDS):
        before = program
        narrowed = _narrow(program)
        if narrowed is program:
            return program
        program = _decide(narrowed)
        if program.formulas == before.formulas:
            return program
    return program


def _narrow(program: Program) -> Program:
    musts = [
        (node, requirement.margin - _TOLERANCE)
        for requirement in program.requirements
        for node in _asserted(requirement.formula)
    ]
    ranges = reach(program.mission, musts, program.ranges)
    same = all(ranges[n].near(known, _TOLERANCE) for n, known in program.ranges.items())
    return program if same else replace(program, ranges=ranges)


def _asserted(root: Node) -> list[Linear]:
    found, todo = [], [root]
    while todo:
        node = todo.pop()
        if isinstance(node, Linear):
            found.append(node)
        elif isinstance(node, And):
            todo.extend(node.args)
    return found


def _decide(program: Program) -> Program:
    """One round over the present ranges; Unreachable where a requirement has become false."""
    memo = program.decided
    if memo.ranges is not program.ranges:
        memo = Decided(program.ranges)
    goals = program.known_goals()
    static_bounds(program.formulas, program.ranges, None, program.link_bounds, memo.bounds)
    known: dict[Node, Node] = {}
    formulas = []
    for requirement in program.requirements:
        level = level_of(requirement, goals)
        settled = memo.settled.setdefault(level, set())
        formula = _decided(requirement, level, memo.bounds, known, settled)
        if formula == Const(False):
            refuse(requirement)
        formulas.append(formula)
    return replace(program.with_formulas(formulas), goals=goals, decided=memo)


def _decided(
    requirement: Requirement,
    level: Level,
    bounds: Mapping[Node, Interval],
    known: dict[Node, Node],
    settled: set[Node],
) -> Node:
    """A requirement's formula with true and false in place of what the bounds decide; nodes
    `settled` stay as they are, and those that this leaves as they are join them."""
    done: dict[Node, Node] = {}
    for node in postorder([requirement.formula], settled):
        low, high = bounds[node]
        if high < requirement.margin - _TOLERANCE:
            built: Node = Const(False, span=node.span)
        elif isinstance(node, Linear | Link | Not):
            free = low >= level.ceiling(unit_of(node))
            built = Const(True, span=node.span) if free else node
        elif isinstance(node, And | Or | Count) or _is_graph(node):
            built = fold(with_children(node, [done.get(c, c) for c in node.children]))
        else:
            built = node
        done[node] = known.setdefault(built, built)
    settled.update(node for node, built in done.items() if built is node)
    return done.get(requirement.formula, requirement.formula)


def _is_graph(node: Node) -> bool:
    """Whether only truth and level of a network's edges matter, not how good each link is."""
    return isinstance(node, Network) and not node.composed


PASS = Pass("decide", run, after=("unroll",), stage=Stage.STEPS, preserves="optima")
