"""Expressions and shapes of mission files, exactly as written: a part of `stlc.syntax.ast`."""

from __future__ import annotations

from typing import Literal

from stlc.record import Record
from stlc.source import Span


class Ident(Record):
    """A name with its place."""

    text: str
    span: Span


# --- expressions -----------------------------------------------------------------------------


class Expr(Record):
    """Base of all expressions."""

    span: Span


class Number(Expr):
    """`8`, `0.5 m`, `-70 dBm` (the sign is a `Negate`), `10 dB^2`, `2 m/s`; `unit` as written."""

    value: float
    text: str
    unit: str | None = None


class String(Expr):
    """`"rssi.csv"`."""

    value: str


class Bool(Expr):
    """`true` or `false`."""

    value: bool


class Name(Expr):
    """A declared or bound name."""

    text: str


class Attribute(Expr):
    """`r1.vx`."""

    base: Expr
    attr: Ident


class Index(Expr):
    """`uav[2]`, one member of a family."""

    base: Expr
    indices: tuple[Expr, ...]


class Call(Expr):
    """`home(r1, goal)`, `rssi(a, b)`, `distance(a, b)`, `abs(x)`, `P(rssi(a, b) >= -70 dBm)`."""

    function: Ident
    args: tuple[Expr, ...]


class Tuple(Expr):
    """`(1, 2)`."""

    items: tuple[Expr, ...]


class List(Expr):
    """`[goal1, goal2]`, and rows of a matrix `[[1, 0], [0, 1]]`."""

    items: tuple[Expr, ...]


class Absolute(Expr):
    """`|u|`."""

    arg: Expr


class Negate(Expr):
    """Unary minus."""

    arg: Expr


class Arithmetic(Expr):
    """`+ - * / ^`. A flat chain `a + b - c` leans to the left, to any depth: walk its `spine`."""

    operator: Literal["+", "-", "*", "/", "^"]
    left: Expr
    right: Expr

    @property
    def spine(self) -> list[Arithmetic]:
        """This node and the operations down its left side, innermost first."""
        chain = [self]
        while isinstance(chain[-1].left, Arithmetic):
            chain.append(chain[-1].left)
        return chain[::-1]


class Comparison(Expr):
    """`a <= b < c`: one or more comparisons in a row, all of which hold."""

    operands: tuple[Expr, ...]
    operators: tuple[Literal["<", "<=", ">", ">=", "==", "!="], ...]


class Membership(Expr):
    """`a in goal`, `a outside pillar`, `a outside pillar swept`."""

    subject: Expr
    relation: Literal["in", "outside"]
    place: Expr
    swept: bool = False


class Swept(Expr):
    """`separation(a, b) >= 0.5 m swept`: the comparison holds between samples too."""

    arg: Expr


class Not(Expr):
    """`not f`."""

    arg: Expr


class Logical(Expr):
    """`and or implies iff`; chains of `and`, `or` are flat, `implies` is right-associative."""

    operator: Literal["and", "or", "implies", "iff"]
    args: tuple[Expr, ...]


class Interval(Record):
    """`[a, b]`; `end` None is written `[a, inf]` or `[a, end]`."""

    start: Expr
    end: Expr | None
    span: Span


class Temporal(Expr):
    """`always[a,b] f`, `eventually[a,b] f`, `next f`; no interval: unbounded (or one step)."""

    operator: Literal["always", "eventually", "next"]
    interval: Interval | None
    arg: Expr


class TemporalPair(Expr):
    """`f until[a,b] g`, `f release[a,b] g`."""

    operator: Literal["until", "release"]
    interval: Interval | None
    left: Expr
    right: Expr


class Quantifier(Expr):
    """`forall a in agents: f`, `forall (a, b) in pairs: f`, `exists r in [g1, g2]: f`.

    As a sum over the same domains, `sum a in agents: x`, it is arithmetic, and so is the number of
    instances that hold, `count(a in agents: f)`.
    """

    kind: Literal["forall", "exists", "sum", "count"]
    variables: tuple[Ident, ...]
    domain: Expr
    body: Expr


class Range(Expr):
    """`1..4`, as a domain, a family or a set of steps."""

    start: Expr
    end: Expr


# --- shapes ----------------------------------------------------------------------------------


class Shape(Record):
    """Base of all shapes."""

    span: Span


class Box(Shape):
    """`box [x0, x1] x [y0, y1]`."""

    x: tuple[Expr, Expr]
    y: tuple[Expr, Expr]


class PolygonShape(Shape):
    """`polygon (1, 8) (2, 8) (2, 9) hole (..) (..) (..)`."""

    ring: tuple[Expr, ...]
    holes: tuple[tuple[Expr, ...], ...] = ()


class GeoJson(Shape):
    """`geojson "site.json" [feature "name"]`, metres in a local frame."""

    path: String
    feature: String | None = None


class NamedShape(Shape):
    """A region used as a shape: `obstacle wall = goal1`."""

    name: Ident


class Moving(Shape):
    """`moving { 0: box ..; 3: box ..; .. }`: the shape from each step on; `linear` between them."""

    frames: tuple[tuple[Expr, Shape], ...]
    linear: bool = False


class Prism(Shape):
    """`box [x0, x1] x [y0, y1] x [z0, z1]`: a shape of the plane between two heights."""

    base: Shape
    z: tuple[Expr, Expr]


class Line(Shape):
    """`line (0, 0) (3, 0) (3, 2)`: what a wall may be drawn by."""

    points: tuple[Expr, ...]


class Union(Shape):
    """`shape + shape`."""

    parts: tuple[Shape, ...]
