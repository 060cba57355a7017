"""Places of a mission: polygons, regions, and obstacles at rest or on the move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stlc.source import Span

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Polytope:
    """Convex polygon {p : normals @ p <= offsets}; unit normals, so slacks are metres.

    normals (k, 2), offsets (k,), vertices (k, 2) counter-clockwise [m].
    """

    normals: Array
    offsets: Array
    vertices: Array


@dataclass(frozen=True, slots=True)
class Outline:
    """A polygon as the file gives it: its ring of corners and those of its holes [m]."""

    ring: tuple[tuple[float, float], ...]
    holes: tuple[tuple[tuple[float, float], ...], ...] = ()


@dataclass(frozen=True, slots=True)
class Region:
    """Union of convex pieces.

    `outlines` are the polygons as written; `barrier` are pieces to keep out of, whose seams are
    closed (`stlc/sema/seams.py`). `heights` [m] are those it lies between; None for all.
    """

    name: str
    pieces: tuple[Polytope, ...]
    span: Span | None = None
    outlines: tuple[Outline, ...] = ()
    barrier: tuple[Polytope, ...] = ()
    heights: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class Wall:
    """What takes `loss` [dB] of a link whose line of sight crosses it; None where only a fit can
    tell. `line` are the corners of one that is drawn by a line [m]: each stretch of it counts;
    `outlines` and convex `pieces` those of one with a thickness, which counts once."""

    name: str
    loss: float | None
    line: tuple[tuple[float, float], ...] = ()
    outlines: tuple[Outline, ...] = ()
    pieces: tuple[Polytope, ...] = ()
    span: Span | None = None


@dataclass(frozen=True, slots=True)
class Track:
    """An obstacle's shape and motion as the file gives them.

    `frames` are (step, polygons), the first at step 0. Between two of them the obstacle rests at
    the earlier and moves in the last step, or moves all the time if `linear`; `velocity` [m/s]
    carries everything along.
    """

    frames: tuple[tuple[int, tuple[Outline, ...]], ...]
    linear: bool = False
    velocity: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Sweep:
    """What to keep out of from one step to the next: pieces that move by `move` [m] meanwhile."""

    pieces: tuple[Polytope, ...]
    move: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Obstacle:
    """A region to keep out of: `frames[t]` are its pieces at step t (the last stays for ever).

    `frames` are inflated by `inflate` metres; `bodies` are the same frames before inflation.
    `barrier[t]` are the frames with closed seams, to keep out of at step t, and `sweeps[t]` what
    to keep out of from t to t + 1; `track` is what the file says, and `heights` [m] those it lies
    between before it is inflated, None for all.
    """

    name: str
    frames: tuple[tuple[Polytope, ...], ...]
    bodies: tuple[tuple[Polytope, ...], ...]
    inflate: float = 0.0
    span: Span | None = None
    track: Track | None = None
    barrier: tuple[tuple[Polytope, ...], ...] = ()
    sweeps: tuple[Sweep, ...] = ()
    heights: tuple[float, float] | None = None
