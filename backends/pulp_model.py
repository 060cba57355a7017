"""Our arrays as PuLP's objects, as fast as PuLP allows."""

from __future__ import annotations

import gc
import warnings
from math import isfinite
from typing import Any

import numpy as np

from stlc.backends.base import Floats
from stlc.milp.model import Model


def build(model: Model, start: Floats | None = None) -> tuple[Any, list[Any]]:
    """PuLP's problem and its variables in our order."""
    collecting = gc.isenabled()
    gc.disable()  # a million new objects, none of them garbage: collection doubles the time
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", category=DeprecationWarning)  # what PuLP 4 will drop
            return _problem(model, start)
    finally:
        if collecting:
            gc.enable()


def _problem(model: Model, start: Floats | None) -> tuple[Any, list[Any]]:
    import pulp

    problem = pulp.LpProblem("model", pulp.LpMinimize)
    variables = _variables(model, start)
    problem.addVariables(variables)
    used = np.flatnonzero(model.c)
    problem.setObjective(pulp.LpAffineExpression({variables[j]: model.c[j] for j in used.tolist()}))
    table, A = np.array(variables, dtype=object), model.A
    entries, values, pointers = table[A.indices].tolist(), A.data.tolist(), A.indptr.tolist()
    bounds = zip(model.row_lower.tolist(), model.row_upper.tolist(), strict=True)
    unused = dict.fromkeys(table[np.bincount(A.indices, minlength=model.columns) == 0], 0.0)
    for i, (low, high) in enumerate(bounds):
        a, b = pointers[i], pointers[i + 1]
        sides = _sides(low, high)
        row = pulp.LpAffineExpression(dict(zip(entries[a:b], values[a:b], strict=True)))
        if unused and sides:  # PuLP's MPS leaves them out but states their bounds: CBC refuses
            row.update(unused)
            unused = {}
        for sense, side in sides:
            problem.addConstraint(pulp.LpConstraint(row, sense, f"r{i}{'elu'[sense]}", side))
    return problem, variables


def _sides(low: float, high: float) -> list[tuple[int, float]]:
    """PuLP's sense (-1 <=, 0 =, 1 >=) and right-hand side of each half of a row."""
    if low == high:
        return [(0, low)]
    return [(s, v) for s, v in ((-1, high), (1, low)) if isfinite(v)]


def _variables(model: Model, start: Floats | None) -> list[Any]:
    import pulp

    lower, upper = (
        [v if isfinite(v) else None for v in bounds.tolist()]
        for bounds in (model.col_lower, model.col_upper)
    )
    kinds = [pulp.LpInteger if i else pulp.LpContinuous for i in model.integrality.tolist()]
    width = len(str(model.columns))  # PuLP sorts variables by name
    made = [
        pulp.LpVariable(f"x{j:0{width}d}", lower[j], upper[j], kinds[j])
        for j in range(model.columns)
    ]
    if start is not None:
        for variable, value in zip(made, np.asarray(start).tolist(), strict=True):
            variable.varValue = value
    return made
