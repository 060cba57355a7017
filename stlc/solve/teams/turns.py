"""First plans for teams: one agent after the other (prioritised planning).

Each agent keeps to what is planned already (Erdmann and Lozano-Perez, On Multiple Moving Objects,
1987). One that can't is planned anew together with an agent in its way (if links bind it, when it
fails again), or comes first in the next order; then orders are drawn at random. Nothing is proven
here: what was found is completed to a point of the whole model.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.arrays import Floats
from stlc.solve import tuning
from stlc.solve.crew.crew import Job
from stlc.solve.deadline import Deadline
from stlc.solve.strategy import Work
from stlc.solve.teams.answers import Answer, Answers, Effort, Runs
from stlc.solve.teams.corridors import extent
from stlc.solve.teams.whole import completed


@dataclass(frozen=True, slots=True, eq=False)
class Turns:
    """A search for runs of all agents that get along.

    `alone` are runs that agents keep to where they get along with what is planned; without any,
    the first run that is found will do for each."""

    answers: Answers
    deadline: Deadline
    alone: Runs = field(default_factory=dict)

    def plan(self, names: Sequence[str]) -> Runs | None:
        """Runs of these agents, None where none were found."""
        first: list[str] = []
        for order in self._orders(names, first):
            runs = self._in_turn(order, first)
            if runs is not None or self.deadline.over() or len(first) > len(names) ** 2:
                return runs
        return None

    def _orders(self, names: Sequence[str], first: Sequence[str]) -> Iterator[list[str]]:
        """As given, then with who failed in front (the last first), then the others shuffled."""
        rng = np.random.default_rng(self.answers.options.seed or 0)
        rest = list(names)
        while True:
            urgent = list(dict.fromkeys(reversed(first)))
            yield urgent + [name for name in rest if name not in urgent]
            if len(first) > len(names):
                rest = [names[int(k)] for k in rng.permutation(len(names))]

    def _in_turn(self, order: Sequence[str], failed: list[str]) -> Runs | None:
        """Runs planned in this order; who has none is added to `failed`. For agents bound by links
        another order is mostly cheaper than two at once, which they get when they fail again: the
        first plan of prr_a4 took 3.6 s, else 14.5 s."""
        runs: dict[str, tuple[Floats, Floats]] = {}
        for name in order:
            if self._keeps(name, runs):
                runs[name] = self.alone[name]
                continue
            answer = self._any((name,), runs)
            found = answer.runs
            again = name in failed or not self.answers.couplings.bound[name]
            if found is None and answer.met and again:
                found = self._together(name, runs, answer)
            if found is None:
                failed.append(name)
                return None
            runs |= found
        return runs

    def _any(self, free: Sequence[str], runs: Runs) -> Answer:
        return self.answers.crew.drive([self._finding(free, runs, frozenset())])[0]

    def _beside(self, free: Sequence[str], runs: Runs, met: frozenset[str]) -> Job[Answer]:
        """Runs near those that agents have alone, in wider and wider tubes; good ones but in the
        widest, where any will do."""
        near, size = tuning.TURNS.beside, extent(self.answers.compiled)
        answer = Answer(None, met, settled=False)
        for part in near:
            moment = self.deadline.share(tuning.TURNS.share, tuning.TURNS.brief)
            effort = Effort(moment, tuning.TURNS.good, part == near[-1], self.alone, part * size)
            answer = yield from self.answers.finding(free, runs, effort, answer.met)
            if answer.runs is not None:
                break
        return answer

    def _finding(self, free: Sequence[str], runs: Runs, met: frozenset[str]) -> Job[Answer]:
        """In a crowd a good run for an agent that nobody is bound to: ones that wander get into
        others' way. Else, or where that takes long, any run (a good one beside those that agents
        have alone, and near those if any is)."""
        if self.alone.keys() >= set(free):
            answer = yield from self._beside(free, runs, met)
            if answer.runs is not None or len(free) > 1:
                return answer
            met = answer.met
        moment = self.deadline.share(tuning.TURNS.share, tuning.TURNS.seconds)
        find, rough = self.answers.finding, not self.alone
        bound = self.answers.couplings.bound
        crowd = len(bound) >= tuning.TURNS.crowd and not any(bound[name] for name in free)
        if rough and crowd and len(free) == 1:
            brief = moment.within(tuning.TURNS.brief)
            answer = yield from find(free, runs, Effort(brief, tuning.TURNS.good))
            if answer.runs is not None or answer.settled:
                return answer
            met = answer.met
        gap = tuning.TURNS.rough if rough else tuning.TURNS.fine
        return (yield from find(free, runs, Effort(moment, gap, rough), met))

    def _keeps(self, name: str, runs: Runs) -> bool:
        """Whether an agent's run alone gets along with those that are planned."""
        couplings = self.answers.couplings
        if name not in self.alone or couplings.bound[name] & runs.keys():
            return False
        with_it = {**runs, name: self.alone[name]}
        return all(couplings.get_along(name, other, with_it) for other in runs)

    def _together(self, name: str, runs: Runs, answer: Answer) -> Runs | None:
        """The agent with one of those that it met planned anew, bound ones before others; where
        several are tried at once, the first of them that did."""
        bound, crew = self.answers.couplings.bound[name], self.answers.crew
        others = sorted(answer.met, key=lambda o: (o not in bound, list(runs).index(o)))
        others = others[: tuning.TURNS.partners]
        for k in range(0, len(others), crew.size):
            jobs = [self._joined(name, o, runs, answer) for o in others[k : k + crew.size]]
            made = next((a.runs for a in crew.drive(jobs) if a.runs is not None), None)
            if made is not None:
                return made
        return None

    def _joined(self, name: str, other: str, runs: Runs, answer: Answer) -> Job[Answer]:
        kept = {n: run for n, run in runs.items() if n != other}
        return self._finding((name, other), kept, answer.met - {other})


def plan_in_turns(work: Work) -> Work:
    """The work with a first plan, if one is found in time."""
    deadline = work.deadline.share(tuning.TURNS.all, tuning.TURNS.most)
    answers = Answers.of(work)
    runs = Turns(answers, deadline).plan(list(work.compiled.states))
    if runs is None:
        return work
    asked = work.deadline.bind(work.options)
    return work.with_point(completed(work.compiled, runs, work.backend, asked), "turns")
