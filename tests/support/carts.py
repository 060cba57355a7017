"""Three carts that cross, with a radio: what tests of searches for teams share."""

from __future__ import annotations

from stlc import backends
from stlc.backends.base import SolveOptions

HIGHS = backends.get("highs")
EXACT = SolveOptions(gap=1e-6)

CARTS = """
horizon 4
workspace box [0, 6] x [0, 6]
dynamics cart = single_integrator
agent r1 : cart { start (1, 1); control |u| <= 1.5 }
agent r2 : cart { start (1, 3); control |u| <= 1.5 }
agent r3 : cart { start (1, 5); control |u| <= 1.5 }
region low = box [4, 6] x [0, 1.5]
region high = box [4, 6] x [4.5, 6]
require apart: forall (a, b) in pairs: always separation(a, b) >= 1 m swept
channel radio { path_loss L0 = -40 dBm, n = 2; fading 0 dB^2; shadowing 0 dB^2, length 1 m
  noise_floor -90 dBm; partition 3 x 3 }
"""
