"""From a mission's text: what `swept` claims, and verdicts on runs made by hand."""

import numpy as np
import pytest

from stlc.api import loads
from stlc.ir.nodes import Motion, Swept, walk
from stlc.plan import make_plan
from stlc.verify import verify

TEXT = """
step 1 s
horizon 3
workspace box [0, 10] x [0, 10]
dynamics cart = double_integrator
agent r1 : cart {{ start (1, 5, 2.5, 0); control |u| <= 1; speed <= 3 }}
agent r2 : cart {{ start (9.75, 5, -1.5, 0); control |u| <= 1; speed <= 3 }}
region zone = box [0, 10] x [4, 6]
obstacle post = box [1.5, 3] x [4.5, 5.5]
{}
minimize effort
"""


def load(requirement):
    return loads(TEXT.format(requirement))


def claims(mission):
    return [n.swept for r in mission.requirements for n in walk(r.formula) if n.swept]


@pytest.mark.parametrize(
    ("requirement", "claim"),
    [
        ("always[0, 2] r1 outside post swept", Swept(Motion.OUTSIDE, "r1", place="post")),
        (
            "always[0, 2] separation(r1, r2) >= (0.5, 0.75) swept",
            Swept(Motion.SEPARATION, "r1", other="r2", distances=(0.5, 0.75)),
        ),
    ],
)
def test_swept_conditions_say_what_they_stand_for(requirement, claim):
    assert claims(load(f"require r: {requirement}")) == [claim]


def coasting(mission):
    runs = {}
    for name, one in mission.agents.items():
        x = [one.start]
        for _ in range(mission.horizon):
            x.append(one.dynamics.A @ x[-1] + one.dynamics.drift)
        runs[name] = np.array(x)
    return make_plan(mission, runs, {name: np.zeros((mission.horizon, 2)) for name in runs})


@pytest.mark.parametrize("requirement", ["r1 outside post", "separation(r1, r2) >= 0.75 m"])
def test_samples_may_pass_where_the_motion_does_not(requirement):
    """r1 jumps from x = 1 over the post to 3.5; it meets r2 between samples."""
    sampled = load(f"require r: always[0, 3] {requirement}")
    assert verify(sampled, coasting(sampled)).ok
    swept = load(f"require r: always[0, 2] {requirement} swept")
    report = verify(swept, coasting(swept))
    assert not report.ok
    assert report.requirements[0].swept < 0
    # the hull that was lowered to is a sufficient condition
    assert report.requirements[0].robustness <= report.requirements[0].swept + 1e-9


def test_violations_point_into_the_text():
    home = load("require home: eventually[0, 2] r2 in zone")
    report = verify(home, coasting(home))
    assert report.ok
    low = load("require low: always[0, 2] r1.y <= 4.5 m")
    report = verify(low, coasting(low))
    (violation,) = report.violations
    assert violation.span.line == 10
