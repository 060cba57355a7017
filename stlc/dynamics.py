"""How agents move: affine laws from step to step, and the motion between them. Data only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from stlc.robots import RobotKind
from stlc.source import Span

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Law:
    """x(t+1) = A x(t) + B u(t) + drift, for one step."""

    A: Array
    B: Array
    drift: Array


@dataclass(frozen=True, slots=True, eq=False)
class Flow:
    """x' = A x + B u + drift, the input constant within a step: the motion between samples."""

    A: Array
    B: Array
    drift: Array


@dataclass(frozen=True, slots=True, eq=False)
class Dynamics:
    """x(t+1) = A x(t) + B u(t) + drift, discrete time.

    A (n, n), B (n, m), drift (n,). `position` (2, n) maps a state to its position [m], or is None
    for an agent that is nowhere. `velocity` are the two or three state indices of its derivative.
    `altitude` (n,) maps it to its height [m], or is None for one that stays at height 0.
    Between samples the state follows `flow`, whose zero-order hold A, B and drift are; with none,
    it moves on a straight line if `straight`, and else nothing is known of it.
    `outputs` name further linear signals: (c (n,), d (m,), constant, unit).
    `robot` is what drives behind the point that moves like this (`stlc/robots.py`).
    What varies has a law for each step, the last one going on; A, B and drift are then those of the
    first.
    """

    name: str
    A: Array
    B: Array
    drift: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    state_units: tuple[str, ...]
    input_units: tuple[str, ...]
    position: Array | None = None
    velocity: tuple[int, ...] | None = None
    flow: Flow | None = None
    straight: bool = False
    outputs: Mapping[str, tuple[Array, Array, float, str]] = field(default_factory=dict)
    span: Span | None = None
    altitude: Array | None = None
    robot: RobotKind | None = None
    laws: tuple[Law, ...] = ()

    @property
    def varies(self) -> bool:
        """Whether its matrices change from step to step."""
        return len(self.laws) > 1

    def number(self, step: int) -> int:
        """Which law carries the state from a step to the next."""
        return min(step, max(len(self.laws) - 1, 0))

    def law(self, step: int) -> Law:
        """x(step + 1) = A x + B u + drift."""
        return self.laws[self.number(step)] if self.laws else Law(self.A, self.B, self.drift)

    def over(self, steps: int, first: int = 0) -> tuple[Array, Array, Array]:
        """A (steps, n, n), B (steps, n, m) and drift (steps, n) from a step on."""
        n, m = self.B.shape
        if not self.varies:
            return (
                np.broadcast_to(self.A, (steps, n, n)), np.broadcast_to(self.B, (steps, n, m)),
                np.broadcast_to(self.drift, (steps, n)),
            )  # fmt: skip
        laws = [self.law(first + t) for t in range(steps)]
        return (
            np.array([law.A for law in laws]).reshape(steps, n, n),
            np.array([law.B for law in laws]).reshape(steps, n, m),
            np.array([law.drift for law in laws]).reshape(steps, n),
        )

    def since(self, step: int) -> Dynamics:
        """The dynamics as seen that many steps later."""
        if not self.varies:
            return self
        laws = self.laws[self.number(step) :]
        return replace(self, A=laws[0].A, B=laws[0].B, drift=laws[0].drift, laws=laws)

    @property
    def space(self) -> Array | None:
        """(3, n): x, y and height [m]; None for an agent that is nowhere."""
        if self.position is None:
            return None
        height = np.zeros(len(self.A)) if self.altitude is None else self.altitude
        return np.vstack([self.position, height])

    @property
    def axes(self) -> Array:
        """Rows (k, n) of its coordinates: none, x and y, or x, y and height."""
        if self.position is None:
            return np.empty((0, len(self.A)))
        return self.position if self.altitude is None else np.vstack([self.position, self.altitude])
