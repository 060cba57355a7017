"""What happens around the solver: starts and bounds found ahead of it."""

from __future__ import annotations

import time
from dataclasses import replace

from stlc.backends.base import Backend, Capability, Solution, SolveOptions, Status
from stlc.milp.compile import Compiled


def run_strategy(
    name: str, compiled: Compiled, backend: Backend, options: SolveOptions
) -> Solution:
    """`milp`: one plain solve. `auto`: link costs between moving agents have a search of their
    own; else a start is looked for first where the model offers one, and one that reaches a static
    bound is optimal and needs no solver."""
    if name != "auto":
        return backend.solve(compiled.model, options)
    from stlc.solve.links.strategy import solve_links

    linked = solve_links(compiled, backend, options)
    if linked is not None:
        return linked
    if options.start is not None:
        return backend.solve(compiled.model, options)
    from stlc.milp.start import find_start

    began = time.perf_counter()
    found = find_start(compiled)
    if found is not None and found.is_optimal(options.gap):
        seconds = time.perf_counter() - began
        return Solution(
            Status.OPTIMAL, found.x, found.objective, found.bound, 0, seconds, "start search",
            "start search over HiGHS LPs", message="the static bound is attained",
        )  # fmt: skip
    if found is not None and Capability.START & backend.capabilities:
        options = replace(options, start=found.x)
    if options.time_limit is not None:
        left = options.time_limit - (time.perf_counter() - began)
        options = replace(options, time_limit=max(left, 0.1))
    return backend.solve(compiled.model, options)
