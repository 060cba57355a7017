"""Missions built in code: each is the file that it prints."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import shapely

import stlc
from stlc import api
from stlc.errors import InfeasibleError, MissionError, UsageError


def small() -> stlc.Mission:
    m = stlc.Mission(step="1 s", horizon=4, workspace=stlc.box((0, 10), (0, 10)))
    m.agent("a", "single_integrator", start=(1, 1), control=2)
    m.region("dock", stlc.box((4, 5), (0, 2)))
    return m


def test_robots_are_built_like_any_agent():
    m = stlc.Mission(horizon=4, workspace=stlc.box((0, 10), (0, 10)))
    van = m.dynamics("van", "car", speed="1 m/s", wheelbase="0.3 m", steering="35 deg")
    m.agent("a", van, start=(2, 2), heading="90 deg", lookahead=0.4, directions=30)
    b = m.agent("b", "unicycle", start=(5, 5), speed=1, turn_rate=2, period="50 ms")
    m.require("go", stlc.eventually(b.x >= 6))
    robots = {name: a.robot for name, a in api.loads(m.text).agents.items()}
    assert robots["a"].lookahead == 0.4
    assert robots["a"].directions == 30
    assert robots["b"].turning == 2.0
    assert robots["b"].period == 0.05


def test_statements_are_those_of_the_language():
    m = stlc.Mission(step="500 ms", margin=0.1)
    drift = m.dynamics("drift", A=[[1, 0], [0, 1]], B=0.1 * np.eye(2), states=("px", "py"))
    a = m.agent("a", drift, "turn_rate on", start=(1, -1.5), control=2, speed="2 m/s", px=(0, 5))
    m.agent("n", "single_integrator", start=(3, 3), integer=True, mass="2 kg")
    base = m.station("base", (5, 0), height=3)
    m.obstacle("truck", stlc.box((0, 2), (6, 7)), velocity=(1, 0), inflate="20 cm")
    m.obstacle("door", stlc.moving({0: stlc.box((0, 1), (2, 3)), 8: stlc.box((8, 9), (2, 3))},
                                   linear=True))  # fmt: skip
    m.region("pad", stlc.box((0, 1), (0, 1), (0, 3)) + stlc.polygon([(2, 2), (3, 2), (2, 3)]))
    m.wall("brick", stlc.line([(0, 0), (3, 0)]), 6)
    radio = m.channel("radio", "fading 10 dB^2", path_loss=(-12.5, 3), partition=(4, 4))
    v = m.param("v", "3 m")
    m.prefer("near", stlc.always(stlc.distance(a, base) <= v), weight=2)
    m.require("talk", stlc.eventually(stlc.probability(stlc.rssi(a, base, radio) >= -50) >= 0.9))
    m.maximize(stlc.robustness("talk") - 0.1 * stlc.effort(a))
    assert (
        str(m)
        == """step 500 ms
margin 0.1
dynamics drift { A = [[1, 0], [0, 1]]; B = [[0.1, 0], [0, 0.1]]; states px py }
agent a : drift { turn_rate on; start (1, -1.5); control |u| <= 2; speed <= 2 m/s; px in [0, 5] }
agent n : single_integrator { start (3, 3); integer; mass 2 kg }
station base at (5, 0) { height 3 }
obstacle truck = box [0, 2] x [6, 7] velocity (1, 0) inflate 20 cm
obstacle door = moving { 0: box [0, 1] x [2, 3]; 8: box [8, 9] x [2, 3] } linear
region pad = box [0, 1] x [0, 1] x [0, 3] + polygon (2, 2) (3, 2) (2, 3)
wall brick = line (0, 0) (3, 0) loss 6 dB
channel radio { fading 10 dB^2; path_loss L0 = -12.5 dBm; n = 3; partition 4 x 4 }
param v = 3 m
prefer near weight 2: always distance(a, base) <= v
require talk: eventually P(rssi(a, base, radio) >= -50) >= 0.9
maximize robustness(talk) - 0.1 * effort(a)
"""
    )


@pytest.mark.parametrize(
    ("made", "text"),
    [
        (lambda x, y: (x >= 1) & (y <= 2), "x >= 1 and y <= 2"),
        (lambda x, y: ~((x >= 1) | (y <= 2)), "not (x >= 1 or y <= 2)"),
        (lambda x, y: (x >= 1) >> (y > 2), "x >= 1 implies y > 2"),
        (lambda x, y: x - (y - 3) >= 1, "x - (y - 3) >= 1"),
        (lambda x, y: 2 * (x + y) / 4 < 3, "2 * (x + y) / 4 < 3"),
        (lambda x, y: 3 - x >= -(y + 1), "3 - x >= -(y + 1)"),
        (lambda x, y: abs(x - y) <= "2 m", "abs(x - y) <= 2 m"),
        (lambda x, y: sum([x, y]) >= 1, "x + y >= 1"),
        (lambda x, y: (x >= 1).until(y >= 2, 1, 3), "x >= 1 until[1, 3] y >= 2"),
        (lambda x, y: (x >= 1).release(y >= 2, end="2 s"), "x >= 1 release[0, 2 s] y >= 2"),
        (lambda x, y: stlc.always((x >= 1) | (y >= 2), 2), "always[2, end] (x >= 1 or y >= 2)"),
        (lambda x, y: stlc.eventually(stlc.always(x >= 1), 0, 3), "eventually[0, 3] always x >= 1"),
        (lambda x, y: (x >= 1).iff(y >= 2), "x >= 1 iff y >= 2"),
        (lambda x, y: stlc.any_of([x >= 1, y >= 2]), "x >= 1 or y >= 2"),
        (lambda x, y: stlc.maximum(x, y, 2) >= 1, "max(x, y, 2) >= 1"),
        (lambda x, y: "x >= 2" & (y >= 1), "x >= 2 and y >= 1"),
    ],
)
def test_operators_print_and_read_back(made, text):
    m = stlc.Mission()
    m.require("r", made(stlc.quantity("x"), stlc.quantity("y")))
    assert str(m) == f"require r: {text}\n"


def test_a_formula_is_no_truth():
    x = stlc.quantity("x")
    with pytest.raises(TypeError, match=r"\(a <= x\) & \(x <= b\)"):
        stlc.always(0 <= x <= 10)
    with pytest.raises(ValueError, match="nothing to join"):
        stlc.all_of([])


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_numbers_that_no_file_can_hold(bad):
    with pytest.raises(ValueError, match="no number"):
        stlc.quantity("x") + bad
    with pytest.raises(TypeError, match="not dict"):
        stlc.quantity("x") + {}


def test_digits_are_kept():
    m = stlc.Mission()
    m.dynamics("d", A=[[0.1 + 0.2]], B=[[1e-7]])
    assert "0.30000000000000004" in str(m)
    assert "1e-07" in str(m)


def test_polygons_of_shapely_have_their_holes():
    ring = shapely.box(0, 0, 3, 3).difference(shapely.box(1, 1, 2, 2))
    m = stlc.Mission()
    m.region("r", stlc.polygon(ring))
    (region,) = api.loads(
        str(m) + "agent a : single_integrator { start (5, 5) }\nhorizon 2\nrequire a in r\n"
    ).regions.values()
    whole = shapely.union_all([shapely.Polygon(p.vertices) for p in region.pieces])
    assert whole.symmetric_difference(ring).area == pytest.approx(0)


def test_mistakes_name_lines_of_the_text():
    m = small()
    m.require("r", "eventually a in dick")
    assert repr(m) == "<Mission mission.stl: 1 mistake>"
    with pytest.raises(MissionError) as caught:
        m.check()
    (mistake,) = caught.value.diagnostics
    assert (mistake.code, mistake.span.line) == ("E0201", 6)


def test_a_text_that_cannot_be_parsed_is_shown_as_it_is():
    m = small()
    m.add("require r: (a.x >= 1")
    assert "(a.x >= 1\n" in str(m)
    assert "mistake" in repr(m)


def test_tables_are_arrays_and_written_beside_the_mission(tmp_path):
    table = np.arange(16.0).reshape(4, 4) + np.pi
    m = small()
    m.agent("b", "single_integrator", start=(2, 2), control=1)
    costs = m.channel("costs", partition=(2, 2), table=table)
    m.minimize(stlc.link_cost(costs, ("a", "b")))
    m.require("r", "eventually a in dock")
    np.testing.assert_array_equal(m.checked.channels["costs"].tables[None], table)
    m.write(tmp_path / "built.stl")
    read = stlc.load(tmp_path / "built.stl")
    np.testing.assert_array_equal(read.checked.channels["costs"].tables[None], table)
    read.channel("more", partition=(2, 2), table=table)
    with pytest.raises(UsageError, match="from files"):
        read.check()


def test_a_file_is_printed_as_it_stands_and_goes_on_in_code(tmp_path):
    text = "horizon   4   # odd spacing\nagent a : single_integrator { start (1, 1) }\n"
    (tmp_path / "m.stl").write_text(text + "require r: a.x >= v\nparam v = 1\n")
    m = stlc.load(tmp_path / "m.stl", params={"v": 0.5})
    assert str(m).startswith(text)
    assert m.checked.params == {"v": "0.5"}
    m.require("more", "a.y >= 0")
    assert [r.name for r in m.checked.requirements] == ["r", "more"]


def test_what_cannot_hold_is_an_error_and_explained():
    m = small()
    m.require("r", stlc.eventually("a in dock", 0, 1))
    with pytest.raises(InfeasibleError):
        m.solve(time_limit=20)
    assert "deadline" in m.explain(time_limit=20).cause.text


def test_importing_is_light():
    code = "import sys, stlc; print(*sorted({'numpy', 'stlc.front', 'click'} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_everything_offered_is_there():
    from stlc import front

    assert set(stlc.__all__) - {"__version__"} == set(front.__all__)
    for name in stlc.__all__:
        assert getattr(stlc, name) is not None
        assert name in dir(stlc)
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        stlc.nothing  # noqa: B018
