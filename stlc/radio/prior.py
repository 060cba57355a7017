"""Seeded samples drawn from a channel's prior: `python -m stlc.radio.prior --help`.

The defaults are the paper's channel (Section V-B: L0 = -12.89, n = 3, sigma_F^2 = 10,
sigma_k^2 = 10, l = 2 m) in the square [-5, 5]^2.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from stlc.files import write_atomic
from stlc.radio.gp import ChannelModel
from stlc.radio.samples import Samples, make_samples

PAPER_CHANNEL = ChannelModel(l0=-12.89, exponent=3.0, fading=10.0, shadowing=10.0, length=2.0)


def draw_samples(model: ChannelModel, low: float, high: float, count: int, seed: int) -> Samples:
    """`count` links with both ends uniform in [low, high]^2 [m] and one joint draw of their
    strengths; the same seed gives the same samples. Positions are rounded to millimetres
    before the draw, strengths to 0.001 dBm after it, as they stand in the file."""
    rng = np.random.default_rng(seed)
    links = np.round(rng.uniform(low, high, size=(count, 4)), 3)
    return make_samples(links, np.round(model.sample_prior(links, rng), 3))


def write_samples(samples: Samples, path: Path) -> None:
    """Write a CSV that `stlc.radio.read.read_samples` reads; replaced only when complete."""
    lines = ["tx_x_m,tx_y_m,rx_x_m,rx_y_m,rssi_dbm"]
    for link, level in zip(samples.links, samples.rssi, strict=True):
        lines.append(",".join(f"{v:.3f}" for v in (*link, level)))
    write_atomic(path, "\n".join(lines) + "\n")


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line of this module."""
    parser = argparse.ArgumentParser(prog="python -m stlc.radio.prior", description=__doc__)
    parser.add_argument("-o", "--output", type=Path, required=True, help="CSV to write")
    parser.add_argument("--count", type=int, default=80, help="number of links")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--low", type=float, default=-5.0, help="[m]")
    parser.add_argument("--high", type=float, default=5.0, help="[m]")
    chosen = parser.parse_args(arguments)
    samples = draw_samples(PAPER_CHANNEL, chosen.low, chosen.high, chosen.count, chosen.seed)
    write_samples(samples, chosen.output)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
