"""Smallest changes of a file's numbers that end its conflicts, each shown to work.

For each knob of a conflict (`knobs.py`) the smallest change is found by doubling and bisection, on
the requirements of the conflict alone; the cheapest ones are then tried on the whole mission, which
has to give a certified, verified plan. Where another conflict remains, it is explained in the
changed text and changed too, and at last each step is made as small as the others allow.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

from stlc.channels import TableMemo
from stlc.errors import InfeasibleError, MissionError, NoPlanError, SolverError
from stlc.explain import shrink
from stlc.explain.conflict import Conflict, conflict_of
from stlc.explain.edits import Change, Replacement, Step, edits, patched, traced
from stlc.explain.knobs import Knob, knobs
from stlc.explain.numbers import Of
from stlc.explain.oracle import Oracle, Verdict
from stlc.explain.places import statements
from stlc.mission import Mission
from stlc.solve.deadline import Deadline
from stlc.solve.driver import solve_mission
from stlc.solve.outcome import SolveSettings
from stlc.source import Span
from stlc.syntax import ast

Load = Callable[[str], Mission]
"""A mission from a changed text, read as the file was; MissionError where the text is wrong."""

_PATIENCE = 10.0  # s for one question: a change that is so hard to judge is none to offer
_PLANNING = 30.0  # s for a plan of a changed mission
_ROUNDS = 4  # conflicts that are ended one after the other
_FIRST = (1.0, 1.3, 1.7, 2.5, 4.0, 16.0)  # parts of the longest way at which a knob is tried first


@dataclass(slots=True)
class Repairer:
    """Looks for changes of one mission; `load` reads a changed text."""

    load: Load
    backend: str
    deadline: Deadline
    grace: float | None = None
    _tables: TableMemo = field(default_factory=dict)

    def changes(self, mission: Mission, conflict: Conflict, most: int = 5) -> tuple[Change, ...]:
        """Up to `most` changes that give verified plans, the smallest first."""
        found: list[Change] = []
        for step in self._steps(mission, (), mission, conflict):
            change = self._whole(mission, step)
            if change is not None and change.text not in {c.text for c in found}:
                found.append(change)
            if len(found) == most or self.deadline.over():
                break
        return tuple(sorted(found, key=lambda c: c.cost))

    def _steps(
        self, mission: Mission, made: tuple[Step, ...], now: Mission, conflict: Conflict
    ) -> list[Step]:
        """The smallest further step of every knob that ends a conflict, cheapest first.

        The conflict is one of `now`, the mission after the steps `made`.
        """
        names = {c.name for c in conflict.clauses}
        tries = [_Try(self, mission, made, knob, names) for knob in knobs(now, conflict)]
        found = (one.least() for one in tries)
        return sorted((s for s in found if s is not None), key=lambda s: s.cost)

    def verdict(
        self, mission: Mission, made: Sequence[Step], names: Collection[str] | None = None
    ) -> Verdict | None:
        """What is known of requirements (None: all) after some steps; None: the text is wrong."""
        changed = self._loaded(mission, made)
        if changed is None:
            return None
        other = any(s.knob.of in (Of.PARTITION, Of.WORKSPACE) for s in made)
        tables = {} if other else self._tables
        oracle = Oracle(changed, self.backend, self.deadline.within(_PATIENCE), self.grace, tables)
        asked = [r for r in changed.requirements if names is None or r.name in names]
        try:
            alone = not asked or names is None
            if alone and oracle.everybody() is not Verdict.FEASIBLE:
                return oracle.everybody()
            return oracle(asked) if asked else Verdict.FEASIBLE
        except MissionError:
            return None

    def _loaded(self, mission: Mission, made: Sequence[Step]) -> Mission | None:
        if not made:
            return mission
        try:
            return self.load(patched(mission.source.text, edits(made)))
        except MissionError:
            return None

    def _whole(self, mission: Mission, step: Step) -> Change | None:
        """The step, with those that other conflicts need, once the whole mission has a plan."""
        made: tuple[Step, ...] = (step,)
        for _ in range(_ROUNDS):
            changed = self._loaded(mission, made)
            if changed is None:
                return None
            oracle = Oracle(changed, self.backend, self.deadline, self.grace)
            local = shrink.is_local(oracle, changed.requirements)
            verdict = Verdict.INFEASIBLE if local else self._planned(changed)
            if verdict is Verdict.FEASIBLE:
                return self._polished(mission, made)
            if verdict is Verdict.UNKNOWN:
                return None
            found = conflict_of(oracle, changed.requirements)
            rest = self._steps(mission, made, changed, found)
            if not rest:
                return None
            made = *_apart(made, rest[0]), rest[0]
        return None

    def _polished(self, mission: Mission, first: tuple[Step, ...]) -> Change | None:
        """Each of several steps as small as the others allow, none where they do without it."""
        made = first
        for step in first if len(first) > 1 else ():
            others = tuple(s for s in made if s is not step)
            smaller = _Try(self, mission, others, step.knob, None).below(step)
            made = others if smaller is None else (*others, smaller)
        changed = self._loaded(mission, made)
        if changed is None or (made != first and self._planned(changed) is not Verdict.FEASIBLE):
            made, changed = first, self._loaded(mission, first)  # which has given a plan
        if changed is None:
            return None
        ordered = tuple(sorted(made, key=lambda s: s.replacements[0].span.start))
        return Change(ordered, changed.source.text)

    def _planned(self, mission: Mission) -> Verdict:
        """Whether the changed mission gives a certified and verified plan."""
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
            return Verdict.UNKNOWN
        return Verdict.FEASIBLE


def _apart(made: Sequence[Step], step: Step) -> tuple[Step, ...]:
    """The steps before, without one whose number the new one changes again."""
    spans = {r.span for r in step.replacements[: len(step.knob.spans)]}
    return tuple(s for s in made if s.replacements[0].span not in spans)


@dataclass(frozen=True, slots=True)
class _Try:
    """One knob of the mission after the steps `made`, asked how far it must go for requirements of
    these names (None: all)."""

    repairer: Repairer
    mission: Mission
    made: tuple[Step, ...]
    knob: Knob
    names: Collection[str] | None

    def least(self) -> Step | None:
        """The smallest step that helps; None where none does."""
        high = self._far()
        if high is None:
            return None
        low, count = 1, 1
        while count < high:
            if self._helps(count):
                high = count
                break
            low, count = count + 1, 2 * count
        return self._between(low, high)

    def below(self, step: Step) -> Step | None:
        """The smallest step that will do in place of one that does; None where none is needed."""
        if self.repairer.verdict(self.mission, self.made, self.names) is Verdict.FEASIBLE:
            return None
        low, high = 1, step.count
        while low < high:
            middle = (low + high) // 2
            smaller = replace(step, count=middle, replacements=self._shorter(step, middle))
            if self._verdict(smaller) is Verdict.FEASIBLE:
                high = middle
            else:
                low = middle + 1
        return replace(step, count=high, replacements=self._shorter(step, high))

    def _shorter(self, step: Step, count: int) -> tuple[Replacement, ...]:
        values = self.knob.at(count)
        own = zip(step.replacements, values, strict=False)
        changed = tuple(replace(r, new=_text(v)) for r, v in own)
        return changed + step.replacements[len(changed) :]

    def _between(self, low: int, high: int) -> Step:
        while low < high:
            middle = (low + high) // 2
            if self._helps(middle):
                high = middle
            else:
                low = middle + 1
        return self.step(high)

    def _far(self) -> int | None:
        """Some count that helps, the farthest first that the text allows; None where none does."""
        for part in _FIRST:
            count = int(self.knob.most / part)
            verdict = self._verdict(self.step(count)) if count else Verdict.INFEASIBLE
            if verdict in (Verdict.FEASIBLE, Verdict.INFEASIBLE):
                return count if verdict is Verdict.FEASIBLE else None
        return None

    def _helps(self, count: int) -> bool:
        return self._verdict(self.step(count)) is Verdict.FEASIBLE

    def _verdict(self, step: Step) -> Verdict | None:
        made = (*_apart(self.made, step), step)
        return self.repairer.verdict(self.mission, made, self.names)

    def step(self, count: int) -> Step:
        """The knob's numbers, and a given horizon that has to go along with a deadline."""
        file, before = self.mission.source, edits(self.made)
        spans = [traced(s, file, before) for s in self.knob.spans]
        values = self.knob.at(count)
        own = [Replacement(s, _text(v)) for s, v in zip(spans, values, strict=True)]
        later = round(self.knob.values[0] / self.knob.step) + count
        horizon = _horizon(self.mission)
        if self.knob.of is Of.DEADLINE and self.knob.way > 0 and horizon is not None:
            span, value = horizon
            own += [Replacement(span, str(later))] if value < later else []
        return Step(self.knob, count, tuple(own))


def _horizon(mission: Mission) -> tuple[Span, float] | None:
    """A horizon that the file gives in steps: its digits and its value."""
    for statement in statements(mission.source):
        if isinstance(statement, ast.Horizon) and isinstance(statement.length, ast.Number):
            number, start = statement.length, statement.length.span.start
            span = mission.source.span(start, start + len(number.text))
            return None if number.unit else (span, number.value)
    return None


def _text(value: float) -> str:
    return format(value, ".10g")
