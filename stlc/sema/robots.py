"""`agent r : unicycle { .. }` and `agent c : car { .. }`: what drives, and the plan it follows.

The mathematics is in `stlc/robots.py`. `start` is where the axle's centre is; the plan starts at
the look-ahead point.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil, cos, inf, isclose, pi, sin, tan

import numpy as np

from stlc.dynamics import Dynamics
from stlc.mission import Array, NormBound, PolygonKind
from stlc.robots import Robot, RobotKind, Steering
from stlc.sema import props
from stlc.sema.name_errors import NotHere
from stlc.sema.report import Mistake
from stlc.sema.robot_errors import NotTracked, RobotNeeds
from stlc.sema.scope import Scope
from stlc.sema.units import METRE, RADIAN, SECOND, Unit
from stlc.sema.values import Env
from stlc.source import Span
from stlc.syntax import ast

PROPERTIES = ("heading", "lookahead", "wheelbase", "steering", "directions", "period")
"""Of robots alone, besides those of any agent; `turn_rate` has a limit here."""

_PERIODS = 50
"""Control periods in a step by default: the tube of a robot that turns by a radian in a step is
then 0.005 % wider than without any, its plan 0.002 % slower."""
_MOST_PERIODS = 10_000
_MOST_DIRECTIONS = 360

_TURNING = Unit((("rad", 1), ("s", -1)))


def known(base: Dynamics, properties: Sequence[str]) -> list[str]:
    """Properties of an agent with these dynamics: robots have some of their own."""
    return [*properties, *(PROPERTIES if base.robot is not None else ())]


def robot_of(
    block: props.Block,
    base: Dynamics,
    name: ast.Ident,
    norms: Sequence[NormBound],
    env: Env,
    scope: Scope,
) -> Robot | None:
    """The robot that a block describes; None for other agents. Raises Mistake."""
    kind = base.robot
    if kind is None:
        return None
    _refuse(block, kind)
    reader = _Reader(block, kind, name, env, scope)
    speed = _speed(reader, norms)
    wheelbase = reader.needed("wheelbase", METRE, "0.3 m") if kind is RobotKind.CAR else 0.0
    turning = reader.turning(wheelbase)
    b = reader.given("lookahead", METRE, 1.0 / turning if wheelbase else speed / turning)
    heading = reader.given("heading", RADIAN, 0.0, least=-inf)
    still = Robot(kind, heading, speed, turning, b, scope.step, wheelbase=wheelbase, span=name.span)
    often = max(_PERIODS, ceil(4.0 * still.pace * scope.step / b))
    robot = replace(still, period=reader.given("period", SECOND, scope.step / often))
    _check_period(robot, reader)
    return _directed(robot, reader) if kind is RobotKind.CAR else robot


def followed(norms: Sequence[NormBound], robot: Robot | None) -> tuple[NormBound, ...]:
    """Norms of inputs; the speed of a robot becomes that of plans which it can follow."""
    if robot is None:
        return tuple(norms)
    fastest = robot.planned_speed
    return tuple(replace(n, limit=min(n.limit, fastest)) for n in norms)


def planned_start(place: Array, robot: Robot | None) -> Array:
    """Where the plan starts: at the look-ahead point of a robot at `place` (2,) [m]."""
    if robot is None:
        return place
    ahead = np.array([cos(robot.heading), sin(robot.heading)])
    return np.asarray(place + robot.lookahead * ahead)


class _Reader:
    """Numbers of a block, each in its unit."""

    def __init__(
        self, block: props.Block, kind: RobotKind, name: ast.Ident, env: Env, scope: Scope
    ) -> None:
        self.block, self.kind, self.name = block, kind, name
        self._env, self.scope = env, scope

    def given(self, key: str, unit: Unit, default: float, least: float = 0.0) -> float:
        """A number above `least`."""
        item = self.block.get(key)
        if item is None:
            return default
        usage = {"heading": "heading 90 deg", "period": "period 20 ms"}.get(key, f"{key} 0.3 m")
        value = self.scope.number(props.only(item, usage), unit, self._env)
        if not least < value < inf:
            raise props.bad(item, "must be above 0", usage)
        return value

    def needed(self, key: str, unit: Unit, usage: str) -> float:
        """A number that has no default."""
        if self.block.get(key) is None:
            raise self.lacking(key, f"{key} {usage}")
        return self.given(key, unit, inf)

    def lacking(self, key: str, usage: str) -> Mistake:
        """The Mistake about a property that is missing."""
        name, kind = self.name, self.kind.value
        needs = RobotNeeds(span=name.span, name=name.text, kind=kind, what=key, usage=usage)
        return Mistake(needs)

    def limit(self, key: str, unit: Unit, usage: str) -> float:
        """The limit in `key <= limit`."""
        item = self.block.get(key)
        if item is None:
            raise self.lacking(key, usage)
        expr = props.only(item, usage)
        if not isinstance(expr, ast.Comparison) or expr.operators not in (("<=",), ("<",)):
            raise props.bad(item, f"of a {self.kind.value} is a limit", usage)
        value = self.scope.number(expr.operands[1], unit, self._env)
        if not 0.0 < value < inf:
            raise props.bad(item, "needs a limit above 0", usage, expr.operands[1].span)
        return value

    def turning(self, wheelbase: float) -> float:
        """W [rad/s], or the greatest curvature of a car [1/m]."""
        if self.kind is RobotKind.UNICYCLE:
            return self.limit("turn_rate", _TURNING, "turn_rate <= 2 rad/s")
        steering = self.limit("steering", RADIAN, "steering <= 35 deg")
        if steering >= pi / 2.0:
            item = self.block.by_key["steering"]
            raise props.bad(item, "must be below a right angle", "steering <= 35 deg")
        return tan(steering) / wheelbase


_MEANINGLESS = {
    "disturbance": "its controller reckons with none",
    "start_noise": "its controller keeps it on its plan",
    "control_noise": "its controller keeps it on its plan",
    "integer": "its wheels take any speed",
    "mass": "it is planned by its speed alone",
}


def _refuse(block: props.Block, kind: RobotKind) -> None:
    """Raises Mistake for properties that mean nothing for such a robot."""
    others = dict(_MEANINGLESS)
    if kind is RobotKind.CAR:
        others["turn_rate"] = "`steering` limits how it turns"
    else:
        others |= dict.fromkeys(("wheelbase", "steering", "directions"), "cars have one")
    for key, why in others.items():
        item = block.get(key)
        if item is not None:
            problem = f"a {kind.value} has no `{key}`: {why}"
            raise Mistake(NotHere(span=item.span, problem=problem, hint=f"leave out `{key}`"))


def _speed(reader: _Reader, norms: Sequence[NormBound]) -> float:
    """V: the least of the speeds that the block gives [m/s]."""
    item = reader.block.get("speed")
    norms = [n for n in norms if item is not None and n.span == item.span]
    if not norms or item is None:
        raise reader.lacking("speed", "speed <= 1 m/s")
    if any(n.kind is PolygonKind.OUTER for n in norms):
        problem = "can't be `outer`: the robot can't follow what is faster"
        raise props.bad(item, problem, "speed <= 1 m/s polygon 16")
    speed = min(n.limit for n in norms)
    if speed <= 0.0:
        raise props.bad(item, "needs a limit above 0", "speed <= 1 m/s")
    return speed


def _check_period(robot: Robot, reader: _Reader) -> None:
    """The controller acts a whole number of times a step, and before it is at its goal."""
    item, step = reader.block.get("period"), reader.scope.step
    span = reader.name.span if item is None else item.span
    count = step / robot.period
    if not (1 <= round(count) <= _MOST_PERIODS and isclose(count, round(count), rel_tol=1e-9)):
        problem = f"a step of {step:g} s is not 1 to {_MOST_PERIODS} whole control periods"
        hint = f"for example `period {step / _PERIODS:g} s`"
        raise Mistake(NotTracked(span=span, name=reader.name.text, problem=problem, hint=hint))
    if robot.pace * robot.period > robot.lookahead:
        problem = (
            f"in a period of {robot.period:g} s it gets {robot.pace * robot.period:g} m ahead, "
            f"beyond its `lookahead` of {robot.lookahead:g} m"
        )
        times = ceil(robot.pace * step / robot.lookahead)
        hint = f"shorten the period, to `period {step / times:g} s` at most, or look further ahead"
        raise Mistake(NotTracked(span=span, name=reader.name.text, problem=problem, hint=hint))


def _directed(robot: Robot, reader: _Reader) -> Robot:
    """A car with as many directions as the block says, or so many that the steering allows changes
    to the next but two."""
    item = reader.block.get("directions")
    if item is None:
        count, span = ceil(6.0 * pi / robot.sharpest), reader.name.span
    else:
        count, span = reader.scope.whole(props.only(item, "directions 24")), item.span
    if item is not None and not 3 <= count <= _MOST_DIRECTIONS:
        raise props.bad(item, f"must be 3 to {_MOST_DIRECTIONS}", "directions 24")
    made = replace(robot, directions=count)
    if count > _MOST_DIRECTIONS or Steering.of(made) is None:
        raise Mistake(_too_few(made, reader.name, span))
    return made


def _too_few(robot: Robot, name: ast.Ident, span: Span) -> NotTracked:
    """Directions between which the steering allows no change."""
    least = int(4.0 * pi / (robot.sharpest - 1e-5)) + 1
    problem = f"its steering allows no change between {robot.directions} directions"
    hint = f"at least {least}, or look further ahead: that lets it turn from more directions"
    return NotTracked(span=span, name=name.text, problem=problem, hint=hint)
