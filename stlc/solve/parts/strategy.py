"""The strategy for teams: bounds and a start from the members alone, the solver for the rest."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

from stlc.arrays import Floats
from stlc.backends.base import Backend, Capability, Progress, Solution, SolveOptions, Status
from stlc.milp.compile import Compiled
from stlc.solve.parts.bounds import Part, least
from stlc.solve.parts.joint import Joint
from stlc.solve.strategy import remaining, solve_twice_if_infeasible


def solve_team(
    compiled: Compiled, parts: Sequence[Part], backend: Backend, options: SolveOptions
) -> Solution:
    """Solve the model (with the rows of `parts` in it) from the best plan that its parts lead to.

    That plan is optimal, and no solver needed, where it costs no more than the parts alone.
    """
    began = time.perf_counter()
    x = Joint(compiled, parts, backend, options).run()
    seconds, bound = time.perf_counter() - began, least(compiled, parts)
    if x is None:
        return solve_twice_if_infeasible(compiled.model, backend, remaining(options, seconds))
    value = compiled.model.objective(x)
    if options.on_progress is not None:
        options.on_progress(Progress(seconds, value, bound, 0, x))
    if value - bound <= max(options.gap * abs(value), 1e-7):
        return Solution(
            Status.OPTIMAL, x, value, min(bound, value), 0, seconds, backend.name,
            f"agents alone, over {backend.version()}", message="no agent can do with less alone",
        )  # fmt: skip
    start = x if Capability.START & backend.capabilities else None
    asked = replace(remaining(options, seconds), start=start)
    found = solve_twice_if_infeasible(compiled.model, backend, asked)
    return found if found.x is not None else _kept(found, x, value, bound)


def _kept(found: Solution, x: Floats, value: float, bound: float) -> Solution:
    """The plan in hand, where the solver came back without any at its limit."""
    if found.status is not Status.NO_SOLUTION:
        return found
    known = bound if found.bound is None else max(bound, found.bound)
    return replace(found, status=Status.FEASIBLE, x=x, objective=value, bound=known)
