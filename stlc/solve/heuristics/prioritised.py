"""Plans for the whole team from the runs of its members alone.

All of them together, if they get along; else agents join one after the other, keeping to what is
planned (prioritised planning: Erdmann and Lozano-Perez, On Multiple Moving Objects, 1987); then
one agent after the other, and two at a time, answer the others best (coordinate descent).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

from stlc.arrays import Floats
from stlc.errors import InfeasibleError, SolverError
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.milp.model import Model
from stlc.solve import tuning
from stlc.solve.alone.bounds import bounded, brief, least
from stlc.solve.alone.project import project
from stlc.solve.alone.run import Run
from stlc.solve.certify import continuous_part
from stlc.solve.mip_start import hold
from stlc.solve.strategy import Strategy, Work

_LOOSE = 1e-5  # of a run that is held: well above the tolerance of solvers, or they stumble


class Joint:
    """A search for one plan `x` of the whole model, better and better."""

    def __init__(self, work: Work) -> None:
        self.work, self.compiled, self.lone = work, work.compiled, work.lone
        self.backend, self.gap = work.backend, work.options.gap
        self.deadline = work.deadline.share(tuning.JOIN.share, tuning.JOIN.seconds)
        self.budget = min(tuning.JOIN.seconds, tuning.JOIN.share * work.deadline.left)
        self.aim = least(work.compiled, work.lone)
        self.alone = {one.agent: one.run for one in work.lone if one.run is not None}
        self.x, self.value = work.x, work.value

    def run(self) -> Floats | None:
        """The best plan that was found."""
        names = list(self.compiled.states)
        if len(self.alone) == len(names) and not self._offer(self._held(self.alone)):
            for order in (names, names[::-1]):
                if self._is_off(tuning.JOIN.far) and self._cheap():
                    self._offer(self._joined(order))
        if self.x is not None:
            self._descend(names)
            self._polish()
        return self.x

    def _polish(self) -> None:
        """Let all continuous columns go, so that nothing is left of the room that runs were held
        in: whole numbers stay, everything else is the best for them. What does not stand that is
        given up."""
        assert self.x is not None
        found = self._solve(continuous_part(self.compiled.model, self.x), 0.0, last=True)
        self.x = self.work.x if found is None else found

    def _descend(self, names: Sequence[str]) -> None:
        """Let one agent, then two of many, answer the others anew, for as long as that helps."""
        self._turns(combinations(names, 1))
        if len(names) >= tuning.JOIN.many and self._is_off(tuning.JOIN.near):
            self._turns(combinations(names, 2))

    def _is_off(self, share: float) -> bool:
        """Whether the plan may cost that share more than needed."""
        return self.x is None or self.value - self.aim > share * abs(self.value)

    def _turns(self, groups: Iterable[tuple[str, ...]]) -> None:
        groups = list(groups)
        while any([self._offer(self._answer(group)) for group in groups]):
            continue

    def _cheap(self) -> bool:
        """Whether there is time to compile teams that grow by one agent after the other."""
        names = self.compiled.states
        return len(names) == 2 or len(names) * self.compiled.stats.seconds < self.budget

    def _offer(self, x: Floats | None) -> bool:
        """Take x if it is better by the gap."""
        if x is None:
            return False
        value = self.compiled.model.objective(x)
        if value >= self.value - self.gap * abs(value):
            return False
        self.x, self.value = x, value
        return True

    def _held(self, runs: Mapping[str, Run], rough: float = 0.0) -> Floats | None:
        return self._solve(hold(self.compiled, runs, _LOOSE), rough)

    def _solve(self, model: Model | None, rough: float, last: bool = False) -> Floats | None:
        if model is None or (self._over() and not last):
            return None
        asked = brief(self.work, max(rough, self.gap))
        try:
            return self.backend.solve(model, asked).x
        except SolverError:
            return None  # this was one try of several; the whole model is still to be solved

    def _over(self) -> bool:
        """Whether the plan is optimal, its share of the time is over, or it was asked to stop."""
        return not self._is_off(self.gap) or self.deadline.over()

    def _answer(self, free: Sequence[str]) -> Floats | None:
        """The best runs of some agents against those that the others have in `x`."""
        assert self.x is not None
        runs = self.compiled.decode(self.x)
        others = {n: (runs.states[n], runs.inputs[n]) for n in runs.states if n not in free}
        return self._held(others)

    def _joined(self, order: Sequence[str]) -> Floats | None:
        """Agents planned in this order; the last is planned in the model of the whole mission."""
        runs = {order[0]: self.alone[order[0]]}
        for k, name in enumerate(order[1:-1], start=2):
            team = self._team(order[:k])
            x = None if team is None else self._solve(hold(team, runs, _LOOSE), tuning.JOIN.rough)
            if team is None or x is None:
                return None
            found = team.decode(x)
            runs[name] = found.states[name], found.inputs[name]
        return self._held(runs, tuning.JOIN.rough)

    def _team(self, names: Iterable[str]) -> Compiled | None:
        mission = project(self.compiled.mission, tuple(names), self.compiled.channels)
        try:
            team = compile_mission(mission, CompileOptions(link=self.compiled.link))
        except InfeasibleError:
            return None
        return bounded(team, [one for one in self.lone if one.agent in team.states])


def _join(work: Work) -> Work:
    return work.with_point(Joint(work).run(), "agents alone")


PRIORITISED = Strategy("prioritised", lambda work: bool(work.lone), _join)
