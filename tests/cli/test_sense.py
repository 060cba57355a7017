"""What is maximised has the person's sign in every output, and is minimised nowhere but inside."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from support.command import inside as stlc

from stlc import api
from stlc.bench.compare import changes
from stlc.bench.groups import disagreements, groups_of, tables_of
from stlc.bench.record import from_json
from stlc.bench.run import run_job
from stlc.plan import read_plan
from stlc.sense import Sense
from stlc.solve.events import Event, ProgressEvent, SolutionEvent
from stlc.solve.outcome import SolveSettings

MISSION = """step 1 s
horizon 4
workspace box [0, 10] x [0, 10]
agent a : single_integrator { start (1, 1); control |u| <= 1 }
region goal = box [3, 6] x [3, 6]
require visit: eventually a in goal
maximize robustness
"""
BEST = 1.5  # the middle of the goal, 4.5 m along both axes, is within reach


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "m.stl").write_text(MISSION)
    return tmp_path


def _events(text: str) -> list[dict[str, Any]]:
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def test_solve(folder: Path) -> None:
    done = stlc("solve", "m.stl", "-o", "p.json", "--json", "--progress", "ndjson", folder=folder)
    assert done.returncode == 0, done.stderr
    said = json.loads(done.stdout)
    assert (said["sense"], said["objective"]) == ("maximize", pytest.approx(BEST))
    assert BEST - 1e-6 <= said["bound"] <= BEST * 1.001
    told = [e for e in _events(done.stderr) if e["event"] in ("progress", "solution")]
    assert all(e["objective"] is None or e["objective"] >= 0 for e in told)
    kept = json.loads((folder / "p.json").read_text())
    assert kept["solve"]["sense"] == "maximize"
    for place in (kept["solve"], kept["certificate"], kept["certificate"]["claim"]):
        assert place["objective"] == pytest.approx(BEST)
    assert kept["solve"]["bound"] == kept["certificate"]["bound"] == said["bound"]
    assert (
        f"optimal: objective {BEST}, bound {BEST}" in stlc("solve", "m.stl", folder=folder).stdout
    )


def test_events() -> None:
    told: list[Event] = []
    outcome = api.solve(api.loads(MISSION), SolveSettings(strategy="milp"), listen=told.append)
    values = [e.objective for e in told if isinstance(e, ProgressEvent | SolutionEvent)]
    known = [v for v in values if v is not None]
    assert known
    assert min(known) >= 0
    assert max(known) == pytest.approx(outcome.plan.solve.objective)
    bounds = [e.bound for e in told if isinstance(e, ProgressEvent) and e.bound is not None]
    assert all(bound >= BEST - 1e-6 for bound in bounds)


def test_race(folder: Path) -> None:
    words = ("race", "m.stl", "--with", "highs:auto", "--progress", "none")
    done = stlc(*words, "--json", "-o", "p.json", folder=folder)
    assert json.loads(done.stdout)["objective"] == pytest.approx(BEST)
    assert json.loads(done.stdout)["sense"] == "maximize"
    assert read_plan(folder / "p.json").solve.objective == pytest.approx(BEST)
    assert f"wins: objective {BEST}, proven" in stlc(*words, folder=folder).stdout


def test_verify_and_plot_read_plans_of_both_signs(folder: Path) -> None:
    stlc("solve", "m.stl", "-o", "p.json", folder=folder)
    told = stlc("verify", "m.stl", "p.json", folder=folder)
    assert told.returncode == 0
    assert "objective 1.5\n    +1 x robustness = 1 x 1.5 = 1.5" in told.stdout
    given = json.loads(stlc("verify", "m.stl", "p.json", "--json", folder=folder).stdout)
    assert (given["sense"], given["objective"]) == ("maximize", pytest.approx(BEST))
    assert given["terms"][0]["weight"] == 1

    old = json.loads((folder / "p.json").read_text())
    solve = old["solve"]
    del solve["sense"]  # plans of before: all figures were minimised
    solve["objective"], solve["bound"] = -solve["objective"], -solve["bound"]
    (folder / "old.json").write_text(json.dumps(old))
    told = stlc("verify", "m.stl", "old.json", folder=folder)
    assert told.returncode == 0, told.stdout
    assert "objective 1.5" in told.stdout


@pytest.mark.parametrize(
    ("figures", "message"),
    [
        ({"objective": 1.6, "bound": 1.6}, "objective is 1.5, worse than the 1.6 claimed"),
        ({"objective": 1.4, "bound": 1.4}, "objective 1.5 is above the proven bound 1.4"),
        ({"sense": "minimize"}, "objective 1.5 is above the proven bound -1.5"),
    ],
)
def test_wrong_claims_are_refused(folder: Path, figures: dict[str, Any], message: str) -> None:
    stlc("solve", "m.stl", "-o", "p.json", folder=folder)
    plan = json.loads((folder / "p.json").read_text())
    plan["solve"] |= figures
    (folder / "p.json").write_text(json.dumps(plan))
    told = stlc("verify", "m.stl", "p.json", folder=folder)
    assert told.returncode == 6
    assert message in told.stdout


def test_a_word_that_is_no_sense(folder: Path) -> None:
    stlc("solve", "m.stl", "-o", "p.json", folder=folder)
    text = (folder / "p.json").read_text()
    (folder / "p.json").write_text(text.replace('"maximize"', '"most"'))
    told = stlc("verify", "m.stl", "p.json", folder=folder)
    assert told.returncode == 2
    assert "at solve.sense: expected 'minimize' or 'maximize'" in told.stderr


def test_read_solution_and_compile(folder: Path) -> None:
    done = stlc("compile", "m.stl", "-o", "m.lp", "--json", folder=folder)
    assert json.loads(done.stdout)["lp_bound"] >= BEST - 1e-6
    compiled = api.compile(api.loads(MISSION))
    point = api.solve(api.loads(MISSION)).solution.x
    from stlc.milp.writers import safe_names

    names = safe_names(compiled.model)[0]
    assert point is not None
    lines = [f"{name} {value!r}" for name, value in zip(names, point.tolist(), strict=True)]
    (folder / "m.sol").write_text("# Objective value = -1.5\n" + "\n".join(lines) + "\n")
    done = stlc("read-solution", "m.stl", "m.sol", "-o", "p.json", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "objective 1.5" in done.stdout
    assert read_plan(folder / "p.json").solve.objective == pytest.approx(BEST)


def test_no_plan_is_worth_more(tmp_path: Path) -> None:
    from support.command import long_mission

    long_mission(tmp_path, 30)
    path = tmp_path / "long.stl"
    goal = "require far: eventually a1 in hall\nregion hall = box [1, 2] x [5, 6]\n"
    text = path.read_text().partition("minimize")[0]
    path.write_text(f"{text}{goal}maximize robustness(far) - 0.1 * link_cost(radio)\n")
    words = ("solve", "long.stl", "--progress", "none", "--time-limit", "0", "--json")
    done = stlc(*words, folder=tmp_path)
    assert done.returncode in (0, 4), done.stderr
    said = json.loads(done.stdout)
    if done.returncode == 4 and said["bound"] is not None:
        assert f"no plan can be worth more than {said['bound']:.6g}" in said["message"]


def test_both_senses_are_minimised(folder: Path) -> None:
    both = MISSION + "minimize 0.01 * effort\n"
    outcome = api.solve(api.loads(both))
    info = outcome.plan.solve
    assert info.sense is Sense.MINIMIZE
    assert info.objective is not None
    assert info.objective < 0
    alone = MISSION.replace("maximize robustness", "maximize robustness - 0.01 * effort")
    other = api.solve(api.loads(alone))
    assert other.plan.solve.objective == pytest.approx(-info.objective)
    assert "-1 x robustness" in outcome.report.text()
    assert "+0.01 x effort" in outcome.report.text()
    assert "-0.01 x effort" in other.report.text()
    for report in (outcome.report, other.report):
        terms = [line for line in report.text().splitlines() if " x " in line]
        shares = [float(line.rpartition(" = ")[2]) for line in terms]
        assert report.objective is not None
        assert sum(shares) == pytest.approx(report.objective[report is other.report], abs=1e-7)


def test_records_of_benchmarks() -> None:
    from support import tiny

    found = run_job(tiny.job(text=MISSION))
    assert found is not None
    assert (found.status, found.sense) == ("optimal", "maximize")
    assert found.objective == pytest.approx(BEST)
    assert found.bound == pytest.approx(BEST, rel=1e-3)
    assert found.lp_bound is not None
    assert found.lp_bound >= BEST - 1e-6
    assert all(p[1] is None or p[1] >= 0 for p in found.trace)
    old = json.loads(found.to_json())  # records of before were minimised and didn't say so
    del old["sense"]
    old |= {"objective": -BEST, "label": "literal"}
    before = from_json(json.dumps(old))
    assert disagreements(tables_of(groups_of([found, before]))[0]) == []
    wrong = from_json(json.dumps(old | {"objective": BEST}))
    assert len(disagreements(tables_of(groups_of([found, wrong]))[0])) == 1
    same = from_json(json.dumps(old | {"label": "auto"}))
    kinds = [c.kind for c in changes(groups_of([found]), groups_of([same]))]
    assert "disagreement" not in kinds
