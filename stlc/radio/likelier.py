"""Whether samples are likelier by other parameters: fits that more measurements call for."""

from __future__ import annotations

import numpy as np

from stlc.radio.errors import RadioError
from stlc.radio.fit import FitOptions, fit_channel
from stlc.radio.gp import ChannelModel
from stlc.radio.learned import Parameters
from stlc.radio.posterior import cholesky
from stlc.radio.samples import Samples, merge

ENOUGH = 30
"""New samples from which on a fit is tried: half of them give an exponent within 0.3 and variances
within a factor of two (drawn from the paper's channel)."""

SHARE = 0.1
"""And at least this share of those of the file, which they have to outweigh somewhere."""

SPECK = 1e-6
"""Fading [dB^2] that samples have at least; readings are rounded far more coarsely."""


def log_likelihood(model: ChannelModel, samples: Samples) -> float:
    """Of uncensored samples by a model's parameters, whatever it has been conditioned on."""
    merged = merge(samples)
    rows, fading = merged.samples, max(model.fading, SPECK)
    covariance = model.covariance(rows.links) + np.diag(fading / merged.count)
    covariance += model.deviation * (merged.link[:, None] == merged.link[None, :])
    lower = cholesky(covariance, "the covariance of the samples")
    white = np.linalg.solve(lower, rows.rssi - model.mean(rows.links))
    spare = merged.count - 1.0  # what the samples of a link tell by what they differ by
    within = spare * np.log(2.0 * np.pi * fading) + np.log(merged.count) + merged.scatter / fading
    whole = len(rows) * np.log(2.0 * np.pi) + 2.0 * float(np.log(np.diag(lower)).sum())
    return -0.5 * float(whole + white @ white + within.sum())


def fitted_anew(
    model: ChannelModel, given: Samples | None, fresh: Samples, everything: Samples
) -> Parameters | None:
    """The parameters fitted to `everything`, where they are worth it; None where the model's stay.

    They are tried from ENOUGH `fresh` samples on, and a SHARE of those `given` before, and taken
    where everything is likelier by more than one (in log) for each parameter (Akaike, 1974).
    Channels with calibration offsets or censored samples keep theirs.
    """
    if len(fresh) < max(ENOUGH, SHARE * (0 if given is None else len(given))):
        return None
    if model.offsets or everything.censored.any():
        return None
    options = FitOptions(d0=model.d0, kernel=model.kernel, walls=model.walls)
    try:
        found = Parameters.of(fit_channel(everything, options).model)
    except RadioError:  # samples that leave the channel open
        return None
    free = 6 + len(found.losses)
    gain = log_likelihood(found.prior(model), everything) - log_likelihood(model, everything)
    return found if gain > free else None
