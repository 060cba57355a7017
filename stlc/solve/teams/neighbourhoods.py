"""Better plans for teams: a few agents answer the others anew (large neighbourhood search).

One agent, then two or three that meet, are free; the others are held to the plan (Shaw, Using
constraint programming and local search methods to solve vehicle routing problems, 1998). Those
with the latest changes come first, and a neighbourhood is left alone while nothing near it has
changed since it had nothing better to offer. In between all continuous columns of the whole model
are let go at once.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from stlc.solve import tuning
from stlc.solve.alone.run import LoneRun, Run
from stlc.solve.crew.crew import Job
from stlc.solve.deadline import Deadline
from stlc.solve.teams.answers import Answer, Answers, Effort

Free = tuple[str, ...]
_SAME = 1e-4  # of states and inputs: runs are held to within a tenth of that


@dataclass(slots=True, eq=False)
class Neighbourhoods:
    """A plan `runs`, better and better; `worth` is the least improvement that counts.

    `lone` are agents alone, where that is known, and `spare` is how much less each might cost:
    agents that cost no more than alone are left as they are."""

    answers: Answers
    deadline: Deadline
    runs: dict[str, Run]
    worth: float
    gap: float
    lone: Mapping[str, LoneRun]
    spare: dict[str, float]
    _met: dict[Free, frozenset[str]] = field(default_factory=dict)
    _seen: dict[Free, int] = field(default_factory=dict)  # the change at which it was last solved
    _changed: dict[str, int] = field(default_factory=dict)  # the last change of each agent
    _changes: int = 1

    def follow(self, runs: Mapping[str, Run], spare: Mapping[str, float]) -> None:
        """Go on from another plan."""
        moved = [name for name, run in runs.items() if not _alike(run, self.runs[name])]
        self.runs, self.spare = dict(runs), dict(spare)
        self._note(moved)

    def sweep(self, size: int) -> bool:
        """Free so many agents at a time; whether any of them bettered the plan.

        Several groups are looked at together where the crew is large. What one of them has bettered
        is known to those behind it, which are looked at again then: the plan is that of one group
        after the other."""
        todo, bettered = list(self._groups(size)), False
        while todo and not self.deadline.over():
            todo = [free for free in todo if self._is_stale(free)]
            some = todo[: self.answers.crew.size]
            jobs = [self._looking(free, len(todo) - k) for k, free in enumerate(some)]
            for free, answer in zip(some, self.answers.crew.drive(jobs), strict=True):
                todo.remove(free)
                if self._takes(free, answer):
                    bettered = True
                    break
        return bettered

    def _groups(self, size: int) -> Iterator[Free]:
        """Single agents, or groups that meet, with something to spare; those with the most first,
        then those with the latest changes."""
        near = {name: self._met.get((name,), frozenset()) for name in self.runs}
        groups = [
            free
            for free in combinations(self.runs, size)
            if self._spare(free) > self.worth
            and (size == 1 or all(_meets(name, free, near) for name in free))
        ]
        groups.sort(key=lambda free: -max(self._changed.get(name, 0) for name in free))
        yield from sorted(groups, key=lambda free: -self._spare(free))

    def _spare(self, free: Free) -> float:
        return sum(self.spare.get(name, np.inf) for name in free)

    def _is_stale(self, free: Free) -> bool:
        """Whether something has changed nearby since it was last looked at."""
        seen = self._seen.get(free, 0)
        near = {*free, *self._met.get(free, ())}
        return not seen or any(self._changed.get(name, 0) > seen for name in near)

    def _looking(self, free: Free, left: int) -> Job[Answer]:
        """The best that the agents `free` can do against the others; `left` groups share the
        time."""
        near, part = tuning.NEAR, self.deadline.left * self.answers.crew.size / (1 + left)
        moment = self.deadline.within(min(max(part, near.least), near.seconds))
        effort, met = Effort(moment, self.gap), self._in_the_way(free)
        return (yield from self.answers.finding(free, self.runs, effort, met))

    def _takes(self, free: Free, answer: Answer) -> bool:
        """Whether an answer betters the plan, which has it then."""
        self._met[free] = answer.met
        self._seen[free] = self._changes
        if answer.runs is None or not answer.gain > self.worth:
            return False
        self.runs |= answer.runs
        part = answer.gain / self._spare(free)
        self.spare.update({n: (1 - part) * self.spare[n] for n in free if n in self.spare})
        self._note(free)
        return True

    def _in_the_way(self, free: Free) -> frozenset[str]:
        """Who was met before, and who is where the free agents would be alone."""
        alone = {n: one.run for n in free if (one := self.lone.get(n)) and one.run is not None}
        runs, alike = {**self.runs, **alone}, self.answers.couplings.get_along
        crossed = (o for o in self.runs if not all(alike(n, o, runs) for n in alone))
        return self._met.get(free, frozenset()) | frozenset(crossed)

    def _note(self, moved: Iterable[str]) -> None:
        """Take note of agents whose runs have changed."""
        self._changes += 1
        self._changed.update(dict.fromkeys(moved, self._changes))


def _alike(one: Run, other: Run) -> bool:
    return all(np.allclose(a, b, atol=_SAME, rtol=0.0) for a, b in zip(one, other, strict=True))


def _meets(name: str, free: Free, near: Mapping[str, frozenset[str]]) -> bool:
    others = set(free) - {name}
    return bool(near[name] & others) or any(name in near[other] for other in others)
