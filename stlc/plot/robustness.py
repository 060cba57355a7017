"""Robustness of every requirement as bars."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from stlc.ir.nodes import Linear, Link, walk
from stlc.mission import Mission
from stlc.plan import RequirementValue
from stlc.plot.style import BAD, GOOD, SMALL
from stlc.verify.report import tidy
from stlc.verify.robustness import TOLERANCE, unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST = 16


def draw_robustness(axes: Axes, mission: Mission, given: Sequence[RequirementValue]) -> None:
    """A bar for each requirement, scaled within each unit; of many, those nearest to failing.

    What the tolerance doesn't tell from 0 is 0.
    """
    requirements = [_rounded(r) for r in given]
    units = {r.name: _unit(mission, r.name) for r in requirements}
    tops = _tops(requirements, units)
    shown = sorted(requirements, key=lambda r: _share(r, tops[units[r.name]]))[:MOST]
    for row, r in enumerate(shown):
        share = _share(r, tops[units[r.name]])
        fine = r.robustness is not None and r.robustness >= r.margin - TOLERANCE
        colour = GOOD if fine else BAD
        axes.barh(row, share, height=0.6, color=colour, alpha=0.85)
        if r.margin:
            mark = r.margin / tops[units[r.name]]
            axes.plot([mark, mark], [row - 0.4, row + 0.4], color="black", linewidth=1.2)
        edge = max(share, 0.0, r.margin / tops[units[r.name]])
        axes.annotate(_value(r, units[r.name]), (edge, row), (4, 0), va="center",
                      textcoords="offset points", fontsize=SMALL)  # fmt: skip
    remarks = ["bars scaled for each unit"] if len(tops) > 1 else []
    if len(shown) < len(requirements):
        remarks.append(f"{len(requirements) - len(shown)} larger ones left out")
    _frame(axes, [r.name for r in shown], "; ".join(remarks))


def _rounded(r: RequirementValue) -> RequirementValue:
    if r.robustness is None or abs(r.robustness) > TOLERANCE:
        return r
    return replace(r, robustness=0.0)


def _frame(axes: Axes, names: Sequence[str], remark: str) -> None:
    """Axes around the bars: names as ticks, room on the right for the values, no frame."""
    axes.axvline(0.0, color="black", linewidth=1.0)
    low = min([0.0, *(bar.get_width() for bar in axes.patches)])  # type: ignore[attr-defined]
    axes.set_xlim(1.1 * low, 1.45)
    axes.set_yticks(range(len(names)), [_short(name) for name in names])
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xticks([])
    axes.grid(False)
    axes.spines["bottom"].set_visible(False)
    axes.spines["left"].set_visible(False)
    axes.tick_params(left=False)
    axes.set_title("Robustness")
    axes.set_xlabel(remark, fontsize=SMALL, color="#606060")


def _short(name: str) -> str:
    return name if len(name) <= 18 else name[:17] + "\N{HORIZONTAL ELLIPSIS}"


def _value(r: RequirementValue, unit_name: str) -> str:
    if r.robustness is None:
        return "can't be judged"
    return f"{tidy(r.robustness, 3)} {unit_name}".rstrip()


def _unit(mission: Mission, name: str) -> str:
    """The unit of a requirement whose predicates share one, else none."""
    nodes = (n for r in mission.requirements if r.name == name for n in walk(r.formula))
    units = {unit(n) for n in nodes if isinstance(n, Linear | Link)}
    return units.pop() if len(units) == 1 else ""


def _tops(requirements: Sequence[RequirementValue], units: dict[str, str]) -> dict[str, float]:
    tops: dict[str, float] = {}
    for r in requirements:
        size = abs(r.robustness or 0.0)
        size = max(size if math.isfinite(size) else 0.0, abs(r.margin))
        tops[units[r.name]] = max(tops.get(units[r.name], TOLERANCE), size)
    return tops


def _share(r: RequirementValue, top: float) -> float:
    if r.robustness is None:
        return -1.0
    return min(max(r.robustness / top, -1.0), 1.0)
