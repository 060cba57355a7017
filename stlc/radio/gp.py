"""The channel: log-distance path loss, shadowing Gaussian process, independent fading.

RSSI(y) ~ GP(m(y) + C_yT (C_T + sigma_F^2 I)^-1 (z_T - m(Y_T)),
             C_y - C_yT (C_T + sigma_F^2 I)^-1 C_Ty + sigma_F^2)     (paper, eq. (3))

One addition: each link has a deviation of its own, of variance sigma_L^2, that all its samples
share. It keeps repeats and the two directions of one link from passing for independent
evidence: on n samples of a link sigma_F^2 becomes sigma_L^2 + sigma_F^2 / n. A link that is asked
for counts as a new one, so its variance has sigma_L^2 in it, and for one packet sigma_F^2 too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stlc.radio.errors import KernelError, RadioError
from stlc.radio.evidence import Evidence, by_link
from stlc.radio.kernel import KernelName, check_covariance, correlation
from stlc.radio.pathloss import link_distance, path_loss_mean
from stlc.radio.posterior import (
    JITTER,
    Posterior,
    cholesky,
    choose_centres,
    exact_posterior,
    inducing_posterior,
    with_more,
)
from stlc.radio.samples import Samples, link_numbers, merge
from stlc.radio.walls import Walls

Array = NDArray[np.float64]

EXACT_LIMIT = 2500
"""Links up to which a channel is conditioned exactly."""

CHUNK = 4096

UNHEARD = "?"
"""Stands for a receiver that no sample is of, where offsets were fitted: its own is as uncertain as
those of all receivers differ."""


@dataclass(frozen=True, slots=True, eq=False)
class ChannelModel:
    """A radio channel between two positions.

    l0          received strength [dBm] at 1 m by the path-loss law
    exponent    path-loss exponent n [-]
    fading      sigma_F^2 [dB^2], independent from packet to packet
    deviation   sigma_L^2 [dB^2], independent from link to link, shared by a link's packets
    shadowing   sigma_k^2 [dB^2], variance of the spatial process
    length      correlation length of the shadowing [m]
    d0          distance [m] below which the path loss stays constant
    kernel      see `stlc.radio.kernel`
    offsets     calibration offset [dB] of each named receiver, added to its mean
    offset_variances  how far each offset may be off [dB^2], added to variances asked for by name
    offset_spread  variance [dB^2] of offsets over all receivers, those never heard too
    posterior   what measurements add; None for the prior
    walls       what takes its share of the strength along the line of sight
    """

    l0: float
    exponent: float
    fading: float
    shadowing: float
    length: float
    d0: float = 1.0
    kernel: KernelName = KernelName.SYMMETRISED
    offsets: tuple[tuple[str, float], ...] = ()
    posterior: Posterior | None = None
    deviation: float = 0.0
    offset_variances: tuple[tuple[str, float], ...] = ()
    walls: Walls | None = None
    offset_spread: float = 0.0

    def __post_init__(self) -> None:
        for name in ("l0", "exponent"):
            if not np.isfinite(getattr(self, name)):
                raise RadioError(f"channel: {name} must be finite")
        for name in ("fading", "shadowing", "deviation"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise RadioError(f"channel: {name} is a variance [dB^2], finite and >= 0")
        for name in ("length", "d0"):
            if not (np.isfinite(getattr(self, name)) and getattr(self, name) > 0):
                raise RadioError(f"channel: {name} is a distance [m], finite and > 0")

    def own_variance(self, fading: bool) -> float:
        """What no sample of another link explains [dB^2]: the link's deviation, and fading for
        one packet."""
        return self.deviation + (self.fading if fading else 0.0)

    def mean(self, links: Array, receiver: str | None = None) -> Array:
        """Path-loss mean m(y) (K,) [dBm] of links (K, 2 D) [m], walls on the way taken off."""
        base = path_loss_mean(link_distance(links), self.l0, self.exponent, self.d0)
        if self.walls is not None:
            base = base - self.walls.attenuation(links)
        return base + self.offset(receiver)

    def offset(self, receiver: str | None) -> float:
        """Calibration offset [dB]; 0 for no name and for UNHEARD. Raises RadioError for an unknown
        name."""
        if not receiver or receiver == UNHEARD:
            return 0.0
        known = dict(self.offsets)
        if receiver not in known:
            raise RadioError(f"no receiver {receiver!r}; known: {', '.join(known) or 'none'}")
        return known[receiver]

    def offset_variance(self, receiver: str | None) -> float:
        """Variance of `offset` [dB^2]; 0 where offsets are given rather than fitted."""
        if receiver == UNHEARD:
            return self.offset_spread
        return dict(self.offset_variances).get(receiver or "", 0.0)

    def predict(
        self, links: Array, fading: bool, receiver: str | None = None
    ) -> tuple[Array, Array]:
        """Posterior mean (K,) [dBm] and variance (K,) [dB^2] of links (K, 2 D) [m].

        fading=True: one packet; False: the mean of many packets over the same link.
        Raises KernelError when the kernel yields a negative variance (`paper_min` may).
        """
        links = np.asarray(links, dtype=np.float64)
        mean = self.mean(links, receiver)
        variance = np.full(len(links), float(self.shadowing))
        if self.posterior is not None:
            for start in range(0, len(links), CHUNK):
                rows = slice(start, start + CHUNK)
                gain, drop = self._update(links[rows], self.posterior)
                mean[rows] += gain
                variance[rows] -= drop
        extra = self.own_variance(fading) + self.offset_variance(receiver)
        return mean, self.checked_variance(variance) + extra

    def checked_variance(self, variance: Array) -> Array:
        """`variance` with rounding removed; KernelError when it is truly negative."""
        least = float(variance.min(initial=0.0))
        if least < -1e-6 * max(self.shadowing, 1.0):
            raise KernelError(
                f"kernel {self.kernel.value} gives a negative variance ({least:.3g} dB^2): "
                "it is no covariance here; use kernel = symmetrised"
            )
        return np.asarray(np.maximum(variance, 0.0), dtype=np.float64)

    def _update(self, links: Array, posterior: Posterior) -> tuple[Array, Array]:
        cross = self.shadowing * correlation(links, posterior.centres, self.length, self.kernel)
        reduced = cross @ posterior.factor.T
        return cross @ posterior.weights, np.einsum("ij,ij->i", reduced, reduced)

    def covariance(self, links: Array) -> Array:
        """Prior shadowing covariance (K, K) [dB^2]."""
        return self.shadowing * correlation(links, links, self.length, self.kernel)

    def sample_prior(self, links: Array, rng: np.random.Generator) -> Array:
        """One joint draw (K,) [dBm] of shadowing, deviations and fading from the prior (seeded
        by `rng`); equal links share all but their fading."""
        matrix = self.covariance(links)
        matrix[np.diag_indices_from(matrix)] += JITTER * max(self.shadowing, 1e-12)
        lower = cholesky(matrix, "the prior covariance")
        level = self.mean(links) + lower @ rng.standard_normal(len(links))
        level += np.sqrt(self.fading) * rng.standard_normal(len(links))
        if self.deviation:
            number = link_numbers(links)
            level += np.sqrt(self.deviation) * rng.standard_normal(len(links))[number]
        return np.asarray(level, dtype=np.float64)


def condition(model: ChannelModel, samples: Samples, most_centres: int = 1000) -> ChannelModel:
    """The channel given uncensored samples (paper, eq. (3)); repeated links merged exactly.

    Up to EXACT_LIMIT links the conditioning is exact, beyond it uses inducing links.
    Raises RadioError for censored samples (fit them: `stlc.radio.fit`) and KernelError for a
    kernel that is no covariance.
    """
    if samples.censored.any():
        raise RadioError("censored samples cannot be conditioned on directly; fit the channel")
    merged = merge(samples)
    rows = merged.samples
    noise = model.fading / merged.count
    return condition_on(model, evidence_for(model, rows, rows.rssi, noise), most_centres)


def extended(model: ChannelModel, samples: Samples) -> ChannelModel:
    """The channel given further uncensored samples beside those it has been conditioned on.

    Exact where the posterior is: as if all had been there at once, but for links measured both
    before and now, whose own deviations count as two. Raises as `condition`.
    """
    if model.posterior is None:
        return condition(model, samples)
    if samples.censored.any():
        raise RadioError("censored samples cannot be conditioned on directly; fit the channel")
    merged = merge(samples)
    rows = merged.samples
    evidence = evidence_for(model, rows, rows.rssi, model.fading / merged.count)
    noise = evidence.noise + _floor_noise(model)
    shape = (model.shadowing, model.length, model.kernel)
    longer = with_more(model.posterior, evidence.links, evidence.residual, noise, *shape)
    return replace(model, posterior=longer)


def evidence_for(model: ChannelModel, samples: Samples, target: Array, noise: Array) -> Evidence:
    """What pseudo-observations `target` (K,) [dBm] of noise variance `noise` (K,) tell about the
    shadowing of each link."""
    shift = np.array([model.offset(n) if model.offsets else 0.0 for n in samples.names])
    residual = target - model.mean(samples.links) - shift[samples.receiver]
    return by_link(samples.links, residual, noise, model.deviation)


def condition_on(model: ChannelModel, evidence: Evidence, most_centres: int) -> ChannelModel:
    """The channel given evidence: exactly up to EXACT_LIMIT links, else by inducing links."""
    prior = replace(model, posterior=None)
    if not len(evidence) or model.shadowing == 0.0:
        return prior
    links, residual, noise = evidence.links, evidence.residual, evidence.noise
    if model.kernel is KernelName.PAPER_MIN:
        check_covariance(links, model.length, model.kernel)
    shape = (model.shadowing, model.length, model.kernel)
    if len(evidence) <= EXACT_LIMIT:
        exact = exact_posterior(links, residual, noise + _floor_noise(model), *shape)
        return replace(prior, posterior=exact)
    rows = choose_centres(links, model.length, model.kernel, most_centres)
    noise = np.maximum(noise, 1e-6)
    sparse = inducing_posterior(links[rows], links, residual, noise, *shape)
    return replace(prior, posterior=sparse)


def _floor_noise(model: ChannelModel) -> float:
    """A speck of noise that keeps the covariance regular when there is none."""
    return 0.0 if model.own_variance(True) > 0 else 1e-8
