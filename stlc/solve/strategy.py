"""What happens around the solver: starts and bounds found ahead of it."""

from __future__ import annotations

from dataclasses import replace

from stlc.backends.base import Backend, Capability, Solution, SolveOptions
from stlc.milp.compile import Compiled


def run_strategy(
    name: str, compiled: Compiled, backend: Backend, options: SolveOptions
) -> Solution:
    """`milp`: one plain solve. `auto`: a start is looked for first where the model offers one."""
    if name == "auto" and options.start is None and Capability.START & backend.capabilities:
        from stlc.milp.start import find_start

        options = replace(options, start=find_start(compiled))
    return backend.solve(compiled.model, options)
