"""The abstract syntax of mission files, exactly as written: names and units are not yet resolved.

One expression language serves numbers, points, regions and formulas; semantic analysis tells them
apart. Every node has the span of its text; comments are kept beside the tree for `stlc fmt`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from stlc.source import Source, Span


@dataclass(frozen=True, slots=True)
class Ident:
    """A name with its place."""

    text: str
    span: Span


# --- expressions -----------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Expr:
    """Base of all expressions."""

    span: Span


@dataclass(frozen=True, slots=True)
class Number(Expr):
    """`8`, `0.5 m`, `-70 dBm` (the sign is a `Negate`), `10 dB^2`, `2 m/s`; `unit` as written."""

    value: float
    text: str
    unit: str | None = None


@dataclass(frozen=True, slots=True)
class String(Expr):
    """`"rssi.csv"`."""

    value: str


@dataclass(frozen=True, slots=True)
class Bool(Expr):
    """`true` or `false`."""

    value: bool


@dataclass(frozen=True, slots=True)
class Name(Expr):
    """A declared or bound name."""

    text: str


@dataclass(frozen=True, slots=True)
class Attribute(Expr):
    """`r1.vx`."""

    base: Expr
    attr: Ident


@dataclass(frozen=True, slots=True)
class Index(Expr):
    """`uav[2]`, one member of a family."""

    base: Expr
    indices: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Call(Expr):
    """`home(r1, goal)`, `rssi(a, b)`, `distance(a, b)`, `abs(x)`, `P(rssi(a, b) >= -70 dBm)`."""

    function: Ident
    args: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Tuple(Expr):
    """`(1, 2)`."""

    items: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class List(Expr):
    """`[goal1, goal2]`, and rows of a matrix `[[1, 0], [0, 1]]`."""

    items: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Absolute(Expr):
    """`|u|`."""

    arg: Expr


@dataclass(frozen=True, slots=True)
class Negate(Expr):
    """Unary minus."""

    arg: Expr


@dataclass(frozen=True, slots=True)
class Arithmetic(Expr):
    """`+ - * / ^`."""

    operator: Literal["+", "-", "*", "/", "^"]
    left: Expr
    right: Expr


@dataclass(frozen=True, slots=True)
class Comparison(Expr):
    """`a <= b < c`: one or more comparisons in a row, all of which hold."""

    operands: tuple[Expr, ...]
    operators: tuple[Literal["<", "<=", ">", ">=", "==", "!="], ...]


@dataclass(frozen=True, slots=True)
class Membership(Expr):
    """`a in goal`, `a outside pillar`, `a outside pillar swept`."""

    subject: Expr
    relation: Literal["in", "outside"]
    place: Expr
    swept: bool = False


@dataclass(frozen=True, slots=True)
class Swept(Expr):
    """`separation(a, b) >= 0.5 m swept`: the comparison holds between samples too."""

    arg: Expr


@dataclass(frozen=True, slots=True)
class Not(Expr):
    """`not f`."""

    arg: Expr


@dataclass(frozen=True, slots=True)
class Logical(Expr):
    """`and or implies iff`; chains of `and`, `or` are flat, `implies` is right-associative."""

    operator: Literal["and", "or", "implies", "iff"]
    args: tuple[Expr, ...]


@dataclass(frozen=True, slots=True)
class Interval:
    """`[a, b]`; `end` None is written `[a, inf]` or `[a, end]`."""

    start: Expr
    end: Expr | None
    span: Span


@dataclass(frozen=True, slots=True)
class Temporal(Expr):
    """`always[a,b] f`, `eventually[a,b] f`, `next f`; no interval: unbounded (or one step)."""

    operator: Literal["always", "eventually", "next"]
    interval: Interval | None
    arg: Expr


@dataclass(frozen=True, slots=True)
class TemporalPair(Expr):
    """`f until[a,b] g`, `f release[a,b] g`."""

    operator: Literal["until", "release"]
    interval: Interval | None
    left: Expr
    right: Expr


@dataclass(frozen=True, slots=True)
class Quantifier(Expr):
    """`forall a in agents: f`, `forall (a, b) in pairs: f`, `exists r in [g1, g2]: f`.

    As a sum over the same domains, `sum a in agents: x`, it is arithmetic.
    """

    kind: Literal["forall", "exists", "sum"]
    variables: tuple[Ident, ...]
    domain: Expr
    body: Expr


@dataclass(frozen=True, slots=True)
class Range(Expr):
    """`1..4`, as a domain, a family or a set of steps."""

    start: Expr
    end: Expr


# --- shapes ----------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Shape:
    """Base of all shapes."""

    span: Span


@dataclass(frozen=True, slots=True)
class Box(Shape):
    """`box [x0, x1] x [y0, y1]`."""

    x: tuple[Expr, Expr]
    y: tuple[Expr, Expr]


@dataclass(frozen=True, slots=True)
class PolygonShape(Shape):
    """`polygon (1, 8) (2, 8) (2, 9) hole (..) (..) (..)`."""

    ring: tuple[Expr, ...]
    holes: tuple[tuple[Expr, ...], ...] = ()


@dataclass(frozen=True, slots=True)
class GeoJson(Shape):
    """`geojson "site.json" [feature "name"]`, metres in a local frame."""

    path: String
    feature: String | None = None


@dataclass(frozen=True, slots=True)
class NamedShape(Shape):
    """A region used as a shape: `obstacle wall = goal1`."""

    name: Ident


@dataclass(frozen=True, slots=True)
class Moving(Shape):
    """`moving { 0: box ..; 3: box ..; .. }`: the shape from each step on, or `path` by vectors."""

    frames: tuple[tuple[Expr, Shape], ...]


@dataclass(frozen=True, slots=True)
class Union(Shape):
    """`shape + shape`."""

    parts: tuple[Shape, ...]


# --- statements ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Property:
    """One property of a block: a key, then its words and values as written.

    `L0 = -12.89 dBm` and `n = 3` have `args` of one value and are `assigned`. `control |u| <= 1`
    has key `control` and the comparison; `speed <= 2` has key `speed` and the comparison with
    `Name("speed")` as first operand (`speed in [0, 2]` the membership likewise). `turn_rate on` has
    the name `on`; `partition 10 x 10` the two numbers, `box [0, 1] x [0, 2]` the name and two
    lists; `start (1, 1)` a tuple; `turn_rate` alone no `args`. A block is flat: in
    `path_loss L0 = -12.89 dBm, n = 3` there are three properties, `path_loss` without `args`, `L0`
    and `n`. In a block a bracket that follows a word after a blank starts a value of its own
    (`start (1, 1)`), without a blank it is a call or an index (`bound max(1, 2)`). A comma ends a
    property, except between bare words: `states px, vx` has the names `px` and `vx`, and so has
    `states px vx`; `states px [m] vx [m/s]` has name, list, name, list.
    """

    key: Ident
    args: tuple[Expr, ...]
    assigned: bool
    span: Span


@dataclass(frozen=True, slots=True)
class Statement:
    """Base of all statements."""

    span: Span


@dataclass(frozen=True, slots=True)
class Import(Statement):
    """`import "lib.stl"`."""

    path: String


@dataclass(frozen=True, slots=True)
class Param(Statement):
    """`param v = 2 m/s`; overridden by `-D v=3`."""

    name: Ident
    value: Expr


@dataclass(frozen=True, slots=True)
class SignalDecl(Statement):
    """`signal speed [m/s]`, for formulas that are monitored on recorded data."""

    names: tuple[Ident, ...]
    unit: str | None = None


@dataclass(frozen=True, slots=True)
class Step(Statement):
    """`step 1 s`."""

    duration: Expr


@dataclass(frozen=True, slots=True)
class Horizon(Statement):
    """`horizon 20`, `horizon 20 s`."""

    length: Expr


@dataclass(frozen=True, slots=True)
class Margin(Statement):
    """`margin 0.1`: the robustness every requirement must reach."""

    value: Expr


@dataclass(frozen=True, slots=True)
class Workspace(Statement):
    """`workspace box [0, 10] x [0, 10]`."""

    shape: Shape


@dataclass(frozen=True, slots=True)
class DynamicsDecl(Statement):
    """`dynamics cart = double_integrator { .. }` or `dynamics cart { A = ..; B = .. }`."""

    name: Ident
    kind: Ident | None
    properties: tuple[Property, ...]


@dataclass(frozen=True, slots=True)
class AgentDecl(Statement):
    """`agent r1 : cart { .. }`, `agent uav[1..4] : cart { .. }`."""

    name: Ident
    family: Range | None
    dynamics: Ident
    properties: tuple[Property, ...]


@dataclass(frozen=True, slots=True)
class StationDecl(Statement):
    """`station base at (5, 0)`, with a block for its height and the like."""

    name: Ident
    position: Expr
    properties: tuple[Property, ...] = ()


@dataclass(frozen=True, slots=True)
class RegionDecl(Statement):
    """`region goal = box ..`."""

    name: Ident
    shape: Shape


@dataclass(frozen=True, slots=True)
class ObstacleDecl(Statement):
    """`obstacle pillar = box .. inflate 0.3 m`."""

    name: Ident
    shape: Shape
    inflate: Expr | None = None


@dataclass(frozen=True, slots=True)
class ChannelDecl(Statement):
    """`channel radio { .. }`."""

    name: Ident
    properties: tuple[Property, ...]


@dataclass(frozen=True, slots=True)
class Let(Statement):
    """`let home(a, g) = ..`."""

    name: Ident
    parameters: tuple[Ident, ...]
    body: Expr


@dataclass(frozen=True, slots=True)
class Require(Statement):
    """`require reach1 [margin 0.2]: ..`; the name is optional."""

    name: Ident | None
    formula: Expr
    margin: Expr | None = None


@dataclass(frozen=True, slots=True)
class Prefer(Statement):
    """Reserved for soft requirements: `prefer close weight 2: ..`."""

    name: Ident | None


@dataclass(frozen=True, slots=True)
class Objective(Statement):
    """`minimize 0.1 * effort + 0.9 * link_cost(radio)`, `maximize robustness`."""

    sense: Literal["minimize", "maximize"]
    expression: Expr


@dataclass(frozen=True, slots=True)
class Comment:
    """`# text`, where it stands."""

    text: str
    span: Span


@dataclass(frozen=True, slots=True)
class File:
    """A whole mission or library file."""

    source: Source
    statements: tuple[Statement, ...]
    comments: tuple[Comment, ...] = ()
