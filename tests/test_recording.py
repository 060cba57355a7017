"""Recordings: waypoints of plans, columns of other things, clocks that jitter and drift."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command import MISSION
from support.command import inside as stlc

from stlc.errors import UsageError
from stlc.recording import JITTER, read_recording

SECOND = "agent b : single_integrator { start (8, 8); control |u| <= 1 }\nregion near"
ON_INPUTS = """require slow: always norminf(b.u) <= 1
require soft: always |a.ux| <= 1
minimize"""
TWO = MISSION.replace("region near", SECOND).replace("minimize", ON_INPUTS)


def _csv(folder: Path, text: str) -> Path:
    path = folder / "t.csv"
    path.write_text(text)
    return path


def test_the_waypoints_of_a_plan_are_a_recording(tmp_path: Path) -> None:
    (tmp_path / "m.stl").write_text(TWO)
    words = ("solve", "m.stl", "--csv", "p.csv", "--progress", "none")
    assert stlc(*words, folder=tmp_path).returncode == 0
    done = stlc("monitor", "m.stl", "p.csv", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert all(line.startswith("ok") for line in done.stdout.splitlines())
    assert len(done.stdout.splitlines()) == 4
    moved = (tmp_path / "p.csv").read_text().replace("\n4,4.0,a,", "\n4,4.0,a,-")
    (tmp_path / "q.csv").write_text(moved)
    done = stlc("monitor", "m.stl", "q.csv", folder=tmp_path)
    assert done.returncode == 6
    assert "NO  visit" in done.stdout


def test_text_in_columns_that_nobody_asks_for(tmp_path: Path) -> None:
    path = _csv(tmp_path, "time,v,mode\n0,1,auto\n1,2,\n2,3,manual\n")
    recording = read_recording(path, 1.0)
    assert recording.columns["v"].tolist() == [1, 2, 3]
    with pytest.raises(UsageError, match=r"t\.csv:2: mode is no number: 'auto'"):
        recording.columns["mode"]


def test_jitter_is_no_drift(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    stamps = 3.0 + 0.1 * np.arange(200) + rng.uniform(-0.99, 0.99, 200) * JITTER / 2 * 0.1
    path = _csv(tmp_path, "time,v\n" + "".join(f"{t:.6f},1\n" for t in stamps))
    times = read_recording(path, 0.1).times
    np.testing.assert_allclose(np.diff(times), 0.1)
    assert times[0] == pytest.approx(stamps[0], abs=1e-6)


def test_drift_adds_up_from_the_first_stamp(tmp_path: Path) -> None:
    """Each gap is within 1 %, the eleventh sample is off by more than a tenth of a step."""
    path = _csv(tmp_path, "time,v\n" + "".join(f"{1.01 * t:.4f},1\n" for t in range(40)))
    with pytest.raises(
        UsageError, match=r"t\.csv:13: the clock has drifted: \+0\.11 s off step 11"
    ):
        read_recording(path, 1.0)


def test_cells_beyond_all_measure(tmp_path: Path) -> None:
    path = _csv(tmp_path, "time,v\n0," + "9" * 200_000 + "\n")
    with pytest.raises(UsageError, match=r"t\.csv:2: no line of a CSV file"):
        read_recording(path, 1.0)
