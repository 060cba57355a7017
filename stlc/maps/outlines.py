"""Geometry as statements: polygons simplified on the outside, printed in the one style."""

from __future__ import annotations

import re
from typing import Any

from stlc.source import Source
from stlc.syntax.parse import parse
from stlc.syntax.printer import format_file


def outward(geometry: Any, far: float, short: float = 0.0) -> Any:
    """A simpler shape that holds `geometry`, edges at most 2 `far` [m] beyond it.

    It is grown by `far`, corners kept sharp, and corners that matter less than `far` go. `short`
    [m] is what chords of curves lack already; it is added.
    """
    if far + short <= 0.0:
        return geometry
    truth = geometry.buffer(short, join_style="mitre") if short else geometry
    grown = truth.buffer(far, join_style="mitre")
    for share in (1.0, 0.5, 0.25):  # now and then GEOS cuts corners farther than it is told to
        simpler = grown.simplify(share * far)
        if simpler.covers(truth):
            return simpler
    return grown


def identifier(text: str) -> str:
    """A name of the language near a text."""
    name = re.sub(r"\W+", "_", text).strip("_") or "map"
    return f"m_{name}" if name[0].isdigit() else name


def obstacle(name: str, geometry: Any) -> tuple[str, int]:
    """`obstacle name = polygon .. + ..`, and its number of corners; an empty text for nothing."""
    import shapely

    parts = [p for p in shapely.get_parts(geometry) if p.geom_type == "Polygon" and p.area > 0.0]
    if not parts:
        return "", 0
    shapes = [
        f"polygon {_ring(p.exterior)}" + "".join(f" hole {_ring(h)}" for h in p.interiors)
        for p in parts
    ]
    corners = sum(len(r.coords) - 1 for p in parts for r in (p.exterior, *p.interiors))
    return f"obstacle {name} = {' + '.join(shapes)}\n", corners


def _ring(ring: Any) -> str:
    """Corners to a tenth of a millimetre, each once."""
    points = [f"({x:.4f}, {y:.4f})" for x, y in ring.coords[:-1]]
    return " ".join(dict.fromkeys(re.sub(r"\.?0+(?=[,)])", "", p) for p in points))


def laid_out(text: str) -> str:
    """The statements in the one style."""
    result = parse(Source("map", text))
    assert not [d for d in result.diagnostics if d.severity.value == "error"], result.diagnostics
    return format_file(result.file)
