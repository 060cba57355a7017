"""What preferences a run violates, by how much, and whether it keeps within caps."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from stlc.mission import Cap, Mission
from stlc.preferences import Measure, Preference
from stlc.verify.preference_report import PreferenceReport
from stlc.verify.report import Violation
from stlc.verify.robustness import TOLERANCE, Evaluator
from stlc.verify.trace import Trace

Interval = tuple[float, float]


def violation(preference: Preference, trace: Trace) -> Interval:
    """Least and greatest violation of a run, in the preference's unit; NaN if it can't be judged.

    The greatest is that for lengths by the faces of polygons, for which a model proves its bound.
    """
    ends = [_violation(preference, Evaluator(trace, faces=faces)) for faces in (False, True)]
    return (math.nan, math.nan) if any(map(math.isnan, ends)) else (min(ends), max(ends))


def _violation(p: Preference, evaluator: Evaluator) -> float:
    if p.measure is Measure.ROBUSTNESS:
        value = evaluator.robustness(p.formula)[:1]
        return float(np.maximum(0.0, p.margin - value[0])) if len(value) else math.nan
    judged = [evaluator.robustness(part)[:1] for part in p.parts]
    if any(np.isnan(value).any() or not len(value) for value in judged):
        return math.nan
    return p.worth * sum(float(value[0]) < p.margin - TOLERANCE for value in judged)


def preference_reports(mission: Mission, trace: Trace) -> tuple[PreferenceReport, ...]:
    """Every preference of the mission."""
    return tuple(
        PreferenceReport(
            p.name,
            violation(p, trace)[0],
            p.unit,
            p.measure.value,
            p.weight,
            p.priority,
            p.cost,
            p.span,
        )
        for p in mission.preferences
    )


def cap_violations(caps: Sequence[tuple[Cap, Interval | None]]) -> Iterator[Violation]:
    """Caps that the run's own costs, least and greatest over ties, exceed."""
    for cap, found in caps:
        if found is None:
            yield Violation("cap", f"the cap on {cap.name} can't be judged", math.inf)
        elif found[0] > cap.limit + 1e-5 * max(1.0, abs(cap.limit)):
            over = found[0] - cap.limit
            text = f"{cap.name} is {found[0]:.9g}, above its cap {cap.limit:.9g}"
            yield Violation("cap", text, over)
