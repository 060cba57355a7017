"""Simulated probabilities against closed forms."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import multivariate_normal, norm
from support.command import inside as stlc

from stlc import api
from stlc.channels import true_values
from stlc.errors import MissionError, UsageError
from stlc.link_places import true_links
from stlc.mission import Mission
from stlc.plan import Plan, make_plan
from stlc.radio.joint import joint
from stlc.simulate import Estimate, simulate

DRAWS = 40_000

HEAD = """step 1 s
horizon 4
workspace box [0, 10] x [0, 10]
agent a : single_integrator {{ start (1, 1); control |u| <= 1; {a} }}
agent b : single_integrator {{ start (6, 1); control |u| <= 1 }}
station mast at (5, 5)
channel radio {{
  path_loss L0 = -10 dBm, n = 2
  fading {fading} dB^2, shadowing 6 dB^2, length 2 m, deviation {own} dB^2
  {extra}
  partition 4 x 4
}}
"""

SAMPLES = """tx_x,tx_y,rx_x,rx_y,rssi
1,1,6,1,-20
2,1,6,2,-31
1,2,5,1,-29
"""


def _mission(
    tmp_path: Path, *lines: str, fading: float = 4, own: float = 0, extra: str = "", a: str = ""
) -> Mission:
    (tmp_path / "s.csv").write_text(SAMPLES)
    head = HEAD.format(fading=fading, own=own, extra=extra, a=a)
    return api.loads(head + "\n".join(lines), folder=tmp_path)


def _plan(mission: Mission, moves: dict[str, list[tuple[float, float]]] | None = None) -> Plan:
    """The plan of given inputs; who has none stays where it is."""
    states, inputs = {}, {}
    for name, agent in mission.agents.items():
        u = np.array((moves or {}).get(name, [(0.0, 0.0)] * mission.horizon))
        inputs[name] = u
        states[name] = agent.start + np.vstack([np.zeros(2), np.cumsum(u, axis=0)])
    return make_plan(mission, states, inputs)


def _sure(estimate: Estimate, truth: float) -> None:
    """The truth lies in an interval that misses it once in ten thousand times."""
    assert estimate.low <= truth <= estimate.high, (estimate.low, truth, estimate.high)


def _run(mission: Mission, plan: Plan, draws: int = DRAWS, **options: bool) -> dict[str, Estimate]:
    found = simulate(mission, plan, draws=draws, seed=7, confidence=0.9999, **options)
    return {e.name: e for e in (*found.requirements, found.joint)}


@pytest.mark.parametrize("extra", ["", 'samples "s.csv"'])
def test_one_packet_is_what_chance_predicates_speak_of(tmp_path: Path, extra: str) -> None:
    mission = _mission(
        tmp_path, "require p: always[2,2] P(rssi(a, b) >= -25 dBm) >= 0.5", own=2, extra=extra
    )
    plan = _plan(mission)
    at = {name: run.states[:1] for name, run in plan.runs.items()}
    link = true_values(mission, mission.channels["radio"], ("a", "b"), at["a"], at["b"])
    truth = norm.cdf((link.mean[0] + 25) / link.sigma[0])
    _sure(_run(mission, plan)["p"], truth)


def test_a_link_at_rest_fades_anew_and_keeps_its_shadow(tmp_path: Path) -> None:
    mission = _mission(tmp_path, "require p: always[0,3] rssi(a, b) >= -25 dBm", own=3)
    mean = -10 - 20 * np.log10(5.0)
    shared = np.sqrt(6 + 3)

    def all_four(z: float) -> float:
        return float(norm.pdf(z) * norm.cdf((mean + shared * z + 25) / 2) ** 4)

    found = _run(mission, _plan(mission))["p"]
    _sure(found, quad(all_four, -8, 8)[0])
    steady = _run(mission, _plan(mission), fading=False)["p"]
    _sure(steady, float(norm.cdf((mean + 25) / shared)))


def test_pairs_and_steps_are_drawn_jointly(tmp_path: Path) -> None:
    mission = _mission(
        tmp_path,
        "require p: always[0,1] rssi(a, b) >= -25 dBm",
        "require q: always[0,1] rssi(b, a) >= -25 dBm",
        "require r: eventually[0,0] rssi(a, mast) >= -27 dBm",
        extra='samples "s.csv"',
    )
    plan = _plan(mission, {"a": [(0.7, 0.4)] * 4})
    model = mission.channels["radio"].model
    assert model is not None
    a, b = (plan.runs[name].states[:2] for name in ("a", "b"))
    mast = np.array([[5.0, 5.0]])
    links = [true_links(mission, model, ("a", "b"), a, b)]
    links.append(true_links(mission, model, ("a", "mast"), a[:1], mast))
    law = joint(model, np.concatenate(links)[None])
    covariance = law.root[0] @ law.root[0].T
    excess = law.mean[0] - np.array([-25, -25, -27])
    # p and q look at two packets each of the same links
    pick = [0, 1, 0, 1, 2]
    spread = covariance[np.ix_(pick, pick)] + model.fading * np.eye(5)
    found = _run(mission, plan)
    _sure(found["all together"], _orthant(excess[pick], spread))
    _sure(found["p"], _orthant(excess[:2], spread[:2, :2]))


def _orthant(mean: np.ndarray, covariance: np.ndarray) -> float:
    """P(x >= 0) of a normal vector."""
    return float(multivariate_normal(np.zeros(len(mean)), covariance).cdf(mean))


def test_the_posterior_is_that_of_the_gaussian_process(tmp_path: Path) -> None:
    mission = _mission(tmp_path, extra='samples "s.csv"', own=1)
    model = mission.channels["radio"].model
    assert model is not None
    links = np.array([[1.0, 1, 6, 1], [2, 2, 6, 1], [6, 1, 1, 1], [3, 3, 5, 5]])
    law = joint(model, links[None])
    mean, variance = model.predict(links, False)
    np.testing.assert_allclose(law.mean[0], mean)
    square = law.root[0] @ law.root[0].T
    np.testing.assert_allclose(np.diag(square), variance, rtol=1e-6)
    assert square[0, 2] == pytest.approx(square[0, 0], rel=1e-6)  # one link, both directions


def test_noise_spreads_as_linear_dynamics_do(tmp_path: Path) -> None:
    mission = _mission(
        tmp_path,
        "require p: eventually[4,4] a.x <= 3.1 m",
        "require q: always (a.y >= 0.9 m or b.x <= 5 m)",
        "require b: always b.x >= 6 m",
        a="start_noise (0.3, 0); control_noise 0.1",
    )
    found = _run(mission, _plan(mission, {"a": [(0.5, 0.0)] * 4}))
    _sure(found["p"], float(norm.cdf(0.1 / np.sqrt(0.3**2 + 4 * 0.1**2))))
    assert found["b"].certain
    assert found["b"].probability == 1.0
    assert 0 < found["q"].probability < 1


def test_links_follow_noisy_positions(tmp_path: Path) -> None:
    mission = _mission(
        tmp_path, "require p: always[0,0] rssi(a, mast) >= -24 dBm",
        a="start_noise (1, 0)", fading=1, extra='samples "s.csv"',
    )  # fmt: skip
    model = mission.channels["radio"].model
    assert model is not None

    def one(x: float) -> float:
        mean, variance = model.predict(np.array([[x, 1.0, 5, 5]]), True)
        return float(norm.pdf(x, 1, 1) * norm.cdf((mean[0] + 24) / np.sqrt(variance[0])))

    _sure(_run(mission, _plan(mission), 10_000)["p"], quad(one, -6, 8, limit=200)[0])


def test_tables_are_looked_up_where_noise_puts_the_agent(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("\n".join(["1,5"] * 2) + "\n")
    mission = api.loads(
        """step 1 s
horizon 1
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (4, 5); control |u| <= 1; start_noise (2, 0) }
agent b : single_integrator { start (4, 5); control |u| <= 1 }
channel radio { partition 2 x 1; table "t.csv" }
require p: always[0,0] link_cost(radio, (b, a)) <= 2
""",
        folder=tmp_path,
    )
    touched = float(norm.cdf(5, 4, 2) - norm.cdf(0, 4, 2))  # outside every cell costs without end
    _sure(_run(mission, _plan(mission))["p"], touched)


def test_pairs_with_and_without_noise_share_a_channel(tmp_path: Path) -> None:
    lines = (
        "require p: always[0,1] rssi(a, mast) >= -24 dBm",
        "require q: always[0,0] rssi(b, mast) >= -22 dBm",
    )
    mission = _mission(tmp_path, *lines, a="start_noise (1, 0)")
    found = _run(mission, _plan(mission), 10_000)
    mean = -10 - 20 * np.log10(np.hypot(1, 4))
    _sure(found["q"], float(norm.cdf((mean + 22) / np.sqrt(6 + 4))))
    assert 0 < found["p"].probability < 1


def test_pairs_in_space_and_on_the_ground_share_a_channel() -> None:
    mission = api.loads("""step 1 s
horizon 1
workspace box [0, 10] x [0, 10]
dynamics drone = single_integrator { dimensions 3; pz in [0, 9]; control |u| <= 1 }
agent a : drone { start (1, 1, 4) }
agent b : single_integrator { start (4, 1); control |u| <= 1 }
agent c : single_integrator { start (6, 1); control |u| <= 1 }
channel radio { path_loss L0 = -10 dBm, n = 2; fading 4 dB^2, shadowing 6 dB^2, length 2 m
  partition 4 x 4 }
require p: always[0,0] rssi(a, b) >= -24 dBm
require q: always[0,0] rssi(b, c) >= -17 dBm
""")
    rest = {n: np.zeros((1, a.dynamics.B.shape[1])) for n, a in mission.agents.items()}
    plan = make_plan(
        mission, {n: np.tile(a.start, (2, 1)) for n, a in mission.agents.items()}, rest
    )
    found = _run(mission, plan)
    spread = np.sqrt(6 + 4)
    _sure(found["p"], float(norm.cdf((-10 - 20 * np.log10(5) + 24) / spread)))
    _sure(found["q"], float(norm.cdf((-10 - 20 * np.log10(2) + 17) / spread)))


def test_swept_conditions_of_certain_agents_are_those_of_the_verifier(tmp_path: Path) -> None:
    lines = ("obstacle rock = box [2.4, 2.6] x [0, 2]", "require p: always a outside rock swept")
    mission = _mission(tmp_path, *lines)
    plan = _plan(mission, {"a": [(1.0, 0.0)] * 4})
    assert _run(mission, plan)["p"].probability == 0.0
    assert api.verify(mission, plan).requirements[0].swept == pytest.approx(-0.1)
    away = _plan(mission, {"a": [(0.0, 1.0)] * 4})
    assert _run(mission, away)["p"].probability == 1.0
    shaken = _mission(tmp_path, *lines, a="start_noise 0.01 m")
    assert _run(shaken, _plan(shaken))["p"].probability == 1.0


def test_seeds_repeat(tmp_path: Path) -> None:
    mission = _mission(tmp_path, "require p: always rssi(a, b) >= -25 dBm")
    plan = _plan(mission)
    one, same, other = (simulate(mission, plan, draws=500, seed=s).as_dict() for s in (1, 1, 2))
    assert one == same
    assert one["requirements"] != other["requirements"]
    with pytest.raises(UsageError):
        simulate(mission, plan, draws=0)


@pytest.mark.parametrize(
    "words",
    ["start_noise -1 m", "start_noise (1, 2, 3)", "control_noise 2 s", "start_noise 1 dB"],
)
def test_noise_that_is_none_is_told(tmp_path: Path, words: str) -> None:
    with pytest.raises(MissionError):
        _mission(tmp_path, "require p: always a.x >= 0 m", a=words)


def test_the_command(tmp_path: Path) -> None:
    mission = _mission(tmp_path, "require p: always rssi(a, b) >= -25 dBm")
    (tmp_path / "m.stl").write_text(mission.source.text)
    _plan(mission).write(tmp_path / "p.json")
    done = stlc("simulate", "m.stl", "p.json", "--draws", "200", "--json", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)["requirements"][0]
    assert sum(said["histogram"]["counts"]) == 200
    assert said["low"] < said["probability"] < said["high"]
    text = stlc("simulate", "m.stl", "p.json", "--seed", "3", folder=tmp_path).stdout
    assert "10000 draws, seed 3" in text
    assert "####" in text


@pytest.mark.parametrize(
    ("properties", "note"),
    [
        ("control_noise 0.01", "noise, and the plan as it stands, without feedback: a"),
        ("disturbance |w| <= 0.04",
         "disturbances, half of them as large as they get, under feedback: a"),
        ("disturbance |w| <= 0.04; control_noise 0.01",
         "noise and disturbances, half of these as large as they get, under feedback: a"),
    ],
)  # fmt: skip
def test_notes_say_whether_there_is_feedback(properties: str, note: str) -> None:
    text = f"""step 1 s
    horizon 2
    agent a : double_integrator {{ start (1, 1); control |u| <= 1; {properties} }}
    require c: always a.x <= 2
    """
    mission = api.loads(text)
    plan = make_plan(mission, {"a": np.tile(mission.agents["a"].start, (3, 1))},
                     {"a": np.zeros((2, 2))})  # fmt: skip
    assert note in simulate(mission, plan, draws=10).notes
