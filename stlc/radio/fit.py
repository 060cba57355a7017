"""Maximum-likelihood fit of a channel to measured samples."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.radio.climb import BLOCK_ROWS, POLISH_ROWS, optimise, standard_errors, start_sites
from stlc.radio.errors import FitError
from stlc.radio.evidence import Evidence
from stlc.radio.gp import ChannelModel, condition_on, evidence_for
from stlc.radio.kernel import KernelName
from stlc.radio.likelihood import Problem, evaluate, make_blocks, variances
from stlc.radio.nearest import NearestForecast
from stlc.radio.pathloss import link_distance, log_distance
from stlc.radio.samples import Merged, Samples, distinct, merge
from stlc.radio.threads import single_thread
from stlc.radio.tobit import regress

Array = NDArray[np.float64]

EXACT_ROWS = 1200
"""Merged links up to which the likelihood is exact."""

COPY = 1e-6
"""Scatter [dB^2] of a link's samples below which they are copies; readings are rounded to 0.001 dB
or more coarsely."""


@dataclass(frozen=True, slots=True)
class FitOptions:
    """d0 [m]; one unknown offset for each receiver; kernel; how many of the
    starts are climbed; inducing links at most; seed of the subset for the restarts."""

    d0: float = 1.0
    receiver_offsets: bool = False
    kernel: KernelName = KernelName.SYMMETRISED
    restarts: int = 2
    centres: int = 800
    seed: int = 0

    def __post_init__(self) -> None:
        if self.restarts < 1 or self.centres < 1:
            raise FitError("restarts and centres must be at least 1")


@dataclass(frozen=True, slots=True, eq=False)
class FitReport:
    """A fitted channel and how sure it is.

    model            conditioned on all samples
    standard_errors  (name, value): l0 [dB], exponent, and of log fading, log shadowing,
                     log length and, where it is fitted, log deviation, from the observed
                     information (inf where the samples leave it open); by blocks it takes the
                     blocks as independent, so errors come out too small (said in `notes`)
    log_likelihood   of all samples; by blocks: of the blocks taken as independent
    path_loss        the same samples without shadowing
    samples, links, censored  counts: samples, different links, censored samples
    method           how likelihood and conditioning were computed
    evidence         what `model` was conditioned on, one row a link
    seconds          wall-clock time
    notes            remarks to show
    """

    model: ChannelModel
    path_loss: ChannelModel
    standard_errors: tuple[tuple[str, float], ...]
    log_likelihood: float
    log_likelihood_path_loss: float
    samples: int
    links: int
    censored: int
    method: str
    evidence: Evidence
    seconds: float
    notes: tuple[str, ...] = ()

    @property
    def forecast(self) -> ChannelModel | NearestForecast:
        """The best forecast of single links: `model` where its conditioning is exact, else
        conditioning on the nearest links."""
        posterior = self.model.posterior
        if posterior is None or posterior.exact or self.model.kernel is KernelName.PAPER_MIN:
            return self.model
        return NearestForecast(replace(self.model, posterior=None), self.evidence)


@single_thread()
def fit_channel(samples: Samples, options: FitOptions | None = None) -> FitReport:
    """Fit path loss, fading, shadowing and correlation length; condition on the samples.

    Where some link was measured twice, in either direction, fading is what its samples differ
    by, and a deviation of each link by itself is fitted beside the shadowing; repeats that are all
    equal are copies and count once. Censored samples enter by expectation propagation; up to
    EXACT_ROWS links the likelihood is exact, beyond it is one of independent blocks.
    Raises FitError when the samples cannot determine the channel.
    """
    options = options or FitOptions()
    started = time.perf_counter()
    _check(samples, options.d0)
    if not options.receiver_offsets:
        samples = samples.unnamed()
    merged = merge(samples)
    copied = _copies(merged)
    if copied:
        samples = distinct(samples)
        merged = merge(samples)
    features = mean_features(merged.samples, options)
    alone = regress(mean_features(samples, options), samples.rssi, samples.floor, samples.censored)
    size = EXACT_ROWS if len(merged.samples) <= EXACT_ROWS else BLOCK_ROWS
    problem = Problem(merged, features, make_blocks(merged.samples.links, size), options.kernel)
    theta = optimise(problem, alone, options.restarts, options.seed)
    last = evaluate(problem, theta, start_sites(problem, theta, alone))
    prior = _model(last.coefficients, theta, samples.names, options)
    evidence = evidence_for(prior, merged.samples, last.sites.target, last.sites.noise)
    model = condition_on(prior, evidence, options.centres)
    path_loss = replace(
        _model(alone.coefficients, np.log([alone.variance, 1.0, 1.0]), samples.names, options),
        shadowing=0.0,
    )
    return FitReport(
        model=model,
        path_loss=path_loss,
        standard_errors=standard_errors(problem, theta, last, alone),
        log_likelihood=last.value,
        log_likelihood_path_loss=alone.log_likelihood,
        samples=len(samples),
        links=len(evidence),
        censored=int(samples.censored.sum()),
        method=_method(problem, model),
        evidence=evidence,
        seconds=time.perf_counter() - started,
        notes=_notes(problem, model, samples, copied),
    )


def _check(samples: Samples, d0: float) -> None:
    if len(samples) < 8:
        raise FitError(f"{len(samples)} samples are too few to fit a channel: at least 8")
    if samples.censored.all():
        raise FitError("every sample is at or below the noise floor: nothing to fit")
    if np.ptp(samples.rssi) == 0.0:
        raise FitError("all samples have the same strength: there is nothing to fit")
    distance = link_distance(samples.links)
    if np.ptp(log_distance(distance, 1e-9)) < 1e-6:
        raise FitError("all links have the same length: the path-loss exponent is undetermined")
    if np.ptp(log_distance(distance, d0)) < 1e-6:
        raise FitError(
            f"no link is longer than d0 = {d0:g} m, the longest is {distance.max():.3g} m: the "
            "path-loss exponent is undetermined; give a smaller d0, or check the unit of positions"
        )


def mean_features(samples: Samples, options: FitOptions) -> Array:
    """Columns of the mean: 1, -10 log10 d, and offsets that sum to zero over the receivers."""
    distance = log_distance(link_distance(samples.links), options.d0)
    columns = [np.ones(len(samples)), distance]
    if options.receiver_offsets and len(samples.names) > 1:
        last = samples.receiver == len(samples.names) - 1
        for k in range(len(samples.names) - 1):
            columns.append((samples.receiver == k).astype(np.float64) - last)
    return np.column_stack(columns)


def _model(
    coefficients: Array, theta: Array, names: tuple[str, ...], options: FitOptions
) -> ChannelModel:
    fading, shadowing, length, deviation = variances(theta)
    offsets: tuple[tuple[str, float], ...] = ()
    if len(coefficients) > 2:
        free = [float(v) for v in coefficients[2:]]
        offsets = tuple(zip(names, [*free, -sum(free)], strict=True))
    return ChannelModel(
        l0=float(coefficients[0]),
        exponent=float(coefficients[1]),
        fading=fading,
        shadowing=shadowing,
        length=length,
        d0=options.d0,
        kernel=options.kernel,
        offsets=offsets,
        deviation=deviation,
    )


def _method(problem: Problem, model: ChannelModel) -> str:
    count, rows = len(problem.blocks), len(problem.features)
    likelihood = (
        f"exact likelihood of {rows} links"
        if count == 1
        else f"likelihood of {rows} links in {count} independent blocks"
    )
    if rows > POLISH_ROWS:
        likelihood += f" (variances and length from about {POLISH_ROWS} of them)"
    if model.posterior is None or model.posterior.exact:
        return f"{likelihood}, exact conditioning"
    return f"{likelihood}, conditioning through {len(model.posterior.centres)} inducing links"


def _copies(merged: Merged) -> bool:
    """Whether samples of one link never differ: copies, which say nothing about fading."""
    return bool((merged.count > 1).any()) and float(merged.scatter.max()) < COPY


def _notes(
    problem: Problem, model: ChannelModel, samples: Samples, copied: bool
) -> tuple[str, ...]:
    notes = []
    if copied:
        notes.append("all samples of one link are equal: taken for copies, counted once")
    if len(problem.blocks) > 1:
        notes.append("standard errors take neighbouring blocks as independent: rather too small")
    if model.exponent < 0:
        notes.append(f"the path-loss exponent is negative ({model.exponent:.2f}): check the data")
    if model.shadowing < 1e-3 * model.fading:
        notes.append("no shadowing found: the samples look like path loss and fading alone")
    if samples.censored.any():
        share = 100.0 * float(samples.censored.mean())
        notes.append(f"{share:.0f} % of the samples are at or below the noise floor (censored)")
    return tuple(notes)
