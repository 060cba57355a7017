"""What robustness each requirement has to reach: its margin, and the objective's columns.

A robustness objective over requirements R with scales s is one column rho with

    rho <= robustness(r) / s   for r in R,       low <= rho <= high,

low from the margins (every requirement holds), high the least static upper bound over R. `high` is
what lets a solver stop as soon as it has found a run that reaches it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from stlc.analysis.bounds import LinkBounds, static_bounds, unknown
from stlc.analysis.ranges import Ranges
from stlc.errors import UsageError
from stlc.ir.requirement import Requirement
from stlc.mission import Mission, ObjectiveTerm, TermKind

Scales = tuple[tuple[str, float], ...]


@dataclass(frozen=True, slots=True)
class Goal:
    """One robustness column: of one requirement, or of all (`requirement` None)."""

    requirement: str | None
    scales: Scales
    weight: float  # objective coefficient, negative: robustness is maximised; 0 for a cap's
    low: float
    high: float

    def scale(self, unit: str) -> float:
        """What one unit of the column is worth in a predicate's unit."""
        return dict(self.scales).get(unit, 1.0)

    def is_of(self, term: ObjectiveTerm) -> bool:
        """Whether it is the column of that robustness term."""
        return (self.requirement, self.scales) == _key(term)

    def covers(self, name: str) -> bool:
        """Whether it speaks of that requirement."""
        return self.requirement in (None, name)


@dataclass(frozen=True, slots=True)
class Level:
    """What the predicates of one requirement must reach: `margin`, and every goal."""

    margin: float
    goals: tuple[Goal, ...] = ()

    def ceiling(self, unit: str) -> float:
        """No predicate of this unit is ever asked for more."""
        return max([self.margin, *(g.high * g.scale(unit) for g in self.goals)])

    def needs_margin(self, unit: str) -> bool:
        """Whether the margin asks for more than every goal's lower end does."""
        return all(g.low * g.scale(unit) < self.margin - 1e-9 for g in self.goals)


def goals_of(
    mission: Mission,
    requirements: Sequence[Requirement],
    ranges: Mapping[str, Ranges],
    links: LinkBounds = unknown,
    known: Sequence[Goal] = (),
) -> tuple[Goal, ...]:
    """The robustness columns of the objective and of caps, with static ends; requirements are
    unrolled.

    `known` are the goals of the same objective with earlier ends, which stay valid.
    """
    earlier = {(g.requirement, g.scales): g.high for g in known}
    weights: dict[tuple[str | None, Scales], float] = {}
    capped = [term for cap in mission.caps for term in cap.terms]
    for term, counts in [*((t, 1.0) for t in mission.objective), *((t, 0.0) for t in capped)]:
        if term.kind is TermKind.ROBUSTNESS:
            if term.weight > 0:
                raise UsageError("robustness can be maximised, not minimised")
            key = _key(term)
            weights[key] = weights.get(key, 0.0) + counts * term.weight
    kept = {_key(t) for t in capped if t.kind is TermKind.ROBUSTNESS}
    return tuple(
        _goal(name, scales, weight, requirements, ranges, links, earlier.get((name, scales)))
        for (name, scales), weight in weights.items()
        if weight < 0 or (name, scales) in kept
    )


def _key(term: ObjectiveTerm) -> tuple[str | None, Scales]:
    return term.requirement, tuple(sorted(term.scales.items()))


def _goal(
    name: str | None,
    scales: Scales,
    weight: float,
    requirements: Sequence[Requirement],
    ranges: Mapping[str, Ranges],
    links: LinkBounds,
    earlier: float | None,
) -> Goal:
    """One robustness column: from the least margin it is about to the static bound, or an earlier
    pass's if that is lower."""
    meant = [r for r in requirements if name in (None, r.name)]
    bounds = static_bounds([r.formula for r in meant], ranges, dict(scales), links)
    high = min([bounds[r.formula][1] for r in meant], default=math.inf)
    high = high if earlier is None else min(high, earlier)
    low = min((_scaled_margin(r.margin, dict(scales)) for r in meant), default=0.0)
    return Goal(name, scales, weight, low, max(low, high))


def _scaled_margin(margin: float, scales: Mapping[str, float]) -> float:
    used = [1.0, *scales.values()] if not scales else list(scales.values())
    return margin / (max(used) if margin >= 0 else min(used))


def level_of(requirement: Requirement, goals: Sequence[Goal]) -> Level:
    """What the predicates of a requirement must reach."""
    return Level(requirement.margin, tuple(g for g in goals if g.covers(requirement.name)))
