"""Pictures of plans, drawn with matplotlib (imported when a picture is asked for)."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from stlc.errors import UsageError
from stlc.files import atomic_output

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stlc.mission import Mission
    from stlc.plan import Plan

FORMATS = ("png", "svg", "pdf", "gif")

__all__ = ["FORMATS", "plan_figure", "plot_plan"]


def plan_figure(mission: Mission, plan: Plan) -> Figure:
    """One figure of a plan. Raises UsageError when the plan doesn't fit the mission."""
    from stlc.plot.figure import build

    return build(mission, plan)


def plot_plan(mission: Mission, plan: Plan, path: str | os.PathLike[str], dpi: int = 130) -> None:
    """Draw a plan into a PNG, SVG or PDF file, or play its map in a GIF, by the file's ending.

    Raises UsageError for another ending or a plan that doesn't fit the mission, OutputError when
    the file can't be written.
    """
    kind = Path(path).suffix.lower().lstrip(".")
    if kind not in FORMATS:
        known = ", ".join(f".{name}" for name in FORMATS)
        raise UsageError(f"cannot draw {os.fspath(path)}: the name must end in one of {known}")
    if kind == "gif":
        from stlc.plot.animation import write_animation

        with atomic_output(path) as stream:
            write_animation(mission, plan, stream)
        return
    figure = plan_figure(mission, plan)
    import matplotlib

    from stlc.plot.style import RC

    # Without a date the same plan gives the same bytes.
    metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind)
    with matplotlib.rc_context(RC), atomic_output(path) as stream:
        figure.savefig(stream, format=kind, dpi=dpi, metadata=metadata)
