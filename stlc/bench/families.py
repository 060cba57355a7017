"""Problems of one family taken together: medians and worst cases, for instances differ a lot."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from statistics import median

from stlc.bench.groups import Group, Table
from stlc.bench.measures import own_labels


@dataclass(frozen=True, slots=True)
class Spread:
    """Median and worst; infinite where it never came."""

    median: float
    worst: float


@dataclass(frozen=True, slots=True)
class Family:
    """The problems of one family under one configuration; `limit` is the greatest time limit [s].

    `first`, `proof` [s, wall, from the first line read] and `cpu` [s, of the solver until its
    proof] are infinite where there was none; `gap` is that after 60 s of the solver.
    """

    name: str
    label: str
    problems: int
    plans: int
    proofs: int
    limit: float
    first: Spread
    gap: Spread
    proof: Spread
    cpu: Spread


def gap_title(limits: Iterable[float]) -> str:
    """Head of the column of `gap_60`, for runs of these time limits [s]."""
    return f"gap at {min(60.0, max(limits)):g} s"


def families_of(table: Table) -> list[Family]:
    """Kinds in the order of their problems, each with its configurations."""
    found: dict[tuple[str, str], list[Group]] = defaultdict(list)
    for row in table.rows.values():
        for label in own_labels(table):
            if label in row and row[label].first.family:
                found[row[label].first.family, label].append(row[label])
    return [_family(name, label, groups) for (name, label), groups in found.items()]


def _family(name: str, label: str, groups: list[Group]) -> Family:
    """Counts and spreads (seconds, gaps) over the problems of one family under one label."""
    return Family(
        name,
        label,
        len(groups),
        sum(g.value("first_plan") is not None for g in groups),
        sum(g.solved for g in groups),
        max(g.first.time_limit for g in groups),
        _spread(groups, lambda g: g.value("first_plan")),
        _spread(groups, lambda g: g.value("gap_60")),
        _spread(groups, lambda g: g.value("proof") if g.solved else None),
        _spread(groups, lambda g: g.seconds if g.solved else None),
    )


def _spread(groups: list[Group], figure: Callable[[Group], float | None]) -> Spread:
    values = [math.inf if (v := figure(g)) is None else v for g in groups]
    return Spread(median(values), max(values))


def spread_text(spread: Spread, limit: float | None) -> str:
    """Median / worst: seconds, or fractions where there is no `limit` [s] that they exceed."""
    return f"{_figure(spread.median, limit)} / {_figure(spread.worst, limit)}"


def _figure(value: float, limit: float | None) -> str:
    if math.isinf(value):
        return "none" if limit is None else f"> {limit:g}"
    return f"{value:.1%}" if limit is None else f"{value:.1f}"
