"""The depth-first search of `dive.py` over the alternatives of disjunctions, one warm LP a node."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np

from stlc.analysis.conflicts import demands_of, find_conflicts
from stlc.analysis.goals import Level
from stlc.arrays import Floats, Ints
from stlc.milp.compile import Compiled
from stlc.milp.model import Model
from stlc.solve import tuning

_INTEGRAL = 1e-6
_NONE = np.empty(0, np.int64)


def never() -> bool:
    """Nobody says stop."""
    return False


def required(level: Level, target: float, unit: str) -> float:
    """What a predicate has to reach when the robustness is at its target."""
    return max([level.margin, *(target * g.scale(unit) for g in level.goals)])


@dataclass(slots=True, eq=False)
class _Decision:
    """A literal that was set; the alternatives that this ruled out; `other`: it is now 0."""

    column: int
    ruled_out: Ints
    other: bool = False


@dataclass(slots=True, eq=False)
class DiveSearch:
    """Literals set one after the other, each with an LP; `trail` is what to take back."""

    model: Model
    rho: int
    lp: Any  # highspy.Highs
    integers: Ints
    groups: Sequence[Ints]
    group_of: Ints  # (n,) group of a literal, -1 for other columns
    asserted: np.ndarray  # (groups,) exactly one alternative must be taken
    over_time: np.ndarray  # (groups,) alternatives at different steps
    conflicts: dict[int, Ints]
    upper: Floats
    lower: Floats
    rng: np.random.Generator
    preference: Floats  # (n,) by the reference that is followed, zeros without one
    lps: int = 0
    spent: int = 0
    restarts: int = 0
    over: Callable[[], bool] = never
    trail: list[_Decision] = field(default_factory=list)

    @staticmethod
    def of(compiled: Compiled, rho: int, target: float, seed: int) -> DiveSearch:
        """The LP with rho at its target, and what is known of the alternatives."""
        model = compiled.model
        groups, asserted, demands = [], [], []
        for one in compiled.layout.encoded:
            level = partial(required, one.level, target)
            top = set(one.formula.children) | {one.formula}
            for node, pairs in one.choices:
                cols = np.array([column for _, column in pairs], np.int64)
                if len(cols) > 1:
                    groups.append(cols)
                    asserted.append(node in top and len(cols) == len(node.args))
                for part, column in pairs:
                    demands += demands_of(column, part, level, compiled.mission, compiled.ranges)
        dead, conflicts = find_conflicts(compiled.mission, compiled.ranges, demands)
        steps = {d.column: d.steps[0] for d in demands}
        over_time = [len({steps.get(int(z), -1) for z in g}) > 1 for g in groups]
        group_of = np.full(model.columns, -1)
        for k, group in enumerate(groups):
            group_of[group] = k
        search = DiveSearch(
            model, rho, _load(model, rho, target),
            np.flatnonzero(model.integrality), groups, group_of,
            np.array(asserted, bool), np.array(over_time, bool), conflicts,
            model.col_upper.copy(), model.col_lower.copy(), np.random.default_rng(seed),
            np.zeros(model.columns),
        )  # fmt: skip
        search._bound(dead, 0.0, 0.0)
        return search

    def run(self, most: int, references: Iterator[Floats]) -> tuple[Floats | None, int]:
        """Search; the point and the number of LPs. `references` are for after a short dive."""
        from stlc.backends.highs_session import SCHEDULER

        with SCHEDULER.claim() as threads:
            self.lp.setOptionValue("threads", threads)
            return self._run(most, references)

    def _run(self, most: int, references: Iterator[Floats]) -> tuple[Floats | None, int]:
        """Dives near each reference, then restarts with shaken preferences under growing limits.

        Returns a point or None, and the LPs that were spent; `most` bounds the restarts' LPs.
        """
        if not self._solve():
            return None, self.lps
        limit = max(tuning.DIVE.first_limit, tuning.DIVE.per_choice * len(self.groups))
        most = max(most, tuning.DIVE.granted * int(limit))
        glance = int(max(tuning.DIVE.glance_lps, tuning.DIVE.glance_share * limit))
        found, exhausted = self._dive(glance)
        for self.preference in references if found is None and not exhausted else ():
            if self.over():
                break
            self._let_go()
            if self._fits(np.flatnonzero(self.preference == 1.0)):
                return self._polished(self._point()), self.lps
            found, exhausted = self._dive(glance)
            if found is not None or exhausted:
                return found, self.lps
        self.preference = np.zeros(self.model.columns)
        while found is None and not exhausted and self.lps < most and not self.over():
            self._let_go()
            self._shake()
            self.restarts += 1
            found, exhausted = self._dive(min(int(limit), most - self.lps))
            limit *= tuning.DIVE.growth
        return found, self.lps

    def _let_go(self) -> None:
        while self.trail:
            self._undo(self.trail.pop())

    def _fits(self, columns: Ints) -> bool:
        """Whether these alternatives, all taken, give a point; they are let go if not."""
        if not self.upper[columns].all():
            return False
        self._bound(columns, 1.0, 1.0)
        if self._solve():
            part = self._point()[self.integers]
            if (np.abs(part - np.round(part)) <= _INTEGRAL).all():
                return True
        self._bound(columns, 0.0, 1.0)
        self._solve()
        return False

    def _dive(self, limit: int) -> tuple[Floats | None, bool]:
        """Decide and backtrack until a point, the limit, or the end of the tree."""
        end, fits = self.spent + limit, True
        while self.spent < end and not self.over():
            if not fits:
                if not self._backtrack():
                    return None, True
                fits = self._still_fits(self.trail[-1].column)
                continue
            x = self._point()
            column = self._pick(x)
            if column is None:
                return self._polished(x), False
            fits = self._decide(column)
        return None, False

    def _polished(self, x: Floats) -> Floats:
        """The best point with these literals."""
        cols = self.integers.astype(np.int32)
        whole = np.round(x[self.integers])
        self.lp.changeColsBounds(len(cols), cols, whole, whole)
        model, every = self.model, np.arange(self.model.columns, dtype=np.int32)
        self.lp.changeColBounds(
            self.rho, float(model.col_lower[self.rho]), float(model.col_upper[self.rho])
        )
        self.lp.changeColsCost(len(every), every, model.c)
        return self._point() if self._solve() else x

    def _point(self) -> Floats:
        return np.array(self.lp.getSolution().col_value)

    def _pick(self, x: Floats) -> int | None:
        """The literal to set next; None where all integer columns are integral."""
        column = self._follow()
        if column is not None:
            return column
        part = x[self.integers]
        loose = np.abs(part - np.round(part)) > _INTEGRAL
        if not loose.any():
            return None
        scores = [self._score(k, x[g]) for k, g in enumerate(self.groups)]
        best = int(np.argmax(scores)) if scores else -1
        if best < 0 or scores[best] < 0:
            return int(self.integers[loose][np.argmax(part[loose])])
        group = self.groups[best]
        wanted = np.where(self.upper[group] > 0, x[group] + self.preference[group], -1.0)
        if self.restarts:
            wanted = wanted * (0.3 + 0.7 * self.rng.random(len(group)))
        return int(group[np.argmax(wanted)])

    def _follow(self) -> int | None:
        """The alternative in time that the reference prefers, of a disjunction not yet decided."""
        for k in map(int, np.flatnonzero(self.over_time & self.asserted)):
            group = self.groups[k]
            wanted = np.where(self.upper[group] > 0, self.preference[group], 0.0)
            if wanted.any() and not (self.lower[group] > 0.5).any():
                return int(group[np.argmax(wanted)])
        return None

    def _score(self, k: int, values: Floats) -> float:
        if (np.abs(values - np.round(values)) <= _INTEGRAL).all():
            return -1.0
        group, total = self.groups[k], float(values.sum())
        open_ = float(np.count_nonzero(self.upper[group] > 0))
        if self.over_time[k] and total > 0.9:
            return 1e6 + (self.rng.random() if self.restarts else open_)
        return open_ * total

    def _decide(self, column: int) -> bool:
        """Take the alternative of a literal and what follows from it; False where no LP point is
        left."""
        self._bound(np.array([column]), 1.0, 1.0)
        out = self.conflicts.get(column, _NONE)
        out = out[self.upper[out] > 0]
        if (self.lower[out] > 0.5).any():
            self.trail.append(_Decision(column, _NONE))
            self.spent += 1
            return False
        self._bound(out, 0.0, 0.0)
        self.trail.append(_Decision(column, out))
        touched = np.unique(self.group_of[out])
        if any(self._is_empty(k) for k in touched):
            self.spent += 1
            return False
        return self._solve()

    def _is_empty(self, k: int) -> bool:
        return k >= 0 and bool(self.asserted[k]) and not self.upper[self.groups[k]].any()

    def _backtrack(self) -> bool:
        """Turn the latest open decision over; False where none is left."""
        while self.trail and self.trail[-1].other:
            self._undo(self.trail.pop())
        if not self.trail:
            return False
        last = self.trail.pop()
        self._undo(last)
        self._bound(np.array([last.column]), 0.0, 0.0)
        self.trail.append(_Decision(last.column, _NONE, other=True))
        return True

    def _still_fits(self, column: int) -> bool:
        if self._is_empty(int(self.group_of[column])):
            self.spent += 1
            return False
        return self._solve()

    def _undo(self, decision: _Decision) -> None:
        self._bound(np.append(decision.ruled_out, decision.column), 0.0, 1.0)

    def _bound(self, columns: Ints, lower: float, upper: float) -> None:
        if not len(columns):
            return
        self.lower[columns], self.upper[columns] = lower, upper
        self.lp.changeColsBounds(
            len(columns), columns.astype(np.int32), self.lower[columns], self.upper[columns]
        )

    def _shake(self) -> None:
        columns = np.concatenate([*self.groups, _NONE]).astype(np.int32)
        self.lp.changeColsCost(len(columns), columns, self.rng.random(len(columns)))
        self._solve()

    def _solve(self) -> bool:
        import highspy

        self.lps += 1
        self.spent += 1
        self.lp.run()
        return bool(self.lp.getModelStatus() == highspy.HighsModelStatus.kOptimal)


def _load(model: Model, rho: int, target: float) -> Any:
    """The relaxation without costs, rho fixed, ready for warm dual simplex."""
    import highspy

    from stlc.backends.highs_session import new_highs

    lp, A = new_highs(), model.A
    lp.setOptionValue("presolve", "off")
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    lower[rho] = upper[rho] = target
    lp.passModel(
        model.columns, model.rows, A.nnz, int(highspy.MatrixFormat.kRowwise),
        int(highspy.ObjSense.kMinimize), 0.0, np.zeros(model.columns), lower, upper,
        model.row_lower, model.row_upper, A.indptr.astype(np.int32), A.indices.astype(np.int32),
        A.data, np.zeros(model.columns, np.int32),
    )  # fmt: skip
    return lp
