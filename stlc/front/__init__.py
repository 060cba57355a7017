"""What `import stlc` offers: missions and plans as objects, and words to build missions from."""

from __future__ import annotations

from stlc.front.expressions import Formula, Quantity
from stlc.front.mission import Mission, load, loads
from stlc.front.plan import Plan, read_plan
from stlc.front.shapes import Shape, box, line, moving, polygon
from stlc.front.words import (
    abs_,
    all_of,
    always,
    any_of,
    ber,
    distance,
    effort,
    eventually,
    formula,
    link_cost,
    maximum,
    minimum,
    norm,
    probability,
    prr,
    quantity,
    robustness,
    rssi,
    separation,
    snr,
)

__all__ = [
    "Formula", "Mission", "Plan", "Quantity", "Shape", "abs_", "all_of", "always", "any_of", "ber",
    "box", "distance", "effort", "eventually", "formula", "line", "link_cost", "load", "loads",
    "maximum", "minimum", "moving", "norm", "polygon", "probability", "prr", "quantity",
    "read_plan", "robustness", "rssi", "separation", "snr",
]  # fmt: skip
