"""Smallest changes of a file's numbers that end its conflicts, each shown to work.

For each knob of a conflict (`knobs.py`) the smallest step is found by doubling and bisection, on
the requirements of the conflict alone (`tries.py`). A change takes a step for every conflict: sets
of steps are tried from the cheapest on (A*, Hart, Nilsson and Raphael, 1968; what a set still lacks
is at least the cheapest step of each conflict that is known and that it doesn't end), on the whole
mission, which has to give a certified, verified plan. Where a conflict remains that wasn't known,
it is explained in the changed text. At last each step is made as small as the others allow.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field, replace
from heapq import heappop, heappush
from itertools import count

from stlc.channels import TableMemo
from stlc.errors import InfeasibleError, MissionError, NoPlanError, SolverError
from stlc.explain import shrink
from stlc.explain.conflict import Conflict, conflict_of
from stlc.explain.edits import Change, Step, edits, patched
from stlc.explain.knobs import knobs
from stlc.explain.numbers import Of
from stlc.explain.oracle import Oracle, Verdict
from stlc.explain.tries import Try, apart
from stlc.mission import Mission
from stlc.solve.deadline import Deadline
from stlc.solve.driver import solve_mission
from stlc.solve.outcome import SolveSettings

Load = Callable[[str], Mission]
"""A mission from a changed text, read as the file was; MissionError where the text is wrong."""

Steps = tuple[Step, ...]

_PATIENCE = 10.0  # s for one question: a change that is so hard to judge is none to offer
_PLANNING = 30.0  # s for a plan of a changed mission


@dataclass(slots=True)
class Repairer:
    """Looks for changes of one mission; `load` reads a changed text."""

    load: Load
    backend: str
    deadline: Deadline
    grace: float | None = None
    open: bool = False  # time ran out, or some change that was looked at is undecided
    _tables: TableMemo = field(default_factory=dict)

    def changes(self, mission: Mission, conflict: Conflict, most: int = 5) -> tuple[Change, ...]:
        """Up to `most` changes that give verified plans, the smallest first."""
        found: list[Change] = []
        for change in _Search(self, mission).changes(conflict):
            if change.text not in {c.text for c in found}:
                found.append(change)
            if len(found) == most:
                break
        self.open |= self.deadline.over()
        return tuple(sorted(found, key=lambda c: c.cost))

    def verdict(
        self, mission: Mission, made: Sequence[Step], names: Collection[str] | None = None
    ) -> Verdict | None:
        """What is known of requirements (None: all) after some steps; None: the text is wrong."""
        changed = self.loaded(mission, made)
        if changed is None:
            return None
        other = any(s.knob.of in (Of.PARTITION, Of.WORKSPACE) for s in made)
        tables = {} if other else self._tables
        oracle = Oracle(changed, self.backend, self.deadline.within(_PATIENCE), self.grace, tables)
        asked = [r for r in changed.requirements if names is None or r.name in names]
        try:
            alone = not asked or names is None
            found = oracle.everybody() if alone else Verdict.FEASIBLE
            if asked and found is Verdict.FEASIBLE:
                found = oracle(asked)
        except MissionError:
            return None
        self.open |= found is Verdict.UNKNOWN
        return found

    def loaded(self, mission: Mission, made: Sequence[Step]) -> Mission | None:
        """The mission after some steps; None where the text is wrong."""
        if not made:
            return mission
        try:
            return self.load(patched(mission.source.text, edits(made)))
        except MissionError:
            return None

    def planned(self, mission: Mission) -> Verdict:
        """Whether a changed mission gives a certified and verified plan."""
        settings = SolveSettings(
            self.backend,
            time_limit=self.deadline.share(0.5, _PLANNING).limit,
            gap=1.0,
            grace=self.grace,
        )
        try:
            solve_mission(replace(mission, objective=(), preferences=()), settings)
        except InfeasibleError:
            return Verdict.INFEASIBLE
        except (MissionError, NoPlanError, SolverError):
            self.open = True
            return Verdict.UNKNOWN
        return Verdict.FEASIBLE


@dataclass(frozen=True, slots=True)
class _Met:
    """A conflict, by the requirements of its clauses, and steps that end it, cheapest first."""

    names: frozenset[str]
    steps: Steps


@dataclass(slots=True)
class _Search:
    """Sets of steps from the cheapest on; `met` are the conflicts that are known."""

    repairer: Repairer
    mission: Mission
    met: list[_Met] = field(default_factory=list)
    _heap: list[tuple[float, int, Steps]] = field(default_factory=list)
    _seen: set[frozenset[Step]] = field(default_factory=set)
    _ends: dict[tuple[Step, int], bool] = field(default_factory=dict)
    _number: Iterator[int] = field(default_factory=count)
    _hopeless: bool = True  # the last set gave no plan: the next one may not either

    def changes(self, conflict: Conflict) -> Iterator[Change]:
        """Sets of steps that give verified plans, until there are no more or the time is over."""
        self._meet((), self.mission, conflict)
        while self._heap and not self.repairer.deadline.over():
            estimate, _, made = heappop(self._heap)
            lacking = self._lacking(made)
            if self._estimate(made, lacking) > estimate + 1e-9:
                self._push(made, lacking)  # other conflicts were met meanwhile
            elif lacking:
                self._further(made, lacking[0].steps)
            else:
                yield from self._tried(made)

    def _meet(self, made: Steps, now: Mission, conflict: Conflict) -> None:
        """Know a conflict of `now`, the mission after the steps `made`, and go on beyond it."""
        names = frozenset(c.name for c in conflict.clauses)
        tries = [Try(self.repairer, self.mission, made, k, names) for k in knobs(now, conflict)]
        found = [s for s in (one.least() for one in tries) if s is not None]
        steps = tuple(sorted(found, key=lambda s: s.cost))
        if steps:
            self.met.append(_Met(names, steps))
            self._further(made, steps)

    def _further(self, made: Steps, steps: Steps) -> None:
        """Go on with each of some steps beside those that are made."""
        for step in steps:
            longer = (*apart(made, step), step)
            if frozenset(longer) not in self._seen:
                self._seen.add(frozenset(longer))
                self._push(longer, self._lacking(longer))

    def _push(self, made: Steps, lacking: Sequence[_Met]) -> None:
        heappush(self._heap, (self._estimate(made, lacking), next(self._number), made))

    def _estimate(self, made: Steps, lacking: Sequence[_Met]) -> float:
        return sum(s.cost for s in made) + sum(one.steps[0].cost for one in lacking)

    def _lacking(self, made: Steps) -> list[_Met]:
        """Conflicts that are known and that no step made ends."""
        return [one for k, one in enumerate(self.met) if not any(self._is_end(s, k) for s in made)]

    def _is_end(self, step: Step, number: int) -> bool:
        """Whether a step ends a conflict by itself."""
        if (step, number) not in self._ends:
            one = self.met[number]
            known = step in one.steps
            asked = known or self.repairer.verdict(self.mission, (step,), one.names)
            self._ends[step, number] = known or asked is Verdict.FEASIBLE
        return self._ends[step, number]

    def _tried(self, made: Steps) -> Iterator[Change]:
        """The change that these steps make, once the whole mission has a plan; else another
        conflict is met."""
        changed = self.repairer.loaded(self.mission, made)
        if changed is None:
            return
        oracle = Oracle(changed, self.repairer.backend, self.repairer.deadline, self.repairer.grace)
        local = self._hopeless and shrink.is_local(oracle, changed.requirements)
        verdict = Verdict.INFEASIBLE if local else self.repairer.planned(changed)
        self._hopeless = verdict is not Verdict.FEASIBLE
        if verdict is Verdict.FEASIBLE:
            yield self._polished(made, changed)
        elif verdict is Verdict.INFEASIBLE:
            self._meet(made, changed, conflict_of(oracle, changed.requirements))

    def _polished(self, first: Steps, planned: Mission) -> Change:
        """Each of several steps as small as the others allow, none where they do without it.
        `planned` is the mission after all of them, which has given a plan."""
        made = first
        for step in first if len(first) > 1 else ():
            others = tuple(s for s in made if s is not step)
            if not self._is_needed(others, step):
                smaller = Try(self.repairer, self.mission, others, step.knob, None).below(step)
                made = others if smaller is None else (*others, smaller)
        changed = planned if made == first else self.repairer.loaded(self.mission, made)
        if changed is None or (
            made != first and self.repairer.planned(changed) is not Verdict.FEASIBLE
        ):
            made, changed = first, planned
        ordered = tuple(sorted(made, key=lambda s: s.replacements[0].span.start))
        return Change(ordered, changed.source.text)

    def _is_needed(self, others: Steps, step: Step) -> bool:
        """Whether the conflict that a step was made for remains if it is any shorter."""
        names = next(one.names for one in self.met if step in one.steps)
        shorter = Try(self.repairer, self.mission, others, step.knob, names).shorter(step)
        made = others if shorter is None else (*others, shorter)
        return self.repairer.verdict(self.mission, made, names) is Verdict.INFEASIBLE
