"""Closed seams: pieces to keep out of, without a way of no width between or past them.

Predicates are closed sets, so `outside` holds on a border: where pieces P_1..P_n touch, a run may
slide along the common border, though it is inside their union U; and along the workspace's border
where a piece touches that. Here the pieces are grown, and small ones ("plugs") added, so that every
point of int U is in the interior of some piece, and of a border contact likewise.

Why that suffices. A point of int U in no open piece is on the border of every piece that holds it,
so all such points lie on borders of two pieces that touch: on finitely many segments (a contact of
two convex sets without common interior is a segment or a point) and single points.

* A segment that is a whole face of one piece and within the other: the piece grows over it, by
  moving the face (parallel, if that stays within the other) or by a gable, a corner beyond it.
* Any other segment: a plug, a convex quadrilateral within both pieces with the segment as diagonal.
  Both cover the segment but its ends, and leave U as it is.
* Two pieces that meet in one point leave no free way through, though U's interior is parted there:
  a plug of `PLUG` around it. It is the only thing that takes free space.
* A face on the workspace's border moves beyond it, where nothing lives; a corner there gets a plug.
* What is left are ends of segments and crossings of borders: vertices of the arrangement. Those in
  int U get a plug within U.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stlc.mission import Array
from stlc.places import Polytope
from stlc.sema.contacts import DEEP, PLUG, TOUCH, Contact, contact, extent
from stlc.sema.crossings import single_points
from stlc.sema.geometry import (
    Point,
    area,
    contains,
    counter_clockwise,
    meeting_point,
    polygons,
    polytope,
    simplified,
    square,
    turn,
)

BEYOND = 0.1
"""How far a face on the workspace's border moves, as a share of the workspace's size."""
MOST_PAIRS = 60_000
"""Pairs of touching pieces of one union: some four seconds. All of them crossing each other, they
make twice as many corners."""


class TooManyPairsError(ValueError):
    """More pieces of a union touch or overlap than can be closed; the message says how many."""


def closed(
    pieces: Sequence[Polytope], space: Polytope | None, move: Point = (0.0, 0.0)
) -> tuple[Polytope, ...]:
    """The pieces of one union, grown and plugged; see the head of this file.

    With a `move` [m], they are to be kept out of while they move by it: a contact with the
    workspace's border that they leave is no contact. Raises TooManyPairsError.
    """
    grown = list(pieces)
    plugs: list[Polytope] = []
    if space is not None:
        for k, piece in enumerate(grown):
            grown[k], more = _past_border(piece, space, np.array(move))
            plugs += more
    plugs += _joined(grown)
    everything = [*grown, *plugs]
    if len(everything) > 2:
        everything += single_points(everything)
    return tuple(everything)


def overlapping(pieces: Sequence[Polytope]) -> tuple[Polytope, ...]:
    """The pieces grown into one another where they touch, their union unchanged."""
    grown = list(pieces)
    _joined(grown)
    return tuple(grown)


def _joined(grown: list[Polytope]) -> list[Polytope]:
    """Grow pieces over their contacts; the plugs for those that can't be."""
    plugs: list[Polytope] = []
    for i, j in _near(grown):
        found = contact(grown[i], grown[j])
        if found is not None:
            plugs += _close(grown, (i, j), found)
    return plugs


# --- contacts ------------------------------------------------------------------------------------


def _near(pieces: Sequence[Polytope]) -> list[tuple[int, int]]:
    """Pairs that may touch, in order."""
    if len(pieces) < 2:
        return []
    import shapely

    rings = polygons(pieces)
    found = shapely.STRtree(rings).query(rings, predicate="dwithin", distance=4.0 * TOUCH)
    pairs = found[:, found[0] < found[1]]
    if pairs.shape[1] > MOST_PAIRS:
        raise TooManyPairsError(f"{pairs.shape[1]:,} pairs of touching pieces")
    return sorted(map(tuple, pairs.T.tolist()))


# --- closing -------------------------------------------------------------------------------------


def _close(grown: list[Polytope], pair: tuple[int, int], met: Contact) -> list[Polytope]:
    """Grow one of two touching pieces over the contact, or give a plug.

    The smaller one first, whatever their order: a motion within a step is kept behind one face of
    each piece, which is easier the smaller they are.
    """
    first, second = (area(grown[k].vertices.tolist()) for k in pair)
    ways = ((0, 1), (1, 0)) if first <= (1.0 + 1e-9) * second else ((1, 0), (0, 1))
    for own, other in ways:
        face = met.faces[own]
        if met.length > PLUG and met.whole[own] and face is not None:
            piece = _over(grown[pair[own]], face, grown[pair[other]])
            if piece is not None:
                grown[pair[own]] = piece
                return []
    return [plug_over(grown[pair[0]], grown[pair[1]], met)]


def _over(piece: Polytope, face: int, other: Polytope) -> Polytope | None:
    """The piece grown over a face into the other piece: parallel, or by a gable."""
    room = float(np.ptp(other.vertices @ piece.normals[face])) / 2.0
    while room > DEEP:
        moved = shifted(piece, face, room)
        if moved is not None and all(contains(other, p, -1e-9) for p in _ends(moved, face)):
            return moved
        room /= 2.0
    return _gabled(piece, face, other)


def _ends(piece: Polytope, face: int) -> tuple[Array, Array]:
    """The two corners of a face."""
    return piece.vertices[face], piece.vertices[(face + 1) % len(piece.vertices)]


def shifted(piece: Polytope, face: int, distance: float) -> Polytope | None:
    """The piece with one face moved outward [m]; None when that takes away or adds no face."""
    count = len(piece.offsets)
    before, after = piece.normals[face - 1], piece.normals[(face + 1) % count]
    normal = piece.normals[face]
    if min(_sine(before, normal), _sine(normal, after)) < 1e-6:
        return None
    offsets = piece.offsets.copy()
    offsets[face] += distance
    vertices, following = piece.vertices.copy(), (face + 1) % count
    for corner in (face, following):
        vertices[corner] = meeting_point(piece.normals, offsets, corner)
    start, end = vertices[face], vertices[following]
    if float((end - start) @ np.array([-normal[1], normal[0]])) < TOUCH:
        return None
    return Polytope(piece.normals, offsets, vertices)


def _sine(a: Array, b: Array) -> float:
    return float(a[0] * b[1] - a[1] * b[0])


def _gabled(piece: Polytope, face: int, other: Polytope) -> Polytope | None:
    """The piece with a corner beyond the middle of a face, as far out as both pieces allow."""
    (u, v), ring = _ends(piece, face), [_point(p) for p in piece.vertices]
    height = 0.25 * float(np.hypot(*(v - u)))
    while height > DEEP:
        tip = (u + v) / 2.0 + height * piece.normals[face]
        taller = [*ring[: face + 1], _point(tip), *ring[face + 1 :]]
        if contains(other, tip, 0.0) and _turns_left(taller, face):
            return polytope(simplified(taller))
        height /= 2.0
    return None


def _turns_left(ring: list[Point], face: int) -> bool:
    """The corners about a new one, `face` + 1, still turn left by a margin."""
    count = len(ring)
    around = [[ring[(face + k + d) % count] for d in (-1, 0, 1)] for k in (0, 1, 2)]
    return all(turn(a, b, c) > 1e-9 * _square(a, b, c) for a, b, c in around)


def _square(a: Point, b: Point, c: Point) -> float:
    return max(abs(p[k] - b[k]) for p in (a, c) for k in (0, 1)) ** 2


def _point(place: Array) -> Point:
    return float(place[0]), float(place[1])


def plug_over(a: Polytope, b: Polytope, met: Contact) -> Polytope:
    """A quadrilateral about a contact, within both pieces; a square about a point."""
    middle = (met.start + met.end) / 2.0
    if met.length <= PLUG:
        return square(middle, PLUG)
    tips = (_tip(piece, middle, met.length) for piece in (a, b))
    shape = simplified([_point(p) for p in _around(met.start, met.end, *tips)])
    return polytope(shape) if len(shape) == 4 else square(middle, PLUG)


def _around(start: Array, end: Array, one: Array, other: Array) -> Iterator[Array]:
    yield from (start, one, end, other)


def _tip(piece: Polytope, middle: Array, length: float) -> Array:
    """A point within a piece before the middle of a contact, a quarter of its length away."""
    face = int((piece.normals @ middle - piece.offsets).argmax())
    height = 0.25 * length
    while height > TOUCH:
        tip = middle - height * piece.normals[face]
        if contains(piece, tip, 0.0):
            return np.asarray(tip)
        height /= 2.0
    return middle


# --- the border ----------------------------------------------------------------


def _past_border(piece: Polytope, space: Polytope, move: Array) -> tuple[Polytope, list[Polytope]]:
    """A piece that touches the workspace's border from within, carried beyond it.

    Contacts are those of the piece as it is told: carried beyond one side, it may reach past the
    next, which it touches in a corner.
    """
    size = BEYOND * float(np.ptp(space.vertices, axis=0).max())
    plugs: list[Polytope] = []
    told = piece
    for normal, offset in zip(space.normals, space.offsets, strict=True):
        reach = float((told.vertices @ normal).max()) - float(offset)
        if not -TOUCH <= reach <= PLUG or float(normal @ move) < -TOUCH:
            continue
        met = _on_border(told, space, normal)
        if met is None:
            continue
        face = met.faces[0]
        moved = None if face is None else shifted(piece, face, size)
        moved = moved or (None if face is None else shifted(piece, face, PLUG))
        if moved is not None:
            piece = moved
        elif met.length > PLUG:
            plugs.append(_bar(told, met, normal))
        else:
            plugs.append(square((met.start + met.end) / 2.0, PLUG))
    return piece, plugs


def _on_border(piece: Polytope, space: Polytope, normal: Array) -> Contact | None:
    """Where a piece lies on a face of the workspace."""
    tangent = np.array([-normal[1], normal[0]])
    (low, high), face = extent(piece, normal, tangent)
    (first, last), _ = extent(space, normal, tangent)
    if high < first - TOUCH or low > last + TOUCH:
        return None
    level = float((piece.vertices @ normal).max())
    start, end = (level * normal + at * tangent for at in (low, high))
    return Contact(start, end, (face, None), (True, False))


def _bar(piece: Polytope, met: Contact, normal: Array) -> Polytope:
    """A quadrilateral about a contact with the border, one tip within, the other beyond."""
    middle = (met.start + met.end) / 2.0
    inner, outer = _tip(piece, middle, met.length), middle + 0.25 * met.length * normal
    ring = counter_clockwise([_point(p) for p in (met.start, inner, met.end, outer)])
    return polytope(simplified(ring))
