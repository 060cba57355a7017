"""Plans: exact round trips, clear errors for files that aren't plans, CSV, shifting."""

import csv
import io
import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.missions import agent, mission, roll

from stlc.certificate import Certificate, Checked, Claim
from stlc.errors import UsageError
from stlc.plan import (
    LinkSeries,
    RequirementValue,
    SolveInfo,
    make_plan,
    mission_digest,
    read_plan,
    shifted,
)
from stlc.plan_json import to_json
from stlc.plan_reader import parse
from stlc.violation import Violations

CERTIFICATE = Certificate(
    Checked(
        "optimal", 1 / 7, None, 1e-4, 1e-6, Claim("optimal", 1 / 7, "highs", "HiGHS 1.16.0"),
        Violations(1e-9, 0.0, 0.25, 1e-10, 0.0, worst_row="clear[3]"), None, True, ("a warning",),
    ),
    True, ("a note",),
)  # fmt: skip


def build(horizon=3, scale=0.1):
    a, b = agent("r1", (0.1, 0.2)), agent("r2", (1 / 3, -7e-17))
    there = mission([a, b], horizon=horizon)
    u = scale * np.arange(2.0 * horizon).reshape(horizon, 2)
    runs = {one.name: roll(one, u) for one in (a, b)}
    plan = make_plan(
        there, {k: v[0] for k, v in runs.items()}, {k: v[1] for k, v in runs.items()},
        SolveInfo("optimal", 1 / 7, 0.14, 1e-4, "highs", "HiGHS 1.15.1", "compact", {"solve": 0.1}),
    )  # fmt: skip
    return there, replace(
        plan,
        requirements=(RequirementValue("a", math.inf), RequirementValue("b", None, 0.5)),
        links=(LinkSeries("radio", "r1", "r2", {"rssi": np.array([-1.5, np.nan, -2, -3])}),),
        certificate=CERTIFICATE,
    )


def same(one, two):
    assert (one.mission, one.sha256, one.step, one.horizon) == (
        two.mission, two.sha256, two.step, two.horizon
    )  # fmt: skip
    assert one.solve == two.solve
    assert one.requirements == two.requirements
    assert one.certificate == two.certificate
    for name, run in one.runs.items():
        other = two.runs[name]
        np.testing.assert_array_equal(run.states, other.states)
        np.testing.assert_array_equal(run.inputs, other.inputs)
        assert (run.state_names, run.input_units) == (other.state_names, other.input_units)
    for link, other in zip(one.links, two.links, strict=True):
        assert (link.channel, link.sender, link.receiver) == ("radio", "r1", "r2")
        np.testing.assert_array_equal(link.values["rssi"], other.values["rssi"])


def test_round_trip_through_a_file(tmp_path):
    there, plan = build()
    plan.write(tmp_path / "plan.json")
    same(plan, read_plan(tmp_path / "plan.json"))
    assert plan.sha256 == mission_digest(there)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=6, max_size=6))
def test_every_number_survives(numbers):
    _, plan = build()
    run = replace(plan.runs["r1"], inputs=np.array(numbers).reshape(3, 2))
    again = parse(to_json(replace(plan, runs={"r1": run})))
    np.testing.assert_array_equal(again.runs["r1"].inputs, run.inputs)


def broken(**changes):
    data = json.loads(to_json(build()[1]))
    for path, value in changes.items():
        *keys, last = path.split("__")
        place = data
        for key in keys:
            place = place[int(key) if key.isdigit() else key]
        place[last] = value
    return json.dumps(data)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "not a plan: expecting value"),
        ("{", "plan:1:2: not a plan"),
        ("[" * 100_000, "not a plan"),
        ("9" * 5_000, "not a plan"),
        (b"\xff\xfe\x00", "not UTF-8|not a plan"),
        ("[]", '"format": "stlc plan"'),
        ('{"format": "stlc plan"}', "a field 'version'"),
        (broken(version=2), "at version: expected version 1"),
        (broken(step=0), "at step: expected a number of seconds above 0"),
        (broken(horizon=2), "at agents.r1.states: expected 3 rows, not 4"),
        (broken(horizon=2.5), "at horizon: expected a whole number"),
        (broken(horizon=True), "at horizon: expected a number"),
        (broken(agents__r1__states=[[1, 2]] * 4), r"agents.r1.states\[0\]: expected 4 numbers"),
        (broken(agents__r1__states=[["x"] * 4] * 4), r"states\[0\]\[0\]: expected a number"),
        (broken(agents__r1__inputs=7), "agents.r1.inputs: expected a list"),
        (broken(agents__r1__state_units=["m"]), "state_units: expected 4 units"),
        (broken(requirements=[{"name": 1}]), r"requirements\[0\]"),
        (broken(links__0__pair=["r1"]), r"links\[0\].pair: expected two names"),
        (broken(certificate=3), "at certificate: expected an object"),
        ('{"format": NaN}', "NaN is no number"),
        ('{"format": "x", "step": 1, "step": 2}', '"step" is given twice'),
        (broken(step=10**400), "not a valid plan at step: expected a finite number"),
    ],
)
def test_what_is_no_plan_is_said_clearly(text, words):
    with pytest.raises(UsageError, match=words):
        parse(text)


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(UsageError, match="no such file"):
        read_plan(tmp_path / "none.json")
    with pytest.raises(UsageError, match="is a folder"):
        read_plan(tmp_path)


def test_csv_has_a_row_for_each_step_and_agent(tmp_path):
    _, plan = build()
    plan.write_csv(tmp_path / "plan.csv")
    rows = list(csv.DictReader(io.StringIO((tmp_path / "plan.csv").read_text())))
    assert list(rows[0]) == ["t", "time", "agent", "px", "py", "vx", "vy", "ux", "uy"]
    assert len(rows) == 8
    assert float(rows[3]["px"]) == plan.runs["r2"].states[1, 0]
    assert (rows[-1]["t"], rows[-1]["ux"]) == ("3", "")


def test_csv_of_unlike_agents_keeps_columns_apart():
    _, plan = build()
    odd = replace(plan.runs["r2"], state_names=("x", "y", "z", "w"), input_names=("px", "q"))
    rows = list(csv.DictReader(io.StringIO(replace(plan, runs=plan.runs | {"r2": odd}).to_csv())))
    assert "px_input" in rows[0]
    assert rows[1]["px"] == "" != rows[0]["px"]


@pytest.mark.parametrize("steps", [0, 1, 3, 5])
def test_shift_follows_the_dynamics_and_the_bounds(steps):
    there, plan = build()
    later = shifted(plan, steps, there.agents)
    for name, run in later.runs.items():
        one = there.agents[name]
        np.testing.assert_array_equal(run.states[0], plan.runs[name].states[min(steps, 3)])
        step = run.states[:-1] @ one.dynamics.A.T + run.inputs @ one.dynamics.B.T
        np.testing.assert_allclose(run.states[1:], step, atol=1e-12)
        assert run.states.shape == plan.runs[name].states.shape
        assert (np.abs(run.inputs) <= 1.0).all()
    assert later.requirements == ()
    assert later.solve == SolveInfo()
