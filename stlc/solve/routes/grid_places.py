"""Places over the grid of `play.py`, and what the ways to them cost at the least."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.routes.board import Board
from stlc.solve.routes.destinations import Places
from stlc.solve.routes.loose import Spread
from stlc.solve.routes.moves import Moves

_MOST_ALIKE = 12  # kinds of steps: each takes as long as a step of the grid
_SMALL = (0.2, 0.4)  # of the grid's sides
_MOST_SMALL = 6
_FREE = 1e-12


@dataclass(slots=True, eq=False)
class Grid(Places):
    """Places over the grid's points, and what the ways to them cost at the least.

    Ways go by moves that some step allows, so that they see obstacles; where steps differ too much
    by any.
    """

    board: Board = field(kw_only=True)
    _widths: dict[int, float] = field(default_factory=dict)
    _allowed: Any = None  # scipy.sparse.csr_matrix, False for none

    @staticmethod
    def on(board: Board) -> Grid:
        """Over the points of a board."""
        points = np.ones(len(board.points), bool)
        return Grid(board.progress, board.judge, board.agent, board.points[0], np.ones(2),
                    board.shape, points, board=board)  # fmt: skip

    def small(self, places: Ints) -> list[list[int]]:
        """Those of some places that are not wide, by two measures, at most so many: a way through
        all of them sees little where it may leave a place far from where it comes to it."""
        wide = np.array([self._width(int(k)) for k in places])
        order = places[np.argsort(wide, kind="stable")]
        counts = {min(int((wide <= part).sum()), _MOST_SMALL) for part in _SMALL}
        return [order[:count].tolist() for count in sorted(counts) if count]

    def _width(self, place: int) -> float:
        """Of a place, relative to the whole grid, along the longer side."""
        if place not in self._widths:
            i, j = np.divmod(np.flatnonzero(self.masks[place]), self.shape[1])
            x, y = self.board.lines[0][i], self.board.lines[1][j]
            found = [np.ptp(v) / max(np.ptp(line), 1e-9) if len(v) else 0.0
                     for v, line in zip((x, y), self.board.lines, strict=True)]  # fmt: skip
            self._widths[place] = float(max(found))
        return self._widths[place]

    def _resting(self, step: int) -> Moves:
        still = np.zeros_like(self.board.ends[0])
        low = Moves(self.agent.name, step, self.board.ends[0], still, self.board.ends[0])
        return Spread(self.agent.name, step, self.board.ends[1], still, self.board.ends[1], low)

    def _holding(self, number: int) -> Bools:
        if self.progress.atoms[number].moving:
            return np.ones(len(self.free), bool)
        return Places._holding(self, number)

    def _ways(self, mask: Bools) -> Floats:
        """What it costs from each point to the nearest of some, at the least."""
        allowed = self.allowed()
        if allowed is None:
            return self._straight(mask)
        from scipy.sparse.csgraph import dijkstra

        goals = np.flatnonzero(mask)
        if not len(goals):
            return np.zeros(len(mask))
        return np.asarray(dijkstra(allowed, indices=goals, min_only=True))

    def _straight(self, mask: Bools) -> Floats:
        """Weighted distance in the 1-norm, one axis after the other."""
        found = np.where(mask, 0.0, np.inf).reshape(self.shape)
        for axis in range(2):
            line, steps = (
                np.moveaxis(found, axis, 0),
                np.diff(self.board.lines[axis]) * self.board.prices[axis],
            )
            for k, step in enumerate(steps):
                np.minimum(line[k + 1], line[k] + step, out=line[k + 1])
            for k in range(len(steps) - 1, -1, -1):
                np.minimum(line[k], line[k + 1] + steps[k], out=line[k])
        return np.asarray(found.ravel())

    def allowed(self) -> Any:
        """Costs of moves that some step allows, either way, as a sparse matrix; None where steps
        differ too much."""
        if self._allowed is None:
            made = self._joined()
            self._allowed = False if made is None else made
        return None if self._allowed is False else self._allowed

    def _joined(self) -> Any:
        """The moves of all kinds of steps as one symmetric matrix."""
        alike = self.board.alike
        if len(alike) > _MOST_ALIKE:
            return None
        from scipy.sparse import coo_matrix

        found = [self.board.permitted(steps) for steps in alike]
        where, target = (np.concatenate(part) for part in zip(*found, strict=True))
        size = len(self.free)
        pairs = np.unique(np.append(where * size + target, target * size + where))
        rows, columns = np.divmod(pairs, size)
        # a move of no cost is one as well, which a sparse matrix would take for none
        costs = np.maximum(self.board.way(rows, columns), _FREE)
        return coo_matrix((costs, (rows, columns)), (size, size)).tocsr()
