"""`make demo`: the paper's case and a real flat, each planned with and without communication.

Leaves plan.json, plan.csv, plan.png, model.mps and model.lp for both in the output folder, and
exits with 1 unless every plan was verified.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stlc.api import load, solve
from stlc.milp.writers import write_model
from stlc.mission import Mission
from stlc.plot import plot_plan
from stlc.radio.figures import plot_summary
from stlc.radio.read import read_samples
from stlc.radio.report import fit_csv, format_summary
from stlc.report import write_report
from stlc.solve.outcome import Outcome, SolveSettings
from stlc.verify import verify

FloatArray = NDArray[np.float64]
HERE = Path(__file__).resolve().parent


def main() -> int:
    """Run both cases."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out"))
    out: Path = parser.parse_args().out
    began = time.perf_counter()
    good = [paper(out / "paper_two_agents"), flat(out / "ble_apartment")]
    print(
        f"\n{'all verified' if all(good) else 'NOT VERIFIED'}, {time.perf_counter() - began:.0f} s"
    )
    return 0 if all(good) else 1


def paper(out: Path) -> bool:
    """The paper's comparison: link cost of the plan that ignores communication and of ours."""
    file = HERE / "paper_two_agents.stl"
    print(f"{file.name}: two agents, eight steps, the paper's channel")
    aware = _solve(file, out, "plan", {})
    silent = _solve(file, out, "motion_only", {"alpha": "1"})
    mission = load(file)
    with_radio, without = _link_cost(mission, aware), _link_cost(mission, silent)
    print(
        f"  link cost (-RSSI/10 summed over 8 steps): {without:.3f} ignoring communication, "
        f"{with_radio:.3f} planned with it: {without / with_radio - 1:.1%} more\n"
        "  (the paper, whose starts and goals are not printed: 23.840 against 14.216, 67.7% more)"
    )
    return aware.report.ok and silent.report.ok


def flat(out: Path) -> bool:
    """The flat: the plan found without the radio requirement violates it."""
    file = HERE / "ble_apartment.stl"
    print(f"\n{file.name}: a robot in a real flat, channel fitted to measured samples")
    forecast(HERE / "data" / "ble_apartment", out)
    aware = _solve(file, out, "plan", {})
    silent = _solve(file, out, "motion_only", {"floor": "-200 dBm"})
    judged = verify(load(file), silent.plan)
    print("  the plan that ignores the radio, judged with it:")
    for violation in judged.violations:
        print(f"    violated: {violation}")
    near_path(aware.plan.runs["robot"].states[:, :2], HERE / "data" / "ble_apartment")
    return aware.report.ok and silent.report.ok and not judged.ok


def forecast(data: Path, out: Path) -> None:
    """Fit the calibration samples and forecast the held-back run of another day."""
    out.mkdir(parents=True, exist_ok=True)
    summary = fit_csv(data / "calib.csv", test=read_samples(data / "test_robot.csv"))
    plot_summary(summary, out / "fit.png")
    print("  " + format_summary(summary).replace("\n", "\n  "))


def near_path(path: FloatArray, data: Path) -> None:
    """Forecast of the strength at the plan's positions beside what was measured near them."""
    with (data / "test_robot.csv").open(newline="") as stream:
        rows = [r for r in csv.DictReader(stream) if r["anchor"] == "3"]
    spots = np.array([[float(r["robot_x_m"]), float(r["robot_y_m"])] for r in rows])
    values = np.array([float(r["rssi_dbm"]) for r in rows])
    mission = load(HERE / "ble_apartment.stl")
    station, model = mission.stations["a3"], mission.channels["ble"].model
    assert model is not None
    links = np.array([[x, y, 0.0, *station.position, station.height] for x, y in path])
    mean, variance = model.predict(links, fading=True)
    print("  forecast at the plan's steps against packets of the later run within 0.5 m:")
    misses, inside = [], []
    for step, (spot, mu, var) in enumerate(zip(path, mean, variance, strict=True)):
        near = values[np.hypot(*(spots - spot).T) <= 0.5]
        if not len(near):
            continue
        spread = 1.645 * var**0.5
        misses.append(near.mean() - mu)
        inside.append(np.abs(near - mu) <= spread)
        print(
            f"    step {step:2d}  forecast {mu:6.1f} +- {spread:4.1f} dBm (90 %)  "
            f"measured {near.mean():6.1f} dBm, mean of {len(near)}"
        )
    if not misses:
        return
    error = np.array(misses)
    print(
        f"    over {len(error)} of {len(path)} steps: measured mean off the forecast by "
        f"{error.mean():+.1f} dB, RMSE {np.sqrt((error**2).mean()):.1f} dB; "
        f"{100 * np.concatenate(inside).mean():.0f} % of the packets within the 90 % interval"
    )


def _solve(file: Path, out: Path, name: str, params: Mapping[str, str]) -> Outcome:
    out.mkdir(parents=True, exist_ok=True)
    mission = load(file, params=params)
    outcome = solve(mission, SolveSettings(save_to=out / f"{name}.json"))
    outcome.plan.write_csv(out / f"{name}.csv")
    plot_plan(mission, outcome.plan, out / f"{name}.png")
    if name == "plan":
        write_report(mission, outcome.plan, out / "plan.html")
        for suffix in ("mps", "lp"):
            write_model(outcome.compiled.model, out / f"model.{suffix}")
    info = outcome.plan.solve
    took = ", ".join(f"{k} {v:.1f} s" for k, v in outcome.seconds.items())
    print(
        f"  {name}: {info.status}, objective {info.objective:.4f}, "
        f"{'verified' if outcome.report.ok else 'NOT VERIFIED'} ({took})"
    )
    return outcome


def _link_cost(mission: Mission, outcome: Outcome) -> float:
    """Sum over t = 1..T of the channel's cost at the plan's cells, as -RSSI / 10."""
    report = verify(mission, outcome.plan)
    term = next(t for t in report.terms if "link_cost" in t.name)
    return term.low / 10


if __name__ == "__main__":
    sys.exit(main())
