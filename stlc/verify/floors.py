"""Obstacles that stand on one another: no agent that must keep out of them passes between them.

Each alone is met between its heights and not at them, so that the height at which one ends and the
other begins is outside of both. What two such cover together is solid there, and so is what goes
through that height: the union of all that is closed as elsewhere. Where the two share a line or a
point only, a bar around it is.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np

from stlc.mission import Mission
from stlc.verify.barriers import Out, keep_out
from stlc.verify.chains import Chain
from stlc.verify.clearance import of_place, of_step
from stlc.verify.demands import demanded
from stlc.verify.lone import claim as at_samples
from stlc.verify.prisms import beyond, levels_of, within
from stlc.verify.report import Violation
from stlc.verify.shapes import Bodies, Levels, Stay
from stlc.verify.subject import TOLERANCE
from stlc.verify.together import claim as between_samples
from stlc.verify.unions import DISC, TOUCH, moved

_BAND = 4.0 * TOUCH
"""How near the height of a seam an agent is in it [m]."""


def floors(mission: Mission, chains: Mapping[str, Chain], bodies: Bodies) -> Iterator[Violation]:
    """Samples and motions in the seams between obstacles one of which stands on the other."""
    samples = demanded(mission, at_samples, mission.horizon + 1)
    swept = demanded(mission, between_samples, mission.horizon)
    for agent, places in samples.items():
        if agent not in chains:
            continue
        names = sorted(set().union(*places))
        levels = {name: levels_of(mission, agent, bodies.of(name)) for name in names}
        for pair in combinations(names, 2):
            band = _seam(*(levels[name] for name in pair))
            if band is None:
                continue
            seam = _Floor(mission, bodies, band, levels, pair)
            for t, asked in enumerate(places):
                later = swept[agent][t] if agent in swept and t < len(swept[agent]) else set()
                found = seam.entered(chains[agent], t, asked, later)
                if found is not None:
                    yield _violation(mission, agent, pair, *found)


def _seam(one: Levels, other: Levels) -> Levels | None:
    """The band around the height at which one ends and the other begins; None without any."""
    low, high = max(one[0], other[0]), min(one[1], other[1])
    if not np.isfinite([low, high]).all() or abs(high - low) > TOUCH:
        return None
    return low - _BAND, high + _BAND


@dataclass(frozen=True, slots=True, eq=False)
class _Floor:
    """The seam between two obstacles, within a `band` of heights; `levels` of all obstacles."""

    mission: Mission
    bodies: Bodies
    band: Levels
    levels: Mapping[str, Levels]
    pair: tuple[str, str]

    def entered(
        self, chain: Chain, t: int, asked: set[str], swept: set[str]
    ) -> tuple[float, float] | None:
        """How deep [m] a sample, or the motion after it, is in what is solid, and when."""
        if asked.issuperset(self.pair) and beyond(chain.levels[t], self.band) < 0.0:
            solid = self._solid(asked, t)
            value = 0.0 if solid is None else of_place(chain.places[t], *solid)
            if value < -TOLERANCE:
                return -value, float(t)
        if t >= len(chain.rows) or not swept.issuperset(self.pair):
            return None
        for row, _ in within(chain.rows[t], chain.heights[t], {"seam": self.band}):
            solid = self._solid(swept, t)
            value, when = (0.0, 0.0) if solid is None else of_step(row, *solid[::-1])
            if value < -TOLERANCE:
                return -value, t + when
        return None

    def _solid(self, names: set[str], t: int) -> tuple[Out, Stay] | None:
        """What is solid at the height at step t, and where it is."""
        stays = {name: self.bodies.of(name).at(t) for name in names}
        own = _shared(*(stays[name] for name in self.pair))
        if not own:
            return None
        low, high = self.band[0] + _BAND - TOUCH, self.band[1] - _BAND + TOUCH
        below = [n for n in names if n not in self.pair and abs(self.levels[n][1] - high) <= _BAND]
        above = [n for n in names if n not in self.pair and abs(self.levels[n][0] - low) <= _BAND]
        through = [n for n in names if self.levels[n][0] < low and self.levels[n][1] > high]
        one, other = self.pair
        under, over = (one, other) if self.levels[one][1] <= high else (other, one)
        parts = [*own, *(moved(p, stays[n].start) for n in through for p in stays[n].form.parts)]
        for pairs in (
            ((n, over) for n in below),
            ((under, n) for n in above),
            product(below, above),
        ):
            parts += [part for a, b in pairs for part in _shared(stays[a], stays[b])]
        still = Stay(stays[one].form, np.zeros(2), np.zeros(2))
        return keep_out(parts, self.mission.workspace, still), still


def _shared(one: Stay, other: Stay) -> list[Any]:
    """What two bodies cover together where they stand, seen from above, and bars around what else
    they share."""
    import shapely

    a, b = (moved(shapely.union_all(list(s.form.parts)), s.start) for s in (one, other))
    both = a.intersection(b)
    areas = [p for p in shapely.get_parts(both) if p.area > 0.0]
    wide = {"join_style": "mitre", "mitre_limit": 20.0}
    near = a.buffer(TOUCH, **wide).intersection(b.buffer(TOUCH, **wide))
    rest = near.difference(both.buffer(-TOUCH, **wide).buffer(8.0 * TOUCH, **wide))
    return [*areas, *(p.buffer(DISC) for p in shapely.get_parts(rest) if not p.is_empty)]


def _violation(
    mission: Mission, agent: str, pair: tuple[str, ...], depth: float, time: float
) -> Violation:
    text = (
        f"{agent} is between {' and '.join(pair)}, one of which stands on the other, at "
        f"{time * mission.step:.3g} s: {depth:.4g} m within what both cover"
    )
    return Violation("outside", text, depth, time, agent, None)
