"""Directions all around in space: polyhedra that stand for Euclidean lengths in linear models."""

from __future__ import annotations

from math import cos, pi

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def directions(sides: int) -> Array:
    """Unit vectors (k, 3): `sides` around at each of ceil(sides / 2) + 1 elevations, one at a pole.

    For any v, shrink(sides) |v| <= max_k directions_k . v <= |v|: around, the largest of the faces
    is within cos(pi / sides) of the length in the plane; of that length and the height, faces that
    are pi / ceil(sides / 2) apart are within cos(pi / (2 ceil(sides / 2))).
    """
    rings = []
    for elevation in np.linspace(-pi / 2.0, pi / 2.0, -(-sides // 2) + 1):
        flat = float(np.cos(elevation))
        around = 2.0 * pi * np.arange(1 if flat < 1e-9 else sides) / sides
        ring = np.column_stack([flat * np.cos(around), flat * np.sin(around)])
        rings.append(np.column_stack([ring, np.full(len(ring), np.sin(elevation))]))
    found = np.vstack(rings)
    return np.where(np.abs(found) < 1e-15, 0.0, found)


def shrink(sides: int) -> float:
    """The least that the faces of `directions(sides)` make of a length of 1."""
    return cos(pi / sides) * cos(pi / (2 * -(-sides // 2)))
