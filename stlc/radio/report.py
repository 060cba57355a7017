"""What `stlc fit` prints."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from stlc.radio.errors import FitError
from stlc.radio.evaluate import (
    ApproximationError,
    HoldOut,
    approximation_error,
    hold_out,
    split_samples,
)
from stlc.radio.fit import FitOptions, FitReport, fit_channel, fit_directed
from stlc.radio.nearest import NearestForecast
from stlc.radio.read import SampleOptions, read_samples
from stlc.radio.samples import Samples

VAGUE = 5.0
"""Standard error of a logarithm from which on the samples don't determine a parameter."""


@dataclass(frozen=True, slots=True, eq=False)
class FitSummary:
    """A fit of all samples, and how a fit without the held-back ones forecasts them.

    fit          of all samples (or of the training file when `test` is another file)
    channel      forecast by the Gaussian process; path_loss: by path loss alone
    approximate  (name, error) of each approximate conditioning against exact; () when exact
    directed     a likelier fit that tells senders from receivers, where there is one, of the
                 samples that `channel` was fitted to, and its forecast
    without_walls  where losses of walls were fitted: the forecast of a fit without any
    """

    fit: FitReport
    samples: Samples
    tested: Samples
    channel: HoldOut
    path_loss: HoldOut
    approximate: tuple[tuple[str, ApproximationError], ...]
    directed: tuple[FitReport, HoldOut] | None = None
    without_walls: HoldOut | None = None

    def as_dict(self) -> dict[str, Any]:
        """The report as JSON data, units as in `format_summary`; vague errors are null."""
        fit, model = self.fit, self.fit.model
        errors = {k: v if v < VAGUE or k == "l0" else None for k, v in fit.standard_errors}
        names = ("l0", "exponent", "fading", "deviation", "shadowing", "length", "d0")
        return {
            "channel": {name: getattr(model, name) for name in names},
            "kernel": model.kernel.value,
            "walls": {}
            if model.walls is None
            else dict(zip(model.walls.names, map(float, model.walls.loss), strict=True)),
            "offsets": dict(model.offsets),
            "offset_variances": dict(model.offset_variances),
            "standard_errors": errors,
            "log_likelihood": fit.log_likelihood,
            "log_likelihood_path_loss": fit.log_likelihood_path_loss,
            "samples": fit.samples,
            "links": fit.links,
            "censored": fit.censored,
            "method": fit.method,
            "seconds": fit.seconds,
            "held_back": {
                "samples": self.channel.samples,
                "channel": _score_dict(self.channel),
                "path_loss": _score_dict(self.path_loss),
                "without_walls": self.without_walls and _score_dict(self.without_walls),
                "directed": self.directed and _score_dict(self.directed[1]),
            },
            "approximation": {
                name: {"mean_db": gap.mean, "sigma_db": gap.sigma, "links": gap.links}
                for name, gap in self.approximate
            },
            "notes": list(fit.notes),
        }


def _score_dict(score: HoldOut) -> dict[str, Any]:
    coverage = {f"{level:g}": share for level, share in score.coverage}
    return {
        "rmse_db": score.rmse,
        "bias_db": score.bias,
        "log_score": score.log_score,
        "coverage": coverage,
    }


def fit_csv(
    path: str | Path,
    options: FitOptions | None = None,
    reading: SampleOptions | None = None,
    test: Samples | None = None,
    share: float = 0.2,
) -> FitSummary:
    """Fit the samples of a CSV and score the forecast.

    test: held-back samples; None holds back `share` of the links, chosen by `options.seed`
    (the channel reported is still fitted to all of them).
    Raises DataError for a file that cannot be read, FitError for samples that fix no channel.
    """
    options = options or FitOptions()
    samples = read_samples(path, reading)
    fit = fit_channel(samples, options)
    if test is None:
        training, tested = split_samples(samples, share, options.seed)
        try:
            scored = fit_channel(training, options)
        except FitError as error:
            raise FitError(f"with {len(tested)} samples held back, {error}") from error
    else:
        training, tested, scored = samples, test, fit
    directed = fit_directed(training, scored, options)
    return FitSummary(
        fit=fit,
        samples=samples,
        tested=tested,
        channel=hold_out(scored.forecast, tested, options.seed),
        path_loss=hold_out(scored.path_loss, tested, options.seed),
        approximate=approximations(fit),
        without_walls=_bare(training, tested, options),
        directed=(
            None
            if directed is None
            else (directed, hold_out(directed.forecast, tested, options.seed))
        ),
    )


def _bare(training: Samples, tested: Samples, options: FitOptions) -> HoldOut | None:
    """The forecast of a fit without walls, where there are any to leave out."""
    if options.walls is None:
        return None
    fit = fit_channel(training, replace(options, walls=None))
    return hold_out(fit.forecast, tested, options.seed)


def approximations(fit: FitReport) -> tuple[tuple[str, ApproximationError], ...]:
    """Errors of the two ways to condition on a large set; () when conditioning is exact."""
    forecast = fit.forecast
    if not isinstance(forecast, NearestForecast):
        return ()
    ways = ("nearest links", forecast), ("inducing links", fit.model)
    return tuple(
        (name, approximation_error(way, forecast.prior, fit.evidence)) for name, way in ways
    )


def format_summary(summary: FitSummary) -> str:
    """The report as plain text."""
    fit, model = summary.fit, summary.fit.model
    error = dict(fit.standard_errors)
    censored = f" ({fit.censored} censored)" if fit.censored else ""
    lines = [
        f"samples       {fit.samples} on {fit.links} links{censored}",
        f"method        {fit.method}, {fit.seconds:.1f} s",
        f"L0            {model.l0:8.2f} dBm   +- {error['l0']:.2f}",
        f"n             {model.exponent:8.2f}       +- {error['exponent']:.2f}",
        _variance_line("fading", model.fading, error["log_fading"], "dB^2"),
        *_deviation_line(fit),
        _variance_line("shadowing", model.shadowing, error["log_shadowing"], "dB^2"),
        _variance_line("length", model.length, error["log_length"], "m"),
        f"log likelihood {fit.log_likelihood:.1f}; path loss alone "
        f"{fit.log_likelihood_path_loss:.1f}",
        f"held back     {summary.channel.samples} samples; one packet, fading included:",
        _score_line("channel", summary.channel),
        _score_line("path loss alone", summary.path_loss),
    ]
    lines += _wall_lines(summary)
    lines += _directed_lines(summary)
    lines += [
        f"{name} against exact conditioning: mean {gap.mean:.2f} dB, "
        f"sigma {gap.sigma:.2f} dB rms on {gap.links} links"
        for name, gap in summary.approximate
    ]
    lines += [
        f"offset        {name}: {value:+.2f} dB +- {np.sqrt(model.offset_variance(name)):.2f}"
        for name, value in model.offsets
    ]
    lines += [f"note: {note}" for note in fit.notes]
    return "\n".join(lines)


def _wall_lines(summary: FitSummary) -> list[str]:
    """The losses of walls, and whether knowing them helps to forecast what was held back."""
    walls, plain = summary.fit.model.walls, summary.without_walls
    if walls is None or plain is None:
        return []
    error = dict(summary.fit.standard_errors)
    gain = plain.rmse - summary.channel.rmse
    said = f"help by {gain:.2f} dB" if gain > 0 else "don't help"
    return [
        _score_line("without walls", plain),
        f"  walls {said} of RMSE on samples held back",
        *(
            f"wall          {name}: {loss:.2f} dB +- {error.get(f'wall {name}', 0.0):.2f}"
            for name, loss in zip(walls.names, walls.loss, strict=True)
        ),
    ]


def _directed_lines(summary: FitSummary) -> list[str]:
    """The forecast that tells senders from receivers, where that is likelier."""
    if summary.directed is None:
        return []
    fit, score = summary.directed
    return [
        _score_line("ends told apart", score),
        f"  (kernel {fit.model.kernel.value}; a mission keeps the symmetric one, which links of "
        "agents need and bounds over cells are of)",
    ]


def _deviation_line(fit: FitReport) -> list[str]:
    """The links' own deviations, where repeats tell them from fading."""
    error = dict(fit.standard_errors).get("log_deviation")
    if error is None:
        return ["deviation     in fading: no link was measured twice"]
    return [_variance_line("deviation", fit.model.deviation, error, "dB^2")]


def _variance_line(name: str, value: float, log_error: float, unit: str) -> str:
    spread = f"x/ {np.exp(log_error):.2f}" if log_error < VAGUE else "(undetermined)"
    return f"{name:<13} {value:8.2f} {unit:<5} {spread}"


def _score_line(name: str, score: HoldOut) -> str:
    shares = ", ".join(f"{100 * p:.0f} %: {100 * s:.1f} %" for p, s in score.coverage)
    return (
        f"  {name:<16} RMSE {score.rmse:.2f} dB, bias {score.bias:+.2f} dB, "
        f"intervals {shares}, log score {score.log_score:.3f}"
    )
