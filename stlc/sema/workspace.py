"""The workspace: its shape, and whether it holds between the steps too."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from stlc.bezier import Curve
from stlc.ir.nodes import walk
from stlc.ir.requirement import Requirement
from stlc.mission import Agent
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import NotConvex
from stlc.sema.shapes import Shaper
from stlc.sema.space_errors import NotInSpace
from stlc.sema.swept import known_curve, known_degree
from stlc.syntax import ast

_WORKSPACE = re.compile(r"^[ \t]*workspace\b", re.M)


def declare_workspace(statement: ast.Workspace | None, text: str, shaper: Shaper) -> None:
    """Read the workspace into the scope; `text` is the file's, to tell that it is there at all."""
    scope = shaper.scope
    if statement is None:
        scope.unread_workspace = bool(scope.report.errors and _WORKSPACE.search(text))
        return
    scope.unread_workspace = True
    with scope.report.guard():
        pieces = shaper.pieces(statement.shape)
        if len(pieces) != 1:
            raise Mistake(NotConvex(span=statement.shape.span))
        scope.workspace, scope.unread_workspace = pieces[0], False
        scope.space_levels = shaper.heights(statement.shape)


def holds_between(
    statement: ast.Workspace | None, requirements: Iterable[Requirement], scope: Scope
) -> bool:
    """Whether the workspace holds between steps: as it says, else where anything is `swept`."""
    if statement is None or scope.workspace is None:
        return False
    if statement.times is None:
        found = any(n.swept is not None for r in requirements for n in walk(r.formula))
    else:
        found = statement.times == "swept"
    for agent in scope.agents.values() if found else ():
        position = agent.dynamics.position
        if position is not None:
            with scope.report.guard():
                states = [int(k) for k in np.flatnonzero(position.any(axis=0))]
                moves = known_curve(agent, scope, statement.span)
                known_degree(moves, agent, states, statement.span)
                _check_floor(agent, moves, statement, scope)
    return found


def _check_floor(agent: Agent, moves: Curve, statement: ast.Workspace, scope: Scope) -> None:
    """Floor and ceiling are bounds of states, which hold between the steps for straight motions."""
    row = agent.dynamics.altitude
    if scope.space_levels is None or row is None:
        return
    if known_degree(moves, agent, [int(np.argmax(row))], statement.span) > 1:
        problem = f"floor and ceiling hold for `{agent.name}` at the steps only"
        low, high = (f"{end:.10g} m" for end in scope.space_levels)
        within = f"always ({low} <= {agent.name}.z <= {high}) swept"
        hint = f"leave them out and ask for `{within}`, or say `sampled`"
        raise Mistake(NotInSpace(span=statement.shape.span, problem=problem, hint=hint))
