"""The strategy for link costs: search around the compiled model, and the solver for the rest."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from stlc.backends.base import Backend, Capability, Solution, SolveOptions, Status
from stlc.milp.compile import Compiled
from stlc.solve.links.recognise import recognise
from stlc.solve.links.restrict import Frame
from stlc.solve.links.search import Search
from stlc.solve.links.session import Session
from stlc.solve.links.team import Team

_LARGE = 400_000  # columns: more are not given to the solver whole when there is a plan
_NEEDED = Capability.TIME_LIMIT | Capability.GAP


def solve_links(
    compiled: Compiled,
    backend: Backend,
    options: SolveOptions,
    finish: Callable[[SolveOptions], Solution] | None = None,
) -> Solution | None:
    """Solve a mission with link costs between moving agents; None for any other mission.

    Where links are only asked for, the search just looks for a first plan. The bound is that of
    the compiled model, and OPTIMAL means proven within the gap, as with a backend. Raises
    SolverError as the backend does.
    """
    if backend.capabilities & _NEEDED != _NEEDED:
        return None
    problem = recognise(compiled)
    if problem is None or not problem.pairs:
        return None
    session = Session(Frame(compiled, problem), backend, options)
    if options.start is not None:
        session.offer(options.start)
    search = Search(session) if len(problem.bodies) == 2 else Team(session)
    proven = search.run() if problem.costly else search.plan()
    large = session.x is not None and compiled.model.columns > _LARGE
    if proven or large or session.stopped():
        return _answer(session, proven)
    return _finish(session, finish or partial(backend.solve, compiled.model))


def _answer(session: Session, proven: bool) -> Solution:
    """What the session found, in a backend's words."""
    found, backend = session.x is not None, session.backend
    status = Status.FEASIBLE if found else Status.NO_SOLUTION
    known = np.isfinite(session.bound)
    return Solution(
        Status.OPTIMAL if proven else status,
        session.x,
        session.value if found else None,
        min(session.bound, session.value) if known else None,
        session.nodes,
        session.seconds,
        backend.name,
        f"link search over {backend.version()}",
    )


def _finish(session: Session, finish: Callable[[SolveOptions], Solution]) -> Solution:
    """Leave the model to `finish`, with the incumbent as its start."""
    options, backend = session.options, session.backend
    limit = None if options.time_limit is None else max(0.1, session.left)
    start = session.x if Capability.START & backend.capabilities else None
    asked = replace(options, time_limit=limit, start=start)
    found = finish(asked)
    if found.x is not None:
        session.offer(found.x)
    if found.status in (Status.INFEASIBLE, Status.UNBOUNDED, Status.FAILED):
        return found
    if found.bound is not None:
        session.raise_bound(found.bound)
    slack = options.gap * abs(session.value) + 1e-9
    proven = session.x is not None and session.bound >= session.value - slack
    return _answer(session, proven or found.status is Status.OPTIMAL)
