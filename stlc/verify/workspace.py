"""The workspace: at the steps, and between them where the mission promises that."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from stlc.ir.nodes import Role
from stlc.mission import Mission
from stlc.places import Polytope
from stlc.verify.continuous import Extremum, behind, inside
from stlc.verify.paths import Path
from stlc.verify.report import Violation
from stlc.verify.subject import TOLERANCE
from stlc.verify.tubes import spread_of


def workspace_violations(
    mission: Mission, motion: Mapping[str, Path], past: int = 0
) -> Iterator[Violation]:
    """Each agent that leaves the workspace after step `past`, where it is farthest out."""
    for name, step, out in _excursions(mission, motion, mission.workspace_swept, past):
        place = ", ".join(f"{c:.6g}" for c in motion[name].at(np.array([step]))[0])
        when = f"step {step:g}" if step == int(step) else f"{step * mission.step:.4g} s"
        text = f"{name} at {when}: ({place}) lies {out:.3g} m outside the workspace"
        yield Violation("workspace", text, out, step, name, mission.agents[name].span)


def workspace_notes(mission: Mission, motion: Mapping[str, Path], past: int = 0) -> Iterator[str]:
    """What the workspace promises, and what happens between samples where it promises nothing."""
    if mission.workspace is None:
        return
    if mission.workspace_swept:
        yield "the workspace holds between samples too"
        return
    yield "the workspace holds at the steps; `workspace .. swept` makes it hold between them"
    for name, step, out in _excursions(mission, motion, swept=True, past=past):
        time = step * mission.step
        yield f"between samples {name} leaves the workspace by {out:.4g} m, at {time:.4g} s"


def _excursions(
    mission: Mission, motion: Mapping[str, Path], swept: bool, past: int
) -> Iterator[tuple[str, float, float]]:
    """(agent, fractional step, metres) where an agent is farthest out of the workspace.

    Of steps that were carried out nothing is asked, nor of the state that was measured last.
    """
    ahead = past if swept or not past else past + 1
    space = mission.workspace
    if space is None or ahead > mission.horizon:
        return
    for name in mission.agents:
        if name in motion:
            path = motion[name]
            found = (
                _between(path, mission, name)
                if swept
                else (_at_steps(path.plane, space, mission, name, past))
            )
            row = ahead + int(found.value[ahead:].argmin())
            out = -float(found.value[row])
            if not out <= TOLERANCE:
                yield name, row + float(found.where[row]), out


def _between(path: Path, mission: Mission, name: str) -> Extremum:
    """Distance to the nearest face [m] on the way from each step, floor and ceiling among them."""
    assert mission.workspace is not None
    found, levels = inside(path.plane, mission.workspace), mission.workspace_levels
    if levels is None or mission.agents[name].dynamics.altitude is None:
        return found
    ends = np.array([levels[1], -levels[0]])
    tall = behind(path, np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]), ends)
    lower = tall.value < found.value
    return Extremum(
        np.where(lower, tall.value, found.value), np.where(lower, tall.where, found.where)
    )


def _at_steps(path: Path, space: Polytope, mission: Mission, name: str, past: int) -> Extremum:
    """Distance to the nearest face [m] at each step, the agent wherever in its tube it is."""
    beyond = path.c0[:: path.pieces] @ space.normals.T - space.offsets
    width = spread_of(mission, past).get((name, Role.STATE))
    position = mission.agents[name].dynamics.position
    if mission.agents[name].robot is not None:
        assert width is not None
        beyond += width[:, :1] * np.linalg.norm(space.normals, axis=1)
    elif width is not None and position is not None:
        beyond += width @ np.abs(space.normals @ position).T
    return Extremum(-beyond.max(axis=1), np.zeros(len(beyond)))
