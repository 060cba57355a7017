"""Pictures: right panels, true arcs, labels apart, clear errors."""

import dataclasses
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest
from support.command import MISSION
from support.missions import agent, avoid, box, mission, obstacle, reach, roll

from stlc.api import loads
from stlc.errors import OutputError, UsageError
from stlc.ir.nodes import Always, Eventually, Link, Quantity, Relation
from stlc.ir.requirement import Requirement
from stlc.mission import Bound, Channel, Station
from stlc.places import Region
from stlc.plan import make_plan
from stlc.plot import plan_figure, plot_plan
from stlc.radio.gp import ChannelModel
from stlc.radio.link_budget import LinkBudget, Modulation
from stlc.radio.partition import uniform_grid

T = 6


def build(count=2, channel=True, places=None):
    team = [agent(f"r{i + 1}", (1 + 0.7 * i, 1 + 0.8 * (i % 3), 1.0, 0.5)) for i in range(count)]
    goal = Region("goal", (box(8, 9, 8, 9),))
    pillar = obstacle("pillar", box(4, 6, 4, 6), box(3.7, 6.3, 3.7, 6.3))
    needs = [Requirement(f"reach{one.name}", reach(one.name, box(8, 9, 8, 9), T)) for one in team]
    needs += [
        Requirement(f"clear{one.name}", avoid(one.name, box(4, 6, 4, 6)), 0.1) for one in team
    ]
    radio = Channel(
        "radio", uniform_grid((0, 12), (0, 12), 4, 4), ChannelModel(-12.89, 3.0, 10.0, 10.0, 2.0),
        LinkBudget(-60.0, Modulation.OQPSK_802_15_4), predicate_bound=Bound.CENTRE,
    )  # fmt: skip
    if channel:
        for a, b in combinations(team, 2):
            talk = Link("radio", Quantity.RSSI, a.name, b.name, Relation.AT_LEAST, -40.0)
            needs.append(Requirement(f"talk{a.name}{b.name}", Always(talk, 0, None)))
        sure = Link("radio", Quantity.RSSI, "r1", "base", Relation.AT_LEAST, -36.0, 0.95)
        wrong = Link("radio", Quantity.BER, "r1", "base", Relation.AT_MOST, 1e-3)
        needs += [Requirement("sure", Eventually(sure, 0, None))]
        needs += [Requirement("ber", Always(wrong, 0, None))]
    there = mission(
        team, needs, horizon=T, regions=[goal], obstacles=[pillar], workspace=box(0, 12, 0, 12),
        channels=[radio] if channel else [],
        stations=[Station("base", np.array([5.0, 0.3]))] if channel else [],
    )  # fmt: skip
    runs = {one.name: roll(one, np.full((T, 2), 0.05)) for one in team}
    plan = make_plan(there, {k: v[0] for k, v in runs.items()}, {k: v[1] for k, v in runs.items()})
    return there, plan


def titles(figure):
    return [axes.get_title(loc="left") for axes in figure.axes if axes.get_title(loc="left")]


def panel(figure, title):
    return next(axes for axes in figure.axes if axes.get_title(loc="left") == title)


def test_panels_with_a_channel():
    figure = plan_figure(*build())
    assert sorted(titles(figure)) == sorted(
        [
            "Trajectories", "Velocity", "Input", "Received strength", "Bit error rate",
            "Channel seen from r2 at 6 s", "Robustness",
        ]
    )  # fmt: skip
    strength = panel(figure, "Received strength")
    flat = [line for line in strength.lines if len(set(line.get_ydata())) == 1]
    assert {line.get_ydata()[0] for line in flat} == {-40.0, -36.0}
    assert [t.get_text() for t in strength.get_legend().get_texts()] == [
        "r1 \N{EN DASH} r2", "r1 \N{EN DASH} base", "95 % level",
    ]  # fmt: skip


def test_panels_without_a_channel():
    figure = plan_figure(*build(channel=False))
    assert sorted(titles(figure)) == ["Input", "Robustness", "Trajectories", "Velocity"]


def test_the_motion_is_the_true_arc():
    there, plan = build(1, channel=False)
    axes = panel(plan_figure(there, plan), "Trajectories")
    arc = max((line.get_xydata() for line in axes.lines), key=len)
    x0, v0, a = plan.runs["r1"].states[0, :2], plan.runs["r1"].states[0, 2:], np.full(2, 0.05)
    np.testing.assert_allclose(arc[12], x0 + 0.5 * v0 + 0.125 * a)
    np.testing.assert_allclose(arc[-1], plan.runs["r1"].states[-1, :2])


@pytest.mark.parametrize("count", [2, 10])
def test_labels_on_the_map_do_not_overlap(count):
    axes = panel(plan_figure(*build(count, channel=count == 2)), "Trajectories")
    renderer = axes.figure.canvas.get_renderer()
    boxes = [text.get_window_extent(renderer) for text in axes.texts]
    assert len(boxes) == count + 2 + (count == 2)  # one more for the station
    assert not [pair for pair in combinations(boxes, 2) if pair[0].overlaps(pair[1])]


def test_agents_differ_in_colour_and_marker():
    figure = plan_figure(*build(10, channel=False))
    handles = figure.legends[0].legend_handles
    assert len({h.get_color() for h in handles}) == 10
    assert len({h.get_marker() for h in handles}) == 10


def test_files(tmp_path):
    there, plan = build(2, channel=False)
    plot_plan(there, plan, tmp_path / "plan.png")
    assert (tmp_path / "plan.png").read_bytes().startswith(b"\x89PNG")
    plot_plan(there, plan, tmp_path / "one.svg")
    plot_plan(there, plan, tmp_path / "two.svg")
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()
    words = " ".join(ElementTree.parse(tmp_path / "one.svg").getroot().itertext())
    assert all(word in words for word in ("Trajectories", "Velocity", "clearr1", "r2"))


def test_errors(tmp_path):
    there, plan = build(2, channel=False)
    with pytest.raises(UsageError, match="must end in one of"):
        plot_plan(there, plan, tmp_path / "plan.doc")
    with pytest.raises(OutputError, match="does not exist"):
        plot_plan(there, plan, tmp_path / "none" / "plan.png")
    with pytest.raises(UsageError, match="the mission has r1, r2, r3"):
        plot_plan(build(3, channel=False)[0], plan, tmp_path / "plan.png")
    assert not list(tmp_path.iterdir())


def signed_area(ring):
    x, y = ring.T
    return 0.5 * float(x[:-1] @ y[1:] - x[1:] @ y[:-1])


def test_a_region_of_several_pieces_is_drawn_as_one_outline_with_its_hole():
    there, plan = build(channel=False)
    sides = box(1, 2, 1, 4), box(3, 4, 1, 4), box(1, 4, 1, 2), box(1, 4, 3, 4)
    ring = dataclasses.replace(there, regions={"ring": Region("ring", sides)}, obstacles={})
    axes = panel(plan_figure(ring, plan), "Trajectories")
    _, patch = axes.patches  # the workspace first
    outer, hole = patch.get_path().to_polygons()
    assert (outer.min(), outer.max()) == (1, 4)
    assert (hole.min(), hole.max()) == (2, 3)
    assert signed_area(outer) * signed_area(hole) < 0


def test_a_label_keeps_off_the_markers():
    there, plan = build(channel=False)
    here = plan.runs["r1"].states[0][:2]
    around = Region("here", (box(here[0] - 0.1, here[0] + 0.1, here[1] - 0.1, here[1] + 0.1),))
    figure = plan_figure(dataclasses.replace(there, regions={"here": around}), plan)
    axes = panel(figure, "Trajectories")
    (label,) = [text for text in axes.texts if text.get_text() == "here"]
    assert not label.get_window_extent().contains(*axes.transData.transform(here))


def test_a_plan_of_other_agents_is_refused(tmp_path):
    ours = loads(MISSION)
    plan = make_plan(ours, {"a": np.zeros((5, 4))}, {"a": np.zeros((4, 2))})
    other = dataclasses.replace(plan, runs={"b": plan.runs["a"]})
    with pytest.raises(UsageError, match="the plan is for agents b; the mission has a"):
        plot_plan(ours, other, tmp_path / "p.png")


def test_heights_of_agents_that_fly_have_a_panel():
    text = """
horizon 3
workspace box [0, 10] x [0, 10]
dynamics drone = double_integrator { dimensions 3; pz in [0, 9]; control |u| <= 2 }
agent a : drone { start (1, 1, 2) }
agent g : single_integrator { start (5, 5); control |u| <= 1 }
station mast at (9, 9) { height 3 m }
region pad = box [0, 3] x [0, 3] x [4, 6]
channel radio { path_loss L0 = -40 dBm, n = 2; partition 2 x 2 x 2 }
require r: eventually a in pad
require s: eventually rssi(a, mast) >= -90 dBm
"""
    found = loads(text)
    inputs = {"a": np.array([[0, 0, 2.0]] * 3), "g": np.zeros((3, 2))}
    runs = {}
    for name, given in inputs.items():
        model, states = found.agents[name].dynamics, [found.agents[name].start]
        for u in given:
            states.append(model.A @ states[-1] + model.B @ u)
        runs[name] = np.array(states)
    figure = plan_figure(found, make_plan(found, runs, inputs))
    panel = next(axes for axes in figure.axes if axes.get_title(loc="left") == "Height")
    curve = panel.lines[0].get_xydata()
    assert curve[12] == pytest.approx((0.5, 2.25))  # half a step up, by the true parabola
    assert panel.lines[1].get_ydata() == pytest.approx([2, 3, 6, 11])
    assert [text.get_text() for text in panel.texts] == ["pad"]
