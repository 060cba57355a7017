"""`swept`: a condition that holds between two steps too.

Between steps t and t + 1 a double integrator's position is a quadratic curve with the Bezier points
p(t), p(t) + v(t) dt / 2, p(t + 1); every other state is followed along its chord. A linear
predicate that holds at all Bezier points holds on the curve, which lies in their convex hull.
"""

from __future__ import annotations

from dataclasses import replace

from stlc.ir.nodes import And, Const, Linear, Motion, Node, Or, Role, Signal, Swept, Timed
from stlc.mission import Agent, Dynamics
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import NoSwept
from stlc.source import Span

Terms = tuple[tuple[Signal, float], ...]


def sweep(node: Node, scope: Scope, span: Span, change: float = 0.0) -> Node:
    """Every linear leaf replaced by its conjunction over the Bezier points.

    `change` is how much each leaf's constant grows, evenly, from a step to the next.
    """
    match node:
        case Linear():
            return sweep_linear(node, scope, span, change)
        case And(args=args):
            return replace(node, args=tuple(sweep(a, scope, span, change) for a in args))
        case Or(args=args):
            return replace(node, args=tuple(sweep(a, scope, span, change) for a in args))
        case Timed(cases=cases):
            return replace(node, cases=tuple(sweep(c, scope, span, change) for c in cases))
        case Const():
            return node
    raise Mistake(NoSwept(span=span, problem="this is not a condition on positions"))


def sweep_linear(node: Linear, scope: Scope, span: Span, change: float = 0.0) -> Node:
    """The conjunction of a predicate at the Bezier points of the motion to the next step."""
    if any(signal.role is Role.FREE for signal, _ in node.terms):
        raise Mistake(NoSwept(span=span, problem="a recorded signal has no motion"))
    curved = any(_velocity_of(signal, scope) is not None for signal, _ in node.terms)
    stages = (0, 1, 2) if curved else (0, 2)
    points = tuple(
        replace(point, constant=point.constant + change * stage / 2.0)
        for stage, point in ((stage, _at(node, stage, scope)) for stage in stages)
    )
    unique = tuple(dict.fromkeys(points))
    return unique[0] if len(unique) == 1 else And(unique, span=node.span)


def separation_claim(node: Node, scope: Scope) -> Swept | None:
    """What a separation says of the motion, read off its four half-planes; None for the rest."""
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


def _at(node: Linear, stage: int, scope: Scope) -> Linear:
    terms: dict[Signal, float] = {}
    for signal, coefficient in node.terms:
        for moved, factor in _bezier(signal, stage, scope):
            terms[moved] = terms.get(moved, 0.0) + coefficient * factor
    kept = [(s, c) for s, c in terms.items() if c != 0.0]
    kept.sort(key=lambda term: term[0].key)
    return replace(node, terms=tuple(kept))


def _bezier(signal: Signal, stage: int, scope: Scope) -> Terms:
    """One state's Bezier point 0, 1 or 2; an input is constant over the step."""
    after = replace(signal, shift=signal.shift + 1)
    if stage == 0 or signal.role is not Role.STATE:
        return ((signal, 1.0),)
    if stage == 2:
        return ((after, 1.0),)
    velocity = _velocity_of(signal, scope)
    if velocity is None:
        return ((signal, 0.5), (after, 0.5))
    return ((signal, 1.0), (replace(signal, index=velocity), scope.step / 2.0))


def _velocity_of(signal: Signal, scope: Scope) -> int | None:
    """The state that is the derivative of a position state which moves on a parabola."""
    agent = scope.agents.get(signal.owner)
    if agent is None or signal.role is not Role.STATE:
        return None
    return _derivatives(agent).get(signal.index)


def _derivatives(agent: Agent) -> dict[int, int]:
    dynamics: Dynamics = agent.dynamics
    if not dynamics.exact_quadratic or dynamics.position is None or dynamics.velocity is None:
        return {}
    rows = dynamics.position
    states = [int(row.nonzero()[0][0]) for row in rows]
    return dict(zip(states, dynamics.velocity, strict=True))
