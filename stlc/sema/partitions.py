"""Partitions of a channel: `auto`, `10 x 10`, edges `[0, 2, 5] x [0, 5]`, or a quadtree."""

from __future__ import annotations

from functools import lru_cache
from itertools import pairwise
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

USAGE = "partition 10 x 10"
MOST_CELLS = 40_000


def is_auto(item: ast.Property | None) -> bool:
    """Whether a channel chooses its own grid: by the word `auto`, or for want of a property."""
    head = item.args[0] if item is not None and len(item.args) == 1 else None
    return item is None or (isinstance(head, ast.Name) and head.text == "auto")


def partition(item: ast.Property | None, model: ChannelModel | None, scope: Scope) -> Partition:
    """The cells that a property describes, over the workspace's bounding box."""
    if item is None or is_auto(item):
        return _auto(item, model, scope)
    head = item.args[0] if item.args else None
    if isinstance(head, ast.Name) and head.text == "quadtree":
        return _quadtree(item, list(item.args[1:]), model, scope)
    return _grid(item, item.args, scope)


def _quadtree(
    item: ast.Property, words: list[ast.Expr], model: ChannelModel | None, scope: Scope
) -> Partition:
    """A grid whose cells are split where the mean strength varies by more than a tolerance."""
    from stlc.radio.partition import quadtree
    from stlc.radio.refine import variation_score

    usage = "partition quadtree 8 x 8 tolerance 3 dB cells 200"
    if model is None:
        raise props.bad(item, "of a table must be a grid", USAGE)
    start = _grid(item, tuple(words[:2]), scope)
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


def _auto(item: ast.Property | None, model: ChannelModel | None, scope: Scope) -> Partition:
    from stlc.grids import first_grid

    assert scope.workspace is not None, "the channel was refused"
    if model is None:
        assert item is not None, "a table without a partition was refused"
        raise props.bad(item, "of a table must be a grid", USAGE)
    x_lo, x_hi, y_lo, y_hi = bounds([scope.workspace])
    length = model.length if model.shadowing > 0 else None
    return first_grid((x_lo, x_hi), (y_lo, y_hi), length)


def _grid(item: ast.Property, args: tuple[ast.Expr, ...], scope: Scope) -> Partition:
    """Cells from counts or edges [m] along both axes."""
    assert scope.workspace is not None, "the channel was refused"
    x_lo, x_hi, y_lo, y_hi = bounds([scope.workspace])
    if len(args) != 2:
        raise props.bad(item, "needs cells along x and along y", USAGE)
    edges = [
        _edges(item, expr, ends, scope)
        for expr, ends in zip(args, ((x_lo, x_hi), (y_lo, y_hi)), strict=True)
    ]
    count = (len(edges[0]) - 1) * (len(edges[1]) - 1)
    if count > MOST_CELLS:
        raise props.bad(item, f"has {count} cells, more than {MOST_CELLS}", USAGE)
    return _made(tuple(edges[0]), tuple(edges[1]))


@lru_cache(maxsize=8)
def _made(x: tuple[float, ...], y: tuple[float, ...]) -> Partition:
    """One grid for all channels that have the same."""
    from stlc.radio.partition import grid

    return grid(x, y)


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
        problem = f"doesn't cover the workspace from {ends[0]:g} to {ends[1]:g}"
        raise props.bad(item, problem, "partition [0, 2, 5] x [0, 5]", expr.span)
    return [float(v) for v in edges]
