"""Sweeps against solves of their own."""

from __future__ import annotations

import csv
import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.cluster import cluster
from support.command import inside as stlc
from support.sweeps import MISSION

from stlc import api
from stlc.errors import UsageError
from stlc.mission import Cap
from stlc.sense import Sense
from stlc.sweep import Answer, Axis, Question, frontier, points
from stlc.sweep.ask import answer, digest
from stlc.sweep.costs import priced, split
from stlc.sweep.executors import run_here
from stlc.sweep.store import Store
from stlc.sweep.work import Task, recalled

RADIO = "link_cost(radio)"


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "m.stl").write_text(MISSION)
    return tmp_path / "m.stl"


def _question(file: Path, **params: str) -> Question:
    point = tuple(params.items())
    return Question(str(file), point, digest(file, point, ()))


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("v=0.1..0.5:0.1", ("0.1", "0.2", "0.3", "0.4", "0.5")),
        ("v=1..2:0.4 m/s", ("1 m/s", "1.4 m/s", "1.8 m/s")),
        ("v=-1..1:1", ("-1", "0", "1")),
        ("v=1, 2 m/s", ("1 m/s", "2 m/s")),
        ("v=1 km/h, 2, 3 m/s", ("1 km/h", "2 m/s", "3 m/s")),
        ("v=1e2, 2e2", ("1e2", "2e2")),
        ("v=10..30:10", ("10", "20", "30")),
    ],
)
def test_values_of_a_parameter(text: str, values: tuple[str, ...]) -> None:
    assert Axis.parse(text) == Axis("v", values)


@pytest.mark.parametrize(
    "text",
    ["v", "v=", "v=,", "v=3..1:1", "v=1..2:0", "v=0..-1", "v=1,1", "v=1..1e9:1e-3"],
)
def test_what_gives_no_values_is_refused(text: str) -> None:
    with pytest.raises(UsageError):
        Axis.parse(text)


def test_points_are_all_combinations() -> None:
    axes = [Axis("a", ("1", "2")), Axis("b", ("x", "y"))]
    assert [tuple(v for _, v in p) for p in points(axes)] == list(itertools.product("12", "xy"))
    with pytest.raises(UsageError):
        points([axes[0], axes[0]])


def test_costs_are_split_outside_brackets() -> None:
    assert split("effort, link_cost(radio, (a, b))") == ("effort", "link_cost(radio, (a, b))")
    for text in ("effort", "effort,", "a,b,c"):
        with pytest.raises(UsageError):
            split(text)


@pytest.mark.parametrize(("v", "near"), list(itertools.product(("1", "2"), ("0", "1", "3"))))
def test_a_point_is_a_solve_of_its_own(file: Path, v: str, near: str) -> None:
    found = answer(_question(file, v=v, near=near))
    need = 2 + float(near)
    if need > 3 * float(v):
        assert found.status == "infeasible"
        return
    assert found.status == "optimal"
    assert found.objective == pytest.approx(need, abs=1e-6)


def test_trades_match_separate_solves(file: Path) -> None:
    given = {"v": "1", "near": "0"}
    curve = frontier(_question(file, **given), ("effort", RADIO), 12, lambda q, s: answer(q, s))
    assert curve.why is None
    assert len(curve.trades) >= 3
    mission = api.load(file, params=given)
    effort, radio = (priced(mission, c, file.parent, ())[1] for c in ("effort", RADIO))
    for trade, after in itertools.pairwise([*curve.trades, None]):
        level = trade.level  # up to here no plan has less effort, just below it too
        assert level >= trade.second - 1e-6
        for held in (trade.second, (trade.second + level) / 2, level):
            capped = replace(mission, objective=effort, caps=(Cap("radio", radio, held + 1e-6),))
            alone = api.solve(capped).plan.solve.objective
            assert alone == pytest.approx(trade.first, rel=2e-4)
        back = replace(mission, objective=radio, caps=(Cap("effort", effort, trade.first + 1e-6),))
        assert api.solve(back).plan.solve.objective == pytest.approx(trade.second, rel=2e-4)
        if after is not None:
            assert after.first < trade.first
            assert after.second > trade.second
    assert curve.trades[-1].first == pytest.approx(2, abs=1e-5)
    least = api.solve(replace(mission, objective=radio)).plan.solve.objective
    assert curve.trades[0].second == pytest.approx(least, rel=2e-4)


def test_a_slope_is_followed_evenly(tmp_path: Path) -> None:
    """Effort of one agent against that of another with which it must meet halfway, or not."""
    file = tmp_path / "m.stl"
    file.write_text("""step 1 s
horizon 2
workspace box [0, 8] x [0, 2]
agent a : single_integrator { start (1, 1); control |u| <= 2 }
agent b : single_integrator { start (7, 1); control |u| <= 2 }
require meet: eventually[2, 2] b.x - a.x <= 2 m
minimize effort
""")
    costs = ("effort(a)", "effort(b)")
    curve = frontier(_question(file), costs, 7, lambda q, s: answer(q, s))
    pairs = np.array([(t.first, t.second) for t in curve.trades])
    assert len(pairs) == 7
    np.testing.assert_allclose(pairs.sum(axis=1), 4, atol=1e-4)
    np.testing.assert_allclose(pairs[[0, -1]], [[4, 0], [0, 4]], atol=1e-4)
    assert np.diff(pairs[:, 1]).max() <= 1.0 + 1e-6


def test_caps_are_verified(file: Path) -> None:
    mission = api.load(file)
    _, effort = priced(mission, "effort", file.parent, ())
    plan = api.solve(mission).plan
    capped = replace(mission, caps=(Cap("effort", effort, 2.0),))
    kinds = [v.kind for v in api.verify(capped, plan).violations]
    assert kinds == ["cap"]
    both = replace(capped, objective=(), sense=Sense.MINIMIZE)
    from stlc.errors import InfeasibleError

    with pytest.raises(InfeasibleError):
        api.solve(both)


def test_the_store_knows_what_was_asked(file: Path, tmp_path: Path) -> None:
    store = Store(tmp_path / "s.sqlite")
    store.create()
    asked = _question(file, v="2")
    assert store.get(asked) is None
    found = answer(asked)
    store.add(asked, found)
    assert store.get(asked) == found
    for other in (
        replace(asked, params=(("v", "3"),)), replace(asked, minimise="effort"),
        replace(asked, cap=("effort", 3.0)), replace(asked, gap=0.1), replace(asked, files="x"),
    ):  # fmt: skip
        assert store.get(other) is None
    (tmp_path / "t.sqlite").write_text("no store")
    with pytest.raises(UsageError):
        Store(tmp_path / "t.sqlite").get(asked)


def test_the_digest_is_of_everything_that_is_read(tmp_path: Path) -> None:
    (tmp_path / "lib.stl").write_text("let home(a) = eventually[0, 3] a.x >= 3 m\n")
    file = tmp_path / "m.stl"
    file.write_text('import "lib.stl"\n' + MISSION.replace("eventually[0, 3] a.x >= 3 m + near",
                                                            "home(a) and a.x >= near"))  # fmt: skip
    before = digest(file, (), ())
    assert digest(file, (), ()) == before
    (tmp_path / "lib.stl").write_text("let home(a) = eventually[0, 2] a.x >= 3 m\n")
    assert digest(file, (), ()) != before


def test_the_command(file: Path, tmp_path: Path) -> None:
    words = ("sweep", "m.stl", "-D", "v=1..2:1", "-D", "near=1,3")
    files = ("--csv", "t.csv", "-o", "t.svg")
    done = stlc(*words, *files, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "t.csv").open()))
    assert [(r["v"], r["near"], r["status"]) for r in rows] == [
        ("1", "1", "optimal"), ("1", "3", "infeasible"), ("2", "1", "optimal"),
        ("2", "3", "optimal"),
    ]  # fmt: skip
    assert "<svg" in (tmp_path / "t.svg").read_text()
    again = stlc(*words, "--json", folder=tmp_path)
    assert "4 of 4 points are in" in again.stderr
    assert [r["objective"] for r in json.loads(again.stdout)["rows"]] == [
        pytest.approx(3),
        None,
        pytest.approx(3),
        pytest.approx(5),
    ]


def test_the_command_trades_in_processes(file: Path, tmp_path: Path) -> None:
    words = ("sweep", "m.stl", "-D", "v=1,2", "--pareto", f"effort,{RADIO}", "--points", "4")
    apart = stlc(*words, "--workers", "2", "-o", "p.png", folder=tmp_path)
    assert apart.returncode == 0, apart.stderr
    assert (tmp_path / "p.png").stat().st_size > 1000
    again = stlc(*words, "--json", folder=tmp_path)
    assert "2 of 2 points are in" in again.stderr
    here = stlc(*words, "--no-store", "--json", folder=tmp_path)
    for one, other in zip(*(json.loads(d.stdout)["rows"] for d in (again, here)), strict=True):
        assert [one["effort"], one[RADIO]] == pytest.approx([other["effort"], other[RADIO]], 1e-3)


@pytest.mark.slow
def test_the_command_on_a_cluster(file: Path, tmp_path: Path) -> None:
    with cluster(tmp_path, 1) as (address, _):
        done = stlc("sweep", "m.stl", "-D", "near=0,1", "--cluster", address, "--json",
                    folder=tmp_path)  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = [row["objective"] for row in json.loads(done.stdout)["rows"]]
    assert found == [pytest.approx(2), pytest.approx(3)]


@pytest.mark.parametrize(
    ("words", "status"),
    [
        (("-D", "nope=1,2"), 1), (("-D", "v=2..1:1"), 2), (("--pareto", "effort"), 2),
        (("--pareto", "effort,wind(radio)"), 1), (("-o", "x.gif"), 2),
        (("--pareto", "effort,robustness(go)"), 1), (("--backend", "none"), 2),
    ],
)  # fmt: skip
def test_mistakes_are_told_before_a_solve(
    file: Path, tmp_path: Path, words: tuple[str, ...], status: int
) -> None:
    done = stlc("sweep", "m.stl", *words, folder=tmp_path)
    assert done.returncode == status, done.stderr
    assert not (tmp_path / "out").exists()


def test_a_sweep_that_was_stopped_goes_on_where_it_was(file: Path, tmp_path: Path) -> None:
    store = Store(tmp_path / "s.sqlite")
    store.create()
    tasks = [Task(_question(file, near=near)) for near in ("0", "1", "2")]
    seen: list[Question] = []

    def keep(question: Question, found: Answer) -> None:
        seen.append(question)
        store.add(question, found)

    first = list(run_here(tasks, lambda: bool(seen), keep))
    assert [number for number, _ in first] == [0]
    left = [task for task in tasks if recalled(task, store.get)[1] is None]
    assert left == tasks[1:]
    rest = list(run_here(left, lambda: False, keep))
    assert seen == [task.question for task in tasks]
    assert [done.found.objective for _, done in rest] == [pytest.approx(3), pytest.approx(4)]
    assert all(recalled(task, store.get)[1] is not None for task in tasks)


def test_a_curve_that_was_stopped_keeps_its_points(file: Path, tmp_path: Path) -> None:
    store = Store(tmp_path / "s.sqlite")
    store.create()
    task = Task(_question(file, v="1", near="0"), ("effort", RADIO), 5)
    seen: list[Question] = []

    def keep(question: Question, found: Answer) -> None:
        seen.append(question)
        store.add(question, found)

    assert list(run_here([task], lambda: len(seen) >= 3, keep)) == []
    before = len(seen)
    again, known = recalled(task, store.get)
    assert known is None
    assert len(again.known) == before
    ((_, done),) = run_here([again], lambda: False, keep)
    assert len({question.key for question in seen}) == len(seen)
    assert recalled(task, store.get)[1] == done.found
