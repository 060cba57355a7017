"""Timed waypoints as CSV: agent, time, place, velocity."""

from __future__ import annotations

import csv
import io
import os

from stlc.exports.track import tracks
from stlc.files import write_atomic
from stlc.mission import Mission
from stlc.plan import Plan

_AXES = "xyz"


def write_waypoints(
    mission: Mission, plan: Plan, path: str | os.PathLike[str], every: float | None
) -> None:
    """A row for each agent and time, agent by agent: `agent,time,x,y[,z],vx,vy[,vz]` in SI units.

    The heights are left out where nobody flies.
    """
    found = tracks(mission, plan, every)
    axes = _AXES[: 3 if mission.aerial else 2]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(["agent", "time", *axes, *(f"v{axis}" for axis in axes)])
    for name, places in found.places.items():
        speeds = found.speeds(name, plan.step)
        for time, place, speed in zip(found.times, places, speeds, strict=True):
            writer.writerow([name, *(repr(float(v)) for v in (time, *place, *speed))])
    write_atomic(path, stream.getvalue())
