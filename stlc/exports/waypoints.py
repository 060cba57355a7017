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
    """A row for each agent and time, agent by agent: `agent,time,x,y[,z],vx,vy[,vz][,heading]` in
    SI units.

    The heights are left out where nobody flies, the headings [rad] where there is no robot; other
    agents have none.
    """
    found = tracks(mission, plan, every)
    axes = _AXES[: 3 if mission.aerial else 2]
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    last = ["heading"] if found.own else []
    writer.writerow(["agent", "time", *axes, *(f"v{axis}" for axis in axes), *last])
    for name, places in found.places.items():
        speeds = found.speeds(name, plan.step)
        headings = found.own.get(name)
        for k, time in enumerate(found.times):
            row = [name, *(repr(float(v)) for v in (time, *places[k], *speeds[k]))]
            row += [""] * len(last) if headings is None else [repr(float(headings[k]))]
            writer.writerow(row)
    write_atomic(path, stream.getvalue())
