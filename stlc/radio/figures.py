"""What `stlc fit` draws."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stlc.files import atomic_output
from stlc.radio.evaluate import predict_samples
from stlc.radio.pathloss import link_distance, split_links
from stlc.radio.report import FitSummary

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


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
