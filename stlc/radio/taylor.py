"""First-order expansions of the posterior over pairs of boxes, with rigorous remainders.

Over boxes of centre y0 and half widths h, r^2 = |h|^2:
  * S = <S, phi> in the space of the unnormalised symmetric kernel, phi its features, so that
    |S''| <= |S| |phi''|, |S|^2 = w' K w;
  * V = <phi, (I - P) phi>, 0 <= P <= I: V'' is at least -2 |phi| |phi''| and at most
    2 |phi'|^2 + 2 |phi| |phi''|, where
    |phi|^2 = g, |phi'|^2 <= (1 + min(1, (1+t) e^(-t/2)))/l^2,
    |phi''|^2 <= (3 + min(3, (3 + 6t + t^2) e^(-t/2)))/l^4, t = 2 |a - b|^2/l^2;
  * m: the Hessian of log |a - b| by a - b has the eigenvalues +-1/|a - b|^2.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log

import numpy as np
from numpy.typing import NDArray

from stlc.radio.gp import ChannelModel
from stlc.radio.pairs import PairField, swap_halves
from stlc.radio.pathloss import path_loss_mean

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Expansion:
    """f(y0 + d) in centre + slopes d + [-low, high] for |d_i| <= halves_i; arrays (na, nb)."""

    centre: Array
    slopes: tuple[Array, ...]
    halves: tuple[Array, ...]
    low: Array
    high: Array

    def interval(self) -> tuple[Array, Array]:
        """Lower and upper bound over the boxes."""
        spread = np.zeros_like(self.centre)
        for slope, half in zip(self.slopes, self.halves, strict=True):
            spread += np.abs(slope) * half
        return self.centre - spread - self.low, self.centre + spread + self.high

    def plus(self, other: Expansion) -> Expansion:
        """The expansion of the sum."""
        slopes = tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True))
        low, high = self.low + other.low, self.high + other.high
        return Expansion(self.centre + other.centre, slopes, self.halves, low, high)

    def times(self, factor: Array) -> Expansion:
        """The expansion multiplied by one number (na, nb) for each pair."""
        slopes = tuple(factor * s for s in self.slopes)
        up, down = np.maximum(factor, 0.0), np.maximum(-factor, 0.0)
        low, high = up * self.low + down * self.high, up * self.high + down * self.low
        return Expansion(factor * self.centre, slopes, self.halves, low, high)


@dataclass(frozen=True, slots=True, eq=False)
class Boxes:
    """n closed boxes: centres (n, D) and half widths (n, D) >= 0 [m]; a point has width 0."""

    centre: Array
    half: Array

    def __len__(self) -> int:
        return len(self.centre)

    def take(self, rows: NDArray[np.intp]) -> Boxes:
        """The boxes of the given rows."""
        return Boxes(self.centre[rows], self.half[rows])

    def subdivide(self, parts: int) -> Boxes:
        """Each box cut into `parts` along every axis of positive width, box-major."""
        axes = [k for k in range(self.centre.shape[1]) if (self.half[:, k] > 0).any()]
        count = parts ** len(axes)
        centre = np.repeat(self.centre, count, axis=0)
        half = np.repeat(self.half, count, axis=0)
        offsets = (2.0 * np.arange(parts) + 1.0) / parts - 1.0
        shifts = np.meshgrid(*[offsets] * len(axes), indexing="ij")
        for axis, shift in zip(axes, shifts, strict=True):
            centre[:, axis] += np.tile(shift.ravel(), len(self)) * half[:, axis]
            half[:, axis] /= parts
        return Boxes(centre, half)


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """Boxes of one end and E at their centres."""

    boxes: Boxes
    factors: Array

    def take(self, rows: NDArray[np.intp]) -> Ends:
        """Some of the rows."""
        return Ends(self.boxes.take(rows), self.factors[rows])


def prepare_ends(field: PairField, boxes: Boxes, other: bool) -> Ends:
    """Boxes with the field's factors at their centres, in the other end's order for `other`."""
    factors = field.factors(boxes.centre)
    if field.one_way and not other:
        factors[:, field.centres :] = 0.0
    return Ends(boxes, swap_halves(factors) if other else factors)


def distances(a: Boxes, b: Boxes) -> tuple[Array, Array, Array]:
    """Least, centre and greatest distance (na, nb) [m] of two closed boxes."""
    shape = (len(a), len(b))
    near, at, far = np.zeros(shape), np.zeros(shape), np.zeros(shape)
    for axis in range(a.centre.shape[1]):
        gap = np.abs(a.centre[:, axis, None] - b.centre[None, :, axis])
        reach = a.half[:, axis, None] + b.half[None, :, axis]
        near += np.maximum(gap - reach, 0.0) ** 2
        at += gap**2
        far += (gap + reach) ** 2
    return np.sqrt(near), np.sqrt(at), np.sqrt(far)


def _halves(a: Boxes, b: Boxes) -> tuple[Array, ...]:
    """Half widths that broadcast over pairs, axes of the first end and then of the second."""
    axes = range(a.centre.shape[1])
    return (*(a.half[:, k, None] for k in axes), *(b.half[None, :, k] for k in axes))


def expand_path_loss(model: ChannelModel, a: Boxes, b: Boxes, near: Array, at: Array) -> Expansion:
    """m; its remainder is infinite where the clamp at d0 may be met."""
    smooth = near > model.d0
    steep = -10.0 * model.exponent / log(10.0)
    square = np.where(smooth, at, 1.0) ** 2
    axes = range(a.centre.shape[1])
    step = [
        np.where(smooth, steep * (a.centre[:, k, None] - b.centre[None, :, k]) / square, 0.0)
        for k in axes
    ]
    moved = sum(((a.half[:, k, None] + b.half[None, :, k]) ** 2 for k in axes), np.zeros_like(at))
    least = np.where(smooth, near, 1.0) ** 2
    bend = np.where(smooth, 0.5 * abs(steep) * moved / least, np.inf)
    centre = path_loss_mean(at, model.l0, model.exponent, model.d0)
    return Expansion(centre, (*step, *(-s for s in step)), _halves(a, b), bend, bend)


def expand_gain(field: PairField, left: Ends, right: Ends, near: Array) -> Expansion:
    """S."""
    a, b, fa, fb = left.boxes, right.boxes, left.factors, right.factors
    weight = np.tile(field.mean_weight, 2)
    both = np.vstack([field.sender, field.receiver])
    crossed = np.vstack([field.receiver, field.sender])
    scale = -1.0 / field.model.length**2
    centre = (fa * weight) @ fb.T
    slopes: list[Array] = []
    for axis in range(both.shape[1]):
        moment = (fa * (weight * both[:, axis])) @ fb.T
        slopes.append(scale * (a.centre[:, axis, None] * centre - moment))
    for axis in range(both.shape[1]):
        moment = (fa * (weight * crossed[:, axis])) @ fb.T
        slopes.append(scale * (b.centre[None, :, axis] * centre - moment))
    _, second = _feature_slopes(near, field.model.length)
    rest = _reach(a, b) * field.norm * np.sqrt(second)
    return Expansion(centre, tuple(slopes), _halves(a, b), rest, rest)


def expand_rest(
    field: PairField, left: Ends, right: Ends, near: Array, overlap: list[Array]
) -> Expansion:
    """V = g - |root w|^2; `overlap`: least, greatest and centre value of g."""
    a, b = left.boxes, right.boxes
    explained, slopes_a, slopes_b = _explained_slopes(field, left, right)
    length2 = field.model.length**2
    pull = (overlap[2] - 1.0) * (-2.0 / length2)
    axes = range(a.centre.shape[1])
    step = [pull * (a.centre[:, k, None] - b.centre[None, :, k]) for k in axes]
    slopes = (*(step[k] - slopes_a[k] for k in axes), *(-step[k] - slopes_b[k] for k in axes))
    first, second = _feature_slopes(near, field.model.length)
    bend = 2.0 * np.sqrt(overlap[1] * second)
    low, high = _reach(a, b) * bend, _reach(a, b) * (2.0 * first + bend)
    return Expansion(overlap[2] - explained, slopes, _halves(a, b), low, high)


def _reach(a: Boxes, b: Boxes) -> Array:
    """Half the squared half diagonals (na, nb) [m^2] of pairs of boxes."""
    return np.asarray(0.5 * ((a.half**2).sum(1)[:, None] + (b.half**2).sum(1)[None, :]))


def _feature_slopes(near: Array, length: float) -> tuple[Array, Array]:
    """Bounds of |phi'|^2 and |phi''|^2 along any direction, from the least distance."""
    t = 2.0 * near**2 / length**2
    decay = np.exp(-t / 2.0)
    first = 1.0 + np.where(t > 1.0, np.minimum((1.0 + t) * decay, 1.0), 1.0)
    second = 3.0 + np.where(t > 2.2, np.minimum((3.0 + 6.0 * t + t**2) * decay, 3.0), 3.0)
    return first / length**2, second / length**4


def _explained_slopes(
    field: PairField, left: Ends, right: Ends
) -> tuple[Array, list[Array], list[Array]]:
    """|root w|^2 at the centres and its derivatives along each axis of both ends."""
    a, b, fa, fb = left.boxes, right.boxes, left.factors, right.factors
    half, axes = field.centres, a.centre.shape[1]
    shape = (len(a), len(b))
    direct = (fa[:, None, :half] * fb[None, :, :half]).reshape(-1, half)
    crossed = (fa[:, None, half:] * fb[None, :, half:]).reshape(-1, half)
    reduced = (direct + crossed) @ field.root.T
    total = np.einsum("ij,ij->i", reduced, reduced).reshape(shape)
    pull = reduced @ field.root
    one, two = pull * direct, pull * crossed
    ends = np.column_stack([np.ones(half), field.sender, field.receiver])
    sums, cross = (one @ ends).reshape(*shape, -1), (two @ ends).reshape(*shape, -1)
    scale = -2.0 / field.model.length**2
    slopes_a, slopes_b = [], []
    for axis in range(axes):
        s, r = 1 + axis, 1 + axes + axis
        both = sums[..., 0] + cross[..., 0]
        at_a, at_b = a.centre[:, axis, None], b.centre[None, :, axis]
        slopes_a.append(scale * (at_a * both - sums[..., s] - cross[..., r]))
        slopes_b.append(scale * (at_b * both - sums[..., r] - cross[..., s]))
    return total, slopes_a, slopes_b
