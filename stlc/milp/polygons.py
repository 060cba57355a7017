"""Regular polygons that stand for a disc, and what stands for a ball."""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats
from stlc.mission import NormBound, PolygonKind
from stlc.sphere import directions, shrink


def polygon_normals(sides: int) -> Floats:
    """Unit normals (sides, 2), (sin, cos) of 2 pi h / sides for h = 1..sides; exact zeros."""
    angles = 2 * np.pi * np.arange(1, sides + 1) / sides
    normals = np.column_stack([np.sin(angles), np.cos(angles)])
    normals[np.abs(normals) < 1e-14] = 0.0
    return normals


def norm_faces(bound: NormBound) -> tuple[Floats, float]:
    """Unit normals (k, d) and the offset of a norm bound's faces over its `indices`."""
    inscribed = bound.kind is PolygonKind.INSCRIBED
    if len(bound.indices) == 3:
        return directions(bound.sides), bound.limit * shrink(bound.sides)
    offset = bound.limit * (np.cos(np.pi / bound.sides) if inscribed else 1.0)
    return polygon_normals(bound.sides), float(offset)
