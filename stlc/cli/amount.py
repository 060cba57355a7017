"""Numbers on the command line."""

from __future__ import annotations

import math
from typing import Any

import click

SEED = click.IntRange(0, 2**31 - 1)
"""Seeds of solvers: 32 bits with a sign, in HiGHS, SCIP and CBC."""

THREADS = click.IntRange(1, 1024)
"""Threads of a solver; Gurobi's most. HiGHS takes more, and starts them all."""


class Amount(click.FloatRange):
    """A number within limits. NaN is within none, though click's comparisons let it pass."""

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float:
        """The number; a usage error for anything else."""
        number = float(super().convert(value, param, ctx))
        if math.isnan(number):
            self.fail(f"{value!r} is not a number.", param, ctx)
        return number
