"""`swept`: a condition that holds between two steps too.

Between steps t and t + 1 a state follows its flow, which `stlc/bezier.py` cuts into parts with
Bezier points that are linear in x(t) and u(t): for a double integrator p(t), p(t) + v(t) dt / 2,
p(t + 1). A linear predicate that holds at all Bezier points of a part holds on the curve, which
lies in their convex hull. Each part makes its own choices; a single or double integrator has one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stlc.bezier import Curve, curve
from stlc.ir.nodes import (
    And,
    Const,
    Linear,
    Motion,
    Node,
    Or,
    Role,
    Signal,
    Swept,
    Timed,
    walk,
)
from stlc.mission import Agent
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import NoSwept
from stlc.source import Span

_POINTS = 3  # of the motion for a predicate, mostly; each takes as long as an evaluation

Part = tuple[int, int]
"""Which part of a step, of how many."""


def sweep(node: Node, scope: Scope, span: Span) -> Node:
    """Every linear leaf replaced by its conjunction over the Bezier points, part by part."""
    parts = parts_of(node, scope, span)
    scope.spend(_POINTS * parts * sum(isinstance(n, Linear) for n in walk(node)), span)
    swept = tuple(sweep_part(node, (part, parts), scope, span) for part in range(parts))
    return swept[0] if parts == 1 else And(swept, span=node.span)


def parts_of(node: Node, scope: Scope, span: Span) -> int:
    """Parts that a step falls into for the agents whose states a condition speaks of."""
    owners = {
        signal.owner
        for leaf in walk(node)
        if isinstance(leaf, Linear)
        for signal, _ in leaf.terms
        if signal.role is Role.STATE
    }
    return max((known_curve(scope.agents[o], scope, span).parts for o in owners), default=1)


def sweep_part(node: Node, part: Part, scope: Scope, span: Span, change: float = 0.0) -> Node:
    """Every linear leaf replaced by its conjunction over the Bezier points of one part.

    `change` is how much each leaf's constant grows, evenly, from a step to the next.
    """
    if isinstance(node, Linear):  # as most are, of places
        return _sweep_linear(node, part, scope, span, change)
    done: dict[int, Node] = {}  # formulas that use a part often have too many paths to walk

    def swept(node: Node) -> Node:
        if id(node) not in done:
            done[id(node)] = replaced(node)
        return done[id(node)]

    def replaced(node: Node) -> Node:
        match node:
            case Linear():
                return _sweep_linear(node, part, scope, span, change)
            case And(args=args) | Or(args=args):
                return replace(node, args=tuple(map(swept, args)))
            case Timed(cases=cases):
                return replace(node, cases=tuple(map(swept, cases)))
            case Const():
                return node
        raise Mistake(NoSwept(span=span, problem="this is not a condition on positions"))

    return swept(node)


def _sweep_linear(node: Linear, part: Part, scope: Scope, span: Span, change: float) -> Node:
    """The conjunction of a predicate at the Bezier points of one part of a step."""
    if any(signal.role is Role.FREE for signal, _ in node.terms):
        raise Mistake(NoSwept(span=span, problem="a recorded signal has no motion"))
    moving = [s for s, _ in node.terms if s.role is Role.STATE]
    degree = max((_degree(s, part, scope, span) for s in moving), default=1)
    points = []
    for stage in range(degree + 1):
        share = (part[0] + stage / degree) / part[1]
        points.append(_at(node, part, degree, stage, scope, span, change * share))
    unique = tuple(dict.fromkeys(points))
    return unique[0] if len(unique) == 1 else And(unique, span=node.span)


def known_curve(agent: Agent, scope: Scope, span: Span, parts: int | None = None) -> Curve:
    """The motion of an agent between steps. Raises Mistake where it isn't known."""
    key = (agent.name, parts)
    if key not in scope.curves:
        scope.curves[key] = curve(agent.dynamics, scope.step, parts)
    found = scope.curves[key]
    if found is not None:
        return found
    name, model = agent.name, agent.dynamics.name
    problem = f"the discrete matrices of `{name}` don't say how it moves between steps"
    hint = f"say `straight` in dynamics `{model}` if it moves straight from sample to sample"
    if agent.dynamics.varies:
        problem = f"how `{name}`, whose matrices change, moves between steps isn't known"
    else:
        hint += ", or give its matrices as `continuous`"
    raise Mistake(NoSwept(span=span, problem=problem, hint=hint))


def known_degree(found: Curve, agent: Agent, states: list[int], span: Span) -> int:
    """Degree of the Bezier points of some states. Raises Mistake where they move too fast."""
    degree = found.degree(states)
    if degree is not None:
        return degree
    problem = f"`{agent.name}` has modes far faster than a step of {found.step:g} s"
    hint = "shorten `step`, or leave the fastest modes out of its dynamics"
    raise Mistake(NoSwept(span=span, problem=problem, hint=hint))


def _degree(signal: Signal, part: Part, scope: Scope, span: Span) -> int:
    agent = scope.agents[signal.owner]
    found = known_curve(agent, scope, span, part[1])
    return known_degree(found, agent, [signal.index], span)


def separation_claim(node: Node, scope: Scope) -> Swept | None:
    """What a separation says of the motion, read off its four half-planes; None for the rest."""
    if node.norms is not None:
        return None
    leaves = _alternatives(node)
    gaps = [_gap(leaf, scope) for leaf in leaves]
    found = {(gap[2], gap[3]): gap for gap in gaps if gap is not None}
    pairs = {gap[:2] for gap in found.values()}
    if len(leaves) != 4 or len(found) != 4 or len(pairs) != 1:
        return None
    x, y = ([found[axis, sign][4] for sign in (1.0, -1.0)] for axis in (0, 1))
    if x[0] != x[1] or y[0] != y[1]:
        return None
    ((agent, other),) = pairs
    return Swept(Motion.SEPARATION, agent, other=other, distances=(x[0], y[0]))


def _alternatives(node: Node) -> tuple[Node, ...]:
    """Arguments of a disjunction, those of a disjunction within it included."""
    if not isinstance(node, Or):
        return (node,)
    return tuple(b for a in node.args for b in (a.args if isinstance(a, Or) else (a,)))


def _gap(leaf: Node, scope: Scope) -> tuple[str, str, int, float, float] | None:
    """(agent, other, axis, sign, distance) of sign * (p_agent - p_other) >= distance."""
    if not isinstance(leaf, Linear) or len(leaf.terms) != 2:
        return None
    (one, sign), (two, opposite) = leaf.terms
    axes = [_axis(signal, scope) for signal in (one, two)]
    if axes[0] is None or axes[0] != axes[1] or one.owner == two.owner:
        return None
    if abs(sign) != 1.0 or opposite != -sign:
        return None
    return one.owner, two.owner, axes[0], sign, -leaf.constant


def _axis(signal: Signal, scope: Scope) -> int | None:
    """0 or 1 when the signal is a coordinate of its agent's position now."""
    agent = scope.agents.get(signal.owner)
    if agent is None or agent.dynamics.position is None:
        return None
    if signal.role is not Role.STATE or signal.shift:
        return None
    for axis, row in enumerate(agent.dynamics.position):
        if row[signal.index] == 1.0 and abs(row).sum() == 1.0:
            return axis
    return None


def _at(
    node: Linear, part: Part, degree: int, stage: int, scope: Scope, span: Span, change: float
) -> Linear:
    """The predicate, its constant changed, at one Bezier point of the motion within a step, as a
    predicate of samples."""
    terms: dict[Signal, float] = {}
    constant = node.constant
    for signal, coefficient in node.terms:
        key = (signal, part, degree, stage)
        known = scope.points.get(key)
        if known is None:
            known = scope.points[key] = _bezier(signal, part, degree, stage, scope, span)
        form, offset = known
        constant += coefficient * offset
        for moved, factor in form:
            terms[moved] = terms.get(moved, 0.0) + coefficient * factor
    kept = [(s, c) for s, c in terms.items() if c != 0.0]
    if len(kept) > 1:
        kept.sort(key=lambda term: term[0].key)
    return Linear(
        tuple(kept), constant + change, node.unit,
        span=node.span, swept=node.swept, member=node.member, norms=node.norms,
    )  # fmt: skip


def _bezier(
    signal: Signal, part: Part, degree: int, stage: int, scope: Scope, span: Span
) -> tuple[list[tuple[Signal, float]], float]:
    """A signal's Bezier point as terms and a constant; an input is constant over the step."""
    index, parts = part
    if signal.role is not Role.STATE or (index == stage == 0):
        return [(signal, 1.0)], 0.0
    if index == parts - 1 and stage == degree:
        return [(signal._replace(shift=signal.shift + 1), 1.0)], 0.0
    found = known_curve(scope.agents[signal.owner], scope, span, parts)
    row = found.points(degree)[index, stage, signal.index]
    n = len(scope.agents[signal.owner].dynamics.states)
    terms = [
        (
            signal._replace(role=Role.STATE, index=int(k))
            if k < n
            else signal._replace(role=Role.INPUT, index=int(k) - n),
            float(row[k]),
        )
        for k in np.flatnonzero(row[:-1])
    ]
    return terms, float(row[-1])
