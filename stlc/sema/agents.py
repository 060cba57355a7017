"""Agents, and families of agents."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from stlc.dynamics import Dynamics
from stlc.mission import Agent, Array, TurnRate
from stlc.sema import noise, props, robots
from stlc.sema.bounds import Bounds, apply
from stlc.sema.dynamics import STRUCTURE, dynamics
from stlc.sema.files import Files
from stlc.sema.heights import antenna, stay_within
from stlc.sema.integrators import KINDS, ROBOTS, named
from stlc.sema.members import unit_of
from stlc.sema.name_errors import UnknownName, WrongKind
from stlc.sema.report import Mistake, Reported, suggested_fix, suggestion
from stlc.sema.scope import EMPTY, Scope
from stlc.sema.shape_errors import FrozenAtStart, MissingStart, TurnRateNeeds
from stlc.sema.shapes import near
from stlc.sema.tubes import tube_of
from stlc.sema.units import KILOGRAM, METRE, SPEED
from stlc.sema.values import Env, Items, Radio, Scalar
from stlc.sema.warnings import OneSided
from stlc.syntax import ast

PROPERTIES = (
    "start", "control", "speed", "state", "turn_rate", "mass", "effort_state", "effort_input",
    "integer", "start_noise", "control_noise", "disturbance", "antenna",
)  # fmt: skip
_BOUNDING = ("control", "speed", "state")
MOST_MEMBERS = 10_000


def declare(statement: ast.AgentDecl, scope: Scope) -> None:
    """Declare an agent, or every member of a family. Raises Mistake or Reported."""
    name = statement.name.text
    try:
        if statement.family is None:
            made = agent(statement, name, EMPTY, scope)
            scope.agents[name] = made
            scope.values[name] = Radio(made)
        else:
            scope.values[name] = family(statement, statement.family, scope)
    except (Mistake, Reported):
        scope.broken.add(name)
        raise


def family(statement: ast.AgentDecl, numbers: ast.Range, scope: Scope) -> Items:
    """`agent uav[1..4]`: its properties may use the member's number, `i`."""
    first, last = scope.whole(numbers.start), scope.whole(numbers.end)
    if not first <= last < first + MOST_MEMBERS:
        raise Mistake(WrongKind(span=numbers.span, expected="a range such as `1..4`", found="this"))
    members = []
    for number in range(first, last + 1):
        name = f"{statement.name.text}[{number}]"
        scope.agents[name] = made = agent(statement, name, Env({"i": Scalar(number)}), scope)
        members.append(Radio(made))
    return Items(tuple(members), "family")


def _apply_all(every: Iterable[ast.Property], bounds: Bounds, scope: Scope) -> None:
    for prop in every:
        with scope.report.guard():
            apply(prop, bounds, scope)
    stay_within(bounds, scope)


def agent(statement: ast.AgentDecl, name: str, env: Env, scope: Scope) -> Agent:
    """One agent: its dynamics' bounds and its own, the latter first."""
    base, inherited = model_of(statement.dynamics, scope)
    limits = [*base.states, *base.inputs]
    owner = f"agent `{statement.name.text}`"
    own = _known(owner, statement.properties, [*robots.known(base, PROPERTIES), *limits], scope)
    keys = {p.key.text for p in own}
    every = [*own, *(p for p in inherited if p.key.text not in keys)]
    block = props.Block(owner, {p.key.text: p for p in every})
    mass = _mass(block, env, scope)
    bounds = Bounds(base, mass, env)
    _apply_all((p for p in every if p.key.text in (*_BOUNDING, *limits)), bounds, scope)
    _tell_of_open_sides(name, bounds, block, scope)
    robot = robots.robot_of(block, base, statement.name, bounds.input_norms, env, scope)
    made = Agent(
        name=name,
        dynamics=base,
        start=robots.planned_start(start(statement, block, base, env, scope), robot),
        state_lower=bounds.state_lower,
        state_upper=bounds.state_upper,
        input_lower=bounds.input_lower,
        input_upper=bounds.input_upper,
        effort_state=_weights(block, "effort_state", base.states, 0.0, scope, env),
        effort_input=_weights(block, "effort_input", base.inputs, 1.0, scope, env),
        integer_inputs=block.get("integer") is not None,
        state_norms=tuple(bounds.state_norms),
        input_norms=robots.followed(bounds.input_norms, robot),
        mass=mass,
        start_noise=noise.of_start(block.get("start_noise"), base, env, scope),
        input_noise=noise.of_inputs(block.get("control_noise"), base, env, scope),
        antenna=antenna(block, base, env, scope),
        tube=tube_of(block.get("disturbance"), base, block, env, scope),
        robot=robot,
        span=statement.name.span,
    )
    scope.starts[name] = (block.get("start") or statement.name).span
    if robot is None:
        with scope.report.guard():
            return replace(made, turn_rate=turn_rate(block, made, scope, env))
    return made


def _mass(block: props.Block, env: Env, scope: Scope) -> float:
    """The agent's mass [kg], 1 where it isn't given."""
    item = block.get("mass")
    if item is None:
        return 1.0
    if (mass := scope.number(props.only(item, "mass 1 kg"), KILOGRAM, env)) <= 0:
        raise props.bad(item, "must be above 0", "mass 1 kg")
    return mass


def _tell_of_open_sides(name: str, bounds: Bounds, block: props.Block, scope: Scope) -> None:
    """Warn of controls with a bound on one side alone, unless a norm bounds both."""
    round_ones = {i for norm in bounds.input_norms for i in norm.indices}
    for i, word in enumerate(bounds.dynamics.inputs):
        below, above = np.isfinite([bounds.input_lower[i], bounds.input_upper[i]])
        item = block.get("control") or block.get(word)
        if below == above or i in round_ones or item is None:
            continue
        side = "lower" if above else "upper"
        scope.report.add(OneSided(span=item.span, name=word, agent=name, side=side))


def _known(
    owner: str, properties: Sequence[ast.Property], known: Sequence[str], scope: Scope
) -> list[ast.Property]:
    """Properties of known keys; a bound may be given in several lines."""
    kept = []
    for item in properties:
        if item.key.text in known:
            kept.append(item)
        else:
            scope.report.add(props.unknown_property(owner, item, known))
    return kept


def model_of(name: ast.Ident, scope: Scope) -> tuple[Dynamics, list[ast.Property]]:
    """The dynamics of that name, and the bounds that their block gives to every agent."""
    found = scope.declarations.get(name.text)
    if isinstance(found, ast.DynamicsDecl):
        scope.used.add(name.text)
        if name.text in scope.broken:
            raise Reported
        model = scope.models[name.text]
        keys = {*robots.known(model, PROPERTIES), *model.states, *model.inputs} - {*STRUCTURE}
        return model, [p for p in found.properties if p.key.text in keys]
    if found is None and name.text in KINDS:
        return named(name, props.Block(f"dynamics `{name.text}`", {}), scope), []
    known = [n for n, d in scope.declarations.items() if isinstance(d, ast.DynamicsDecl)]
    known += KINDS
    hint = suggestion(name.text, known, "declare it: `dynamics cart = double_integrator`")
    fix = suggested_fix(name.span, name.text, known)
    raise Mistake(UnknownName(span=name.span, name=name.text, hint=hint, fix=fix))


def declare_dynamics(statement: ast.DynamicsDecl, scope: Scope, files: Files) -> None:
    """Declare dynamics; bounds in their block are left for the agents."""
    name = statement.name.text
    kind = "" if statement.kind is None else statement.kind.text
    bounding = (*PROPERTIES, *(robots.PROPERTIES if kind in ROBOTS else ()))
    structure = [p for p in statement.properties if p.key.text not in bounding]
    try:
        made = dynamics(statement, structure, scope, files)
    except (Mistake, Reported):
        scope.broken.add(name)
        raise
    scope.models[name] = replace(made, name=name if statement.kind is None else made.name,
                                 span=statement.name.span)  # fmt: skip


def start(
    statement: ast.AgentDecl, block: props.Block, base: Dynamics, env: Env, scope: Scope
) -> Array:
    """The state at step 0: all of it, or a position, the rest being zero."""
    item = block.get("start")
    n = len(base.states)
    if item is None:
        usage = "(1, 1)" if base.position is not None else f"({', '.join(['0'] * n)})"
        name = statement.name
        raise Mistake(MissingStart(span=name.span, name=name.text, usage=usage))
    expr = props.only(item, "start (1, 1)")
    value = scope.value(expr, env)
    count = len(value.items) if isinstance(value, Items) else 1
    axes = [k for k, state in enumerate(base.states) if state in ("px", "py", "pz")]
    if base.name in KINDS and count == len(axes) < n:
        full = np.zeros(n)
        full[axes] = props.numbers(expr, scope, [METRE] * count, env)
    elif count == len(base.axes) < n:
        where = props.numbers(expr, scope, [METRE] * count, env)
        full = np.zeros(n)
        full[[int(np.argmax(row)) for row in base.axes]] = where
    else:
        full = props.numbers(expr, scope, [unit_of(u) for u in base.state_units], env)
    for row in base.axes:
        near(float(row @ full), expr.span)
    return full


def _weights(
    block: props.Block,
    key: str,
    names: tuple[str, ...],
    default: float,
    scope: Scope,
    env: Env,
) -> Array:
    """One weight for each of `names`, from a number or a tuple; never negative, without units."""
    item = block.get(key)
    if item is None:
        return np.full(len(names), default)
    usage = f"{key} ({', '.join('1' for _ in names)})"
    expr = props.only(item, usage)
    value = scope.value(expr, env)
    if isinstance(value, Scalar):
        weights = np.full(len(names), scope.constant(expr, env).constant)
    else:
        weights = props.numbers(expr, scope, [None] * len(names), env)
    if (weights < 0).any():
        raise props.bad(item, "has a negative weight", usage)
    return weights


def turn_rate(block: props.Block, made: Agent, scope: Scope, env: Env) -> TurnRate | None:
    """`turn_rate on` or `turn_rate literal`, with `directions 16` and `rest_speed 0.05`."""
    item = block.get("turn_rate")
    if item is None:
        return None
    usage = "turn_rate on"
    words = list(item.args)
    head = words.pop(0) if words else None
    mode = head.text if isinstance(head, ast.Name) else ""
    if mode not in ("on", "off", "literal"):
        raise props.bad(item, "is `on`, `off` or `literal`", usage)
    if mode == "off":
        return None
    options = {"directions": 16.0, "rest_speed": 0.05}
    while words:
        key = words.pop(0)
        if not isinstance(key, ast.Name) or key.text not in options or not words:
            raise props.bad(item, "has an unknown word", f"{usage} directions 16", key.span)
        options[key.text] = scope.number(words.pop(0), SPEED, env)
    return _turn_rate(item, made, mode == "literal", options)


def _turn_rate(
    item: ast.Property, made: Agent, literal: bool, options: dict[str, float]
) -> TurnRate:
    """The turning rate's limits: the tightest of the agent's speeds [m/s] and inputs.

    Mistake without velocity, two inputs and finite limits, and for `literal` at rest, which freezes
    the agent.
    """
    velocity = made.dynamics.velocity
    speeds = [b.limit for b in made.state_norms if b.indices == velocity]
    if velocity is None or len(made.dynamics.inputs) != 2:
        what = "an agent with a velocity and two inputs"
        raise Mistake(TurnRateNeeds(span=item.span, what=what))
    if not speeds:
        speeds = [float(min(made.state_upper[k], -made.state_lower[k])) for k in velocity]
    inputs = [b.limit for b in made.input_norms]
    if not inputs:
        inputs = [float(v) for v in np.minimum(made.input_upper, -made.input_lower)]
    v_max, u_max = min(speeds), min(inputs)
    if not (0 < v_max < np.inf and 0 < u_max < np.inf):
        raise Mistake(TurnRateNeeds(span=item.span, what="a speed limit and an input limit"))
    directions = int(options["directions"])
    if directions != options["directions"] or not 3 <= directions <= 360:
        raise props.bad(item, "needs 3 to 360 directions", "turn_rate on directions 16")
    if literal and not np.any(made.start[list(velocity)]):
        raise Mistake(FrozenAtStart(span=item.span, name=made.name))
    return TurnRate(u_max, v_max, directions, literal, options["rest_speed"], item.span)
