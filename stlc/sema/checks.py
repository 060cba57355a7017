"""Checks of the whole mission: places, starts, empty requirements, names that nobody uses."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from stlc.arrays import Floats
from stlc.ir.requirement import Requirement
from stlc.mission import Agent, Mission
from stlc.places import Obstacle, Polytope
from stlc.sema import geometry
from stlc.sema.gaps import narrow_gaps
from stlc.sema.heights import EVERY, kept_from
from stlc.sema.objective_errors import NeverTrue
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import OutsideWorkspace, StartInObstacle, StartMisplaced
from stlc.sema.static_range import StaticRange, boxes
from stlc.sema.values import Place, Radio
from stlc.sema.warnings import (
    AlwaysTrue,
    NeverFromStart,
    NoRequirement,
    PartlyOutside,
    UnusedName,
    UnusedObstacle,
)
from stlc.syntax import ast

TOLERANCE = 1e-6


def checked(mission: Mission, scope: Scope) -> Mission:
    """The mission with its warnings; mistakes go to the scope's report."""
    _places(mission, scope)
    for warning in narrow_gaps(mission):
        scope.report.add(warning)
    for agent in mission.agents.values():
        _start(agent, mission, scope)
    _requirements(mission, scope)
    _unused(mission, scope)
    return replace(mission, warnings=scope.report.warnings)


# --- places ------------------------------------------------------------------------------------


def _places(mission: Mission, scope: Scope) -> None:
    """Warns of regions outside the workspace, and of obstacles that are nowhere in it."""
    space = mission.workspace
    if space is None:
        return
    for region in mission.regions.values():
        how = _position(region.pieces, space)
        if how == "wholly":
            scope.report.add(OutsideWorkspace(span=region.span, what="region", name=region.name))
        elif how == "partly":
            scope.report.add(
                PartlyOutside(span=region.span, what="region", name=region.name, how=how)
            )
    for obstacle in mission.obstacles.values():
        pieces = tuple(p for frame in obstacle.frames for p in frame)
        if _position(pieces, space) == "wholly":
            what, name = "obstacle", obstacle.name
            scope.report.add(PartlyOutside(span=obstacle.span, what=what, name=name, how="wholly"))


def _position(pieces: tuple[Polytope, ...], space: Polytope) -> str:
    if all(geometry.disjoint(p, space) for p in pieces):
        return "wholly"
    return "within" if all(geometry.within(p, space) for p in pieces) else "partly"


# --- starts --------------------------------------------------------------------------------------


def _start(agent: Agent, mission: Mission, scope: Scope) -> None:
    problem = _misplaced(agent, mission.workspace)
    if problem:
        span = scope.starts[agent.name]
        scope.report.add(StartMisplaced(span=span, name=agent.name, problem=problem))


def _misplaced(agent: Agent, space: Polytope | None) -> str:
    """In words, why the agent can't start where it does; nothing if it can."""
    rows = agent.dynamics.position
    if space is not None and rows is not None:
        place = rows @ agent.start
        if not geometry.contains(space, place, -TOLERANCE):
            return f"outside the workspace, at ({place[0]:g}, {place[1]:g})"
        if problem := _cramped(agent, space, place):
            return problem
    for k, name in enumerate(agent.dynamics.states):
        low, high = agent.state_lower[k], agent.state_upper[k]
        if not low - TOLERANCE <= agent.start[k] <= high + TOLERANCE:
            return f"outside its bounds: {name} = {agent.start[k]:g} is not in [{low:g}, {high:g}]"
    for bound in agent.state_norms:
        size = float(np.linalg.norm(agent.start[list(bound.indices)]))
        if size > bound.limit + TOLERANCE:
            of = ", ".join(agent.dynamics.states[k] for k in bound.indices)
            return f"outside its bounds: the norm of ({of}) is {size:g}, above {bound.limit:g}"
    return ""


def _cramped(agent: Agent, space: Polytope, place: Floats) -> str:
    """In words, that the tube of a robot doesn't fit into the workspace where it starts."""
    if agent.robot is None:
        return ""
    room = float((space.offsets - space.normals @ place).min())
    if room >= agent.robot.radius - TOLERANCE:
        return ""
    return (
        f"too near to the workspace's border: its look-ahead point, at ({place[0]:g}, "
        f"{place[1]:g}), needs {agent.robot.radius:.4g} m around it and has {max(room, 0.0):.4g} m"
    )


def _avoided(scope: Scope) -> Iterator[tuple[Agent, Obstacle]]:
    """Pairs of an agent and an obstacle that some formula keeps it out of."""
    by_id = {id(o): o for o in scope.obstacles.values()}
    for key in scope.memo:
        if isinstance(key, tuple) and key[0] == "member" and key[3] == "outside":
            subject, obstacle = key[1], by_id.get(key[2])
            if isinstance(subject, Radio) and isinstance(subject.thing, Agent) and obstacle:
                yield subject.thing, obstacle


def _inside(agent: Agent, obstacle: Obstacle) -> bool:
    rows = agent.dynamics.position
    assert rows is not None, "only agents with a position are kept out of obstacles"
    place = np.asarray(rows @ agent.start)
    low, high = kept_from(Place(obstacle).heights or EVERY, agent)
    row = agent.dynamics.altitude
    if not low < (0.0 if row is None else float(row @ agent.start)) < high:
        return False
    return any(geometry.contains(piece, place, TOLERANCE) for piece in obstacle.barrier[0])


# --- requirements --------------------------------------------------------------------------------


def _requirements(mission: Mission, scope: Scope) -> None:
    """Warns of what no run satisfies, what every run does, and what the start rules out."""
    asked = mission.requirements or mission.preferences
    if not asked and not scope.report.errors:
        scope.report.add(NoRequirement(span=mission.source.span(0, 0)))
    known = boxes(mission.agents, mission.workspace)
    anywhere = StaticRange(known)
    starts = {n: a.start for n, a in mission.agents.items()}
    started = StaticRange(known, starts, anywhere.later)
    for item in mission.requirements:
        low, high = anywhere.of(item.formula, first=False)
        if high < item.margin - TOLERANCE:
            scope.report.add(_never(item, high))
        elif low >= item.margin:
            scope.report.add(_always(item, low))
        elif started.of(item.formula, first=True)[1] < item.margin - TOLERANCE:
            _from_start(item, started.of(item.formula, first=True)[1], scope)


def _never(item: Requirement, best: float) -> NeverTrue:
    return NeverTrue(span=item.span, name=item.name, best=best + 0.0, margin=item.margin)


def _always(item: Requirement, worst: float) -> AlwaysTrue:
    return AlwaysTrue(span=item.span, name=item.name, worst=worst + 0.0, margin=item.margin)


def _from_start(item: Requirement, best: float, scope: Scope) -> None:
    """Say why the start makes a requirement fail: an obstacle around it, or something else."""
    caught = [(a, o) for a, o in _avoided(scope) if _inside(a, o)]
    for agent, obstacle in caught:
        span, name = scope.starts[agent.name], agent.name
        scope.report.add(StartInObstacle(span=span, name=name, obstacle=obstacle.name))
    if not caught:
        scope.report.add(
            NeverFromStart(span=item.span, name=item.name, best=best, margin=item.margin)
        )


# --- names -------------------------------------------------------------------------------------


def _unused(mission: Mission, scope: Scope) -> None:
    """Names of the mission's own file that nothing uses; a library may hold more than is used."""
    for name, statement in scope.declarations.items():
        own = statement.span.source is mission.source
        if not own or name in scope.used or name in scope.broken:
            continue
        match statement:
            case ast.ObstacleDecl():
                scope.report.add(UnusedObstacle(span=statement.name.span, name=name))
            case ast.AgentDecl():
                continue
            case ast.SignalDecl():
                span = next(n.span for n in statement.names if n.text == name)
                scope.report.add(UnusedName(span=span, what="signal", name=name))
            case (
                ast.RegionDecl() | ast.Param() | ast.Let() | ast.DynamicsDecl()
                | ast.StationDecl() | ast.ChannelDecl()
            ):  # fmt: skip
                what = type(statement).__name__.removesuffix("Decl").lower()
                scope.report.add(UnusedName(span=statement.name.span, what=what, name=name))
