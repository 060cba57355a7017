"""A first plan before branch and bound: a short depth-first search over alternatives, one warm LP
a node, at the static upper bound of the robustness.

Where a mission maximises robustness, its static bound is very often attained: a run that reaches
it is optimal, and no dual work is needed. The search holds rho at that bound and decides which
alternative each disjunction takes,

    disjunctions that range over time first, the widest first; the alternative that the LP scores,
    every alternative that conflicts with a decision (`analysis/conflicts.py`) is ruled out at once,
    backtracking in order, restarts from other LP vertices (random costs) with growing limits.

Between the first dive and the restarts come runs of lattices (`lattice_runs.py`): their
alternatives are tried all at once, then one by one, those over time first.

It gives up after a fixed number of LPs, so it is repeatable. A point found with all literals
integral is feasible for the whole model.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from stlc.arrays import Floats
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.solve.heuristics.dive_search import DiveSearch, never, required
from stlc.solve.heuristics.references import reference_points
from stlc.solve.strategy import Work

_SHORT = 3e-5  # aim this far below the bound, relative: less than any sensible gap


@dataclass(frozen=True, slots=True, eq=False)
class Start:
    """A feasible point x (n,), its objective, a static bound (lower) on it, and the LPs it took."""

    x: Floats
    objective: float
    bound: float
    lps: int

    def is_optimal(self, gap: float) -> bool:
        """Whether the bound proves it optimal within a relative gap (and rounding)."""
        return self.objective - self.bound <= max(gap * abs(self.objective), 1e-7)


def find_start(
    compiled: Compiled, most_lps: int = 700, seed: int = 0, over: Callable[[], bool] = never
) -> Start | None:
    """A start, or None where none was found within `most_lps` linear programs (or a few dives), or
    before `over` said so.

    Only for missions that maximise the robustness of all requirements, where every integer column
    belongs to a formula.
    """
    column = compiled.robustness.get(None)
    if column is None or len(compiled.robustness) != 1 or not _covers(compiled):
        return None
    aim = column[2] - _SHORT * abs(column[2])
    search = DiveSearch.of(compiled, column[0], aim, seed)
    search.over = over
    x, lps = search.run(
        most_lps, reference_points(compiled, lambda level: partial(required, level, aim))
    )
    if x is None:
        return None
    return Start(x, compiled.model.objective(x), _static_bound(compiled.model), lps)


def _static_bound(model: Model) -> float:
    used = np.flatnonzero(model.c)
    ends = np.minimum(model.c[used] * model.col_lower[used], model.c[used] * model.col_upper[used])
    return float(ends.sum()) + model.offset


def _covers(compiled: Compiled) -> bool:
    known = {c for e in compiled.layout.encoded for _, alts in e.choices for _, c in alts}
    known.update(c for e in compiled.layout.encoded for c in e.literals.values())
    integers = np.flatnonzero(compiled.model.integrality)
    known.update(map(int, compiled.layout.derived))
    return all(int(c) in known for c in integers)


def look_for_start(work: Work) -> Work:
    """The work with a start, and the static bound, where one is found."""
    found = find_start(work.compiled, over=work.deadline.over)
    if found is None:
        return work
    return work.with_bound(found.bound).with_point(found.x, "start search")
