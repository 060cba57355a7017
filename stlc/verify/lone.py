"""Samples where obstacles touch: no agent that must keep out of all at a step may be there.

Each obstacle alone is a closed set, so that their common border, and a point in which their corners
meet, is outside of each. Together they hold it inside, and the union is closed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import combinations

import numpy as np

from stlc.ir.nodes import Motion, Node
from stlc.mission import Mission
from stlc.verify.barriers import keep_out
from stlc.verify.chains import Chain
from stlc.verify.clearance import SURE, of_place
from stlc.verify.demands import demanded
from stlc.verify.prisms import asked_of, levels_of
from stlc.verify.report import Violation
from stlc.verify.shapes import Bodies, Stay
from stlc.verify.subject import TOLERANCE
from stlc.verify.together import apart
from stlc.verify.unions import TOUCH, moved


def lone_samples(
    mission: Mission, chains: Mapping[str, Chain], bodies: Bodies
) -> Iterator[Violation]:
    """Samples inside the union of touching obstacles and in none of them."""
    for agent, places in demanded(mission, claim, mission.horizon + 1).items():
        for t, names in _near(mission, agent, chains.get(agent), places, bodies):
            found = _inside(mission, chains[agent], t, names, bodies)
            if found is not None:
                yield _violation(mission, agent, t, *found)


def claim(node: Node) -> tuple[str, str] | None:
    """Sample or motion: both speak of the sample."""
    swept, member = node.swept, node.member
    if swept is not None and swept.motion is Motion.OUTSIDE and swept.place is not None:
        return swept.agent, swept.place
    if member is not None and not member.inside and isinstance(member.subject, str):
        return member.subject, member.place
    return None


def _near(
    mission: Mission, agent: str, chain: Chain | None, places: list[set[str]], bodies: Bodies
) -> Iterator[tuple[int, list[str]]]:
    """Steps at which an agent is near two obstacles or more that it must keep out of."""
    names = sorted(set().union(*places))
    if chain is None or len(names) < 2:
        return
    each = [bodies.of(name) for name in names]
    away = np.stack([chain.least(body)[: len(places)] - body.grow for body in each])
    asked = np.array([[name in at for at in places] for name in names])
    near = asked[:, : away.shape[1]] & (away <= SURE)
    levels = [levels_of(mission, agent, body) for body in each]
    heights = chain.levels
    near = np.array([asked_of(row, heights, own) for row, own in zip(near, levels, strict=True)])
    for t in np.flatnonzero(near.sum(axis=0) > 1):
        yield int(t), [names[k] for k in np.flatnonzero(near[:, t])]


def _inside(
    mission: Mission, chain: Chain, t: int, names: list[str], bodies: Bodies
) -> tuple[list[str], float] | None:
    """The obstacles that touch with a sample within their union alone, and how deep it is [m]."""
    stays = {name: replace(bodies.of(name).at(t), move=np.zeros(2)) for name in names}
    touching: set[str] = set()
    for one, other in combinations(names, 2):
        if apart(stays[one], stays[other]) <= TOUCH:
            touching |= {one, other}
    if not touching:
        return None
    space, place = mission.workspace, chain.places[t]
    for name in names:
        alone = Stay(stays[name].form, stays[name].start, np.zeros(2))
        if of_place(place, keep_out(alone.form.parts, space, alone), alone) < -TOLERANCE:
            return None  # its own requirement tells
    whole = Stay(stays[names[0]].form, np.zeros(2), np.zeros(2))
    parts = [moved(p, stays[n].start) for n in sorted(touching) for p in stays[n].form.parts]
    value = of_place(place, keep_out(parts, space, whole), whole)
    return (sorted(touching), -value) if value < -TOLERANCE else None


def _violation(mission: Mission, agent: str, t: int, names: list[str], depth: float) -> Violation:
    text = (
        f"{agent} is between {' and '.join(names)}, which touch, at {t * mission.step:.3g} s: "
        f"{depth:.4g} m within their union"
    )
    return Violation("outside", text, depth, float(t), agent, None)
