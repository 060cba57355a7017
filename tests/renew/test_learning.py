"""What channels learn on the way: recorded in plans, known to whoever judges them, fitted anew."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support.command import inside

from stlc import api
from stlc.errors import UsageError
from stlc.plan import as_planned, read_plan
from stlc.plan_json import to_json
from stlc.plan_reader import parse
from stlc.radio.gp import ChannelModel
from stlc.radio.learned import Learned, Parameters, taught
from stlc.radio.likelier import ENOUGH, fitted_anew, log_likelihood
from stlc.radio.posterior import JITTER
from stlc.radio.samples import make_samples
from stlc.renew.reestimate import reestimated
from stlc.verify import verify

TEXT = """step 1 s
horizon 6
workspace box [0, 12] x [0, 4]
agent a : single_integrator { start (1, 1); control |u| <= 2 }
station base at (11, 1)
channel radio { path_loss L0 = -40 dBm, n = 3; fading 1 dB^2, shadowing 25 dB^2, length 4 m
  partition 12 x 4 }
require talk: always[4, 6] rssi(a, base) >= -62 dBm
minimize effort
"""
HEARD = "tx_x,tx_y,rx_x,rx_y,rssi\n" + "".join(
    f"{x},{y},11,1,-48\n" for x, y in [(1, 1), (1.5, 1.5), (2, 1), (1, 0.5), (0.5, 1)]
)


def stlc(*args: object) -> tuple[int, str, str]:
    """Exit status, output and errors of a command."""
    done = inside(*args, folder=Path())
    return done.returncode, done.stdout, done.stderr


def _written(tmp_path: Path) -> tuple[Path, Path]:
    file, plan = tmp_path / "m.stl", tmp_path / "plan.json"
    file.write_text(TEXT)
    assert stlc("solve", file, "-o", plan, "--progress", "none")[0] == 0
    (tmp_path / "new.csv").write_text(HEARD)
    return file, plan


def test_a_plan_holds_what_it_was_made_by(tmp_path: Path) -> None:
    file, plan = _written(tmp_path)
    second, third = tmp_path / "2.json", tmp_path / "3.json"
    code, _, _ = stlc(
        "replan", file, plan, "--at", 1, "--samples", tmp_path / "new.csv", "-o", second
    )
    assert code == 0
    made = read_plan(second)
    assert len(made.learned["radio"]) == 5
    moved = made.runs["a"].states[-1, 0] - made.runs["a"].states[1, 0]
    assert moved < 1.0  # by what was heard there is no need to go anywhere
    code, out, _ = stlc("verify", file, second)
    assert code == 0
    assert "radio knows 5 samples measured on the way" in out
    # one that isn't told of them blames the same run
    value = json.loads(second.read_text())
    del value["learned"]
    (tmp_path / "forgetful.json").write_text(json.dumps(value))
    assert stlc("verify", file, tmp_path / "forgetful.json")[0] == 6
    # and what comes later is added
    stlc("replan", file, second, "--at", 2, "--samples", tmp_path / "new.csv", "-o", third)
    assert len(read_plan(third).learned["radio"]) == 10
    assert stlc("verify", file, third)[0] == 0
    assert stlc("simulate", file, third, "--draws", 20)[0] == 0


def test_lessons_survive_the_file() -> None:
    mission = api.loads(TEXT)
    heard = {"radio": make_samples(np.array([[1.0, 1, 11, 1]]), np.array([-50.25]))}
    known = reestimated(mission, heard)
    plan = api.solve(known).plan
    again = parse(to_json(plan))
    assert again.learned["radio"].same(plan.learned["radio"])
    assert verify(mission, again).ok
    assert as_planned(known, again).channels["radio"] is known.channels["radio"]
    fitted = Parameters(-40.5, 2.5, 1.0, 0.5, 9.0, 2.0)
    what = Learned(heard["radio"].links, heard["radio"].rssi, fitted)
    text = to_json(plan).replace('"samples": [', f'"parameters": {_json(fitted)}, "samples": [', 1)
    assert parse(text).learned["radio"].same(what)


def _json(p: Parameters) -> str:
    names = ("l0", "exponent", "fading", "deviation", "shadowing", "length", "losses")
    return json.dumps({name: getattr(p, name) for name in names})


@pytest.mark.parametrize(
    ("learned", "told"),
    [
        ('{"radar": {"samples": [[1, 1, 2, 2, -40]]}}', "'radar' is not in the mission"),
        ('{"radio": {"samples": []}}', "rows of 4 or 6"),
        ('{"radio": {"samples": [[1, 1, 2, -40]]}}', "rows of 4 or 6"),
        (
            '{"radio": {"samples": [[1, 1, 2, 2, -40]], "parameters": {"l0": -40, "exponent": 2, '
            '"fading": -1, "deviation": 0, "shadowing": 1, "length": 1, "losses": []}}}',
            "variance",
        ),
        (
            '{"radio": {"samples": [[1, 1, 2, 2, -40]], "parameters": {"l0": -40, "exponent": 2, '
            '"fading": 1, "deviation": 0, "shadowing": 1, "length": 1, "losses": [3]}}}',
            "other walls",
        ),
    ],
)
def test_lessons_that_are_none(tmp_path: Path, learned: str, told: str) -> None:
    file, plan = _written(tmp_path)
    text = plan.read_text().replace('"solve"', f'"learned": {learned},\n  "solve"', 1)
    plan.write_text(text)
    code, _, err = stlc("verify", file, plan)
    assert code == 2
    assert told in err


TRUE = ChannelModel(-40.0, 2.0, 1.0, 9.0, 3.0)
RNG = np.random.default_rng(2)
LINKS = np.hstack([RNG.uniform(0, 12, (60, 2)), np.tile([11.0, 1.0], (60, 1))])
STRENGTHS = TRUE.sample_prior(LINKS, RNG)


def test_parameters_are_fitted_anew_where_samples_say_so() -> None:
    wrong = ChannelModel(-40.0, 4.0, 1.0, 9.0, 3.0)
    fresh = make_samples(LINKS, STRENGTHS)
    found = fitted_anew(wrong, None, fresh, fresh)
    assert found is not None
    assert abs(found.exponent - 2.0) < 0.5
    assert log_likelihood(found.prior(wrong), fresh) > log_likelihood(wrong, fresh) + 6
    assert fitted_anew(TRUE, None, fresh, fresh) is None  # they say nothing against it
    few = make_samples(LINKS[: ENOUGH - 1], STRENGTHS[: ENOUGH - 1])
    assert fitted_anew(wrong, None, few, few) is None


def test_the_likelihood_is_that_of_a_normal_law() -> None:
    from scipy.stats import multivariate_normal

    model = ChannelModel(-40.0, 2.0, 2.0, 9.0, 3.0, deviation=1.5)
    links = np.vstack([LINKS[:4], LINKS[:2]])
    rssi = np.concatenate([STRENGTHS[:4], STRENGTHS[:2] + 1.0])
    same = np.equal.outer(*[np.array([0, 1, 2, 3, 0, 1])] * 2)
    covariance = model.covariance(links) + 1.5 * same + 2.0 * np.eye(6)
    expected = multivariate_normal(model.mean(links), covariance).logpdf(rssi)
    assert log_likelihood(model, make_samples(links, rssi)) == pytest.approx(expected, abs=1e-6)


def test_a_channel_fitted_anew_is_conditioned_on_all_samples() -> None:
    model = ChannelModel(-40.0, 4.0, 1.0, 9.0, 3.0)
    given = make_samples(LINKS[:20], STRENGTHS[:20])
    found = taught(model, given, Learned(LINKS[20:], STRENGTHS[20:], Parameters.of(TRUE)))
    mean, variance = found.predict(LINKS[5:25], False)
    assert found.exponent == 2.0
    assert (np.abs(mean - STRENGTHS[5:25]) < 3.5).all()
    assert (variance < 1.0 + JITTER).all()


def test_the_command_fits_anew(tmp_path: Path) -> None:
    file, plan = _written(tmp_path)
    rows = [f"{','.join(map(str, y))},{z}" for y, z in zip(LINKS, STRENGTHS, strict=True)]
    (tmp_path / "new.csv").write_text("\n".join([HEARD.splitlines()[0], *rows]) + "\n")
    asked = ("replan", file, plan, "--at", 1, "--samples", tmp_path / "new.csv")
    second = tmp_path / "2.json"
    code, out, _ = stlc(*asked, "--refit", "-o", second)
    assert code == 0
    assert "radio: fitted anew: L0 = " in out
    assert read_plan(second).learned["radio"].parameters is not None
    assert stlc("verify", file, second)[0] == 0
    code, out, _ = stlc(*asked)
    assert "fitted anew" not in out


def test_lessons_do_not_contradict() -> None:
    mission = api.loads(TEXT)
    one, two = (make_samples(np.array([[1.0, 1, 11, 1]]), np.array([z])) for z in (-50.0, -51.0))
    known = reestimated(mission, {"radio": one})
    with pytest.raises(UsageError, match="learnt from other samples"):
        reestimated(known, {"radio": two})
    with pytest.raises(UsageError, match="heights"):
        reestimated(mission, {"radio": make_samples(np.zeros((1, 6)), np.array([-50.0]))},
                    {"radio": Learned(one.links, one.rssi)})  # fmt: skip
