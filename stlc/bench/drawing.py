"""Curves as inline SVG: profiles, cactus plots, growth, gaps over time. matplotlib draws."""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from stlc.backends.base import relative_gap
from stlc.bench.growth import Growth
from stlc.bench.measures import Curve
from stlc.plot.style import RC, Look

Styles = Mapping[str, Look]
_SIZE = (5.6, 3.5)  # inches
_LEAST_GAP, _MOST_GAP = 1e-5, 10.0  # an incumbent near 0 has any gap: beyond 1,000 % is one thing


def profile_svg(curves: Mapping[str, Curve], styles: Styles) -> str:
    """Performance profile: fraction solved (y) within a factor of the best (x)."""
    fig, ax = _axes("times the best time", "fraction of problems solved")
    top = max([f for xs, _ in curves.values() for f in xs] + [2.0]) * 1.5
    for label, (xs, ys) in curves.items():
        steps = ([1.0, *xs, top], [0.0, *ys, ys[-1] if ys else 0.0])
        ax.step(*steps, where="post", color=styles[label].colour, label=label, linewidth=1.8)
    ax.set_xscale("log")
    ax.set_xlim(1.0, top)
    ax.set_ylim(0.0, 1.04)
    return _finish(fig, ax)


def cactus_svg(curves: Mapping[str, Curve], styles: Styles, limit: float) -> str:
    """Cactus plot: seconds (y) within which so many problems (x) are solved."""
    fig, ax = _axes("problems solved", "solver time [s]")
    for label, (xs, ys) in curves.items():
        look = styles[label]
        ax.plot(xs, ys, marker=look.marker, markersize=4.5, color=look.colour, label=label)
    ax.axhline(limit, color="#9A9A9A", linestyle=":", linewidth=1.0)
    ax.annotate("time limit", (0.01, limit), xycoords=("axes fraction", "data"),
                va="bottom", color="#707070", fontsize=8)  # fmt: skip
    ax.set_yscale("log")
    ax.set_xlim(left=0.5)
    ax.xaxis.get_major_locator().set_params(integer=True)
    return _finish(fig, ax)


def growth_svg(curves: Sequence[Growth], styles: Styles, size: str, quantity: str) -> str:
    """A quantity over a size, both logarithmic, with fitted powers dashed."""
    fig, ax = _axes(size, quantity)
    for curve in curves:
        look = styles[curve.label]
        ax.plot(curve.sizes, curve.values, look.marker, color=look.colour, label=_legend(curve))
        if curve.exponent is not None:
            ends = [curve.sizes[0], curve.sizes[-1]]
            fitted = [curve.factor * x**curve.exponent for x in ends]
            ax.plot(ends, fitted, "--", color=look.colour, linewidth=1.2)
    ax.set_xscale("log")
    ax.set_yscale("log")
    _plain_ticks(ax, sorted({x for curve in curves for x in curve.sizes}))
    return _finish(fig, ax)


def gap_svg(curves: Mapping[str, Curve], styles: Styles) -> str:
    """Relative gap (y) over seconds of the solver (x)."""
    fig, ax = _axes("solver time [s]", "relative gap")
    for label, (xs, ys) in curves.items():
        ax.step(xs, ys, where="post", color=styles[label].colour, label=label, linewidth=1.6)
    ax.set_yscale("log")
    ax.set_xlim(left=0.0)
    return _finish(fig, ax)


def _legend(curve: Growth) -> str:
    missing = f", {curve.missing} without" if curve.missing else ""
    if curve.exponent is None:
        return f"{curve.label}{missing}"
    return f"{curve.label}: exponent {curve.exponent:.2f} (R² {curve.quality:.2f}{missing})"


def _axes(x: str, y: str) -> tuple[Any, Any]:
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(RC):
        fig = Figure(figsize=_SIZE, layout="constrained")
        ax = fig.subplots()
        ax.set_xlabel(x)
        ax.set_ylabel(y)
    return fig, ax


def _plain_ticks(ax: Any, values: Sequence[float]) -> None:
    from matplotlib.ticker import FixedLocator, NullLocator, StrMethodFormatter

    ax.xaxis.set_major_locator(FixedLocator(list(values)))
    ax.xaxis.set_minor_locator(NullLocator())
    ax.xaxis.set_major_formatter(StrMethodFormatter("{x:g}"))


def _plain_numbers(axis: Any) -> None:
    """0.6 instead of 6e-01 on a logarithmic axis; matplotlib decides which ticks are named."""
    from matplotlib.ticker import LogFormatter, LogLocator

    class Plain(LogFormatter):
        def __call__(self, x: float, pos: int | None = None) -> str:
            return f"{x:g}" if super().__call__(x, pos) else ""

    if isinstance(axis.get_major_locator(), LogLocator):
        axis.set_major_formatter(Plain())
        axis.set_minor_formatter(Plain(minor_thresholds=(1.5, 0.5)))


def _finish(fig: Any, ax: Any) -> str:
    """The figure as SVG for inlining, without a date, so that equal data give equal text."""
    import matplotlib as mpl

    for axis in (ax.xaxis, ax.yaxis):
        _plain_numbers(axis)
    if ax.get_legend_handles_labels()[1]:
        ax.legend(loc="best")
    out = io.StringIO()
    with mpl.rc_context(RC):
        fig.savefig(out, format="svg", transparent=True, metadata={"Date": None})
    return _inline(out.getvalue())


def _inline(svg: str) -> str:
    """The `<svg>` element alone, scaled by the page; no metadata with foreign addresses."""
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg[svg.index("<svg") :], flags=re.DOTALL)
    head, rest = svg.split(">", 1)
    return re.sub(r'\b(width|height)="[^"]*"', "", head) + ">" + rest


def finite_gaps(points: Sequence[tuple[float | None, ...]]) -> Curve:
    """Seconds and gaps of a trace, where both incumbent and bound are known, within 1e-5 and 10."""
    xs, ys = [], []
    for seconds, objective, bound, *_ in points:
        gap = relative_gap(objective, bound)
        if seconds is not None and gap is not None and math.isfinite(gap):
            xs.append(seconds)
            ys.append(min(max(gap, _LEAST_GAP), _MOST_GAP))
    return xs, ys
