"""Colours that colour-blind readers can tell apart, markers, sizes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

# Okabe and Ito's palette without its yellow, then three of Paul Tol's muted scheme.
COLOURS = (
    "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9",
    "#E69F00", "#000000", "#882255", "#999933", "#44AA99",
)  # fmt: skip
MARKERS = "os^Dv<>PX*"

GOOD = "#0072B2"
BAD = "#D55E00"
BODY = "#4D4D4D"
BUFFER = "#BFBFBF"
REGION = "#009E73"
GRID = "#D9D9D9"
QUIET = "#9A9A9A"

TEXT = 9.0
SMALL = 8.0

RC: Any = {
    "font.size": TEXT,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": TEXT,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "xtick.labelsize": SMALL,
    "ytick.labelsize": SMALL,
    "legend.fontsize": SMALL,
    "legend.frameon": False,
    "svg.hashsalt": "stlc",
    "svg.fonttype": "none",
}


@dataclass(frozen=True, slots=True)
class Look:
    """How one thing is drawn."""

    colour: str
    marker: str


def looks(names: Iterable[str]) -> dict[str, Look]:
    """A look for each name; colours and markers have coprime-free cycles of ten."""
    count = len(COLOURS)
    return {
        name: Look(COLOURS[i % count], MARKERS[(i + i // count) % len(MARKERS)])
        for i, name in enumerate(names)
    }
