"""The strategy `neighbourhoods`: a plan of a team, better and better.

What agents do alone is a plan where it gets along; where it nearly does, the whole model within a
tube around it mostly holds one that costs little more. Then a few agents answer the others anew,
and the whole model is solved within tubes around the incumbent, in turn.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from stlc.mission import TermKind
from stlc.solve import tuning
from stlc.solve.alone.run import Run
from stlc.solve.deadline import Deadline, Stopwatch
from stlc.solve.strategy import Work
from stlc.solve.teams.answers import Answers
from stlc.solve.teams.corridors import Corridor, beside
from stlc.solve.teams.couplings import Couplings
from stlc.solve.teams.neighbourhoods import Neighbourhoods
from stlc.solve.teams.turns import Turns
from stlc.solve.teams.whole import completed

_LEAST = 1e-4  # relative: runs that are held to within 1e-5 differ by less than this in cost


@dataclass(slots=True, eq=False)
class Improvement:
    """The search from the incumbent of a work, points reported as they come.

    It ends when for `patience` times as long as the best plan took nothing better was found.
    """

    work: Work
    deadline: Deadline
    priced: bool  # links cost: whole models are large then
    patience: float = math.inf
    watch: Stopwatch = field(default_factory=Stopwatch)
    took: float = 0.0  # s, for the best plan so far

    def run(self) -> Work:
        """The work with the best point found."""
        self._take_alone()
        if self.work.x is not None and not self._is_near():
            self._descend()
        if self.work.x is not None and self._is_near() and not self.work.proven():
            search = self._from_incumbent(self.work.options.gap)
            search.sweep(1)
            self._take(search.runs, "neighbourhoods")
        return self.work

    def _descend(self) -> None:
        """Larger and larger neighbourhoods, tubes in between, until nothing betters the plan."""
        search, size = self._from_incumbent(tuning.NEAR.gap), 1
        corridor = Corridor(idle=self.priced)
        most = min(tuning.NEAR.agents, len(search.runs) - 1)  # all of them are the mission itself
        while not (self._patient().over() or self._is_near()):
            before = self.work.value
            if not corridor.idle:
                self.work = corridor.better(self.work, self._moment())
                search.follow(self._runs(), self._spare())
            if size <= most and search.sweep(size):
                self._take(search.runs, "neighbourhoods")
                search.follow(self._runs(), self._spare())
                corridor = corridor if self.priced else corridor.moved()
            bettered = self.work.value < before - search.worth
            size = 1 if bettered else size + 1
            self.took = self.watch.seconds if bettered else self.took
            if corridor.idle and size > most:
                break

    def _is_near(self) -> bool:
        """Whether the plan is as near the bound as answers come: only exact ones tell more."""
        slack = tuning.NEAR.gap * abs(self.work.value)
        return self.work.proven() or self.work.bound >= self.work.value - slack

    def _patient(self) -> Deadline:
        until = (1.0 + self.patience) * max(self.took, tuning.NEAR.moment)
        return self.deadline.within(until - self.watch.seconds)

    def _moment(self) -> Deadline:
        part = min(tuning.NEAR.share * self.deadline.left, tuning.NEAR.seconds)
        return self._patient().within(part)

    def _take_alone(self) -> None:
        """A plan of what agents do alone: as it is, nearby, or as far as that gets along."""
        alone = {one.agent: one.run for one in self.work.lone if one.run is not None}
        if not alone or self._take(alone, "agents alone"):
            return
        bound = any(Couplings.of(self.work.compiled).bound.values())
        complete = alone.keys() >= self.work.compiled.states.keys()
        if complete and not bound:
            self._plan_in_turn(alone)
        if complete and not (self.work.x is not None and self._is_near()):
            crowd = len(alone) >= tuning.LONE.crowd
            free = tuning.NEAR.crowd if crowd else tuning.NEAR.joint
            part = tuning.NEAR.bound if bound else free
            self.work = beside(self.work, alone, self.deadline.share(part))
        if self.work.x is None:
            self._plan_in_turn(alone)

    def _plan_in_turn(self, alone: Mapping[str, Run]) -> None:
        """A plan of one agent after the other, near what each does alone."""
        deadline = self.deadline.share(tuning.NEAR.alone)
        runs = Turns(Answers.of(self.work), deadline, alone).plan(list(self.work.compiled.states))
        if runs is not None:
            self._take(runs, "turns")

    def _from_incumbent(self, gap: float) -> Neighbourhoods:
        """A search whose answers come within that gap."""
        value, asked = abs(self.work.value), self.work.options.gap
        worth = max(tuning.NEAR.worth * asked * value, _LEAST * (1 + value))
        lone = {one.agent: one for one in self.work.lone}
        answers = Answers.of(self.work)
        runs, spare = self._runs(), self._spare()
        return Neighbourhoods(answers, self.deadline, runs, worth, max(gap, asked), lone, spare)

    def _runs(self) -> dict[str, Run]:
        assert self.work.x is not None
        made = self.work.compiled.decode(self.work.x)
        return {name: (made.states[name], made.inputs[name]) for name in made.states}

    def _spare(self) -> dict[str, float]:
        """How much more each agent costs than it does alone, where that is known."""
        x, model, columns = self.work.x, self.work.compiled.model, self.work.compiled.layout.effort
        assert x is not None
        own = {one.agent: columns[one.agent] for one in self.work.lone if one.agent in columns}
        bounds = {one.agent: one.bound for one in self.work.lone}
        return {name: float(model.c[k] @ x[k]) - bounds[name] for name, k in own.items()}

    def _take(self, runs: Mapping[str, Run], finder: str) -> bool:
        """Complete runs of all agents; whether they make a better plan."""
        work = self.work
        if not runs.keys() >= work.compiled.states.keys():
            return False
        asked = work.deadline.bind(work.options)
        found = completed(work.compiled, runs, work.backend, asked)
        self.work = work.with_point(found, finder)
        return self.work is not work


def improve(work: Work) -> Work:
    """The work with the best plan found in time."""
    priced = TermKind.LINK_COST in work.kinds
    patience = tuning.NEAR.pair if len(work.compiled.states) == 2 else math.inf
    share = tuning.NEAR.priced if priced else tuning.NEAR.effort
    deadline = work.deadline.share(share, tuning.NEAR.most)
    return Improvement(work, deadline, priced, patience).run()
