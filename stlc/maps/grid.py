"""Occupancy grids of ROS: a YAML file beside a picture (PGM, PNG, ..).

A cell's darkness is its chance to be occupied (`negate` turns that round): at least
`occupied_thresh` is an obstacle, at most `free_thresh` is free, anything between is unknown. The
origin is the pose of the lower left corner.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stlc.errors import UsageError
from stlc.inputs import InputError, read_input
from stlc.maps.outlines import identifier, laid_out, obstacle, outward

if TYPE_CHECKING:
    from stlc.maps import MapOptions, MapText

MOST_CELLS = 100_000_000  # 10,000 x 10,000: 500 m at 5 cm


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """`occupied` and `unknown` (rows, columns), the lowest row first; a cell is `size` [m]."""

    occupied: NDArray[np.bool_]
    unknown: NDArray[np.bool_]
    size: float
    origin: tuple[float, float, float]  # x, y [m], yaw [rad] of the lower left corner


def read_grid(path: Path, options: MapOptions) -> MapText:
    """The obstacles of a grid. Raises UsageError for files that can't be read."""
    import shapely
    from shapely import affinity

    from stlc.maps import MapText

    grid = load_grid(path)
    solid = grid.occupied | grid.unknown if options.unknown else grid.occupied
    if not solid.any():
        raise UsageError(f"{path}: no cell of this map is an obstacle")
    far = grid.size if options.simplify is None else options.simplify
    x, y, yaw = grid.origin
    placed = affinity.translate(
        affinity.rotate(outward(_cells(solid, grid.size), far), yaw, (0.0, 0.0), use_radians=True),
        x, y,
    )  # fmt: skip
    text, corners = obstacle(options.name or identifier(path.stem), shapely.normalize(placed))
    rows, columns = solid.shape
    share = float(grid.unknown.mean())
    notes = [
        f"{columns} x {rows} cells of {grid.size:g} m, from ({x:g}, {y:g}) on: {corners} corners"
    ]
    if share:
        word = "obstacles" if options.unknown else "free"
        notes.append(f"{share:.0%} of the cells are unknown: they count as {word}")
    return MapText(laid_out(text), tuple(notes))


def _cells(solid: NDArray[np.bool_], size: float) -> Any:
    """The union of the cells, made of the runs of each row."""
    import shapely

    padded = np.pad(solid, ((0, 0), (1, 1))).astype(np.int8)
    change = np.diff(padded, axis=1)
    rows, begin = np.nonzero(change == 1)
    _, end = np.nonzero(change == -1)
    boxes = shapely.box(begin * size, rows * size, end * size, (rows + 1) * size)
    return shapely.union_all(boxes)


def load_grid(path: Path) -> Grid:
    """Reads the YAML file and its picture. Raises UsageError."""
    facts = _facts(path)
    darkness = 1.0 - _picture(path.parent / str(facts["image"])) / 255.0
    if facts.get("negate"):
        darkness = 1.0 - darkness
    if facts.get("mode", "trinary") not in ("trinary", "scale"):
        raise UsageError(f"{path}: maps of mode {facts['mode']!r} are not read")
    occupied = darkness > _number(path, facts, "occupied_thresh")
    free = darkness < _number(path, facts, "free_thresh")
    size = _number(path, facts, "resolution")
    if not size > 0.0:
        raise UsageError(f"{path}: a resolution is more than 0")
    return Grid(occupied[::-1], (~occupied & ~free)[::-1], size, _origin(path, facts))


def _facts(path: Path) -> dict[str, Any]:
    """What the YAML file says."""
    try:
        text = read_input(path).decode("utf-8")
    except (InputError, UnicodeDecodeError) as error:
        raise UsageError(f"cannot read `{path}`: {error}") from None
    try:
        import yaml
    except ImportError:
        raise UsageError("maps of ROS need a package: pip install 'stlc[maps]'") from None
    try:
        facts = yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise UsageError(f"cannot read `{path}`: {' '.join(str(error).split())}") from None
    missing = {"image", "resolution", "origin", "occupied_thresh", "free_thresh"} - set(
        facts if isinstance(facts, dict) else ()
    )
    if missing:
        raise UsageError(f"{path}: no map of ROS, it lacks {', '.join(sorted(missing))}")
    return dict(facts)


def _number(path: Path, facts: dict[str, Any], key: str) -> float:
    try:
        return float(facts[key])
    except (TypeError, ValueError):
        raise UsageError(f"{path}: {key} is no number but {facts[key]!r}") from None


def _origin(path: Path, facts: dict[str, Any]) -> tuple[float, float, float]:
    try:
        x, y, yaw = (float(v) for v in facts["origin"])
    except (TypeError, ValueError):
        raise UsageError(f"{path}: the origin is not x, y, yaw but {facts['origin']!r}") from None
    return x, y, yaw


def _picture(path: Path) -> NDArray[np.float64]:
    """Brightness (rows, columns), 0 to 255, the top row first."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(io.BytesIO(read_input(path))) as picture:
            if picture.width * picture.height > MOST_CELLS:
                raise UsageError(f"{path}: more than {MOST_CELLS:g} cells")
            return np.asarray(picture.convert("L"), dtype=np.float64)
    except InputError as error:
        raise UsageError(f"cannot read `{path}`: {error}") from None
    except (UnidentifiedImageError, OSError, SyntaxError) as error:
        raise UsageError(f"cannot read `{path}`: no picture ({error})") from None
