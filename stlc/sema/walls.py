"""Walls, drawn by lines or shapes: `wall brick = line (0, 0) (3, 0) loss 6 dB`."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from stlc.places import Wall
from stlc.sema import props
from stlc.sema.channel_errors import BadChannel
from stlc.sema.name_errors import NotHere
from stlc.sema.report import Mistake, Reported
from stlc.sema.scope import Scope
from stlc.sema.shapes import Shaper, cut
from stlc.sema.units import DB
from stlc.syntax import ast

if TYPE_CHECKING:
    from stlc.radio.walls import Walls

MOST_LOSS = 1000.0  # dB, as of levels


def declare_wall(statement: ast.WallDecl, shaper: Shaper) -> None:
    """Declare a wall. Raises Mistake or Reported."""
    name = statement.name.text
    try:
        shaper.scope.walls[name] = _wall(statement, shaper)
    except (Mistake, Reported):
        shaper.scope.broken.add(name)
        raise


def _wall(statement: ast.WallDecl, shaper: Shaper) -> Wall:
    """The wall as it is drawn. Raises Mistake for a line that is none, or a shape with heights."""
    name, loss = statement.name, _loss(statement, shaper.scope)
    shape = statement.shape
    if isinstance(shape, ast.Line):
        line = tuple(shaper.point(e) for e in shape.points)
        if len(line) < 2 or any(np.hypot(x - u, y - v) < 1e-3 for (x, y), (u, v) in pairwise(line)):
            problem = "a line has two corners or more, a millimetre apart at least"
            hint = "write `wall brick = line (0, 0) (3, 0) loss 6 dB`"
            raise Mistake(NotHere(span=shape.span, problem=problem, hint=hint))
        return Wall(name.text, loss, line, span=name.span)
    if shaper.heights(shape) is not None:
        problem, hint = "a wall stands at every height", "leave out its heights"
        raise Mistake(NotHere(span=shape.span, problem=problem, hint=hint))
    outlines = shaper.outlines(shape)
    return Wall(name.text, loss, (), outlines, cut(outlines, shape.span), name.span)


def _loss(statement: ast.WallDecl, scope: Scope) -> float | None:
    if statement.loss is None:
        return None
    loss = scope.number(statement.loss, DB)
    if not 0.0 <= loss <= MOST_LOSS:
        problem, hint = f"a wall can't lose {loss:g} dB", "say `loss 6 dB`: what it takes away"
        raise Mistake(NotHere(span=statement.loss.span, problem=problem, hint=hint))
    return loss


def walls_of(block: props.Block, channel: ast.Ident, scope: Scope) -> list[Wall]:
    """Those that a channel heeds: all of them, or the ones that `walls` names."""
    item = block.get("walls")
    if item is None:
        return list(scope.walls.values())
    found = []
    for expr in item.args:
        if not isinstance(expr, ast.Name):
            raise props.bad(item, "needs names of walls, or `none`", "walls brick core", expr.span)
        if expr.text == "none" and "none" not in scope.walls:
            return []
        if expr.text in scope.broken:
            raise Reported
        if expr.text not in scope.walls:
            problem = f"there is no wall `{expr.text}`"
            known = ", ".join(scope.walls) or "declare one: `wall brick = line (0, 0) (3, 0)`"
            raise Mistake(
                BadChannel(span=expr.span, channel=channel.text, problem=problem, hint=known)
            )
        found.append(scope.walls[expr.text])
    return found


def known_losses(walls: Iterable[Wall], channel: ast.Ident) -> None:
    """Raise Mistake at a wall of a channel without a fit whose loss nobody knows."""
    for wall in walls:
        if wall.loss is None:
            problem = f"the loss of the wall `{wall.name}` isn't known"
            hint = 'say `loss 6 dB` where it is drawn, or fit it: `samples "rssi.csv" fit`'
            raise Mistake(
                BadChannel(span=channel.span, channel=channel.text, problem=problem, hint=hint)
            )


def as_radio(walls: Iterable[Wall]) -> Walls | None:
    """Walls as the radio has them; None for none. A loss that isn't known is 0."""
    from stlc.radio.walls import Body, Walls

    drawn = list(walls)
    if not drawn:
        return None
    lines = [(k, (*p, *q)) for k, w in enumerate(drawn) for p, q in pairwise(w.line)]
    bodies = [Body(k, tuple(p.vertices for p in w.pieces)) for k, w in enumerate(drawn) if w.pieces]
    return Walls(
        tuple(w.name for w in drawn),
        np.array([w.loss or 0.0 for w in drawn]),
        np.array([line for _, line in lines], dtype=np.float64).reshape(-1, 4),
        np.array([k for k, _ in lines], dtype=np.intp),
        tuple(bodies),
    )
