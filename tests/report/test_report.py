"""`stlc report`: the page's data, its structure, and its script at work."""

from __future__ import annotations

import re

import numpy as np
import pytest
from support.command import MISSION, inside
from support.page import Page

from stlc.api import loads
from stlc.errors import UsageError
from stlc.plan import Plan, make_plan
from stlc.report import report_page
from stlc.verify import verify
from stlc.verify.timeline import timelines

TEXT = """step 1 s
horizon 4
workspace box [0, 20] x [0, 8]
dynamics boat {
  A = [[1, 0], [0, 1]]
  B = [[1, 0], [0, 1]]
  states east north; inputs ve vn; state_units m m; input_units m/s m/s
  position east north
}
dynamics drone = double_integrator { dimensions 3; pz in [0, 30] }
agent r : boat { start (1, 1); control |u| <= 4 }
agent d : drone { start (1, 6, 5, 1, 0, 0) }
station base at (10, 0)
wall brick = line (12, 1) (14, 1) (14, 3) loss 6 dB
region pad = box [8, 10] x [0, 2]
region cloud = box [2, 4] x [5, 7] x [4, 6]
obstacle truck = moving { 0: box [4, 6] x [5, 7]; 4: box [8, 10] x [5, 7] } linear inflate 0.2 m
channel radio { path_loss L0 = -40 dBm, n = 2; partition 5 x 4 }
require reach: eventually[1, 4] r in pad
require hold: eventually[0, 2] always[0, 1] r.north >= 1 m
require clear margin 0.1: always r outside truck
require talk: always[1, 3] rssi(r, base) >= -70 dBm
"""


def mission_and_plan(text: str = TEXT, speed: float = 2.0) -> tuple[object, Plan]:
    mission = loads(text.replace("partition 5 x 4", "partition 5 x 4 x 1"), name="a/sea.stl")
    r = np.column_stack([1 + speed * np.arange(5.0), np.ones(5)])
    d = np.zeros((5, 6))
    d[:] = [1, 6, 5, 1, 0, 0]
    d[:, 0] += np.arange(5.0)
    inputs = {"r": np.tile([speed, 0.0], (4, 1)), "d": np.zeros((4, 3))}
    return mission, make_plan(mission, {"r": r, "d": d}, inputs)


@pytest.fixture(scope="module")
def good() -> Page:
    return Page(report_page(*mission_and_plan()))


def test_a_timeline_meets_the_robustness_where_it_is_decided():
    mission, plan = mission_and_plan()
    report = verify(mission, plan)
    curves = timelines(mission, plan)
    for found, curve in zip(report.requirements, curves, strict=True):
        assert curve.values[curve.step] == pytest.approx(found.robustness)
    assert [c.window for c in curves] == [(1, 4), (0, 3), (0, 4), (1, 3)]
    np.testing.assert_allclose(curves[0].values, [-7, -5, -3, -1, 1])


def test_a_curve_under_a_negation_has_the_sign_of_the_requirement():
    text = TEXT[: TEXT.index("require reach")] + "require low: not eventually r.north >= 3 m\n"
    mission, plan = mission_and_plan(text)
    np.testing.assert_allclose(timelines(mission, plan)[0].values, np.full(5, 2.0))


def test_requirements_stand_beside_their_lines(good):
    needs = {need["name"]: need for need in good.data["needs"]}
    assert list(needs) == ["reach", "hold", "clear", "talk"]
    assert all(need["ok"] for need in needs.values())
    assert (needs["reach"]["slack"], needs["reach"]["step"]) == ("1 m", 4)
    assert needs["hold"]["tight"]
    assert needs["hold"]["slack"] == "0 m"
    assert needs["clear"]["names"] == ["r", "truck"]
    assert needs["talk"]["names"] == ["base", "r"]
    lines = [a for tag, a in good.elements if tag == "li" and "data-needs" in a]
    assert [(a["data-needs"], a["class"]) for a in lines] == [(str(k), "good") for k in range(4)]
    assert good.data["needs"][0]["lines"] == [19, 19]


def test_a_violated_requirement_is_red_and_said_so():
    page = Page(report_page(*mission_and_plan(speed=1.0)))
    assert [need["ok"] for need in page.data["needs"]] == [False, True, True, True]
    moods = [a["class"] for tag, a in page.elements if tag == "li" and "data-needs" in a]
    assert moods == ["bad", "good", "good", "good"]
    assert ("p", {"class": "verdict bad"}) in page.elements
    page.run()


def test_the_scene_is_that_of_the_file(good):
    scene = good.data["scene"]
    truck = next(p for p in scene["places"] if p["name"] == "truck")
    corners = [min(x for x, _ in frame[0][0]) for frame in truck["frames"]]
    assert corners == [4, 5, 6, 7, 8]
    assert truck["inflate"] == 0.2
    pad = next(p for p in scene["places"] if p["name"] == "pad")
    assert len(pad["frames"]) == 1
    assert scene["walls"] == [{"name": "brick", "lines": [[[12, 1], [14, 1], [14, 3]]]}]
    boat, drone = scene["agents"]
    assert boat["path"][-1] == [9, 1, 0]
    assert drone["flies"]
    assert drone["path"][-1] == [5, 6, 5]
    low, high = scene["box"][:2], scene["box"][2:]
    assert low[0] < 0 < 20 < high[0]
    (link,) = scene["links"]
    assert link["ends"] == ["r", "base"]
    pairs = zip(link["quality"], link["value"], strict=True)
    assert all((q >= 0.5) == (v >= -70) for q, v in pairs)


def test_every_signal_has_its_own_name_and_unit(good):
    titles = [(c["what"], c["title"], c["unit"]) for c in good.data["charts"]]
    assert titles[0] == ("link", "Received strength", "dBm")
    assert ("state", "east", "m") in titles
    assert ("state", "pz", "m") in titles
    assert ("state", "vz", "m/s") in titles
    assert ("input", "vn", "m/s") in titles
    heights = next(c for c in good.data["charts"] if c["title"] == "pz")
    assert heights["bands"] == [{"name": "cloud", "kind": "region", "low": 4, "high": 6}]


def test_the_page_needs_nothing_else():
    html = report_page(*mission_and_plan())
    addresses = set(re.findall(r"https?://[^\"' )]*", html))
    assert addresses == {"http://www.w3.org/2000/svg"}  # a name, not a place
    assert not re.findall(r"<(?:script|img|link)[^>]*(?:src|href)=\"(?!data:)", html)


def test_text_of_a_mission_cannot_leave_its_place():
    text = TEXT + "# </script><script>alert(1)</script> <b>\n"
    page = Page(report_page(*mission_and_plan(text)))
    assert [tag for tag, _ in page.elements].count("script") == 2
    assert "b" not in [tag for tag, a in page.elements if not a and tag == "b"]
    page.run()


def test_the_script_moves_the_map(good):
    engine = good.run()
    mark = (
        'ids.map.querySelectorAll("g").filter((g) => "transform" in g.attributes)'
        '.map((g) => g.attributes.transform).join(";")'
    )
    before = engine.eval(mark)
    engine.eval("seek(2.5)")
    assert engine.eval(mark) != before
    assert engine.eval("ids.clock.textContent") == "2.50 s, step 2"
    assert engine.eval("place(DATA.scene.agents[0], 2.5)[0]") == 6
    inner = "frameAt(DATA.scene.places.find((p) => p.name === 'truck').frames, 2.5)[0][0][0][0]"
    assert engine.eval(inner) == engine.eval(inner.replace("2.5", "2")) + 0.5


def test_playing_goes_to_the_end_and_stops(good):
    engine = good.run()
    engine.eval("ids.play.fire('click')")
    engine.eval("for (let now = 0; frames.length && now < 1e6; now += 100) frames.shift()(now)")
    assert engine.eval("state.t") == 4
    assert not engine.eval("player.playing")
    engine.eval("document.fire('keydown', { key: 'ArrowLeft', target: body })")
    assert engine.eval("state.t") == 3


def test_text_map_and_cards_are_joined(good):
    engine = good.run()
    lit = 'body.querySelectorAll(".lit").map((n) => n.attributes["data-name"]).filter(Boolean)'
    engine.eval('document.querySelectorAll("li[data-needs]")[2].fire("mouseenter")')
    assert set(engine.eval(f"{lit}.join()").split(",")) == {"r", "truck"}
    cards = 'body.querySelectorAll("article").map((n) => n.classList.contains("lit")).join()'
    assert engine.eval(cards) == "false,false,true,false"
    engine.eval('document.querySelectorAll("li[data-needs]")[2].fire("mouseleave")')
    assert engine.eval(f"{lit}.length") == 0
    engine.eval('ids.map.querySelectorAll("[data-name]").find('
                '(n) => n.attributes["data-name"] === "base").fire("focus")')  # fmt: skip
    assert engine.eval(cards) == "false,false,false,true"


def test_agents_that_are_nowhere_have_charts_alone():
    mission = loads(
        "horizon 3\ndynamics k = single_integrator { dimensions 1 }\nagent c : k { start 2 }\n"
        "require low: eventually[0, 3] c.px <= 1 m\n"
    )
    plan = make_plan(mission, {"c": np.full((4, 1), 2.0)}, {"c": np.zeros((3, 1))})
    page = Page(report_page(mission, plan))
    assert page.data["scene"]["box"] is None
    assert [c["title"] for c in page.data["charts"]] == ["px", "ux"]
    page.run()


def test_the_ring_is_where_the_deciding_agent_is():
    text = TEXT[: TEXT.index("require reach")]
    text += "require both: always forall a in agents: a.y <= 7 m\n"
    page = Page(report_page(*mission_and_plan(text)))
    (need,) = page.data["needs"]
    assert (need["names"], need["about"]) == (["d", "r"], ["d"])
    engine = page.run()
    engine.eval('document.querySelectorAll("li[data-needs]")[0].fire("mouseenter")')
    assert engine.eval('map.ghosts.querySelectorAll("circle").length') == 1


def test_the_command_writes_a_page(tmp_path):
    (tmp_path / "m.stl").write_text(MISSION)
    assert inside("solve", "m.stl", "-o", "p.json", "--progress", "none", folder=tmp_path)
    done = inside("report", "m.stl", "p.json", "-o", "p.html", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    page = Page((tmp_path / "p.html").read_text(encoding="utf-8"))
    assert {need["name"] for need in page.data["needs"]} == {"visit", "clear"}
    done = inside("report", "m.stl", "p.json", "-o", "m.stl", folder=tmp_path)
    assert done.returncode == 2


def test_a_plan_of_another_mission_is_refused():
    _, plan = mission_and_plan()
    other, _ = mission_and_plan(TEXT.replace("horizon 4", "horizon 5"))
    with pytest.raises(UsageError, match="steps"):
        report_page(other, plan)
