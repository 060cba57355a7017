"""Motions and bodies that touch by rounding alone have a distance too."""

from __future__ import annotations

import numpy as np
import pytest
import shapely

from stlc.verify.barriers import Out
from stlc.verify.clearance import _clear, _held
from stlc.verify.report import Clearance

CORNERS = [
    (7.328860768587152, 5.20025257204648),
    (4.628678091292717, 2.867688654485352),
    (2.2915166999670653, 6.953021060918184),
]
MOTION = np.array(
    [[6.507225834553992, 4.490479853093331], [6.507225834553994, 4.490479853093332]]
)  # 2e-15 m on the border: not covered, and nothing of it is outside
TIMES = np.array([0.0, 1.0])


def test_a_motion_of_which_nothing_is_left_outside_is_inside() -> None:
    body = shapely.Polygon(CORNERS)
    assert not shapely.covers(body, shapely.LineString(MOTION))
    value, when = _held(TIMES, MOTION, body, body)
    assert value == pytest.approx(0.0, abs=1e-12)
    assert 0.0 <= when <= 1.0


def test_a_motion_that_meets_a_body_in_nothing_touches_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where shapely says that they intersect, and that their intersection is empty."""
    body = shapely.box(2.0, 0.0, 4.0, 4.0)
    out = Out(body, body, body)
    places = np.array([[1.0, 1.0], [2.0, 1.0]])
    assert _clear(TIMES, places, out) == (0.0, 1.0)
    nothing = shapely.LineString()
    monkeypatch.setattr(shapely, "intersection", lambda *given: nothing)
    assert _clear(TIMES, places, out) == (0.0, 1.0)


@pytest.mark.parametrize(
    ("value", "shown"), [(3.176e-22, ": 0 m"), (-5.551e-17, ": 0 m"), (2e-6, ": 2e-06 m")]
)
def test_rounding_is_no_distance(value: float, shown: str) -> None:
    assert shown in str(Clearance("body", "a", "wall", value, 1.0))
