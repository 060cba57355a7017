"""What `stlc fit` prints and draws."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stlc.files import atomic_output
from stlc.radio.errors import FitError
from stlc.radio.evaluate import (
    ApproximationError,
    HoldOut,
    approximation_error,
    hold_out,
    predict_samples,
    split_samples,
)
from stlc.radio.fit import FitOptions, FitReport, fit_channel
from stlc.radio.nearest import NearestForecast
from stlc.radio.pathloss import link_distance, split_links
from stlc.radio.read import SampleOptions, read_samples
from stlc.radio.samples import Samples

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


VAGUE = 5.0
"""Standard error of a logarithm from which on the samples don't determine a parameter."""


@dataclass(frozen=True, slots=True, eq=False)
class FitSummary:
    """A fit of all samples, and how a fit without the held-back ones forecasts them.

    fit          of all samples (or of the training file when `test` is another file)
    channel      forecast by the Gaussian process; path_loss: by path loss alone
    approximate  (name, error) of each approximate conditioning against exact; () when exact
    """

    fit: FitReport
    samples: Samples
    tested: Samples
    channel: HoldOut
    path_loss: HoldOut
    approximate: tuple[tuple[str, ApproximationError], ...]

    def as_dict(self) -> dict[str, Any]:
        """The report as JSON data, units as in `format_summary`; vague errors are null."""
        fit, model = self.fit, self.fit.model
        errors = {k: v if v < VAGUE or k == "l0" else None for k, v in fit.standard_errors}
        names = ("l0", "exponent", "fading", "deviation", "shadowing", "length", "d0")
        return {
            "channel": {name: getattr(model, name) for name in names},
            "kernel": model.kernel.value,
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
        tested, scored = test, fit
    return FitSummary(
        fit=fit,
        samples=samples,
        tested=tested,
        channel=hold_out(scored.forecast, tested, options.seed),
        path_loss=hold_out(scored.path_loss, tested, options.seed),
        approximate=approximations(fit),
    )


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


def plot_summary(summary: FitSummary, path: str | Path) -> None:
    """Map, residuals, variogram and calibration in one PNG. Raises OutputError."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 9.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2)
    _draw_map(axes[0, 0], summary)
    _draw_residuals(axes[0, 1], summary)
    _draw_variogram(axes[1, 0], summary)
    _draw_calibration(axes[1, 1], summary)
    with atomic_output(path) as file:
        figure.savefig(file, format="png", dpi=110)


def _draw_map(axes: Axes, summary: FitSummary) -> None:
    """Forecast towards the receiver most often heard, over the extent of the senders."""
    sender, receiver = split_links(summary.samples.links)
    ends, count = np.unique(receiver, axis=0, return_counts=True)
    end = ends[int(np.argmax(count))]
    low, high = sender[:, :2].min(0), sender[:, :2].max(0)
    x, y = np.linspace(low[0], high[0], 60), np.linspace(low[1], high[1], 60)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    depth = np.tile(np.median(sender[:, 2:], axis=0), (len(grid), 1))
    links = np.hstack([grid, depth, np.tile(end, (len(grid), 1))])
    mean, _ = summary.fit.forecast.predict(links, False)
    image = axes.pcolormesh(x, y, mean.reshape(60, 60).T, shading="auto")
    axes.figure.colorbar(image, ax=axes, label="RSSI [dBm]")
    axes.plot(*end[:2], "r^", label="receiver")
    axes.plot(*sender[:: max(1, len(sender) // 2000), :2].T, "k.", ms=1, label="samples")
    axes.set(title="posterior mean (fading averaged)", xlabel="x [m]", ylabel="y [m]")
    axes.legend(loc="upper right")


def _draw_residuals(axes: Axes, summary: FitSummary) -> None:
    """Measured less forecast over distance, by path loss alone and by the whole channel."""
    from matplotlib.ticker import LogFormatter

    tested = summary.tested.take(~summary.tested.censored)
    mean, _ = predict_samples(summary.fit.forecast, tested)
    alone, _ = predict_samples(summary.fit.path_loss, tested)
    distance = link_distance(tested.links)
    axes.semilogx(distance, tested.rssi - alone, ".", ms=2, label="path loss alone")
    axes.semilogx(distance, tested.rssi - mean, ".", ms=2, label="channel fitted to all")
    axes.axhline(0.0, color="k", lw=0.5)
    axes.set(title="residuals", xlabel="distance [m]", ylabel="measured - forecast [dB]")
    axes.xaxis.set_major_formatter(LogFormatter())
    axes.xaxis.set_minor_formatter(LogFormatter())
    axes.legend()


def empirical_variogram(
    summary: FitSummary, bins: int = 20, most: int = 1500
) -> tuple[Array, Array]:
    """Lags [m] and half mean squared differences [dB^2] of path-loss residuals between links.

    Uses at most `most` samples (evenly spaced), links up to three correlation lengths apart.
    """
    seen = summary.samples.take(~summary.samples.censored)
    seen = seen.take(np.unique(np.linspace(0, len(seen) - 1, most).astype(np.intp)))
    offset = dict(summary.fit.model.offsets)
    shift = np.array([offset.get(n, 0.0) for n in seen.names])
    residual = seen.rssi - shift[seen.receiver] - summary.fit.model.mean(seen.links)
    i, j = np.triu_indices(len(seen), 1)
    lag = np.linalg.norm(seen.links[i] - seen.links[j], axis=1)
    half = 0.5 * (residual[i] - residual[j]) ** 2
    edges = np.linspace(0.0, 3.0 * summary.fit.model.length, bins + 1)
    cell = np.digitize(lag, edges) - 1
    found = [b for b in range(bins) if (cell == b).any()]
    means = np.array([half[cell == b].mean() for b in found])
    return (edges[:-1] + edges[1:])[found] / 2.0, means


def _draw_variogram(axes: Axes, summary: FitSummary) -> None:
    """Half the mean squared difference of links over their distance, and the fitted curve."""
    lag, value = empirical_variogram(summary)
    model = summary.fit.model
    axes.plot(lag, value, "o", label="samples")
    x = np.linspace(0.0, 3.0 * model.length, 200)
    rise = model.shadowing * (1.0 - np.exp(-(x**2) / (2.0 * model.length**2)))
    axes.plot(x, model.own_variance(True) + rise, label="fitted")
    axes.set(
        title="variogram", xlabel="distance between links [m]", ylabel="[dB^2]", ylim=(0, None)
    )
    axes.legend()


def _draw_calibration(axes: Axes, summary: FitSummary) -> None:
    for name, score in (("channel", summary.channel), ("path loss alone", summary.path_loss)):
        inside = np.sort(2.0 * np.abs(score.pit - 0.5))
        axes.plot(inside, (np.arange(len(inside)) + 1.0) / len(inside), label=name)
    axes.plot([0, 1], [0, 1], "k:", lw=1)
    axes.set(title="calibration (held back)", xlabel="interval level", ylabel="share inside")
    axes.legend()
