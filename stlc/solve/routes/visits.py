"""All ways of one agent from visit to visit, with what each leaves open of the mission.

Atoms that keep a position within a box are *places*; a *visit* is a step within some of them, the
others of the boxes left out. Between visits no place is met, and all that is no place is taken to
hold. Formulas are monotone, so every run that fulfils the mission is a way of this graph: its
nodes are (where from, where, step, progress), its arcs the legs that the agent is fast enough for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from stlc.arrays import Bools, Floats, Ints
from stlc.solve.relaxation.problem import Body
from stlc.solve.routes.box_atoms import common
from stlc.solve.routes.pace import Pace
from stlc.solve.routes.progress import Open, Progress

MOST_ARCS = 4_000_000
MOST_LEGS = 30_000  # more are too slow to price: 89,000 of data_mule took 0.3 s at each step
_MOST_KINDS = 32
Label = dict[int, bool]
Waiting = dict[int, dict[int, tuple[Ints, Ints]]]
"""By kind and step of the last visit: nodes, and what is open by now."""


@dataclass(frozen=True, slots=True, eq=False)
class Ways:
    """Arcs (n,) from node `source` to `target`, sorted by target, and the leg of each; `ends` are
    nodes that nothing need follow.

    stops[node] is the stop it is at; a stop is (from, kind, step). legs (l, 2) are stops; boxes
    (kinds + 1, 2, 2) of positions, the start last. steps (nodes,) ascend.
    """

    source: Ints
    target: Ints
    leg: Ints
    ends: Ints
    stops: Ints
    steps: Ints
    legs: Ints
    stop: Ints  # (stops, 3)
    boxes: Floats


Kind = tuple[frozenset[int], Floats]
"""Visits within some places, the others left out, and a box (2, 2: axis, low and high) of
positions."""


def kinds_of(places: Sequence[Floats]) -> list[Kind] | None:
    """Sets of places (2, 2) that meet, with what they share; None for too many."""
    found: dict[frozenset[int], Floats] = {}
    todo = [(frozenset([k]), box) for k, box in enumerate(places)]
    while todo:
        members, box = todo.pop()
        if members in found or (box[:, 0] > box[:, 1]).any():
            continue
        found[members] = box
        if len(found) > _MOST_KINDS:
            return None
        todo.extend((members | {k}, common(box, other)) for k, other in enumerate(places))
    return sorted(found.items(), key=lambda one: sorted(one[0]))


@dataclass(slots=True, eq=False)
class Search:
    """Builds the graph. `place[atom]` for atoms that are places, `kinds` the visits there are;
    `told`: whether nodes tell where the agent comes from."""

    body: Body
    progress: Progress
    place: Mapping[int, int]
    kinds: Sequence[Kind]
    over: Callable[[], bool]
    told: bool = True
    boxes: Floats = field(init=False)
    _pace: Pace = field(init=False)
    _opens: list[Open] = field(init=False, default_factory=list)
    _known: dict[Open, int] = field(init=False, default_factory=dict)
    _node: dict[tuple[int, int, int, int], int] = field(init=False, default_factory=dict)
    _arcs: list[tuple[Ints, Ints]] = field(init=False, default_factory=list)
    _ends: list[int] = field(init=False, default_factory=list)
    _from: list[int] = field(init=False, default_factory=list)
    _legs: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        start = np.array([[axis.start[0], axis.start[0]] for axis in self.body.axes])
        self.boxes = np.array([*(box for _, box in self.kinds), start])
        self._pace = Pace.of(self.body, self.boxes)

    def ways(self) -> Ways | None:
        """The graph, without what leads nowhere; None where it is too large."""
        steps, home = len(self.body.axes[0].box) - 1, len(self.kinds)
        at = (members for members, box in self.kinds if self._within(box))
        held = frozenset[int]().union(*at)
        first = self.progress.after(frozenset(), 0, self._label(0, held), {})
        if first is None:
            return _pruned(self, steps)
        node, busy = self._number(home, home, 0, self._name(first)), self._last_start()
        waiting: Waiting = {home: {0: (np.array([node]), np.array([self._name(first)]))}}
        for t in range(1, steps + 1):
            if self.over():
                return None
            arrived = self._arrivals(t, waiting)
            self._wait(t, waiting)
            for kind, keys in arrived.items():
                opens = np.array([key[3] for key in keys], np.int64)
                nodes = np.array([self._node[key] for key in keys])
                waiting.setdefault(kind, {})[t] = (nodes, opens)
            if t >= busy:
                self._finish(waiting)
            if self._is_too_large(t / steps):
                return None
        return _pruned(self, steps)

    def _is_too_large(self, part: float) -> bool:
        """Whether the graph is after this part of its steps: it grows ever faster, or evenly."""
        return self._legs > part * MOST_LEGS or sum(len(a[0]) for a in self._arcs) > MOST_ARCS

    def _last_start(self) -> int:
        """The step from which on nothing new is asked for."""
        return max(self.progress.starting, default=0)

    def _finish(self, waiting: Waiting) -> None:
        """Let those end that have nothing left to do."""
        done = self._name(frozenset())
        for steps in waiting.values():
            for s, (nodes, opens) in steps.items():
                self._ends.extend(nodes[opens == done].tolist())
                steps[s] = (nodes[opens != done], opens[opens != done])

    def _within(self, box: Floats) -> bool:
        start = np.array([axis.start[0] for axis in self.body.axes])
        return bool(((start >= box[:, 0]) & (start <= box[:, 1])).all())

    def _label(self, t: int, places: frozenset[int]) -> Label:
        return {a: self.place.get(a) in places or a not in self.place
                for a in self.progress.atoms_at.get(t, ())}  # fmt: skip

    def _name(self, open_: Open) -> int:
        if open_ not in self._known:
            self._known[open_] = len(self._opens)
            self._opens.append(open_)
        return self._known[open_]

    def _number(self, before: int, kind: int, t: int, open_: int) -> int:
        number = self._node.setdefault((before, kind, t, open_), len(self._node))
        if number == len(self._from):
            self._from.append(before)
        return number

    def _after(self, t: int, opens: Ints, label: Label) -> Ints:
        """The numbers of what is open after a step (k,), -1 for what can't be fulfilled."""
        memo: dict[int, int] = {}
        unique, back = np.unique(opens, return_inverse=True)
        found = [self.progress.after(self._opens[o], t, label, memo) for o in unique.tolist()]
        return np.array([-1 if o is None else self._name(o) for o in found], np.int64)[back]

    def _arrivals(
        self, t: int, waiting: Waiting
    ) -> dict[int, dict[tuple[int, int, int, int], None]]:
        """Visits of step t by kind, their arcs noted."""
        arrived: dict[int, dict[tuple[int, int, int, int], None]] = {}
        for kind, (members, _) in enumerate(self.kinds):
            groups = [
                (before, *both) for before, steps in waiting.items()
                for s, both in steps.items() if self._pace.may(before, s, kind, t) and len(both[0])
            ]  # fmt: skip
            if not groups:
                continue
            after = self._after(t, np.concatenate([g[2] for g in groups]), self._label(t, members))
            first = 0
            for before, nodes, opens in groups:
                own = after[first : first + len(opens)]
                first += len(opens)
                fine = own >= 0
                unique, back = np.unique(own[fine], return_inverse=True)
                told = before if self.told else 0
                keys = [(told, kind, t, o) for o in unique.tolist()]
                targets = np.array([self._number(*key) for key in keys], np.int64)
                arrived.setdefault(kind, {}).update(dict.fromkeys(keys))
                self._arcs.append((nodes[fine], targets[back]))
                self._legs += len({self._from[node] for node in nodes[fine].tolist()})
        return arrived

    def _wait(self, t: int, waiting: Waiting) -> None:
        """Take those that visit nothing at step t a step on."""
        live = [(kind, s, *both) for kind, steps in waiting.items() for s, both in steps.items()
                if len(both[0])]  # fmt: skip
        waiting.clear()
        if not live:
            return
        after = self._after(t, np.concatenate([opens for *_, opens in live]),
                            self._label(t, frozenset()))  # fmt: skip
        first = 0
        for kind, s, nodes, opens in live:
            own = after[first : first + len(opens)]
            first += len(opens)
            if (own >= 0).any():
                waiting.setdefault(kind, {})[s] = (nodes[own >= 0], own[own >= 0])


def _pruned(search: Search, steps: int) -> Ways:
    """What lies on a way from the start to an end, nodes by step, arcs by target."""
    keys = np.array(list(search._node), np.int64).reshape(-1, 4)
    none = np.empty(0, np.int64)
    source = np.concatenate([none, *(a for a, _ in search._arcs)])
    target = np.concatenate([none, *(b for _, b in search._arcs)])
    useful = np.zeros(len(keys), bool)
    useful[np.array(search._ends, np.int64)] = True
    useful = _leading(useful, keys[:, 2], source, target, steps)
    kept = useful[source] & useful[target]
    source, target = source[kept], target[kept]
    order = np.lexsort((np.arange(len(keys)), keys[:, 2]))
    order = order[useful[order]]
    rank = np.full(len(keys), -1)
    rank[order] = np.arange(len(order))
    keys = keys[order]
    stop, stops = np.unique(keys[:, :3], axis=0, return_inverse=True)
    stops = stops.ravel()
    source, target = rank[source], rank[target]
    pair = stops[source] * max(len(stop), 1) + stops[target]
    pairs, leg = np.unique(pair, return_inverse=True)
    by_target = np.argsort(target, kind="stable")
    ends = np.unique(rank[np.array(search._ends, np.int64)])
    return Ways(
        source[by_target], target[by_target], leg.ravel()[by_target], ends[ends >= 0], stops,
        keys[:, 2], np.stack(np.divmod(pairs, max(len(stop), 1)), axis=1), stop, search.boxes,
    )  # fmt: skip


def _leading(useful: Bools, steps: Ints, source: Ints, target: Ints, last: int) -> Bools:
    """Nodes from which a useful one is reached, the last steps first."""
    by_step = np.argsort(steps[target], kind="stable")
    bounds = np.searchsorted(steps[target][by_step], np.arange(last + 2))
    for t in range(last, 0, -1):
        own = by_step[bounds[t] : bounds[t + 1]]
        useful[source[own[useful[target[own]]]]] = True
    return useful
