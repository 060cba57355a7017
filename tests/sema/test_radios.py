"""Frequencies, power, energy, antennas: what a file says of radios, and what links make of it."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from stlc import api
from stlc.channels import ChannelTables, true_values
from stlc.errors import MissionError
from stlc.mission import Mission
from stlc.verify import verify

TEXT = """step 1 s
horizon 4
workspace box [0, 20] x [0, 10]
agent r1 : double_integrator { start (1, 1); control |u| <= 1; speed <= 2; R1 }
agent r2 : double_integrator { start (9, 1); control |u| <= 1; speed <= 2; R2 }
station base at (19, 5) { height 6 m }
channel wifi { WIFI; partition 10 x 5 }
channel lora { frequency 868 MHz; power 14 dBm; path_loss n = 3; d0 2 m; partition 5 x 3
  bound BOUND }
require far: always rssi(r1, r2, lora) >= -60 dBm
REST
"""
WIFI = "frequency 2.4 GHz; power 100 mW; path_loss n = 2; noise_floor -90 dBm"


def _mission(
    wifi: str = WIFI, r1: str = "mass 1 kg", rest: str = "", bound: str = "worst"
) -> Mission:
    text = TEXT.replace("WIFI", wifi).replace("R1", r1).replace("R2", "mass 1 kg")
    return api.loads(text.replace("REST", rest).replace("BOUND", bound))


def test_free_space_gives_the_strength_at_d0() -> None:
    channels = _mission().channels
    wifi, lora = channels["wifi"].model, channels["lora"].model
    assert wifi is not None
    assert lora is not None
    assert wifi.l0 == pytest.approx(20 - 20 * math.log10(4 * math.pi * 2.4e9 / 299792458.0))
    at_d0 = lora.mean(np.array([[0.0, 0.0, 2.0, 0.0]]))[0]
    assert at_d0 == pytest.approx(14 - 20 * math.log10(4 * math.pi * 2 * 868e6 / 299792458.0))


def test_a_strength_that_is_given_stays() -> None:
    model = _mission("path_loss L0 = -40 dBm, n = 2; frequency 2.4 GHz").channels["wifi"].model
    assert model is not None
    assert model.l0 == -40.0


@pytest.mark.parametrize(
    ("wifi", "told"),
    [
        ("frequency 2.4 GHz; path_loss n = 2", "power"),
        ("frequency 2.4 GHz; power 20 dBm", "path_loss"),
        ("frequency 0 Hz; power 20 dBm; path_loss n = 2", "above 0"),
        ("frequency 2.4 GHz; power 0 W; path_loss n = 2", "above 0 W"),
        (f"{WIFI}; cost energy; modulation bpsk; packet 32 bytes", "rate"),
    ],
)
def test_what_lacks_is_said(wifi: str, told: str) -> None:
    with pytest.raises(MissionError, match=told):
        _mission(wifi, rest="minimize link_cost(wifi, (r1, base))")


ENERGY = (
    f"{WIFI}; bandwidth 2 MHz; rate 250 kbit/s; modulation oqpsk_802_15_4; packet 125 bytes; "
    "fading 4 dB^2; cost energy"
)


@pytest.mark.parametrize("cost_bound", ["mean", "worst"])
def test_energy_is_power_by_time_on_the_air(cost_bound: str) -> None:
    """100 mW for 4 ms, as often as it takes until the packet is through."""
    mission = _mission(
        f"{ENERGY}; cost_bound {cost_bound}", rest="minimize link_cost(wifi, (r1, base))"
    )
    table = ChannelTables(mission).cost("wifi", ("r1", "base"))
    assert table.min() == pytest.approx(0.4, rel=1e-6)
    noisy = _mission(
        f"{ENERGY}; cost_bound {cost_bound}".replace("-90", "-36"),
        rest="minimize link_cost(wifi, (r1, base))",
    )
    costs = ChannelTables(noisy).cost("wifi", ("r1", "base"))
    assert costs.min() < 0.41 < 0.8 < costs.max() <= 400.0
    assert verify(noisy, api.solve(noisy).plan).ok


def test_energy_holds_within_its_bounds() -> None:
    """Of any place in a cell it is at most what `worst` says, and at least what its negation."""
    rest = "require a: always[4, 4] link_cost(wifi, (r1, base)) <= 1"
    mission = _mission(ENERGY.replace("-90", "-38"), rest=rest)
    (link,) = [r.formula.children[0] for r in mission.requirements if r.name == "a"]
    found = ChannelTables(mission).thresholds(link)
    channel, rng = mission.channels["wifi"], np.random.default_rng(1)
    boxes = channel.partition.boxes
    from stlc.channels import true_robustness

    for _ in range(20):
        unit = rng.uniform(0, 1, (len(boxes), 2))
        low, high = boxes[:, 0:4:2], boxes[:, 1:4:2]
        places = np.column_stack([low + unit * (high - low), np.zeros(len(boxes))])
        base = np.tile(mission.stations["base"].place, (len(boxes), 1))
        values = true_values(mission, channel, ("r1", "base"), places, base)
        truth = true_robustness(channel, link, values)
        assert (found.low <= truth + 1e-9).all()
        assert (truth <= found.high + 1e-9).all()


def test_antennas_are_above_their_agents() -> None:
    mission = _mission(r1="antenna 1.5 m")
    a, b = np.array([[1.0, 1.0, 0.0]]), np.array([[19.0, 5.0, 6.0]])
    found = true_values(mission, mission.channels["wifi"], ("r1", "base"), a, b)
    assert found.distance[0] == pytest.approx(math.sqrt(18**2 + 4**2 + 4.5**2))
    ground = true_values(mission, mission.channels["wifi"], ("r2", "base"), a, b)
    assert ground.distance[0] == pytest.approx(math.sqrt(18**2 + 4**2 + 6**2))


@pytest.mark.parametrize("bound", ["worst", "centre"])
def test_antennas_count_in_tables_and_verdicts(bound: str) -> None:
    """A raised antenna is further from one on the ground, and near above it all the same."""
    rest = "require close: eventually distance(r1, r2) <= 1.5 m\nmaximize robustness(far)"
    low, high = (
        api.solve(_mission(r1=r1, bound=bound, rest=rest.replace("1.5 m", "7 m")))
        for r1 in ("antenna 0 m", "antenna 9 m")
    )
    assert low.plan.solve.objective is not None
    assert high.plan.solve.objective is not None
    assert high.plan.solve.objective < low.plan.solve.objective - 1.0
    (series,) = high.report.links
    off = [low_run.states[:, :2] for low_run in high.plan.runs.values()]
    flat = np.linalg.norm(off[0] - off[1], axis=1)
    np.testing.assert_allclose(series.values["distance"], np.hypot(flat, 9.0), atol=1e-9)
    assert high.report.ok


@pytest.mark.parametrize("r1", ["antenna -1 m", "antenna 1 s"])
def test_antennas_that_are_none(r1: str) -> None:
    with pytest.raises(MissionError):
        _mission(r1=r1)


def test_who_flies_has_its_antenna_where_it_is() -> None:
    text = (
        "workspace box [0, 5] x [0, 5]\ndynamics drone = single_integrator { dimensions 3 }\n"
        "agent d : drone { start (1, 1, 1); control |u| <= 1; antenna 1 m }\n"
        "require: eventually[0, 2] d.x >= 1 m\n"
    )
    with pytest.raises(MissionError, match="flies"):
        api.loads(text)


def test_samples_in_the_plane_know_no_antennas(tmp_path: Path) -> None:
    (tmp_path / "s.csv").write_text("tx_x,tx_y,rx_x,rx_y,rssi\n1,1,5,1,-50\n2,1,5,2,-51\n")
    wifi = f'{WIFI}; shadowing 4 dB^2; length 2 m; fading 1 dB^2; samples "s.csv"'
    text = TEXT.replace("WIFI", wifi)
    text = text.replace("R1", "antenna 2 m").replace("R2", "mass 1 kg").replace("BOUND", "worst")
    with pytest.raises(MissionError, match="raised antenna"):
        api.loads(text.replace("REST", ""), folder=tmp_path)
