"""What each agent spends alone bounds its share of the effort: one row of the model for each.

    minimise effort_a over the runs of agent a alone  =  b_a
    ->  sum_{j in S_a} c_j x_j >= b_a,   S_a: the cost columns of agent a's states and inputs

The rows cut off no run of the mission. Separation and links cost little beside the ways that the
agents have to go, while the relaxation of the whole model sees little of those ways: disjunctions
over time are spread thinly in it. Alone, an agent's model is small and soon solved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from stlc.arrays import Ints
from stlc.backends.base import Capability, Solution, Status
from stlc.errors import InfeasibleError
from stlc.milp.compile import Compiled, CompileOptions, compile_mission
from stlc.milp.model import Block, Model, Origin
from stlc.solve import tuning
from stlc.solve.alone.pieces import Pieces
from stlc.solve.alone.project import project
from stlc.solve.alone.run import LoneRun, Run
from stlc.solve.crew.ask import Ask
from stlc.solve.crew.crew import Job
from stlc.solve.deadline import Deadline
from stlc.solve.strategy import Work

_SLACK = 1e-6  # relative: solvers satisfy rows to within about this
_OPEN = (Status.FEASIBLE, Status.NO_SOLUTION)  # more may be found in more time


def look_at_each(work: Work) -> Work:
    """The work with what each agent of a team does alone, as rows and as a bound."""
    lone = lone_runs(work)
    found = replace(work, compiled=bounded(work.compiled, lone), lone=lone)
    return found.with_bound(least(work.compiled, lone))


def lone_runs(work: Work) -> tuple[LoneRun, ...]:
    """Each agent of a team alone, as far as the time goes: all of them are looked at first, then
    those that need longer share the rest."""
    pieces = Pieces.of(work.compiled.mission)
    names = list(work.compiled.mission.agents)
    alone = {name: one for name in names if (one := _alone(work, name, pieces)) is not None}
    deadline = work.deadline.share(tuning.LONE.share)
    found: dict[str, Solution] = {}
    looks_at = ((deadline.share(tuning.LONE.first), 1.0), (deadline, tuning.LONE.generous))
    for moment, part in looks_at:
        todo = [n for n in alone if n not in found or found[n].status in _OPEN]
        looks = [
            _look(work, alone[name], found.get(name), moment, part / (len(todo) - k))
            for k, name in enumerate(todo)
        ]
        found |= dict(zip(todo, work.crew.drive(looks), strict=True))
    told = (_told(name, alone[name], found[name]) for name in alone)
    return tuple(one for one in told if one is not None)


def _alone(work: Work, name: str, pieces: Pieces) -> Compiled | None:
    """One agent's mission without the others; None where that says nothing."""
    compiled = work.compiled
    mission = project(compiled.mission, (name,), compiled.channels, pieces)
    if not mission.objective or work.deadline.over():
        return None
    try:
        return compile_mission(mission, CompileOptions(link=compiled.link))
    except InfeasibleError:
        return None  # it shows again, and is told, when the whole mission is solved


def _look(
    work: Work, alone: Compiled, known: Solution | None, moment: Deadline, part: float
) -> Job[Solution]:
    """A solve of one agent alone, from the point of an earlier one, in a part of the time."""
    start = known.x if known is not None and work.can(Capability.START) else None
    options = replace(work.options, gap=0.1 * work.options.gap, start=start)
    limit = moment.share(min(work.crew.size * part, 1.0), tuning.LONE.seconds)
    return _better(known, (yield Ask(alone.model, work.backend, options, limit)))


def _better(first: Solution | None, second: Solution) -> Solution:
    """The second look at an agent with what the first one knew better."""
    if first is None or second.status is Status.OPTIMAL:
        return second
    bounds = [one.bound for one in (first, second) if one.bound is not None]
    points = [one for one in (first, second) if one.x is not None]
    best = min(points, key=lambda one: float(one.objective or 0.0), default=first)
    return replace(best, bound=max(bounds, default=None))


def _told(name: str, alone: Compiled, found: Solution) -> LoneRun | None:
    if found.bound is None or found.status not in (Status.OPTIMAL, *_OPEN):
        return None
    return LoneRun(name, found.bound, _run(alone, found, name))


def _run(compiled: Compiled, found: Solution, name: str) -> Run | None:
    if found.x is None:
        return None
    runs = compiled.decode(found.x)
    return runs.states[name], runs.inputs[name]


def bounded(compiled: Compiled, lone: Sequence[LoneRun]) -> Compiled:
    """The compiled mission with their rows added at the end; columns stay as they are."""
    shares = compiled.layout.effort
    rows = [(shares[one.agent], safe(one.bound)) for one in lone if one.agent in shares]
    rows = [(columns, bound) for columns, bound in rows if len(columns)]
    if not rows:
        return compiled
    return replace(compiled, model=with_rows(compiled.model, rows, "effort of each agent alone"))


def with_rows(model: Model, rows: Sequence[tuple[Ints, float]], origin: str) -> Model:
    """The model with a row for each (columns, bound): their cost is at least the bound."""
    from scipy.sparse import csr_matrix, vstack

    columns = np.concatenate([columns for columns, _ in rows])
    ends = np.cumsum([0, *(len(columns) for columns, _ in rows)])
    extra = csr_matrix((model.c[columns], columns, ends), shape=(len(rows), model.columns))
    extra.sort_indices()
    block = Block("alone", model.rows, (len(rows),), Origin(origin))
    return replace(
        model,
        A=vstack([model.A, extra], format="csr"),
        row_lower=np.append(model.row_lower, [bound for _, bound in rows]),
        row_upper=np.append(model.row_upper, np.full(len(rows), np.inf)),
        row_blocks=(*model.row_blocks, block),
    )


def least(compiled: Compiled, lone: Sequence[LoneRun]) -> float:
    """The bounds of all agents together: no plan costs less. -inf where an agent is missing."""
    if len(lone) < len(compiled.states):
        return -np.inf
    return compiled.model.offset + sum(safe(one.bound) for one in lone)


def safe(bound: float) -> float:
    """A bound less what solvers take for satisfied."""
    return bound - _SLACK * (1 + abs(bound))
