"""The strategy `boxes`: one agent that pays for where it is, by the cheapest runs over boxes.

Each cut of the boxes (`box_runs.py`) gives a bound, a run that plans are looked for near, and for
every step the places that no better plan comes to: the model goes on without them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from stlc.backends.base import Solution, Status
from stlc.mission import TermKind
from stlc.solve import tuning
from stlc.solve.deadline import Stopwatch
from stlc.solve.relaxation.bodies import body_of
from stlc.solve.routes.axis_boxes import axis_boxes
from stlc.solve.routes.box_runs import BoxRuns
from stlc.solve.routes.box_view import View, faces_of
from stlc.solve.routes.finder import Routes
from stlc.solve.routes.glance import glance
from stlc.solve.routes.nearby import FINDER, bettered, solved
from stlc.solve.routes.progress import Progress
from stlc.solve.routes.tube import within
from stlc.solve.strategy import Work

_SETTLED = (Status.OPTIMAL, Status.INFEASIBLE)


def look_through_boxes(work: Work) -> Work | Solution:
    """A bound, plans near the runs it is of, and the model without what neither needs."""
    soon = work.deadline.share(tuning.BOXES.share, tuning.BOXES.glance)
    begun = glance(work, soon, soon)
    if begun is None or isinstance(begun, Solution):
        return begun or work
    deadline = begun.deadline.share(tuning.BOXES.share, tuning.BOXES.seconds)
    runs: BoxRuns | None = None
    for view in _views(begun, deadline.over):
        clock, finer = Stopwatch(), BoxRuns(view, begun.value, runs)
        bound = finer.bound(deadline.over)
        if bound is None:
            break
        if np.isinf(bound):
            return begun.without_plan("cheapest runs over boxes")
        took, begun = clock.seconds, _near(begun.with_bound(bound), finer)
        finer.look_back(begun.value)
        runs = finer
        if begun.proven() or deadline.left < tuning.BOXES.growth * took:
            break
    if runs is None or begun.proven() or begun.x is None:
        return begun
    return bettered(_narrowed(begun, runs), tuning.BOXES.better_share)


def _views(work: Work, over: Callable[[], bool]) -> Iterator[View]:
    """The mission over finer and finer boxes."""
    compiled = work.compiled
    ((name, agent),) = compiled.mission.agents.items()
    efforts = [t for t in compiled.mission.objective if t.kind is TermKind.EFFORT]
    body = body_of(compiled, agent, efforts)
    if body is None:
        return
    routes, encoded = Routes.of(compiled, over), compiled.layout.encoded
    formulas = ((one.formula, k) for k, one in enumerate(encoded))
    progress = Progress.of(formulas, apart=True)
    faces = faces_of(compiled, name, body, routes.levels)
    for parts in tuning.BOXES.parts:
        x, y = (axis_boxes(axis, f, parts) for axis, f in zip(body.axes, faces, strict=True))
        if x is None or y is None:
            return
        yield View(compiled, agent, body, progress, routes.levels, x, y)


def _near(work: Work, runs: BoxRuns) -> Work:
    """The work with plans near a cheapest run: the closer, the sooner they are found."""
    work.report()
    boxes = runs.cheapest()
    if boxes is None:
        return work
    around = {runs.view.agent.name: boxes}
    wide = float(max(np.ptp(p, axis=1).max() for p in (runs.view.x.p, runs.view.y.p)))
    for room, steps in tuning.BOXES.near:
        near = within(work.compiled, around, room * wide, steps)
        found = solved(work, near, tuning.BOXES.near_seconds, work.options.gap)
        if found is not None:
            work = work.with_point(found.x, FINDER)
        if work.proven() or found is None or found.status not in _SETTLED:
            break
    return work


def _narrowed(work: Work, runs: BoxRuns) -> Work:
    """The work with an agent that is at each step where a better plan may be; the incumbent stays
    a point of the model."""
    compiled, axes = work.compiled, runs.view.body.axes
    model, states = compiled.model, compiled.states[runs.view.agent.name]
    lower, upper = model.col_lower.copy(), model.col_upper.copy()
    for t in range(1, runs.steps + 1) if runs.to_go[0] else ():
        columns = states[t, [axis.state for axis in axes]]
        low, high = runs.positions(t)
        if work.x is not None:
            low, high = np.minimum(low, work.x[columns]), np.maximum(high, work.x[columns])
        lower[columns] = np.clip(low, lower[columns], upper[columns])
        upper[columns] = np.clip(high, lower[columns], upper[columns])
    drawn = replace(model, col_lower=lower, col_upper=upper)
    return replace(work, compiled=replace(compiled, model=drawn))
