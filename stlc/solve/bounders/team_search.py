"""More than two agents: first plans by coordinate descent, then branch and bound over all."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

from stlc.solve import tuning
from stlc.solve.bounders.team import Tree
from stlc.solve.heuristics.descent import Descent
from stlc.solve.heuristics.iterated import Runs, iterated
from stlc.solve.restricted.session import Session

_WORKERS = 2  # sweeps are bound by memory: more threads bring little


class Team:
    """Works on a session until proven or stopped."""

    def __init__(self, session: Session) -> None:
        self.session, self.problem = session, session.problem
        self.descent = Descent(session.guide, session.stopped)

    def plan(self) -> bool:
        """Look for first plans only; never proves anything."""
        if not self.descent.possible:
            return False
        moment = self.session.deadline.share(tuning.DESCENTS.share, tuning.DESCENTS.seconds)
        found = list(iterated(self.descent, moment.over, self.session.options.seed or 0))
        for runs in found[::-1]:  # the cheapest first, others where the mission rules it out
            if self._follow(runs) or self.session.stopped():
                break
        return False

    def run(self) -> bool:
        """Search; True when the incumbent is proven within the gap."""
        session = self.session
        if session.x is None:
            self.plan()
        workers = min(_WORKERS, session.options.threads or os.cpu_count() or 1)
        with ThreadPoolExecutor(workers) as pool:
            Tree(session, pool).run()
        return session.x is not None and session.bound >= session.cutoff - 1e-6

    def _follow(self, runs: Runs) -> bool:
        paths = [runs[n] for n in range(len(runs))]
        return self.session.follow(paths, tuning.DESCENTS.follow_seconds)
