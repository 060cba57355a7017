"""Where an agent has to go: places of obligations, and the ways to them around obstacles.

Over a grid of the workspace, the place of an obligation is where an agent could fulfil one of its
alternatives at that alternative's last step; ways go over cells where an agent at rest keeps what
is asserted (Dijkstra over eight neighbours, from each place once). Both guide a search and judge
what it can still reach; neither proves anything.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.mission import Agent
from stlc.solve.routes.moves import Judge, Moves
from stlc.solve.routes.progress import Progress

if TYPE_CHECKING:
    from stlc.ir.nodes import Node

_CELLS = 56  # along the longer side
_FAR = 1e6
_FEW = 7  # places: 2^k k^2 sums


class Window(NamedTuple):
    """An obligation's place, from when and by when it has to be reached, and the first step at
    which the obligation may be fulfilled."""

    place: int
    since: int
    by: int
    done: int


@dataclass(slots=True, eq=False)
class Places:
    """`ways[k]` (cells,) [m] to place k; `between` (places, places) [m]."""

    progress: Progress
    judge: Judge
    agent: Agent
    low: Floats
    size: Floats
    shape: tuple[int, int]
    free: Bools
    ways: list[Floats] = field(default_factory=list)
    masks: list[Bools] = field(default_factory=list)
    _place: dict[int, int] = field(default_factory=dict)
    _known: dict[bytes, int] = field(default_factory=dict)
    _tours: dict[tuple[int, ...], Floats] = field(default_factory=dict)
    _holds: dict[int, Bools] = field(default_factory=dict)
    _last: dict[int, int] = field(default_factory=dict)
    _windows: dict[int, Window] = field(default_factory=dict)

    @staticmethod
    def of(progress: Progress, judge: Judge, agent: Agent, low: Floats, high: Floats,
           steps: int) -> Places:  # fmt: skip
        """Over the box from low to high (2,) [m]."""
        size = float((high - low).max()) / _CELLS
        counts = np.maximum(np.ceil((high - low) / size - 1e-9).astype(int), 1)
        shape = (int(counts[0]), int(counts[1]))
        places = Places(progress, judge, agent, low, (high - low) / counts, shape,
                        np.ones(shape[0] * shape[1], bool))  # fmt: skip
        blocked = [places._blocked(t) for t in {steps // 3, steps // 2, (2 * steps) // 3}]
        places.free = ~np.logical_and.reduce(blocked)
        return places

    def _states(self) -> Floats:
        """An agent at rest (cells, n) in the middle of each cell."""
        i, j = np.divmod(np.arange(len(self.free)), self.shape[1])
        points = self.low + (np.column_stack([i, j]) + 0.5) * self.size
        position = self.agent.dynamics.position
        assert position is not None
        rest = self.agent.start * (np.abs(position).sum(axis=0) > 0)
        shift = points - position @ rest
        return np.asarray(rest + shift @ np.linalg.pinv(position).T)

    def _resting(self, step: int) -> Moves:
        states = self._states()
        inputs = np.zeros((len(states), self.agent.dynamics.B.shape[1]))
        return Moves(self.agent.name, step, states, inputs, states)

    def _blocked(self, step: int) -> Bools:
        moves, out = self._resting(step), np.zeros(len(self.free), bool)
        done: dict[int, dict[Node, Bools]] = {}
        for number in self.progress.asserted.get(step, ()):
            atom = self.progress.atoms[number]
            memo = done.setdefault(atom.source, {})
            out |= ~self.judge.holds(atom.node, atom.source, moves, memo)
        return out

    def place_of(self, number: int) -> int:
        """The place of an obligation."""
        if number not in self._place:
            kind, args = self.progress.parts[number]
            mask = np.zeros(len(self.free), bool)
            for arg in args if kind == "or" else (number,):
                mask |= self._at_last(arg)
            self._place[number] = self._add(mask)
        return self._place[number]

    def _at_last(self, number: int) -> Bools:
        last = self.last(number)
        kind, args = self.progress.parts[number]
        atoms = [a for a in (args if kind == "and" else (number,))
                 if a in self.progress.atoms and self.progress.atoms[a].step == last]  # fmt: skip
        return np.asarray(np.logical_and.reduce([np.ones(len(self.free), bool),
                                                 *(self._holding(a) for a in atoms)]))  # fmt: skip

    def _holding(self, number: int) -> Bools:
        if number not in self._holds:
            atom = self.progress.atoms[number]
            self._holds[number] = self.judge.holds(
                atom.node, atom.source, self._resting(atom.step), {}
            )
        return self._holds[number]

    def last(self, number: int) -> int:
        """The last step that a formula speaks of."""
        if number not in self._last:
            atom = self.progress.atoms.get(number)
            args = self.progress.parts[number][1]
            self._last[number] = (
                atom.step if atom else max((self.last(a) for a in args), default=-1)
            )
        return self._last[number]

    def _add(self, mask: Bools) -> int:
        key = mask.tobytes()
        if key not in self._known:
            self._known[key] = len(self.ways)
            self.masks.append(mask)
            self.ways.append(self._ways(mask))
        return self._known[key]

    def _ways(self, mask: Bools) -> Floats:
        from scipy.sparse.csgraph import dijkstra

        goals = np.flatnonzero(mask & self.free)
        goals = goals if len(goals) else np.flatnonzero(mask)
        if not len(goals):
            return np.zeros(len(self.free))
        found = dijkstra(self._graph(), indices=goals, min_only=True)
        return np.asarray(np.minimum(found, _FAR))

    def _graph(self) -> object:
        """Cells with their eight neighbours, lengths in metres, as a symmetric sparse matrix.

        Ways through one blocked middle cost four times their length: cells may be half free.
        """
        from scipy.sparse import csr_matrix

        number = np.arange(len(self.free)).reshape(self.shape)
        free, rows, cols, lengths = self.free.reshape(self.shape), [], [], []
        for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
            a = (slice(0, self.shape[0] - di), slice(max(0, -dj), self.shape[1] - max(0, dj)))
            b = (slice(di, self.shape[0]), slice(max(0, dj), self.shape[1] - max(0, -dj)))
            both = free[a] | free[b]  # a way may begin beside a cell whose middle is blocked
            both &= free[a] & free[b] | (di * dj == 0)
            rows.append(number[a][both])
            cols.append(number[b][both])
            step = float(np.hypot(di * self.size[0], dj * self.size[1]))
            costly = np.where(free[a] & free[b], step, 4.0 * step)[both]
            lengths.append(costly)
        i, j, v = (np.concatenate(x) for x in (rows, cols, lengths))
        size = len(self.free)
        return csr_matrix((np.append(v, v), (np.append(i, j), np.append(j, i))), (size, size))

    def cells(self, points: Floats) -> Ints:
        """The cell of each point (N, 2)."""
        k = np.clip(((points - self.low) / self.size).astype(int), 0, np.array(self.shape) - 1)
        return np.asarray(k[:, 0] * self.shape[1] + k[:, 1])

    def window(self, number: int) -> Window:
        """When an obligation's place has to be reached, and when it is fulfilled at the least."""
        if number not in self._windows:
            kind, args = self.progress.parts[number]
            parts = args if kind == "or" else (number,)
            place = self.place_of(number)
            arrivals = [self._arrival(a, self.masks[place]) for a in parts]
            self._windows[number] = Window(
                place, min(arrivals), max(arrivals), min(self.last(a) for a in parts)
            )
        return self._windows[number]

    def _arrival(self, number: int, place: Bools) -> int:
        """From when on an alternative asks to be at the place, without a break to its end."""
        kind, args = self.progress.parts[number]
        steps: dict[int, Bools] = {}
        for a in args if kind == "and" else ():
            atom = self.progress.atoms.get(a)
            if atom is not None:
                held = self._holding(a)
                steps[atom.step] = steps[atom.step] & held if atom.step in steps else held
        arrival = self.last(number)
        while arrival - 1 in steps and not (steps[arrival - 1] & ~place).any():
            arrival -= 1
        return arrival

    def tours(self, places: Sequence[int]) -> Floats:
        """Least way (k,) through all places (k,) [m] that begins at each of them.

        Exact (Held and Karp, 1962) for a few; else a least spanning tree, which no way beats.
        """
        key = tuple(places)
        if key not in self._tours:
            between = np.array([[self._between(a, b) for b in key] for a in key])
            few = len(key) <= _FEW
            self._tours[key] = _paths(between) if few else np.full(len(key), _tree(between))
        return self._tours[key]

    def _between(self, a: int, b: int) -> float:
        mask = self.masks[b]
        return float(self.ways[a][mask].min()) if mask.any() else 0.0


def _paths(between: Floats) -> Floats:
    """Shortest Hamiltonian path from each node, of a few."""
    size = len(between)
    best = {(1 << k, k): 0.0 for k in range(size)}
    for seen in range(1, 1 << size):
        for k in (k for k in range(size) if seen >> k & 1 and seen != 1 << k):
            rest = seen ^ (1 << k)
            best[seen, k] = min(between[k, m] + best[rest, m]
                                for m in range(size) if rest >> m & 1)  # fmt: skip
    return np.array([best[(1 << size) - 1, k] for k in range(size)])


def _tree(between: Floats) -> float:
    """Length of a least spanning tree (Prim)."""
    near, total = between[0].copy(), 0.0
    todo = np.arange(1, len(between))
    while len(todo):
        k = int(todo[np.argmin(near[todo])])
        total += float(near[k])
        near = np.minimum(near, between[k])
        todo = todo[todo != k]
    return total
