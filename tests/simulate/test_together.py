"""Chances of several packets together: sufficient, by simulation and by closed forms."""

from __future__ import annotations

import pytest
from scipy.stats import norm

from stlc import api
from stlc.errors import InfeasibleError, MissionError
from stlc.ir.nodes import Link, walk
from stlc.simulate import simulate

HEAD = """step 1 s
horizon 4
workspace box [0, 12] x [0, 2]
agent a : single_integrator { start (1, 1); control |u| <= 3 }
station mast at (11, 1)
station relay at (0, 1)
channel radio {
  path_loss L0 = -10 dBm, n = 2
  fading 4 dB^2, shadowing 6 dB^2, length 2 m
  partition 24 x 1
}
"""


def _mission(line: str, objective: str = "minimize effort") -> str:
    return f"{HEAD}require p: {line}\n{objective}\n"


def _levels(text: str) -> set[float]:
    formula = api.loads(text).requirements[0].formula
    found = {n.probability for n in walk(formula) if isinstance(n, Link)}
    return {round(p, 12) for p in found if p is not None}


@pytest.mark.parametrize(
    ("inner", "packets", "shares"),
    [
        ("always[1, 4] rssi(a, mast) >= -25 dBm", 4, (1, 4, 7, 13)),
        ("rssi(a, mast) >= -25 dBm and rssi(a, relay) >= -40 dBm", 2, (1, 4, 7)),
        (
            "always[0, 2] (rssi(a, mast) >= -25 dBm and rssi(a, relay) >= -40 dBm)",
            6,
            (1, 4, 10, 19),
        ),
        ("eventually[0, 3] always[0, 1] rssi(a, mast) >= -25 dBm", 2, (1, 4, 7)),
        ("rssi(a, mast) >= -25 dBm or always[0, 2] rssi(a, relay) >= -25 dBm", 3, (1, 4, 10, 12)),
        ("always[0, 1] not rssi(a, mast) >= -5 dBm", 2, (1, 4, 7)),
        ("a.x >= 1 m and rssi(a, mast) >= -60 dBm", 1, (4,)),
        ("always[0, 1] (rssi(a, mast) >= -25 dBm or rssi(a, relay) >= -25 dBm)", 2, (4,)),
        ("always[0, 99] rssi(a, mast) >= -25 dBm", 100, (4,)),
    ],
)
def test_the_risk_is_shared(inner: str, packets: int, shares: tuple[int, ...]) -> None:
    text = _mission(f"P({inner}) >= 0.9").replace("horizon 4", "horizon 99")
    assert _levels(text) == {round(1 - 0.1 * m / (4 * packets), 12) for m in shares}


@pytest.mark.parametrize("level", [-24, -27])
def test_plans_keep_what_is_asked_of_all_packets_together(level: int) -> None:
    line = f"P(always[3, 4] rssi(a, mast) >= {level} dBm) >= 0.8"
    mission = api.loads(_mission(line))
    plan = api.solve(mission).plan
    (found,) = simulate(mission, plan, draws=20_000).requirements
    assert found.low >= 0.8
    alone = api.loads(_mission(f"always[3, 4] P(rssi(a, mast) >= {level} dBm) >= 0.8"))
    each = api.solve(alone).plan
    (weak,) = simulate(alone, each, draws=20_000).requirements
    assert weak.high < 0.8  # each packet by itself is not enough


def test_one_packet_together_is_that_packet() -> None:
    one = _mission("P(always[2, 2] rssi(a, mast) >= -25 dBm) >= 0.8")
    same = _mission("always[2, 2] P(rssi(a, mast) >= -25 dBm) >= 0.8")
    values = [api.solve(api.loads(text)).plan.solve.objective for text in (one, same)]
    assert values[0] == pytest.approx(values[1])


def test_what_cannot_be_met_by_shares_is_infeasible() -> None:
    least = -10 - float(norm.ppf(1 - 0.1 / 3)) * 10**0.5  # at the mast
    text = f"P(always[2, 4] rssi(a, mast) >= {least + 0.5} dBm) >= 0.9"
    mission = api.loads(_mission(text))
    with pytest.raises(InfeasibleError):
        api.solve(mission)


@pytest.mark.parametrize(
    "line",
    [
        "P(always rssi(a, mast) >= -25 dBm) >= 0.9",
        "P(always[0, 2] rssi(a, mast) >= -25 dBm) <= 0.9",
        "not P(always[0, 2] rssi(a, mast) >= -25 dBm) >= 0.9",
        "P(always[0, 2] rssi(a, mast) >= -25 dBm) >= 0.9 implies a.x >= 1 m",
        "P(always[0, 2] a.x >= 1 m) >= 0.9",
        "P(a.x >= 1 m) >= 0.9",
        "P((rssi(a, mast) >= -25 dBm) until[0, 2] (a.x >= 1 m)) >= 0.9",
        "P(always[0, 2] P(rssi(a, mast) >= -25 dBm) >= 0.9) >= 0.9",
        "P(always[0, 2] rssi(a, mast) >= -25 dBm) >= 1.5",
    ],
)
def test_what_has_no_bound_from_below_is_told(line: str) -> None:
    with pytest.raises(MissionError) as caught:
        api.loads(_mission(line))
    assert all(d.span is not None for d in caught.value.diagnostics)
