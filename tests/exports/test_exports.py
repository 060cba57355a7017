"""Plans as GeoJSON, MCAP and waypoints: what other programs read there is the plan."""

from __future__ import annotations

import builtins
import csv
import json

import numpy as np
import pytest
import shapely
from mcap.reader import make_reader
from rosbags.highlevel import AnyReader
from support.command import MISSION, inside

from stlc.api import loads
from stlc.errors import OutputError, UsageError
from stlc.exports import export
from stlc.exports.rosbag import PATH, POSE, TWIST
from stlc.exports.track import tracks
from stlc.plan import make_plan
from stlc.verify import verify

TEXT = """step 500 ms
horizon 4
workspace box [0, 20] x [0, 8]
agent r : double_integrator { start (1, 1) }
dynamics drone = double_integrator { dimensions 3; pz in [0, 30] }
agent d : drone { start (1, 6, 5, 1, 0, 0) }
station base at (10, 0) { height 2 }
region pad = box [8, 10] x [0, 2] + polygon (1, 1) (4, 1) (4, 4) (1, 4) hole (2, 2) (3, 2) (3, 3)
obstacle crate = box [14, 15] x [1, 2] x [0, 3] inflate 0.1
obstacle truck = moving { 0: box [4, 6] x [5, 7]; 4: box [8, 10] x [5, 7] } linear
channel radio { path_loss L0 = -40 dBm, n = 2; partition 5 x 4 x 1 }
require talk: always[1, 3] rssi(r, base) >= -90 dBm
require off: always (r outside truck and r outside crate)
require at: eventually r in pad
"""


@pytest.fixture(scope="module")
def both():
    there = loads(TEXT)
    inputs = {"r": np.tile([1.0, 0.0], (4, 1)), "d": np.zeros((4, 3))}
    runs = {}
    for name, given in inputs.items():
        model, states = there.agents[name].dynamics, [there.agents[name].start]
        for u in given:
            states.append(model.A @ states[-1] + model.B @ u)
        runs[name] = np.array(states)
    plan = make_plan(there, runs, inputs)
    return there, verify(there, plan).annotate(plan)


ROBOT = """step 1 s
horizon 2
agent r : unicycle { start (1, 1); heading 90 deg; speed <= 1; turn_rate <= 2; lookahead 0.5 }
agent s : single_integrator { start (5, 5) }
require a: always r.x <= 9
"""


def test_robots_are_where_they_drive_with_their_headings(tmp_path):
    there = loads(ROBOT)
    ways = {"r": np.array([[0.9, 0.0], [0.9, 0.0]]), "s": np.zeros((2, 2))}
    starts = {name: agent.start for name, agent in there.agents.items()}
    runs = {n: np.vstack([starts[n], starts[n] + np.cumsum(w, axis=0)]) for n, w in ways.items()}
    plan = make_plan(there, runs, ways)
    export(there, plan, tmp_path / "w.csv", 0.5)
    rows = list(csv.DictReader((tmp_path / "w.csv").open()))
    mine = [r for r in rows if r["agent"] == "r"]
    assert float(mine[0]["heading"]) == pytest.approx(np.pi / 2)
    assert (float(mine[0]["x"]), float(mine[0]["y"])) == pytest.approx((1.0, 1.0))
    falls = np.tan(np.pi / 4) * ((1 - 0.018) / (1 + 0.018)) ** 100  # of 100 periods of 18 mm
    last = float(mine[-1]["heading"])
    assert np.tan(last / 2) == pytest.approx(falls, rel=1e-6)
    end = runs["r"][-1] - 0.5 * np.array([np.cos(last), np.sin(last)])
    assert (float(mine[-1]["x"]), float(mine[-1]["y"])) == pytest.approx(tuple(end))
    assert {r["heading"] for r in rows if r["agent"] == "s"} == {""}
    export(there, plan, tmp_path / "w.geojson", None)
    feature = json.loads((tmp_path / "w.geojson").read_text())["features"][0]
    assert feature["properties"]["headings"][-1] == pytest.approx(last)


def test_waypoints_are_on_the_motion(both, tmp_path):
    export(*both, tmp_path / "w.csv", 0.3)
    rows = list(csv.DictReader((tmp_path / "w.csv").open()))
    assert list(rows[0]) == ["agent", "time", "x", "y", "z", "vx", "vy", "vz"]
    mine = [r for r in rows if r["agent"] == "r"]
    times = np.array([float(r["time"]) for r in mine])
    np.testing.assert_allclose(times, [0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.8, 2.0])
    np.testing.assert_allclose([float(r["x"]) for r in mine], 1 + times**2 / 2)
    np.testing.assert_allclose([float(r["vx"]) for r in mine], times, atol=1e-9)
    other = [r for r in rows if r["agent"] == "d"]
    np.testing.assert_allclose([float(r["z"]) for r in other], 5)
    np.testing.assert_allclose([float(r["vx"]) for r in other], 1)


def test_a_plane_has_no_heights(tmp_path):
    there = loads(MISSION)
    plan = make_plan(there, {"a": np.ones((5, 4))}, {"a": np.zeros((4, 2))})
    export(there, plan, tmp_path / "w.csv")
    assert (tmp_path / "w.csv").read_text().splitlines()[0] == "agent,time,x,y,vx,vy"


def test_geojson_has_everything_and_reads_back(both, tmp_path):
    export(*both, tmp_path / "p.geojson")
    features = json.loads((tmp_path / "p.geojson").read_text())["features"]
    kinds = {f["properties"]["name"]: f["properties"]["kind"] for f in features}
    assert kinds == {
        "r": "agent", "d": "agent", "workspace": "workspace", "pad": "region",
        "crate": "obstacle", "truck": "obstacle", "base": "station",
    }  # fmt: skip
    shapes = {f["properties"]["name"]: shapely.geometry.shape(f["geometry"]) for f in features}
    assert shapes["pad"].is_valid
    assert shapes["pad"].area == pytest.approx(4 + 9 - 0.5)
    assert shapes["r"].coords[-1][0] == pytest.approx(3)
    assert shapes["base"].z == 2
    outer = shapes["pad"].geoms[1].exterior
    assert outer.is_ccw
    again = loads(
        "agent a : single_integrator { start (30, 30) }\nhorizon 2\n"
        'region pad = geojson "p.geojson" feature "pad"\nrequire r: eventually a in pad\n',
        folder=tmp_path,
    )
    pieces = [shapely.Polygon(p.vertices) for p in again.regions["pad"].pieces]
    assert shapely.union_all(pieces).symmetric_difference(shapes["pad"]).area < 1e-9


def test_mcap_holds_poses_links_inputs_and_the_scene(both, tmp_path):
    export(*both, tmp_path / "p.mcap", 0.25)
    found: dict[str, list[tuple[float, dict]]] = {}
    with (tmp_path / "p.mcap").open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert channel.message_encoding == "json"
            assert schema.encoding == "jsonschema"
            found.setdefault(channel.topic, []).append(
                (message.log_time / 1e9, json.loads(message.data))
            )
    assert set(found) == {
        "/agents/r/pose", "/agents/d/pose", "/agents/r/input", "/agents/d/input",
        "/links/radio/r/base", "/scene",
    }  # fmt: skip
    time, pose = found["/agents/r/pose"][3]
    assert time == 0.75
    assert pose["timestamp"] == {"sec": 0, "nsec": 750_000_000}
    assert pose["pose"]["position"]["x"] == pytest.approx(1 + 0.75**2 / 2)
    assert pose["pose"]["orientation"]["w"] == pytest.approx(1)
    assert found["/agents/r/input"][0][1] == {"ux": 1.0, "uy": 0.0}
    assert found["/links/radio/r/base"][2][1]["rssi"] == pytest.approx(
        both[1].links[0].values["rssi"][2]
    )
    first, *later = found["/scene"]
    assert {e["id"] for e in first[1]["entities"]} == {"workspace", "pad", "crate", "truck"}
    assert [e["id"] for _, update in later for e in update["entities"]] == ["truck"] * 4
    corners = later[-1][1]["entities"][0]["lines"][0]["points"]
    assert min(p["x"] for p in corners) == 8


def test_a_bag_holds_paths_and_set_points(both, tmp_path):
    export(*both, tmp_path / "p.rosbag", 0.25)
    found: dict[str, list[tuple[float, object]]] = {}
    with AnyReader([tmp_path / "p.rosbag"]) as reader:
        for link, time, data in reader.messages():
            found.setdefault(link.topic, []).append(
                (time / 1e9, reader.deserialize(data, link.msgtype))
            )
        kinds = {link.topic: link.msgtype for link in reader.connections}
        (kept,) = reader.topics["/agents/r/path"].connections[0].ext.offered_qos_profiles
    assert kept.durability.name == "TRANSIENT_LOCAL"
    assert kinds == {
        f"/agents/{a}/{topic}": kind
        for a in "rd"
        for topic, kind in [("path", PATH), ("pose", POSE), ("velocity", TWIST)]
    }
    ((first, path),) = found["/agents/r/path"]
    assert (first, path.header.frame_id, len(path.poses)) == (0, "map", 9)
    assert [t for t, _ in found["/agents/r/pose"]] == pytest.approx(np.arange(9) / 4)
    for (time, pose), due in zip(found["/agents/r/pose"], path.poses, strict=True):
        assert due.header.stamp.sec + due.header.stamp.nanosec / 1e9 == pytest.approx(time)
        assert pose.pose.position.x == due.pose.position.x == pytest.approx(1 + time**2 / 2)
    assert [m.twist.linear.x for _, m in found["/agents/r/velocity"]] == pytest.approx(
        np.arange(9) / 4
    )
    assert found["/agents/d/pose"][-1][1].pose.position.z == pytest.approx(5)
    with pytest.raises(UsageError, match="is there already"):
        export(*both, tmp_path / "p.rosbag")
    with pytest.raises(OutputError, match="cannot write"):
        export(*both, tmp_path / "nowhere" / "p.rosbag")
    assert [p.name for p in tmp_path.iterdir()] == ["p.rosbag"]


def test_headings_go_with_the_motion_and_stay_at_rest(tmp_path):
    there = loads(MISSION)
    states = np.array([[1, 1, 0, 0], [1, 1, 0, 1], [1, 2, 0, 0], [1, 2, 0, 0], [1, 2, 0, 0]], float)
    plan = make_plan(there, {"a": states}, {"a": np.array([[0, 1], [0, -1], [0, 0], [0, 0.0]])})
    headings = tracks(there, plan, 0.5).headings("a", plan.step)
    np.testing.assert_allclose(headings, [0] + [np.pi / 2] * (len(headings) - 1))


def test_what_cannot_be_exported_is_said(both, tmp_path, monkeypatch):
    with pytest.raises(UsageError, match=r"\.geojson, \.mcap, \.rosbag, \.csv"):
        export(*both, tmp_path / "p.kml")
    with pytest.raises(UsageError, match="longer steps"):
        export(*both, tmp_path / "p.csv", 1e-9)
    there = loads(
        "horizon 1\ndynamics k = single_integrator { dimensions 1 }\n"
        "agent c : k { start 2 }\nrequire c.px >= 0\n"
    )
    plan = make_plan(there, {"c": np.ones((2, 1))}, {"c": np.zeros((1, 1))})
    with pytest.raises(UsageError, match="no agent has a position"):
        export(there, plan, tmp_path / "p.csv")
    real = builtins.__import__

    def without(name, *rest, **more):
        if name.startswith(("mcap", "rosbags")):
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(UsageError, match=r"pip install 'stlc\[mcap\]'"):
        export(*both, tmp_path / "p.mcap")
    with pytest.raises(UsageError, match=r"pip install 'stlc\[rosbag\]'"):
        export(*both, tmp_path / "p.rosbag")
    assert not list(tmp_path.iterdir())


def test_the_command(tmp_path):
    (tmp_path / "m.stl").write_text(MISSION)
    inside("solve", "m.stl", "-o", "p.json", "--progress", "none", folder=tmp_path)
    done = inside("export", "m.stl", "p.json", "-o", "w.csv", "--every", "100 ms", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert len((tmp_path / "w.csv").read_text().splitlines()) == 42
    wrong = inside("export", "m.stl", "p.json", "-o", "w.csv", "--every", "2 m", folder=tmp_path)
    assert wrong.returncode == 2
