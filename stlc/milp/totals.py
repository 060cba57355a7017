"""Totals of the objective: linear costs as coefficients, peaks as columns.

    factor * max_i (a_i' y + c_i)      a column z of that cost with z >= a_i' y + c_i for each i

Convex costs alone come here (semantic analysis sees to it), so that z is pressed onto the largest.
"""

from __future__ import annotations

import numpy as np

from stlc.charges import Form
from stlc.ir.signals import Role
from stlc.milp.context import Context
from stlc.mission import ObjectiveTerm


def add_total(ctx: Context, term: ObjectiveTerm) -> None:
    """Add every charge of a total."""
    for charge in term.charges:
        _add_linear(ctx, charge.form, term.weight)
        for factor, forms in charge.peaks:
            ends = [_ends(ctx, form) for form in forms]
            low, high = max(e[0] for e in ends), max(e[1] for e in ends)
            peak = ctx.builder.add_columns("peak", (1,), low, high, cost=term.weight * factor)
            for form in forms:
                cols, values = _columns(ctx, form)
                ctx.builder.add_dense_rows(
                    "peak", [*peak, *cols], [1.0, *(-v for v in values)], form.constant, np.inf
                )


def _add_linear(ctx: Context, form: Form, weight: float) -> None:
    cols, values = _columns(ctx, form)
    ctx.builder.offset += weight * form.constant
    if cols:
        ctx.builder.add_cost(cols, [weight * v for v in values])


def _columns(ctx: Context, form: Form) -> tuple[list[int], list[float]]:
    """Columns of the signals, with their factors."""
    cols = [
        int((ctx.states if s.role is Role.STATE else ctx.inputs)[s.owner][s.shift, s.index])
        for s, _ in form.terms
    ]
    return cols, [factor for _, factor in form.terms]


def _ends(ctx: Context, form: Form) -> tuple[float, float]:
    """Least and greatest value within the ranges."""
    low = high = form.constant
    for signal, factor in form.terms:
        r, state = ctx.ranges[signal.owner], signal.role is Role.STATE
        least, most = (
            float((one if state else other)[signal.shift, signal.index])
            for one, other in ((r.state_lower, r.input_lower), (r.state_upper, r.input_upper))
        )
        ends = factor * least, factor * most
        low, high = low + min(ends), high + max(ends)
    return low, high
