"""Big-Ms that solvers' arithmetic cannot carry: an error, or a warning.

A literal within a solver's integrality tolerance of 0 lets a row with big-M leak tolerance x M.
From M = 1e6 on HiGHS and CBC were seen to return wrong optima and false infeasibilities. Below,
certification rounds the literals, so no plan leaks; but a solver may believe one that does, and
its word on optimality is worth less.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from stlc.arrays import Floats
from stlc.diagnostics import Diagnostic, Warn
from stlc.ir.requirement import Requirement
from stlc.milp.model import Model

LARGEST = 1e6
_TOLERANCE = 1e-6  # on integrality, of most solvers
_LEAST_MARGIN = 1e-3  # in a row's units: nobody minds less where no margin is asked for


class TooLargeM(Diagnostic):
    """A requirement compares a signal whose range is too wide for a solver's arithmetic.

    A disjunction (`or`, `outside`, `eventually`) switches its parts on and off by coefficients as
    large as the ranges of the signals in them. From 1e6 on, solvers were seen to return wrong
    optima, so no such model is made. Ranges follow from the workspace and from limits on speed,
    states and inputs.
    """

    code: ClassVar[str] = "E0802"
    title: ClassVar[str] = "`{signals}` in requirement `{name}` can differ by {size:.3g}"
    label: ClassVar[str] = "too wide for a solver's arithmetic, which ends at 1e+06"
    help: ClassVar[str] = "declare a smaller workspace or bounds, or choose a larger unit of length"
    name: str
    signals: str
    size: float


class LeakyM(Warn):
    """A solver's integrality tolerance times a coefficient of the model exceeds the margin.

    The plan is safe: its integers are rounded and it is verified before anybody sees it. But the
    solver may take a slightly wrong point for the optimum, or call a mission infeasible that just
    holds.
    """

    code: ClassVar[str] = "W1101"
    title: ClassVar[str] = "`{name}` makes a big-M of {size:.3g} in {rows} rows"
    label: ClassVar[str] = (
        "a solver's tolerance of 1e-06 is worth {leak:.2g} here, more than {margin:g}"
    )
    help: ClassVar[str] = "declare tighter bounds, or ask for a larger margin"
    name: str
    size: float
    rows: int
    leak: float
    margin: float


def leaky_big_ms(model: Model, requirements: Mapping[str, Requirement]) -> tuple[LeakyM, ...]:
    """A warning for each origin whose big-M times 1e-6 exceeds its requirement's margin.

    A big-M is a coefficient of an integer column in a row that has continuous columns too;
    `requirements` are by the label of their origin. Where no margin is asked for it is 1e-3.
    """
    largest = _largest_in_rows(model)
    found: dict[str, LeakyM] = {}
    for block in model.row_blocks:
        own = largest[block.start : block.start + block.size]
        label = block.origin.label
        asked = requirements[label].margin if label in requirements else 0.0
        margin = asked if asked > 0 else _LEAST_MARGIN
        size = float(own.max(initial=0.0))
        if size * _TOLERANCE <= margin:
            continue
        rows = int((own * _TOLERANCE > margin).sum())
        known = found.get(label)
        if known is not None:
            rows, size = rows + known.rows, max(size, known.size)
        found[label] = LeakyM(
            span=block.origin.span, name=label, size=size, rows=rows, leak=size * _TOLERANCE,
            margin=margin,
        )  # fmt: skip
    return tuple(found.values())


def _largest_in_rows(model: Model) -> Floats:
    """The largest big-M of each row (m,), 0 where there is none."""
    found = np.zeros(model.rows)
    for rows, inside in model.row_slices():
        counts = np.diff(model.A.indptr[rows.start : rows.stop + 1])
        filled = np.flatnonzero(counts)
        if not len(filled):
            continue
        starts = (np.cumsum(counts) - counts)[filled]
        switch = model.integrality[model.A.indices[inside]] == 1
        sizes = np.where(switch, np.abs(model.A.data[inside]), 0.0)
        mixed = ~np.logical_and.reduceat(switch, starts)
        found[rows.start + filled] = np.where(mixed, np.maximum.reduceat(sizes, starts), 0.0)
    return found
