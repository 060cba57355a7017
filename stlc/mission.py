"""The checked mission: what semantic analysis hands to every later stage. Data only.

All numbers are in SI units, angles in radians, strengths in dBm or dB, times in steps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stlc.charges import Charge
from stlc.dynamics import Dynamics
from stlc.ir.requirement import Requirement
from stlc.places import Obstacle, Polytope, Region, Wall
from stlc.preferences import Preference
from stlc.robots import Robot
from stlc.sense import Sense
from stlc.source import Source, Span
from stlc.tubes import Tube

if TYPE_CHECKING:
    from stlc.diagnostics import Diagnostic
    from stlc.radio.gp import ChannelModel
    from stlc.radio.learned import Learned
    from stlc.radio.link_budget import LinkBudget
    from stlc.radio.partition import Partition
    from stlc.radio.samples import Samples

Array = NDArray[np.float64]


class PolygonKind(Enum):
    """Which side of a disc its regular polygon lies on."""

    INSCRIBED = "inscribed"  # sound: within the disc
    OUTER = "outer"  # circumscribed: the paper's, lets the norm exceed the limit


@dataclass(frozen=True, slots=True)
class NormBound:
    """Euclidean norm of two or three states (or inputs) <= limit, by a polygon of `sides` sides.

    Face h has the normal (sin(2 pi h / sides), cos(2 pi h / sides)), h = 1..sides, as in the
    paper's eq. (17); offset `limit` (OUTER) or limit * cos(pi / sides) (INSCRIBED). States are
    bounded at t = 1..T, inputs at t = 0..T-1. Of three the faces are `stlc.sphere.directions`, and
    INSCRIBED is the only kind.
    """

    indices: tuple[int, ...]
    limit: float
    sides: int
    kind: PolygonKind
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class TurnRate:
    """||u|| <= (u_max / v_max) ||v|| at t = 0..T-1, the paper's turning rate (mass cancels).

    `literal` leaves out the branch 'at rest' (||v|| <= rest_speed frees u).
    """

    u_max: float
    v_max: float
    directions: int = 16
    literal: bool = False
    rest_speed: float = 0.05
    span: Span | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Agent:
    """One agent. Bounds are (n,) and (m,); state bounds hold at t = 0..T; infinite if absent.

    `start_noise` (n,) and `input_noise` (m,) are standard deviations of what a run is off by, at
    the start and in each step's inputs; None for none. Plans are made without them.
    `starts` are ends (n,) between which it may start in place of `start`: no file says so,
    `explain` asks what would be if the start were free.
    """

    name: str
    dynamics: Dynamics
    start: Array
    state_lower: Array
    state_upper: Array
    input_lower: Array
    input_upper: Array
    effort_state: Array  # q >= 0, (n,)
    effort_input: Array  # r >= 0, (m,)
    integer_inputs: bool = False
    state_norms: tuple[NormBound, ...] = ()
    input_norms: tuple[NormBound, ...] = ()
    turn_rate: TurnRate | None = None
    mass: float = 1.0
    start_noise: Array | None = None
    input_noise: Array | None = None
    tube: Tube | None = None  # of one that is disturbed
    robot: Robot | None = None  # what drives behind the plan of its look-ahead point
    span: Span | None = None
    antenna: float = 0.0  # m above the ground, of one that does not fly
    starts: tuple[Array, Array] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Station:
    """A radio that stays at `position` (2,), `height` [m] above the ground."""

    name: str
    position: Array
    height: float = 0.0
    span: Span | None = None

    @property
    def place(self) -> Array:
        """(3,): x, y and height [m]."""
        return np.append(np.asarray(self.position, dtype=np.float64), self.height)


class Bound(Enum):
    """What one number stands for a whole cell pair."""

    CENTRE = "centre"  # the value between the centres: the paper's
    MEAN = "mean"  # the mean over the cells
    WORST = "worst"  # rigorous: the worst for the polarity it is used in


@dataclass(frozen=True, slots=True, eq=False)
class Channel:
    """A radio channel: a model (with a link budget), link costs given as tables, or both.

    The table of a pair wins for its cost; signal strength and error rates are the model's.
    `tables[(a, b)]`, or `tables[None]` for every pair, is (n, n) with n the cells of `partition`,
    which has layers of height where any agent has one.
    """

    name: str
    partition: Partition
    model: ChannelModel | None = None
    budget: LinkBudget | None = None
    cost: str = "inv_snr"
    tables: Mapping[tuple[str, str] | None, Array] = field(default_factory=dict)
    predicate_bound: Bound = Bound.WORST
    cost_bound: Bound = Bound.MEAN
    auto: bool = False  # the partition may be made finer (`stlc.grids`)
    samples: Samples | None = None  # those of the file
    learned: Learned | None = None  # what the model has beside them (`stlc.measurements`)
    span: Span | None = None

    def has_table(self, pair: tuple[str, str]) -> bool:
        """Whether the mission gives this pair's cost as a table."""
        return any(key in self.tables for key in (pair, pair[::-1], None))


class TermKind(Enum):
    """What an objective term adds up."""

    EFFORT = "effort"
    LINK_COST = "link_cost"
    ROBUSTNESS = "robustness"
    VIOLATION = "violation"
    TOTAL = "total"


@dataclass(frozen=True, slots=True)
class ObjectiveTerm:
    """`weight` times a cost (robustness comes in with a negative weight: all is minimised).

    EFFORT: sum_{t in window, t>=1} q'|x_t| + sum_{t in window, t<=T-1} r'|u_t| over `agents`.
    LINK_COST: sum_{t in window, t>=1} of the channel's cost over `pairs`.
    ROBUSTNESS: of one requirement, or of all together (`requirement` None: their minimum, each
    divided by `scales[unit]`).
    VIOLATION: of the preference that `requirement` names, over its scale.
    TOTAL: what `charges` add up to; `requirement` is how the file writes it.
    `normalised` divides a cost by its static range. `window` None is all steps.
    """

    kind: TermKind
    weight: float
    agents: tuple[str, ...] = ()
    channel: str | None = None
    pairs: tuple[tuple[str, str], ...] = ()
    requirement: str | None = None
    scales: Mapping[str, float] = field(default_factory=dict)
    normalised: bool = False
    window: tuple[int, int] | None = None
    span: Span | None = None
    charges: tuple[Charge, ...] = ()


@dataclass(frozen=True, slots=True)
class Cap:
    """The sum of `terms`, as an objective counts them, is at most `limit`; `name` says of what."""

    name: str
    terms: tuple[ObjectiveTerm, ...]
    limit: float


@dataclass(frozen=True, slots=True, eq=False)
class Mission:
    """A mission that has passed every check.

    `workspace_swept`: the workspace holds between samples too, not at the steps alone. `caps` are
    no part of a file: they hold what is more important, or the other cost of a trade-off.
    """

    source: Source
    step: float  # s
    horizon: int  # T: steps 0..T
    workspace: Polytope | None
    agents: Mapping[str, Agent]
    stations: Mapping[str, Station]
    regions: Mapping[str, Region]
    obstacles: Mapping[str, Obstacle]
    channels: Mapping[str, Channel]
    requirements: tuple[Requirement, ...]
    objective: tuple[ObjectiveTerm, ...]
    signals: tuple[str, ...] = ()  # free signals, for `stlc monitor`
    warnings: tuple[Diagnostic, ...] = ()
    workspace_swept: bool = False
    workspace_levels: tuple[float, float] | None = None  # floor and ceiling [m]
    sense: Sense = Sense.MINIMIZE  # of what a person sees; `objective` is minimised
    params: Mapping[str, str] = field(default_factory=dict)  # what `-D` set, as it was given
    preferences: tuple[Preference, ...] = ()
    caps: tuple[Cap, ...] = ()
    walls: Mapping[str, Wall] = field(default_factory=dict)

    @property
    def aerial(self) -> bool:
        """Whether any agent's height is one of its signals."""
        return any(agent.dynamics.altitude is not None for agent in self.agents.values())

    @property
    def cell_axes(self) -> int:
        """Axes of every channel's cells: 3 where any agent flies, else 2."""
        return 3 if self.aerial else 2

    def summary(self) -> str:
        """One line: agents, requirements, horizon."""
        counts = (len(self.agents), len(self.requirements), self.horizon)
        words = zip(counts, ("agent", "requirement", "step"), strict=True)
        said = (f"{count} {word}{'' if count == 1 else 's'}" for count, word in words)
        return f"{', '.join(said)} of {self.step:g} s"
