"""The grid of `play.py` as a board: its points, the moves between them, and what holds after one.

Most steps ask the same of a move as others do, a step later: what is asserted and which atoms hold
is found out for all moves of the board once for all steps that are alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.ir.nodes import And, Linear, Node, Or
from stlc.mission import Agent
from stlc.solve.routes.loose import EDGE, Spread
from stlc.solve.routes.moves import Judge, Moves
from stlc.solve.routes.progress import Progress

_ROOM = 1e-3  # m beyond the outermost lines: the ranges end there
_ALIKE = 3  # steps: fewer are not worth looking at all moves of the board
_KEPT = 4  # of what is known of all moves, at most
Form = tuple[int, object]
"""An atom by its requirement and its signals' steps, relative to the step it is judged at."""


class Known(NamedTuple):
    """Of all moves (N * C,): whether they may be, and their class; what holds by class (L, F), the
    column of each form."""

    fine: Bools
    label: Ints
    holds: Bools
    column: dict[Form, int]


@dataclass(eq=False)
class Board:
    """`points` (N, 2) on `lines`, `ends` (2, N, 2) of the open box that x is in while y is there,
    `moves` (C, 2) in lines, the second axis fastest; `prices` (2,) a metre."""

    agent: Agent
    progress: Progress
    judge: Judge
    lower: Floats  # (T+1, 2) ranges
    upper: Floats
    lines: tuple[Floats, Floats]
    prices: Floats
    shape: tuple[int, int] = field(init=False)
    points: Floats = field(init=False)
    ends: Floats = field(init=False)
    fastest: Floats = field(init=False)
    moves: Ints = field(init=False)
    _known: dict[object, Known] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.shape = (len(self.lines[0]), len(self.lines[1]))
        self.points = _crossed(self.lines)
        low = [np.append(g[0] - _ROOM, g[:-1]) for g in self.lines]
        high = [np.append(g[1:], g[-1] + _ROOM) for g in self.lines]
        self.ends = np.stack([_crossed((low[0], low[1])), _crossed((high[0], high[1]))])
        gains = np.abs(np.diag(self.agent.dynamics.B))
        push = np.maximum(np.abs(self.agent.input_lower), np.abs(self.agent.input_upper))
        self.fastest = push * gains
        most = [
            int((np.searchsorted(g, h + d + EDGE) - np.arange(len(g))).max(initial=1))
            for g, h, d in zip(self.lines, high, self.fastest, strict=True)
        ]
        back = [
            int((np.arange(len(g)) - np.searchsorted(g, h - d - EDGE) + 1).max(initial=1))
            for g, h, d in zip(self.lines, low, self.fastest, strict=True)
        ]
        axes = [np.arange(-b, m + 1) for b, m in zip(back, most, strict=True)]
        self.moves = _crossed((axes[0], axes[1])).astype(np.int64)

    @cached_property
    def alike(self) -> list[list[int]]:
        """The steps from 1 on by what they ask."""
        found: dict[object, list[int]] = {}
        for t in range(1, len(self.lower)):
            found.setdefault(self._asked(t), []).append(t)
        return list(found.values())

    @cached_property
    def _company(self) -> dict[int, list[int]]:
        """The steps that are alike, by step."""
        return {t: steps for steps in self.alike for t in steps}

    def _asked(self, t: int) -> object:
        asserted = frozenset(self.form(n, t) for n in self._steady(t))
        return asserted, frozenset(self.form(n, t) for n in self.progress.atoms_at.get(t, ()))

    def is_steady(self, number: int) -> bool:
        """Whether an atom asks the same of moves at whatever step it stands."""
        return True

    def _steady(self, t: int) -> list[int]:
        return [n for n in self.progress.asserted.get(t, ()) if self.is_steady(n)]

    def form(self, number: int, t: int) -> Form:
        """An atom without its step `t`."""
        atom = self.progress.atoms[number]
        return atom.source, _form(atom.node, t)

    def way(self, where: Ints, target: Ints) -> Floats:
        """What y pays from point to point."""
        return np.asarray(np.abs(self.points[target] - self.points[where]) @ self.prices)

    def around(self, t: int, origins: Ints) -> tuple[Bools, list[dict[int, bool]], Ints]:
        """Which moves may be from some points (k, C), what holds after them by class, and the
        class of each."""
        shape = (len(origins), len(self.moves))
        if len(self._company[t]) < _ALIKE:
            pairs = np.repeat(origins, shape[1]), np.tile(self.moves, (shape[0], 1))
            fine, labels, label = self.classes(t, *pairs)
            return fine.reshape(shape), labels, label.reshape(shape)
        known = self._of_all(t)
        rows = known.fine.reshape(-1, shape[1])[origins]
        target = origins[:, None] + self.shifts
        fine = rows & self._ranged(t)[np.clip(target, 0, len(self.points) - 1)]
        changing = [n for n in self.progress.asserted.get(t, ()) if not self.is_steady(n)]
        if changing:
            k, move = np.nonzero(fine)
            fine[k, move] = self._judge(t, origins[k], target[k, move], changing, ())[0]
        columns = [(n, known.column[self.form(n, t)]) for n in self.progress.atoms_at.get(t, ())]
        labels = [{n: bool(row[k]) for n, k in columns} for row in known.holds]
        return fine, labels, known.label.reshape(-1, shape[1])[origins]

    def _of_all(self, t: int) -> Known:
        """What is known of all moves of the board at a step that others are like."""
        key = self._company[t][0]
        if key not in self._known:
            while len(self._known) >= _KEPT:
                del self._known[next(iter(self._known))]
            steps = self._company[t]
            low, high = self.lower[steps].min(axis=0), self.upper[steps].max(axis=0)
            where, moves = self._every()
            fine, labels, label = self._classes(t, self._steady(t), (low, high), where, moves)
            atoms = self.progress.atoms_at.get(t, [])
            holds = np.array([[row[n] for n in atoms] for row in labels], bool)
            column = {self.form(n, t): k for k, n in enumerate(atoms)}
            self._known[key] = Known(fine, label, holds.reshape(len(labels), -1), column)
        return self._known[key]

    def _every(self) -> tuple[Ints, Ints]:
        n, c = len(self.points), len(self.moves)
        return np.repeat(np.arange(n), c), np.tile(self.moves, (n, 1))

    @cached_property
    def shifts(self) -> Ints:
        """By how much each move shifts the number of a point."""
        return np.asarray(self.moves @ np.array([self.shape[1], 1]))

    def _ranged(self, t: int) -> Bools:
        """The points (N,) that x may be around at a step."""
        return self._between(self.lower[t], self.upper[t])

    def _between(self, lower: Floats, upper: Floats) -> Bools:
        fine = (self.ends[1] >= lower - EDGE) & (self.ends[0] <= upper + EDGE)
        return np.asarray(fine.all(axis=1))

    def classes(
        self, t: int, where: Ints, moves: Ints
    ) -> tuple[Bools, list[dict[int, bool]], Ints]:
        """Which moves may be (k,), what holds after them by class, and the class of each."""
        asserted = self.progress.asserted.get(t, [])
        return self._classes(t, asserted, (self.lower[t], self.upper[t]), where, moves)

    def _classes(
        self,
        t: int,
        asserted: Sequence[int],
        ranges: tuple[Floats, Floats],
        where: Ints,
        moves: Ints,
    ) -> tuple[Bools, list[dict[int, bool]], Ints]:
        """As `classes`, with these atoms asserted, within these ranges."""
        fine, target = self._inside(ranges, where, moves)
        atoms = self.progress.atoms_at.get(t, [])
        label = np.zeros(len(where), np.int64)
        own = np.flatnonzero(fine)
        good, holds = self._judge(t, where[own], target[own], asserted, atoms)
        fine[own[~good]] = False
        if not len(own):
            return fine, [dict.fromkeys(atoms, False)], label
        packed = np.packbits(holds, axis=1) if atoms else np.zeros((len(own), 1), np.uint8)
        keys = np.ascontiguousarray(packed).view(f"V{packed.shape[1]}").ravel()
        _, first, inverse = np.unique(keys, return_index=True, return_inverse=True)
        label[own] = inverse.ravel()
        return fine, [dict(zip(atoms, holds[k].tolist(), strict=True)) for k in first], label

    def permitted(self, steps: Sequence[int]) -> tuple[Ints, Ints]:
        """All moves (k,) that what is asserted of steps that are alike allows within the ranges of
        any: from where, to where."""
        earlier = np.array(steps) - 1
        near = self._between(self.lower[earlier].min(axis=0), self.upper[earlier].max(axis=0))
        if len(steps) >= _ALIKE:
            fine = self._of_all(steps[0]).fine & np.repeat(near, len(self.moves))
            where, shift = np.divmod(np.flatnonzero(fine), len(self.moves))
            return where, where + self.shifts[shift]
        origins = np.flatnonzero(near)
        where, moves = np.repeat(origins, len(self.moves)), np.tile(self.moves, (len(origins), 1))
        low, high = self.lower[steps].min(axis=0), self.upper[steps].max(axis=0)
        fine, target = self._inside((low, high), where, moves)
        where, target = where[fine], target[fine]
        good = self._judge(steps[0], where, target, self._steady(steps[0]), ())[0]
        return where[good], target[good]

    def _inside(
        self, ranges: tuple[Floats, Floats], where: Ints, moves: Ints
    ) -> tuple[Bools, Ints]:
        """Moves that end on the grid, within the ranges, and the points where they do."""
        at = np.column_stack(np.divmod(where, self.shape[1])) + moves
        fine = ((at >= 0) & (at < np.array(self.shape))).all(axis=1)
        target = np.where(fine, at[:, 0] * self.shape[1] + at[:, 1], where)
        fine &= self._between(*ranges)[target]
        least, most = self._ways(where, target)
        fine &= ((least <= self.fastest + EDGE) & (most >= -self.fastest - EDGE)).all(axis=1)
        return np.asarray(fine), target

    def _ways(self, where: Ints, target: Ints) -> tuple[Floats, Floats]:
        """Least and greatest way of x (k, 2) while y moves: it ends beyond the line y moves to."""
        low, high = self.ends
        here, there = self.points[where], self.points[target]
        least = np.where(there > here, there, low[target]) - high[where]
        most = np.where(there < here, there, high[target]) - low[where]
        return least, most

    def _judge(
        self, t: int, where: Ints, target: Ints, asserted: Sequence[int], atoms: Sequence[int]
    ) -> tuple[Bools, Bools]:
        """Whether what is asserted holds (k,), and these other atoms (k, atoms)."""
        moves = self._moving(t, where, target)
        memos: dict[int, dict[Node, Bools]] = {}

        def judged(number: int) -> Bools:
            atom = self.progress.atoms[number]
            memo = memos.setdefault(atom.source, {})
            return self.judge.holds(atom.node, atom.source, moves, memo)

        good = np.ones(len(where), bool)
        for number in asserted:
            good &= judged(number)
        holds = np.zeros((len(where), len(atoms)), bool)
        for k, number in enumerate(atoms):
            holds[:, k] = judged(number)
        return good, holds

    def _moving(self, t: int, where: Ints, target: Ints) -> Moves:
        """What x may do while y moves."""
        (low, high), name = self.ends, self.agent.name
        ways = [np.clip(w, -self.fastest, self.fastest) for w in self._ways(where, target)]
        inputs = np.sort(np.array(ways) / np.diag(self.agent.dynamics.B), axis=0)
        inputs += np.array([-EDGE, EDGE])[:, None, None]  # its ends may be reached
        below = Moves(name, t, low[where], inputs[0], low[target])
        return Spread(name, t, high[where], inputs[1], high[target], below)

    def judged(self, t: int, where: Ints, target: Ints) -> tuple[Bools, list[dict[int, bool]]]:
        """Whether what is asserted holds (k,), and the other atoms of a step by move."""
        atoms = self.progress.atoms_at.get(t, [])
        good, holds = self._judge(t, where, target, self.progress.asserted.get(t, []), atoms)
        return good, [dict(zip(atoms, row.tolist(), strict=True)) for row in holds]


def _crossed(axes: tuple[Floats, Floats] | tuple[Ints, Ints]) -> Floats:
    """All pairs (N, 2), the second axis fastest."""
    return np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 2)


def _form(node: Node, step: int) -> object:
    """A formula by its signals' steps relative to a step."""
    if isinstance(node, Linear):
        terms = ((s.owner, s.role, s.index, s.shift - step, value) for s, value in node.terms)
        return node.constant, node.unit, tuple(terms)
    if isinstance(node, And | Or):
        return type(node), tuple(_form(arg, step) for arg in node.args)
    return node
