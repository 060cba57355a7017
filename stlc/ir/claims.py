"""What nodes stand for in the mission's own words, for a judge that doesn't look at the nodes."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stlc.ir.nodes import Linear, Node


class Motion(Enum):
    """What a `swept` condition says of the motion from one step to the next."""

    OUTSIDE = "outside"  # of an obstacle (inflated) or region
    INSIDE = "inside"  # of a region
    SEPARATION = "separation"  # |dx| >= distances[0] or |dy| >= distances[1]
    CONDITION = "condition"  # any other condition on states and inputs


@dataclass(frozen=True, slots=True)
class Swept:
    """The meaning behind a node that stands for a `swept` condition at its step t.

    The node is a sufficient condition over samples; this says what it is sufficient for, over all
    times in [t, t + 1]. `place` names an obstacle or region, `other` the second agent or station;
    a CONDITION is about no agent alone and is the formula `condition`. The verifier judges it in
    continuous time without looking at the node.
    """

    motion: Motion
    agent: str = ""
    place: str | None = None
    other: str | None = None
    distances: tuple[float, float] = (0.0, 0.0)
    condition: Node | None = None


@dataclass(frozen=True, slots=True)
class Membership:
    """The meaning behind a node that says of a sample that it is in, or outside, a place.

    `subject` is an agent or a station, or the two or three coordinates of a point; `place` names an
    obstacle or region of the file. The verifier judges it by the corners in the file, beside the
    node.
    """

    inside: bool
    subject: str | tuple[Linear, ...]
    place: str
