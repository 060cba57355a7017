"""Walls: what a link loses for each one that its line of sight crosses.

A wall is drawn by lines, each of which costs its loss, or by convex pieces of bodies, each body of
which costs it once, however the line of sight runs through it. Walls stand at every height, so
links in space are looked at from above. An end nearer than TOUCH to a line is on no side of it, so
that a radio may hang on a wall; a body is left out to the same depth.

Over a pair of closed boxes the crossings are bounded by

    certain    every corner of one box lies on one side of the line and every corner of the other
               on the other side, and each line of sight between corners passes between its ends
               (orientations are linear in each end, so that corners decide)
    possible   the line meets the convex hull of both boxes, which all lines of sight fill, by
               separating axes, and the boxes are not both on one side of it
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from stlc.radio.pathloss import split_links

Array = NDArray[np.float64]
Ints = NDArray[np.intp]
Bools = NDArray[np.bool_]

TOUCH = 1e-6
"""An end this close [m] to a wall is not beyond it."""


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Convex pieces (corners (k, 2) [m], counter-clockwise) that cost a wall's loss together."""

    wall: int
    pieces: tuple[Array, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Walls:
    """Walls by their names and losses (W,) [dB]; `lines` (n, 4) [m], `owner` (n,) their walls."""

    names: tuple[str, ...]
    loss: Array
    lines: Array
    owner: Ints
    bodies: tuple[Body, ...] = ()

    def __len__(self) -> int:
        return len(self.names)

    def with_loss(self, loss: Array) -> Walls:
        """The same walls with other losses (W,) [dB]."""
        return replace(self, loss=np.asarray(loss, dtype=np.float64))

    def crossed(self, links: Array) -> Array:
        """How often each of K links (K, 2 D) crosses each wall, (K, W)."""
        a, b = (end[:, :2] for end in split_links(links))
        count = np.zeros((len(links), len(self.names)))
        for line, wall in zip(self.lines, self.owner, strict=True):
            count[:, wall] += _crosses(a, b, line[:2], line[2:])
        for body in self.bodies:
            hit = np.zeros(len(links), dtype=bool)
            for piece in body.pieces:
                hit |= _passes(a, b, piece)
            count[:, body.wall] += hit
        return count

    def attenuation(self, links: Array) -> Array:
        """What each link loses (K,) [dB]."""
        return np.asarray(self.crossed(links) @ self.loss)

    def between(self, a: Array, b: Array) -> Array:
        """What links between points a (na, D) and b (nb, D) lose, (na, nb) [dB]."""
        flat = np.hstack([np.repeat(a[:, :2], len(b), axis=0), np.tile(b[:, :2], (len(a), 1))])
        return self.attenuation(flat).reshape(len(a), len(b))

    def bounds(self, a: Sequence[Array], b: Sequence[Array]) -> tuple[Array, Array]:
        """Least and greatest loss (na, nb) [dB] between boxes, each as low and high corners
        (n, D)."""
        boxes = [np.stack([end[:, :2] for end in ends], axis=1) for ends in (a, b)]
        shape = (len(boxes[0]), len(boxes[1]))
        least, most = np.zeros(shape), np.zeros(shape)
        for line, wall in zip(self.lines, self.owner, strict=True):
            chord = line.reshape(2, 2)
            possible = _may_meet(boxes[0], boxes[1], chord) & ~_beside(boxes[0], boxes[1], chord)
            most += self.loss[wall] * possible
            least += self.loss[wall] * _certain(boxes[0], boxes[1], chord, possible)
        for body in self.bodies:
            possible, certain = np.zeros(shape, bool), np.zeros(shape, bool)
            for piece in body.pieces:
                met = _may_meet(boxes[0], boxes[1], piece)
                possible |= met
                certain |= _runs_through(boxes[0], boxes[1], piece, met)
            most += self.loss[body.wall] * possible
            least += self.loss[body.wall] * certain
        return least, most


def _side(p: Array, q: Array, x: Array) -> Array:
    """Signed distance [m] of points x (.., 2) from the line through p and q."""
    along = q - p
    size = float(np.hypot(*along))
    return np.asarray((along[0] * (x[..., 1] - p[1]) - along[1] * (x[..., 0] - p[0])) / size)


def _crosses(a: Array, b: Array, p: Array, q: Array) -> Bools:
    """Which of the links a -> b (K, 2) cross the line from p to q, its ends included."""
    one, other = _side(p, q, a), _side(p, q, b)
    apart = (np.minimum(one, other) < -TOUCH) & (np.maximum(one, other) > TOUCH)
    return np.asarray(apart & (_turn(a, b, p) * _turn(a, b, q) <= 0.0))


def _turn(a: Array, b: Array, x: Array) -> Array:
    """Twice the signed area of a, b, x."""
    one, two = b - a, x - a
    return np.asarray(one[..., 0] * two[..., 1] - one[..., 1] * two[..., 0])


def _passes(a: Array, b: Array, corners: Array) -> Bools:
    """Which links run through a convex piece, deeper than TOUCH: cut by its faces one by one."""
    first, last = np.zeros(len(a)), np.ones(len(a))
    for p, q in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        one, other = _side(p, q, a) - TOUCH, _side(p, q, b) - TOUCH
        slope = other - one
        with np.errstate(divide="ignore", invalid="ignore"):
            at = -one / slope
        first = np.where(slope > 0, np.maximum(first, at), first)
        last = np.where(slope < 0, np.minimum(last, at), last)
        last = np.where((slope == 0) & (one < 0), -1.0, last)
    return np.asarray(first <= last)


def _corners(boxes: Array) -> Array:
    """The four corners (n, 4, 2) of boxes (n, 2, 2), in one order for all."""
    low, high = boxes[:, 0], boxes[:, 1]
    x = np.stack([low[:, 0], high[:, 0], high[:, 0], low[:, 0]], axis=1)
    y = np.stack([low[:, 1], low[:, 1], high[:, 1], high[:, 1]], axis=1)
    return np.stack([x, y], axis=2)


def _beside(a: Array, b: Array, chord: Array) -> Bools:
    """Pairs (na, nb) of boxes that are both on one side of a line, or on it."""
    one, other = (_side(chord[0], chord[1], _corners(end)) for end in (a, b))
    left = (one.min(axis=1) >= -TOUCH)[:, None] & (other.min(axis=1) >= -TOUCH)[None, :]
    right = (one.max(axis=1) <= TOUCH)[:, None] & (other.max(axis=1) <= TOUCH)[None, :]
    return np.asarray(left | right)


def _may_meet(a: Array, b: Array, shape: Array) -> Bools:
    """Pairs (na, nb) of boxes whose convex hull meets a convex shape (k, 2), by separating axes.

    Normals of the hull are those of the axes, and of lines between equal corners of both boxes; of
    the shape, those of its faces.
    """
    met = np.ones((len(a), len(b)), dtype=bool)
    ca, cb = _corners(a), _corners(b)
    faces = np.roll(shape, -1, axis=0) - shape
    for axis in (np.array([1.0, 0.0]), np.array([0.0, 1.0]), *(f[::-1] * (1, -1) for f in faces)):
        ours, theirs = (c @ axis for c in (ca, cb))
        low = np.minimum(ours.min(axis=1)[:, None], theirs.min(axis=1)[None, :])
        high = np.maximum(ours.max(axis=1)[:, None], theirs.max(axis=1)[None, :])
        at, slack = shape @ axis, 1e-9 * float(np.abs(axis).sum())
        met &= (at.min() <= high + slack) & (at.max() >= low - slack)
    rows, columns = np.nonzero(met)
    for k in range(4):
        along = cb[columns, k] - ca[rows, k]
        axis = np.stack([along[:, 1], -along[:, 0]], axis=1)
        hull = np.concatenate([ca[rows], cb[columns]], axis=1)
        ours = np.einsum("pkc,pc->pk", hull, axis)
        at = axis @ shape.T
        slack = 1e-9 * np.abs(axis).sum(axis=1)
        apart = (at.min(axis=1) > ours.max(axis=1) + slack) | (
            at.max(axis=1) < ours.min(axis=1) - slack
        )
        met[rows[apart], columns[apart]] = False
    return met


def _certain(a: Array, b: Array, chord: Array, possible: Bools) -> Bools:
    """Pairs (na, nb) of boxes all of whose lines of sight cross the line."""
    found = np.zeros(possible.shape, dtype=bool)
    one, other = (_side(chord[0], chord[1], _corners(end)) for end in (a, b))
    up = (one.min(axis=1) > TOUCH)[:, None] & (other.max(axis=1) < -TOUCH)[None, :]
    down = (one.max(axis=1) < -TOUCH)[:, None] & (other.min(axis=1) > TOUCH)[None, :]
    rows, columns = np.nonzero(possible & (up | down))
    starts = _corners(a)[rows][:, :, None, :]
    ends = _corners(b)[columns][:, None, :, :]
    turns = [_turn(starts, ends, end).reshape(len(rows), 16) for end in chord]
    ways = [
        (one.min(axis=1) > 0.0) & (other.max(axis=1) < 0.0) for one, other in (turns, turns[::-1])
    ]
    found[rows, columns] = ways[0] | ways[1]
    return found


def _runs_through(a: Array, b: Array, piece: Array, possible: Bools) -> Bools:
    """Pairs of boxes all of whose lines of sight run through a convex piece, as far as one box
    within it, or one chord between its corners, tells."""
    inner = _shrunk(piece)
    if inner is None:
        return np.zeros(possible.shape, dtype=bool)
    faces = list(zip(inner, np.roll(inner, -1, axis=0), strict=True))
    within = [
        np.all([(_side(p, q, _corners(end)) >= 0.0).all(axis=1) for p, q in faces], axis=0)
        for end in (a, b)
    ]
    found = possible & (within[0][:, None] | within[1][None, :])
    for p, q in combinations(inner, 2):
        found |= _certain(a, b, np.stack([p, q]), possible & ~found)
    return np.asarray(found)


def _shrunk(piece: Array) -> Array | None:
    """Corners of the piece without a rim of twice TOUCH; None where nothing is left."""
    middle = piece.mean(axis=0)
    faces = list(zip(piece, np.roll(piece, -1, axis=0), strict=True))
    depth = min(float(_side(p, q, middle)) for p, q in faces)
    return None if depth <= 4.0 * TOUCH else middle + (1.0 - 2.0 * TOUCH / depth) * (piece - middle)
