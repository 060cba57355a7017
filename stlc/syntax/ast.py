"""The abstract syntax of mission files, exactly as written: names and units are not yet resolved.

One expression language serves numbers, points, regions and formulas; semantic analysis tells them
apart. Every node has the span of its text; comments are kept beside the tree for `stlc fmt`.
"""

from __future__ import annotations

from typing import Literal

from stlc.record import Record
from stlc.source import Source, Span
from stlc.syntax.nodes import (
    Absolute as Absolute,
)
from stlc.syntax.nodes import (
    Arithmetic as Arithmetic,
)
from stlc.syntax.nodes import (
    Attribute as Attribute,
)
from stlc.syntax.nodes import (
    Bool as Bool,
)
from stlc.syntax.nodes import (
    Box as Box,
)
from stlc.syntax.nodes import (
    Call as Call,
)
from stlc.syntax.nodes import (
    Comparison as Comparison,
)
from stlc.syntax.nodes import (
    Expr as Expr,
)
from stlc.syntax.nodes import (
    GeoJson as GeoJson,
)
from stlc.syntax.nodes import (
    Ident as Ident,
)
from stlc.syntax.nodes import (
    Index as Index,
)
from stlc.syntax.nodes import (
    Interval as Interval,
)
from stlc.syntax.nodes import (
    Line as Line,
)
from stlc.syntax.nodes import (
    List as List,
)
from stlc.syntax.nodes import (
    Logical as Logical,
)
from stlc.syntax.nodes import (
    Membership as Membership,
)
from stlc.syntax.nodes import (
    Moving as Moving,
)
from stlc.syntax.nodes import (
    Name as Name,
)
from stlc.syntax.nodes import (
    NamedShape as NamedShape,
)
from stlc.syntax.nodes import (
    Negate as Negate,
)
from stlc.syntax.nodes import (
    Not as Not,
)
from stlc.syntax.nodes import (
    Number as Number,
)
from stlc.syntax.nodes import (
    PolygonShape as PolygonShape,
)
from stlc.syntax.nodes import (
    Prism as Prism,
)
from stlc.syntax.nodes import (
    Quantifier as Quantifier,
)
from stlc.syntax.nodes import (
    Range as Range,
)
from stlc.syntax.nodes import (
    Shape as Shape,
)
from stlc.syntax.nodes import (
    String as String,
)
from stlc.syntax.nodes import (
    Swept as Swept,
)
from stlc.syntax.nodes import (
    Temporal as Temporal,
)
from stlc.syntax.nodes import (
    TemporalPair as TemporalPair,
)
from stlc.syntax.nodes import (
    Tuple as Tuple,
)
from stlc.syntax.nodes import (
    Union as Union,
)


class Property(Record):
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


class Statement(Record):
    """Base of all statements."""

    span: Span


class Import(Statement):
    """`import "lib.stl"`."""

    path: String


class Param(Statement):
    """`param v = 2 m/s`; overridden by `-D v=3`."""

    name: Ident
    value: Expr


class SignalDecl(Statement):
    """`signal speed [m/s]`, for formulas that are monitored on recorded data; with
    `from "speed.csv"` it is known beforehand."""

    names: tuple[Ident, ...]
    unit: str | None = None
    file: String | None = None


class Step(Statement):
    """`step 1 s`."""

    duration: Expr


class Horizon(Statement):
    """`horizon 20`, `horizon 20 s`."""

    length: Expr


class Margin(Statement):
    """`margin 0.1`: the robustness every requirement must reach."""

    value: Expr


class Workspace(Statement):
    """`workspace box [0, 10] x [0, 10] swept`; `times` is "swept", "sampled" or left open."""

    shape: Shape
    times: str | None = None


class DynamicsDecl(Statement):
    """`dynamics cart = double_integrator { .. }` or `dynamics cart { A = ..; B = .. }`."""

    name: Ident
    kind: Ident | None
    properties: tuple[Property, ...]


class AgentDecl(Statement):
    """`agent r1 : cart { .. }`, `agent uav[1..4] : cart { .. }`."""

    name: Ident
    family: Range | None
    dynamics: Ident
    properties: tuple[Property, ...]


class StationDecl(Statement):
    """`station base at (5, 0)`, with a block for its height and the like."""

    name: Ident
    position: Expr
    properties: tuple[Property, ...] = ()


class RegionDecl(Statement):
    """`region goal = box ..`."""

    name: Ident
    shape: Shape


class ObstacleDecl(Statement):
    """`obstacle pillar = box .. velocity (1, 0) inflate 0.3 m`."""

    name: Ident
    shape: Shape
    inflate: Expr | None = None
    velocity: Expr | None = None


class WallDecl(Statement):
    """`wall brick = line .. loss 6 dB`, `wall core = box .. loss 10 dB`."""

    name: Ident
    shape: Shape
    loss: Expr | None = None


class ChannelDecl(Statement):
    """`channel radio { .. }`."""

    name: Ident
    properties: tuple[Property, ...]


class Let(Statement):
    """`let home(a, g) = ..`."""

    name: Ident
    parameters: tuple[Ident, ...]
    body: Expr


class Require(Statement):
    """`require reach1 [margin 0.2]: ..`; the name is optional."""

    name: Ident | None
    formula: Expr
    margin: Expr | None = None


class Wish(Record):
    """One word of a `prefer`: `weight 2`, `priority 1`, `margin 0.1`, `scale 2 dB`, `late`,
    `share`; the last two have no value."""

    word: str
    value: Expr | None
    span: Span


class Prefer(Statement):
    """`prefer close weight 2: ..`; the name is optional."""

    name: Ident | None
    formula: Expr
    wishes: tuple[Wish, ...] = ()


class Objective(Statement):
    """`minimize 0.1 * effort + 0.9 * link_cost(radio)`, `maximize robustness`."""

    sense: Literal["minimize", "maximize"]
    expression: Expr


class Comment(Record):
    """`# text`, where it stands."""

    text: str
    span: Span


class File(Record):
    """A whole mission or library file."""

    source: Source
    statements: tuple[Statement, ...]
    comments: tuple[Comment, ...] = ()
