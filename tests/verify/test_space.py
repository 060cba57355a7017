"""Agents that fly: distances, separations and links are those in space."""

import math
from pathlib import Path

import numpy as np
import pytest

from stlc.api import check, load, loads
from stlc.errors import InfeasibleError, MissionError
from stlc.milp.compile import CompileOptions
from stlc.plan import make_plan
from stlc.simulate import simulate
from stlc.solve.driver import solve_mission
from stlc.solve.outcome import SolveSettings
from stlc.verify import verify

CASES = Path(__file__).parents[1] / "cases"

HEAD = """
horizon 4
workspace box [0, 20] x [0, 20]
dynamics drone = single_integrator {{ dimensions 3; pz in [0, 30]; control |u| <= 6 }}
agent a : drone {{ start (2, 10, 12) }}
agent g : single_integrator {{ start (10, 2); control |u| <= 3 }}
station mast at (10, 10) {{ height 4 m }}
channel radio {{ path_loss L0 = -40 dBm, n = 3; noise_floor -100 dBm; {} }}
{}
"""


def mission(requirement, channel="partition 5 x 5 x 3"):
    return loads(HEAD.format(channel, requirement))


def at_rest(found):
    runs = {n: np.tile(a.start, (found.horizon + 1, 1)) for n, a in found.agents.items()}
    inputs = {n: np.zeros((found.horizon, a.dynamics.B.shape[1])) for n, a in found.agents.items()}
    return make_plan(found, runs, inputs)


def rssi(place, other=(10, 10, 4)):
    return -40 - 30 * math.log10(max(math.dist(place, other), 1))


@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("distance(a, mast) >= 1", math.dist((2, 10, 12), (10, 10, 4)) - 1),
        ("distance(a, g) <= 20", 20 - math.dist((2, 10, 12), (10, 2, 0))),
        ("distance(a, (2, 10, 0)) >= 1", 11),
        ("distance(g, (10, 2, 5)) >= 1", 4),
        ("separation(a, g) >= 1", 11),
        ("separation(a, g) >= (9 m, 9 m, 11 m)", 1),
        ("norm(a.x, a.y, a.z) >= 1 m", math.hypot(2, 10, 12) - 1),
        ("norminf(a.position) >= 1 m", 11),
        ("mast.z >= 3 m", 1),
    ],
)
def test_values_are_those_in_space(formula, value):
    found = mission(f"require r: always {formula}")
    report = verify(found, at_rest(found)).requirements[0]
    assert report.robustness == pytest.approx(value, abs=1e-9)


def test_distances_in_the_plane_leave_heights_of_stations_out():
    found = mission("require r: always distance(g, mast) >= 1")
    assert verify(found, at_rest(found)).requirements[0].robustness == pytest.approx(7)


def test_a_link_knows_the_true_distance():
    found = mission("require r: always rssi(a, mast) >= -80 dBm\nrequire s: rssi(a, g) >= -90 dBm")
    report = verify(found, at_rest(found))
    assert report.requirements[0].true == pytest.approx(rssi((2, 10, 12)) + 80)
    assert report.requirements[1].true == pytest.approx(rssi((2, 10, 12), (10, 2, 0)) + 90)
    assert report.requirements[0].robustness <= report.requirements[0].true
    estimate = simulate(found, at_rest(found), draws=20).requirements[0]
    assert estimate.robustness == pytest.approx(rssi((2, 10, 12)) + 80)


def test_a_drone_far_up_has_no_link_from_the_ground():
    with pytest.raises(InfeasibleError):
        solve_mission(load(CASES / "altitude.stl"))


@pytest.mark.parametrize("bound", ["worst", "mean", "centre"])
def test_tables_bound_every_place_of_their_cells(bound):
    found = mission("require r: rssi(a, g) >= -70 dBm", f"partition 3 x 2 x 4; bound {bound}")
    from stlc.channels import ChannelTables

    table = ChannelTables(found).thresholds(found.requirements[0].formula)
    cells, rng = found.channels["radio"].partition, np.random.default_rng(0)
    assert cells.shape == (3, 2, 4)
    for _ in range(300):
        i, j = rng.integers(len(cells), size=2)
        one, other = (rng.uniform(cells.low[k], cells.high[k]) for k in (i, j))
        value = rssi(one, (*other[:2], 0.0)) + 70  # whoever drives is on the ground in any layer
        if bound == "worst":
            assert table.low[i, j] - 1e-9 <= value <= table.high[i, j] + 1e-9
    middle = rssi(cells.centres[5], (*cells.centres[20][:2], 0.0)) + 70
    assert table.low[5, 20] == pytest.approx(middle, abs=0.0 if bound == "centre" else 9.0)


DESCENT = HEAD.format(
    "partition 2 x 2 x 3",
    "require r: eventually[2, 4] rssi(a, mast) >= -77 dBm\n"
    "minimize effort(a) + 1e3 * link_cost(radio, (a, g))",
)


@pytest.fixture(scope="module")
def optimum():
    """By the paper's encoding, which shares no columns with the others."""
    outcome = solve_mission(loads(DESCENT), SolveSettings(compile=CompileOptions(link="literal")))
    return outcome.plan.solve.objective


@pytest.mark.parametrize("encoding", ["unary", "hull", "lifted", "logarithmic", "literal-tight"])
def test_encodings_agree_in_space(encoding, optimum):
    settings = SolveSettings(compile=CompileOptions(link=encoding))
    outcome = solve_mission(loads(DESCENT), settings)
    assert outcome.plan.solve.objective == pytest.approx(optimum, rel=2e-4)
    assert verify(loads(DESCENT), outcome.plan).ok


@pytest.mark.parametrize(
    ("change", "code", "where"),
    [
        (("pz in [0, 30]; ", ""), "E0417", "a"),
        (("2 x 2 x 3", "quadtree 2 x 2"), "E0208", "partition"),
        (("mast) >=", "(1, 1)) >="), "E0418", "(1, 1)"),
    ],
)
def test_what_is_flat_is_refused(change, code, where):
    text = HEAD.format("partition 2 x 2 x 3", "require r: distance(a, mast) >= 1")
    with pytest.raises(MissionError) as caught:
        loads(text.replace(*change))
    (found,) = caught.value.diagnostics
    assert found.code == code
    assert found.span.text.startswith(where)


def test_a_mission_in_the_plane_has_cells_of_the_plane():
    text = HEAD.format("partition 5 x 5", "require r: rssi(g, mast) >= -99 dBm")
    flat = "\n".join(x for x in text.splitlines() if "drone" not in x)
    found = loads(flat)
    assert found.channels["radio"].partition.boxes.shape == (25, 4)
    assert not check(found)
