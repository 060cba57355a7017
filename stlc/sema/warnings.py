"""Warnings (W1xxx): the mission means something, but perhaps not what its author thinks."""

from __future__ import annotations

from typing import ClassVar

from stlc.diagnostics import Warn


class UnusedObstacle(Warn):
    """An obstacle that no requirement avoids doesn't constrain anything."""

    code: ClassVar[str] = "W1001"
    title: ClassVar[str] = "obstacle `{name}` is not avoided by any requirement"
    label: ClassVar[str] = "has no effect"
    help: ClassVar[str] = "add `require: always forall a in agents: a outside {name}`"
    name: str


class UnusedName(Warn):
    """Something is declared and never used."""

    code: ClassVar[str] = "W1002"
    title: ClassVar[str] = "{what} `{name}` is never used"
    label: ClassVar[str] = "declared here"
    help: ClassVar[str] = "use it or remove it"
    what: str
    name: str


class PartlyOutside(Warn):
    """A region lies partly outside the workspace; only the rest of it can be reached."""

    code: ClassVar[str] = "W1003"
    title: ClassVar[str] = "{what} `{name}` lies {how} outside the workspace"
    label: ClassVar[str] = "beyond the workspace"
    help: ClassVar[str] = "nothing to do if that is meant"
    what: str
    name: str
    how: str


class AlwaysTrue(Warn):
    """A requirement holds whatever the agents do, so it says nothing."""

    code: ClassVar[str] = "W1004"
    title: ClassVar[str] = "requirement `{name}` always holds"
    label: ClassVar[str] = "at worst {worst:.6g}, required {margin:g}"
    help: ClassVar[str] = "remove it, or check its numbers"
    name: str
    worst: float
    margin: float


class EmptyInequality(Warn):
    """`!=` on continuous signals without a margin.

    Predicates are closed sets, and any two reals can differ by as little as one likes, so without
    a margin `a != b` holds everywhere (robustness |a - b| >= 0).
    """

    code: ClassVar[str] = "W1005"
    title: ClassVar[str] = "`!=` holds everywhere without a margin"
    label: ClassVar[str] = "closed semantics: |a - b| >= 0"
    help: ClassVar[str] = "write `abs(a - b) >= 0.1`, or give the requirement a `margin`"


class PaperCost(Warn):
    """`cost paper_inv_rssi` divides by a level in dB.

    It changes sign at 0 dBm, is singular there and has no physical scale. The default `inv_snr`
    is the expected energy for each bit.
    """

    code: ClassVar[str] = "W1006"
    title: ClassVar[str] = "1/RSSI of a level in dBm has the wrong scale"
    label: ClassVar[str] = "kept only to repeat published results"
    help: ClassVar[str] = "use `cost inv_snr`"


class NoRequirement(Warn):
    """The mission requires nothing."""

    code: ClassVar[str] = "W1007"
    title: ClassVar[str] = "the mission has no requirement"
    help: ClassVar[str] = "add a line such as `require: eventually[0, 8] r1 in goal`"


class OuterPolygon(Warn):
    """A circumscribed speed polygon lets the speed exceed its limit."""

    code: ClassVar[str] = "W1008"
    title: ClassVar[str] = "an outer polygon lets the norm exceed its limit"
    label: ClassVar[str] = "by up to {excess:.1f} % with {sides} sides"
    help: ClassVar[str] = "leave out `outer`: the inscribed polygon never exceeds it"
    excess: float
    sides: int


class ChannelNote(Warn):
    """The radio model has something to say about the values it was given."""

    code: ClassVar[str] = "W1009"
    title: ClassVar[str] = "channel `{channel}`: {text}"
    label: ClassVar[str] = "this channel"
    help: ClassVar[str] = "`stlc fit` on the same samples tells more"
    channel: str
    text: str


class NeverFromStart(Warn):
    """A requirement can't hold from where the agents start, whatever they do later.

    Solving such a mission ends with a proof that there is no plan.
    """

    code: ClassVar[str] = "W1010"
    title: ClassVar[str] = "requirement `{name}` can't hold from these starts"
    label: ClassVar[str] = "at best {best:.6g}, required {margin:g}"
    help: ClassVar[str] = "give it a window, `eventually[0, n]` or `always[1, n]`, or move a start"
    name: str
    best: float
    margin: float


class OneSided(Warn):
    """A control is bounded on one side only, so it may be as large as one likes on the other.

    `control u <= 1` leaves u = -1000 open; `control |u| <= 1` bounds both sides.
    """

    code: ClassVar[str] = "W1011"
    title: ClassVar[str] = "control `{name}` of {agent} has no {side} bound"
    label: ClassVar[str] = "bounds one side"
    help: ClassVar[str] = "write `control |u| <= 1` if both signs are meant"
    name: str
    agent: str
    side: str


class NarrowGap(Warn):
    """Two obstacles, or an obstacle and the workspace's border, leave less than a millimetre.

    What touches is closed; a gap of a micrometre or more is a way through, which a robot without
    size takes. `inflate` gives robots a size.
    """

    code: ClassVar[str] = "W1012"
    title: ClassVar[str] = "obstacle `{name}` leaves a gap of {gap:.3g} m to {what}"
    label: ClassVar[str] = "nearly touches {what}"
    help: ClassVar[str] = "let them touch to close the gap, or `inflate` by the size of the robot"
    name: str
    gap: float
    what: str
