"""Shapes as written, as convex pieces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

from stlc.places import Obstacle, Outline, Polytope, Region, Track
from stlc.sema import geometry, jsonshapes, quotas, seams, tracks
from stlc.sema.clock import steps
from stlc.sema.decompose import PolygonError, decompose
from stlc.sema.files import Files
from stlc.sema.geometry import Point
from stlc.sema.name_errors import NotHere, Redeclared, TooLarge, WrongKind
from stlc.sema.report import Mistake, Reported, with_note
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import BadPolygon, EmptyBox, FarAway
from stlc.sema.space_errors import NotInSpace
from stlc.sema.units import METRE, SPEED, Unit
from stlc.sema.values import Items, Place, Scalar, describe
from stlc.source import Span
from stlc.syntax import ast

Pieces = tuple[Polytope, ...]
Outlines = tuple[Outline, ...]

FURTHEST = 1e8
"""Largest coordinate [m]: doubles are 1.5e-8 m apart there. At 9e8 m, 1e-7 m apart, shapes that are
closed by a hair, a micrometre, come out wrong."""


@dataclass(frozen=True, slots=True)
class Shaper:
    """Turns shapes into pieces; declares regions and obstacles on demand."""

    scope: Scope
    files: Files

    def outlines(self, shape: ast.Shape) -> Outlines:
        """Polygons of a shape that doesn't move, each known to be one."""
        match shape:
            case ast.Box():
                return (self.box(shape),)
            case ast.PolygonShape():
                ring = tuple(self.point(e) for e in shape.ring)
                holes = tuple(tuple(self.point(e) for e in hole) for hole in shape.holes)
                return (self._checked(Outline(ring, holes), shape.span),)
            case ast.Prism():
                return self.outlines(shape.base)
            case ast.Union():
                return tuple(o for part in shape.parts for o in self.outlines(part))
            case ast.NamedShape():
                return self.named(shape.name)
            case ast.GeoJson():
                return self.geojson(shape)
        hint = "only an obstacle can move; give it the name `obstacle .. = moving {..}`"
        raise Mistake(NotHere(span=shape.span, problem="this shape can't move", hint=hint))

    def pieces(self, shape: ast.Shape) -> Pieces:
        """Convex pieces of a shape that doesn't move."""
        return cut(self.outlines(shape), shape.span)

    def _checked(self, outline: Outline, span: Span) -> Outline:
        cut((outline,), span)
        return outline

    def track(self, statement: ast.ObstacleDecl) -> Track:
        """The shape at the steps that are given, and how it moves."""
        shape, velocity = statement.shape, (0.0, 0.0)
        if statement.velocity is not None:
            velocity = self._pair(statement.velocity, SPEED, "a velocity `(vx, vy)`")
        if not isinstance(shape, ast.Moving):
            return Track(((0, self.outlines(shape)),), velocity=velocity)
        known = self._frames(shape)
        if 0 not in known:
            hint = "say where it is at first: `moving { 0: box .. ; .. }`"
            raise Mistake(NotHere(span=shape.span, problem="nothing is said of step 0", hint=hint))
        frames = tuple(sorted(known.items()))
        if shape.linear:
            for (step, one), (_, other) in pairwise(frames):
                if not tracks.alike(one, other):
                    problem = f"the shape changes its number of corners after step {step}"
                    hint = "give the same corners in every frame, or leave out `linear`"
                    raise Mistake(NotHere(span=shape.span, problem=problem, hint=hint))
        return Track(frames, shape.linear, velocity)

    def _frames(self, shape: ast.Moving) -> dict[int, tuple[Outline, ...]]:
        """The polygons of each step that is given, each once."""
        known: dict[int, tuple[Outline, ...]] = {}
        places: dict[int, Span] = {}
        for time, part in shape.frames:
            step, outlines = steps(time, self.scope), self.outlines(part)
            if step in known:
                hint = "a moving obstacle has one frame a step: leave one of the two out"
                twice = Redeclared(span=time.span, name=f"step {step}", hint=hint)
                raise Mistake(with_note(twice, "its frame before this one", places[step]))
            known[step], places[step] = outlines, time.span
        return known

    def box(self, shape: ast.Box) -> Outline:
        """An axis-aligned box."""
        (x0, x1), (y0, y1) = (self._extent(e, axis) for e, axis in ((shape.x, "x"), (shape.y, "y")))
        return Outline(((x0, y0), (x1, y0), (x1, y1), (x0, y1)))

    def _extent(self, ends: tuple[ast.Expr, ast.Expr], axis: str) -> Point:
        low, high = (near(self.scope.number(e, METRE), e.span) for e in ends)
        if low >= high:
            span = ends[0].span.to(ends[1].span)
            raise Mistake(EmptyBox(span=span, axis=axis, low=low, high=high))
        return low, high

    def heights(self, shape: ast.Shape) -> Point | None:
        """The heights that a shape lies between [m], None for a column of every height.

        Mistake where its parts lie between different ones: the seams between these aren't closed.
        """
        match shape:
            case ast.Prism():
                if self.heights(shape.base) is not None:
                    problem, hint = "this shape has heights of its own", "leave out one of the two"
                    raise Mistake(NotHere(span=shape.span, problem=problem, hint=hint))
                return self._extent(shape.z, "z")
            case ast.Union():
                return self._common([self.heights(part) for part in shape.parts], shape.span)
            case ast.Moving():
                return self._common([self.heights(part) for _, part in shape.frames], shape.span)
            case ast.NamedShape():
                return self._heights_of(shape.name)
        return None

    def _common(self, found: Sequence[Point | None], span: Span) -> Point | None:
        if len(set(found)) > 1:
            problem = "parts of one shape lie between different heights"
            hint = "declare a shape of its own for each range of heights"
            raise Mistake(NotInSpace(span=span, problem=problem, hint=hint))
        return found[0]

    def _heights_of(self, name: ast.Ident) -> Point | None:
        value = self.scope.lookup(name.text, name.span)
        if isinstance(value, ast.RegionDecl | ast.ObstacleDecl):
            return self.heights(value.shape)
        return value.shape.heights if isinstance(value, Place) else None

    def point(self, expr: ast.Expr) -> Point:
        """A pair of constants [m]."""
        return self._pair(expr, METRE, "a point `(x, y)`")

    def _pair(self, expr: ast.Expr, unit: Unit, expected: str) -> Point:
        value = self.scope.value(expr)
        if not (isinstance(value, Items) and len(value.items) == 2):
            raise Mistake(WrongKind(span=expr.span, expected=expected, found=describe(value)))
        x, y = (_in_unit(v, unit, expr.span) for v in value.items)
        return x, y

    def named(self, name: ast.Ident) -> Outlines:
        """Polygons of another region or obstacle (at step 0, before inflation)."""
        value = self.scope.lookup(name.text, name.span)
        if isinstance(value, ast.RegionDecl | ast.ObstacleDecl):
            with self.scope.expanding(name.text, name.span):
                return self.outlines(value.shape)
        if isinstance(value, Place):
            shape = value.shape
            if isinstance(shape, Region):
                return shape.outlines
            assert shape.track is not None, "a declared obstacle has its track"
            return shape.track.frames[0][1]
        found = "something else" if isinstance(value, ast.Statement) else describe(value)
        raise Mistake(WrongKind(span=name.span, expected="a region or an obstacle", found=found))

    def geojson(self, shape: ast.GeoJson) -> Outlines:
        """Polygons of a GeoJSON file, in a local frame in metres."""
        text = self.files.text(shape.path.value, shape.path.span)
        feature = shape.feature.value if shape.feature else None
        found = []
        for ring, holes in jsonshapes.polygons(text, feature, shape.path):
            for x, y in (p for corners in (ring, *holes) for p in corners):
                near(max(abs(x), abs(y)), shape.span)
            outline = Outline(tuple(ring), tuple(tuple(hole) for hole in holes))
            found.append(self._checked(outline, shape.span))
        return tuple(found)

    def region(self, statement: ast.RegionDecl) -> None:
        """Declare a region."""
        name = statement.name.text
        try:
            outlines, heights = self.outlines(statement.shape), self.heights(statement.shape)
            pieces = cut(outlines, statement.shape.span)
            with _countable(statement.span):
                inner = seams.overlapping(pieces)
                outer = seams.closed(pieces, self.scope.workspace)
        except (Mistake, Reported):
            self.scope.broken.add(name)
            raise
        region = Region(name, inner, statement.name.span, outlines, outer, heights)
        self.scope.regions[name] = region
        self.scope.values[name] = Place(region)

    def obstacle(self, statement: ast.ObstacleDecl) -> None:
        """Declare an obstacle; inflation grows each piece, so the union grows by as much."""
        name = statement.name.text
        try:
            track = self.track(statement)
            self.heights(statement.shape)
            self.place(name, track, self._inflation(statement), statement)
        except (Mistake, Reported):
            self.scope.broken.add(name)
            raise

    def place(self, name: str, track: Track, grow: float, statement: ast.ObstacleDecl) -> None:
        """Work out where an obstacle is at each step that is known so far."""
        quotas.count_in(track, statement, self.scope)
        outlines = tracks.placed(track, self.scope.step, self.scope.last_step)
        bodies = _bodies(outlines, statement.shape.span)
        frames = tuple(tuple(geometry.inflated(p, grow) for p in body) for body in bodies)
        space = self.scope.workspace
        with _countable(statement.span):
            closings = tracks.barriers(frames, space)
            sweeps = tracks.sweeps(outlines, frames, closings, grow, space)
        at = statement.name.span
        heights = self.heights(statement.shape)
        obstacle = Obstacle(name, frames, bodies, grow, at, track, closings, sweeps, heights)
        self.scope.obstacles[name] = obstacle
        self.scope.values[name] = Place(obstacle)

    def _inflation(self, statement: ast.ObstacleDecl) -> float:
        if statement.inflate is None:
            return 0.0
        grow = near(self.scope.number(statement.inflate, METRE), statement.inflate.span)
        if grow < 0:
            hint = "an obstacle grows by the size of the robot: `inflate 0.3 m`"
            raise Mistake(
                NotHere(span=statement.inflate.span, problem="`inflate` is negative", hint=hint)
            )
        return grow


@contextmanager
def _countable(span: Span) -> Iterator[None]:
    """Say where a union has more pieces that touch than can be closed."""
    try:
        yield
    except seams.TooManyPairsError as error:
        hint = "draw its outline as one polygon, or leave out what others cover"
        raise Mistake(TooLarge(span=span, size=str(error), hint=hint)) from None


def cut(outlines: Outlines, span: Span) -> Pieces:
    """Convex pieces of polygons with holes."""
    return tuple(p for o in outlines for p in _polygon(o, span))


def _polygon(outline: Outline, span: Span) -> Pieces:
    if len(outline.ring) < 3 or any(len(hole) < 3 for hole in outline.holes):
        raise Mistake(BadPolygon(span=span, problem="it needs three corners or more"))
    try:
        return _decomposed(outline)
    except PolygonError as error:
        raise Mistake(BadPolygon(span=span, problem=str(error))) from None


@lru_cache(maxsize=16)
def _decomposed(outline: Outline) -> Pieces:
    """A polygon is cut when it is read, and again where it is placed."""
    return tuple(decompose(outline.ring, outline.holes))


def _bodies(outlines: Sequence[Outlines], span: Span) -> tuple[Pieces, ...]:
    """Pieces at each step; a shape that only moves keeps its pieces."""
    found = [cut(outlines[0], span)]
    for before, after in pairwise(outlines):
        by = tracks.move(before, after)
        if by is None:
            found.append(cut(after, span))
        else:
            found.append(tuple(tracks.translated(p, by) if any(by) else p for p in found[-1]))
    return tuple(found)


def _in_unit(value: object, unit: Unit, span: Span) -> float:
    """A constant in the unit that is meant."""
    if isinstance(value, Scalar) and value.is_constant and value.unit in (None, unit):
        return near(value.constant, span)
    expected = f"numbers in {unit}" if unit != METRE else "coordinates in m"
    raise Mistake(WrongKind(span=span, expected=expected, found="something else"))


def near(value: float, span: Span) -> float:
    """A coordinate that a double tells from one a micrometre away. Raises Mistake."""
    if not abs(value) <= FURTHEST:
        raise Mistake(FarAway(span=span, value=value, limit=FURTHEST))
    return value
