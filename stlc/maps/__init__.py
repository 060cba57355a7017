"""Maps of other programs as obstacles: occupancy grids of ROS, drawings in DXF.

What comes out is a text of the language that a mission imports. Obstacles are never smaller than
what they stand for: outlines are simplified on the outside.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from stlc.errors import UsageError

ENDINGS = (".yaml", ".yml", ".dxf")

__all__ = ["ENDINGS", "MapOptions", "MapText", "read_map"]


@dataclass(frozen=True, slots=True)
class MapOptions:
    """`simplify` [m]: how far outlines may be outside the truth, None for the format's own measure.

    `unknown`: cells of a grid that nobody has seen are obstacles. `wall` [m]: the thickness of
    lines in a drawing that enclose nothing. `unit` [m]: of a drawing that says none. `layers`: of
    a drawing, all if empty. `name`: of the obstacles, else that of the file.
    """

    simplify: float | None = None
    unknown: bool = True
    wall: float | None = None
    unit: float | None = None
    layers: tuple[str, ...] = ()
    name: str | None = None


@dataclass(frozen=True, slots=True)
class MapText:
    """Statements, and what their reader should know."""

    text: str
    notes: tuple[str, ...]


def read_map(path: str | os.PathLike[str], options: MapOptions | None = None) -> MapText:
    """The obstacles of a map. Raises UsageError for a file that can't be read or holds none."""
    from stlc.maps.dxf import read_dxf
    from stlc.maps.grid import read_grid

    kind = Path(path).suffix.lower()
    if kind not in ENDINGS:
        raise UsageError(f"{path}: maps end in one of {', '.join(ENDINGS)}")
    read = read_dxf if kind == ".dxf" else read_grid
    return read(Path(path), options or MapOptions())
