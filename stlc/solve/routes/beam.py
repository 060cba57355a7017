"""A run of one agent through the whole mission: a beam of states in product with progress.

Step by step every kept state is moved on by each of a set of controls. What breaks an asserted
atom, the ranges, or can no longer come to a place in time is dropped; of the states in one cell
with the same progress the cheapest stays; and where there are more than the beam holds, those stay
whose cost so far and way still to go (`places.py`) are least, half of them over all, half for
each progress apart. Moves are exact, so what comes out is a run of the mission, for its agent.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.analysis.ranges import Ranges
from stlc.arrays import Bools, Floats, Ints
from stlc.ir.nodes import Linear, Node, Role, walk
from stlc.mission import Agent, Mission
from stlc.solve.routes.agenda import Agenda
from stlc.solve.routes.controls import TOUCH, control_set, within_norm
from stlc.solve.routes.destinations import Places
from stlc.solve.routes.moves import Judge, Moves
from stlc.solve.routes.progress import Open, Progress

Run = tuple[Floats, Floats]
"""States (T+1, n) and inputs (T, m)."""
CostOf = Callable[[int, Floats, Floats], Floats]
"""Cost (N,) of a step's states (N, n) after it and inputs (N, m)."""

_WAIT = 0.25  # of the way of a step: what a step of staying counts
_RIVALS = 12  # cheaper states of a cell that each is compared with
_REACH = 1.05  # grid ways are up to so much longer than the shortest; also one cell is allowed


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """States x (k, n) at a step, their progress (k,) as indices of `opens`, cost, and the index in
    the layer before and the input (k, m) that led there."""

    x: Floats
    progress: Ints
    opens: Sequence[Open]
    cost: Floats
    parent: Ints
    inputs: Floats


@dataclass(slots=True, eq=False)
class Beam:
    """One search; `parts` cut each input's range from 0 to its bound."""

    mission: Mission
    agent: Agent
    ranges: Ranges
    progress: Progress
    judge: Judge
    places: Places
    cost_of: CostOf
    reach: Floats  # (T+1, T+1): metres from one step to another at most
    width: int
    parts: int
    cell: Floats
    per_metre: float
    over: Callable[[], bool]
    _controls: Floats = field(init=False)
    _placed: Bools = field(init=False)
    _fastest: float = field(init=False)

    def __post_init__(self) -> None:
        self._controls = control_set(self.agent, self.parts)
        position = self.agent.dynamics.position
        self._fastest = max(float(self.reach[0, -1]) / max(len(self.reach) - 1, 1), 1e-9)
        self._placed = np.zeros(len(self.agent.start), bool)
        if position is not None:
            self._placed = np.abs(position).sum(axis=0) > 0

    def run(self) -> Run | None:
        """The cheapest run that was kept to the end, or None."""
        x = self.agent.start[None].astype(float)
        start = Moves(self.agent.name, 0, x, np.zeros((1, self._controls.shape[1])), x)
        layer = self._settled(start, np.zeros(1, np.int64), [frozenset()], np.zeros(1),
                              np.zeros(1, np.int64))  # fmt: skip
        layers = [layer] if layer is not None else []
        for t in range(1, len(self.ranges.input_lower) + 1):
            if not layers or self.over():
                return None
            layer = self._advance(layers[-1], t)
            if layer is None:
                return None
            layers.append(layer)
        return self._trace(layers)

    def _trace(self, layers: Sequence[Layer]) -> Run | None:
        """The cheapest run whose formula is settled at the end, followed back by parents."""
        done = [k for k, open_ in enumerate(layers[-1].opens) if not open_]
        ends = np.flatnonzero(np.isin(layers[-1].progress, done))
        if not len(ends):
            return None
        k = int(ends[np.argmin(layers[-1].cost[ends])])
        states, inputs = [], []
        for layer in reversed(layers):
            states.append(layer.x[k])
            inputs.append(layer.inputs[k])
            k = int(layer.parent[k])
        return np.array(states[::-1]), np.array(inputs[::-1][1:])

    def _advance(self, layer: Layer, t: int) -> Layer | None:
        """The next layer, every state under every control that ranges allow; None if empty."""
        controls = self._allowed_controls(t)
        if not len(controls):
            return None
        k, c = len(layer.x), len(controls)
        dynamics = self.agent.dynamics
        after = (layer.x @ dynamics.A.T)[:, None] + (controls @ dynamics.B.T + dynamics.drift)
        after = after.reshape(k * c, -1)
        fine = self._in_ranges(after, t)
        parent = np.repeat(np.arange(k), c)[fine]
        inputs = np.tile(controls, (k, 1))[fine]
        moves = Moves(self.agent.name, t, layer.x[parent], inputs, after[fine])
        cost = layer.cost[parent] + self.cost_of(t, moves.after, inputs)
        return self._settled(moves, layer.progress[parent], layer.opens, cost, parent)

    def _allowed_controls(self, t: int) -> Floats:
        """Those within the bounds of the step, and what is asserted of inputs alone."""
        low, high = self.ranges.input_lower[t - 1] - TOUCH, self.ranges.input_upper[t - 1] + TOUCH
        u = self._controls
        u = u[((u >= low) & (u <= high)).all(axis=1)]
        blank = np.full((len(u), len(self.agent.start)), np.nan)
        moves = Moves(self.agent.name, t, blank, u, blank)
        fine = np.ones(len(u), bool)
        for number in self.progress.asserted.get(t, ()):
            atom = self.progress.atoms[number]
            if of_inputs(atom.node, self.agent.name):
                fine &= self.judge.holds(atom.node, atom.source, moves, {})
        return np.asarray(u[fine])

    def _in_ranges(self, x: Floats, t: int) -> Bools:
        """Which of x (n, states) keep ranges, norms and workspace at step t, up to `judge.miss`."""
        slack = 1e-7 + np.where(self._placed, self.judge.miss, 0.0)
        low, high = self.ranges.state_lower[t] - slack, self.ranges.state_upper[t] + slack
        fine = ((x >= low) & (x <= high)).all(axis=1)
        for norm in self.agent.state_norms:
            fine &= within_norm(x, norm)
        position, workspace = self.agent.dynamics.position, self.mission.workspace
        if position is not None and workspace is not None:
            room = 1e-7 + self.judge.miss
            faces = (x @ position.T) @ workspace.normals.T
            fine &= (faces <= workspace.offsets + room).all(axis=1)
        return np.asarray(fine)

    def _settled(
        self, moves: Moves, progress: Ints, opens: Sequence[Open], cost: Floats, parent: Ints
    ) -> Layer | None:
        """What is left of moves: asserted atoms hold, progress is judged, the best are kept."""
        done: dict[int, dict[Node, Bools]] = {}
        fine = np.ones(len(moves.after), bool)
        for number in self.progress.asserted.get(moves.step, ()):
            atom = self.progress.atoms[number]
            memo = done.setdefault(atom.source, {})
            fine &= self.judge.holds(atom.node, atom.source, moves, memo)
        atoms = self.progress.atoms_at.get(moves.step, [])
        labels = np.zeros((len(fine), len(atoms)), bool)
        for k, number in enumerate(atoms):
            atom = self.progress.atoms[number]
            memo = done.setdefault(atom.source, {})
            labels[:, k] = self.judge.holds(atom.node, atom.source, moves, memo)
        progress, opens, alive = self._progressed(progress, opens, labels, fine, moves.step)
        kept = np.flatnonzero(fine & alive)
        agenda = Agenda.of(self.places, opens, moves.step)
        kept = kept[self._cheapest(moves.after[kept], progress[kept], cost[kept], agenda.due)]
        kept = self._best(moves, progress, cost, kept, agenda)
        if not len(kept):
            return None
        return Layer(moves.after[kept], progress[kept], opens, cost[kept], parent[kept],
                     moves.inputs[kept])  # fmt: skip

    def _progressed(
        self, progress: Ints, opens: Sequence[Open], labels: Bools, fine: Bools, step: int
    ) -> tuple[Ints, list[Open], Bools]:
        """The progress of each move after the step, and whether there is any."""
        atoms = self.progress.atoms_at.get(step, [])
        packed = np.packbits(labels, axis=1) if atoms else np.zeros((len(fine), 1), np.uint8)
        _, first, which = np.unique(
            np.ascontiguousarray(packed).view(f"V{packed.shape[1]}").ravel(),
            return_index=True, return_inverse=True,
        )  # fmt: skip
        pair = progress * len(first) + which
        pairs, back = np.unique(np.where(fine, pair, -1), return_inverse=True)
        made: dict[Open, int] = {}
        memos: dict[int, tuple[dict[int, bool], dict[int, int]]] = {}
        after = np.full(len(pairs), -1)
        for k, both in enumerate(pairs.tolist()):
            if both < 0:
                continue
            p, label = divmod(both, len(first))
            if label not in memos:
                memos[label] = (dict(zip(atoms, labels[first[label]].tolist(), strict=True)), {})
            open_ = self.progress.after(opens[p], step, *memos[label])
            if open_ is not None:
                after[k] = made.setdefault(open_, len(made))
        found = after[back]
        return found, list(made), found >= 0

    def _cheapest(self, x: Floats, progress: Ints, cost: Floats, due: Floats) -> Ints:
        """The cheapest of each cell and progress, without those that a cheaper one dominates."""
        if not len(x):
            return np.empty(0, np.int64)
        key = np.round(x / self.cell).astype(np.int64)
        key -= key.min(axis=0)
        cell = np.zeros(len(x), np.int64)
        for column in key.T:
            cell = cell * (int(column.max()) + 1) + column
        order = np.lexsort((cost, progress, cell))
        first = np.ones(len(order), bool)
        first[1:] = (cell[order][1:] != cell[order][:-1]) | (
            progress[order][1:] != progress[order][:-1]
        )
        order = order[first]
        order = order[np.lexsort((cost[order], cell[order]))]
        beaten = np.zeros(len(order), bool)
        for k in range(1, _RIVALS + 1):
            rival, own = order[:-k], order[k:]
            later = (due[progress[rival]] >= due[progress[own]]).all(axis=1)
            beaten[k:] |= (cell[rival] == cell[own]) & later
        return order[~beaten]

    def _best(self, moves: Moves, progress: Ints, cost: Floats, kept: Ints, agenda: Agenda) -> Ints:
        """The beam's width of `kept`, by cost so far and the way to go (per metre and per step).

        Half of them are the best of all, half the best of each set of tasks left, so that none dies
        out.
        """
        if not len(kept):
            return kept
        way, late = self._way_to_go(moves.after[kept], progress[kept], agenda, moves.step)
        kept, way = kept[~late], way[~late]
        if len(kept) <= self.width:
            return kept
        wait = _WAIT * self._fastest * agenda.stays[progress[kept]]
        score = cost[kept] + self.per_metre * (way + wait)
        order = np.argsort(score, kind="stable")
        rank = np.empty(len(order), np.int64)
        rank[order] = np.arange(len(order))
        todo = np.isfinite(agenda.due) @ 2.0 ** np.arange(agenda.due.shape[1])
        inner = np.lexsort((score, todo[progress[kept]]))
        groups = todo[progress[kept]][inner]
        starts = np.flatnonzero(np.append(True, groups[1:] != groups[:-1]))
        sizes = np.diff(np.append(starts, len(groups)))
        within = np.empty(len(order), np.int64)
        within[inner] = np.arange(len(order)) - np.repeat(starts, sizes)
        chosen = np.argsort(np.minimum(2 * rank, 2 * within * len(starts) + 1), kind="stable")
        return kept[np.sort(chosen[: self.width])]

    def _way_to_go(
        self, x: Floats, progress: Ints, agenda: Agenda, step: int
    ) -> tuple[Floats, Bools]:
        """Metres still to go (k,), and whether some place can't be reached in time (k,)."""
        position = self.agent.dynamics.position
        way, late = np.zeros(len(x)), np.zeros(len(x), bool)
        due, since = agenda.due[progress], agenda.since
        if position is None or not due.shape[1]:
            return way, late
        cells = self.places.cells(x @ position.T)
        ways = np.array([w[cells] for w in self.places.ways[: due.shape[1]]]).T
        todo = np.isfinite(due)
        ends = np.where(todo, due, step).astype(int)
        left = self.reach[step, np.minimum(ends, len(self.reach) - 1)]
        late = (todo & (ways / _REACH - self.places.size.max() > left + 1e-6)).any(axis=1)
        way, open_ = np.zeros(len(x)), since[None] <= step + np.maximum(ways / self._fastest, 1)
        sets, which = np.unique(todo, axis=0, return_inverse=True)
        for k, chosen in enumerate(map(np.flatnonzero, sets)):
            if len(chosen):
                own = which.ravel() == k
                first = ways[np.ix_(own, chosen)] + self.places.tours(chosen.tolist())
                may = open_[np.ix_(own, chosen)]
                may |= ~may.any(axis=1, keepdims=True)
                way[own] = np.where(may, first, np.inf).min(axis=1)
        return way, late


def of_inputs(node: Node, agent: str) -> bool:
    """Whether a formula speaks of inputs of the agent only."""
    leaves = [part for part in walk(node) if not part.children]
    return all(
        isinstance(part, Linear)
        and all(s.role is Role.INPUT and s.owner == agent for s, _ in part.terms)
        for part in leaves
    )
