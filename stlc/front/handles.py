"""Names of a mission that formulas speak of: agents, stations, places, channels."""

from __future__ import annotations

from dataclasses import dataclass

from stlc.front.expressions import Formula, Quantity
from stlc.front.text import written


@dataclass(frozen=True, slots=True, eq=False)
class Handle:
    """Anything declared under a name."""

    name: str

    @property
    def text(self) -> str:
        """The name."""
        return self.name

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"


class Place(Handle):
    """A region or an obstacle."""


class Channel(Handle):
    """A channel."""


class Dynamics(Handle):
    """How agents move."""


class Station(Handle):
    """A radio that stays where it is."""


class Agent(Handle):
    """An agent; its signals are attributes: `r.x`, `r.vy`, `r.position`, `r.u`, and its states and
    inputs by their own names."""

    def __getattr__(self, signal: str) -> Quantity:
        if signal.startswith("_"):
            raise AttributeError(signal)
        return Quantity(f"{self.name}.{signal}")

    def inside(self, place: Place | str) -> Formula:
        """`r in place`."""
        return Formula(f"{self.name} in {written(place)}")

    def outside(self, place: Place | str) -> Formula:
        """`r outside place`; `.swept()` says so of the motion between the steps too."""
        return Formula(f"{self.name} outside {written(place)}")
