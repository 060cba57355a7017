"""Polygons from GeoJSON (RFC 7946), read as metres in a local frame."""

from __future__ import annotations

import json
import re
import sys
from typing import Any

from stlc.sema.geometry import Point
from stlc.sema.report import Mistake, nearest
from stlc.sema.shape_errors import BadGeoJson
from stlc.syntax import ast

Rings = tuple[list[Point], list[list[Point]]]


def polygons(text: str, feature: str | None, path: ast.String) -> list[Rings]:
    """Outer ring and holes of each polygon. Raises Mistake."""
    try:
        data = json.loads(text)
    except RecursionError:
        raise Mistake(_bad(path, "not GeoJSON: it is nested too deeply")) from None
    except ValueError as error:
        raise Mistake(_bad(path, f"not JSON: {error}")) from None
    found: list[Rings] = []
    for geometry in _geometries(data, feature, path):
        found.extend(_polygons(geometry, path))
    if not found:
        raise Mistake(_bad(path, "no Polygon or MultiPolygon in it"))
    _check_frame(data, found, path)
    return found


_DEGREES = re.compile(r"CRS:?84|EPSG:+(?:[\d.]*:)?(?:4326|4258|4269)\b|WGS ?84\b", re.IGNORECASE)
_TINY = 0.01  # a polygon below 1 cm is none of a mission; 0.01 degrees are 1 km


def _check_frame(data: dict[str, Any], found: list[Rings], path: ast.String) -> None:
    """Refuse longitude and latitude: what says so, and what would be tiny and far in metres."""
    crs = json.dumps(data.get("crs"))
    points = [p for outer, _ in found for p in outer]
    xs, ys = zip(*points, strict=True) if points else ((0.0,), (0.0,))
    spans = max(xs) - min(xs), max(ys) - min(ys)
    on_earth = max(map(abs, xs)) <= 180 and max(map(abs, ys)) <= 90
    far = min(max(map(abs, xs)), max(map(abs, ys))) > 100 * max(spans)
    if _DEGREES.search(crs):
        problem = "its `crs` is longitude and latitude in degrees"
    elif on_earth and far and 0 < max(spans) < _TINY:
        problem = f"only {spans[0]:.3g} x {spans[1]:.3g}: longitude and latitude, it seems"
    else:
        return
    raise Mistake(_bad(path, problem, "project it to metres in a local frame first"))


def _bad(path: ast.String, problem: str, hint: str | None = None) -> BadGeoJson:
    if hint is None:
        return BadGeoJson(span=path.span, path=path.value, problem=problem)
    return BadGeoJson(span=path.span, path=path.value, problem=problem, hint=hint)


def _geometries(data: Any, feature: str | None, path: ast.String) -> list[Any]:
    """Geometries of a GeoJSON object (RFC 7946), all of them or those of the named feature."""
    if not isinstance(data, dict):
        raise Mistake(_bad(path, "not a GeoJSON object"))
    features = data.get("features", [data] if data.get("type") == "Feature" else None)
    if features is None:
        return [data]
    if not isinstance(features, list) or not all(isinstance(f, dict) for f in features):
        raise Mistake(_bad(path, "its `features` are not a list of objects"))
    if feature is None:
        return [f.get("geometry") for f in features]
    chosen = [f.get("geometry") for f in features if feature in _names(f)]
    if not chosen:
        known = [n for f in features for n in _names(f)]
        near = nearest(feature, known)
        hint = f"did you mean `{near}`?" if near else f"it has {', '.join(known) or 'no names'}"
        raise Mistake(_bad(path, f"no feature `{feature}`", hint))
    return chosen


def _names(feature: dict[str, Any]) -> list[str]:
    properties = feature.get("properties")
    name = properties.get("name") if isinstance(properties, dict) else None
    return [str(n) for n in (name, feature.get("id")) if n is not None]


def _polygons(geometry: Any, path: ast.String) -> list[Rings]:
    """Rings of each polygon of a geometry; points and lines have none."""
    if not isinstance(geometry, dict):
        return []
    coordinates = geometry.get("coordinates")
    match geometry.get("type"):
        case "Polygon":
            return [_rings(coordinates, path)]
        case "MultiPolygon" if isinstance(coordinates, list):
            return [_rings(part, path) for part in coordinates]
        case "GeometryCollection" if isinstance(geometry.get("geometries"), list):
            return [r for g in geometry["geometries"] for r in _polygons(g, path)]
    return []


def _rings(coordinates: Any, path: ast.String) -> Rings:
    if not isinstance(coordinates, list) or not coordinates:
        raise Mistake(_bad(path, "a polygon without coordinates"))
    outer, *holes = (_ring(ring, path) for ring in coordinates)
    return outer, holes


def _ring(ring: Any, path: ast.String) -> list[Point]:
    if not isinstance(ring, list):
        raise Mistake(_bad(path, "a ring that is not a list of positions"))
    points = [_position(p, path) for p in ring]
    return points[:-1] if len(points) > 1 and points[0] == points[-1] else points


def _position(value: Any, path: ast.String) -> Point:
    if isinstance(value, list) and len(value) >= 2:
        x, y = value[0], value[1]
        if _is_number(x) and _is_number(y):
            return float(x), float(y)
    raise Mistake(_bad(path, f"a position that is not two numbers: {str(value)[:40]}"))


def _is_number(value: Any) -> bool:
    """A number that doubles hold: JSON here knows NaN, infinity and integers of any length."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max
