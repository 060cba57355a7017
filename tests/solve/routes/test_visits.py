"""Bounds by visits: never above the optimum of the whole model, and near it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from support.route_missions import boxes, collecting, optimum

from stlc.api import load, loads
from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.errors import InfeasibleError
from stlc.milp.compile import Compiled, compile_mission
from stlc.record import changed
from stlc.solve import tuning
from stlc.solve.relaxation.bodies import body_of
from stlc.solve.routes.box_atoms import places_of
from stlc.solve.routes.finder import Routes
from stlc.solve.routes.motion_bounds import Bounds, only_effort, visits_of
from stlc.solve.routes.pace import Pace
from stlc.solve.routes.visit_bound import Climb
from stlc.solve.routes.visits import kinds_of
from stlc.solve.strategies import run_strategy

LONG = Path(__file__).parents[3] / "benchmarks" / "missions" / "long"
ROUNDS = """step 1 s
horizon 12
workspace box [0, 10] x [0, 10]
agent r : double_integrator { start (2, 5); control |u| <= 2; speed <= 3 }
region a = box [0, 3] x [0, 3]
region b = box [7, 10] x [0, 3]
region c = box [7, 10] x [7, 10]
obstacle mid = box [4, 6] x [4, 6]
require rounds: forall g in regions: always[0, 5] eventually[0, 7] r in g
require clear: always r outside mid swept
minimize effort
"""
EULER = """step 0.5 s
horizon 10
workspace box [0, 6] x [0, 6]
dynamics mass {
  A = [[1, 0, 0.5, 0], [0, 1, 0, 0.5], [0, 0, 1, 0], [0, 0, 0, 1]]
  B = [[0, 0], [0, 0], [0.5, 0], [0, 0.5]]
  states px py vx vy; inputs ux uy
}
agent r : mass { start (1, 1); control |u| <= 4; effort_input (1, 2); effort_state (0, 0, 0, 0.1) }
region a = box [3, 4] x [0, 1] + box [0, 1] x [4, 5]
region b = box [3.5, 5] x [0.5, 5]
require stay: eventually[0, 8] always[0, 2] r in a
require until: (not (r in b)) until r in a
require late: eventually[8, 10] r in b
minimize 2 * effort
"""
RADIO = collecting(
    10, "(18, 3)", "eventually[0, 5] always[0, 1] rssi(r, a) >= -60 dBm",
    "eventually[8, 10] rssi(r, b) >= -60 dBm",
)  # fmt: skip
MISSIONS = {"rounds": ROUNDS, "euler": EULER, "radio": RADIO}


def bound(one: Compiled, most: float) -> float:
    graph = visits_of(Routes.of(one, lambda: False), "r")
    assert graph is not None
    return Climb(graph).bound(most, lambda: False)


@pytest.mark.parametrize(("name", "share"), [("rounds", 0.8), ("euler", 0.0), ("radio", 0.6)])
def test_bounds_stay_below_the_optimum_and_come_near(name: str, share: float) -> None:
    one = compile_mission(loads(MISSIONS[name]))
    best = optimum(one)
    found = bound(one, 1.2 * best)
    assert share * best <= found <= best + 1e-6
    assert bound(one, 0.5 * share * best) == pytest.approx(0.5 * share * best)


def test_bound_without_where_agents_come_from_is_one_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """The smaller graph, where the larger one has too many legs."""
    one = compile_mission(loads(ROUNDS))
    large = visits_of(Routes.of(one, lambda: False), "r")
    assert large is not None
    monkeypatch.setattr("stlc.solve.routes.visits.MOST_LEGS", 200)
    small = visits_of(Routes.of(one, lambda: False), "r")
    assert small is not None
    assert len(small.ways.legs) < len(large.ways.legs)
    best = optimum(one)
    assert 0.4 * best <= Climb(small).bound(1.2 * best, lambda: False) <= best + 1e-6


def test_prices_rise_on_where_heat_was_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many ways of nearly the same cost: together and colder they rise on."""
    one = compile_mission(load(LONG / "frugal_door_puzzle_N1_T20.stl"))
    graph = visits_of(Routes.of(one, lambda: False), "robot")
    assert graph is not None
    best = 3.80833
    found = Climb(graph).bound(best, lambda: False)
    monkeypatch.setattr(tuning, "ROUTES", changed(tuning.ROUTES, coldest=tuning.ROUTES.heat))
    assert 1.05 * Climb(graph).bound(best, lambda: False) <= found <= best


def test_prices_better_a_bound() -> None:
    one = compile_mission(loads(ROUNDS))
    graph = visits_of(Routes.of(one, lambda: False), "r")
    assert graph is not None
    without = graph.least(np.zeros((len(graph.ways.stop), 2, 2)))
    assert Climb(graph).bound(optimum(one), lambda: False) > 3 * without


def test_model_with_the_visits_of_the_cheapest_way_has_a_plan() -> None:
    """One that is hardly dearer than the best."""
    one = compile_mission(loads(ROUNDS))
    bounds = Bounds.of(one, lambda: False)
    assert bounds is not None
    model = bounds.visiting(one, 1.0, lambda: False)
    assert model is not None
    found = get("highs").solve(model, SolveOptions())
    assert found.x is not None
    assert optimum(one) - 1e-6 <= one.model.objective(found.x) <= 1.2 * optimum(one)


def test_derivative_is_that_of_the_soft_least() -> None:
    graph = visits_of(Routes.of(compile_mission(loads(ROUNDS)), lambda: False), "r")
    assert graph is not None
    rng = np.random.default_rng(1)
    prices = rng.normal(scale=0.2, size=(len(graph.ways.stop), 2, 2))
    prices[graph.ways.stop[:, 2] == 0] = 0.0
    way = np.where(prices == 0, 0.0, rng.normal(size=prices.shape))
    value, slope = graph.soft(prices, 0.5)
    ahead, behind = (graph.soft(prices + h * way, 0.5)[0] for h in (1e-6, -1e-6))
    assert (ahead - behind) / 2e-6 == pytest.approx(float(np.vdot(slope, way)), rel=1e-3)
    assert value <= graph.least(prices)


SIZES = st.floats(0.4, 2.5)


@settings(max_examples=15, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(
    st.tuples(*[st.floats(0.2, 6.4)] * 6), st.tuples(*[SIZES] * 6),
    st.sampled_from(["eventually[1, 4] always[0, 1]", "always[0, 3] eventually[0, 3]"]),
)  # fmt: skip
def test_no_random_optimum_is_below_its_bound(
    corners: tuple[float, ...], sizes: tuple[float, ...], often: str
) -> None:
    a, b, c = boxes(corners, sizes)
    text = f"""step 1 s
horizon 6
workspace box [0, 9] x [0, 9]
agent r : double_integrator {{ start (4, 4); control |u| <= 3; speed <= 4; effort_input (1, 2) }}
region a = {a}
region b = {b}
region c = {c}
require see: {often} r in a
require visit: (r outside a) until (r in b or r in c)
require end: eventually[4, 6] (r in c and not (r in b))
minimize effort
"""
    try:
        one = compile_mission(loads(text))
    except InfeasibleError:
        return
    found = get("highs").solve(one.model, SolveOptions(gap=1e-6, time_limit=20.0))
    bounds = Bounds.of(one, lambda: False)
    assert bounds is not None
    if found.status is Status.OPTIMAL and bounds.visits:
        assert found.objective is not None
        assert not bounds.hopeless()
        assert bound(one, 1.3 * found.objective + 1.0) <= found.objective + 1e-5


def test_out_of_reach_is_hopeless() -> None:
    """Four far corners that no agent of this speed visits in the time."""
    text = ROUNDS.replace("eventually[0, 7]", "eventually[0, 5]").replace(
        "speed <= 3", "speed <= 2"
    )
    one = compile_mission(loads(text.replace("[0, 5] e", "[0, 7] e")))
    bounds = Bounds.of(one, lambda: False)
    assert bounds is not None
    assert bounds.hopeless()
    assert get("highs").solve(one.model, SolveOptions()).status is Status.INFEASIBLE


def test_bound_is_that_of_the_solve(monkeypatch: pytest.MonkeyPatch) -> None:
    """The rows and the bound leave the optimum where it is."""
    quick = changed(tuning.ROUTES, glance=0.0, better_seconds=0.0)
    monkeypatch.setattr(tuning, "ROUTES", quick)
    one = compile_mission(loads(ROUNDS))
    found = run_strategy("routes", one, get("highs"), SolveOptions(time_limit=100.0, gap=1e-5))
    assert found.status is Status.OPTIMAL
    assert found.objective == pytest.approx(optimum(one), abs=1e-3)


def test_speaks_of_effort_only() -> None:
    assert only_effort(compile_mission(loads(ROUNDS)))
    text = ROUNDS.replace("minimize effort", "maximize robustness")
    assert not only_effort(compile_mission(loads(text)))


def test_single_integrators_have_no_visits() -> None:
    one = compile_mission(loads(ROUNDS.replace("double", "single").replace("; speed <= 3", "")))
    assert visits_of(Routes.of(one, lambda: False), "r") is None


def test_a_region_is_one_place_whatever_faces_are_out_of_reach() -> None:
    """Early steps need no upper face, an `until` tells the faces one by one."""
    text = """step 1 s
horizon 8
workspace box [0, 10] x [0, 10]
agent r : double_integrator { start (5, 2); control |u| <= 0.5; speed <= 2 }
region key = box [1, 2] x [3, 4]
region door = box [8, 10] x [4, 6]
require unlock: r in key or (r outside door until[0, 7] next r in key)
minimize effort
"""
    one = compile_mission(loads(text))
    grids = Routes.of(one, lambda: False)
    body = body_of(one, one.mission.agents["r"], one.mission.objective)
    assert body is not None
    place, boxes = places_of(one, "r", grids.progress, grids.levels, body)
    np.testing.assert_allclose(boxes, [[[1, 2], [3, 4]]], atol=1e-5)
    assert set(place.values()) == {0}


def test_pace_is_that_of_axes_polygon_and_start() -> None:
    one = compile_mission(loads(ROUNDS))
    body = body_of(one, one.mission.agents["r"], one.mission.objective)
    assert body is not None
    boxes = np.array([[[8, 9], [8, 9]], [[2, 2.5], [5, 6]], [[2, 2], [5, 5]]], float)
    pace = Pace.of(body, boxes)
    assert pace.need[2][1] == 1  # there already
    assert pace.need[2][0] == 3  # 6.7 m at 3 m a step, whichever axis
    assert not pace.may(2, 0, 0, 2)
    assert pace.may(2, 0, 0, 3) == (pace.can_be[0][3])
    assert not pace.can_be[0][1]


def test_kinds_are_the_places_that_meet() -> None:
    boxes = [np.array(b, float) for b in ([[0, 2], [0, 2]], [[1, 3], [1, 3]], [[5, 6], [0, 9]])]
    found = kinds_of(boxes)
    assert found is not None
    members = dict(found)
    assert set(members) == {frozenset(s) for s in ([0], [1], [2], [0, 1])}
    np.testing.assert_array_equal(members[frozenset([0, 1])], [[1, 2], [1, 2]])
    assert kinds_of([boxes[0]] * 6) is None
