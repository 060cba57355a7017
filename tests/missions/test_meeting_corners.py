"""Where obstacles meet in one point they hold it inside together: for encoder and verifier."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from stlc import api
from stlc.errors import InfeasibleError
from stlc.mission import Mission
from stlc.verify import verify

WEDGES = (
    "polygon (5, 5) (8, 3) (8, 8)",
    "polygon (5, 5) (8, 8) (2, 7)",
    "polygon (5, 5) (2, 7) (2, 2) (8, 3)",
)
ALL_THREE = "always[0, 0] (r outside a and r outside b and r outside c)"


def _mission(formula: str, wedges: tuple[str, ...] = WEDGES, start: str = "(5, 5)") -> Mission:
    places = "\n".join(f"obstacle {n} = {w}" for n, w in zip("abc", wedges, strict=False))
    return api.loads(
        "step 1 s\nhorizon 2\nworkspace box [0, 10] x [0, 10]\n"
        f"agent r : single_integrator {{ start {start}; control |u| <= 1 }}\n"
        f"{places}\nrequire x: {formula}\nminimize effort\n"
    )


FORMULAS = {
    "conjunction": ALL_THREE,
    "swept": "always[0, 0] (r outside a swept and r outside b swept and r outside c swept)",
    "requirements": "r outside a\nrequire y: r outside b\nrequire z: r outside c",
    "windows": "always[0, 1] r outside a\nrequire y: r outside b\nrequire z: always r outside c",
    "forall": "always[0, 0] forall o in obstacles: r outside o",
    "nested": "r outside a and (r outside b and r outside c)",
}


@pytest.mark.parametrize("formula", FORMULAS.values(), ids=FORMULAS)
def test_no_sample_where_three_wedges_meet(formula: str) -> None:
    with pytest.raises(InfeasibleError):
        api.solve(_mission(formula))


@pytest.mark.parametrize("formula", FORMULAS.values(), ids=FORMULAS)
def test_nor_does_the_verifier_allow_it(formula: str) -> None:
    plan = api.solve(_mission("r.x >= 0 m")).plan
    report = verify(_mission(formula), replace(plan, sha256=None))
    assert not report.ok
    assert "a and b and c, which touch" in "\n".join(map(str, report.violations))


@pytest.mark.parametrize("times", ["", " swept"])
def test_wedges_that_leave_a_gap_leave_it(times: str) -> None:
    """Without the third wedge the point is on the border of the union."""
    formula = f"always[0, 0] (r outside a{times} and r outside b{times})"
    assert api.solve(_mission(formula, WEDGES[:2])).report.ok


def test_a_sample_on_a_seam_is_refused_by_the_verifier() -> None:
    """Two obstacles, a point in the middle of their common face, no word of `swept`."""
    place = "(6.5, 6.5)"
    plan = api.solve(_mission("r.x >= 0 m", start=place)).plan
    report = verify(_mission("r outside a and r outside b", start=place), plan)
    assert "outside" in [v.kind for v in report.violations]


def test_at_other_steps_the_point_is_free() -> None:
    """Each wedge alone is kept out of, but never the three at one step."""
    formula = "r outside a and r outside b\nrequire y: always[1, 1] r outside c"
    assert api.solve(_mission(formula)).report.ok


def test_wedges_that_move_together_hold_it_too() -> None:
    wedges = tuple(f"{w} velocity (1, 0)" for w in WEDGES)
    with pytest.raises(InfeasibleError):
        api.solve(_mission("always[0, 0] forall o in obstacles: r outside o", wedges))
    with pytest.raises(InfeasibleError):
        api.solve(_mission(FORMULAS["swept"], wedges))


@pytest.mark.parametrize("turns", range(4))
def test_a_wedge_in_a_corner_of_the_workspace_leaves_no_way_there(turns: int) -> None:
    """It touches one border along a face, the next in the corner alone: kept out of there too, by
    encoder and verifier alike."""
    ring = [(0.0, 0.0), (6.0, 2.0), (8.0, 2.0), (8.0, 0.0), (6.0, 0.0)]
    start = (1.0, 5.0)
    for _ in range(turns):
        ring, start = [(10.0 - y, x) for x, y in ring], (10.0 - start[1], start[0])
    corner = ring[0]
    text = (
        "step 1 s\nhorizon 6\nworkspace box [0, 10] x [0, 10]\n"
        f"agent r : double_integrator {{ start {start}; control |u| <= 1; speed <= 2 }}\n"
        f"obstacle pan = polygon {' '.join(map(str, ring))}\n"
        "require clear: always r outside pan swept\n"
        f"require x: eventually[4, 6] (|r.x - {corner[0]}| <= 0.01 and |r.y - {corner[1]}| <= 0.01)"
        "\n"
        "minimize effort\n"
    )
    outcome = api.solve(api.loads(text))
    assert outcome.report.ok
    places = np.array(outcome.plan.runs["r"].states)[4:, :2]
    assert 1e-4 < np.abs(places - corner).max(axis=1).min() <= 0.01 + 1e-6
