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
from stlc.solve.routes.progress import Open, Progress

MOST_ARCS = 4_000_000
MOST_LEGS = 30_000  # more are too slow to price: 89,000 of data_mule took 0.3 s at each step
_MOST_KINDS = 32
_EDGE = 1e-6
Label = dict[int, bool]


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


def kinds_of(places: Sequence[Floats]) -> list[tuple[frozenset[int], Floats]] | None:
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
        for k, other in enumerate(places):
            both = np.stack([np.maximum(box[:, 0], other[:, 0]),
                             np.minimum(box[:, 1], other[:, 1])], axis=1)  # fmt: skip
            todo.append((members | {k}, both))
    return sorted(found.items(), key=lambda one: sorted(one[0]))


@dataclass(slots=True, eq=False)
class Search:
    """Builds the graph. `place[atom]` for atoms that are places, `kinds` the visits there are."""

    body: Body
    progress: Progress
    place: Mapping[int, int]
    kinds: Sequence[tuple[frozenset[int], Floats]]
    over: Callable[[], bool]
    boxes: Floats = field(init=False)
    _opens: list[Open] = field(default_factory=list)
    _known: dict[Open, int] = field(default_factory=dict)
    _node: dict[tuple[int, int, int, int], int] = field(default_factory=dict)
    _arcs: list[tuple[Ints, Ints]] = field(default_factory=list)
    _ends: list[int] = field(default_factory=list)
    _from: list[int] = field(default_factory=list)
    _legs: int = 0

    def __post_init__(self) -> None:
        start = np.array([[axis.start[0], axis.start[0]] for axis in self.body.axes])
        self.boxes = np.array([*(box for _, box in self.kinds), start])

    def ways(self) -> Ways | None:
        """The graph, without what leads nowhere; None where it is too large."""
        steps, home = len(self.body.axes[0].box) - 1, len(self.kinds)
        at = frozenset(k for k, (_, box) in enumerate(self.kinds) if self._within(box))
        held = frozenset().union(*(self.kinds[k][0] for k in at))
        first = self.progress.after(frozenset(), 0, self._label(0, held), {})
        if first is None:
            return _pruned(self, steps)
        node = self._number(home, home, 0, self._name(first))
        waiting = {(home, 0): (np.array([node]), np.array([self._name(first)]))}
        for t in range(1, steps + 1):
            if self.over():
                return None
            arrived = self._arrivals(t, waiting)
            self._wait(t, waiting)
            for kind, keys in arrived.items():
                opens = np.array([key[3] for key in keys], np.int64)
                waiting[kind, t] = (np.array([self._node[key] for key in keys]), opens)
            if self._is_too_large(t / steps):
                return None
        done = self._name(frozenset())
        for nodes, opens in waiting.values():
            self._ends.extend(nodes[opens == done].tolist())
        return _pruned(self, steps)

    def _is_too_large(self, part: float) -> bool:
        """Whether the graph is after this part of its steps: it grows ever faster, or evenly."""
        return self._legs > part * MOST_LEGS or sum(len(a[0]) for a in self._arcs) > MOST_ARCS

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
        self, t: int, waiting: Mapping[tuple[int, int], tuple[Ints, Ints]]
    ) -> dict[int, dict[tuple[int, int, int, int], None]]:
        """Visits of step t by kind, their arcs noted."""
        arrived: dict[int, dict[tuple[int, int, int, int], None]] = {}
        for kind, (members, _) in enumerate(self.kinds):
            groups = [(key, *both) for key, both in waiting.items()
                      if len(both[0]) and self._may(key, kind, t)]  # fmt: skip
            if not groups:
                continue
            after = self._after(t, np.concatenate([g[2] for g in groups]), self._label(t, members))
            first = 0
            for (before, _), nodes, opens in groups:
                own = after[first : first + len(opens)]
                first += len(opens)
                fine = own >= 0
                unique, back = np.unique(own[fine], return_inverse=True)
                keys = [(before, kind, t, o) for o in unique.tolist()]
                targets = np.array([self._number(*key) for key in keys], np.int64)
                arrived.setdefault(kind, {}).update(dict.fromkeys(keys))
                self._arcs.append((nodes[fine], targets[back]))
                self._legs += len({self._from[node] for node in nodes[fine].tolist()})
        return arrived

    def _wait(self, t: int, waiting: dict[tuple[int, int], tuple[Ints, Ints]]) -> None:
        """Take those that visit nothing at step t a step on."""
        live = {key: both for key, both in waiting.items() if len(both[0])}
        waiting.clear()
        if not live:
            return
        after = self._after(t, np.concatenate([o for _, o in live.values()]),
                            self._label(t, frozenset()))  # fmt: skip
        first = 0
        for key, (nodes, opens) in live.items():
            own = after[first : first + len(opens)]
            first += len(opens)
            if (own >= 0).any():
                waiting[key] = (nodes[own >= 0], own[own >= 0])

    def _may(self, key: tuple[int, int], kind: int, t: int) -> bool:
        """Whether an agent can be at a kind of visit at t that was at another before."""
        before, s = key
        way, allowed = [], True
        for d, axis in enumerate(self.body.axes):
            box, range_ = self.boxes[kind, d], axis.box[t]
            allowed &= box[0] <= range_[1] + _EDGE and box[1] >= range_[0] - _EDGE
            here = self.boxes[before, d]
            low, high = box[0] - here[1], box[1] - here[0]
            fastest = float(np.abs(axis.box[s : t + 1, 2:]).max()) * (t - s)
            allowed &= low <= fastest + _EDGE and high >= -fastest - _EDGE
            way.append((low, high))
        return bool(allowed) and self._fast_enough(way, s, t)

    def _fast_enough(self, way: Sequence[tuple[float, float]], s: int, t: int) -> bool:
        """Whether the faces of the speed polygon allow a way (low, high along each axis)."""
        (xl, xh), (yl, yh) = way
        start = np.array([axis.start[1] for axis in self.body.axes])
        for nx, ny, c in self.body.faces:
            most = max(c, float(nx * start[0] + ny * start[1])) if s == 0 else c
            least = min(nx * xl, nx * xh) + min(ny * yl, ny * yh)
            if least > most * (t - s) + _EDGE:
                return False
        return True


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
