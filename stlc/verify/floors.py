"""Obstacles that stand on one another: no agent that must keep out of both passes between them.

Each alone is met between its heights and not at them, so that the height at which one ends and the
other begins is outside of both. Where both cover a place it is inside of the two together.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any

import numpy as np

from stlc.mission import Mission
from stlc.verify.barriers import keep_out
from stlc.verify.chains import Chain
from stlc.verify.clearance import of_place, of_step
from stlc.verify.demands import demanded
from stlc.verify.lone import claim as at_samples
from stlc.verify.prisms import beyond, levels_of, within
from stlc.verify.report import Violation
from stlc.verify.shapes import Bodies, Levels, Stay
from stlc.verify.subject import TOLERANCE
from stlc.verify.together import claim as between_samples
from stlc.verify.unions import TOUCH, moved

_BAND = 4.0 * TOUCH
"""How near the height of a seam an agent is in it [m]."""


def floors(mission: Mission, chains: Mapping[str, Chain], bodies: Bodies) -> Iterator[Violation]:
    """Samples and motions in the seam between obstacles one of which stands on the other."""
    samples = demanded(mission, at_samples, mission.horizon + 1)
    swept = demanded(mission, between_samples, mission.horizon)
    for agent, places in samples.items():
        chain = chains.get(agent)
        if chain is None:
            continue
        for pair in combinations(sorted(set().union(*places)), 2):
            levels = _seam(*(levels_of(mission, agent, bodies.of(name)) for name in pair))
            for t, names in enumerate(places if levels is not None else []):
                if levels is None or not names.issuperset(pair):
                    continue
                both = t < len(chain.rows) and t < len(swept.get(agent, []))
                motion = both and swept[agent][t].issuperset(pair)
                found = _entered(mission, chain, t, levels, pair, bodies, motion)
                if found is not None:
                    yield _violation(mission, agent, pair, *found)


def _seam(one: Levels, other: Levels) -> Levels | None:
    """The band around the height at which one ends and the other begins; None without any."""
    low, high = max(one[0], other[0]), min(one[1], other[1])
    if not np.isfinite([low, high]).all() or abs(high - low) > TOUCH:
        return None
    return low - _BAND, high + _BAND


def _entered(
    mission: Mission,
    chain: Chain,
    t: int,
    levels: Levels,
    pair: tuple[str, ...],
    bodies: Bodies,
    motion: bool,
) -> tuple[float, float] | None:
    """How deep [m] a sample, or the motion after it, is between two obstacles, and when."""
    stays = [bodies.of(name).at(t) for name in pair]
    solid = _covered(stays)
    if solid is None:
        return None
    still = Stay(stays[0].form, np.zeros(2), np.zeros(2))
    out = keep_out([solid], mission.workspace, still)
    if beyond(chain.levels[t], levels) < 0.0:
        value = of_place(chain.places[t], out, still)
        if value < -TOLERANCE:
            return -value, float(t)
    if motion:
        for row, _ in within(chain.rows[t], chain.heights[t], {"seam": levels}):
            value, when = of_step(row, still, out)
            if value < -TOLERANCE:
                return -value, t + when
    return None


def _covered(stays: list[Stay]) -> Any | None:
    """What two bodies cover together where they stand, seen from above; None where that is none."""
    import shapely

    one, other = (moved(shapely.union_all(list(stay.form.parts)), stay.start) for stay in stays)
    both = one.intersection(other)
    return both if both.area > 0.0 else None


def _violation(
    mission: Mission, agent: str, pair: tuple[str, ...], depth: float, time: float
) -> Violation:
    text = (
        f"{agent} is between {' and '.join(pair)}, one of which stands on the other, at "
        f"{time * mission.step:.3g} s: {depth:.4g} m within what both cover"
    )
    return Violation("outside", text, depth, time, agent, None)
