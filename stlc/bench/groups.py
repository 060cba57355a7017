"""Runs of one problem under one configuration, taken together."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from statistics import median

from stlc.bench.record import Record
from stlc.sense import Sense

BEST_PEER = "better peer"


@dataclass(frozen=True, slots=True)
class Group:
    """The repeats of one problem under one configuration; figures are medians over them."""

    runs: tuple[Record, ...]

    @property
    def first(self) -> Record:
        """Any run: for what is the same in all."""
        return self.runs[0]

    @property
    def solved(self) -> bool:
        """Proven in every repeat."""
        return all(run.solved for run in self.runs)

    @property
    def status(self) -> str:
        """The worst of the repeats."""
        return max((run.status for run in self.runs), key=_RANK.index)

    @property
    def seconds(self) -> float:
        """Median of the time that is compared, see `seconds_of`."""
        return median(seconds_of(run) for run in self.runs)

    @property
    def spread(self) -> tuple[float, float]:
        """Shortest and longest time."""
        times = [seconds_of(run) for run in self.runs]
        return min(times), max(times)

    def value(self, name: str) -> float | None:
        """Median of a figure over the runs that have it."""
        known = [float(v) for run in self.runs if (v := getattr(run, name)) is not None]
        return median(known) if known else None

    @property
    def minimised(self) -> float | None:
        """The objective, maximised ones with a minus sign: what compares between all tools."""
        return Sense(self.first.sense).own(self.value("objective"))


_RANK = (
    "optimal", "infeasible", "feasible", "no_plan", "out_of_time", "out_of_memory", "failed",
    "refused",
)  # fmt: skip


_AT_LIMIT = ("feasible", "no_plan")


def seconds_of(run: Record) -> float:
    """Time to proof of the solver (and strategy) alone: processor time of a run with one thread,
    for a busy machine stretches the other; wall time otherwise.

    A run without proof counts with its time limit, or with the processor time it got until then
    if that is less. What interval analysis proves infeasible needs no solver: then it is the time
    to compile.
    """
    own = run.cpu_seconds if run.threads == 1 else None
    if not run.solved:
        if own is None or run.status not in _AT_LIMIT:
            return run.time_limit
        return min(run.time_limit, own)
    known = (s for s in (own, run.solver_seconds, run.proof) if s is not None)
    return next(known, run.time_limit)


def groups_of(records: Iterable[Record]) -> list[Group]:
    """One group for each suite, problem and configuration, in order of appearance.

    Where a store holds runs of several versions or limits, the latest count.
    """
    found: dict[tuple[str, str, str], list[Record]] = defaultdict(list)
    for record in records:
        found[record.suite, record.problem, record.label].append(record)
    return [Group(_latest(runs)) for runs in found.values()]


def _latest(runs: Sequence[Record]) -> tuple[Record, ...]:
    def setting(run: Record) -> tuple[object, ...]:
        limits = (run.time_limit, run.gap_limit, run.threads, run.memory_limit)
        return (run.code, run.digest, *limits)

    last = setting(max(runs, key=lambda run: run.finished))
    return tuple(run for run in runs if setting(run) == last)


@dataclass(frozen=True, slots=True)
class Table:
    """The groups of one suite: `rows[problem][label]`; the first label is the reference."""

    suite: str
    labels: tuple[str, ...]
    rows: dict[str, dict[str, Group]]

    def of(self, label: str) -> dict[str, Group]:
        """Groups of one configuration by problem."""
        return {problem: row[label] for problem, row in self.rows.items() if label in row}


def tables_of(groups: Iterable[Group]) -> list[Table]:
    """One table a suite; `auto` (else the first seen) is the reference.

    Where a problem has several peers, the better of them is one more column."""
    suites: dict[str, list[Group]] = defaultdict(list)
    for group in groups:
        suites[group.first.suite].append(group)
    return [_table(suite, members) for suite, members in suites.items()]


def _table(suite: str, members: Sequence[Group]) -> Table:
    """The groups of one suite by problem and label; the first label is the reference.

    A column for the best of several peers is added: solved ones first, then the fastest.
    """
    rows: dict[str, dict[str, Group]] = defaultdict(dict)
    for group in members:
        rows[group.first.problem][group.first.label] = group
    for row in rows.values():
        peers = [group for label, group in row.items() if label.startswith("peer ")]
        if len(peers) > 1:
            row[BEST_PEER] = min(peers, key=lambda group: (not group.solved, group.seconds))
    labels = list(dict.fromkeys(label for row in rows.values() for label in row))
    labels.sort(key=lambda label: (label != "auto", label.startswith("peer"), label == BEST_PEER))
    return Table(suite, tuple(labels), dict(rows))


def disagreements(table: Table) -> list[str]:
    """Proven optima of one problem that differ by more than their gaps: somebody is wrong.

    The relative tolerance is the sum of both gaps asked for, and 1e-6."""
    found = []
    for problem, row in table.rows.items():
        proven = [(label, g) for label, g in row.items() if g.status == "optimal"]
        for label, group in proven[1:]:
            (first, other), mine = proven[0], group.minimised
            theirs = other.minimised
            if mine is None or theirs is None:
                continue
            allowed = 1e-6 + group.first.gap_limit + other.first.gap_limit
            own = Sense(group.first.sense).own
            if abs(mine - theirs) > allowed * max(1.0, abs(mine), abs(theirs)):
                found.append(
                    f"{problem}: {first} proves {own(theirs):.9g}, {label} proves {own(mine):.9g}"
                )
    return found
