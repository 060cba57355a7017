"""First plans: agents routed one after the other, each against those before it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.milp.compile import Compiled
from stlc.solve.routes.beam import Beam, Run
from stlc.solve.routes.controls import cell_sizes, reach_of
from stlc.solve.routes.destinations import Places
from stlc.solve.routes.moves import Judge, LevelOf
from stlc.solve.routes.progress import Progress
from stlc.solve.routes.step_costs import StepCosts
from stlc.trajectories import Trajectories

_NOBODY = Trajectories({}, {})


@dataclass(frozen=True, slots=True)
class Effort:
    """How to search: states that are kept, parts of each input's range, the share of a cell by
    which predicates may be missed, the weight of the way that is still to go."""

    width: int
    parts: int
    miss: float
    greed: float


@dataclass(frozen=True, slots=True, eq=False)
class Routes:
    """Searches for runs of a compiled mission's agents."""

    compiled: Compiled
    levels: Sequence[LevelOf]
    progress: Progress
    over: Callable[[], bool]

    @staticmethod
    def of(compiled: Compiled, over: Callable[[], bool]) -> Routes:
        """At the margins of the requirements."""
        encoded = compiled.layout.encoded
        progress = Progress.of((one.formula, k) for k, one in enumerate(encoded))
        return Routes(compiled, [_margin(one.level.margin) for one in encoded], progress, over)

    def team(self, effort: Effort) -> Trajectories | None:
        """Runs of all agents that get along; who finds no way goes first in the next round."""
        order = list(self.compiled.mission.agents)
        for _ in range(len(order)):
            runs = _NOBODY
            for name in order:
                run = self.run(name, runs, effort)
                if run is None:
                    break
                runs = Trajectories({**runs.states, name: run[0]}, {**runs.inputs, name: run[1]})
            else:
                return runs
            if name == order[0] or self.over():
                return None
            order.remove(name)
            order.insert(0, name)
        return None

    def run(self, name: str, others: Trajectories, effort: Effort) -> Run | None:
        """A run of one agent that keeps all that is said of it and the others, or None."""
        mission, agent = self.compiled.mission, self.compiled.mission.agents[name]
        ranges = self.compiled.ranges[name]
        cell = cell_sizes(agent, ranges, effort.parts)
        miss = effort.miss * self.spacing(name, effort.parts)
        judge = Judge(mission, self.compiled.channels, self.levels, others, miss)
        low, high = (
            ranges.position_lower[:, :2].min(axis=0),
            ranges.position_upper[:, :2].max(axis=0),
        )
        places = Places.of(self.progress, judge, agent, low, high, mission.horizon)
        costs, reach = StepCosts(mission, agent, judge), reach_of(agent, ranges)
        price = effort.greed * costs.per_metre(float(reach[0, -1]) / mission.horizon)
        return Beam(
            mission, agent, ranges, self.progress, judge, places, costs.of, reach, effort.width,
            effort.parts, cell, price, self.over,
        ).run()  # fmt: skip

    def spacing(self, name: str, parts: int) -> float:
        """Distance [m] between neighbouring states of a search."""
        agent = self.compiled.mission.agents[name]
        cell = cell_sizes(agent, self.compiled.ranges[name], parts)
        position = agent.dynamics.position
        assert position is not None
        placed = np.abs(position).sum(axis=0) > 0
        return float(cell[placed].max())


def _margin(value: float) -> LevelOf:
    return lambda unit: value
