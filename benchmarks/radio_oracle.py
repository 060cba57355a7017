"""Channels fitted by us beside scikit-learn's Gaussian processes, on the same held-out links.

    python benchmarks/radio_oracle.py rssi_long.csv pairs_1200tx.csv.gz --links 600 --splits 5

Of each file `--links` links and half as many more are drawn, fitted and held back; of a file with
a `split` column its `calib` rows are drawn and its `test_robot` rows forecast as well. Synthetic
sets with known parameters follow: each link once, every sample twice, both directions. scikit-learn
gets least-squares residuals to the same path loss and offsets, in the same coordinates, each of
its kernels plus white noise; the one of greatest likelihood counts, chosen without the held-out.
Ours is the symmetric kernel or, where no place both sends and receives, the likeliest of it and
those that tell the ends apart, as `stlc fit` reports.
Printed are median and worst over the splits.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, Kernel, Matern, WhiteKernel

from stlc.radio.evaluate import hold_out, split_samples
from stlc.radio.fit import FitOptions, fit_channel, fit_directed, mean_features
from stlc.radio.gp import ChannelModel
from stlc.radio.pathloss import swap_ends
from stlc.radio.read import SampleOptions, read_samples
from stlc.radio.samples import Samples, link_numbers, make_samples
from stlc.radio.sheet import read_sheet

Scores = NDArray[np.float64]
Split = tuple[Samples, Samples]
Draw = Callable[[int], Split]

MANY_RECEIVERS = 10
TRUTH = ChannelModel(-40.0, 2.5, fading=2.0, shadowing=20.0, length=3.0, deviation=4.0)


def main() -> None:
    """Print a table of each set."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--links", type=int, default=600, help="links fitted")
    parser.add_argument("--splits", type=int, default=5)
    given = parser.parse_args()
    warnings.simplefilter("ignore")  # scikit-learn's about parameters at their limits
    for name, draw in (*_measured(given.paths, given.links), *_synthetic(given.links)):
        ways = {"ours": ours, "scikit-learn": theirs}
        pairs = [draw(seed) for seed in range(given.splits)]
        found = {w: np.array([score(*pair) for pair in pairs]) for w, score in ways.items()}
        _print(name, found)


def _measured(paths: list[Path], links: int) -> Iterator[tuple[str, Draw]]:
    for path in paths:
        if "split" not in read_sheet(path).rows[0][1]:
            whole = read_samples(path)
            yield f"{path.name}, links held back", lambda s, w=whole: _drawn(w, links, s)
            continue
        kinds = ("calib", "test_robot")
        calib, test = (read_samples(path, SampleOptions(where=("split", k))) for k in kinds)
        yield f"{path.name}, links held back", lambda s, w=calib: _drawn(w, links, s)
        once = _once(calib)
        yield f"{path.name}, each link once", lambda s, w=once: _drawn(w, links, s)
        another = f"{path.name}, another day"
        yield another, lambda s, w=calib, t=test: (_drawn(w, links, s)[0], t)


def _synthetic(links: int) -> Iterator[tuple[str, Draw]]:
    kinds: dict[str, Callable[[Samples, int], Samples]] = {
        "each link once": lambda s, seed: s,
        "every sample twice": lambda s, seed: make_samples(
            np.vstack([s.links, s.links]), np.tile(s.rssi, 2)
        ),
        "both directions": _both_directions,
    }
    for name, change in kinds.items():
        yield (
            f"synthetic, {name}",
            lambda seed, c=change: split_samples(
                c(_links(links * 3 // 2, seed), seed), 1 / 3, seed
            ),
        )


def _links(count: int, seed: int) -> Samples:
    """Links from places in a square to one of five fixed ends."""
    rng = np.random.default_rng(seed)
    ends = np.array([[0.0, 0.0], [20.0, 0.0], [10.0, 10.0], [0.0, 20.0], [20.0, 20.0]])
    places = np.hstack([rng.uniform(0, 20, (count, 2)), ends[rng.integers(5, size=count)]])
    return make_samples(places, TRUTH.sample_prior(places, rng))


def _both_directions(samples: Samples, seed: int) -> Samples:
    both = np.vstack([samples.links, swap_ends(samples.links)])
    return make_samples(both, TRUTH.sample_prior(both, np.random.default_rng(seed)))


def _once(samples: Samples) -> Samples:
    _, first = np.unique(link_numbers(samples.links), return_index=True)
    return samples.take(first)


def _drawn(samples: Samples, links: int, seed: int) -> Split:
    """`links` links to fit and half as many to hold back."""
    number = link_numbers(samples.links)
    wanted = min(links * 3 // 2, int(number.max()) + 1)
    picked = np.random.default_rng(seed).choice(number.max() + 1, wanted, replace=False)
    held = np.isin(number, picked[: wanted // 3])
    kept = np.isin(number, picked[wanted // 3 :])
    return samples.take(kept), samples.take(held)


def _options(samples: Samples) -> FitOptions:
    return FitOptions(receiver_offsets=len(samples.names) > MANY_RECEIVERS)


def ours(training: Samples, held: Samples) -> Scores:
    """RMSE [dB], share within the 90 % interval, mean log density of one packet."""
    options = _options(training)
    symmetric = fit_channel(training, options)
    fit = fit_directed(training, symmetric, options) or symmetric
    score = hold_out(fit.forecast, held)
    return np.array([score.rmse, dict(score.coverage)[0.9], score.log_score])


def theirs(training: Samples, held: Samples) -> Scores:
    """The same of scikit-learn's kernel of greatest likelihood."""
    heard = np.unique(training.receiver)
    features = _columns(training, heard)
    loss, *_ = np.linalg.lstsq(features, training.rssi, rcond=None)
    residual = training.rssi - features @ loss
    used = np.ptp(training.links, axis=0) > 0
    scale = float(training.links.std(axis=0).max()) / 3.0
    fits = [
        GaussianProcessRegressor(kernel).fit(training.links[:, used], residual)
        for kernel in _kernels(scale, float(residual.var()))
    ]
    best = max(fits, key=lambda fit: fit.log_marginal_likelihood_value_)
    mean, sigma = best.predict(held.links[:, used], return_std=True)
    t = (held.rssi - mean - _columns(held, heard) @ loss) / sigma
    density = -0.5 * t**2 - np.log(sigma) - 0.5 * np.log(2.0 * np.pi)
    rmse = np.sqrt(((t * sigma) ** 2).mean())
    return np.array([rmse, (np.abs(t) <= 1.6448536).mean(), density.mean()])


def _columns(samples: Samples, heard: NDArray[np.intp]) -> NDArray[np.float64]:
    """1, -10 log10 d and, of many receivers, offsets that sum to zero over those heard in
    training; others have none."""
    columns = mean_features(samples, _options(samples))
    if columns.shape[1] == 2:
        return columns
    offsets = columns[:, 2:][:, heard]
    return np.column_stack([columns[:, :2], offsets[:, :-1] - offsets[:, -1:]])


def _kernels(scale: float, variance: float) -> list[Kernel]:
    limits = (1e-2 * scale, 1e2 * scale)
    shapes = (RBF(scale, limits), Matern(scale, limits, nu=1.5), Matern(scale, limits, nu=0.5))
    white = WhiteKernel(variance / 2.0, (1e-3, 1e3))
    return [variance / 2.0 * shape + white for shape in shapes]


def _print(name: str, found: dict[str, Scores]) -> None:
    print(name)
    for who, scores in found.items():
        middle = np.median(scores, axis=0)
        worst = scores[:, 0].max(), np.abs(scores[:, 1] - 0.9).max(), scores[:, 2].min()
        print(
            f"  {who:13s}RMSE {middle[0]:.2f} (worst {worst[0]:.2f}) dB, 90 % covers "
            f"{100 * middle[1]:.1f} % (worst off {100 * worst[1]:.1f}), log density "
            f"{middle[2]:.3f} (worst {worst[2]:.3f})",
            flush=True,
        )


if __name__ == "__main__":
    main()
