"""From runs of all agents to a point of the whole model.

Held runs leave the solver literals, cells and costs to settle. Cell pairs that no run touches are
taken out before: most columns of a model with link costs are such.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from stlc.arrays import Bools, Floats
from stlc.backends.base import Backend, SolveOptions
from stlc.errors import SolverError
from stlc.milp.compile import Compiled
from stlc.milp.layout import PairColumns
from stlc.milp.model import Model
from stlc.solve.alone.run import Run
from stlc.solve.certify import continuous_part
from stlc.solve.mip_start import hold

_LOOSE = 1e-5  # of a run that is held: well above the tolerance of solvers, or they stumble
_NONE = 1e-6  # of a cell pair that is not used
_TOUCH = 1e-4  # m: a cell so near counts as touched


def completed(
    compiled: Compiled, runs: Mapping[str, Run], backend: Backend, asked: SolveOptions
) -> Floats | None:
    """A point (n,) of the model near the runs of all agents, its continuous part the best for its
    integers; None where the model has none."""
    held = hold(compiled, runs, _LOOSE)
    if held is None:
        return None
    upper = held.col_upper.copy()
    for columns in _far(compiled, runs):
        upper[columns] = held.col_lower[columns]
    x = _solved(replace(held, col_upper=upper), backend, asked)
    return None if x is None else polished(compiled, x, backend, asked)


def polished(compiled: Compiled, x: Floats, backend: Backend, asked: SolveOptions) -> Floats:
    """The point with the best continuous part for its integers (and cell pairs); x itself where
    that is no better."""
    model = continuous_part(compiled.model, x)
    upper = model.col_upper.copy()
    for made in compiled.layout.pairs:
        unused = made.columns[x[made.columns] < _NONE]
        upper[unused] = model.col_lower[unused]
    better = _solved(replace(model, col_upper=upper), backend, asked)
    return x if better is None else better


def _far(compiled: Compiled, runs: Mapping[str, Run]) -> Iterator[np.ndarray]:
    """Columns of cell pairs that the runs do not touch."""
    for made in compiled.layout.pairs:
        one, other = (_touched(compiled, made, end, runs) for end in (0, 1))
        yield made.columns[~np.logical_and.outer(one, other)]


def _touched(compiled: Compiled, made: PairColumns, end: int, runs: Mapping[str, Run]) -> Bools:
    """(k,): the cells of one end that its run touches."""
    name = made.ends[end]
    space = compiled.mission.agents[name].dynamics.space
    assert space is not None, "whoever has a link is somewhere"
    axes = compiled.mission.cell_axes
    point = (space @ runs[name][0][made.step])[:axes]
    cells = np.frombuffer(made.partition).reshape(-1, axes, 2)[made.cells[end]]
    near = (cells[:, :, 0] <= point + _TOUCH) & (cells[:, :, 1] >= point - _TOUCH)
    return np.asarray(near.all(axis=1))


def _solved(model: Model, backend: Backend, asked: SolveOptions) -> Floats | None:
    """A point of the model, its fixed columns taken out first."""
    lower, upper = model.col_lower, np.maximum(model.col_lower, model.col_upper)
    kept = np.flatnonzero(upper > lower)
    fixed = np.where(upper > lower, 0.0, lower)
    shift = model.A @ fixed
    part = model.A[:, kept]
    rows = np.flatnonzero(np.diff(part.indptr) > 0)
    small = replace(
        model, c=model.c[kept], offset=model.objective(fixed), A=part[rows],
        row_lower=(model.row_lower - shift)[rows], row_upper=(model.row_upper - shift)[rows],
        col_lower=lower[kept], col_upper=upper[kept], integrality=model.integrality[kept],
        col_blocks=(), row_blocks=(),
    )  # fmt: skip
    try:
        found = backend.solve(small, replace(asked, start=None, on_progress=None)).x
    except SolverError:
        return None  # one try of several
    if found is None:
        return None
    x = fixed.copy()
    x[kept] = found
    return x
