"""Interval reach sets."""

from __future__ import annotations

import warnings

import numpy as np

from stlc.analysis.reach import reach
from stlc.mission import Mission

FREE = """step 1 s
horizon 3
agent a : double_integrator { start (1, 1) }
region far = box [5, 6] x [1, 2]
require visit: always[3, 3] a in far
minimize effort
"""


def test_what_nothing_bounds_stays_infinite() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ranges = reach(Mission.from_text(FREE, name="free.stl"))["a"]
    assert np.isneginf(ranges.state_lower[2:]).all()
    assert np.isposinf(ranges.state_upper[2:]).all()
    assert np.isneginf(ranges.input_lower).all()
    assert np.isposinf(ranges.input_upper).all()
