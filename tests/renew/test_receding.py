"""Closed loops in a simulated world, and channels that learn."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc

from stlc import api
from stlc.errors import UsageError
from stlc.mission import Mission
from stlc.plan import read_plan
from stlc.radio.gp import ChannelModel, condition, extended
from stlc.radio.joint import joint
from stlc.radio.samples import make_samples
from stlc.renew.receding import Heard, Loop, Measured, deviation
from stlc.renew.reestimate import channel_of, reestimated
from stlc.renew.world import SimulatedWorld, TrueChannel
from stlc.solve.outcome import SolveSettings

MODEL = ChannelModel(-20.0, 2.0, 3.0, 8.0, 2.0, deviation=0.5)


def _samples(rng: np.random.Generator, count: int):
    return make_samples(rng.uniform(0, 6, (count, 4)), rng.normal(-40, 4, count))


@pytest.mark.parametrize("seed", range(3))
def test_what_comes_later_counts_as_if_it_had_been_there(seed: int) -> None:
    rng = np.random.default_rng(seed)
    early, late, asked = _samples(rng, 30), _samples(rng, 7), rng.uniform(0, 6, (20, 4))
    together = make_samples(
        np.vstack([early.links, late.links]), np.concatenate([early.rssi, late.rssi])
    )
    step_by_step = extended(extended(condition(MODEL, early), late.take(np.arange(3))),
                            late.take(np.arange(3, 7)))  # fmt: skip
    for fading in (False, True):
        for one, other in zip(
            step_by_step.predict(asked, fading), condition(MODEL, together).predict(asked, fading),
            strict=True,
        ):  # fmt: skip
            np.testing.assert_allclose(one, other, atol=1e-6)
    assert extended(MODEL, early).posterior is not None


def test_a_channel_drawn_link_by_link_is_one_joint_draw() -> None:
    rng = np.random.default_rng(5)
    links = np.array([[1, 1, 4, 4], [1.5, 1, 4, 4], [4, 4, 1, 1.2]], dtype=float)
    known = condition(MODEL, _samples(rng, 10))
    law = joint(replace(known, deviation=0.0), links[None])
    draws = np.array(
        [[c.mean(link) for link in links] for c in (TrueChannel(known, rng) for _ in range(4000))]
    )
    np.testing.assert_allclose(draws.mean(axis=0), law.mean[0], atol=0.2)
    np.testing.assert_allclose(np.cov(draws.T), law.root[0] @ law.root[0].T, atol=0.4)


LOOP = """step 1 s
horizon 8
workspace box [0, 10] x [0, 10]
agent a : double_integrator {{ start (1, 1); control |u| <= 1; speed <= 2; {noise} }}
station base at (9, 5)
region dock = box [6, 9] x [7, 9]
channel radio {{
  path_loss L0 = -30 dBm, n = 2; fading 2 dB^2, shadowing {shadowing} dB^2, length 2 m
  partition 5 x 5
}}
require go: eventually[0, 8] a in dock
require talk: always[4, 8] rssi(a, base) >= -55 dBm
minimize effort
"""


def _mission(noise: str = "", shadowing: float = 4.0) -> Mission:
    return api.loads(LOOP.format(noise=noise, shadowing=shadowing))


def test_a_loop_without_surprises_keeps_its_plan() -> None:
    mission = _mission()
    loop = Loop(sigmas=np.inf)
    found = api.receding(mission, SimulatedWorld(mission, np.random.default_rng(1)), loop)
    assert [e.why for e in found.events] == ["the first plan"]
    first = found.events[0].renewed
    assert first is not None
    np.testing.assert_allclose(found.run.runs["a"].states, first.plan.runs["a"].states, atol=1e-9)
    assert found.run.executed == 8
    assert len(found.seconds) == 8
    assert {r.name: r.satisfied for r in found.report.requirements}["go"]


@pytest.mark.parametrize("seed", [2, 3])
def test_a_loop_in_a_noisy_world(seed: int) -> None:
    """Pushed off its plan at every step, it plans anew, and still gets there."""
    mission = _mission("control_noise 0.03")
    world = SimulatedWorld(mission, np.random.default_rng(seed))
    loop = Loop(drift=0.02, settings=SolveSettings(time_limit=3.0, gap=0.02))
    found = api.receding(mission, world, loop)
    renewed = [e for e in found.events if e.step]
    assert renewed
    assert all("off its" in e.why for e in renewed)
    places = found.run.runs["a"].states[:, :2]
    away = np.abs(places - np.clip(places, [6, 7], [9, 9])).max(axis=1)
    assert away.min() < 0.1  # the last push is nobody's plan
    model = found.mission.channels["radio"].model
    assert model is not None
    assert model.posterior is not None
    assert model.posterior.samples == 9


def test_forecasts_that_fail_are_events() -> None:
    mission = _mission()
    link = np.array([1.0, 1.0, 9.0, 5.0])
    model = mission.channels["radio"].model
    assert model is not None
    mean, variance = model.predict(link[None], True)
    packet = Heard("radio", ("a", "base"), link, float(mean[0] + 2.5 * np.sqrt(variance[0])))
    assert deviation(mission, packet) == pytest.approx(2.5)

    class Loud(SimulatedWorld):
        """Hears everything far louder than it can be."""

        def step(self, states, inputs):
            found = super().step(states, inputs)
            return Measured(
                found.states, tuple(replace(p, strength=p.strength + 30) for p in found.heard)
            )

    found = api.receding(mission, Loud(mission, np.random.default_rng(0)), Loop(learn=False))
    assert "sigma off its forecast" in found.events[1].why


def test_a_fixed_rhythm() -> None:
    mission = _mission(shadowing=0.0)
    world = SimulatedWorld(mission, np.random.default_rng(0))
    found = api.receding(mission, world, Loop(every=3, sigmas=np.inf))
    assert [e.step for e in found.events] == [0, 3, 6]
    assert found.report.ok


def test_samples_for_the_command(tmp_path: Path) -> None:
    text = LOOP.format(noise="", shadowing=4.0)
    (tmp_path / "m.stl").write_text(text)
    api.solve(api.loads(text)).plan.write(tmp_path / "p.json")
    lines = ["tx_x,tx_y,rx_x,rx_y,rssi", "3,3,9,5,-58", "4,4,9,5,-62", "7,8,9,5,-61"]
    (tmp_path / "new.csv").write_text("\n".join(lines))
    words = ("replan", "m.stl", "p.json", "--at", 2, "-o", "q.json", "--samples")
    assert stlc(*words, "new.csv", folder=tmp_path).returncode in (0, 6)
    assert stlc(*words, "radio=new.csv", folder=tmp_path).returncode in (0, 6)
    before, after = read_plan(tmp_path / "p.json"), read_plan(tmp_path / "q.json")
    strength = [p.links[0].values["rssi"] for p in (before, after)]
    assert strength[1][-1] < strength[0][-1] - 0.5  # it knows now that it is weaker there
    (tmp_path / "bad.csv").write_text("a,b\n1,2\n")
    assert stlc(*words, "bad.csv", folder=tmp_path).returncode == 2


def test_channels_that_take_no_samples() -> None:
    mission = _mission()

    samples = make_samples(np.ones((1, 4)), np.array([-40.0]))
    for name in ("wifi", "none"):
        with pytest.raises(UsageError, match=name):
            reestimated(mission, {name: samples})
    assert channel_of(mission, "radio=x.csv") == ("radio", Path("x.csv"))
    assert channel_of(mission, "x=1.csv") == ("radio", Path("x=1.csv"))
    two = replace(mission, channels={**mission.channels, "b": mission.channels["radio"]})
    with pytest.raises(UsageError, match="NAME="):
        channel_of(replace(two, channels={}), "x.csv")
