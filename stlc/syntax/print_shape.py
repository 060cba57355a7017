"""Shapes as text."""

from __future__ import annotations

from stlc.syntax import ast
from stlc.syntax.print_expr import quoted, show, show_list


def show_shape(shape: ast.Shape) -> str:
    """The shape as text."""
    match shape:
        case ast.Box():
            return f"box [{show_list(shape.x)}] x [{show_list(shape.y)}]"
        case ast.PolygonShape():
            rings = [shape.ring, *shape.holes]
            return "polygon " + " hole ".join(" ".join(map(show, ring)) for ring in rings)
        case ast.Line():
            return "line " + " ".join(map(show, shape.points))
        case ast.GeoJson():
            feature = f" feature {quoted(shape.feature)}" if shape.feature else ""
            return f"geojson {quoted(shape.path)}{feature}"
        case ast.NamedShape():
            return shape.name.text
        case ast.Moving():
            frames = (f"{show(when)}: {show_shape(where)}" for when, where in shape.frames)
            end = " linear" if shape.linear else ""
            return f"moving {{ {'; '.join(frames)} }}{end}"
        case ast.Prism():
            base = shape.base
            flat = f"({show_shape(base)})" if isinstance(base, ast.Prism) else _part(base)
            return f"{flat} x [{show_list(shape.z)}]"
        case ast.Union():
            return " + ".join(_part(part) for part in shape.parts)
        case _:
            raise AssertionError(shape)


def _part(shape: ast.Shape) -> str:
    return f"({show_shape(shape)})" if isinstance(shape, ast.Union) else show_shape(shape)
