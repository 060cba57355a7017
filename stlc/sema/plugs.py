"""Plugs between places that an agent keeps out of together, by step, in the frame of each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from stlc.places import Sweep
from stlc.sema.junctions import meeting, plugs_between
from stlc.sema.tracks import lasting
from stlc.sema.values import Place

Sweeps = tuple[Sweep, ...]


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
    tracks = [p.sweeps if swept else tuple(Sweep(pieces) for pieces in p.barriers) for p in places]
    for t in range(max(map(len, tracks))):
        yield [track[min(t, len(track) - 1)] for track in tracks]


def plugs_of_two(a: Place, b: Place, swept: bool) -> list[Sweeps]:
    """Plugs at each step, in the frame of either where the two move differently until the next."""
    found = []
    for x, y in _steps((a, b), swept):
        if np.abs(np.subtract(x.move, y.move)).max() <= 1e-9:
            found.append((Sweep(plugs_between(x.pieces, y.pieces), x.move), Sweep(())))
        else:
            found.append((_carried(x, y), _carried(y, x)))
    return [sweeps for sweeps in zip(*found, strict=True) if any(s.pieces for s in sweeps)]


def plugs_of_three(places: Sequence[Place], swept: bool) -> list[Sweeps]:
    """Plugs where three places meet in a point, at the steps at which they move alike."""
    found = []
    for sweeps in _steps(places, swept):
        moves = np.array([s.move for s in sweeps])
        plugs = meeting(*(s.pieces for s in sweeps)) if np.ptp(moves, axis=0).max() <= 1e-9 else ()
        found.append(Sweep(plugs, sweeps[0].move))
    return [tuple(found)] if any(s.pieces for s in found) else []


def _carried(one: Sweep, other: Sweep) -> Sweep:
    """Plugs that move with the first, over what stays in contact until the next step."""
    away = np.subtract(other.move, one.move)
    return Sweep(plugs_between(one.pieces, lasting(other.pieces, away)), one.move)
