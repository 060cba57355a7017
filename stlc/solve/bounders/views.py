"""Finer and finer views of the nodes of a team: borders, alternatives, slopes, halved boxes.

Each is a relaxation of the same plans as the one before, whose prices it takes over: the bound
never falls.
"""

from __future__ import annotations

from concurrent.futures import Executor

import numpy as np

from stlc.arrays import Floats
from stlc.solve import tuning
from stlc.solve.bounders.agreement import Agreement
from stlc.solve.bounders.finer import halved_rows, spreads, widest
from stlc.solve.bounders.team_ascent import TeamAscent
from stlc.solve.bounders.team_node import Node, Taken, pairs_of, viewed
from stlc.solve.relaxation.problem import Problem
from stlc.solve.relaxation.recognise import recognise
from stlc.solve.restricted.session import Session
from stlc.solve.states.layers import Layer, Maker, rate_borders
from stlc.solve.states.tubes import Tubes


class Views:
    """Makes the layers of all nodes of one problem."""

    def __init__(self, session: Session, tubes: list[Tubes], pool: Executor) -> None:
        self.session, self.tubes, self.pool = session, tubes, pool
        self._bordered: Problem | None = None

    def layers(self, problem: Problem, taken: Taken) -> list[list[Layer]]:
        """Layers of all agents that take one of these alternatives."""
        return [self._maker(problem, n, part).layers() for n, part in enumerate(taken)]

    def _maker(self, problem: Problem, n: int, taken: tuple[int, ...]) -> Maker:
        body = problem.bodies[n]
        rates = (rate_borders(body.axes[0], 1), rate_borders(body.axes[1], 1))
        return Maker(problem, body, self.tubes[n], taken, rates)

    def split(self, node: Node) -> bool:
        """Make borders cells of their own, or set alternatives apart, where that is still to do."""
        if not node.problem.borders and node.size <= tuning.TEAM.border_states:
            self.with_borders(node)
            return True
        if node.by_choice:
            return False
        rows = self._children(node, node.problem, True)
        node.by_choice = pairs_of(rows, node.prices) <= tuning.TEAM.split_pairs
        if node.by_choice:
            viewed(node, rows)
        return node.by_choice

    def ascend(self, node: Node) -> bool:
        """Better slopes and prices, where they are still to be found: once while a choice is open;
        where none is, again and again while the last ones or a split raised the bound, and with
        boxes in halves where borders are cells (they keep the bound low where they are not)."""
        session, node.reached, before = self.session, node.bound, node.reached
        enough = before + tuning.TEAM.worth_halves * (session.cutoff - before)
        node.ascended |= np.isfinite(before) and node.bound < enough
        if node.ascended or node.pairs > tuning.TEAM.pairs or not np.isfinite(session.cutoff):
            return False
        node.ascended = True
        ascent = TeamAscent(Agreement(node.problem, node.rows, node.prices, node.masks, self.pool))
        moment = session.deadline.share(tuning.TEAM.ascent_share)
        z, heat = ascent.climb(moment.over, session.cutoff - node.bound)
        node.rows, node.prices = ascent.taken(z)
        if node.problem.borders and not (node.has_open_choice or session.stopped()):
            self._halve(node, ascent, spreads(ascent, z, heat))
        return True

    def _halve(self, node: Node, ascent: TeamAscent, found: list[Floats]) -> None:
        """Halve the boxes that are crossed the most differently, if that is not too much."""
        if not all(np.isfinite(f).all() for f in found):
            return
        least = widest(found, tuning.TEAM.halved)
        rows = halved_rows(ascent, node.rows, found, least, self.tubes, node.taken)
        if pairs_of(rows, node.prices) <= tuning.TEAM.pairs:
            viewed(node, rows)
            node.ascended = False

    def with_borders(self, node: Node) -> None:
        """Borders of alive cells as cells of their own. A plan is in that of the touching cells
        that its first tables take: states are kept for any of them."""
        if self._bordered is None:
            self._bordered = recognise(self.session.frame.compiled, borders=True)
        assert self._bordered is not None
        viewed(node, self._children(node, self._bordered, node.by_choice), self._bordered)

    def _children(self, node: Node, problem: Problem, by_choice: bool) -> list[list[Layer]]:
        """Layers on the cells of a problem; `by_choice`: with states of their own for every
        alternative that is left."""
        out = []
        for n, row in enumerate(node.rows):
            maker = self._maker(problem, n, node.taken[n])
            out.append(maker.by_choice(row) if by_choice else maker.layers(row))
        return out
