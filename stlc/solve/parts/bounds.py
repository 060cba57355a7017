"""What each agent spends alone bounds its share of the effort: one row of the model for each.

    minimise effort_a over the runs of agent a alone  =  b_a
    ->  sum_{j in S_a} c_j x_j >= b_a,   S_a: the cost columns of agent a's states and inputs

The rows cut off no run of the mission. Separation and links cost little beside the ways that the
agents have to go, while the relaxation of the whole model sees little of those ways: disjunctions
over time are spread thinly in it. Alone, an agent's model is small and soon solved.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stlc.arrays import Floats, Ints
from stlc.backends.base import Backend, Capability, Solution, SolveOptions, Status
from stlc.errors import InfeasibleError, SolverError
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.milp.model import Block, Model, Origin
from stlc.mission import TermKind
from stlc.solve.parts.project import project

_SLACK = 1e-6  # relative: solvers satisfy rows to within about this
_MOST = 20.0  # s for one agent, and no more than a share of the time limit
_SHARE = 0.1
_LEAST = 1.0  # s
_NEEDED = Capability.TIME_LIMIT | Capability.GAP

Run = tuple[Floats, Floats]


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """One agent alone: a lower bound of its effort, and the best run found, states (T+1, n) and
    inputs (T, m)."""

    agent: str
    bound: float
    run: Run | None


def parts_of(compiled: Compiled, backend: Backend, options: SolveOptions) -> tuple[Part, ...]:
    """Each agent of a team alone.

    Nothing for a single agent, where more than effort is minimised, by a solver that knows no
    limits, or in less than a second.
    """
    if backend.capabilities & _NEEDED != _NEEDED or (options.time_limit or np.inf) < _LEAST:
        return ()
    mission = compiled.mission
    kinds = {term.kind for term in mission.objective if term.weight != 0}
    if len(mission.agents) < 2 or kinds != {TermKind.EFFORT}:
        return ()
    found = (_alone(compiled, name, backend, options) for name in mission.agents)
    return tuple(part for part in found if part is not None)


def _alone(compiled: Compiled, name: str, backend: Backend, options: SolveOptions) -> Part | None:
    mission = project(compiled.mission, (name,), compiled.channels)
    if not mission.objective or (options.should_stop is not None and options.should_stop()):
        return None
    try:
        alone = compile_mission(mission, CompileOptions(link=compiled.link))
        found = backend.solve(alone.model, brief(options, 0.1 * options.gap))
    except (InfeasibleError, SolverError):
        return None  # it shows again, and is told, when the whole mission is solved
    if found.bound is None or found.status not in (Status.OPTIMAL, Status.FEASIBLE):
        return None
    return Part(name, found.bound, _run(alone, found, name))


def brief(options: SolveOptions, gap: float) -> SolveOptions:
    """Options of a solve on the way: a small share of the time, nothing reported."""
    seconds = min(_MOST, _SHARE * (options.time_limit or np.inf))
    return replace(options, time_limit=seconds, gap=gap, start=None, on_progress=None)


def _run(compiled: Compiled, found: Solution, name: str) -> Run | None:
    if found.x is None:
        return None
    runs = compiled.decode(found.x)
    return runs.states[name], runs.inputs[name]


def bounded(compiled: Compiled, parts: Sequence[Part]) -> Compiled:
    """The compiled mission with the parts' rows added at the end; columns stay as they are."""
    shares = _shares(compiled)
    rows = [(shares[part.agent], _safe(part.bound)) for part in parts]
    rows = [(columns, bound) for columns, bound in rows if len(columns)]
    if not rows:
        return compiled
    return replace(compiled, model=_with_rows(compiled.model, rows))


def _shares(compiled: Compiled) -> Mapping[str, Ints]:
    """The cost columns of each agent: its states and inputs, and what rows tie to them alone."""
    from scipy.sparse import csr_matrix

    model, names = compiled.model, list(compiled.states)
    own = np.zeros((model.columns, len(names)))
    for k, name in enumerate(names):
        own[np.concatenate([compiled.states[name].ravel(), compiled.inputs[name].ravel()]), k] = 1
    pattern = csr_matrix((np.ones(model.nonzeros), model.A.indices, model.A.indptr), model.A.shape)
    costs = np.flatnonzero(model.c)
    near = (pattern.T.tocsr()[costs] @ (pattern @ own)) > 0
    near = np.where(own[costs].any(1, keepdims=True), own[costs] > 0, near)
    alone = near.sum(1) == 1
    return {name: costs[near[:, k] & alone] for k, name in enumerate(names)}


def _with_rows(model: Model, rows: Sequence[tuple[Ints, float]]) -> Model:
    from scipy.sparse import csr_matrix, vstack

    columns = np.concatenate([columns for columns, _ in rows])
    ends = np.cumsum([0, *(len(columns) for columns, _ in rows)])
    extra = csr_matrix((model.c[columns], columns, ends), shape=(len(rows), model.columns))
    extra.sort_indices()
    block = Block("alone", model.rows, (len(rows),), Origin("effort of each agent alone"))
    return replace(
        model,
        A=vstack([model.A, extra], format="csr"),
        row_lower=np.append(model.row_lower, [bound for _, bound in rows]),
        row_upper=np.append(model.row_upper, np.full(len(rows), np.inf)),
        row_blocks=(*model.row_blocks, block),
    )


def least(compiled: Compiled, parts: Sequence[Part]) -> float:
    """The parts' bounds together: no plan costs less. -inf where a part is missing."""
    if len(parts) < len(compiled.states):
        return -np.inf
    return compiled.model.offset + sum(_safe(part.bound) for part in parts)


def _safe(bound: float) -> float:
    return bound - _SLACK * (1 + abs(bound))
