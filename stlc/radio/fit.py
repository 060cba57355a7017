"""Maximum-likelihood fit of a channel to measured samples."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.radio.climb import BLOCK_ROWS, optimise, standard_errors, start_sites
from stlc.radio.errors import FitError
from stlc.radio.evidence import Evidence
from stlc.radio.fit_words import method_of, notes_of
from stlc.radio.gp import ChannelModel, condition_on, evidence_for
from stlc.radio.kernel import DIRECTED, KernelName
from stlc.radio.likelihood import Evaluation, evaluate
from stlc.radio.nearest import NearestForecast
from stlc.radio.pathloss import link_distance, log_distance
from stlc.radio.problem import FIXED, Problem, make_problem
from stlc.radio.samples import Merged, Samples, distinct, merge
from stlc.radio.threads import single_thread
from stlc.radio.tobit import Regression, regress
from stlc.radio.wall_losses import Open, losses_of, wall_errors, wall_notes
from stlc.radio.walls import Walls

Array = NDArray[np.float64]

EXACT_ROWS = 1200
"""Merged links up to which the likelihood is exact."""

COPY = 1e-6
"""Scatter [dB^2] of a link's samples below which they are copies; readings are rounded to 0.001 dB
or more coarsely."""


@dataclass(frozen=True, slots=True)
class FitOptions:
    """d0 [m]; one unknown offset for each receiver; kernel; how many of the
    starts are climbed; inducing links at most; seed of the subset for the restarts; walls whose
    losses are estimated."""

    d0: float = 1.0
    receiver_offsets: bool = False
    kernel: KernelName = KernelName.SYMMETRISED
    restarts: int = 2
    centres: int = 800
    seed: int = 0
    walls: Walls | None = None

    def __post_init__(self) -> None:
        if self.restarts < 1 or self.centres < 1:
            raise FitError("restarts and centres must be at least 1")


@dataclass(frozen=True, slots=True, eq=False)
class FitReport:
    """A fitted channel and how sure it is.

    model            conditioned on all samples
    standard_errors  (name, value): l0 [dB], exponent, and of log fading, log shadowing,
                     log length and, where they are fitted, log deviation and log offset
                     (variance of the receivers' offsets), from the observed information
                     (inf where the samples leave it open); by blocks it takes the blocks as
                     independent, so errors come out too small (said in `notes`)
    log_likelihood   of all samples, offsets integrated out; by blocks: of the blocks taken as
                     independent
    restricted       likewise, L0 and n integrated out too: what kernels are compared by
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
    restricted: float
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


def fit_directed(samples: Samples, symmetric: FitReport, options: FitOptions) -> FitReport | None:
    """The likeliest fit by a kernel that tells senders from receivers, where no place is both and
    it is likelier than `symmetric`, the fit of the same samples; else None.

    All kernels have as many parameters, so their likelihoods are compared as they are.
    """
    if not samples.directed or options.kernel is not KernelName.SYMMETRISED:
        return None
    fits = [fit_channel(samples, replace(options, kernel=kernel)) for kernel in DIRECTED]
    best = max(fits, key=lambda fit: fit.restricted)
    return best if best.restricted > symmetric.restricted else None


@single_thread()
def fit_channel(samples: Samples, options: FitOptions | None = None) -> FitReport:
    """Fit path loss, fading, shadowing and correlation length; condition on the samples.

    Variances and length are those of greatest restricted likelihood; receivers' offsets are random
    effects (`stlc.radio.likelihood`), 0 for receivers without a sample.
    Where some link was measured twice, in either direction, fading is what its samples differ
    by, and a deviation of each link by itself is fitted beside the shadowing; repeats that are all
    equal are copies and count once. Censored samples enter by expectation propagation; up to
    EXACT_ROWS links the likelihood is exact, beyond it is one of independent blocks.
    Walls' losses are fixed effects, as L0 and n are; one that the samples give no loss counts as
    none. Raises FitError when the samples cannot determine the channel.
    """
    options = options or FitOptions()
    if options.walls is not None:
        return fit_with_walls(samples, options, options.walls)
    return _fit(samples, options, None)


def fit_with_walls(samples: Samples, options: FitOptions, walls: Walls) -> FitReport:
    """The channel with the losses of walls; those that come out negative are left out, the most
    negative first, and so are walls that no link crosses."""
    open_ = np.flatnonzero(walls.crossed(samples.links).any(axis=0))
    while True:
        fit = _fit(samples, options, (walls, open_))
        assert fit.model.walls is not None
        loss = fit.model.walls.loss
        if not len(open_) or loss[open_].min() >= 0.0:
            return fit
        open_ = open_[open_ != open_[np.argmin(loss[open_])]]


def _fit(samples: Samples, options: FitOptions, walls: Open | None) -> FitReport:
    """A fit of everything, among it the losses of the walls that are open."""
    started = time.perf_counter()
    _check(samples, options.d0)
    if not options.receiver_offsets:
        samples = samples.unnamed()
    merged = merge(samples)
    copied = _copies(merged)
    if copied:
        samples = distinct(samples)
        merged = merge(samples)
    features = mean_features(merged.samples, options, walls)
    plain = mean_features(samples, options, walls)
    alone = regress(plain, samples.rssi, samples.floor, samples.censored)
    size = EXACT_ROWS if len(merged.samples) <= EXACT_ROWS else BLOCK_ROWS
    fixed = FIXED + (0 if walls is None else len(walls[1]))
    problem = make_problem(merged, features, size, options.kernel, fixed)
    theta = optimise(problem, alone, options.restarts, options.seed)
    last = evaluate(problem, theta, start_sites(problem, theta, alone))
    prior = _model(problem, theta, last, samples.names, options, walls)
    evidence = evidence_for(prior, merged.samples, last.sites.target, last.sites.noise)
    model = condition_on(prior, evidence, options.centres)
    return FitReport(
        model=model, path_loss=_path_loss(alone, samples, options, walls),
        standard_errors=(
            *standard_errors(problem, theta, last, alone), *wall_errors(walls, last.covariance),
        ),
        log_likelihood=last.likelihood, log_likelihood_path_loss=alone.log_likelihood,
        restricted=last.value, samples=len(samples), links=len(evidence),
        censored=int(samples.censored.sum()), method=method_of(problem, model), evidence=evidence,
        seconds=time.perf_counter() - started,
        notes=(*notes_of(problem, model, samples, copied), *wall_notes(samples, walls)),
    )  # fmt: skip


def _check(samples: Samples, d0: float) -> None:
    """Refuses samples from which the path-loss line can't be told: FitError with the reason.

    `d0` in metres: distances below it count as d0.
    """
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


def mean_features(samples: Samples, options: FitOptions, walls: Open | None = None) -> Array:
    """Columns of the mean: 1, -10 log10 d, how often a link crosses each open wall, and one for the
    offset of each receiver, which is 0 throughout for a receiver without a sample."""
    distance = log_distance(link_distance(samples.links), options.d0)
    columns = [np.ones(len(samples)), distance]
    if walls is not None:
        columns += list(-walls[0].crossed(samples.links)[:, walls[1]].T)
    if options.receiver_offsets and len(samples.names) > 1:
        numbers = range(len(samples.names))
        columns += [(samples.receiver == k).astype(np.float64) for k in numbers]
    return np.column_stack(columns)


def _model(
    problem: Problem,
    theta: Array,
    last: Evaluation,
    names: tuple[str, ...],
    options: FitOptions,
    walls: Open | None,
) -> ChannelModel:
    """The channel at the optimum; the mean's coefficients are those profiled out in `last`.

    L0 [dBm], exponent, then one offset [dB] a device, with its posterior variance [dB^2].
    """
    at, given = problem.parameters(theta), last.given
    offsets = last.coefficients[problem.fixed :]
    return ChannelModel(
        l0=float(last.coefficients[0]),
        exponent=float(last.coefficients[1]),
        fading=at.fading,
        shadowing=at.shadowing,
        length=at.length,
        d0=options.d0,
        kernel=options.kernel,
        offsets=_named(names, offsets),
        offset_variances=_named(names, given),
        offset_spread=at.offset,
        deviation=at.deviation,
        walls=losses_of(walls, last.coefficients),
    )


def _path_loss(
    alone: Regression, samples: Samples, options: FitOptions, walls: Open | None
) -> ChannelModel:
    """The channel without shadowing; offsets sum to zero over the receivers that were heard."""
    fixed = FIXED + (0 if walls is None else len(walls[1]))
    base, offsets = float(alone.coefficients[0]), alone.coefficients[fixed:]
    if len(offsets):
        heard = np.unique(samples.receiver)
        middle = float(offsets[heard].mean())
        base, centred = base + middle, np.zeros(len(offsets))
        centred[heard] = offsets[heard] - middle
        offsets = centred
    return ChannelModel(
        l0=base,
        exponent=float(alone.coefficients[1]),
        fading=alone.variance,
        shadowing=0.0,
        length=1.0,
        d0=options.d0,
        kernel=options.kernel,
        offsets=_named(samples.names, offsets),
        walls=losses_of(walls, alone.coefficients),
    )


def _named(names: tuple[str, ...], values: Array) -> tuple[tuple[str, float], ...]:
    return tuple(zip(names, map(float, values), strict=True)) if len(values) else ()


def _copies(merged: Merged) -> bool:
    """Whether samples of one link never differ: copies, which say nothing about fading."""
    return bool((merged.count > 1).any()) and float(merged.scatter.max()) < COPY
