"""`swept` conditions on any signals, judged in continuous time against dense simulation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from stlc.api import loads, verify
from stlc.plan import make_plan

MISSION = """
step 1.5 s
horizon 5
{dynamics}
agent a : cart {{ start (1, 1, 0.4, 0); control |u| <= 1 }}
agent b : cart {{ start (4, 2, 0, 0.3); control |u| <= 1 }}
require r: always {condition}
"""
MATRICES = """
dynamics cart {
  continuous; states px py vx vy; inputs ux uy
  A = [[0, 0, 1, 0], [0, 0, 0, 1], [0, 0, -0.3, -0.8], [0, 0, 0.8, -0.3]]
  B = [[0, 0], [0, 0], [1, 0], [0, 1]]
}
"""
FLOWS = {
    "dynamics cart = double_integrator": np.zeros((2, 2)),
    MATRICES: np.array([[-0.3, -0.8], [0.8, -0.3]]),
}
FINE = np.linspace(0.0, 1.0, 301)


def states(lower: np.ndarray, x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """(T, 301, 4), from the starts of steps and the inputs."""
    whole = np.zeros((6, 6))
    whole[:2, 2:4], whole[2:4, 2:4], whole[2:4, 4:] = np.eye(2), lower, np.eye(2)
    z = np.column_stack([x[:-1], u])
    return np.stack([(z @ expm(whole * s * 1.5).T)[:, :4] for s in FINE], axis=1)


CONDITIONS = {
    "(a.vx + 0.5 * b.vy <= 2 m/s) swept": lambda a, b, u: 2 - a[..., 2] - 0.5 * b[..., 3],
    "(a.x <= 1.2 m or a.vy <= 0.1 m/s) swept": lambda a, b, u: np.maximum(
        1.2 - a[..., 0], 0.1 - a[..., 3]
    ),
    "(norm1(a.x - b.x, a.y - b.y) >= 1 m) swept": lambda a, b, u: (
        np.abs(a[..., :2] - b[..., :2]).sum(-1) - 1
    ),
    "(a.y + 2 * a.x >= 1 m) swept": lambda a, b, u: a[..., 1] + 2 * a[..., 0] - 1,
    "(a.vx - b.vx <= 1 m/s and a.ux <= 0.9 m/s^2) swept": lambda a, b, u: np.minimum(
        1 - a[..., 2] + b[..., 2], 0.9 - u[:, None, 0]
    ),
}


@pytest.mark.parametrize("condition", CONDITIONS)
@pytest.mark.parametrize("dynamics", FLOWS, ids=["parabolas", "spirals"])
def test_conditions_are_judged_at_all_times(dynamics: str, condition: str) -> None:
    mission = loads(MISSION.format(dynamics=dynamics, condition=condition))
    random = np.random.default_rng(3)
    for _ in range(10):
        x, u, dense = {}, {}, []
        for name, agent in mission.agents.items():
            u[name] = random.uniform(-1.0, 1.0, (mission.horizon, 2))
            run = [agent.start]
            for row in u[name]:
                run.append(agent.dynamics.A @ run[-1] + agent.dynamics.B @ row)
            x[name] = np.array(run)
            dense.append(states(FLOWS[dynamics], x[name], u[name]))
        true = float(CONDITIONS[condition](*dense, u["a"]).min())
        report = verify(mission, make_plan(mission, x, u)).requirements[0]
        assert report.swept is not None
        assert true - 2e-2 <= report.swept <= true + 1e-9
        assert report.robustness is not None
        assert report.robustness <= true + 1e-6
        assert report.satisfied == (report.swept >= -1e-6)
