"""Values over boxes of two axes, kept only where there are any; those of one place together."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

import numpy as np

from stlc.arrays import Ints
from stlc.solve.relaxation.problem import Singles
from stlc.solve.routes.axis_boxes import AxisBoxes, Span
from stlc.solve.routes.progress import Open


class Patch(NamedTuple):
    """Values (nx, mx, ny, my) of the boxes with positions in spans x and y, at all rates; infinite
    where there is none. Of k patches together they are (nx, mx, k, ny, my)."""

    x: Span
    y: Span
    values: Singles


def shared(a: Span, b: Span) -> Span:
    """What two spans share, empty where that is nothing."""
    first = max(a[0], b[0])
    return first, max(min(a[1], b[1]), first)


def within(patch: Patch, x: Span, y: Span) -> Singles:
    """The values of some positions, to be read or written."""
    (x0, _), (y0, _) = patch.x, patch.y
    return patch.values[x[0] - x0 : x[1] - x0, ..., y[0] - y0 : y[1] - y0, :]


def empty(x: Span, y: Span, rates: tuple[int, int]) -> Patch:
    """No values yet."""
    shape = (x[1] - x[0], rates[0], y[1] - y[0], rates[1])
    return Patch(x, y, np.full(shape, np.inf, np.float32))


def merged(known: Patch | None, new: Patch) -> Patch:
    """The least values of two; `known` may be written to."""
    if known is None:
        return new
    x, y = _hull(known.x, new.x), _hull(known.y, new.y)
    if (x, y) != (known.x, known.y):
        wider = empty(x, y, (known.values.shape[1], known.values.shape[3]))
        within(wider, known.x, known.y)[...] = known.values
        known = wider
    part = within(known, new.x, new.y)
    np.minimum(part, new.values, out=part)
    return known


def _hull(a: Span, b: Span) -> Span:
    return min(a[0], b[0]), max(a[1], b[1])


def trimmed(patch: Patch) -> Patch | None:
    """Without positions that have no values; None for none at all."""
    known = np.isfinite(patch.values.min(axis=(1, 3)))
    i, j = np.flatnonzero(known.any(axis=1)), np.flatnonzero(known.any(axis=0))
    if not len(i):
        return None
    x = patch.x[0] + int(i[0]), patch.x[0] + int(i[-1]) + 1
    y = patch.y[0] + int(j[0]), patch.y[0] + int(j[-1]) + 1
    return Patch(x, y, np.ascontiguousarray(within(patch, x, y)))


def alike(layer: Mapping[Open, Patch]) -> Iterator[tuple[list[Open], Patch]]:
    """The patches of one place together: what is open in each, and all values."""
    found: dict[tuple[Span, Span], list[Open]] = {}
    for open_, patch in layer.items():
        found.setdefault((patch.x, patch.y), []).append(open_)
    for (x, y), opens in found.items():
        yield opens, Patch(x, y, np.stack([layer[o].values for o in opens], axis=2))


def stepped(patch: Patch, x: AxisBoxes, y: AxisBoxes, *, back: bool) -> Patch:
    """The least values that a step from, or (`back`) to, patches of one place comes from, along x,
    then y."""
    wide, high = x.beside(patch.x), y.beside(patch.y)
    (nx, mx, count, ny, my), into = patch.values.shape, (wide[1] - wide[0]) * x.rates
    along = x.stepped(patch.values.reshape(nx * mx, -1), patch.x, wide, back=back)
    turned = np.ascontiguousarray(along.reshape(-1, ny * my).T)
    both = y.stepped(turned, patch.y, high, back=back)
    shape = (into // x.rates, mx, count, high[1] - high[0], my)
    return Patch(wide, high, np.ascontiguousarray(both.T).reshape(shape))


def refined(patch: Patch, x: Ints, y: Ints, rates: tuple[Ints, Ints]) -> Singles:
    """The values of finer boxes (nx, mx, ny, my): x and y are their coarse positions, `rates`
    their coarse rates."""
    spans = ((x, patch.x), (y, patch.y))
    inside = [(own >= span[0]) & (own < span[1]) for own, span in spans]
    i, j = (
        np.where(fine, own - span[0], 0) for fine, (own, span) in zip(inside, spans, strict=True)
    )
    found: Singles = patch.values[np.ix_(i, rates[0], j, rates[1])]
    found[~inside[0]] = np.inf
    found[:, :, ~inside[1]] = np.inf
    return found
