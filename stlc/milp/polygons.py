"""Regular polygons that stand for a disc."""

from __future__ import annotations

import numpy as np

from stlc.arrays import Floats


def polygon_normals(sides: int) -> Floats:
    """Unit normals (sides, 2), (sin, cos) of 2 pi h / sides for h = 1..sides; exact zeros."""
    angles = 2 * np.pi * np.arange(1, sides + 1) / sides
    normals = np.column_stack([np.sin(angles), np.cos(angles)])
    normals[np.abs(normals) < 1e-14] = 0.0
    return normals
