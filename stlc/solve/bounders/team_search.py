"""More than two agents: first plans by coordinate descent, then branch and bound over all."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor

from stlc.solve.bounders.team import Tree
from stlc.solve.heuristics.descent import Descent
from stlc.solve.restricted.session import Session

_WORKERS = 2  # sweeps are bound by memory: more threads bring little


class Team:
    """Works on a session until proven or stopped."""

    def __init__(self, session: Session) -> None:
        self.session, self.problem = session, session.problem
        self.descent = Descent(self.problem, session.stopped)

    def plan(self) -> bool:
        """Look for first plans only; never proves anything."""
        order = list(range(len(self.problem.bodies)))
        if self.descent.possible:
            self._descend(order)
            self._descend(order[::-1])
        return False

    def run(self) -> bool:
        """Search; True when the incumbent is proven within the gap."""
        session = self.session
        self.plan()
        workers = min(_WORKERS, session.options.threads or os.cpu_count() or 1)
        with ThreadPoolExecutor(workers) as pool:
            Tree(session, pool).run()
        return session.x is not None and session.bound >= session.cutoff - 1e-6

    def _descend(self, order: list[int]) -> None:
        runs = self.descent.run(order, {}, 3)
        if runs is not None:
            self.session.follow([runs[i] for i in sorted(order)], 20.0)
