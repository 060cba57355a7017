"""What the picture of a plan shows of any dynamics, any duration, any shape of the world."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image

from stlc.api import loads
from stlc.errors import UsageError
from stlc.plan import make_plan
from stlc.plot import plan_figure, plot_plan

BOAT = """
horizon {horizon}
step {step}
workspace box [0, {wide}] x [0, 10]
dynamics boat {{
  A = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]
  B = [[1, 0], [0, 1], [-0.5, 0]]
  states e n fuel; inputs ve vn; state_units m m kg; input_units m/s m/s
  position e n
}}
agent b : boat {{ start (1, 1, 9) }}
obstacle log = moving {{ 0: box [5, 6] x [5, 6]; 2: box [7, 8] x [5, 6] }} linear
require go: eventually b.e >= 2.9999999 m
require off: always b outside log
"""


def boat(horizon=2, step="1 s", wide=10):
    there = loads(BOAT.format(horizon=horizon, step=step, wide=wide))
    inputs = np.tile([2.0 / horizon, 1e-14], (horizon, 1))
    t = np.arange(horizon + 1.0)[:, None] / horizon
    states = np.array([1, 1, 9]) + t * [2.0, horizon * 1e-14, -1.0]
    return there, make_plan(there, {"b": states}, {"b": inputs})


def titles(figure):
    return [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]


def panel(figure, title):
    return next(axes for axes in figure.axes if axes.get_title(loc="left") == title)


def keyed(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_states_of_custom_dynamics_have_their_own_names_and_units():
    figure = plan_figure(*boat())
    assert titles(figure).count("State") == 2
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert {"e, n [m]", "fuel [kg]", "input [m/s]"} <= set(labels)
    inputs = panel(figure, "Input")
    assert keyed(inputs) == ["ve", "vn"]
    assert inputs.patches[1].get_data().values.max() == 0.0  # not 1e-14


def test_velocity_in_space_has_three_components():
    there = loads(
        "horizon 1\ndynamics drone = double_integrator { dimensions 3; pz in [0, 9] }\n"
        "agent a : drone { start (1, 1, 2, 0, 0, 1) }\nrequire r: eventually a.z >= 0 m\n"
    )
    states = np.array([[1, 1, 2, 0, 0, 1.0], [1, 1, 3, 0, 0, 1]])
    figure = plan_figure(there, make_plan(there, {"a": states}, {"a": np.zeros((1, 3))}))
    velocity = panel(figure, "Velocity")
    assert keyed(velocity) == ["vx", "vy", "vz"]
    assert [list(line.get_ydata()) for line in velocity.lines] == [[0, 0], [0, 0], [1, 1]]


def test_no_panel_is_empty():
    text = "horizon 1\nagent a : single_integrator { start (1, 1) }\nrequire a.x >= 0 m\n"
    there = loads(text)
    plan = make_plan(there, {"a": np.ones((2, 2))}, {"a": np.zeros((1, 2))})
    assert sorted(titles(plan_figure(there, plan))) == ["Input", "Robustness", "Trajectories"]


@pytest.mark.parametrize(
    ("horizon", "step", "label", "last"),
    [(2, "1 s", "time [s]", 2), (4, "50 ms", "time [ms]", 200), (12, "1 min", "time [min]", 12),
     (6, "1 h", "time [h]", 6)],
)  # fmt: skip
def test_time_has_a_sensible_unit(horizon, step, label, last):
    figure = plan_figure(*boat(horizon, step))
    assert label in [axes.get_xlabel() for axes in figure.axes]
    assert panel(figure, "State").lines[0].get_xdata()[-1] == pytest.approx(last)


def test_robustness_within_the_tolerance_is_drawn_as_zero():
    bars = panel(plan_figure(*boat()), "Robustness")
    assert "0 m" in {text.get_text() for text in bars.texts}
    assert min(bar.get_width() for bar in bars.patches) == 0.0


@pytest.mark.parametrize(("wide", "whole"), [(15, False), (40, True)])
def test_a_wide_world_has_its_map_over_the_whole_width(wide, whole):
    figure = plan_figure(*boat(wide=wide))
    box = panel(figure, "Trajectories").get_window_extent()
    assert (box.width > 0.9 * figure.bbox.width) == whole


def test_dots_on_the_map_are_the_samples():
    there = loads(
        "horizon 3\ndynamics slow { A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, 0, -0.2, 0], "
        "[0, 0, 0, -0.3]]; B = [[0], [0], [1], [0]]; continuous\n"
        "states px py vx vy; inputs u }\n"
        "agent a : slow { start (0, 0, 3, 1) }\nrequire eventually a.px >= 1\n"
    )
    states = [there.agents["a"].start]
    for _ in range(3):
        states.append(there.agents["a"].dynamics.A @ states[-1])
    plan = make_plan(there, {"a": np.array(states)}, {"a": np.zeros((3, 1))})
    lines = panel(plan_figure(there, plan), "Trajectories").lines
    assert [len(line.get_xdata()) for line in lines if line.get_marker() == "."] == [4]


def test_a_gif_moves(tmp_path):
    there, plan = boat()
    for name in ("one.gif", "two.gif"):
        plot_plan(there, plan, tmp_path / name)
    assert (tmp_path / "one.gif").read_bytes() == (tmp_path / "two.gif").read_bytes()
    with Image.open(tmp_path / "one.gif") as picture:
        assert picture.n_frames > 50
        first = np.asarray(picture.convert("RGB")).astype(int)
        picture.seek(picture.n_frames - 1)
        last = np.asarray(picture.convert("RGB")).astype(int)
    changed = np.abs(first - last).max(axis=2) > 40
    assert 0.001 < changed.mean() < 0.2


def test_a_gif_of_nobody_on_the_map_is_refused(tmp_path):
    there = loads(
        "horizon 1\ndynamics k = single_integrator { dimensions 1 }\n"
        "agent c : k { start 2 }\nrequire c.px >= 0\n"
    )
    plan = make_plan(there, {"c": np.ones((2, 1))}, {"c": np.zeros((1, 1))})
    with pytest.raises(UsageError, match="no agent has a position"):
        plot_plan(there, plan, tmp_path / "p.gif")
    assert not list(tmp_path.iterdir())
