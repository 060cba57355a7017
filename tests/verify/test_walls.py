"""Missions with walls: planned around, judged by the verifier's own geometry."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.command import inside as stlc

from stlc import api
from stlc.channels import ChannelTables
from stlc.errors import InfeasibleError, MissionError
from stlc.mission import Mission
from stlc.plan import make_plan
from stlc.verify import verify

HEAD = """step 1 s
horizon 5
workspace box [0, 6] x [0, 5]
agent a : single_integrator {{ start (1, 1); control |u| <= 1; integer }}
station base at (5.5, 0.7)
wall brick = line (3.5, 0) (3.5, 2.5) loss 12 dB
wall core = box [4.2, 4.8] x [3.2, 3.8] loss 20 dB
channel radio {{ path_loss L0 = -30 dBm, n = 2; {model} partition 6 x 5; {more} }}
"""
MODELS = ["", "fading 2 dB^2, shadowing 4 dB^2, length 2 m;"]
ASKED = [
    "require t: eventually[0, 5] rssi(a, base) >= -50 dBm\nminimize effort",
    "require t: eventually[0, 5] always[0, 0] rssi(a, base) >= -43 dBm\nminimize effort",
    "require t: always not (rssi(a, base) >= -45 dBm)\nrequire g: eventually a.x >= 3 m\n"
    "minimize effort",
]


def _mission(asked: str, model: str = "", more: str = "") -> Mission:
    return api.loads(HEAD.format(model=model, more=more) + asked)


def _best(mission: Mission) -> float | None:
    """Least effort of all runs on whole steps, by the verifier."""
    moves = [np.array(m, float) for m in itertools.product((-1, 0, 1), repeat=2)]
    runs = itertools.product(moves, repeat=mission.horizon - 2)
    tables = ChannelTables(mission)  # made once
    for steps in sorted(runs, key=lambda run: float(np.abs(run).sum())):
        u = np.array([*steps, (0.0, 0.0), (0.0, 0.0)])
        x = np.vstack([[1.0, 1.0], 1.0 + np.cumsum(u, axis=0)])
        if (x < 0).any() or (x > [6, 5]).any():
            continue
        if verify(mission, make_plan(mission, {"a": x}, {"a": u}), tables).ok:
            return float(np.abs(u).sum())
    return None


@pytest.mark.parametrize("asked", ASKED)
def test_the_best_of_all_runs(asked: str) -> None:
    mission = _mission(asked)
    best = _best(mission)
    assert best is not None
    outcome = api.solve(mission)
    assert outcome.plan.solve.objective == pytest.approx(best, abs=1e-4)
    bare = _mission(asked, more="walls none")
    assert bare.channels["radio"].model.walls is None
    try:
        without = api.solve(bare).plan.solve.objective
    except InfeasibleError:
        without = None
    assert without != pytest.approx(best, abs=1e-4)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("bound", ["worst", "centre", "mean"])
def test_plans_heed_walls(model: str, bound: str) -> None:
    outcome = api.solve(_mission(ASKED[0], model, f"bound {bound}"))
    assert outcome.report.ok
    if bound == "worst":
        assert not outcome.report.approximate
        run = outcome.plan.runs["a"].states
        step = int(np.argmax(outcome.plan.links[0].values["rssi"]))
        assert run[step, 0] > 3 or run[step, 1] > 2


def test_the_verifier_counts_walls_by_itself() -> None:
    """Where the radio's own count goes wrong, plans made by it are found out."""
    mission = _mission(ASKED[0])
    channel = mission.channels["radio"]
    walls = channel.model.walls
    blind = replace(walls, lines=walls.lines + 50.0)
    faulty = replace(channel, model=replace(channel.model, walls=blind))
    wrong = replace(mission, channels={"radio": faulty})
    plan = api.solve(_mission(ASKED[0], more="walls none")).plan
    report = verify(wrong, plan)
    assert not report.ok
    assert "not at the true positions" in str(report.violations[0])


def test_some_walls_for_some_channels() -> None:
    mission = _mission("require t: eventually a.x >= 2 m", more="walls core")
    assert mission.channels["radio"].model.walls.names == ("core",)
    assert set(mission.walls) == {"brick", "core"}


SAMPLES = "tx_x,tx_y,rx_x,rx_y,rssi\n"


def test_losses_are_fitted_where_a_channel_is(tmp_path: Path) -> None:
    rng = np.random.default_rng(2)
    links = rng.uniform([0, 0, 0, 0], [6, 5, 6, 5], (80, 4))
    truth = _mission("require t: eventually a.x >= 2 m", MODELS[1]).channels["radio"].model
    level = truth.sample_prior(links, rng)
    rows = ["{:.3f},{:.3f},{:.3f},{:.3f},{:.2f}".format(*k, v)
            for k, v in zip(links, level, strict=True)]  # fmt: skip
    (tmp_path / "s.csv").write_text(SAMPLES + "\n".join(rows))
    text = HEAD.format(model='samples "s.csv" fit;', more="").replace(
        "path_loss L0 = -30 dBm, n = 2; ", ""
    )
    text = text.replace(" loss 12 dB", "") + "require t: eventually a.x >= 2 m\n"
    mission = api.loads(text, folder=tmp_path)
    losses = dict(zip(("brick", "core"), mission.channels["radio"].model.walls.loss, strict=True))
    assert losses["brick"] == pytest.approx(12, abs=4)
    assert losses["core"] == pytest.approx(20, abs=8)
    (tmp_path / "walls.stl").write_text("\n".join(text.splitlines()[5:7]))
    done = stlc("fit", "s.csv", "--walls", "walls.stl", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "walls help by" in done.stdout
    assert "brick:" in done.stdout
    (tmp_path / "none.stl").write_text("step 1 s\n")
    assert stlc("fit", "s.csv", "--walls", "none.stl", folder=tmp_path).returncode == 2


@pytest.mark.parametrize(
    ("line", "more", "told"),
    [
        ("wall thin = line (1, 1) loss 3 dB", "", "two corners or more"),
        ("wall thin = line (1, 1) (1, 1) loss 3 dB", "", "two corners or more"),
        ("wall thin = line (1, 1) (2, 1) loss -3 dB", "", "can't lose -3 dB"),
        ("wall thin = line (1, 1) (2, 1) loss 3 m", "", "m"),
        ("wall thin = box [1, 2] x [1, 2] x [0, 3] loss 3 dB", "", "at every height"),
        ("wall thin = line (1, 1) (2, 1)", "", "the loss of the wall `thin` isn't known"),
        ("wall brick = line (1, 1) (2, 1) loss 3 dB", "", "brick"),
        ("", "walls bric", "there is no wall `bric`"),
        ("", "walls 3", "needs names of walls"),
    ],
)
def test_walls_that_are_none(line: str, more: str, told: str) -> None:
    with pytest.raises(MissionError, match="E0") as caught:
        api.loads(HEAD.format(model="", more=more) + line + "\nrequire t: eventually a.x >= 2 m")
    assert told in str(caught.value)
