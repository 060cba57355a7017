"""Plugs between places that an agent keeps out of together, by step, in the frame of each.

Only steps at which the boxes of both touch are looked at, and the plugs of two that move alike are
worked out once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from stlc.arrays import Floats
from stlc.places import Polytope, Sweep
from stlc.sema.contacts import TOUCH
from stlc.sema.geometry import Point
from stlc.sema.junctions import meeting, plugs_between
from stlc.sema.tracks import SAME, lasting, translated
from stlc.sema.values import Place

Sweeps = tuple[Sweep, ...]

_ALIKE = 1e-9  # m that moves within a step may differ by


def box_of(place: Place) -> tuple[float, float, float, float]:
    """Least and greatest coordinates of a place over all times [m]."""
    pieces = [p.vertices for frame in place.barriers for p in frame]
    for sweep in place.sweeps:
        pieces += [p.vertices + by for p in sweep.pieces for by in (np.zeros(2), sweep.move)]
    corners = np.vstack(pieces)
    (x0, y0), (x1, y1) = corners.min(axis=0), corners.max(axis=0)
    return float(x0), float(y0), float(x1), float(y1)


def _steps(places: Sequence[Place], swept: bool) -> Iterator[list[Sweep]]:
    """What to keep out of at each step, the last one staying."""
    tracks = [_track(p, swept) for p in places]
    for t in range(max(map(len, tracks))):
        yield [track[min(t, len(track) - 1)] for track in tracks]


def _track(place: Place, swept: bool) -> Sequence[Sweep]:
    return place.sweeps if swept else tuple(Sweep(pieces) for pieces in place.barriers)


def plugs_of_two(a: Place, b: Place, swept: bool) -> list[Sweeps]:
    """Plugs at each step, in the frame of either where the two move differently until the next.

    One sweep a step in each of the two tracks; tracks without any plug are left out.
    """
    found = []
    near = _near_each_other([_track(p, swept) for p in (a, b)])
    known = _Known(plugs_between)
    for (x, y), close in zip(_steps((a, b), swept), near, strict=True):
        if not close:
            found.append((Sweep((), x.move), Sweep(())))
        elif x.move == y.move or np.abs(np.subtract(x.move, y.move)).max() <= _ALIKE:
            found.append((Sweep(known.plugs(x.pieces, y.pieces), x.move), Sweep(())))
        else:
            found.append((_carried(x, y), _carried(y, x)))
    return [sweeps for sweeps in zip(*found, strict=True) if any(s.pieces for s in sweeps)]


def _near_each_other(tracks: Sequence[Sequence[Sweep]]) -> list[bool]:
    """At which steps the boxes of two bodies touch: plugs lie where their pieces do."""
    count = max(map(len, tracks))
    if count == 1:
        return [True]  # found by their boxes
    low, high = np.empty((2, len(tracks), count, 2))
    for k, track in enumerate(tracks):
        for t, sweep in enumerate(track):
            corners = _corners(sweep.pieces)
            low[k, t], high[k, t] = corners.min(axis=0), corners.max(axis=0)
        low[k, len(track) :], high[k, len(track) :] = (
            low[k, len(track) - 1],
            high[k, len(track) - 1],
        )
    meets = low.max(axis=0) <= high.min(axis=0) + 2.0 * TOUCH
    return [bool(m) for m in meets.all(axis=1)]


def _corners(pieces: Sequence[Polytope]) -> Floats:
    return pieces[0].vertices if len(pieces) == 1 else np.vstack([p.vertices for p in pieces])


@dataclass(slots=True)
class _Known:
    """Plugs of bodies that move alike: worked out once, then carried along."""

    make: Callable[..., tuple[Polytope, ...]]  # of the pieces of each body
    bodies: tuple[Sequence[Polytope], ...] = ()
    made: tuple[Polytope, ...] = ()

    def plugs(self, *bodies: Sequence[Polytope]) -> tuple[Polytope, ...]:
        """`make(*bodies)`."""
        by = self._carried(bodies)
        if by is None:
            self.bodies, self.made = bodies, self.make(*bodies)
            return self.made
        return tuple(translated(p, by) for p in self.made)

    def _carried(self, bodies: tuple[Sequence[Polytope], ...]) -> Point | None:
        """How all moved since plugs were worked out [m], None where not alike."""
        if [len(pieces) for pieces in self.bodies] != [len(pieces) for pieces in bodies]:
            return None
        before, after = (
            _corners([p for pieces in b for p in pieces]) for b in (self.bodies, bodies)
        )
        if before.shape != after.shape or np.ptp(after - before, axis=0).max() > SAME:
            return None
        x, y = after[0] - before[0]
        return float(x), float(y)


def plugs_of_three(places: Sequence[Place], swept: bool) -> list[Sweeps]:
    """Plugs where three places meet in a point, at the steps at which they move alike."""
    found = []
    near = _near_each_other([_track(p, swept) for p in places])
    known = _Known(meeting)
    for sweeps, close in zip(_steps(places, swept), near, strict=True):
        first = sweeps[0].move
        alike = close and all(s.move == first for s in sweeps)
        if close and not alike:
            alike = bool(np.ptp([s.move for s in sweeps], axis=0).max() <= _ALIKE)
        plugs = known.plugs(*(s.pieces for s in sweeps)) if alike else ()
        found.append(Sweep(plugs, first))
    return [tuple(found)] if any(s.pieces for s in found) else []


def _carried(one: Sweep, other: Sweep) -> Sweep:
    """Plugs that move with the first, over what stays in contact until the next step."""
    away = np.subtract(other.move, one.move)
    return Sweep(plugs_between(one.pieces, lasting(other.pieces, away)), one.move)
