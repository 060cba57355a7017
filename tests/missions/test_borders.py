"""Tables at cell borders: small missions from text, in every encoding and by the link search."""

import pytest

from stlc.api import loads
from stlc.milp.compile import CompileOptions
from stlc.milp.tables import ENCODINGS
from stlc.solve.driver import solve_mission
from stlc.solve.outcome import SolveSettings

HEAD = """
horizon 1
workspace box [0, 4] x [0, 2]
agent r : single_integrator { start (1, 1); control |u| <= 1; integer }
station base at (0, 1)
"""
PREDICATES = (
    HEAD
    + """
channel c {
  path_loss L0 = -40 dBm, n = 3; fading 1 dB^2, shadowing 1 dB^2, length 2 m
  partition 2 x 1; bound centre
}
require a: eventually[1] (r.x >= 2 m and rssi(r, base) >= -45 dBm)
require b: eventually[1] rssi(r, base) <= -50 dBm
minimize effort
"""
)
COST = (
    HEAD
    + """
channel c {
  path_loss L0 = -40 dBm, n = 3; fading 1 dB^2, shadowing 1 dB^2, length 2 m
  partition 2 x 1; bound centre; noise_floor -90 dBm; cost neg_rssi; cost_bound centre
}
require a: eventually[1] (r.x >= 2 m and rssi(r, base) <= -50 dBm)
minimize link_cost(c, (r, base))
"""
)
EVERY = ["auto", *ENCODINGS]


def objective(text: str, encoding: str) -> float:
    settings = SolveSettings(compile=CompileOptions(link=encoding))
    found = solve_mission(loads(text), settings).plan.solve.objective
    assert found is not None
    return found


@pytest.mark.parametrize("encoding", EVERY)
def test_two_predicates_on_a_border_take_a_cell_each(encoding):
    assert objective(PREDICATES, encoding) == pytest.approx(1.0)


@pytest.mark.parametrize("encoding", EVERY)
def test_cost_and_predicate_on_a_border_take_a_cell_each(encoding):
    assert objective(COST, encoding) == pytest.approx(40.0)


def test_integers_a_tolerance_off_a_border_are_looked_for_again():
    """HiGHS takes x = 0 for 1e-6 or more; its point has no plan, x = 1 has one."""
    text = """
        horizon 1
        workspace box [1e-06, 4] x [0, 2]
        agent r : single_integrator { start (1, 0); control |u| <= 1; integer }
    """
    plan = solve_mission(loads(text)).plan
    assert plan.solve.status == "optimal"
    assert plan.runs["r"].states[1, 0] >= 1.0 - 1e-6
