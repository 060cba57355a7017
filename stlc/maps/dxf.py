"""Drawings in DXF: what encloses an area is an obstacle, one for each layer; lines are walls."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stlc.errors import UsageError
from stlc.inputs import InputError, read_input
from stlc.maps.outlines import identifier, laid_out, obstacle, outward

if TYPE_CHECKING:
    from stlc.maps import MapOptions, MapText

_FINE = 1e-4  # m: nearer chords than that tell no robot anything
SIMPLIFY = 0.01  # m: of drawings, whose curves are exact


def read_dxf(path: Path, options: MapOptions) -> MapText:
    """The obstacles of a drawing. Raises UsageError for one that can't be read or has none."""
    import shapely

    from stlc.maps import MapText

    document = _document(path)
    unit = _unit(path, document, options)
    far = SIMPLIFY if options.simplify is None else options.simplify
    layers: dict[str, list[Any]] = {}
    ignored = 0
    chord = max(far, _FINE) / 2.0
    for layer, points, closed in _outlines(document, unit, chord):
        if options.layers and layer not in options.layers:
            continue
        shape = _shape(points, closed, options.wall)
        if shape is None:
            ignored += 1
        else:
            layers.setdefault(layer, []).append(shape)
    texts, notes = [], []
    for layer, shapes in layers.items():
        name = identifier(f"{options.name}_{layer}" if options.name else layer)
        text, corners = obstacle(
            name, shapely.normalize(outward(shapely.union_all(shapes), far, chord))
        )
        texts.append(text)
        notes.append(f"layer {layer}: {len(shapes)} outlines, {corners} corners")
    if not texts:
        raise UsageError(f"{path}: nothing in this drawing is an obstacle{_lines(ignored)}")
    if ignored:
        notes.append(_lines(ignored).lstrip("; "))
    return MapText(laid_out("".join(texts)), tuple(notes))


def _lines(count: int) -> str:
    return f"; {count} open lines have no thickness: give one by --wall" if count else ""


def _document(path: Path) -> Any:
    """The drawing, read with ezdxf."""
    import io

    try:
        content = io.BytesIO(read_input(path))
    except InputError as error:
        raise UsageError(f"cannot read `{path}`: {error}") from None
    try:
        from ezdxf import recover
        from ezdxf.lldxf.const import DXFError
    except ImportError:
        raise UsageError("DXF needs a package: pip install 'stlc[maps]'") from None
    try:
        document, audit = recover.read(content)
    except (OSError, DXFError) as error:
        raise UsageError(f"cannot read `{path}`: no DXF ({error})") from None
    if audit.has_errors:
        raise UsageError(f"{path}: the drawing is broken: {audit.errors[0].message}")
    return document


def _unit(path: Path, document: Any, options: MapOptions) -> float:
    """Metres of a unit of the drawing."""
    from ezdxf import units
    from ezdxf.enums import InsertUnits

    if options.unit is not None:
        return options.unit
    if document.units == 0:
        raise UsageError(f"{path}: the drawing says no unit: give one, such as --unit mm")
    return float(units.conversion_factor(InsertUnits(document.units), InsertUnits.Meters))


def _outlines(
    document: Any, unit: float, chord: float
) -> Iterator[tuple[str, list[tuple[float, float]], bool]]:
    """Layer, corners [m] and whether they close, of every curve of the model; blocks resolved.

    Curves are cut into chords no farther than `chord` [m] from them.
    """
    from ezdxf import disassemble, path

    for entity in disassemble.recursive_decompose(document.modelspace()):
        try:
            curve = path.make_path(entity)
        except TypeError:  # text, dimensions and the like
            continue
        for part in curve.sub_paths():
            points = [(float(p.x) * unit, float(p.y) * unit) for p in part.flattening(chord / unit)]
            if len(points) > 1:
                yield entity.dxf.layer, points, part.is_closed


def _shape(points: Iterable[tuple[float, float]], closed: bool, wall: float | None) -> Any:
    """An area, or a wall; None for a line without a thickness."""
    import shapely

    corners = list(points)
    if closed and len(corners) > 3:
        return shapely.make_valid(shapely.Polygon(corners))
    if wall is None:
        return None
    line = shapely.LineString(corners)
    return line.buffer(wall / 2.0, cap_style="square", join_style="mitre")
