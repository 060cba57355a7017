"""What each agent spends alone at the least, by the way it moves: grids (`play.py`) for those that
go where their inputs say, visits (`visit_bound.py`) for those with inertia.

Effort is never negative, so agents that neither speaks of count as free of cost. Each bound is a
row of the model as well.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from stlc.backends.base import Solution
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.mission import TermKind
from stlc.solve import tuning
from stlc.solve.alone.effort_rows import bounded, safe
from stlc.solve.alone.run import LoneRun
from stlc.solve.deadline import Deadline
from stlc.solve.relaxation.bodies import body_of
from stlc.solve.routes.box_atoms import places_of
from stlc.solve.routes.finder import Routes
from stlc.solve.routes.grid_beam import Crossings, GridBeam
from stlc.solve.routes.loose import fits
from stlc.solve.routes.moves import Judge
from stlc.solve.routes.nearby import FINDER, solved
from stlc.solve.routes.play import MOST_MOVES, Play, play_of
from stlc.solve.routes.traced import traced
from stlc.solve.routes.tube import within
from stlc.solve.routes.visit_bound import Climb, Priced
from stlc.solve.routes.visits import Search, kinds_of
from stlc.solve.strategy import Work
from stlc.trajectories import Trajectories

_NOBODY = Trajectories({}, {})


@dataclass(frozen=True, slots=True, eq=False)
class Bounds:
    """What is known of each agent's share: `lone[name]`, proven for plans that cost less than the
    best known; `visits[name]` is the graph of those with inertia."""

    grids: Routes
    lone: Mapping[str, float]
    visits: Mapping[str, Climb]
    plays: dict[tuple[str, int], Play] = field(default_factory=dict)  # by agent and cut

    @staticmethod
    def of(compiled: Compiled, over: Callable[[], bool]) -> Bounds | None:
        """Nothing known yet; None where the objective is more than effort."""
        if not only_effort(compiled):
            return None
        grids, visits = Routes.of(compiled, over), dict[str, Climb]()
        for name in compiled.mission.agents:
            graph = None if fits(compiled, name) else visits_of(grids, name)
            if graph is not None:
                visits[name] = Climb(graph)
        return Bounds(grids, {}, visits)

    def says_nothing(self) -> bool:
        """Whether no agent moves in a way that has a bound."""
        return not self.visits and not self.gridded

    def promises(self, value: float, part: float) -> bool:
        """Whether bounds are soon near that part of what a plan costs: visits of one agent by a
        first look."""
        if self.gridded or len(self.visits) != 1 or not np.isfinite(value):
            return True
        for climb in self.visits.values():
            climb.guess(self.grids.over)
        known = sum(max(climb.best, 0.0) for climb in self.visits.values())
        return known >= part * (value - self.grids.compiled.model.offset)

    def hopeless(self) -> bool:
        """Whether some agent can't make its visits: there is no plan."""
        return any(not climb.graph.possible for climb in self.visits.values())

    def visiting(self, compiled: Compiled, room: float, over: Callable[[], bool]) -> Model | None:
        """The model with visits where the cheapest ways have them, or up to `room` steps away;
        None where there are none."""
        if not self.visits:
            return None
        model = compiled.model
        lower, upper = model.col_lower.copy(), model.col_upper.copy()
        for name, climb in self.visits.items():
            found, body = climb.guess(over), climb.graph.body
            boxes = climb.graph.ways.boxes[found[:, 0]]
            for d, axis in enumerate(body.axes):
                columns = compiled.states[name][found[:, 1], axis.state]
                wide = room * float(np.abs(axis.box[:, 2:]).max())
                lower[columns] = np.maximum(lower[columns], boxes[:, d, 0] - wide)
                upper[columns] = np.minimum(upper[columns], boxes[:, d, 1] + wide)
        return replace(model, col_lower=np.minimum(lower, upper), col_upper=upper)

    def guided(self, work: Work, over: Callable[[], bool]) -> Work:
        """The work with a plan of, or near, runs from crossing to crossing that are found soon: one
        agent after the other, alone where it finds none beside those before it."""
        for width, greed in tuning.ROUTES.grid_beams:
            beams, others = dict[str, Play](), _NOBODY
            for name in self.gridded:
                grid = self._grid(work, name, tuning.ROUTES.cuts[0], np.inf, over)
                boards = [self._crossings(grid, work, o) for o in dict.fromkeys((others, _NOBODY))]
                tries = (GridBeam(c, np.inf, over, grid.places, width=width, greed=greed)
                         for c in boards if grid.size() <= MOST_MOVES)  # fmt: skip
                found = next((beam for beam in tries if beam.finds()), None)
                if found is None:
                    break
                beams[name], others = found, _with(others, found)
            else:
                work = _beside(work, beams)
            if work.x is not None or over():
                break
        return work

    def _crossings(self, grid: Play, work: Work, others: Trajectories) -> Crossings:
        """The board for exact moves, beside agents that are planned."""
        compiled, board = work.compiled, grid.board
        judge = Judge(compiled.mission, compiled.channels, self.grids.levels, others)
        return Crossings(
            board.agent, board.progress, judge, board.lower, board.upper, board.lines, board.prices
        )

    def better(self, work: Work, share: float) -> Work | Solution:
        """The work with the best bounds that there is time for, as rows too, and with plans that
        lie near the runs they are of, or that there is none; `share` of the time that is left."""
        deadline = work.deadline.share(share, tuning.ROUTES.bound_seconds)
        lone = dict(self.lone)
        for name, climb in self.visits.items():
            lone[name] = climb.bound(_left(work, lone, name), deadline.over)
        found = _told(work, lone)
        if self.gridded:
            found = self._by_grids(found, self.gridded, lone, deadline)
            if np.isposinf(found.bound):
                return found.without_plan("runs over grids")
        return _with_rows(found, lone)

    def _by_grids(
        self, work: Work, names: list[str], lone: dict[str, float], deadline: Deadline
    ) -> Work:
        """Finer and finer grids, `lone` kept up to date; plans near the runs of each."""
        for cut in self._cuts(work, names):
            began, grids = time.monotonic(), dict[str, Play]()
            for name in names:
                most = _left(work, lone, name)
                grid = grids[name] = self._grid(work, name, cut, most, deadline.over)
                found = grid.bound() if grid.size() <= MOST_MOVES else None
                if found is None:
                    return _told(work, lone)
                if np.isposinf(found):
                    return work.with_bound(found)
                lone[name] = max(found, lone.get(name, 0.0))
                work = _told(work, lone)
            if not work.proven():
                work = _beside(work, grids)
            if work.proven() or deadline.left < tuning.ROUTES.growth * (time.monotonic() - began):
                break
        return work

    @property
    def gridded(self) -> list[str]:
        """The agents whose inputs move them directly."""
        compiled = self.grids.compiled
        return [name for name in compiled.mission.agents if fits(compiled, name)]

    def _cuts(self, work: Work, names: list[str]) -> list[int]:
        """Those of the tuning but for the ones whose next is hardly more to judge."""
        sizes = [
            sum(self._grid(work, n, cut, np.inf, work.deadline.over).size() for n in names)
            for cut in tuning.ROUTES.cuts
        ]
        ahead = [*sizes[1:], np.inf]
        return [c for c, size, more in zip(tuning.ROUTES.cuts, sizes, ahead, strict=True)
                if more > tuning.ROUTES.hardly * size]  # fmt: skip

    def _grid(self, work: Work, name: str, cut: int, most: float, over: Callable[[], bool]) -> Play:
        grids = self.grids
        if (name, cut) not in self.plays:
            self.plays[name, cut] = play_of(
                work.compiled, name, grids.progress, grids.levels, cut, most, over
            )
        return replace(self.plays[name, cut], most=most, over=over, layers=[])


def _with(others: Trajectories, beam: GridBeam) -> Trajectories:
    """Planned agents and the one whose run a beam has found."""
    run, board = traced(beam), beam.board
    assert run is not None
    assert isinstance(board, Crossings)
    inputs = {**others.inputs, board.agent.name: board.inputs(run[0][:-1], run[0][1:])}
    return Trajectories({**others.states, board.agent.name: run[0]}, inputs)


def _beside(work: Work, grids: Mapping[str, Play]) -> Work:
    """The work with a plan near the runs that the bounds of grids are of, if there is one."""
    boxes = {name: run for name, grid in grids.items() if (run := traced(grid)) is not None}
    wide = max(float(grid.widest) for grid in grids.values())
    for room, steps in tuning.ROUTES.beside if boxes else ():
        near = within(work.compiled, boxes, room * wide, steps)
        found = solved(work, near, tuning.ROUTES.repair_seconds, work.options.gap)
        if found is not None and found.x is not None:
            return work.with_point(found.x, FINDER)
    return work


def only_effort(compiled: Compiled) -> bool:
    """Whether the objective is nothing but effort, which is never negative."""
    terms = [term for term in compiled.mission.objective if term.weight != 0]
    return all(term.kind is TermKind.EFFORT and term.weight > 0 for term in terms) and bool(terms)


def visits_of(grids: Routes, name: str) -> Priced | None:
    """The graph of an agent with inertia; None where its axes are no chains or it is too large."""
    compiled = grids.compiled
    efforts = [term for term in compiled.mission.objective if term.kind is TermKind.EFFORT]
    body = body_of(compiled, compiled.mission.agents[name], efforts)
    if body is None or any(axis.speed is None for axis in body.axes):
        return None
    if not any(axis.change_cost.min() > 0 for axis in body.axes):
        return None
    place, boxes = places_of(compiled, name, grids.progress, grids.levels, body)
    kinds = kinds_of(boxes)
    if kinds is None:
        return None
    search = Search(body, grids.progress, place, kinds, grids.over)
    for told in (True, False):
        ways = replace(search, told=told).ways()
        if ways is not None:
            return Priced(body, ways)
    return None


def _left(work: Work, lone: Mapping[str, float], name: str) -> float:
    """What an agent may spend in a plan that is better than the best known."""
    return work.value - work.compiled.model.offset - sum(v for n, v in lone.items() if n != name)


def _told(work: Work, lone: Mapping[str, float]) -> Work:
    found = work.with_bound(work.compiled.model.offset + sum(map(safe, lone.values())))
    found.report()
    return found


def _with_rows(work: Work, lone: Mapping[str, float]) -> Work:
    rows = [LoneRun(name, bound, None) for name, bound in lone.items()]
    return replace(work, compiled=bounded(work.compiled, rows))
