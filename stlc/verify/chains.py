"""A motion as chains of chords: a fine one for it, a rough one to tell what is near."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from stlc.places import Track
from stlc.verify.paths import FINE, Path
from stlc.verify.shapes import Body

Array = NDArray[np.float64]

STRAY = 2e-7
"""Chords stay this near to the curve [m], well within the tolerance of a judgement."""

MOST = 4096
"""Chords of one step at most; enough for 10 m of sagitta."""

CHORDS = 16
"""Chords of a step of the rough chain, which tells what is near enough to look at closely."""

_ROUGH = np.linspace(0.0, 1.0, CHORDS + 1)


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """Positions of a motion: for each step t < T a row of (times in [0, 1] (K,), places (K, 2)).

    `rough` (T+1, CHORDS + 1, 2) is the same at fewer times, and within `stray` (T+1,) [m]. The
    truth may be off by `room` (T+1,) [m], zero where the tolerance has room for it.
    `heights` are those at the times of each row (K,) [m]. `tube` is the motion in the plane with
    what disturbances may add, None without any; `stray` has that in it too.
    """

    rows: tuple[tuple[Array, Array], ...]
    rough: Array
    stray: Array
    room: Array
    heights: tuple[Array, ...] = ()
    tube: Path | None = None
    _known: dict[int, tuple[Track, Array]] = field(default_factory=dict)

    @classmethod
    def of(cls, path: Path) -> Chain:
        """The chords of a motion; its last row, where it rests, is one point."""
        last, width = len(path) - 1, path.c0.shape[1]
        rough = np.stack([_within(path, t, _ROUGH) for t in range(last)] or [np.empty((0, width))])
        rest = np.tile(path.at(np.array([float(last)])), (1, CHORDS + 1, 1))
        rough = np.concatenate([rough, rest]) if last else rest
        # Of 16 chords, a second difference d means a sagitta of d / 8 each.
        second = np.moveaxis(np.diff(rough, 2, axis=1), 2, 0)
        bends = reduce(np.hypot, second).max(axis=1) / 8.0
        rows = [_chords(path, t, float(bends[t])) for t in range(last)]
        rows.append((np.array([0.0, 1.0]), rest[0, :2]))
        flat = tuple((times, places[:, :2]) for times, places in rows)
        heights = tuple(places[:, 2] if width == 3 else np.zeros(len(places)) for _, places in rows)
        room = path.room.reshape(-1, path.pieces).max(axis=1)
        room = np.where(room <= FINE, 0.0, room)
        off = path.plane.reach.max(axis=0).reshape(-1, path.pieces).max(axis=1)
        tube = path.plane if path.sways else None
        return cls(flat, rough[:, :, :2], 2.0 * bends + STRAY + room + off, room, heights, tube)

    @property
    def places(self) -> Array:
        """Where it is at each step (T+1, 2) [m]."""
        return self.rough[:, 0]

    @property
    def levels(self) -> Array:
        """Its height at each step (T+1,) [m]."""
        return np.array([heights[0] for heights in self.heights])

    def least(self, body: Body) -> Array:
        """At most the distance to the polygons as in the file, by step (T+1,) [m].

        -inf where corners move unlike each other.
        """
        key = id(body.track)
        if key not in self._known:
            self._known[key] = (body.track, self._least(body))
        return self._known[key][1]

    def _least(self, body: Body) -> Array:
        import shapely

        found = np.full(len(self.rough), -np.inf)
        for spell in body.spells(len(found)):
            along = spell.starts[:, None] + _ROUGH[:, None] * spell.move
            lines = shapely.linestrings(self.rough[spell.steps] - along)
            found[spell.steps] = shapely.distance(spell.form.solid, lines)
        return found - self.stray


def _chords(path: Path, t: int, sagitta: float) -> tuple[Array, Array]:
    # More chords have a sagitta less by the square of how many.
    count = CHORDS * int(np.ceil(np.sqrt(sagitta / STRAY))) if sagitta > STRAY / 8.0 else 1
    times = np.linspace(0.0, 1.0, min(count, MOST) + 1)
    return times, _within(path, t, times)


def _within(path: Path, t: int, times: Array) -> Array:
    """Places between two steps; the very end is the start of the next step."""
    return path.at(t + np.minimum(times, 1.0))
