"""Fit channels to large measured sets and score the forecasts.

    python benchmarks/radio_fit.py rssi_long.csv pairs_1200tx.csv.gz

A file with a `split` column is fitted on its `calib` rows and scored on `test_robot`; of any
other file a fifth of the links is held back, and whole neighbourhoods in a second run. Where
there are more than ten receivers each gets an unknown offset, and the weakest twentieth of its
samples counts as censored at its noise floor. RMSE and coverage are of one packet.
"""

from __future__ import annotations

import argparse
import gzip
import time
from pathlib import Path

import numpy as np

from stlc.radio.evaluate import HoldOut, hold_out, split_samples
from stlc.radio.fit import FitOptions, FitReport, fit_channel
from stlc.radio.read import SampleOptions, read_samples
from stlc.radio.report import approximations
from stlc.radio.samples import Samples

MANY_RECEIVERS = 10
FLOOR_SHARE = 0.05


def main() -> None:
    """Print the figures of each file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="+", type=Path)
    for path in parser.parse_args().paths:
        for name, training, held in _sets(path):
            _report(f"{path.name}, {name}", training, held)


def _sets(path: Path) -> list[tuple[str, Samples, Samples]]:
    if "split" in _header(path):
        rows = (SampleOptions(where=("split", kind)) for kind in ("calib", "test_robot"))
        training, held = (read_samples(path, options) for options in rows)
        return [("calib rows, scored on test_robot", training, held)]
    samples = read_samples(path)
    if len(samples.names) > MANY_RECEIVERS:
        index = range(len(samples.names))
        levels = [np.quantile(samples.rssi[samples.receiver == k], FLOOR_SHARE) for k in index]
        samples = samples.with_floor(np.array(levels))
    kinds = ("a fifth of the links held back", False), ("neighbourhoods held back", True)
    return [(name, *split_samples(samples, 0.2, 0, blocks)) for name, blocks in kinds]


def _header(path: Path) -> list[str]:
    with (gzip.open if path.suffix == ".gz" else open)(path, "rt", encoding="utf-8") as file:
        return str(file.readline()).strip().split(",")


def _report(title: str, training: Samples, held: Samples) -> None:
    offsets = len(training.names) > MANY_RECEIVERS
    started = time.process_time()
    fit = fit_channel(training, FitOptions(receiver_offsets=offsets))
    seconds = time.process_time() - started
    print(f"{title}\n  {fit.samples} samples, {fit.links} links, {fit.censored} censored")
    print(f"  {fit.method}; fit {fit.seconds:.1f} s wall clock, {seconds:.1f} s CPU")
    print(f"  {_parameters(fit)}")
    scores = {"nearest or exact": hold_out(fit.forecast, held), "model": hold_out(fit.model, held)}
    scores["path loss alone"] = hold_out(fit.path_loss, held)
    for name, score in scores.items():
        print(f"  {name:17s}{_score(score)}")
    for name, gap in approximations(fit):
        print(f"  {name}: {gap.mean:.3f} dB mean, {gap.sigma:.3f} dB sigma from exact (rms)")


def _parameters(fit: FitReport) -> str:
    model = fit.model
    return (
        f"L0 {model.l0:.2f} dBm, n {model.exponent:.2f}, fading {model.fading:.2f} dB^2, "
        f"deviation {model.deviation:.2f} dB^2, shadowing {model.shadowing:.2f} dB^2, "
        f"length {model.length:.2f} m"
    )


def _score(score: HoldOut) -> str:
    shares = "  ".join(f"{100 * level:.0f} %: {100 * share:.1f}" for level, share in score.coverage)
    return f"RMSE {score.rmse:.2f} dB, bias {score.bias:+.2f}, coverage {shares} ({score.samples})"


if __name__ == "__main__":
    main()
