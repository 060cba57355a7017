"""`disturbance |w| <= 0.05`: what pushes an agent, whatever it is, and the feedback against it.

The gain is that of the linear-quadratic regulator with unit weights, from the discrete algebraic
Riccati equation; where there is none (the dynamics can't be stabilised) there is no feedback.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from stlc.dynamics import Dynamics
from stlc.ir.nodes import Link, Node, Quantity, Swept, walk
from stlc.mission import Agent, Array, Bound
from stlc.sema import props
from stlc.sema.members import unit_of
from stlc.sema.name_errors import NotHere
from stlc.sema.noise import size_of
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.values import Env
from stlc.source import Span
from stlc.syntax import ast
from stlc.tubes import Tube

_USAGE = "disturbance |w| <= 0.05"


def tube_of(
    item: ast.Property | None, base: Dynamics, block: props.Block, env: Env, scope: Scope
) -> Tube | None:
    """The disturbance of each step's inputs: one bound for all, or one for each. Raises Mistake."""
    if item is None:
        return None
    if base.varies:
        problem = "no feedback is known for dynamics that change from step to step"
        raise Mistake(NotHere(span=item.span, problem=problem, hint="leave out `disturbance`"))
    for other in ("integer", "turn_rate"):
        if block.get(other) is not None:
            problem = f"a disturbed agent can't be `{other}`: feedback changes its inputs"
            hint = f"leave out `{other}` or `disturbance`"
            raise Mistake(NotHere(span=item.span, problem=problem, hint=hint))
    units = [unit_of(u) for u in base.input_units]
    expr = _limit(item)
    bound = size_of(item, expr, units, list(range(len(units))), env, scope, _USAGE)
    return Tube(bound, feedback(base))


def _limit(item: ast.Property) -> ast.Expr:
    """The bound in `|w| <= bound`, or what stands alone."""
    expr = props.only(item, _USAGE)
    if not isinstance(expr, ast.Comparison):
        return expr
    plain = len(expr.operators) == 1 and expr.operators[0] in ("<", "<=")
    if not plain or not isinstance(expr.operands[0], ast.Absolute):
        raise props.bad(item, "bounds the size of the disturbance", _USAGE)
    return expr.operands[1]


def feedback(base: Dynamics) -> Array:
    """K (m, n) of u = K e."""
    from scipy.linalg import solve_discrete_are

    n, m = base.B.shape
    try:
        cost = solve_discrete_are(base.A, base.B, np.eye(n), np.eye(m))
    except (np.linalg.LinAlgError, ValueError):
        return np.zeros((m, n))
    gain = np.linalg.solve(np.eye(m) + base.B.T @ cost @ base.B, base.B.T @ cost @ base.A)
    return np.asarray(-gain, dtype=np.float64)


def check_tubes(formulas: Iterable[Node], scope: Scope) -> None:
    """Report what is asked of disturbed agents that no tube tells: some links, and their motion
    past what has heights; and of robots: the cost of a link that is given as a table over cells."""
    _check_tables(formulas := tuple(formulas), scope)
    disturbed = {name for name, agent in scope.agents.items() if agent.tube is not None}
    if not disturbed:
        return
    for formula in formulas:
        for node in walk(formula):
            if isinstance(node, Link) and {node.sender, node.receiver} & disturbed:
                _check_link(node, scope)
            elif node.swept is not None and _by_heights(node.swept, scope) & disturbed:
                _refuse(node.span, "its motion in space between the steps", scope)


def _check_link(link: Link, scope: Scope) -> None:
    """A link of disturbed agents is known where whatever is worst over a cell is."""
    channel = scope.channels[link.channel]
    pair = (link.sender, link.receiver)
    agents = [scope.agents[name] for name in pair if name in scope.agents]
    pushed = [a for a in agents if a.tube is not None]
    tabled = link.quantity is Quantity.COST and channel.has_table(pair)
    if channel.model is None or tabled:
        _refuse(link.span, "a link that is given as a table", scope)
    elif channel.predicate_bound is not Bound.WORST:
        _refuse(link.span, f"a link with `bound {channel.predicate_bound.value}`", scope)
    elif not all(_stays(a) for a in pushed):
        _refuse(link.span, "links: nothing keeps it near its plan", scope)


def _stays(agent: Agent) -> bool:
    model, tube = agent.dynamics, agent.tube
    return tube is None or bool(np.isfinite(tube.widest(model.A, model.B)).all())


def _check_tables(formulas: Iterable[Node], scope: Scope) -> None:
    """A table has one cost a cell, and a robot may be in another than its plan."""
    robots = {name for name, agent in scope.agents.items() if agent.robot is not None}
    if not robots:
        return
    for node in (n for formula in formulas for n in walk(formula)):
        if not isinstance(node, Link) or node.quantity is not Quantity.COST:
            continue
        pair = (node.sender, node.receiver)
        if robots & {*pair} and scope.channels[node.channel].has_table(pair):
            problem = (
                f"the cost of a robot's link isn't known by cells: `{node.channel}` is a table"
            )
            hint = "ask for it of a channel with a model, or minimise it"
            scope.report.add(NotHere(span=node.span, problem=problem, hint=hint))


def _by_heights(swept: Swept, scope: Scope) -> set[str]:
    """Who flies past a place between heights."""
    agent = scope.agents.get(swept.agent)
    if swept.place is None or agent is None or agent.dynamics.altitude is None:
        return set()
    place = scope.obstacles.get(swept.place) or scope.regions.get(swept.place)
    return set() if place is None or place.heights is None else {agent.name}


def _refuse(span: Span | None, what: str, scope: Scope) -> None:
    problem = f"of a disturbed agent nothing is promised about {what}"
    hint = "ask for it at the steps, or leave `disturbance` out"
    scope.report.add(NotHere(span=span, problem=problem, hint=hint))
