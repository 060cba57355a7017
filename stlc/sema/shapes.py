"""Shapes as written, as convex pieces."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.mission import Obstacle, Polytope, Region
from stlc.sema import geometry, jsonshapes
from stlc.sema.clock import steps
from stlc.sema.decompose import PolygonError, decompose
from stlc.sema.files import Files
from stlc.sema.geometry import Point
from stlc.sema.name_errors import NotHere, WrongKind
from stlc.sema.report import Mistake, Reported
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import BadPolygon, EmptyBox
from stlc.sema.units import METRE
from stlc.sema.values import Items, Place, Scalar, describe
from stlc.source import Span
from stlc.syntax import ast

Pieces = tuple[Polytope, ...]


@dataclass(frozen=True, slots=True)
class Shaper:
    """Turns shapes into pieces; declares regions and obstacles on demand."""

    scope: Scope
    files: Files

    def pieces(self, shape: ast.Shape) -> Pieces:
        """Convex pieces of a shape that doesn't move."""
        match shape:
            case ast.Box():
                return (self.box(shape),)
            case ast.PolygonShape():
                ring = [self.point(e) for e in shape.ring]
                holes = [[self.point(e) for e in hole] for hole in shape.holes]
                return polygon(ring, holes, shape.span)
            case ast.Union():
                return tuple(p for part in shape.parts for p in self.pieces(part))
            case ast.NamedShape():
                return self.named(shape.name)
            case ast.GeoJson():
                return self.geojson(shape)
        hint = "only an obstacle can move; give it the name `obstacle .. = moving {..}`"
        raise Mistake(NotHere(span=shape.span, problem="this shape can't move", hint=hint))

    def frames(self, shape: ast.Shape) -> tuple[Pieces, ...]:
        """Pieces at each step; the last stays for ever."""
        if not isinstance(shape, ast.Moving):
            return (self.pieces(shape),)
        known: dict[int, Pieces] = {}
        for time, part in shape.frames:
            known[steps(time, self.scope)] = self.pieces(part)
        if 0 not in known:
            hint = "say where it is at first: `moving { 0: box .. ; .. }`"
            raise Mistake(NotHere(span=shape.span, problem="nothing is said of step 0", hint=hint))
        frames = [known[0]]
        for step in range(1, max(known) + 1):
            frames.append(known.get(step, frames[-1]))
        return tuple(frames)

    def box(self, shape: ast.Box) -> Polytope:
        """An axis-aligned box."""
        x, y = (self._extent(e, axis) for e, axis in ((shape.x, "x"), (shape.y, "y")))
        return geometry.box(x, y)

    def _extent(self, ends: tuple[ast.Expr, ast.Expr], axis: str) -> Point:
        low, high = (self.scope.number(e, METRE) for e in ends)
        if low >= high:
            span = ends[0].span.to(ends[1].span)
            raise Mistake(EmptyBox(span=span, axis=axis, low=low, high=high))
        return low, high

    def point(self, expr: ast.Expr) -> Point:
        """A pair of constants [m]."""
        value = self.scope.value(expr)
        if not (isinstance(value, Items) and len(value.items) == 2):
            raise Mistake(
                WrongKind(span=expr.span, expected="a point `(x, y)`", found=describe(value))
            )
        x, y = (self._metres(v, expr.span) for v in value.items)
        return x, y

    def _metres(self, value: object, span: Span) -> float:
        if isinstance(value, Scalar) and value.is_constant and value.unit in (None, METRE):
            return value.constant
        raise Mistake(WrongKind(span=span, expected="coordinates in m", found="something else"))

    def named(self, name: ast.Ident) -> Pieces:
        """Pieces of another region or obstacle (at step 0, before inflation)."""
        value = self.scope.lookup(name.text, name.span)
        if isinstance(value, ast.RegionDecl | ast.ObstacleDecl):
            with self.scope.expanding(name.text, name.span):
                return self.pieces(value.shape)
        if isinstance(value, Place):
            shape = value.shape
            return shape.pieces if isinstance(shape, Region) else shape.bodies[0]
        found = "something else" if isinstance(value, ast.Statement) else describe(value)
        raise Mistake(WrongKind(span=name.span, expected="a region or an obstacle", found=found))

    def geojson(self, shape: ast.GeoJson) -> Pieces:
        """Polygons of a GeoJSON file, in a local frame in metres."""
        text = self.files.text(shape.path.value, shape.path.span)
        feature = shape.feature.value if shape.feature else None
        rings = jsonshapes.polygons(text, feature, shape.path)
        return tuple(p for ring, holes in rings for p in polygon(ring, holes, shape.span))

    def region(self, statement: ast.RegionDecl) -> None:
        """Declare a region."""
        name = statement.name.text
        try:
            region = Region(name, self.pieces(statement.shape), statement.name.span)
        except (Mistake, Reported):
            self.scope.broken.add(name)
            raise
        self.scope.regions[name] = region
        self.scope.values[name] = Place(region)

    def obstacle(self, statement: ast.ObstacleDecl) -> None:
        """Declare an obstacle; inflation grows each piece, so the union grows by as much."""
        name = statement.name.text
        try:
            bodies = self.frames(statement.shape)
            grow = self._inflation(statement)
        except (Mistake, Reported):
            self.scope.broken.add(name)
            raise
        frames = tuple(tuple(geometry.inflated(p, grow) for p in body) for body in bodies)
        obstacle = Obstacle(name, frames, bodies, grow, statement.name.span)
        self.scope.obstacles[name] = obstacle
        self.scope.values[name] = Place(obstacle)

    def _inflation(self, statement: ast.ObstacleDecl) -> float:
        if statement.inflate is None:
            return 0.0
        grow = self.scope.number(statement.inflate, METRE)
        if grow < 0:
            hint = "an obstacle grows by the size of the robot: `inflate 0.3 m`"
            raise Mistake(
                NotHere(span=statement.inflate.span, problem="`inflate` is negative", hint=hint)
            )
        return grow


def polygon(ring: list[Point], holes: list[list[Point]], span: Span) -> Pieces:
    """Convex pieces of a polygon with holes."""
    if len(ring) < 3 or any(len(hole) < 3 for hole in holes):
        raise Mistake(BadPolygon(span=span, problem="it needs three corners or more"))
    try:
        return tuple(decompose(ring, holes))
    except PolygonError as error:
        raise Mistake(BadPolygon(span=span, problem=str(error))) from None
