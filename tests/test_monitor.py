"""Monitoring recorded signals."""

import csv
import io
import json

import numpy as np
import pytest
from support.missions import agent, inside, mission

from stlc.errors import UsageError
from stlc.ir.nodes import (
    Always,
    Eventually,
    Implies,
    Linear,
    Link,
    Quantity,
    Relation,
    Role,
    Signal,
)
from stlc.ir.requirement import Requirement
from stlc.monitor import monitor
from stlc.recording import read_recording
from stlc.source import Source


def above(name, level, **extra):
    return Linear(((Signal(name, Role.FREE, 0), 1.0),), -level, "m/s", **extra)


def spec(*formulas, step=0.5, agents=()):
    needs = [Requirement(f"r{k}", f, 0.25 * k) for k, f in enumerate(formulas)]
    return mission(list(agents), needs, horizon=10, step=step)


def record(tmp_path, text):
    path = tmp_path / "run.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


GOOD = "time,speed,gap\n0,1,5\n0.5,2,4\n1.0,3,1\n1.5,0,2\n"


def test_robustness_over_time_by_sub_formula(tmp_path):
    fast, near = above("speed", 2.0), above("gap", 2.0)
    report = monitor(
        spec(Always(Implies(fast, near), 0, 1), Eventually(near, 0, None)), record(tmp_path, GOOD)
    )
    first, second = report.formulas
    assert first.robustness.tolist() == [2.0, -1.0, -1.0]
    assert first.satisfied.tolist() == [True, False, False]
    assert [p.depth for p in first.parts] == [1, 2, 2]
    assert first.parts[1].robustness.tolist() == [-1.0, 0.0, 1.0, -2.0]
    assert second.robustness.tolist() == [3.0, 2.0, 0.0, 0.0]
    assert second.satisfied.tolist() == [True, True, False, False]
    assert report.ok
    assert "first fails at 0.5 s" in report.text()


def test_outputs(tmp_path):
    source = Source("spec.stl", "require a: eventually[0, 1]\n  (speed >= 2)")
    formula = Eventually(above("speed", 2.0, span=source.span(31, 41)), 0, 1)
    report = monitor(spec(formula), record(tmp_path, GOOD))
    data = json.loads(report.to_json())
    assert data["formulas"][0]["robustness"] == [0.0, 1.0, 1.0]
    assert data["formulas"][0]["parts"][0]["line"] == 2
    assert data["formulas"][0]["parts"][0]["text"] == "speed >= 2"
    assert "parts" not in json.loads(report.to_json(parts=False))["formulas"][0]
    rows = list(csv.DictReader(io.StringIO(report.to_csv())))
    assert [row["r0"] for row in rows] == ["0.0", "1.0", "1.0", ""]
    assert rows[0]["r0 satisfied"] == "1"


def test_agents_signals_are_columns_with_a_dot(tmp_path):
    from support.missions import box

    one = agent("r1", (0, 0))
    text = "# odometry\nt;r1.px;r1.py\n3;1;1\n4;2;2\n5;9;9\n"
    formula = inside("r1", box(0, 5, 0, 5))
    report = monitor(spec(formula, step=0.1, agents=[one]), record(tmp_path, text))
    assert report.formulas[0].robustness.tolist() == [1.0, 2.0, -4.0]
    np.testing.assert_allclose(report.times, [0.3, 0.4, 0.5])


def test_a_short_recording_cannot_be_judged(tmp_path):
    report = monitor(spec(Always(above("speed", 0.0), 0, 9)), record(tmp_path, GOOD))
    assert not report.ok
    assert "too short" in report.text()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "needs a header"),
        ("time,speed\n", "at least one sample"),
        ("speed\n1\n", "with a column `time` in seconds, or `t` in steps; its header is 'speed'"),
        ('{\n  "mission": 1,\n}\n', "a recording is a CSV file with a column `time`"),
        ("time,sped\n0,1\n", r"no column 'speed' \(is it 'sped'\?\)"),
        ("time,speed\n0,1\n0.6,2\n", r"run.csv:3: 0.6 s after the sample before.*step is 0.5 s"),
        ("time,speed\n0,1\n0,2\n", "run.csv:3: 0 s after"),
        ("time,speed\n0,1\n0.5\n", "run.csv:3: expected 2 fields, found 1"),
        ("time,speed\n0,fast\n", "run.csv:2: speed is no number: 'fast'"),
        ("time,speed\n0,nan\n", "speed is not finite"),
        ("time,speed,speed\n0,1,1\n", "same name"),
        (b"\xff\xfe\x00\x01", "not UTF-8"),
        ("time,speed\n0,\0\n", "no number"),
    ],
)
def test_bad_recordings(tmp_path, text, words):
    with pytest.raises(UsageError, match=words):
        monitor(spec(above("speed", 0.0)), record(tmp_path, text))


def test_missing_file_and_links(tmp_path):
    with pytest.raises(UsageError, match="no such file"):
        read_recording(tmp_path / "none.csv", 1.0)
    with pytest.raises(UsageError, match="is a folder"):
        read_recording(tmp_path, 1.0)
    link = Link("radio", Quantity.RSSI, "a", "b", Relation.AT_LEAST, -70.0)
    with pytest.raises(UsageError, match="can't be monitored"):
        monitor(spec(link), record(tmp_path, GOOD))
