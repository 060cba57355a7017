"""Partitions of a channel: `auto`, `10 x 10`, edges `[0, 2, 5] x [0, 5]`, or a quadtree.

Where any agent flies cells have layers of height too: `8 x 8 x 3`; `8 x 8` has one.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from stlc.sema import props
from stlc.sema.geometry import bounds
from stlc.sema.scope import Scope
from stlc.sema.units import DB, METRE
from stlc.sema.values import Items
from stlc.syntax import ast

if TYPE_CHECKING:
    from stlc.radio.gp import ChannelModel
    from stlc.radio.partition import Partition

Ends = tuple[float, float]

USAGE = "partition 10 x 10"
MOST_CELLS = 40_000


def is_auto(item: ast.Property | None) -> bool:
    """Whether a channel chooses its own grid: by the word `auto`, or for want of a property."""
    head = item.args[0] if item is not None and len(item.args) == 1 else None
    return item is None or (isinstance(head, ast.Name) and head.text == "auto")


def partition(
    item: ast.Property | None, model: ChannelModel | None, heights: Ends | None, scope: Scope
) -> Partition:
    """The cells that a property describes, over the workspace's bounding box and `heights` [m]."""
    if item is None or is_auto(item):
        return _auto(item, model, heights, scope)
    head = item.args[0] if item.args else None
    if isinstance(head, ast.Name) and head.text == "quadtree":
        if heights is not None:
            raise props.bad(item, "divides the plane, and agents fly here", "partition 8 x 8 x 3")
        return _quadtree(item, list(item.args[1:]), model, scope)
    return _grid(item, item.args, heights, scope)


def _quadtree(
    item: ast.Property, words: list[ast.Expr], model: ChannelModel | None, scope: Scope
) -> Partition:
    """A grid whose cells are split where the mean strength varies by more than a tolerance."""
    from stlc.radio.partition import quadtree
    from stlc.radio.refine import variation_score

    usage = "partition quadtree 8 x 8 tolerance 3 dB cells 200"
    if model is None:
        raise props.bad(item, "of a table must be a grid", USAGE)
    start = _grid(item, tuple(words[:2]), None, scope)
    tolerance, most = 3.0, 4 * len(start)
    rest = words[2:]
    while rest:
        head = rest.pop(0)
        key = head.text if isinstance(head, ast.Name) else ""
        if key == "tolerance" and rest:
            tolerance = scope.number(rest.pop(0), DB)
        elif key == "cells" and rest:
            most = scope.whole(rest.pop(0))
        else:
            raise props.bad(item, "has an unknown word", usage, head.span)
    if tolerance <= 0 or not len(start) <= most <= MOST_CELLS:
        raise props.bad(item, f"needs a tolerance above 0 and {len(start)} cells or more", usage)
    stations = [s.position for s in scope.stations.values()]
    fixed = np.array(stations) if stations and len(scope.agents) == 1 else None
    return quadtree(start, variation_score(model, fixed), tolerance, most)


def _auto(
    item: ast.Property | None, model: ChannelModel | None, heights: Ends | None, scope: Scope
) -> Partition:
    """The grid that a channel begins with where it chooses its own."""
    from stlc.grids import first_grid

    assert scope.workspace is not None, "the channel was refused"
    if model is None:
        assert item is not None, "a table without a partition was refused"
        raise props.bad(item, "of a table must be a grid", USAGE)
    length = model.length if model.shadowing > 0 else None
    return first_grid(_ends(heights, scope), length)


def _ends(heights: Ends | None, scope: Scope) -> list[Ends]:
    """What cells have to cover along each axis [m]."""
    assert scope.workspace is not None, "the channel was refused"
    x_lo, x_hi, y_lo, y_hi = bounds([scope.workspace])
    return [(x_lo, x_hi), (y_lo, y_hi), *([] if heights is None else [heights])]


def _grid(
    item: ast.Property, args: tuple[ast.Expr, ...], heights: Ends | None, scope: Scope
) -> Partition:
    """Cells from counts or edges [m] along each axis; one layer of height where none are given."""
    ends = _ends(heights, scope)
    if heights is None and len(args) == 3:
        raise props.bad(item, "has layers of height, and no agent flies", USAGE)
    if len(args) not in (2, len(ends)):
        usage = USAGE if heights is None else "partition 8 x 8 x 3"
        raise props.bad(item, "needs cells along x and along y", usage)
    edges = [_edges(item, e, side, scope) for e, side in zip(args, ends, strict=False)]
    edges += [list(side) for side in ends[len(args) :]]
    count = prod(len(e) - 1 for e in edges)
    if count > MOST_CELLS:
        raise props.bad(item, f"has {count} cells, more than {MOST_CELLS}", USAGE)
    return _made(*(tuple(e) for e in edges))


@lru_cache(maxsize=8)
def _made(*edges: tuple[float, ...]) -> Partition:
    """One grid for all channels that have the same."""
    from stlc.radio.partition import grid

    return grid(*edges)


def _edges(
    item: ast.Property, expr: ast.Expr, ends: tuple[float, float], scope: Scope
) -> list[float]:
    """Edges along one axis [m]: evenly many, or the file's own, which increase and cover `ends`."""
    value = scope.value(expr)
    if not isinstance(value, Items):
        count = scope.whole(expr)
        if not 1 <= count <= MOST_CELLS:
            raise props.bad(item, f"can't have {count} cells along one axis", USAGE, expr.span)
        return [float(v) for v in np.linspace(*ends, count + 1)]
    edges = list(props.numbers(expr, scope, [METRE] * len(value.items)))
    if len(edges) < 2 or any(b <= a for a, b in pairwise(edges)):
        raise props.bad(item, "has edges that don't increase", "partition [0, 2, 5] x [0, 5]")
    if edges[0] > ends[0] + 1e-9 or edges[-1] < ends[1] - 1e-9:
        problem = f"doesn't cover what is in use, from {ends[0]:g} to {ends[1]:g}"
        raise props.bad(item, problem, "partition [0, 2, 5] x [0, 5]", expr.span)
    return [float(v) for v in edges]
