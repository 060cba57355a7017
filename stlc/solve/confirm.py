"""A second solver's word on what cannot be certified: that there is no point, or no better one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from stlc.backends import get
from stlc.backends.base import Backend, Floats, Solution, SolveOptions, Status
from stlc.errors import InfeasibleError, SolverError
from stlc.milp.model import Model
from stlc.solve.certify import TOLERANCE, Certified, certify, refusal

OPINION = 60.0
"""Seconds that a second solver may take at least to confirm an infeasible claim."""


class RefutedError(SolverError):
    """A solver claims that there is no point; `x` (n,), certified, was found by `by`."""

    def __init__(self, message: str, x: Floats, by: Backend) -> None:
        super().__init__(message)
        self.x = x
        self.by = by


@dataclass(frozen=True, slots=True)
class Confirmation:
    """What a second solver said about a claim of the first."""

    confirmed: bool
    by: str  # solver and version
    seconds: float
    message: str

    def __str__(self) -> str:
        return self.message


def confirm_infeasible(
    model: Model,
    first: Solution | str,
    second: Backend | None = None,
    options: SolveOptions | None = None,
) -> Confirmation:
    """Let a second solver judge an infeasible claim of `first`; the objective is left out.

    `second` is by default another installed solver (`second_opinion`). `confirmed` is False where
    there is none, it failed or reached its limits, or its own answer is refused. RefutedError names
    the first solver when the second finds a point and that point is certified.
    """
    claim = Solution(Status.INFEASIBLE, solver=first) if isinstance(first, str) else first
    who = claim.solver_version or claim.solver
    second = second or second_opinion(claim.solver)
    if second is None:
        return Confirmation(False, "", 0.0, f"{who} says so; no second solver is installed")
    feasibility = replace(model, c=np.zeros(model.columns), offset=0.0)
    asked = replace(options or SolveOptions(), start=None, on_progress=None)
    try:
        answer = second.solve(feasibility, asked)
    except SolverError as error:
        return Confirmation(False, second.name, 0.0, f"{who} says so; {error}")
    by = answer.solver_version or second.name
    if answer.status is Status.INFEASIBLE:
        return Confirmation(True, by, answer.seconds, f"proven by {who}, confirmed by {by}")
    try:
        found = certify(feasibility, answer, options=asked)
    except SolverError:
        return Confirmation(False, by, answer.seconds, f"{who} says so; {by} gave no valid point")
    if found.x is not None:
        problem = f"it claims infeasible, but {by} found a point that is certified"
        raise RefutedError(str(refusal(claim, problem)), found.x, second)
    return Confirmation(False, by, answer.seconds, f"{who} says so; {by} could not decide")


def opinion(options: SolveOptions, seconds: float) -> SolveOptions:
    """Limits for a second solver that judges a claim which took the first `seconds`."""
    return replace(options, time_limit=options.time_limit or max(OPINION, 2 * seconds))


def doubt(model: Model, claim: Solution, asked: SolveOptions) -> RefutedError:
    """What a second solver finds against an infeasible claim: a certified point, and its message.

    Raises InfeasibleError, with both solvers' words, where it finds none.
    """
    try:
        word = confirm_infeasible(model, claim, options=asked)
    except RefutedError as error:
        return error
    raise InfeasibleError(f"no run satisfies the mission ({word})")


def contradicted(claim: Solution) -> str:
    """Why an infeasible claim isn't believed once a verified plan is in hand."""
    return str(refusal(claim, "it claims infeasible, but a verified plan is in hand"))


def confirm_optimal(
    model: Model, first: Certified, second: Backend, options: SolveOptions | None = None
) -> Confirmation:
    """Let a second solver judge an optimum. SolverError when it certifies a better point."""
    asked = replace(options or SolveOptions(), start=None, on_progress=None)
    other = certify(model, second.solve(model, asked), options=asked)
    by = other.claim.solver_version or second.name
    if first.objective is None:
        raise refusal(first.claim, "it has no point to confirm")
    if other.status is Status.INFEASIBLE:
        raise refusal(other.claim, "it claims infeasible, but a certified point exists")
    slack = (asked.gap + TOLERANCE) * max(1.0, abs(first.objective))
    if other.objective is not None and other.objective < first.objective - slack:
        raise refusal(
            first.claim,
            f"it claims {first.objective:.9g} is optimal, but {by} found {other.objective:.9g}",
        )
    proven = other.status is Status.OPTIMAL
    said = "agrees" if proven else f"could not decide: {other.claim.message}"
    return Confirmation(proven, by, other.claim.seconds, f"{by} {said}")


_FAMILIES = (
    ("scip", "external-scip", "external-fscip"),
    ("mip", "pulp", "external-cbc"),
    ("highs", "cvxpy", "scipy", "external-highs"),
    ("external-glpsol",),
)


def second_opinion(first: str) -> Backend | None:
    """An installed backend that is built on another solver than the one named, if any."""
    for family in _FAMILIES:
        if first in family:
            continue
        for backend in map(get, family):
            if backend.available() is None:
                return backend
    return None
