"""More than two agents: guides, neighbourhoods of the incumbent, and a bound over the pairs.

The cost of a plan is the sum over pairs of what the pair costs alone, with each agent's effort and
station costs divided among its pairs. So least costs of the pairs add up to a bound of the whole.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from stlc.solve.links.descent import Descent
from stlc.solve.links.joint import Joint
from stlc.solve.links.layers import Layer, Maker, rate_borders
from stlc.solve.links.problem import Body, Problem
from stlc.solve.links.reach import tubes
from stlc.solve.links.session import Session
from stlc.solve.links.shares import coarsened, pair_share, stage_cost

_TOUCH = 1e-6
_SIZES = ((144, 4), (144, 2), (64, 2), (36, 2))  # cells and bins of the rate, for the bound
_MOST_PAIRS = 3_000_000  # pairs of states at a step
_ROUND = 4.0  # s a neighbourhood


class Team:
    """Works on a session until the neighbourhoods bring nothing more."""

    def __init__(self, session: Session) -> None:
        self.session, self.problem = session, session.problem
        self.descent = Descent(self.problem, session.stopped)

    def run(self) -> bool:
        """Search; True when the incumbent is proven within the gap."""
        if not self.descent.possible:
            return False
        order = list(range(len(self.problem.bodies)))
        self._guide(order)
        self._bound()
        self._guide(order[::-1])
        if self.session.x is not None:
            self._improve()
        return self.session.x is not None and self.session.bound >= self.session.cutoff

    def _guide(self, order: list[int]) -> None:
        runs = self.descent.run(order, {}, 3)
        if runs is not None:
            self.session.follow([runs[i] for i in sorted(order)], 20.0)

    def _improve(self) -> None:
        """Free two agents at a time around the incumbent, until a whole round changes nothing."""
        cell = min(float(np.diff(e).max()) for e in self.problem.edges)
        self.session.around((), 0.0, _ROUND, 1e-3)
        for patience in (1.0, 3.0):
            before = float("inf")
            while self.session.value < before - 1e-4 * abs(self.session.value):
                before = self.session.value
                for free in self._subsets():
                    self.session.around(free, 0.7 * cell, patience * _ROUND, 1e-3)
                    if self.session.stopped():
                        return

    def _subsets(self) -> Iterator[tuple[int, ...]]:
        return itertools.combinations(range(len(self.problem.bodies)), 2)

    def _bound(self) -> None:
        """Add up the pairs' least costs, on the finest boxes that fit."""
        for cells, bins in _SIZES:
            coarse = coarsened(self.problem, cells)
            rows = [_layers(coarse, body, bins) for body in coarse.bodies]
            if self.session.stopped() or not all(len(layer) for row in rows for layer in row):
                return
            widest = sorted(max(len(layer) for layer in row) for row in rows)[-2:]
            if widest[0] * widest[1] <= _MOST_PAIRS:
                self._add_up(coarse, rows)
                return

    def _add_up(self, coarse: Problem, rows: list[list[Layer]]) -> None:
        total = self.problem.rest
        for i, j in coarse.pairs:
            if self.session.stopped():
                return
            part = pair_share(coarse, (i, j))
            bodies = (part.bodies[0], part.bodies[1])
            cost = [stage_cost(part, t) for t in range(1, part.steps + 1)]
            joint = Joint(bodies, (rows[i], rows[j]), cost, None)
            total += joint.forward()
        self.session.raise_bound(total - _TOUCH)


def _layers(problem: Problem, body: Body, bins: int) -> list[Layer]:
    sets = tubes(body, problem.steps)
    borders = (rate_borders(body.axes[0], bins), rate_borders(body.axes[1], bins))
    return Maker(problem, body, sets, sets.possible, borders).layers()
