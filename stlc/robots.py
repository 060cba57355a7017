"""Unicycles and cars, planned by a point ahead of their axle that moves as a single integrator.

The models, with the axle's centre c = (x, y) and the heading theta, e = (cos, sin) of it:

    unicycle   c' = v e, theta' = omega                |v| <= V, |omega| <= W
    car        c' = v e, theta' = v tan(phi) / L       0 <= v <= V, |phi| <= Phi   (rear axle)

The point p = c + b e has p' = R(theta) (v, b omega), which is invertible for b > 0: input-output
linearisation (d'Andrea-Novel, Campion and Bastin, Control of nonholonomic wheeled mobile robots by
state feedback linearization, IJRR 14, 1995; De Luca, Oriolo and Samson, Feedback control of a
nonholonomic car-like robot, in Laumond (ed.), Robot Motion Planning and Control, 1998). The plan is
a run z of p that is straight between the steps, at most `Robot.planned_speed` fast.

The controller holds (v, omega) for a period d. Held, they move p by sinc(h/2) R(theta + h/2)
(v d, b h), h = omega d, and this can be solved: with (d1, d2) what p has to go from here to the
plan's place one period later, seen from the robot,

    h = 2 atan2(d2, 2 b + d1),     v = (cos(h/2) d1 + sin(h/2) d2) / (d sinc(h/2)).

So p is on its plan at the end of each period, and errors don't add up. What that takes:

    |(v, b omega)| = |(d1, d2)| / (d sinc(h/2)) <= (2 b / d) asin(|(d1, d2)| / (2 b)),

since |h| <= 2 asin(|(d1, d2)| / (2 b)). Therefore a plan of speed s = (2 b / d) sin(S d / (2 b))
needs no more than S = min(V, b W), or S = V of a car: both limits hold. Within a period |p''| =
|omega||p'| <= S^2 / b, so that p is within d^2 S^2 / (8 b) of the straight line (the error of
linear interpolation), and c, which is b from p, within `Robot.radius` of the plan, at all times.

A car's steering asks for |tan(alpha - h/2)| <= b tan(Phi) / L, where alpha is the plan's direction
seen from the robot, and |alpha| <= atan(b tan(Phi) / L) sees to that, since h has the sign of alpha
and 0 <= |h|/2 <= |alpha|. While the plan goes straight alpha falls, by a way r in one period to

    tan(alpha' / 2) = tan(alpha / 2) (2 b - r) / (2 b + r),    0 < r < 2 b,

which is at most exp(-r / b) of it: a tractrix, without overshoot. `Steering` makes directions
of that, which the plan keeps to.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from math import atan, atan2, cos, log, pi, sin, tan

from stlc.source import Span


class RobotKind(Enum):
    """What steers it."""

    UNICYCLE = "unicycle"
    CAR = "car"


@dataclass(frozen=True, slots=True)
class Robot:
    """A robot behind a plan of its look-ahead point.

    `heading` [rad] at the start, `speed` V [m/s], `turning`: W [rad/s] of a unicycle, the greatest
    curvature tan(Phi) / L [1/m] of a car; `lookahead` b [m], `period` d [s] of its controller;
    `directions` that a car's plan tells apart.
    """

    kind: RobotKind
    heading: float
    speed: float
    turning: float
    lookahead: float
    period: float
    directions: int = 0
    wheelbase: float = 0.0  # m, of a car
    span: Span | None = None

    @property
    def pace(self) -> float:
        """S: how fast the look-ahead point may get [m/s]."""
        if self.kind is RobotKind.CAR:
            return self.speed
        return min(self.speed, self.lookahead * self.turning)

    @property
    def planned_speed(self) -> float:
        """The greatest speed of a plan that the robot can follow [m/s]."""
        reach = 2.0 * self.lookahead / self.period
        return reach * sin(self.pace / reach)

    @property
    def stray(self) -> float:
        """How far the look-ahead point may be off the plan within a period [m]."""
        return (self.period * self.pace) ** 2 / (8.0 * self.lookahead)

    @property
    def radius(self) -> float:
        """How far the axle's centre may be off the plan at any time [m]: its tube."""
        return self.lookahead + self.stray

    @property
    def sharpest(self) -> float:
        """The greatest angle between the plan's direction and the heading [rad]."""
        return atan(self.lookahead * self.turning) if self.kind is RobotKind.CAR else pi


@dataclass(frozen=True, slots=True)
class Steering:
    """Directions of a car's plan: in each step one of `count`, evenly spread, within `spacing` / 2.

    The heading is within `hold` of the step's direction when the step ends. While the direction
    stays, so it does: it turns towards the plan's direction, which is nearer, standing still or
    not. A change to a neighbour begins with an angle of at most spacing + hold + spacing / 2, which
    is what the steering allows, and ends with at most hold - spacing / 2 after `run_up` metres:

        exp(-run_up / b) tan(sharpest / 2) = tan((hold - spacing / 2) / 2).
    """

    count: int
    spacing: float
    hold: float
    run_up: float

    @classmethod
    def of(cls, robot: Robot) -> Steering | None:
        """Those of a car; None where they are too few for what its steering allows."""
        spacing = 2.0 * pi / robot.directions
        widest = robot.sharpest - _SPARE
        last = widest - 2.0 * spacing  # hold - spacing / 2
        if last <= 0.0:
            return None
        run_up = robot.lookahead * log(tan(widest / 2.0) / tan(last / 2.0)) + _SPARE
        return cls(robot.directions, spacing, last + spacing / 2.0, run_up)

    def directions(self) -> list[float]:
        """The directions [rad], counter-clockwise from the x axis."""
        return [k * self.spacing for k in range(self.count)]

    def held(self, heading: float) -> list[bool]:
        """Which directions a heading is within `hold` of."""
        return [abs(turned(heading, angle)) <= self.hold for angle in self.directions()]


_SPARE = 1e-6
"""rad, m: what solvers' tolerances may take of a limit."""


def turned(to: float, start: float) -> float:
    """The angle from one direction to another, in (-pi, pi]."""
    return atan2(sin(to - start), cos(to - start))


def command(robot: Robot, ahead: float, aside: float) -> tuple[float, float]:
    """The controller: (v, omega) [m/s, rad/s] held for a period in which the look-ahead point goes
    (`ahead`, `aside`) [m], seen from the robot; less where its limits don't allow that."""
    b, d = robot.lookahead, robot.period
    if robot.kind is RobotKind.CAR:
        ahead, aside = _steerable(robot, ahead, aside)
    half = atan2(aside, 2.0 * b + ahead)
    v, omega = (cos(half) * ahead + sin(half) * aside) / (d * _sinc(half)), 2.0 * half / d
    most = abs(v) / robot.speed
    if robot.kind is RobotKind.UNICYCLE:
        most = max(most, abs(omega) / robot.turning)
    return (v, omega) if most <= 1.0 else (v / most, omega / most)


def _steerable(robot: Robot, ahead: float, aside: float) -> tuple[float, float]:
    """The nearest way that a car can steer to: none that is too far aside, and none backwards."""
    widest = robot.sharpest
    if abs(atan2(aside, ahead)) <= widest:
        return ahead, aside
    along = max(cos(widest) * ahead + sin(widest) * abs(aside), 0.0)
    return along * cos(widest), along * sin(widest) * (1.0 if aside > 0.0 else -1.0)


def _sinc(angle: float) -> float:
    return sin(angle) / angle if abs(angle) > 1e-9 else 1.0
