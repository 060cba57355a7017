"""Shapes of regions and obstacles; `+` joins them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from stlc.front.text import point, written

Span = tuple[Any, Any]


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A polygon, a union of some, or a moving one."""

    text: str

    def __add__(self, other: Shape) -> Shape:
        return Shape(f"{self.text} + {other.text}")

    def __repr__(self) -> str:
        return f"<Shape {self.text}>"


def _span(ends: Span) -> str:
    low, high = ends
    return f"[{written(low)}, {written(high)}]"


def box(x: Span, y: Span, z: Span | None = None) -> Shape:
    """`box((0, 2), (1, 3))` from x = 0 to 2 and y = 1 to 3 [m]; with z a prism."""
    high = f" x {_span(z)}" if z is not None else ""
    return Shape(f"box {_span(x)} x {_span(y)}{high}")


def polygon(corners: Any, holes: Sequence[Any] = (), z: Span | None = None) -> Shape:
    """Corners (K, 2) [m] in either order, with holes; any sequence or array, or a shapely polygon.

    With z a prism.
    """
    if hasattr(corners, "exterior"):
        rings = [ring.coords[:-1] for ring in (corners.exterior, *corners.interiors)]
        corners, holes = rings[0], rings[1:]
    text = f"polygon {_ring(corners)}" + "".join(f" hole {_ring(h)}" for h in holes)
    return Shape(f"{text} x {_span(z)}" if z is not None else text)


def _ring(corners: Any) -> str:
    return " ".join(point(tuple(corner)) for corner in corners)


def line(corners: Any) -> Shape:
    """Corners (K, 2) [m] of a line, for walls."""
    return Shape(f"line {_ring(corners)}")


def moving(frames: Mapping[Any, Shape], *, linear: bool = False) -> Shape:
    """Shapes at steps (or times such as "2 s"): it jumps from one to the next within a step, or
    moves all the time if `linear`."""
    parts = "; ".join(f"{written(at)}: {shape.text}" for at, shape in frames.items())
    return Shape(f"moving {{ {parts} }}{' linear' if linear else ''}")
