"""What happens around the solver: starts and bounds found ahead of it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from stlc.backends.base import Backend, Capability, Solution, SolveOptions, Status
from stlc.milp.compile import Compiled
from stlc.milp.model import Model

_SMALL = 1500  # columns
_MOMENT = 1.0  # s


def run_strategy(
    name: str, compiled: Compiled, backend: Backend, options: SolveOptions
) -> Solution:
    """`milp`: one plain solve. `auto`: small models are tried at once for a moment; teams that
    minimise effort are bounded by what each agent does alone; links between moving agents have a
    search of their own; else a start is looked for first where the model offers one, and one that
    reaches a static bound is optimal and needs no solver."""
    if name != "auto":
        return solve_twice_if_infeasible(compiled.model, backend, options)
    from stlc.solve.links.strategy import solve_links
    from stlc.solve.parts.bounds import bounded, parts_of
    from stlc.solve.parts.strategy import solve_team

    began = time.perf_counter()
    if _is_small(compiled) and Capability.TIME_LIMIT & backend.capabilities:
        at_once = solve_twice_if_infeasible(compiled.model, backend, _moment(options))
        if at_once.status in (Status.OPTIMAL, Status.INFEASIBLE):
            return at_once
        if options.start is None and Capability.START & backend.capabilities:
            options = replace(options, start=at_once.x)
    parts = parts_of(compiled, backend, options)
    finish = partial(solve_twice_if_infeasible, compiled.model, backend)
    if parts:
        compiled = bounded(compiled, parts)
        finish = partial(solve_team, compiled, parts, backend)
    options = remaining(options, time.perf_counter() - began)
    linked = solve_links(compiled, backend, options, finish)
    if linked is not None:
        return linked
    if options.start is not None or parts:
        return finish(options)
    return _from_start(compiled, backend, options, finish)


def _from_start(
    compiled: Compiled,
    backend: Backend,
    options: SolveOptions,
    finish: Callable[[SolveOptions], Solution],
) -> Solution:
    """Look for a start; `finish` what it leaves open."""
    from stlc.solve.heuristics.dive import find_start

    began = time.perf_counter()
    found = find_start(compiled, over=lambda: _is_over(options, began))
    seconds = time.perf_counter() - began
    if found is not None and found.is_optimal(options.gap):
        return Solution(
            Status.OPTIMAL, found.x, found.objective, found.bound, 0, seconds, "start search",
            "start search over HiGHS LPs", message="the static bound is attained",
        )  # fmt: skip
    options = remaining(options, seconds)
    if found is not None and Capability.START & backend.capabilities:
        options = replace(options, start=found.x)
    return finish(options)


def _is_small(compiled: Compiled) -> bool:
    """A team's model so small that a plain solve mostly ends before any search has begun."""
    return len(compiled.states) > 1 and not compiled.robustness and compiled.model.columns <= _SMALL


def remaining(options: SolveOptions, seconds: float) -> SolveOptions:
    """Options with the time limit that is left after some seconds."""
    if options.time_limit is None:
        return options
    return replace(options, time_limit=max(options.time_limit - seconds, 0.01))


def _is_over(options: SolveOptions, began: float) -> bool:
    """Asked to stop, or at the time limit."""
    asked = options.should_stop is not None and options.should_stop()
    limit = options.time_limit
    return asked or (limit is not None and time.perf_counter() - began > limit)


def _moment(options: SolveOptions) -> SolveOptions:
    limit = _MOMENT if options.time_limit is None else min(_MOMENT, 0.1 * options.time_limit)
    return replace(options, time_limit=limit)


def solve_twice_if_infeasible(model: Model, backend: Backend, options: SolveOptions) -> Solution:
    """Solve; where HiGHS says infeasible, hear it again without its presolve.

    Presolve of HiGHS 1.15.1 has called feasible models infeasible. A second answer that is not
    infeasible replaces the first, unless it only ran out of time.
    """
    first = backend.solve(model, options)
    left = None if options.time_limit is None else options.time_limit - first.seconds
    late = left is not None and left <= 0
    if first.status is not Status.INFEASIBLE or backend.name != "highs" or late:
        return first
    plain = replace(options, time_limit=left, extra={**options.extra, "presolve": "off"})
    again = backend.solve(model, plain)
    return first if again.status in (Status.INFEASIBLE, Status.NO_SOLUTION) else again
