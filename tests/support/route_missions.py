"""What tests of routes and their bounds share: optima to hold bounds against, missions."""

from __future__ import annotations

from stlc.backends import get
from stlc.backends.base import SolveOptions, Status
from stlc.milp.compile import Compiled

_COLLECTING = """step 1 s
horizon {horizon}
workspace box [0, 20] x [0, 20]
agent r : double_integrator {{ start (10, 2); control |u| <= 2; speed <= 4 }}
station a at (3, 18)
station b at {b}
channel radio {{
  path_loss L0 = -40 dBm, n = 3
  noise_floor -92 dBm, modulation oqpsk_802_15_4, packet 64 bytes
  partition 10 x 10
}}
require collect: {collect}
require deliver: {deliver}
minimize effort
"""


def collecting(horizon: int, b: str, collect: str, deliver: str) -> str:
    """A mission that reads from station a and tells station b at a place."""
    return _COLLECTING.format(horizon=horizon, b=b, collect=collect, deliver=deliver)


def optimum(one: Compiled) -> float:
    """The least cost of any plan, by the whole model."""
    found = get("highs").solve(one.model, SolveOptions(gap=1e-7))
    assert found.status is Status.OPTIMAL
    assert found.objective is not None
    return found.objective


def boxes(corners: tuple[float, ...], sizes: tuple[float, ...]) -> list[str]:
    """Boxes in the words of a mission, by lower corners and sizes, x and y in turn."""
    ends = zip(corners[::2], corners[1::2], sizes[::2], sizes[1::2], strict=True)
    return [f"box [{x:.3f}, {x + w:.3f}] x [{y:.3f}, {y + h:.3f}]" for x, y, w, h in ends]
