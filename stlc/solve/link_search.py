"""The strategy for links between moving agents: a search around the compiled model."""

from __future__ import annotations

from dataclasses import replace

from stlc.backends.base import Solution, Status
from stlc.solve.bounders.pair import Search
from stlc.solve.bounders.team_search import Team
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.restricted.frame import Frame
from stlc.solve.restricted.session import Session
from stlc.solve.strategy import Work

_LARGE = 400_000  # columns: more are not given to the solver whole when there is a plan


def plan_links(work: Work) -> Work:
    """A first plan along the runs of descents, where the relaxation understands the mission."""
    problem = recognise(work.compiled)
    if problem is None or not problem.pairs:
        return work
    session = Session(Frame(work.compiled, problem), work)
    Team(session).plan()
    return session.work()


def search_links(work: Work) -> Work | Solution:
    """Bound and plan; where links are only asked for, the search just looks for a first plan."""
    problem = recognise(work.compiled)
    if problem is None or not problem.pairs:
        return work
    session = Session(Frame(work.compiled, problem), work)
    search = Search(session) if len(problem.bodies) == 2 else Team(session)
    proven = search.run() if problem.costly else search.plan()
    found = session.work()
    large = found.x is not None and work.compiled.model.columns > _LARGE
    if not (proven or large or session.stopped()):
        return found
    answer = found.answer()
    return replace(answer, status=Status.OPTIMAL) if proven else answer
