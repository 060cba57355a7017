"""How near a motion comes to a body, and how deep it gets, from the file's own outlines.

The motion of a step becomes a chain of chords, fine enough that it strays by less than `STRAY` from
the true curve; what it has to do with polygons is shapely's to tell. A body that moves without
turning is met in its own frame, exactly; one whose corners move unlike each other is judged at
`INSTANTS` times of the step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.mission import Polytope
from stlc.verify.continuous import Extremum
from stlc.verify.paths import Path
from stlc.verify.shapes import TOUCH, Body, beyond, closed_union

Array = NDArray[np.float64]

STRAY = 2e-7
"""Chords stay this near to the curve [m], well within the tolerance of a judgement."""

MOST = 4096
"""Chords of one step at most; enough for 10 m of sagitta."""

INSTANTS = 129


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Positions of a motion: for each step t < T a row of (times in [0, 1] (K,), places (K, 2))."""

    rows: tuple[tuple[Array, Array], ...]

    @classmethod
    def of(cls, path: Path) -> Chain:
        """The chords of a motion; its last row, where it rests, is one point."""
        rows = [_chords(path, t) for t in range(len(path) - 1)]
        rows.append((np.array([0.0, 1.0]), np.tile(path.at(np.array([len(path) - 1.0])), (2, 1))))
        return cls(tuple(rows))


def _chords(path: Path, t: int) -> tuple[Array, Array]:
    rough = np.linspace(0.0, 1.0, 17)
    places = _within(path, t, rough)
    bend = float(np.hypot(*np.diff(places, 2, axis=0).T).max())
    # Of 16 chords, a second difference d means a sagitta of d / 8 each, less by the square of more.
    count = 16 * int(np.ceil(np.sqrt(bend / 8.0 / STRAY))) if bend > STRAY else 1
    times = np.linspace(0.0, 1.0, min(count, MOST) + 1)
    return times, _within(path, t, times)


def _within(path: Path, t: int, times: Array) -> Array:
    """Places between two steps; the very end is the start of the next step."""
    return path.at(t + np.minimum(times, 1.0))


@dataclass(slots=True, eq=False)
class Meeting:
    """What a kind of judgement needs of a body, made once for steps that look alike."""

    make: Callable[[Sequence[Any], Array], tuple[Any, Any]]
    known: dict[tuple[int, bytes], tuple[Any, Any]] = field(default_factory=dict)

    def of(self, parts: Sequence[Any], move: Array) -> tuple[Any, Any]:
        """The geometry of these parts."""
        key = (id(parts), move.tobytes())
        if key not in self.known:
            self.known[key] = self.make(parts, move)
        return self.known[key]


def outside(chain: Chain, body: Body, space: Polytope | None = None) -> Extremum:
    """Euclidean distance to a body in each step (T+1,) [m]; negative: how deep inside.

    With a workspace, what touches its border is closed there.
    """
    seen = Meeting(lambda parts, move: keep_out(parts, space, move))
    rows = []
    for t in range(len(chain.rows)):
        stay = body.stay(t)
        if stay is None:
            rows.append(_sampled(chain, body, t))
            continue
        rows.append(of_step(chain, t, stay.parts, stay.move, seen))
    values, where = np.array(rows).T
    return Extremum(values, where)


def of_step(
    chain: Chain, t: int, parts: Sequence[Any], move: Array, seen: Meeting
) -> tuple[float, float]:
    """(distance or minus depth, time) from step t to the next, of polygons that move alike."""
    times, places = chain.rows[t]
    return _clear(times, places - times[:, None] * move, *seen.of(parts, move))


def inside(chain: Chain, body: Body) -> Extremum:
    """Distance to the border in each step (T+1,) [m] while inside; negative: how far outside."""
    seen = Meeting(lambda parts, move: _stay_in(parts))
    rows = []
    for t, (times, places) in enumerate(chain.rows):
        stay = body.stay(t)
        if stay is None:
            rows.append(_sampled(chain, body, t, -1.0))
            continue
        relative = places - times[:, None] * stay.move
        rows.append(_held(times, relative, *seen.of(stay.parts, stay.move)))
    values, where = np.array(rows).T
    return Extremum(values, where)


def _stay_in(parts: Sequence[Any]) -> tuple[Any, Any]:
    """(where to be, by less than the tolerance, the closed union itself)."""
    import shapely

    whole = closed_union(parts)
    room = whole.buffer(2.0 * TOUCH, join_style="mitre")
    shapely.prepare(room)
    return room, whole


def _held(times: Array, places: Array, room: Any, whole: Any) -> tuple[float, float]:
    import shapely

    line = _line(places)
    if shapely.covers(room, line):
        near = shapely.get_coordinates(shapely.shortest_line(line, whole.boundary))[0]
        return float(shapely.distance(line, whole.boundary)), _when(times, places, near)
    out = _fine(shapely.difference(line, room))
    away = shapely.distance(shapely.points(out), whole)
    return -float(away.max()), _when(times, places, out[int(away.argmax())])


def keep_out(
    parts: Sequence[Any], space: Polytope | None, move: Array
) -> tuple[Any, tuple[Any, Any]]:
    """(what not to be in by more than the tolerance, (union with what is around, by itself))."""
    import shapely

    past = beyond(space, move)
    whole, solid = closed_union(parts, past), closed_union(parts)
    core = whole.buffer(-2.0 * TOUCH, join_style="mitre")
    if past:
        far = shapely.union_all(past).buffer(-TOUCH, join_style="mitre")
        own = solid.buffer(-2.0 * TOUCH, join_style="mitre")
        core = shapely.union_all([shapely.difference(core, far), own])
    shapely.prepare(core)
    return core, (whole, solid)


def _clear(times: Array, places: Array, core: Any, whole: tuple[Any, Any]) -> tuple[float, float]:
    """(distance or minus depth, time) of one step."""
    import shapely

    border, solid = whole
    line = _line(places)
    if shapely.intersects(core, line):
        met = _fine(shapely.intersection(line, core))
        deep = shapely.distance(shapely.points(met), border.boundary)
        return -float(deep.max()), _when(times, places, met[int(deep.argmax())])
    between = shapely.shortest_line(line, solid)
    return float(between.length), _when(times, places, shapely.get_coordinates(between)[0])


def _line(places: Array) -> Any:
    """The chain of chords; a point where nothing moves."""
    import shapely

    still = not np.ptp(places, axis=0).any()
    return shapely.Point(places[0]) if still else shapely.LineString(places)


def _fine(lines: Any) -> Array:
    """Places along lines, a 32nd of their length apart at most (n, 2)."""
    import shapely

    return np.asarray(
        shapely.get_coordinates(shapely.segmentize(lines, max(lines.length, TOUCH) / 32.0))
    )


def _when(times: Array, places: Array, place: Array) -> float:
    """The time at which the chain is nearest to a place."""
    legs, rest = np.diff(places, axis=0), place - places[:-1]
    squares = np.maximum((legs * legs).sum(axis=1), 1e-300)
    shares = np.clip((legs * rest).sum(axis=1) / squares, 0.0, 1.0)
    k = int(np.hypot(*(rest - shares[:, None] * legs).T).argmin())
    return float(times[k] + shares[k] * (times[k + 1] - times[k]))


def _sampled(chain: Chain, body: Body, t: int, sign: float = 1.0) -> tuple[float, float]:
    """The least of `sign` times the distance at many instants of a step, and when."""
    times, places = chain.rows[t]
    instants = np.linspace(0.0, 1.0, INSTANTS)
    at = np.column_stack([np.interp(instants, times, places[:, k]) for k in (0, 1)])
    values = [sign * body.distance(t + s, p) for s, p in zip(instants, at, strict=True)]
    least = int(np.argmin(values))
    return float(values[least]), float(instants[least])
