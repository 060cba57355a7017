"""Stations: radios that stay."""

from __future__ import annotations

import numpy as np

from stlc.mission import Station
from stlc.sema import props
from stlc.sema.report import Mistake, Reported
from stlc.sema.shapes import Shaper
from stlc.sema.units import METRE
from stlc.sema.values import Radio
from stlc.syntax import ast


def station(statement: ast.StationDecl, shaper: Shaper) -> None:
    """Declare a station. Raises Mistake."""
    scope, name = shaper.scope, statement.name.text
    try:
        place = np.array(shaper.point(statement.position))
        owner = f"station `{name}`"
        block = props.block(owner, statement.properties, ("height",), scope)
        item = block.get("height")
        height = 0.0 if item is None else props.number(item, METRE, "height 2 m", scope)
    except (Mistake, Reported):
        scope.broken.add(name)
        raise
    made = Station(name, place, height, statement.name.span)
    scope.stations[name] = made
    scope.values[name] = Radio(made)
