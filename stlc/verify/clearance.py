"""How near a motion comes to a body, and how deep it gets, from the file's own outlines.

The motion of a step is a chain of chords (`chains.py`); what it has to do with polygons is told
by shapely. A body that moves without turning is met in its own frame, exactly; one whose corners
move unlike each other is judged at `INSTANTS` times of the step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stlc.places import Polytope
from stlc.verify.barriers import Out, kept_out
from stlc.verify.chains import CHORDS, Chain
from stlc.verify.continuous import Extremum
from stlc.verify.prisms import EVERY, Row, beyond, nearest, within
from stlc.verify.regions import beside_turning, kept_clear, kept_within
from stlc.verify.shapes import Body, Form, Levels, Stay
from stlc.verify.unions import DISC, TOUCH, closed_union

Array = NDArray[np.float64]

INSTANTS = 129
"""Times of a step at which what turns is looked at."""

SURE = 2.0 * DISC
"""What stays this far away is outside, whatever else is closed [m]."""


def outside(
    chain: Chain,
    body: Body,
    space: Polytope | None = None,
    levels: Levels = EVERY,
    steps: int | None = None,
) -> Extremum:
    """Euclidean distance to a body in each step (T+1,) [m]; negative: how deep inside.

    Of `steps`, only in that many (at least in one): what moves on comes nearer after a plan's end.
    The body lies between `levels` of height, inflation included.
    With a workspace, what touches its border is closed there. Exact in steps that come nearest of
    all or near; in others it is a lower bound, within the sagitta of the rough chain.
    """
    count = len(chain.rows) if steps is None else max(steps, 1)
    if levels != EVERY:
        rows = [_of_prism(chain, t, body, space, levels) for t in range(count)]
        values, where = np.array(rows).T
        return Extremum(values - chain.room[:count], where)
    value, where = (chain.least(body) - body.grow)[:count], np.zeros(count)
    finite = np.isfinite(value)
    known = (value[finite] + 2.0 * chain.stray[:count][finite]).min(initial=np.inf)
    for t in np.flatnonzero(value <= max(SURE, float(known))):
        value[t], where[t] = _of_step(chain, int(t), body, space, bool(value[t] > SURE))
    return Extremum(value - chain.room[:count], where)


def _of_step(
    chain: Chain, t: int, body: Body, space: Polytope | None, apart: bool
) -> tuple[float, float]:
    """(distance or minus depth, time) from step t to the next."""
    stay = body.stay(t)
    if stay is None:
        return _sampled(chain, body, t)
    if chain.tube is not None:
        return kept_clear(chain.tube, t, stay, kept_out(stay, space))
    if apart:
        return _away(*_nearest(chain, t, stay), stay.form.solid, body.grow)
    return of_step(chain.rows[t], stay, kept_out(stay, space))


def _of_prism(
    chain: Chain, t: int, body: Body, space: Polytope | None, levels: Levels
) -> tuple[float, float]:
    """(distance or minus depth, time) from step t to the next, for a body between heights."""
    (times, places), heights, stay = chain.rows[t], chain.heights[t], body.stay(t)
    if stay is None:
        return _turned(chain, body, t, levels)
    out = kept_out(stay, space)
    met = []
    for part, _ in within((times, places), heights, {"": levels}):
        if of_step(part, stay, out)[0] < 0.0:
            met.append(_deepest(part, np.interp(part[0], times, heights), stay, out, levels))
    if met:
        return min(met)
    return nearest((times, places - stay.start), heights, stay.move, out.solid, levels)


def _deepest(row: Row, heights: Array, stay: Stay, out: Out, levels: Levels) -> tuple[float, float]:
    """(minus depth, time) of a part of a step that enters a body between heights."""
    import shapely

    times, places = row
    asked = np.union1d(np.linspace(times[0], times[-1], INSTANTS), times)
    at = np.column_stack([np.interp(asked, times, places[:, k]) for k in (0, 1)])
    points = shapely.points(at - stay.start - asked[:, None] * stay.move)
    deep = shapely.distance(out.border.boundary, points)
    flat = np.where(shapely.intersects(out.core, points), -deep, 0.0)
    value = np.maximum(flat, beyond(np.interp(asked, times, heights), levels))
    least = int(value.argmin())
    return min(float(value[least]), -2.0 * TOUCH), float(asked[least])


def _turned(chain: Chain, body: Body, t: int, levels: Levels) -> tuple[float, float]:
    """The same at many instants, for a body whose corners move unlike each other."""
    (times, places), instants = chain.rows[t], np.linspace(0.0, 1.0, INSTANTS)
    at = np.column_stack([np.interp(instants, times, places[:, k]) for k in (0, 1)])
    flat = np.array([body.distance(t + s, p) for s, p in zip(instants, at, strict=True)])
    up = beyond(np.interp(instants, times, chain.heights[t]), levels)
    out = np.hypot(np.maximum(flat, 0.0), np.maximum(up, 0.0))
    values = np.where(np.maximum(flat, up) < 0.0, np.maximum(flat, up), out)
    least = int(values.argmin())
    return float(values[least]), float(instants[least])


def of_step(row: Row, stay: Stay, out: Out) -> tuple[float, float]:
    """(distance or minus depth, time) of a row of a chain, of what moves as `stay` does."""
    times, places = row
    return _clear(times, places - stay.start - times[:, None] * stay.move, out)


def of_place(place: Array, out: Out, stay: Stay) -> float:
    """Distance of a place (2,) at rest from what doesn't move, or minus its depth [m]."""
    return _clear(np.array([0.0, 1.0]), np.tile(place - stay.start, (2, 1)), out)[0]


def _nearest(chain: Chain, t: int, stay: Stay) -> tuple[Array, Array]:
    """The part of a step, as times and places relative to a form, that is nearest to it."""
    import shapely

    times, places = chain.rows[t]
    relative = places - stay.start - times[:, None] * stay.move
    each = (len(times) - 1) // CHORDS
    if not each:
        return times, relative
    ends = relative[::each]
    chords = shapely.linestrings(np.stack([ends[:-1], ends[1:]], axis=1))
    far = shapely.distance(stay.form.solid, chords)
    close = np.flatnonzero(far <= far.min() + 2.0 * chain.stray[t])
    part = slice(int(close[0]) * each, (int(close[-1]) + 1) * each + 1)
    return times[part], relative[part]


def _away(times: Array, places: Array, solid: Any, grow: float) -> tuple[float, float]:
    import shapely

    between = shapely.shortest_line(_line(places), solid)
    when = _when(times, places, shapely.get_coordinates(between)[0])
    return float(between.length) - grow, when


def inside(chain: Chain, body: Body) -> Extremum:
    """Distance to the border in each step (T+1,) [m] while inside; negative: how far outside."""
    rows = []
    for t, (times, places) in enumerate(chain.rows):
        stay = body.stay(t)
        if stay is None:
            rows.append(_sampled(chain, body, t, -1.0))
            continue
        if chain.tube is not None:
            rows.append(kept_within(chain.tube, t, stay, *_stayed_in(stay.form)))
            continue
        relative = places - stay.start - times[:, None] * stay.move
        rows.append(_held(times, relative, *_stayed_in(stay.form)))
    if body.levels is not None:
        rows = [min(found, _between(chain, t, body.levels)) for t, found in enumerate(rows)]
    values, where = np.array(rows).T
    return Extremum(values - chain.room, where)


def _between(chain: Chain, t: int, levels: Levels) -> tuple[float, float]:
    """(how far it is from the nearer level, negative beyond it; time) from step t to the next."""
    past = beyond(chain.heights[t], levels)
    worst = int(past.argmax())
    return -float(past[worst]), float(chain.rows[t][0][worst])


def at_steps(body: Body, places: Array, inside: bool, space: Polytope | None) -> Array:
    """How far places (L, 2) at steps 0..L-1 are inside, or outside, a body (L,) [m]."""
    found = np.empty(len(places))
    stays = [body.at(t) for t in range(len(places))]
    starts = np.array([stay.start for stay in stays]).reshape(-1, 2)
    forms = np.array([id(stay.form) for stay in stays])
    for key in np.unique(forms):
        steps = np.flatnonzero(forms == key)
        relative, form = places[steps] - starts[steps], stays[steps[0]].form
        if inside:
            found[steps] = _depths(relative, form)
        else:
            found[steps] = _gaps(relative, starts[steps], form, body.grow, space)
    return found


def _depths(places: Array, form: Form) -> Array:
    import shapely

    points, (room, whole) = shapely.points(places), _stayed_in(form)
    away = shapely.distance(whole, points)
    deep = shapely.distance(whole.boundary, points)
    return np.asarray(np.where(shapely.covers(room, points), deep, -away))


def _gaps(places: Array, starts: Array, form: Form, grow: float, space: Polytope | None) -> Array:
    import shapely

    found: Array = shapely.distance(form.solid, shapely.points(places)) - grow
    now = np.array([0.0, 1.0])
    for k in np.flatnonzero(found <= SURE):
        out = kept_out(Stay(form, starts[k], np.zeros(2)), space)
        found[k] = _clear(now, np.tile(places[k], (2, 1)), out)[0]
    return found


def _stayed_in(form: Form) -> tuple[Any, Any]:
    """`_stay_in`, made once."""
    if "in" not in form.made:
        form.made["in"] = _stay_in(form)
    made: tuple[Any, Any] = form.made["in"]
    return made


def _stay_in(form: Form) -> tuple[Any, Any]:
    """(where to be, by less than the tolerance, the closed union itself)."""
    import shapely

    whole = closed_union(form.parts)
    room = whole.buffer(2.0 * TOUCH, join_style="mitre")
    shapely.prepare(room)
    return room, whole


def _held(times: Array, places: Array, room: Any, whole: Any) -> tuple[float, float]:
    """(distance to the border or minus how far outside, time) of one step."""
    import shapely

    line = _line(places)
    left = None if shapely.covers(room, line) else shapely.difference(line, room)
    if left is None or left.is_empty:  # by rounding, of motions of 1e-15 m on the border
        near = shapely.get_coordinates(shapely.shortest_line(line, whole.boundary))[0]
        return float(shapely.distance(line, whole.boundary)), _when(times, places, near)
    out = _fine(left)
    away = shapely.distance(shapely.points(out), whole)
    return -float(away.max()), _when(times, places, out[int(away.argmax())])


def _clear(times: Array, places: Array, out: Out) -> tuple[float, float]:
    """(distance or minus depth, time) of one step."""
    import shapely

    line = _line(places)
    if shapely.intersects(out.core, line):
        common = shapely.intersection(line, out.core)
        if common.is_empty:  # they touch by rounding alone
            nearest_line = shapely.shortest_line(line, out.core)
            common = shapely.Point(shapely.get_coordinates(nearest_line)[0])
        met = _fine(common)
        deep = shapely.distance(shapely.points(met), out.border.boundary)
        return -float(deep.max()), _when(times, places, met[int(deep.argmax())])
    between = shapely.shortest_line(line, out.solid)
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
    if chain.tube is not None:
        return beside_turning(chain.tube, t, body, sign)
    times, places = chain.rows[t]
    instants = np.linspace(0.0, 1.0, INSTANTS)
    at = np.column_stack([np.interp(instants, times, places[:, k]) for k in (0, 1)])
    values = [sign * body.distance(t + s, p) for s, p in zip(instants, at, strict=True)]
    least = int(np.argmin(values))
    return float(values[least]), float(instants[least])
