"""What a few agents spend without the others bounds their effort: rows for groups of agents.

    minimise effort of the agents S without the others  =  b_S
    ->  sum_{a in S} effort_a >= b_S

Groups are agents that are bound to each other by links, or whose lone runs do not get along; pairs
come first, then triples and so on while there is time. Links are loosened (`loosened.py`) and what
keeps agents apart that do not meet is left out: both ask for less, so rows cut off no plan. The
bounds of overlapping groups are put together by the best weights,

    max sum_S y_S b_S   with   sum_{S with a} y_S <= 1 for each agent a,  y >= 0
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from stlc.backends.base import Status
from stlc.errors import InfeasibleError
from stlc.ir.nodes import Const, Linear, Node
from stlc.ir.rewrite import rewrite
from stlc.milp.compile import Compiled, compile_mission
from stlc.mission import Mission
from stlc.solve import tuning
from stlc.solve.alone.effort_rows import safe, with_rows
from stlc.solve.alone.loosened import loosened
from stlc.solve.alone.pieces import Pieces
from stlc.solve.alone.project import project
from stlc.solve.crew.ask import Ask
from stlc.solve.crew.crew import Job
from stlc.solve.deadline import Deadline
from stlc.solve.strategy import Work
from stlc.solve.teams.couplings import Couplings

Group = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Part:
    """Agents that spend at least `bound` together."""

    agents: Group
    bound: float


def parted(
    compiled: Compiled,
    group: Group,
    meeting: Collection[frozenset[str]],
    pieces: Pieces | None = None,
) -> Mission:
    """The mission of a group without the others, links loosened; only the pairs `meeting` are
    kept apart."""
    mission = project(compiled.mission, group, compiled.channels, pieces)

    def left(node: Node) -> Node:
        if not isinstance(node, Linear):
            return node
        owners = frozenset(signal.owner for signal, _ in node.terms)
        kept = len(owners) < 2 or any(owners <= pair for pair in meeting)
        return node if kept else Const(True)

    requirements = mission.requirements
    formulas = rewrite([r.formula for r in requirements], left)
    kept = [replace(r, formula=f) for r, f in zip(requirements, formulas, strict=True)]
    return loosened(replace(mission, requirements=tuple(kept)), compiled.channels)


def bound_of(parts: Sequence[Part], agents: Sequence[str]) -> float:
    """A lower bound of what all agents spend: the best weights, made to fit exactly."""
    from scipy.optimize import linprog

    holds = np.array([[agent in part.agents for part in parts] for agent in agents], float)
    worth = np.array([part.bound for part in parts])
    found = linprog(-worth, A_ub=holds, b_ub=np.ones(len(agents)), bounds=(0, None))
    if found.x is None:
        return -np.inf
    weights = np.maximum(found.x, 0.0)
    weights /= max(1.0, float((holds @ weights).max()))
    return float(weights @ worth)


@dataclass(slots=True, eq=False)
class Parts:
    """Groups of growing size and their bounds, from those of single agents on."""

    work: Work
    deadline: Deadline
    couplings: Couplings
    meeting: frozenset[frozenset[str]]
    pieces: Pieces
    found: list[Part]

    @staticmethod
    def of(work: Work, deadline: Deadline) -> Parts:
        """Those of a solve under way that knows its agents alone."""
        couplings = Couplings.of(work.compiled)
        runs = {one.agent: one.run for one in work.lone if one.run is not None}
        alike = couplings.get_along
        meeting = [p for p in combinations(runs, 2) if not alike(*p, runs)]
        alone = [Part((one.agent,), safe(one.bound)) for one in work.lone]
        pieces = Pieces.of(work.compiled.mission)
        return Parts(work, deadline, couplings, frozenset(map(frozenset, meeting)), pieces, alone)

    def run(self) -> Work:
        """The work with the rows of all groups that the time allows for, and their bound."""
        agents = list(self.work.compiled.states)
        whole = any(self.couplings.bound.values())  # loosened, all together are a smaller model
        for size in range(2, len(agents) + whole):
            before = self.work
            self._bound_all(agents, size)
            if self.deadline.over() or self.work.proven():
                break
            if not whole and not self._pays_off(before):
                break
        return self._with_rows()

    def _bound_all(self, agents: Sequence[str], size: int) -> None:
        """Bound every group of that size, as many at once as there are hands."""
        groups, many = list(self._groups(agents, size)), self.work.crew.size
        for k in range(0, len(groups), many):
            if self.deadline.over() or self.work.proven():
                return
            left = -(-(len(groups) - k) // many)
            jobs = [self._solved(group, left) for group in groups[k : k + many]]
            self.found += [p for p in self.work.crew.drive(jobs) if p is not None]
            least = self.work.compiled.model.offset + bound_of(self.found, agents)
            self.work = self.work.with_bound(least)
            self.work.report()

    def _pays_off(self, before: Work) -> bool:
        """Whether the bound has come so much nearer to the plan that larger groups are worth it."""
        if before.x is None or not np.isfinite(before.bound):
            return True
        return self.work.bound - before.bound >= tuning.PARTS.gain * (before.value - before.bound)

    def _groups(self, agents: Sequence[str], size: int) -> Iterator[Group]:
        """Groups that hang together, by links or where lone runs meet."""
        for group in combinations(agents, size):
            reached, todo = {group[0]}, [group[0]]
            while todo:
                one = todo.pop()
                near = {o for o in group if o not in reached and self._is_tied(one, o)}
                reached |= near
                todo += sorted(near)
            if len(reached) == size:
                yield group

    def _is_tied(self, one: str, other: str) -> bool:
        return other in self.couplings.bound[one] or frozenset((one, other)) in self.meeting

    def _solved(self, group: Group, left: int) -> Job[Part | None]:
        """The bound of a group; so many rounds of groups share the time."""
        moment = self.deadline.share(1.0 / left, tuning.PARTS.seconds)
        options = replace(self.work.options, start=None, gap=tuning.PARTS.gap)
        try:
            mission = parted(self.work.compiled, group, self.meeting, self.pieces)
            team = with_parts(compile_mission(mission), self.found)
        except InfeasibleError:
            return None  # it shows again, and is told, when the whole mission is solved
        got = yield Ask(team.model, self.work.backend, options, moment)
        if got.bound is None or got.status not in _BOUNDED:
            return None
        return Part(group, safe(got.bound))

    def _with_rows(self) -> Work:
        groups = [part for part in self.found if len(part.agents) > 1]
        return replace(self.work, compiled=with_parts(self.work.compiled, groups))


_BOUNDED = (Status.OPTIMAL, Status.FEASIBLE, Status.NO_SOLUTION)


def with_parts(compiled: Compiled, parts: Sequence[Part]) -> Compiled:
    """The compiled mission with a row for each part whose agents are all there."""
    shares = compiled.layout.effort
    rows = [
        (np.concatenate([shares[agent] for agent in part.agents]), part.bound)
        for part in parts
        if shares.keys() >= set(part.agents)
    ]
    if not rows:
        return compiled
    return replace(compiled, model=with_rows(compiled.model, rows, "effort of a few agents"))


def bound_parts(work: Work) -> Work:
    """The work with rows for groups of agents, as many as there is time for."""
    deadline = work.deadline.share(tuning.PARTS.share, tuning.PARTS.most)
    return Parts.of(work, deadline).run()
