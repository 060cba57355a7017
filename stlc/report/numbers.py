"""Arrays as short lists for JSON."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stlc.arrays import Floats

DIGITS = 5
"""Of the range of an array: more than a screen has pixels."""


def short(values: Floats) -> Any:
    """Nested lists, rounded to `DIGITS` of their largest magnitude; None for what isn't finite."""
    finite = np.abs(values[np.isfinite(values)])
    top = float(finite.max(initial=0.0))
    places = DIGITS - math.floor(math.log10(top)) if top > 1e-300 else 0
    return _plain(np.round(values, min(places, 300)).tolist())


def _plain(value: Any) -> Any:
    """Whole numbers as such, NaN and infinities as None."""
    if isinstance(value, list):
        return [_plain(v) for v in value]
    if not math.isfinite(value):
        return None
    return int(value) if value == int(value) and abs(value) < 1e15 else value
