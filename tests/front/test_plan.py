"""Plans as objects."""

from __future__ import annotations

import builtins

import numpy as np
import pytest
from support.command import MISSION

import stlc
from stlc.errors import UsageError


@pytest.fixture(scope="module")
def plan() -> stlc.Plan:
    return stlc.loads(MISSION).solve(time_limit=30, gap=1e-3)


def test_what_a_plan_says(plan):
    assert plan.ok
    assert plan.status == "optimal"
    assert plan.gap <= 1e-3
    assert plan.bound <= plan.objective + 1e-9
    assert set(plan.robustness) == {"visit", "clear"}
    assert plan.states("a").shape == (5, 4)
    assert plan.inputs("a").shape == (4, 2)
    assert repr(plan).startswith("<Plan optimal, objective ")
    assert repr(plan).endswith(": a, 4 steps>")
    with pytest.raises(KeyError, match="no agent 'b'; there are a"):
        plan.states("b")


def test_places_between_steps_are_on_the_true_motion(plan):
    x, u = plan.states("a"), plan.inputs("a")
    found = plan.at("a", 1.5)
    np.testing.assert_allclose(found[:2], x[1, :2] + 0.5 * x[1, 2:] + 0.125 * u[1])
    np.testing.assert_allclose(plan.positions("a", plan.times), x[:, :2], atol=1e-9)
    assert plan.at("a", [0.5, 1.5]).shape == (2, 4)
    with pytest.raises(UsageError, match="from 0 to 4 s"):
        plan.at("a", 4.5)


def test_a_frame_has_every_signal(plan):
    frame = plan.to_dataframe()
    assert list(frame.columns) == ["t", "time", "agent", "px", "py", "vx", "vy", "ux", "uy"]
    np.testing.assert_array_equal(frame[["px", "py", "vx", "vy"]], plan.states("a"))


def test_a_frame_without_pandas_is_a_clear_error(plan, monkeypatch):
    real = builtins.__import__

    def without(name, *rest, **more):
        if name == "pandas":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(UsageError, match="pip install pandas"):
        plan.to_dataframe()


def test_files(plan, tmp_path):
    mission = stlc.loads(MISSION)
    plan.write(tmp_path / "p.json")
    again = mission.read_plan(tmp_path / "p.json")
    assert again.ok
    assert again.objective == plan.objective
    assert stlc.read_plan(tmp_path / "p.json", mission).robustness == plan.robustness
    picture = plan.plot(tmp_path / "p.svg")
    assert (tmp_path / "p.svg").read_text().startswith("<?xml")
    assert picture._repr_png_().startswith(b"\x89PNG")
    plan.page(tmp_path / "p.html")
    assert "visit" in (tmp_path / "p.html").read_text()


def test_notebooks_show_missions_and_plans(plan):
    html = plan._repr_html_()
    assert html.count("<tr>") == 3
    assert "visit" in html
    text = stlc.loads(MISSION + "# <b>\n")._repr_html_()
    assert "&lt;b&gt;" in text
    assert "<b>\n" not in text


def test_a_plan_can_start_from_another(plan):
    again = stlc.loads(MISSION).solve(time_limit=30, start=plan)
    assert again.objective == pytest.approx(plan.objective, rel=1e-3)
