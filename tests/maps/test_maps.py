"""Maps as obstacles: what comes out holds what was occupied, and little more."""

from __future__ import annotations

import math
import sys

import ezdxf
import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from shapely import affinity
from support.command import inside

from stlc.api import loads
from stlc.errors import UsageError
from stlc.maps import MapOptions, read_map
from stlc.maps.outlines import identifier, outward

OUTSIDE = "agent a : single_integrator {{ start (-90, -90) }}\nhorizon 2\n{}"


def obstacles(text):
    needs = "".join(
        f"require always a outside {line.split()[1]}\n"
        for line in text.splitlines() if line.startswith("obstacle")
    )  # fmt: skip
    found = loads(OUTSIDE.format(text + needs)).obstacles
    return {
        name: shapely.union_all([
            shapely.Polygon(o.ring, o.holes) for _, shape in one.track.frames for o in shape
        ])
        for name, one in found.items()
    }  # fmt: skip


def write_map(folder, pixels, **facts):
    """A map whose top row of pixels is the first."""
    Image.fromarray(np.array(pixels, dtype=np.uint8)).save(folder / "hall.pgm")
    given = {"image": "hall.pgm", "resolution": 0.5, "origin": [-1.0, 2.0, 0.0], "negate": 0,
             "occupied_thresh": 0.65, "free_thresh": 0.196} | facts  # fmt: skip
    (folder / "hall.yaml").write_text("".join(f"{k}: {v}\n" for k, v in given.items()))
    return folder / "hall.yaml"


FREE, SOLID, UNKNOWN = 254, 0, 205  # what map_server writes: free, occupied, unknown


def test_cells_are_where_the_map_says(tmp_path):
    path = write_map(tmp_path, [[FREE, SOLID, FREE], [FREE, FREE, FREE], [SOLID, FREE, FREE]])
    shape = obstacles(read_map(path, MapOptions(simplify=0.0)).text)["hall"]
    expected = shapely.union_all([
        shapely.box(-1, 2, -0.5, 2.5),  # the lowest row is the last of the picture
        shapely.box(-0.5, 3, 0, 3.5),
    ])  # fmt: skip
    assert shape.symmetric_difference(expected).area < 1e-9


def test_a_turned_origin_turns_the_map(tmp_path):
    path = write_map(tmp_path, [[FREE, FREE], [FREE, SOLID]], origin=[1.0, 0.0, math.pi / 2])
    shape = obstacles(read_map(path, MapOptions(simplify=0.0)).text)["hall"]
    assert shape.symmetric_difference(shapely.box(0.5, 0.5, 1.0, 1.0)).area < 1e-3


def test_unknown_cells_are_obstacles_unless_told(tmp_path):
    path = write_map(tmp_path, [[FREE, UNKNOWN], [FREE, SOLID]])
    found = read_map(path, MapOptions(simplify=0.0))
    assert obstacles(found.text)["hall"].area == pytest.approx(0.5)
    assert "25% of the cells are unknown: they count as obstacles" in found.notes
    free = read_map(path, MapOptions(simplify=0.0, unknown=False))
    assert obstacles(free.text)["hall"].area == pytest.approx(0.25)


def test_negate_turns_dark_and_light_round(tmp_path):
    path = write_map(tmp_path, [[255 - FREE, 255 - SOLID]], negate=1)
    assert obstacles(read_map(path, MapOptions(simplify=0.0)).text)["hall"].area == 0.25


def test_a_ring_keeps_its_room(tmp_path):
    pixels = np.full((9, 9), FREE)
    pixels[[0, -1], :] = pixels[:, [0, -1]] = SOLID
    shape = obstacles(read_map(write_map(tmp_path, pixels)).text)["hall"]
    assert len(shape.interiors) == 1
    assert not shape.contains(shapely.Point(-1 + 2.25, 2 + 2.25))


@given(st.integers(0, 2**32 - 1), st.floats(0.05, 0.8))
def test_simpler_outlines_hold_the_truth(seed, far):
    rng = np.random.default_rng(seed)
    cells = np.argwhere(rng.random((8, 8)) < 0.4)
    truth = shapely.union_all([shapely.box(x, y, x + 1, y + 1) for x, y in cells])
    simpler = outward(truth, far)
    assert truth.difference(simpler).area < 1e-9
    assert simpler.difference(truth.buffer(2 * far + 1e-9, join_style="mitre")).area < 1e-9
    count = shapely.count_coordinates
    assert count(simpler) <= count(truth.buffer(far, join_style="mitre"))


@pytest.mark.parametrize(
    ("facts", "said"),
    [
        ({"image": "none.pgm"}, "there is no such file"),
        ({"image": "hall.yaml"}, "no picture"),
        ({"resolution": "fine"}, "resolution is no number"),
        ({"resolution": 0}, "more than 0"),
        ({"origin": "[1, 2]"}, "x, y, yaw"),
        ({"mode": "raw"}, "mode 'raw'"),
        ({"origin": "[1, 2"}, "cannot read"),
    ],
)
def test_broken_grids_are_told(facts, said, tmp_path):
    path = write_map(tmp_path, [[SOLID]], **facts)
    with pytest.raises(UsageError, match=said.replace("(", r"\(")):
        read_map(path)


def test_empty_maps_and_other_files_are_told(tmp_path):
    with pytest.raises(UsageError, match="no cell"):
        read_map(write_map(tmp_path, [[FREE]]))
    (tmp_path / "a.yaml").write_text("just: this\n")
    with pytest.raises(UsageError, match="it lacks free_thresh, image"):
        read_map(tmp_path / "a.yaml")
    with pytest.raises(UsageError, match=r"\.yaml, \.yml, \.dxf"):
        read_map(tmp_path / "a.svg")


@pytest.fixture
def drawing(tmp_path):
    document = ezdxf.new(units=ezdxf.units.MM)
    model = document.modelspace()
    model.add_lwpolyline([(0, 0), (4000, 0), (4000, 1000), (0, 1000)], close=True,
                         dxfattribs={"layer": "Walls"})  # fmt: skip
    model.add_circle((6000, 3000), 500, dxfattribs={"layer": "2 columns"})
    model.add_line((0, 5000), (3000, 5000), dxfattribs={"layer": "glass"})
    model.add_text("hall", dxfattribs={"layer": "words"})
    block = document.blocks.new("TABLE")
    block.add_lwpolyline([(0, 0), (1000, 0), (1000, 1000), (0, 1000)], close=True)
    model.add_blockref("TABLE", (8000, 0), dxfattribs={"layer": "Walls", "rotation": 90})
    path = tmp_path / "hall.dxf"
    document.saveas(path)
    return path


def test_a_drawing_is_an_obstacle_for_each_layer(drawing):
    found = read_map(drawing)
    shapes = obstacles(found.text)
    assert {"Walls", "m_2_columns"} <= set(shapes)
    truth = shapely.Point(6, 3).buffer(0.5, quad_segs=256)
    assert truth.difference(shapes["m_2_columns"]).area < 1e-9
    assert shapes["m_2_columns"].difference(truth.buffer(0.05)).area < 1e-9
    table = affinity.translate(shapely.box(-1, 0, 0, 1), 8, 0)
    every = shapely.union_all(list(shapes.values()))
    for part in (shapely.box(0, 0, 4, 1), table):
        assert part.difference(every).area < 1e-9
    assert any("1 open lines have no thickness" in note for note in found.notes)


def test_lines_become_walls_and_layers_are_chosen(drawing):
    found = read_map(drawing, MapOptions(simplify=0.001, wall=0.2, layers=("glass",)))
    (shape,) = obstacles(found.text).values()
    assert shape.contains(shapely.box(0, 4.9, 3, 5.1))
    assert shape.area == pytest.approx(3.2 * 0.2, abs=0.05)


def test_a_drawing_without_a_unit_asks_for_one(tmp_path):
    document = ezdxf.new(units=0)
    document.modelspace().add_circle((0, 0), 2)
    document.saveas(tmp_path / "a.dxf")
    with pytest.raises(UsageError, match="--unit mm"):
        read_map(tmp_path / "a.dxf")
    (shape,) = obstacles(read_map(tmp_path / "a.dxf", MapOptions(unit=0.5)).text).values()
    assert shape.area == pytest.approx(math.pi, abs=0.15)


def test_what_is_no_drawing_is_told(tmp_path):
    (tmp_path / "a.dxf").write_text("hello\n")
    with pytest.raises(UsageError, match="cannot read"):
        read_map(tmp_path / "a.dxf")
    document = ezdxf.new(units=ezdxf.units.M)
    document.modelspace().add_line((0, 0), (1, 1))
    document.saveas(tmp_path / "b.dxf")
    with pytest.raises(UsageError, match="give one by --wall"):
        read_map(tmp_path / "b.dxf")


def test_names_are_those_of_the_language():
    assert [identifier(t) for t in ("hall", "2nd floor", "a-b.c", "--")] == [
        "hall", "m_2nd_floor", "a_b_c", "map",
    ]  # fmt: skip


@pytest.mark.parametrize("name", ["none.yaml", "none.dxf"])
def test_what_is_not_there_is_told_before_what_is_not_installed(name, tmp_path, monkeypatch):
    for package in ("yaml", "ezdxf"):
        monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(UsageError, match="there is no such file"):
        read_map(tmp_path / name)
    (tmp_path / name).touch()
    with pytest.raises(UsageError, match="need"):
        read_map(tmp_path / name)


def test_the_command(tmp_path):
    write_map(tmp_path, [[FREE, SOLID], [FREE, UNKNOWN]])
    done = inside("map", "hall.yaml", "-o", "hall.stl", "--unknown", "free", folder=tmp_path)
    assert done.returncode == 0
    assert "2 x 2 cells of 0.5 m" in done.stderr
    text = 'import "hall.stl"\nagent a : single_integrator { start (5, 5); control |u| <= 1 }\n'
    (tmp_path / "m.stl").write_text(text + "require r: always[0, 3] a outside hall\n")
    assert inside("check", "m.stl", folder=tmp_path).returncode == 0
    shown = inside("map", "hall.yaml", folder=tmp_path)
    assert shown.stdout.startswith("obstacle hall = polygon ")
    assert inside("map", "none.yaml", folder=tmp_path).returncode == 2
