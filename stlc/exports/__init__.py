"""Plans for other programs: GeoJSON for maps, MCAP for viewers, ROS bags, timed waypoints."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

from stlc.errors import UsageError

if TYPE_CHECKING:
    from stlc.mission import Mission
    from stlc.plan import Plan

FORMATS = (".geojson", ".mcap", ".rosbag", ".csv")

__all__ = ["FORMATS", "export"]


def export(
    mission: Mission, plan: Plan, path: str | os.PathLike[str], every: float | None = None
) -> None:
    """Write a plan by the ending of `path`; `every` [s] is the time between samples, else a step.

    Raises UsageError for another ending, a plan that doesn't fit the mission, agents without a
    position, or where the `mcap` or `rosbags` package is missing; OutputError when the file can't
    be written.
    """
    from stlc.exports.geojson import write_geojson
    from stlc.exports.mcap import write_mcap
    from stlc.exports.rosbag import write_rosbag
    from stlc.exports.waypoints import write_waypoints
    from stlc.verify.subject import check_shape

    kind = Path(path).suffix.lower()
    if kind not in FORMATS:
        known = ", ".join(FORMATS)
        raise UsageError(f"cannot write {os.fspath(path)}: the name must end in one of {known}")
    check_shape(mission, plan)
    writers = {".geojson": write_geojson, ".mcap": write_mcap, ".rosbag": write_rosbag,
               ".csv": write_waypoints}  # fmt: skip
    writers[kind](mission, plan, path, every)
