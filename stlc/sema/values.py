"""What expressions evaluate to. Scalars are piecewise linear over signals and link qualities."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from math import prod

from stlc.ir.nodes import Node, Quantity, Signal
from stlc.mission import Agent, Station
from stlc.places import Obstacle, Polytope, Region, Sweep
from stlc.sema.units import Unit
from stlc.syntax import ast


@dataclass(frozen=True, slots=True)
class LinkAtom:
    """A link quality, as an unknown beside the signals."""

    channel: str
    quantity: Quantity
    sender: str
    receiver: str
    shift: int = 0


Atom = Signal | LinkAtom


class FoldKind(Enum):
    """What a fold does with its arguments."""

    MAX = "max"
    MIN = "min"
    DISTANCE = "distance"  # the max over faces, which is within `least` of a norm


@dataclass(frozen=True, slots=True)
class Fold:
    """Maximum or minimum of scalars; `pieces` counts the linear functions it is made of.

    `components` (x, y), or (x, y, z), of a DISTANCE, which its faces stand for; the largest of them
    is between `least` times the distance and the distance.
    """

    kind: FoldKind
    args: tuple[Scalar, ...]
    components: tuple[Scalar, ...] = ()
    least: float = 1.0
    pieces: int = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "pieces", sum(arg.pieces for arg in self.args))


@dataclass(frozen=True, slots=True)
class Scalar:
    """constant + terms + folds. `unit` None is a bare number, which takes any unit it meets.

    `index`: a number that a quantifier's variable stands for, or one computed from it.
    """

    constant: float = 0.0
    terms: tuple[tuple[Atom, float], ...] = ()
    folds: tuple[tuple[Fold, float], ...] = ()
    unit: Unit | None = None
    index: bool = False

    @property
    def is_constant(self) -> bool:
        """True when it is a number known now."""
        return not self.terms and not self.folds

    @property
    def pieces(self) -> int:
        """How many linear functions a comparison of it expands to."""
        return prod(fold.pieces for fold, _ in self.folds)


@dataclass(frozen=True, slots=True)
class Separation:
    """The differences along x and y, and z in space; as a scalar, the largest of their sizes."""

    axes: tuple[Scalar, ...]


@dataclass(frozen=True, slots=True)
class Truth:
    """A formula."""

    node: Node


@dataclass(frozen=True, slots=True)
class Chance:
    """`P(link predicate)`, before it is compared with a probability."""

    link: Node


@dataclass(frozen=True, slots=True)
class Tally:
    """`count(b in agents: ..)`, before it is compared with a number."""

    expr: ast.Quantifier
    env: Env


@dataclass(frozen=True, slots=True)
class Delivery:
    """`delivered(a, b)[2, 8]`, before it is compared with an amount; `window` None: all steps."""

    channel: str
    ends: tuple[str, str]
    window: tuple[int, int] | None = None


@dataclass(frozen=True, slots=True)
class Place:
    """A region or an obstacle."""

    shape: Region | Obstacle

    @property
    def heights(self) -> tuple[float, float] | None:
        """Between which heights it lies, inflation included [m]; None for all."""
        shape, grow = self.shape, 0.0
        if isinstance(shape, Obstacle):
            grow = shape.inflate
        return shape.heights and (shape.heights[0] - grow, shape.heights[1] + grow)

    @property
    def frames(self) -> tuple[tuple[Polytope, ...], ...]:
        """Pieces at each step, to be in; the last frame stays."""
        return self.shape.frames if isinstance(self.shape, Obstacle) else (self.shape.pieces,)

    @property
    def barriers(self) -> tuple[tuple[Polytope, ...], ...]:
        """Pieces to keep out of at each step, seams closed; the last frame stays."""
        return self.shape.barrier if isinstance(self.shape, Obstacle) else (self.shape.barrier,)

    @property
    def sweeps(self) -> tuple[Sweep, ...]:
        """What to keep out of from each step to the next; the last one stays."""
        shape = self.shape
        return shape.sweeps if isinstance(shape, Obstacle) else (Sweep(shape.barrier),)


@dataclass(frozen=True, slots=True)
class Radio:
    """An agent or a station."""

    thing: Agent | Station

    @property
    def name(self) -> str:
        """Its name."""
        return self.thing.name


@dataclass(frozen=True, slots=True)
class Items:
    """A tuple, list, family or domain."""

    items: tuple[Value, ...]
    what: str = "list"


@dataclass(frozen=True, slots=True)
class Members:
    """`r1.u` or `r1.x`: a vector of signals, to be indexed."""

    items: tuple[Scalar, ...]


@dataclass(frozen=True, slots=True)
class Text:
    """A string."""

    text: str


@dataclass(frozen=True, slots=True)
class ChannelName:
    """A declared channel."""

    name: str


@dataclass(frozen=True, slots=True, eq=False)
class Function:
    """A parametrised `let`; the same one when it is the same statement."""

    let: ast.Let

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Function) and self.let is other.let

    def __hash__(self) -> int:
        return id(self.let)


Value = (
    Scalar
    | Separation
    | Truth
    | Chance
    | Tally
    | Delivery
    | Place
    | Radio
    | Items
    | Members
    | Text
    | ChannelName
    | Function
)


@dataclass(frozen=True, slots=True)
class Env:
    """What an expression's meaning depends on, besides the declarations."""

    bound: Mapping[str, Value]
    positive: bool = True  # polarity, for what is only bounded from one side
    margin: float = 0.0
    clock: int | None = None  # the step at which known signals have their values

    def __hash__(self) -> int:
        return hash((tuple(self.bound.items()), self.positive, self.margin))


def describe(value: Value) -> str:
    """What a value is, in a person's words."""
    match value:
        case Scalar(unit=unit):
            return f"a quantity in {unit}" if unit and str(unit) else "a number"
        case Separation():
            return "a separation"
        case Truth():
            return "a formula"
        case Chance():
            return "a probability"
        case Tally():
            return "a count"
        case Delivery():
            return "an amount that is delivered"
        case Place(shape=shape):
            return f"the {type(shape).__name__.lower()} `{shape.name}`"
        case Radio(thing=thing):
            return f"the {type(thing).__name__.lower()} `{thing.name}`"
        case Items(what=what):
            return f"a {what}"
        case Members():
            return "a vector of signals"
        case Text():
            return "a text"
        case ChannelName(name=name):
            return f"the channel `{name}`"
        case Function(let=let):
            return f"the parametrised `{let.name.text}`"
