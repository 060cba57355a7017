"""The workspace: its shape, and whether it holds between the steps too."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from stlc.ir.nodes import walk
from stlc.ir.requirement import Requirement
from stlc.sema.report import Mistake
from stlc.sema.scope import Scope
from stlc.sema.shape_errors import NotConvex
from stlc.sema.shapes import Shaper
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
                moves = known_curve(agent, scope, statement.span)
                states = np.flatnonzero(agent.dynamics.axes.any(axis=0)).tolist()
                known_degree(moves, agent, states, statement.span)
    return found
