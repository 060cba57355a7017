"""Bodies between two heights: the parts of a motion within them, and how near it comes to them.

A prism is met by the part of a motion that is between its heights, which is judged in the plane
(`clearance.py`); how near a motion that stays out comes to it is found by samples of each step, the
best of them refined. What goes on to the lowest or highest height that an agent may have goes on
beyond it: there is no way of no height.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.mission import Mission
from stlc.verify.shapes import Array, Body, Levels
from stlc.verify.unions import TOUCH

Row = tuple[Array, Array]
"""Times (K,) of a step and places (K, 2) then [m]."""

EVERY: Levels = (-np.inf, np.inf)

SAMPLES, ZOOMS = 129, 4
"""Times of a step at which a distance is looked at, and how often the best of them is refined, 33
times between its neighbours: to 1e-8 of a step."""


def levels_of(mission: Mission, agent: str, body: Body) -> Levels:
    """The heights that an agent keeps out of, for a body that it must not enter [m]."""
    if body.levels is None:
        return EVERY
    low, high = body.levels[0] - body.grow, body.levels[1] + body.grow
    found = mission.agents.get(agent)
    if found is None:
        return low, high
    row = found.dynamics.altitude
    if row is None:  # on the ground
        return EVERY if low <= TOUCH < high else (low, high)
    k = int(np.argmax(row))
    open_below = low <= found.state_lower[k] + TOUCH
    open_above = high >= found.state_upper[k] - TOUCH
    return (-np.inf if open_below else low, np.inf if open_above else high)


def within(
    row: Row, heights: Array, levels: Mapping[str, Levels]
) -> Iterator[tuple[Row, list[str]]]:
    """Parts of a step in which the same of some bodies are met, and which these are.

    heights (K,) are those at the row's times. A body is met between its levels, and not at them.
    """
    times, places = row
    ends = sorted({end for low, high in levels.values() for end in (low + TOUCH, high - TOUCH)})
    finite = [end for end in ends if np.isfinite(end)]
    if not finite:
        yield row, list(levels)
        return
    times, places, heights = _cut(times, places, heights, finite)
    middle = (heights[:-1] + heights[1:]) / 2.0
    met = np.array(
        [(middle > low + TOUCH) & (middle < high - TOUCH) for low, high in levels.values()]
    )
    change = np.flatnonzero((met[:, 1:] != met[:, :-1]).any(axis=0)) + 1
    names = list(levels)
    for start, stop in pairwise([0, *change.tolist(), len(middle)]):
        some = [names[k] for k in np.flatnonzero(met[:, start])]
        if some:
            yield (times[start : stop + 1], places[start : stop + 1]), some


def _cut(
    times: Array, places: Array, heights: Array, ends: list[float]
) -> tuple[Array, Array, Array]:
    """The chords of a step, cut where they pass a height of `ends`."""
    more = []
    for end in ends:
        above = heights > end
        for k in np.flatnonzero(above[1:] != above[:-1]):
            share = (end - heights[k]) / (heights[k + 1] - heights[k])
            more.append(times[k] + share * (times[k + 1] - times[k]))
    every = np.unique(np.concatenate([times, more]))
    x, y = (np.interp(every, times, places[:, axis]) for axis in (0, 1))
    return every, np.column_stack([x, y]), np.interp(every, times, heights)


def beyond(heights: Array, levels: Levels) -> Array:
    """How far heights are below or above `levels`; negative between them [m]."""
    return np.asarray(np.maximum(levels[0] - heights, heights - levels[1]))


def nearest(
    row: Row, heights: Array, move: Array, solid: Any, levels: Levels
) -> tuple[float, float]:
    """(distance, time) of a motion that stays out of a prism over `solid` moving by `move` [m]."""
    import shapely

    times, places = row
    asked = np.union1d(np.linspace(0.0, 1.0, SAMPLES), times)
    for _ in range(ZOOMS):
        at = np.column_stack([np.interp(asked, times, places[:, k]) for k in (0, 1)])
        flat = shapely.distance(solid, shapely.points(at - asked[:, None] * move))
        up = np.maximum(beyond(np.interp(asked, times, heights), levels), 0.0)
        value = np.hypot(flat, up)
        best = int(value.argmin())
        found = float(value[best]), float(asked[best])
        ends = asked[max(best - 1, 0)], asked[min(best + 1, len(asked) - 1)]
        asked = np.linspace(*ends, 33)
    return found


def corrected(value: Array, heights: Array, levels: Levels | None, inside: bool) -> Array:
    """How far places at some heights are inside, or outside, a prism, from what they are in the
    plane (L,) [m]."""
    if levels is None:
        return value
    past = beyond(heights, levels)
    return np.asarray(np.minimum(value, -past) if inside else np.maximum(value, past))


def asked_of(chosen: NDArray[np.bool_], heights: Array, levels: Levels) -> NDArray[np.bool_]:
    """Of chosen steps (L,) those at which a sample is between the levels."""
    return np.asarray(chosen & (beyond(heights[: len(chosen)], levels) < -TOUCH))
