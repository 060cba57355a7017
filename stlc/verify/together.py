"""Obstacles that touch: no agent that must keep out of both passes between them.

Obstacles that move alike are judged as one union, in their own frame; two that move differently by
their union at each of `INSTANTS` times at which the agent is on the border of both.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from stlc.ir.nodes import Motion, Node
from stlc.mission import Mission
from stlc.verify.barriers import keep_out, kept_out
from stlc.verify.chains import Chain
from stlc.verify.clearance import INSTANTS, SURE, of_step
from stlc.verify.demands import demanded
from stlc.verify.prisms import Row, levels_of, within
from stlc.verify.report import Violation
from stlc.verify.shapes import Array, Bodies, Stay
from stlc.verify.subject import TOLERANCE
from stlc.verify.unions import TOUCH, closed_union, moved

Found = tuple[float, float]
"""Minus the depth [m], and the time within the step."""


def passages(mission: Mission, chains: Mapping[str, Chain], bodies: Bodies) -> Iterator[Violation]:
    """Motions through the seam of obstacles that an agent must keep out of at the same time."""
    joints: dict[tuple[int, ...], list[str]] = {}
    for name, places in _avoided(mission).items():
        if name in chains:
            yield from _Passages(mission, name, chains[name], bodies, joints).found(places)


def _avoided(mission: Mission) -> dict[str, list[set[str]]]:
    """For each agent the obstacles that it must keep out of, `swept`, after each step."""
    return demanded(mission, claim, mission.horizon)


def claim(node: Node) -> tuple[str, str] | None:
    """An agent that keeps out of a place by its motion, and the place."""
    swept = node.swept
    if swept is None or swept.motion is not Motion.OUTSIDE or swept.place is None:
        return None
    return swept.agent, swept.place


@dataclass(slots=True, eq=False)
class _Passages:
    mission: Mission
    agent: str
    chain: Chain
    bodies: Bodies
    joints: dict[tuple[int, ...], list[str]] = field(default_factory=dict)

    def found(self, places: Sequence[set[str]]) -> Iterator[Violation]:
        """One violation for each step that passes between obstacles but into none of them."""
        for t, names in self._near(places):
            stays = {n: s for n in names if (s := self.bodies.of(n).stay(t)) is not None}
            levels = {n: levels_of(self.mission, self.agent, self.bodies.of(n)) for n in stays}
            for row, met in within(self.chain.rows[t], self.chain.heights[t], levels):
                some = {n: stays[n] for n in met}
                found = self._worst(row, some) if len(some) > 1 else None
                if found is not None and not self._enters_one(row, some):
                    group, (value, when) = found
                    yield self._violation(group, value, t + when)

    def _near(self, places: Sequence[set[str]]) -> Iterator[tuple[int, list[str]]]:
        """Steps that come near two obstacles or more, and which."""
        names = sorted(set().union(*places))
        if len(names) < 2:
            return
        bodies = [self.bodies.of(name) for name in names]
        low = np.stack([self.chain.least(b)[: len(places)] - b.grow for b in bodies])
        asked = np.array([[name in at for at in places] for name in names])
        near = asked & (low <= SURE)
        for t in np.flatnonzero(near.sum(axis=0) > 1):
            yield int(t), [names[k] for k in np.flatnonzero(near[:, t])]

    def _worst(self, row: Row, stays: Mapping[str, Stay]) -> tuple[Sequence[str], Found] | None:
        """The obstacles that are passed between, and how deep within their union."""
        alike: dict[bytes, dict[str, Stay]] = {}
        for name, stay in stays.items():
            alike.setdefault(np.round(stay.move, 9).tobytes(), {})[name] = stay
        found: list[tuple[Sequence[str], Found]] = []
        for group in alike.values():
            touching = self._touching(group)
            if touching:
                found.append((touching, self._union(row, [group[n] for n in touching])))
        for one, other in combinations(alike.values(), 2):
            for a, b in ((a, b) for a in one for b in other):
                found.append(((a, b), self._between(row, one[a], other[b])))
        passed = [item for item in found if item[1][0] < -TOLERANCE]
        return min(passed, key=lambda item: item[1][0], default=None)

    def _union(self, row: Row, stays: Sequence[Stay]) -> Found:
        """Through the union of obstacles that move alike."""
        first = stays[0]
        parts = [moved(p, s.start - first.start) for s in stays for p in s.form.parts]
        return of_step(row, first, keep_out(parts, self.mission.workspace, first))

    def _between(self, row: Row, one: Stay, other: Stay) -> Found:
        """Through the seam of two obstacles that move differently."""
        import shapely

        fine, places = row
        times, at = np.linspace(fine[0], fine[-1], INSTANTS), np.empty((INSTANTS, 2))
        for axis in (0, 1):
            at[:, axis] = np.interp(times, fine, places[:, axis])
        worst = (0.0, 0.0)
        for k in np.flatnonzero(_on_border(at, times, one) & _on_border(at, times, other)):
            parts = [
                moved(p, s.start + times[k] * s.move) for s in (one, other) for p in s.form.parts
            ]
            union, point = closed_union(parts), shapely.Point(at[k])
            if shapely.contains(union, point):
                worst = min(worst, (-float(union.boundary.distance(point)), float(times[k])))
        return worst

    def _touching(self, group: Mapping[str, Stay]) -> list[str]:
        """Obstacles that touch another at the start of a step."""
        key = tuple(id(stay) for stay in group.values())
        if key not in self.joints:
            near = set()
            for one, other in combinations(group, 2):
                if apart(group[one], group[other]) <= TOUCH:
                    near |= {one, other}
            self.joints[key] = sorted(near)
        return self.joints[key]

    def _enters_one(self, row: Row, stays: Mapping[str, Stay]) -> bool:
        """Whether an obstacle alone is entered, which its own requirement tells."""
        space = self.mission.workspace
        clear = (of_step(row, s, kept_out(s, space))[0] for s in stays.values())
        return any(value < -TOLERANCE for value in clear)

    def _violation(self, group: Sequence[str], value: float, time: float) -> Violation:
        seconds = time * self.mission.step
        text = (
            f"{self.agent} passes between {' and '.join(group)}, which touch, "
            f"at {seconds:.3g} s: {-value:.4g} m within their union"
        )
        return Violation("swept", text, -value, time, self.agent, None)


def _on_border(at: Array, times: Array, stay: Stay) -> NDArray[np.bool_]:
    """Whether places at some times of a step are on the border of an obstacle, or as good as."""
    import shapely

    points = shapely.points(at - stay.start - times[:, None] * stay.move)
    whole = shapely.union_all(list(stay.form.parts))
    return np.asarray(shapely.distance(whole.boundary, points) <= 2.0 * TOUCH)


def apart(one: Stay, other: Stay) -> float:
    """Distance of two bodies at the start of a step [m]."""
    import shapely

    shapes = (moved(shapely.union_all(list(s.form.parts)), s.start) for s in (one, other))
    return float(shapely.distance(*shapes))
