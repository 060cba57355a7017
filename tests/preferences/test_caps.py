"""What a priority has reached is kept by those after it, to well within what a person sees."""

from __future__ import annotations

from stlc.api import loads, solve

OPPOSED = """step 1 s
horizon 3
agent r : single_integrator { start (0, 0); control |u| <= 1 }
prefer right priority 2 weight 100: eventually[3] r.x >= 3
prefer left priority 1: eventually[3] r.x <= -3
minimize effort
"""


def test_later_tiers_leave_what_is_kept() -> None:
    """They used up a cap's slack: `left` was given up by 1e-06 m."""
    report = solve(loads(OPPOSED)).report
    assert {p.name: p.kept for p in report.preferences} == {"right": False, "left": True}
