"""GeoJSON that is none, and GeoJSON in degrees: a located mistake, never a crash."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from stlc.api import loads
from stlc.errors import MissionError

MISSION = """workspace box [0, 10] x [0, 10]
agent a : double_integrator { start (1, 1); control |u| <= 1 }
obstacle o = geojson "o.json"
require clear: always[0, 3] a outside o
"""


def _problem(folder: Path, text: str) -> str:
    (folder / "o.json").write_text(text)
    with pytest.raises(MissionError) as error:
        loads(MISSION, folder=folder)
    (mistake,) = error.value.diagnostics
    assert (mistake.span.line, mistake.code) == (3, "E0411")
    return mistake.label_text


def _polygon(*points: tuple[object, object], **more: object) -> str:
    ring = [list(p) for p in (*points, points[0])]
    return json.dumps({"type": "Polygon", "coordinates": [ring], **more})


@pytest.mark.parametrize(
    "bad", ["NaN", "Infinity", "1" + "0" * 400, "true", '"1"', "null", "1e999"]
)
def test_what_is_no_coordinate(bad: str, tmp_path: Path) -> None:
    text = _polygon(("BAD", 0), (5, 1), (5, 5)).replace('"BAD"', bad)
    assert "a position that is not two numbers" in _problem(tmp_path, text)


def test_nesting_without_end(tmp_path: Path) -> None:
    deep = '{"type": "GeometryCollection", "geometries": [' * 50_000
    for text in ("[" * 100_000, deep):
        assert "nested too deeply" in _problem(tmp_path, text)


def test_longitude_and_latitude(tmp_path: Path) -> None:
    site = ((8.6821, 50.1109), (8.6829, 50.1109), (8.6829, 50.1114))
    assert "longitude and latitude, it seems" in _problem(tmp_path, _polygon(*site))
    named = {"type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}
    square = ((4, 4), (5, 4), (5, 5))
    assert "degrees" in _problem(tmp_path, _polygon(*square, crs=named))
    named["properties"] = {"name": "urn:ogc:def:crs:EPSG::32632"}  # metres
    (tmp_path / "o.json").write_text(_polygon(*square, crs=named))
    loads(MISSION, folder=tmp_path)
