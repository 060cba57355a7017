"""Where agents are at even times, by their own motion between the steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Floats
from stlc.errors import UsageError
from stlc.mission import Mission
from stlc.plan import Plan
from stlc.verify.paths import Path
from stlc.verify.robots import drives, true_paths

FRAME = "map"
"""What places are said to be in, where a format asks for a name."""

MOST_SAMPLES = 1_000_000  # of one agent: what a reader of any of the formats still opens

_AT_REST = 1e-6
"""Metres a second below which a direction would be rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Tracks:
    """`times` (K,) [s], the last step among them, and places (K, 2) or (K, 3) [m] by agent.

    Those of robots are where they drive, `own` their headings (K,) [rad].
    """

    times: Floats
    places: Mapping[str, Floats]
    paths: Mapping[str, Path]
    own: Mapping[str, Floats]

    def speeds(self, agent: str, step: float) -> Floats:
        """Velocities (K, 2) or (K, 3) [m/s]."""
        path = self.paths[agent]
        along = self.times / step * path.pieces
        row = np.clip(np.floor(along).astype(np.intp), 0, len(path.c0) - path.pieces - 1)
        s = (along - row)[:, None]
        return np.asarray((path.c1[row] + 2.0 * s * path.c2[row]) * path.pieces / step)

    def headings(self, agent: str, step: float) -> Floats:
        """Which way an agent moves (K,) [rad]; one at rest keeps its heading, 0 at first. A robot
        has its own."""
        if agent in self.own:
            return self.own[agent]
        vx, vy = self.speeds(agent, step)[:, :2].T
        moves = np.hypot(vx, vy) > _AT_REST
        last = np.maximum.accumulate(np.where(moves, np.arange(len(moves)), -1))
        return np.where(last < 0, 0.0, np.arctan2(vy, vx)[last])


def nano(seconds: float) -> int:
    """Nanoseconds, as recordings count."""
    return round(seconds * 1e9)


def tracks(mission: Mission, plan: Plan, every: float | None) -> Tracks:
    """Of all agents that are somewhere. UsageError where there is none, or far too many samples."""
    motion = true_paths(mission, plan)
    agents = [name for name in mission.agents if name in motion]
    if not agents:
        raise UsageError("no agent has a position: there is nothing to export")
    last, gap = plan.horizon * plan.step, every or plan.step
    if last / gap > MOST_SAMPLES:
        raise UsageError(f"that would be {last / gap:.3g} samples of each agent; take longer steps")
    times = np.arange(0.0, last - 1e-9 * gap, gap)
    times = np.append(times, last)
    places = {name: motion[name].at(times / plan.step) for name in agents}
    driven = drives(mission, plan.runs, plan.executed)
    own = {name: d.heading_at(times / plan.step) for name, d in driven.items()}
    return Tracks(times, places, {name: motion[name] for name in agents}, own)
