"""Maximum-likelihood fit of a channel to measured samples."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import FitError
from stlc.radio.gp import ChannelModel, condition_on_sites
from stlc.radio.kernel import KernelName
from stlc.radio.likelihood import (
    Evaluation,
    Problem,
    Sites,
    evaluate,
    initial_sites,
    make_blocks,
)
from stlc.radio.nearest import Evidence, NearestForecast
from stlc.radio.pathloss import link_distance, log_distance
from stlc.radio.samples import Samples, merge
from stlc.radio.threads import single_thread
from stlc.radio.tobit import Regression, regress

Array = NDArray[np.float64]

EXACT_ROWS = 1200
"""Merged links up to which the likelihood is exact."""

BLOCK_ROWS = 300
SCREEN_ROWS = 600
"""Rows on which the restarts are run before the best end is polished."""

ENOUGH = 1e-3
"""A climb ends when a step gains less log likelihood than this."""

POLISH_ROWS = 4000
"""Rows whose blocks fix fading, shadowing and length; the mean and the likelihood use all."""


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
                     log length, from the observed information; by blocks it takes the blocks as
                     independent, so errors come out too small (said in `notes`)
    log_likelihood   of all samples; by blocks: of the blocks taken as independent
    path_loss        the same samples without shadowing
    samples, links, censored  counts: samples, rows after merging, censored samples
    method           how likelihood and conditioning were computed
    evidence         what `model` was conditioned on, merged, censored rows as Gaussian sites
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

    Repeated links are merged exactly; censored samples enter by expectation propagation; up to
    EXACT_ROWS links the likelihood is exact, beyond it is one of independent blocks.
    Raises FitError when the samples cannot determine the channel.
    """
    options = options or FitOptions()
    started = time.perf_counter()
    _check(samples)
    merged = merge(samples)
    features = mean_features(merged.samples, options)
    alone = regress(mean_features(samples, options), samples.rssi, samples.floor, samples.censored)
    size = EXACT_ROWS if len(merged.samples) <= EXACT_ROWS else BLOCK_ROWS
    problem = Problem(merged, features, make_blocks(merged.samples.links, size), options.kernel)
    theta = _optimise(problem, options, alone)
    last = evaluate(problem, theta, _start_sites(problem, theta, alone))
    prior = _model(last.coefficients, theta, samples.names, options)
    rows = merged.samples
    model = condition_on_sites(prior, rows, last.sites.target, last.sites.noise, options.centres)
    path_loss = replace(
        _model(alone.coefficients, np.log([alone.variance, 1.0, 1.0]), samples.names, options),
        shadowing=0.0,
    )
    return FitReport(
        model=model,
        path_loss=path_loss,
        standard_errors=_standard_errors(problem, theta, last),
        log_likelihood=last.value,
        log_likelihood_path_loss=alone.log_likelihood,
        samples=len(samples),
        links=len(rows),
        censored=int(samples.censored.sum()),
        method=_method(problem, model),
        evidence=_evidence(prior, rows, last.sites),
        seconds=time.perf_counter() - started,
        notes=_notes(problem, model, samples),
    )


def _check(samples: Samples) -> None:
    if len(samples) < 8:
        raise FitError(f"{len(samples)} samples are too few to fit a channel: at least 8")
    if samples.censored.all():
        raise FitError("every sample is at or below the noise floor: nothing to fit")
    if np.ptp(samples.rssi) == 0.0:
        raise FitError("all samples have the same strength: there is nothing to fit")
    if np.ptp(log_distance(link_distance(samples.links), 1e-9)) < 1e-6:
        raise FitError("all links have the same length: the path-loss exponent is undetermined")


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
    fading, shadowing, length = (float(v) for v in np.exp(theta))
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
    )


def _evidence(prior: ChannelModel, rows: Samples, sites: Sites) -> Evidence:
    shift = np.array([prior.offset(n) if prior.offsets else 0.0 for n in rows.names])
    residual = sites.target - prior.mean(rows.links) - shift[rows.receiver]
    return Evidence(rows.links, residual, sites.noise)


def _start_sites(problem: Problem, theta: Array, alone: Regression) -> Sites:
    return initial_sites(problem, float(np.exp(theta[0])), alone.variance)


def _optimise(problem: Problem, options: FitOptions, alone: Regression) -> Array:
    """Starts compared on a subset, the best climbed, the best end polished on more rows."""
    small = _screen(problem, options.seed, SCREEN_ROWS)
    part = _restrict(small)
    starts = _starts(problem, alone)
    starts.sort(key=lambda s: -evaluate(part, s, _start_sites(part, s, alone)).value)
    ends = [_climb(small, start, alone, problem) for start in starts[: options.restarts]]
    ends.sort(key=lambda end: -end[1])
    if small is problem:
        return ends[0][0]
    return _climb(_screen(problem, options.seed, POLISH_ROWS), ends[0][0], alone, problem)[0]


def _screen(problem: Problem, seed: int, most: int) -> Problem:
    """Whole blocks that hold about `most` rows, drawn at random; all rows where they fit."""
    if len(problem.features) <= most:
        return problem
    blocks = make_blocks(problem.merged.samples.links, BLOCK_ROWS)
    order = np.random.default_rng(seed).permutation(len(blocks))
    picked = [blocks[i] for i in order[: max(2, most // BLOCK_ROWS)]]
    return replace(problem, blocks=tuple(picked))


def _scale(problem: Problem) -> float:
    """Extent [m] of the positions: the largest standard deviation of a coordinate."""
    return max(float(problem.merged.samples.links.std(axis=0).max()), 1e-3)


def _starts(problem: Problem, alone: Regression) -> list[Array]:
    base = [(f, s) for s in (0.5, 0.8) for f in (0.1, 0.3, 1.0, 0.03)]
    return [
        np.log([alone.variance * (1.0 - s), alone.variance * s, _scale(problem) * f])
        for f, s in base
    ]


def _climb(
    problem: Problem, start: Array, alone: Regression, whole: Problem
) -> tuple[Array, float]:
    """L-BFGS-B from `start`; returns the end and its log likelihood."""
    from scipy.optimize import minimize

    active = _restrict(problem)
    sites = [_start_sites(active, start, alone)]

    def objective(theta: Array) -> tuple[float, Array]:
        got = evaluate(active, theta, sites[0])
        sites[0] = got.sites
        return -got.value, -got.gradient

    size, variance = np.log(_scale(whole)), np.log(alone.variance)
    limits = [(variance - 9.0, variance + 3.0)] * 2 + [(size - 6.0, size + 3.0)]
    options = {"maxiter": 60, "ftol": ENOUGH / max(abs(alone.log_likelihood), 1.0), "gtol": 1e-3}
    found = minimize(objective, start, jac=True, method="L-BFGS-B", bounds=limits, options=options)
    return np.asarray(found.x, dtype=np.float64), -float(found.fun)


def _restrict(problem: Problem) -> Problem:
    """The problem with only the rows that its blocks hold, renumbered."""
    rows = np.concatenate(problem.blocks)
    if len(rows) == len(problem.features):
        return problem
    merged = problem.merged
    share = len(rows) / len(problem.features)
    part = replace(
        merged,
        samples=merged.samples.take(rows),
        count=merged.count[rows],
        scatter=merged.scatter * share,
        surplus=round(merged.surplus * share),
    )
    ends = np.cumsum([len(b) for b in problem.blocks])[:-1]
    blocks = tuple(np.split(np.arange(len(rows), dtype=np.intp), ends))
    return Problem(part, problem.features[rows], blocks, problem.kernel)


def _standard_errors(
    problem: Problem, theta: Array, last: Evaluation
) -> tuple[tuple[str, float], ...]:
    """Square roots of the inverse observed information (differences of the gradient)."""
    step = 1e-3
    information = np.zeros((3, 3))
    for k in range(3):
        move = np.zeros(3)
        move[k] = step
        up = evaluate(problem, theta + move, last.sites).gradient
        down = evaluate(problem, theta - move, last.sites).gradient
        information[k] = (down - up) / (2.0 * step)
    information = (information + information.T) / 2.0
    value, vector = np.linalg.eigh(information)
    spread = (vector**2) @ (1.0 / np.maximum(value, 1e-30))
    linear = np.sqrt(np.diag(last.covariance)[:2])
    names = ("l0", "exponent", "log_fading", "log_shadowing", "log_length")
    return tuple(zip(names, map(float, [*linear, *np.sqrt(spread)]), strict=True))


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


def _notes(problem: Problem, model: ChannelModel, samples: Samples) -> tuple[str, ...]:
    notes = []
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
