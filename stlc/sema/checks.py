"""Checks of the whole mission: places, starts, names nobody uses."""

from __future__ import annotations

from dataclasses import replace

from stlc.mission import Mission
from stlc.sema.scope import Scope


def checked(mission: Mission, scope: Scope) -> Mission:
    """The mission with its warnings."""
    return replace(mission, warnings=scope.report.warnings)
