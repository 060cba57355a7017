"""No answer is believed: a solver's point is checked against the Model, or refused.

Integers are rounded. If the rounded point breaks a row, the continuous part is solved again with
the integers fixed. Then rows, bounds, integrality and objective are checked in extended precision.
What is certified is the point and its objective; that it is optimal, or that there is none, stays
the claim of the solver, which a second one can confirm.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stlc.backends import get
from stlc.backends.base import Floats, Solution, SolveOptions, Status, relative_gap
from stlc.certificate import Checked, Claim
from stlc.errors import SolverError
from stlc.milp.model import Model
from stlc.milp.violations import exact_objective, violations
from stlc.sense import Sense
from stlc.violation import Violations

TOLERANCE = 1e-6  # absolute, for rows and bounds: what solvers promise by default
EXACT: dict[str, object] = {
    "primal_feasibility_tolerance": 1e-9,
    "dual_feasibility_tolerance": 1e-9,
    "mip_feasibility_tolerance": 1e-9,
}
"""Options of HiGHS near the least tolerances that it takes."""
_FRACTION = 1e-4  # beyond every solver's own integrality tolerance (1e-6 to 1e-5)
_GROSS = 1e-4  # relative row violation that no tolerance or rounded digits explain


@dataclass(frozen=True, slots=True, eq=False)
class Certified:
    """A certified answer. `claim` is what the solver said, untouched.

    `status` is the claim as far as it can stand: OPTIMAL becomes FEASIBLE where it cannot.
    `x` (n,) has exact integers; `objective` is its own; both None without a point.
    """

    status: Status
    claim: Solution
    x: Floats | None
    objective: float | None
    bound: float | None
    tolerance: float
    before: Violations | None = None  # of the point as the solver returned it
    after: Violations | None = None  # of `x`
    polished: bool = False  # the continuous part was solved again
    warnings: tuple[str, ...] = ()

    @property
    def gap(self) -> float | None:
        """Relative gap between the certified objective and the solver's bound, not negative."""
        if self.objective is None or self.bound is None:
            return None
        return relative_gap(self.objective, min(self.bound, self.objective))

    def checked(self, sense: Sense = Sense.MINIMIZE) -> Checked:
        """What the plan keeps of it: figures go the way of the mission's `sense`, warnings quote
        the model, which minimises."""
        claim, own = self.claim, sense.own
        said = Claim(
            claim.status.value, own(claim.objective), claim.solver, claim.solver_version
        )  # fmt: skip
        return Checked(
            self.status.value, own(self.objective), own(self.bound), self.gap, self.tolerance, said,
            self.before, self.after, self.polished, self.warnings,
        )  # fmt: skip


def certify(
    model: Model,
    solution: Solution,
    tolerance: float = TOLERANCE,
    *,
    options: SolveOptions | None = None,
) -> Certified:
    """Certify an answer to `model`, given with the options it was asked under.

    Raises SolverError, which names the solver and what is wrong, for an answer that is refused.
    """
    options = options or SolveOptions()
    _check_claim(solution)
    if solution.status not in (Status.OPTIMAL, Status.FEASIBLE):
        bound = solution.bound
        return Certified(solution.status, solution, None, None, bound, tolerance)
    x = _checked_point(model, solution)
    before = violations(model, x)
    _check_gross(solution, before, tolerance)
    _check_objective(model, solution, x)
    rounded, polished = _rounded(model, x), False
    after = before if np.array_equal(rounded, x) else violations(model, rounded)
    if not after.within(tolerance):
        rounded, polished = _polished(model, solution, rounded), True
        after = violations(model, rounded)
        if not after.within(tolerance):
            raise refusal(solution, f"after rounding, {after.describe()}")
    objective = exact_objective(model, rounded)
    status, warnings = _standing(solution, objective, options)
    return Certified(
        status, solution, rounded, objective, solution.bound, tolerance,
        before, after, polished, warnings,
    )  # fmt: skip


def refusal(solution: Solution, problem: str) -> SolverError:
    """The error that names a solver and what is wrong with its answer."""
    version = solution.solver_version
    who = f"{solution.solver} ({version})" if version else solution.solver
    return SolverError(f"the answer of {who} is refused: {problem}")


def _check_claim(solution: Solution) -> None:
    if solution.status is Status.FAILED:
        who = solution.solver_version or solution.solver
        raise SolverError(f"{who} failed: {solution.message or 'it gives no reason'}")
    for name, value in (("objective", solution.objective), ("bound", solution.bound)):
        if value is not None and not np.isfinite(value):
            raise refusal(solution, f"its {name} is {value}")


def _checked_point(model: Model, solution: Solution) -> Floats:
    if solution.x is None:
        raise refusal(solution, f"it claims {solution.status.value} but returned no point")
    x = np.asarray(solution.x, dtype=float)
    if x.shape != (model.columns,):
        raise refusal(solution, f"it returned {x.size} values for {model.columns} columns")
    if not np.isfinite(x).all():
        column = model.col_name(int(np.flatnonzero(~np.isfinite(x))[0]))
        raise refusal(solution, f"column {column} is not a finite number")
    return x


def _check_gross(solution: Solution, found: Violations, tolerance: float) -> None:
    if found.integrality > _FRACTION:
        raise refusal(
            solution,
            f"integer column {found.worst_integer} is off its integer by {found.integrality:.3g}",
        )
    if found.rows_relative > _GROSS or found.bounds_relative > max(_GROSS, tolerance):
        raise refusal(solution, found.describe())


def _check_objective(model: Model, solution: Solution, x: Floats) -> None:
    """SolverError unless objective and bound claimed are those of the point, within rounding."""
    if solution.objective is None:
        raise refusal(solution, "it returned a point without its objective")
    value = exact_objective(model, x)
    used = np.flatnonzero(x)
    scale = 1.0 + float(np.abs(model.c[used]) @ np.abs(x[used])) + abs(model.offset)
    if abs(value - solution.objective) > TOLERANCE * scale:
        raise refusal(
            solution, f"it claims objective {solution.objective:.12g}, its point has {value:.12g}"
        )
    if solution.bound is not None and solution.bound > value + TOLERANCE * scale:
        raise refusal(
            solution, f"its bound {solution.bound:.12g} exceeds its own point's {value:.12g}"
        )


def _rounded(model: Model, x: Floats) -> Floats:
    integers = np.where(model.integrality == 1, np.round(x), x)
    return np.clip(integers, model.col_lower, model.col_upper) + 0.0


def _polished(model: Model, solution: Solution, x: Floats) -> Floats:
    """The best continuous part for the integers of x, by HiGHS."""
    again = _solved_again(model, x, SolveOptions())
    if again is None:
        found = violations(model, x)
        raise refusal(
            solution, f"with its integers rounded no point is feasible; {found.describe()}"
        )
    return again


def _solved_again(model: Model, x: Floats, options: SolveOptions) -> Floats | None:
    again = get("highs").solve(continuous_part(model, x), options)
    if again.x is None:
        return None
    return _rounded(model, np.where(model.integrality == 1, x, again.x))


def sharpened(model: Model, given: Certified, options: SolveOptions | None = None) -> Certified:
    """`given` with its continuous part solved again to 1e-9; itself where that gives no point.

    Solvers use up their tolerance, and weights of a hull carry it on to coordinates, many times as
    large: within tolerances of the Model, beyond those of the mission.
    """
    x = None if given.x is None else _solved_again(model, given.x, SolveOptions(extra=EXACT))
    if x is None or not (after := violations(model, x)).within(given.tolerance):
        return given
    objective = exact_objective(model, x)
    status, warnings = _standing(given.claim, objective, options or SolveOptions())
    return replace(
        given, status=status, x=x, objective=objective, after=after, polished=True,
        warnings=warnings,
    )  # fmt: skip


def continuous_part(model: Model, x: Floats) -> Model:
    """The linear programme that is left when the integers are those of x (n,), rounded."""
    fixed = model.integrality == 1
    values = np.round(x)
    return replace(
        model,
        integrality=np.zeros_like(model.integrality),
        col_lower=np.where(fixed, values, model.col_lower),
        col_upper=np.where(fixed, values, model.col_upper),
    )


def _standing(
    solution: Solution, objective: float, options: SolveOptions
) -> tuple[Status, tuple[str, ...]]:
    """The status that a claim with a certified point can keep, and why not more."""
    if solution.status is not Status.OPTIMAL:
        return solution.status, ()
    who, claimed = solution.solver, solution.objective
    slack = 10 * TOLERANCE * max(1.0, abs(objective))  # rows a tolerance off shift objectives
    if claimed is not None and objective > claimed + options.gap * abs(claimed) + slack:
        return Status.FEASIBLE, (
            f"{who} claims {claimed:.9g} is optimal; its point with exact integers is worth "
            f"{objective:.9g}, so optimality is not proven",
        )
    if (
        solution.bound is not None
        and objective - solution.bound
        > options.gap * 1.01 * max(abs(objective), abs(solution.bound)) + slack
    ):
        return Status.FEASIBLE, (
            f"{who} claims to be optimal, but its own bound {solution.bound:.9g} leaves a gap "
            f"to {objective:.9g}",
        )
    limit = options.time_limit
    if solution.bound is None and limit is not None and solution.seconds >= limit:
        return Status.FEASIBLE, (f"{who} claims to be optimal at its time limit, without a bound",)
    return Status.OPTIMAL, ()
