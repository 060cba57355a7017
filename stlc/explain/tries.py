"""How far one number has to go: doubling and bisection over its steps.

Each count is asked on the requirements of a conflict alone, after the steps that are made already.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from stlc.explain.edits import Replacement, Step, edits, traced
from stlc.explain.knobs import Knob
from stlc.explain.numbers import Of
from stlc.explain.oracle import Verdict
from stlc.explain.places import statements
from stlc.mission import Mission
from stlc.source import Span
from stlc.syntax import ast

_FIRST = (1.0, 1.3, 1.7, 2.5, 4.0, 16.0)  # parts of the longest way at which a knob is tried first


class Judge(Protocol):
    """Who knows what can hold in a changed file."""

    def verdict(
        self, mission: Mission, made: Sequence[Step], names: Collection[str] | None = None
    ) -> Verdict | None:
        """Whether requirements of these names (None: all) can be met after some steps; None where
        the text is wrong then."""


def apart(made: Sequence[Step], step: Step) -> tuple[Step, ...]:
    """The steps before, without one whose number the new one changes again."""
    spans = {r.span for r in step.replacements[: len(step.knob.spans)]}
    return tuple(s for s in made if s.replacements[0].span not in spans)


@dataclass(frozen=True, slots=True)
class Try:
    """One knob of the mission after the steps `made`, asked how far it must go for requirements of
    these names (None: all)."""

    judge: Judge
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
        if self.judge.verdict(self.mission, self.made, self.names) is Verdict.FEASIBLE:
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

    def shorter(self, step: Step) -> Step | None:
        """The next smaller step; None where there is none."""
        if step.count == 1:
            return None
        less = step.count - 1
        return replace(step, count=less, replacements=self._shorter(step, less))

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
        made = (*apart(self.made, step), step)
        return self.judge.verdict(self.mission, made, self.names)

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
