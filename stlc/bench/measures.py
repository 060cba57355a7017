"""Statistics of benchmark times: shifted geometric means, profiles, growth exponents."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from stlc.bench.groups import Group, Table

SHIFT = 1.0  # s
_LEAST = 0.01  # s: below it, times are noise


def shifted_geometric_mean(values: Iterable[float], shift: float = SHIFT) -> float:
    """exp(mean(log(v + shift))) - shift (T. Achterberg's thesis, 2007). ValueError for none."""
    logs = [math.log(value + shift) for value in values]
    if not logs:
        raise ValueError("a mean needs a value")
    return math.exp(math.fsum(logs) / len(logs)) - shift


@dataclass(frozen=True, slots=True)
class Summary:
    """One configuration over a suite. Ratios are to the reference, on the problems both have.

    The reference has none. `geometric`, `least` and `greatest` leave out problems that neither
    solved: two time limits say nothing. Where only one of the two was solved, a ratio is a bound:
    `mark` says which way the geometric mean is one.
    """

    label: str
    problems: int
    solved: int
    plans: int  # with a certified plan
    mean: float  # shifted geometric mean of seconds
    ratio: float | None  # of the shifted geometric means
    geometric: float | None  # geometric mean of the ratios of times, each at least 0.01 s
    mark: str  # "≥ ", "≤ ", "~ " where both kinds of bounds mix, or nothing
    least: float | None  # ratio of times
    greatest: float | None
    greatest_mark: str  # as `mark`, of the greatest ratio


def summaries(table: Table) -> list[Summary]:
    """One line for each configuration."""
    return [_summary(table, label) for label in table.labels]


def _summary(table: Table, label: str) -> Summary:
    """One configuration against the reference, the first label.

    Ratios are over problems of which one of both has a proof. Means are shifted geometric ones,
    in seconds of the solver. `bound_mark` tells which way a ratio bounds the true one, where a
    side stopped at its limit.
    """
    mine, reference = table.of(label), table.of(table.labels[0])
    own = label == table.labels[0]
    common = [problem for problem in mine if problem in reference and not own]
    told = [p for p in common if mine[p].solved or reference[p].solved]
    ratios = [time_ratio(mine[p], reference[p]) for p in told]
    top = told[ratios.index(max(ratios))] if told else None
    means = [
        shifted_geometric_mean(side[p].seconds for p in common) if common else math.nan
        for side in (mine, reference)
    ]
    return Summary(
        label,
        len(mine),
        sum(g.solved for g in mine.values()),
        sum(all(run.certified for run in g.runs) for g in mine.values()),
        shifted_geometric_mean(g.seconds for g in mine.values()),
        means[0] / means[1] if common and means[1] > 0 else None,
        math.exp(math.fsum(map(math.log, ratios)) / len(ratios)) if ratios else None,
        bound_mark((mine[p], reference[p]) for p in told),
        min(ratios, default=None),
        max(ratios, default=None),
        "" if top is None else bound_mark([(mine[top], reference[top])]),
    )


def time_ratio(group: Group, reference: Group) -> float:
    """How many times longer than the reference; times below 0.01 s count as 0.01 s."""
    return max(group.seconds, _LEAST) / max(reference.seconds, _LEAST)


def bound_mark(pairs: Iterable[tuple[Group, Group]]) -> str:
    """How ratios of these (group, reference) are bounds, as a mark before a number."""
    marks = {"≥ " if not a.solved else "≤ " for a, b in pairs if a.solved != b.solved}
    return "~ " if len(marks) > 1 else next(iter(marks), "")


Curve = tuple[list[float], list[float]]


def performance_profile(table: Table) -> dict[str, Curve]:
    """Fraction of problems solved within a factor of the best (E. Dolan, J. More, 2002).

    Only problems that every configuration was run on count; the derived column of the better
    peer is left out, for it would compete with itself.
    """
    labels = own_labels(table)
    rows = [row for row in table.rows.values() if all(label in row for label in labels)]
    found = {}
    for label in labels:
        factors = sorted(_factor(row, label, labels) for row in rows)
        solved = [f for f in factors if math.isfinite(f)]
        found[label] = (solved, [(k + 1) / len(rows) for k in range(len(solved))])
    return found


def own_labels(table: Table) -> tuple[str, ...]:
    """Configurations that were run, without derived ones."""
    from stlc.bench.groups import BEST_PEER

    return tuple(label for label in table.labels if label != BEST_PEER)


def _factor(row: dict[str, Group], label: str, labels: Sequence[str]) -> float:
    best = min((max(row[x].seconds, _LEAST) for x in labels if row[x].solved), default=math.inf)
    return max(row[label].seconds, _LEAST) / best if row[label].solved else math.inf


def cactus(table: Table) -> dict[str, Curve]:
    """How many problems each configuration solves within a time: (count, seconds)."""
    found = {}
    for label in own_labels(table):
        times = sorted(max(g.seconds, _LEAST) for g in table.of(label).values() if g.solved)
        found[label] = ([float(k) for k in range(1, len(times) + 1)], times)
    return found
