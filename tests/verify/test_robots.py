"""Robots stay in their tubes, and true paths do what missions ask, by the nonlinear model."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from support.driving import along, driven

from stlc import api
from stlc.mission import Mission
from stlc.plan import Plan, make_plan
from stlc.robots import Robot, RobotKind, Steering, turned
from stlc.simulate import simulate
from stlc.verify import verify
from stlc.verify.robots import Drive, drive, robot_notes
from stlc.verify.tubes import radius


def _unicycle(rng: np.random.Generator, step: float) -> Robot:
    turning, b = rng.uniform(0.3, 4.0), rng.uniform(0.1, 1.0)
    speed = rng.uniform(0.2, 2.0)
    pace = min(speed, b * turning)
    periods = max(3, int(np.ceil(pace * step / b)), rng.integers(3, 20))
    heading = rng.uniform(-4.0, 4.0)
    return Robot(RobotKind.UNICYCLE, heading, speed, turning, b, step / periods)


def _anyhow(robot: Robot, rng: np.random.Generator, step: float, count: int) -> np.ndarray:
    """A plan in any directions, as fast as may be or slower, at rest now and then."""
    length = robot.planned_speed * step * rng.choice([0.0, 0.3, 1.0, 1.0], count)
    angle = rng.uniform(-np.pi, np.pi, count)
    moves = length[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([np.zeros(2), np.cumsum(moves, axis=0)])


def test_a_unicycle_stays_in_its_tube_whatever_its_plan_and_its_heading() -> None:
    rng = np.random.default_rng(0)
    nearest, widest = 0.0, 0.0
    for _ in range(25):
        step = rng.uniform(0.2, 2.0)
        robot = _unicycle(rng, step)
        plan = _anyhow(robot, rng, step, 6)
        found = driven(robot, plan, step)
        aims = along(plan, found.times)
        off = np.linalg.norm(found.centres - aims, axis=1)
        ahead = np.column_stack([np.cos(found.headings), np.sin(found.headings)])
        point = np.linalg.norm(found.centres + robot.lookahead * ahead - aims, axis=1)
        assert off.max() <= robot.radius + 1e-7
        assert point.max() <= robot.stray + 1e-7
        assert np.abs(found.speeds).max() <= robot.speed * (1.0 + 1e-9)
        assert np.abs(found.turns).max() <= robot.turning * (1.0 + 1e-9)
        assert radius(robot) == pytest.approx(robot.radius, abs=1e-12)
        nearest = max(nearest, float(off.max() / robot.radius))
        widest = max(widest, float(point.max() / robot.stray))
    assert nearest > 0.99  # no wider than it must be
    assert widest > 0.5


def _car(rng: np.random.Generator, step: float) -> Robot:
    wheelbase, steering = rng.uniform(0.2, 0.5), rng.uniform(0.4, 0.8)
    turning = np.tan(steering) / wheelbase
    b = rng.uniform(0.5, 1.5) / turning
    sharpest = np.arctan(b * turning)
    count = int(np.ceil(rng.uniform(4.2, 8.0) * np.pi / sharpest)) + 1
    heading, speed = rng.uniform(-4.0, 4.0), rng.uniform(0.5, 2.0)
    periods = max(3, int(np.ceil(speed * step / b)), rng.integers(3, 20))
    return Robot(
        RobotKind.CAR, heading, speed, turning, b, step / periods, count, wheelbase=wheelbase
    )


def _steered(robot: Robot, rng: np.random.Generator, step: float, count: int) -> np.ndarray:
    """A plan that keeps to directions, and changes them as soon and as sharply as it may."""
    steering = Steering.of(robot)
    assert steering is not None
    now = int(rng.choice(np.flatnonzero(steering.held(robot.heading))))
    moves = []
    for _ in range(count):
        change = int(rng.choice([-1, 0, 1, 1]))
        now = (now + change) % steering.count
        least = steering.run_up if change else 0.0
        most = max(robot.planned_speed * step, least)
        length = rng.choice([least, rng.uniform(least, most), most])
        aside = rng.choice([-0.5, 0.5, rng.uniform(-0.5, 0.5)])
        angle = (now + aside) * steering.spacing
        moves.append(length * np.array([np.cos(angle), np.sin(angle)]))
    return np.vstack([np.zeros(2), np.cumsum(moves, axis=0)])


def test_a_car_can_steer_along_every_plan_that_keeps_to_directions() -> None:
    rng = np.random.default_rng(1)
    sharpest = 0.0
    for _ in range(25):
        robot = _car(rng, 1.0)
        steering = Steering.of(robot)
        step = max(1.0, steering.run_up / robot.planned_speed)
        robot = Robot(
            robot.kind, robot.heading, robot.speed, robot.turning, robot.lookahead,
            step / np.ceil(step / robot.period), robot.directions, robot.wheelbase,
        )  # fmt: skip
        plan = _steered(robot, rng, step, 12)
        found = driven(robot, plan, step)
        off = np.linalg.norm(found.centres - along(plan, found.times), axis=1)
        limit = np.arctan(robot.turning * robot.wheelbase)
        assert off.max() <= robot.radius + 1e-7
        assert found.speeds.min() >= -1e-12
        assert found.speeds.max() <= robot.speed * (1.0 + 1e-9)
        assert np.abs(found.turns).max() <= limit + 1e-9
        sharpest = max(sharpest, float(np.abs(found.turns).max() / limit))
    assert sharpest > 0.7


def test_a_step_straight_ahead_is_a_tractrix() -> None:
    robot = Robot(RobotKind.UNICYCLE, 1.2, 1.0, 5.0, 0.4, 0.1)
    plan = np.array([[0.0, 0.0], [1.0, 0.0]])
    found = driven(robot, plan, 2.0)
    r = 0.05
    falls = ((2 * 0.4 - r) / (2 * 0.4 + r)) ** 20
    assert np.tan(found.headings[-1] / 2) == pytest.approx(np.tan(0.6) * falls, abs=1e-6)
    assert falls <= np.exp(-1.0 / 0.4)
    assert abs(turned(3.0, -3.0)) == pytest.approx(2 * np.pi - 6.0)


ROOM = """step 1 s
horizon {horizon}
workspace box [0, 8] x [0, 8] swept
agent r : {robot}
region dock = polygon ({x} {y}) ({x1} {y}) ({x1} {y1}) ({x} {y1})
obstacle rock = polygon (3, 3) (5, 3) (4, 5)
require go: eventually[0, {horizon}] r in dock
require clear: always r outside rock swept
"""
UNICYCLE = """unicycle {{
  start ({0:.3f}, {1:.3f}); heading {2:.1f} deg; speed <= 1.5 m/s
  turn_rate <= 3 rad/s; lookahead 0.3
}}"""
CAR = """car {{
  start ({0:.3f}, {1:.3f}); heading {2:.1f} deg; speed <= 1.5 m/s
  wheelbase 0.2 m; steering <= 40 deg
}}"""


def _mission(robot: str, rng: np.random.Generator, heading: float, horizon: int) -> Mission:
    x, y = rng.uniform(5.0, 6.2, 2)
    corners = {"x": f"{x:.2f},", "y": f"{y:.2f}", "x1": f"{x + 1.7:.2f},", "y1": f"{y + 1.7:.2f}"}
    start = (*rng.uniform(1.0, 2.0, 2), heading)
    return api.loads(ROOM.format(robot=robot.format(*start), horizon=horizon, **corners))


def _keeps(mission: Mission, plan: Plan) -> None:
    """The nonlinear model's own path does what the mission asks, at all times."""
    robot = mission.agents["r"].robot
    assert robot is not None
    found = driven(robot, plan.runs["r"].states, mission.step)
    path = shapely.LineString(found.centres)
    assert shapely.box(-1e-6, -1e-6, 8 + 1e-6, 8 + 1e-6).contains(path)
    rock = shapely.Polygon([(3, 3), (5, 3), (4, 5)])
    assert path.distance(rock) > 0.0
    at_steps = found.centres[np.isclose(found.times, np.round(found.times), atol=1e-9)]
    dock = shapely.Polygon(mission.regions["dock"].pieces[0].vertices).buffer(1e-6)
    assert any(dock.contains(shapely.Point(p)) for p in at_steps)
    mine = drive(robot, plan.runs["r"], mission.step)
    np.testing.assert_allclose(mine.at_steps(), at_steps, atol=1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_missions_of_unicycles_hold_for_the_nonlinear_model(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mission = _mission(UNICYCLE, rng, rng.uniform(-180, 180), 8)
    outcome = api.solve(mission)
    assert outcome.report.ok
    assert any("drives within 0.3" in note for note in outcome.report.notes)
    _keeps(mission, outcome.plan)
    found = simulate(mission, outcome.plan, draws=10)
    assert any("in its tube of 0.3" in note for note in found.notes)
    assert all(e.hold == 10 for e in found.requirements)


def test_a_mission_of_a_car_holds_for_the_nonlinear_model() -> None:
    mission = _mission(CAR, np.random.default_rng(3), 20.0, 7)
    outcome = api.solve(mission)
    assert outcome.report.ok
    _keeps(mission, outcome.plan)


def _by_hand(mission: Mission, moves: list[tuple[float, float]]) -> Plan:
    start = mission.agents["r"].start
    states = np.vstack([start, start + np.cumsum(moves, axis=0)])
    return make_plan(mission, {"r": states}, {"r": np.array(moves)})


OPEN = """step 1 s
horizon 3
agent r : {}
require on: always r.x <= 100
"""


def test_a_car_at_rest_steers_no_wheels() -> None:
    """Speeds of rounding errors need any steering."""
    mission = _mission(CAR, np.random.default_rng(3), 20.0, 7)
    still, moving, rate = 1e-14, 0.5, np.array([1e-9, 0.2])
    places = np.zeros((3, 2))
    found = Drive(1, places, np.zeros(3), np.array([still, moving]), rate, places)
    (note,) = robot_notes(mission, {"r": found})
    wheelbase = mission.agents["r"].robot.wheelbase  # type: ignore[union-attr]
    assert f"steering at most {np.degrees(np.arctan2(wheelbase * 0.2, moving)):.3g} deg" in note


def test_what_a_car_cannot_steer_is_refused() -> None:
    text = OPEN.format("car { start (0, 0); speed <= 1; wheelbase 0.3; steering <= 30 deg }")
    mission = api.loads(text)
    straight = verify(mission, _by_hand(mission, [(0.9, 0.0), (0.0, 0.0), (0.9, 0.05)]))
    assert straight.ok
    for moves in ([(0.9, 0.0), (-0.9, 0.0), (-0.9, 0.0)], [(-0.9, 0.0)] * 3):
        report = verify(mission, _by_hand(mission, moves))
        assert [v.kind for v in report.violations] == ["tracking"]
        assert "outside its tube" in str(report.violations[0])


def test_a_unicycle_follows_any_direction_but_no_faster_plan() -> None:
    mission = api.loads(OPEN.format("unicycle { start (0, 0); speed <= 1; turn_rate <= 2 }"))
    robot = mission.agents["r"].robot
    assert robot is not None
    assert robot.lookahead == pytest.approx(0.5)
    assert verify(mission, _by_hand(mission, [(0.99, 0.0), (-0.99, 0.0), (0.0, 0.99)])).ok
    kinds = {v.kind for v in verify(mission, _by_hand(mission, [(1.2, 0.0)] * 3)).violations}
    assert kinds == {"norm", "tracking"}


def test_predicates_leave_room_for_the_disc() -> None:
    text = OPEN.format("unicycle { start (0, 0); speed <= 1; turn_rate <= 2; lookahead 0.2 }")
    mission = api.loads(text + "require slant: always 3 * r.x + 4 * r.y <= 60\n")
    plan = _by_hand(mission, [(0.0, 0.0)] * 3)
    values = {r.name: r.robustness for r in verify(mission, plan).requirements}
    r = radius(mission.agents["r"].robot)
    assert values["on"] == pytest.approx(100 - 0.2 - r, abs=1e-9)
    assert values["slant"] == pytest.approx(60 - 3 * 0.2 - 5 * r, abs=1e-9)
    slow = "(its `lookahead` times `turn_rate` allows 0.4 of 1)"
    assert any(slow in note for note in verify(mission, plan).notes)


TALK = """step 1 s
horizon 4
workspace box [0, 10] x [0, 10]
agent r : unicycle {{ start (2, 5); speed <= 1; turn_rate <= 2; lookahead 0.4 }}
agent s : unicycle {{ start (8, 5); speed <= 1; turn_rate <= 4; lookahead 0.3; heading 180 deg }}
station base at (9, 9)
channel radio {{ path_loss L0 = -40 dBm, n = 2; partition 5 x 5 }}
require talk: eventually[0, 4] {}
minimize effort
"""


@pytest.mark.parametrize("ends", ["r, base", "base, r", "r, s"])
def test_links_hold_wherever_in_its_tube_a_robot_is(ends: str) -> None:
    mission = api.loads(TALK.format(f"rssi({ends}) >= -58 dBm"))
    outcome = api.solve(mission)
    assert outcome.report.ok
    (told,) = outcome.report.requirements
    assert told.true is not None
    assert told.robustness is not None
    rng = np.random.default_rng(0)
    least = -np.inf
    for t in range(5):
        places = {"base": np.tile([9.0, 9.0], (500, 1))}
        for name, agent in mission.agents.items():
            angle, reach = rng.uniform(0, 2 * np.pi, 500), radius(agent.robot)
            around = reach * np.column_stack([np.cos(angle), np.sin(angle)])
            places[name] = outcome.plan.runs[name].states[t] + around
        a, b = (places[name.strip()] for name in ends.split(","))
        level = -40 - 20 * np.log10(np.linalg.norm(a - b, axis=1))
        least = max(least, float((level + 58).min()))
    assert least >= told.robustness - 1e-6
