"""How well a channel forecasts samples it has not seen."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import FitError
from stlc.radio.evidence import Evidence
from stlc.radio.gp import ChannelModel
from stlc.radio.posterior import exact_posterior
from stlc.radio.problem import make_blocks
from stlc.radio.samples import Samples, merge
from stlc.radio.tobit import mills

Array = NDArray[np.float64]

LEVELS = (0.5, 0.9, 0.95)


class Forecast(Protocol):
    """What a channel and a nearest-link forecast have in common."""

    @property
    def offsets(self) -> tuple[tuple[str, float], ...]:
        """Calibration offsets [dB] of the named receivers."""

    def offset(self, receiver: str | None) -> float:
        """Calibration offset [dB] of one receiver."""

    def offset_variance(self, receiver: str | None) -> float:
        """Variance of it [dB^2]."""

    def predict(
        self, links: Array, fading: bool, receiver: str | None = None
    ) -> tuple[Array, Array]:
        """Mean [dBm] and variance [dB^2] of links."""


@dataclass(frozen=True, slots=True, eq=False)
class HoldOut:
    """Forecast of one packet (fading included) against held-back samples.

    rmse       [dB], of max(forecast, floor) against max(rssi, floor)
    bias       [dB], mean of observed minus forecast
    coverage   (level, share) of the central intervals, by the randomised probability
               transform, which is uniform for censored samples too when the model is right
    log_score  mean log density (log probability for censored samples)
    pit        (K,) probability transforms
    """

    rmse: float
    bias: float
    coverage: tuple[tuple[float, float], ...]
    log_score: float
    pit: Array
    samples: int


def hold_out(model: Forecast, samples: Samples, seed: int = 0) -> HoldOut:
    """Score `model` on samples; `seed` draws the transforms of censored ones.

    Raises FitError without samples.
    """
    if not len(samples):
        raise FitError("no samples to score")
    mean, variance = predict_samples(model, samples)
    sigma = np.sqrt(np.maximum(variance, 1e-12))
    hidden = samples.censored
    observed = np.where(hidden, samples.floor, samples.rssi)
    error = np.maximum(observed, samples.floor) - np.maximum(mean, samples.floor)
    t = (observed - mean) / sigma
    log_cdf, _ = mills(t)
    draw = np.where(hidden, np.random.default_rng(seed).uniform(size=len(t)), 1.0)
    pit = np.exp(log_cdf) * draw
    density = -0.5 * t**2 - np.log(sigma) - 0.5 * np.log(2.0 * np.pi)
    shares = tuple((p, float((np.abs(pit - 0.5) <= p / 2.0).mean())) for p in LEVELS)
    score = float(np.where(hidden, log_cdf, density).mean())
    rmse = float(np.sqrt((error**2).mean()))
    return HoldOut(rmse, float(error.mean()), shares, score, pit, len(samples))


def predict_samples(model: Forecast, samples: Samples) -> tuple[Array, Array]:
    """One packet's mean [dBm] and variance [dB^2] at each sample, offsets included."""
    mean, variance = model.predict(samples.links, True)
    if model.offsets:
        mean += np.array([model.offset(n) for n in samples.names])[samples.receiver]
        off = np.array([model.offset_variance(n) for n in samples.names])
        variance += off[samples.receiver]
    return mean, variance


def split_samples(
    samples: Samples, share: float, seed: int, blocks: bool = False
) -> tuple[Samples, Samples]:
    """Training and held-back samples; repeated links never fall on both sides.

    blocks: hold back whole neighbourhoods instead of single links, a harder test.
    """
    merged = merge(samples)
    rng = np.random.default_rng(seed)
    group = merged.row_of
    if blocks:
        label = np.empty(len(merged.samples), dtype=np.intp)
        size = max(2, len(label) // 100)
        for number, rows in enumerate(make_blocks(merged.samples.links, size)):
            label[rows] = number
        group = label[group]
    names = np.unique(group)
    held = rng.choice(names, max(1, round(share * len(names))), replace=False)
    test = np.isin(group, held)
    return samples.take(~test), samples.take(test)


@dataclass(frozen=True, slots=True)
class ApproximationError:
    """A forecast against exact conditioning on the same evidence: root mean square difference
    of mean [dB] and of sigma without fading [dB], and how many links were compared."""

    mean: float
    sigma: float
    links: int


def approximation_error(
    forecast: Forecast, prior: ChannelModel, evidence: Evidence, most: int = 2000, seed: int = 0
) -> ApproximationError:
    """Compare `forecast` with exact conditioning of `prior` on the `most` links around a middle.

    Three middles are drawn; both are asked at the 50 links nearest to each, so that what lies
    outside the neighbourhood matters little. Censored rows enter both as the same sites.
    """
    picks = np.random.default_rng(seed).choice(len(evidence), min(3, len(evidence)), replace=False)
    gaps = [_gap(forecast, prior, evidence, evidence.links[k], most) for k in picks]
    mean, sigma = (np.concatenate(part) for part in zip(*gaps, strict=True))
    rms = [float(np.sqrt((part**2).mean())) for part in (mean, sigma)]
    return ApproximationError(rms[0], rms[1], len(mean))


def _gap(
    forecast: Forecast, prior: ChannelModel, evidence: Evidence, middle: Array, most: int
) -> tuple[Array, Array]:
    """Differences of mean and sigma from exact conditioning around one link."""
    order = np.argsort(((evidence.links - middle) ** 2).sum(1), kind="stable")
    near = evidence.take(order[:most])
    asked = near.links[:50]
    shape = (prior.shadowing, prior.length, prior.kernel)
    exact = exact_posterior(near.links, near.residual, near.noise, *shape)
    a = forecast.predict(asked, False)
    b = replace(prior, posterior=exact).predict(asked, False)
    return a[0] - b[0], np.sqrt(a[1]) - np.sqrt(b[1])
