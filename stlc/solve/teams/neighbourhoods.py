"""Better plans for teams: a few agents answer the others anew (large neighbourhood search).

One agent, then two or three that meet, are free; the others are held to the plan (Shaw, Using
constraint programming and local search methods to solve vehicle routing problems, 1998). Those
with the latest changes come first, and a neighbourhood is left alone while nothing near it has
changed since it had nothing better to offer. In between all continuous columns of the whole model
are let go at once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations

from stlc.mission import TermKind
from stlc.solve import tuning
from stlc.solve.alone.run import Run
from stlc.solve.deadline import Deadline
from stlc.solve.strategy import Strategy, Work
from stlc.solve.teams.answers import Answers, Effort
from stlc.solve.teams.turns import NEEDED, Turns
from stlc.solve.teams.whole import completed

Free = tuple[str, ...]

_LEAST = 1e-4  # relative: runs that are held to within 1e-5 differ by less than this in cost


@dataclass(slots=True, eq=False)
class Neighbourhoods:
    """A plan `runs`, better and better; `worth` is the least improvement that counts."""

    answers: Answers
    deadline: Deadline
    runs: dict[str, Run]
    worth: float
    gap: float
    _met: dict[Free, frozenset[str]] = field(default_factory=dict)
    _seen: dict[Free, int] = field(default_factory=dict)  # the change at which it was last solved
    _changed: dict[str, int] = field(default_factory=dict)  # the last change of each agent
    _changes: int = 1

    def sweep(self, size: int) -> bool:
        """Free so many agents at a time; whether any of them bettered the plan."""
        return any([self._better(free) for free in list(self._groups(size))])

    def _groups(self, size: int) -> Iterator[Free]:
        """Single agents, or groups that meet; those with the latest changes first."""
        near = {name: self._met.get((name,), frozenset()) for name in self.runs}
        groups = [
            free
            for free in combinations(self.runs, size)
            if size == 1 or all(_meets(name, free, near) for name in free)
        ]
        groups.sort(key=lambda free: -max(self._changed.get(name, 0) for name in free))
        yield from groups

    def _is_stale(self, free: Free) -> bool:
        """Whether something has changed nearby since it was last looked at."""
        seen = self._seen.get(free, 0)
        near = {*free, *self._met.get(free, ())}
        return not seen or any(self._changed.get(name, 0) > seen for name in near)

    def _better(self, free: Free) -> bool:
        """Take the best that the agents `free` can do against the others, if it is better."""
        if self.deadline.over() or not self._is_stale(free):
            return False
        moment = self.deadline.share(tuning.NEAR.share, tuning.NEAR.seconds)
        met = self._met.get(free, frozenset())
        answer = self.answers.find(free, self.runs, Effort(moment, self.gap), met)
        self._met[free] = answer.met
        self._seen[free] = self._changes
        if answer.runs is None or not answer.gain > self.worth:
            return False
        self.runs |= answer.runs
        self._changes += 1
        self._changed.update(dict.fromkeys(free, self._changes))
        return True


def _meets(name: str, free: Free, near: Mapping[str, frozenset[str]]) -> bool:
    others = set(free) - {name}
    return bool(near[name] & others) or any(name in near[other] for other in others)


@dataclass(slots=True, eq=False)
class Improvement:
    """The search from the incumbent of a work, points reported as they come."""

    work: Work
    deadline: Deadline

    def run(self) -> Work:
        """The work with the best point found."""
        self._take_alone()
        if self.work.x is None or self.work.proven():
            return self.work
        search, size = self._from_incumbent(), 1
        while size <= tuning.NEAR.agents and not (self.deadline.over() or self.work.proven()):
            before = self.work.value
            if search.sweep(size):
                self._take(search.runs, "neighbourhoods")
                search.runs = self._runs()
            size = 1 if self.work.value < before - search.worth else size + 1
        return self.work

    def _take_alone(self) -> None:
        """A plan of what agents do alone, as far as that gets along."""
        alone = {one.agent: one.run for one in self.work.lone if one.run is not None}
        if not alone or self._take(alone, "agents alone"):
            return
        deadline = self.deadline.share(tuning.NEAR.alone)
        runs = Turns(Answers.of(self.work), deadline, alone).plan(list(self.work.compiled.states))
        if runs is not None:
            self._take(runs, "turns")

    def _from_incumbent(self) -> Neighbourhoods:
        value, gap = abs(self.work.value), self.work.options.gap
        worth = max(tuning.NEAR.worth * gap * value, _LEAST * (1 + value))
        answers = Answers.of(self.work)
        gap = max(gap, tuning.NEAR.gap)
        return Neighbourhoods(answers, self.deadline, self._runs(), worth, gap)

    def _runs(self) -> dict[str, Run]:
        assert self.work.x is not None
        made = self.work.compiled.decode(self.work.x)
        return {name: (made.states[name], made.inputs[name]) for name in made.states}

    def _take(self, runs: Mapping[str, Run], finder: str) -> bool:
        """Complete runs of all agents; whether they make a better plan."""
        work = self.work
        if not runs.keys() >= work.compiled.states.keys():
            return False
        asked = work.deadline.bind(work.options)
        found = completed(work.compiled, runs, work.backend, asked)
        self.work = work.with_point(found, finder)
        return self.work is not work


def _improve(work: Work) -> Work:
    priced = TermKind.LINK_COST in _kinds(work)
    share = tuning.NEAR.priced if priced else tuning.NEAR.effort
    return Improvement(work, work.deadline.share(share, tuning.NEAR.most)).run()


def _kinds(work: Work) -> set[TermKind]:
    return {term.kind for term in work.compiled.mission.objective if term.weight != 0}


def _may_improve(work: Work) -> bool:
    """A team with a plan, or with what its agents do alone, that costs effort or links; pairs that
    pay for their link have `link_search.py`."""
    kinds, agents = _kinds(work), len(work.compiled.mission.agents)
    pair = agents == 2 and TermKind.LINK_COST in kinds
    team = agents > 1 and not pair and TermKind.ROBUSTNESS not in kinds
    known = work.x is not None or bool(work.lone)
    return team and bool(kinds) and known and work.can(NEEDED)


NEIGHBOURHOODS = Strategy("neighbourhoods", _may_improve, _improve)
