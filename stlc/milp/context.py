"""What every encoder shares: mission, growing model, columns and ranges of the trajectory."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.arrays import Floats, Ints
from stlc.milp.builder import ModelBuilder
from stlc.milp.layout import Layout
from stlc.mission import Agent, Mission


@dataclass(frozen=True, slots=True, eq=False)
class Affine:
    """constant + sum values * x[cols]: an expression over columns."""

    cols: Ints
    values: Floats
    constant: float = 0.0

    def scaled(self, factor: float) -> Affine:
        """The expression times a number."""
        return Affine(self.cols, self.values * factor, self.constant * factor)

    def plus(self, other: Affine) -> Affine:
        """The sum of two expressions."""
        return Affine(
            np.concatenate([self.cols, other.cols]),
            np.concatenate([self.values, other.values]),
            self.constant + other.constant,
        )


@dataclass(slots=True, eq=False)
class Context:
    """Handed from encoder to encoder while one model is built.

    `layout` collects what each encoder put where. `memo` is for encoders that
    share auxiliary columns (cells of an agent at a step, literals of a sub-formula).
    """

    mission: Mission
    builder: ModelBuilder
    ranges: Mapping[str, Ranges]
    layout: Layout = field(default_factory=Layout)
    memo: dict[Any, Any] = field(default_factory=dict)

    @property
    def states(self) -> dict[str, Ints]:
        """states[agent] (T+1, n): columns."""
        return self.layout.states

    @property
    def inputs(self) -> dict[str, Ints]:
        """inputs[agent] (T, m): columns."""
        return self.layout.inputs

    def agent(self, name: str) -> Agent:
        """The agent of that name."""
        return self.mission.agents[name]

    def position(self, name: str, step: int, axis: int) -> Affine:
        """Coordinate `axis` (0 x, 1 y, 2 z) [m] of an agent's or station's place at a step."""
        station = self.mission.stations.get(name)
        if station is not None:
            return Affine(np.empty(0, np.int64), np.empty(0), float(station.place[axis]))
        row = self.agent(name).dynamics.space
        assert row is not None, "semantic analysis gives every radio a position"
        used = np.flatnonzero(row[axis])
        return Affine(self.states[name][step, used], row[axis][used])
