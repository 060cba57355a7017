"""The objective over two parameters, one cell for each combination."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from stlc.plot.style import BAD, BUFFER, SMALL
from stlc.sweep.ask import Answer
from stlc.sweep.axes import Axis, Point
from stlc.sweep.work import Found

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_WRITTEN = 144  # cells: more have no room for their numbers
_DARK = 0.55  # of the colour scale: below it numbers are white

Results = Sequence[tuple[Point, Found]]


def varied(axes: Sequence[Axis]) -> tuple[Axis, Axis] | None:
    """The two parameters that vary, if two do."""
    several = [axis for axis in axes if len(axis.values) > 1]
    return (several[0], several[1]) if len(several) == 2 else None


def draw_map(ax: Axes, first: Axis, second: Axis, found: Results) -> None:
    """The objective, the first parameter along the x axis, its values evenly spaced.

    Cells without a plan are grey, crossed where that is proven; a number behind ~ is the best plan
    found, not proven best.
    """
    values = np.full((len(second.values), len(first.values)), np.nan)
    for point, answer in found:
        if isinstance(answer, Answer):
            i, j = _cell(first, second, point)
            values[j, i] = np.nan if answer.objective is None else answer.objective
    ax.set_facecolor(BUFFER)
    image = ax.imshow(
        np.ma.masked_invalid(values), origin="lower", cmap="cividis", aspect="auto",
        interpolation="nearest",
    )  # fmt: skip
    bar = ax.figure.colorbar(image, ax=ax, pad=0.02)
    bar.set_label("objective")
    bar.outline.set_visible(False)
    for point, answer in found:
        if isinstance(answer, Answer):
            _write(ax, _cell(first, second, point), answer, image.norm, values.size)
    ax.set_xticks(range(len(first.values)), first.values)
    ax.set_yticks(range(len(second.values)), second.values)
    ax.set(xlabel=first.name, ylabel=second.name)
    ax.set_title(_key(found), loc="right", fontsize=SMALL, fontweight="normal")
    ax.tick_params(length=0)
    ax.grid(False)
    for spine in ax.spines.values():
        spine.set_visible(False)


def _cell(first: Axis, second: Axis, point: Point) -> tuple[int, int]:
    """Column and row of a point."""
    at: Mapping[str, str] = dict(point)
    return first.values.index(at[first.name]), second.values.index(at[second.name])


def _key(found: Results) -> str:
    """What the signs that stand in the map mean."""
    known = {answer.status for _, answer in found if isinstance(answer, Answer)}
    signs = (("infeasible", "× no plan exists"), ("feasible", "~ not proven best"))
    words = [text for status, text in signs if status in known]
    if known - {"optimal", "feasible", "infeasible"}:
        words.append("? no plan found")
    return "    ".join(words)


def _write(ax: Axes, at: tuple[int, int], answer: Answer, norm: object, cells: int) -> None:
    """The number of a cell, or why it has none."""
    if answer.objective is None:
        word, colour = ("×", BAD) if answer.status == "infeasible" else ("?", "black")
        ax.text(*at, word, ha="center", va="center", color=colour, fontsize=SMALL + 2)
    elif cells <= _WRITTEN:
        assert callable(norm)
        shade = float(norm(answer.objective))
        sign = "" if answer.status == "optimal" else "~"
        ax.text(*at, f"{sign}{answer.objective:.3g}", ha="center", va="center", fontsize=SMALL,
                color="white" if shade < _DARK else "black")  # fmt: skip
